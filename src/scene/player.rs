//! A clock for animations: converts elapsed seconds to ticks.

use crate::pose::OutOfRange;
use crate::scene::Animation;

/// The behaviour of a [`Player`] at the end of its animation.
///
/// [`Player`] has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum LoopMode {
    /// Stops at the end.
    Once,
    /// Starts again. The last frame and the first show the same phase, so one loop takes [`Animation::duration`] ticks.
    #[default]
    Loop,
    /// Plays backwards to the start, and then forwards again.
    PingPong,
}

/// The playback position of an animation.
///
/// A player is only a clock. It stores the length of its animation, but no reference to it. So one player can drive
/// many skeletons, and one animation can have many players, on any threads:
///
/// ```
/// use mocap::{Binding, Player, Pose, Scene};
///
/// fn play(dancers: &[Scene], clip: &mocap::scene::Animation, seconds_per_picture: f64) {
///     let bindings: Vec<_> = dancers.iter().map(|dancer| Binding::new(dancer, clip)).collect();
///     let mut poses: Vec<_> = dancers.iter().map(Pose::rest).collect();
///     let mut player = Player::new(clip);
///     player.speed = 0.5;
///     loop {
///         for (pose, binding) in poses.iter_mut().zip(&bindings) {
///             pose.sample(binding, clip, player.tick);
///             // draw the pose
///         }
///         player.advance(seconds_per_picture);
///         # break;
///     }
/// }
/// # play(&[Scene::default()], &Default::default(), 0.1);
/// ```
///
/// The timer of an introductory course, `tick = 0; while tick <= duration { update; tick += 1 }`, is a player that
/// plays once and advances by whole ticks:
///
/// ```
/// use mocap::scene::Animation;
/// use mocap::{LoopMode, Player};
///
/// let animation = Animation { ticks_per_second: 10.0, duration: 9.0, ..Animation::default() };
/// let mut shown = Vec::new();
///
/// let mut player = Player::new(&animation);
/// player.loop_mode = LoopMode::Once;
/// loop {
///     shown.push(player.tick); // scene.update_node_matrices(0, player.tick)
///     if player.is_finished() {
///         break;
///     }
///     player.advance_ticks(1.0);
/// }
/// assert_eq!(shown, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Player {
    /// The current tick. Set it to seek.
    pub tick: f64,
    /// The playback speed. Default: 1; negative plays backwards.
    pub speed: f64,
    /// The behaviour at the end of the animation.
    pub loop_mode: LoopMode,
    ticks_per_second: f64,
    duration: f64,
    /// Whether [`LoopMode::PingPong`] is playing backwards.
    returns: bool,
}

impl Player {
    /// A player at the start of `animation` that loops at its normal speed.
    pub fn new(animation: &Animation) -> Self {
        Self::of_length(animation.duration, animation.ticks_per_second)
    }

    /// A player for a motion that is not an [`Animation`], such as a packed clip (see its `player`). `duration` is the
    /// length in ticks. A length that is not above 0 becomes 0.
    pub fn of_length(duration: f64, ticks_per_second: f64) -> Self {
        Self {
            tick: 0.0,
            speed: 1.0,
            loop_mode: LoopMode::default(),
            ticks_per_second,
            // `max` also turns NaN into 0.
            duration: duration.max(0.0),
            returns: false,
        }
    }

    /// Advances by `seconds` times [`speed`](Self::speed), and returns the new tick.
    pub fn advance(&mut self, seconds: f64) -> f64 {
        self.advance_ticks(seconds * self.ticks_per_second)
    }

    /// Advances by `ticks` times [`speed`](Self::speed), and returns the new tick, from 0 to the duration. Ignores a
    /// step that is not finite.
    pub fn advance_ticks(&mut self, ticks: f64) -> f64 {
        let step = ticks * self.speed;
        let step = if step.is_finite() { step } else { 0.0 };
        // Forwards and backwards form one cycle of twice the duration.
        let cycle = 2.0 * self.duration;
        self.returns &= self.loop_mode == LoopMode::PingPong;
        let so_far = if self.returns { cycle - self.tick } else { self.tick } + step;
        self.tick = match self.loop_mode {
            LoopMode::Once => OutOfRange::Clamp.resolve(so_far, self.duration),
            LoopMode::Loop => OutOfRange::Loop.resolve(so_far, self.duration),
            LoopMode::PingPong => {
                let so_far = OutOfRange::Loop.resolve(so_far, cycle);
                self.returns = so_far > self.duration;
                if self.returns { cycle - so_far } else { so_far }
            }
        };
        self.tick
    }

    /// Whether the player plays once and has reached the end (or the start, if it plays backwards).
    pub fn is_finished(&self) -> bool {
        self.loop_mode == LoopMode::Once
            && if self.speed < 0.0 {
                self.tick <= 0.0
            } else {
                self.tick >= self.duration
            }
    }
}
