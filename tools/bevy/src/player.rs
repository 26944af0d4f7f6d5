//! What an app says and hears: the component, the choice of a clip, the events.

use std::time::Duration;

use bevy::prelude::*;
use mocap::LoopMode;

use crate::loader::Motion;
use crate::play::{Body, Coming, Track};

/// Which motion of a file is meant.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Clip {
    /// The first one.
    #[default]
    First,
    /// By its number, from 0.
    Index(usize),
    /// By its name.
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
/// and [`spawn`](crate::spawn) make them. It waits until they are there, and until the file is loaded.
///
/// A motion of the same skeleton plays as it is. One of another is retargeted; both must be humanoids then.
#[derive(Component, Default)]
pub struct MotionPlayer {
    /// How fast it plays: 1 as recorded, negative backwards.
    pub speed: f64,
    /// What it does at the end.
    pub loop_mode: LoopMode,
    /// Whether a retargeted motion has its feet held still where those of the source stand, where it is better so.
    pub lock_feet: bool,
    pub(crate) coming: Option<Coming>,
    /// From the one that fades out longest to the one that plays.
    pub(crate) tracks: Vec<Track>,
    pub(crate) body: Option<Body>,
}

impl MotionPlayer {
    /// A player of the first motion of a file, which loops.
    pub fn new(motion: Handle<Motion>) -> Self {
        let mut player = Self {
            speed: 1.0,
            lock_feet: true,
            ..Self::default()
        };
        player.play(motion, Clip::First, Duration::ZERO);
        player
    }

    /// Changes to another motion as soon as it is loaded, over a time in which both play.
    pub fn play(&mut self, motion: Handle<Motion>, clip: impl Into<Clip>, fade: Duration) {
        self.coming = Some(Coming::new(motion, clip.into(), fade));
    }

    /// Whether a motion plays.
    pub fn is_playing(&self) -> bool {
        self.tracks.last().is_some_and(|track| !track.player.is_finished())
    }

    /// Whether a motion that was asked for is not there yet.
    pub fn is_waiting(&self) -> bool {
        self.coming.is_some()
    }

    /// The clock of the motion that plays: its tick can be read and set.
    pub fn clock(&mut self) -> Option<&mut mocap::Player> {
        self.tracks.last_mut().map(|track| &mut track.player)
    }

    /// How much of the pose is of the motion that plays, from 0 to 1; less than 1 while it fades in.
    pub fn weight(&self) -> f32 {
        self.tracks.last().map_or(0.0, Track::weight)
    }

    /// The figure has changed: its entities are looked for anew before the next motion.
    pub fn forget_figure(&mut self) {
        self.body = None;
    }
}

/// A motion has begun to play.
#[derive(EntityEvent, Clone, Debug)]
pub struct MotionStarted {
    /// The entity of the [`MotionPlayer`].
    pub entity: Entity,
    /// The file.
    pub motion: Handle<Motion>,
    /// The number of the motion in the file.
    pub index: usize,
    /// How many degrees limbs of the figure point from those of the source in the mean; 0 where nothing was retargeted.
    pub mean_degrees: f64,
}

/// A motion has come to its end and begins again.
#[derive(EntityEvent, Clone, Copy, Debug)]
pub struct MotionLooped {
    /// The entity of the [`MotionPlayer`].
    pub entity: Entity,
}

/// A motion that plays once has come to its end.
#[derive(EntityEvent, Clone, Copy, Debug)]
pub struct MotionFinished {
    /// The entity of the [`MotionPlayer`].
    pub entity: Entity,
}

/// A motion that was asked for cannot be played; what played before goes on.
#[derive(EntityEvent, Clone, Debug)]
pub struct MotionFailed {
    /// The entity of the [`MotionPlayer`].
    pub entity: Entity,
    /// Why, as one sentence.
    pub reason: String,
}
