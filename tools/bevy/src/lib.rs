//! Motion files in Bevy: assets of the formats that [`mocap`] reads, and a component that plays them on a figure that
//! is there already, such as a skinned glTF scene.
//!
//! ```no_run
//! use std::time::Duration;
//!
//! use bevy::prelude::*;
//! use mocap_bevy::{Clip, MotionPlayer};
//!
//! fn begin(mut commands: Commands, assets: Res<AssetServer>) {
//!     // The hero is what another plugin loads below this entity: bevy_gltf, or `mocap_bevy::spawn`.
//!     commands.spawn(MotionPlayer::new(assets.load("walk.bvh")));
//! }
//!
//! fn run(assets: Res<AssetServer>, mut players: Query<&mut MotionPlayer>) {
//!     for mut player in &mut players {
//!         player.play(assets.load("takes.fbx"), Clip::from("run"), Duration::from_millis(300));
//!     }
//! }
//! ```
//!
//! A motion of another skeleton is retargeted, in the background, once for each figure. Names, rest pose, unit and axes
//! need not agree. Feet stand still where the feet of the source do. [`MotionStarted`], [`MotionLooped`],
//! [`MotionFinished`] and [`MotionFailed`] tell what happens.
//!
//! `mocap` and Bevy have both +Y up, right-handed coordinates and column vectors, so numbers go over as they are.

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

/// The systems that play motions. An app that has them may order its own before or after.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PlayMotions;

/// Loads motion files, and plays them where a [`MotionPlayer`] is. It needs Bevy's `AssetPlugin` and `TaskPoolPlugin`,
/// which `DefaultPlugins` have.
pub struct MotionPlugin;

impl Plugin for MotionPlugin {
    fn build(&self, app: &mut App) {
        app.init_asset::<Motion>()
            .register_asset_loader(MotionLoader::default())
            .add_systems(Update, (play::begin, play::advance).chain().in_set(PlayMotions));
    }
}
