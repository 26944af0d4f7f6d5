//! The interface of an app: the component, the clip selection and the events.

use std::time::Duration;

use bevy::prelude::*;
use mocap::LoopMode;

use crate::loader::Motion;
use crate::play::{Body, Coming, Track};

/// The selected motion of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Clip {
    /// The first motion.
    #[default]
    First,
    /// The motion with this index, counted from 0.
    Index(usize),
    /// The motion with this name.
    Name(String),
}

impl From<&str> for Clip {
    fn from(name: &str) -> Self {
        Self::Name(name.to_owned())
    }
}

impl From<usize> for Clip {
    fn from(index: usize) -> Self {
        Self::Index(index)
    }
}

impl Clip {
    /// The index of the motion in the file.
    pub(crate) fn find(&self, scene: &mocap::Scene) -> Result<usize, String> {
        let count = scene.animations.len();
        match self {
            Self::First | Self::Index(_) if count == 0 => Err("the file has a skeleton and no motion".to_owned()),
            Self::First => Ok(0),
            Self::Index(index) if *index < count => Ok(*index),
            Self::Index(index) => Err(format!(
                "there is no motion {index}: the file has {count}, counted from 0"
            )),
            Self::Name(name) => {
                let names = || scene.animations.iter().map(|animation| animation.name.as_str());
                let found = names().position(|other| other == name);
                found.ok_or_else(|| {
                    let known = names().collect::<Vec<_>>().join(", ");
                    format!("no motion is called {name:?}; the file has {known}")
                })
            }
        }
    }
}

/// Plays motions on the figure below its entity: the entities that have a [`Transform`] and a [`Name`], as bevy_gltf
/// and [`spawn`](crate::spawn) create them. The player waits until these entities exist and the file is loaded.
///
/// A motion of the same skeleton plays unchanged. A motion of another skeleton is retargeted; then both skeletons must
/// be humanoids.
#[derive(Component, Default)]
pub struct MotionPlayer {
    /// The playback speed. 1 is the recorded speed; a negative speed plays backwards.
    pub speed: f64,
    /// What happens at the end of the motion.
    pub loop_mode: LoopMode,
    /// Whether to lock the feet of a retargeted motion while the source's feet are in contact. The lock is skipped
    /// where it would make the motion worse.
    pub lock_feet: bool,
    pub(crate) coming: Option<Coming>,
    /// The tracks, ordered from the track that has been fading out longest to the track that plays.
    pub(crate) tracks: Vec<Track>,
    pub(crate) body: Option<Body>,
}

impl MotionPlayer {
    /// A player that loops the first motion of a file.
    pub fn new(motion: Handle<Motion>) -> Self {
        let mut player = Self {
            speed: 1.0,
            lock_feet: true,
            ..Self::default()
        };
        player.play(motion, Clip::First, Duration::ZERO);
        player
    }

    /// Crossfades to another motion as soon as it is loaded. `fade` is the duration in which both motions play.
    pub fn play(&mut self, motion: Handle<Motion>, clip: impl Into<Clip>, fade: Duration) {
        self.coming = Some(Coming::new(motion, clip.into(), fade));
    }

    /// Whether a motion plays.
    pub fn is_playing(&self) -> bool {
        self.tracks.last().is_some_and(|track| !track.player.is_finished())
    }

    /// Whether a requested motion is still loading.
    pub fn is_waiting(&self) -> bool {
        self.coming.is_some()
    }

    /// The clock of the playing motion. You can read and set its tick.
    pub fn clock(&mut self) -> Option<&mut mocap::Player> {
        self.tracks.last_mut().map(|track| &mut track.player)
    }

    /// The weight of the playing motion in the pose, from 0 to 1. It is less than 1 while the motion fades in.
    pub fn weight(&self) -> f32 {
        self.tracks.last().map_or(0.0, Track::weight)
    }

    /// Tells the player that the figure has changed. The player searches for its entities again before the next motion.
    pub fn forget_figure(&mut self) {
        self.body = None;
    }
}

/// A motion has started.
#[derive(EntityEvent, Clone, Debug)]
pub struct MotionStarted {
    /// The entity of the [`MotionPlayer`].
    pub entity: Entity,
    /// The file.
    pub motion: Handle<Motion>,
    /// The index of the motion in the file.
    pub index: usize,
    /// The mean angle between the limbs of the figure and the limbs of the source, in degrees; 0 without retargeting.
    pub mean_degrees: f64,
}

/// A looping motion has reached its end and starts again.
#[derive(EntityEvent, Clone, Copy, Debug)]
pub struct MotionLooped {
    /// The entity of the [`MotionPlayer`].
    pub entity: Entity,
}

/// A motion that plays once has reached its end.
#[derive(EntityEvent, Clone, Copy, Debug)]
pub struct MotionFinished {
    /// The entity of the [`MotionPlayer`].
    pub entity: Entity,
}

/// A requested motion cannot be played. The previous motion continues.
#[derive(EntityEvent, Clone, Debug)]
pub struct MotionFailed {
    /// The entity of the [`MotionPlayer`].
    pub entity: Entity,
    /// The reason, as one sentence.
    pub reason: String,
}
