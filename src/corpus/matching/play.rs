//! Makes a figure follow a gamepad.

use std::fmt;

use glam::{Vec2, Vec3};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::{Animation, Scene};
use serde::Serialize;

use super::controller::Controller;
use super::features::FEATURE_RATE;
use super::gamepad::Gamepad;
use super::record::Record;

/// The largest speed in m/s that a stick at its edge may request. No human runs faster.
const FASTEST: f32 = 12.0;
/// Half the window over which the velocity of the figure is measured, in frames. The window is one step of a walk.
const STEP: usize = 15;

/// How a figure followed a gamepad.
///
/// [`Controller::play`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct PlayReport {
    /// The number of frames, at 60 frames per second.
    pub frames: usize,
    /// The number of jumps to other frames of the database.
    pub jumps: usize,
    /// The length of the figure's path over the ground, in metres.
    pub distance: f64,
    /// The length of the path that the sticks asked for, in metres.
    pub wanted_distance: f64,
    /// The mean difference between the velocity of the figure, measured over half a second, and the wanted velocity, in
    /// m/s.
    pub mean_velocity_error: f64,
    /// The mean angle between the facing of the figure and the wanted facing, in degrees.
    pub mean_angle: f64,
}

impl fmt::Display for PlayReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "frames: {}, jumps: {}; the figure moved {:.1} m, the gamepad asked for {:.1} m; mean error of the velocity {:.2} m/s, of the \
             direction {:.0} degrees",
            self.frames, self.jumps, self.distance, self.wanted_distance, self.mean_velocity_error, self.mean_angle
        )
    }
}

impl Controller {
    /// Makes the figure follow a gamepad. The figure stands at first. The left stick controls the velocity over the
    /// ground: forward is +Z of the world, and right is -X. At its edge, the stick requests `speed` m/s. The right
    /// stick controls the facing. While the right stick is in its centre, the figure faces its direction of motion.
    /// Returns the motion, and a report of how well the figure followed.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::glam::Vec3;
    /// use mocap::matching::{Controller, Database, Gamepad, IndexedClip, Moves};
    /// use mocap::retarget::{Retargeter, RetargetOptions};
    ///
    /// # fn main() -> mocap::Result<()> {
    /// let walk = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let database = Database::new(IndexedClip::of(&walk, "walk.bvh", false));
    /// let mut hero = mocap::import("fixtures/real/rokoko_dance.bvh")?;
    /// mocap::Conversion::new().apply(&mut hero)?;
    /// let clips = Retargeter::new(walk, hero.clone(), RetargetOptions::new())?.into_clips();
    /// let mut moves = Moves::new(&hero)?;
    /// moves.add(&database.clips()[0], &clips[0].animation)?;
    /// let mut figure = Controller::new(&database, moves, Vec3::ZERO, Vec3::Z)?;
    /// let gamepad = Gamepad::parse("seconds,left_x,left_y\n0,0,1\n3,0,0\n")?;
    /// let (animation, played) = figure.play(&hero, &gamepad, 1.2)?;
    /// assert_eq!(animation.frame_count(), played.frames);
    /// assert!(played.distance > 1.5);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`Code::InvalidValue`] for a speed that is not above 0, or above 12 m/s.
    pub fn play(&mut self, character: &Scene, gamepad: &Gamepad, speed: f32) -> Result<(Animation, PlayReport)> {
        if !(speed > 0.0 && speed <= FASTEST) {
            let diagnostic = Diagnostic::new(Code::InvalidValue, "the figure cannot move at this speed");
            let expected = format!("above 0 and at most {FASTEST} m/s");
            return Err(diagnostic.expected_found(expected, speed.to_string()).into());
        }
        let mut record = Record::new(self, character);
        let (mut positions, mut asked) = (Vec::new(), Vec::new());
        let frames = (gamepad.seconds() * FEATURE_RATE).round() as usize + 1;
        let (mut angles, jumps) = (0.0, self.jumps());
        for frame in 0..frames {
            record.add(self.pose());
            positions.push(self.position());
            asked.push(self.steering().velocity());
            angles += f64::from(self.forward().angle_between(self.steering().forward()));
            let [left, right] = gamepad.at(frame as f64 / FEATURE_RATE);
            // Seen from behind, the right is along -X.
            let [left, right] = [left, right].map(|stick| Vec2::new(-stick.x, stick.y));
            self.steer(speed * left, right);
        }
        let sum = |lengths: &mut dyn Iterator<Item = f32>| lengths.map(f64::from).sum::<f64>();
        let played = PlayReport {
            frames,
            jumps: self.jumps() - jumps,
            distance: sum(&mut positions.windows(2).map(|pair| pair[0].distance(pair[1]))),
            wanted_distance: sum(&mut asked.iter().map(|velocity| velocity.length())) / FEATURE_RATE,
            mean_velocity_error: velocity_error(&positions, &asked),
            mean_angle: (angles / frames as f64).to_degrees(),
        };
        Ok((record.animation(character), played))
    }
}

/// The mean difference between the velocities of the figure and the wanted velocities.
fn velocity_error(positions: &[Vec3], asked: &[Vec3]) -> f64 {
    let last = positions.len() - 1;
    let error = |(frame, asked): (usize, &Vec3)| {
        let (before, after) = (frame.saturating_sub(STEP), (frame + STEP).min(last));
        let seconds = (after - before).max(1) as f32 / FEATURE_RATE as f32;
        f64::from(((positions[after] - positions[before]) / seconds).distance(*asked))
    };
    asked.iter().enumerate().map(error).sum::<f64>() / asked.len() as f64
}
