//! Plays a motion file on Bevy's entities: an entity a node, with a name, below that of its parent.
//!
//! Bevy chains the transforms itself, so [`play`] only writes them. The parts of a node's transform lie in `mocap` as
//! they lie in Bevy, translation, rotation, scale; both are right-handed with column vectors, and lengths stay in the
//! file's unit unless the root's parent is scaled.

#![warn(clippy::unwrap_used)]

use bevy::prelude::*;
use mocap::{Binding, Player, Trs};

/// Moves the nodes of every [`Capture`] as time passes.
pub struct CapturePlugin;

impl Plugin for CapturePlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Update, play);
    }
}

/// A motion and the skeleton of entities that it moves. It sits on the skeleton's root.
#[derive(Component)]
pub struct Capture {
    /// Where in the motion it is, how fast it plays, and what it does at the end.
    pub player: Player,
    /// The entity of each node, in the order of the scene's nodes.
    pub nodes: Vec<Entity>,
    animation: mocap::scene::Animation,
    binding: Binding,
}

/// Spawns the skeleton of `scene` and, if the scene has a motion, a [`Capture`] that plays the first one. Returns the
/// root, or nothing if there are no nodes.
pub fn spawn(commands: &mut Commands, mut scene: mocap::Scene) -> Option<Entity> {
    let mut nodes: Vec<Entity> = Vec::with_capacity(scene.nodes.len());
    for node in &scene.nodes {
        let transform = transform(Trs::from_matrix(node.transform));
        let mut entity = commands.spawn((Name::new(node.name.clone()), transform));
        // Parents stand before their children.
        if let Some(parent) = node.parent {
            entity.insert(ChildOf(nodes[parent.index()]));
        }
        nodes.push(entity.id());
    }
    let root = *nodes.first()?;
    if !scene.animations.is_empty() {
        let animation = scene.animations.remove(0);
        commands.entity(root).insert(Capture {
            player: Player::new(&animation),
            binding: Binding::new(&scene, &animation),
            nodes,
            animation,
        });
    }
    Some(root)
}

/// Writes the transforms of all skeletons for the tick that the time is at.
pub fn play(time: Res<Time>, mut captures: Query<&mut Capture>, mut transforms: Query<&mut Transform>) {
    for mut capture in &mut captures {
        let tick = capture.player.advance(time.delta_secs_f64());
        let capture = &*capture;
        capture.binding.sample(&capture.animation, tick, |node, trs| {
            // An entity that the app has despawned is not there to be moved.
            if let Ok(mut place) = transforms.get_mut(capture.nodes[node.index()]) {
                *place = transform(trs);
            }
        });
    }
}

/// The two libraries may use different versions of the same vectors, so numbers go over and not types.
fn transform(trs: Trs) -> Transform {
    Transform {
        translation: Vec3::from_array(trs.translation.to_array()),
        rotation: Quat::from_array(trs.rotation.to_array()),
        scale: Vec3::from_array(trs.scale.to_array()),
    }
}
