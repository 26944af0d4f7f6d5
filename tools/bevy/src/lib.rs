//! Motion files in Bevy: assets of the formats that [`mocap`] reads, and a component that plays them on an existing
//! figure, such as a skinned glTF scene.
//!
//! ```no_run
//! use std::time::Duration;
//!
//! use bevy::prelude::*;
//! use mocap_bevy::{Clip, MotionPlayer};
//!
//! fn begin(mut commands: Commands, assets: Res<AssetServer>) { // bevy_gltf or `mocap_bevy::spawn` loads the hero
//!     below this entity. commands.spawn(MotionPlayer::new(assets.load("walk.bvh"))); }
//!
//! fn run(assets: Res<AssetServer>, mut players: Query<&mut MotionPlayer>) {
//!     for mut player in &mut players {
//!         player.play(assets.load("takes.fbx"), Clip::from("run"), Duration::from_millis(300));
//!     }
//! }
//! ```
//!
//! A motion of another skeleton is retargeted in the background, once for each figure. Names, rest pose, unit and axes
//! may differ. Feet are locked while the feet of the source are in contact. The events are [`MotionStarted`],
//! [`MotionLooped`], [`MotionFinished`] and [`MotionFailed`].
//!
//! Both `mocap` and Bevy use +Y up, right-handed coordinates and column vectors, so numbers are not converted.

#![warn(clippy::unwrap_used)]

mod body;
mod loader;
mod play;
mod player;

use bevy::prelude::*;

pub use self::body::spawn;
pub use self::loader::{Motion, MotionLoader};
pub use self::player::{Clip, MotionFailed, MotionFinished, MotionLooped, MotionPlayer, MotionStarted};
pub use mocap;

/// The systems that play motions. An app may order its systems before or after them.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PlayMotions;

/// Loads motion files, and plays them on entities with a [`MotionPlayer`]. It needs Bevy's `AssetPlugin` and
/// `TaskPoolPlugin`, which `DefaultPlugins` contain.
pub struct MotionPlugin;

impl Plugin for MotionPlugin {
    fn build(&self, app: &mut App) {
        app.init_asset::<Motion>()
            .register_asset_loader(MotionLoader::default())
            .add_systems(Update, (play::begin, play::advance).chain().in_set(PlayMotions));
    }
}
