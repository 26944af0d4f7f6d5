//! Changes of a motion: the laws that every step keeps, and what each does to real files.

mod cleaned;
#[cfg(feature = "cli")]
mod command;
mod feet;
mod joined;
mod mirrored;

use mocap::glam::Vec3;
use mocap::scene::NodeId;
use mocap::{Binding, Conversion, Pose, Scene};

/// A real file in metres with +Y up, without the rest pose that some begin with.
fn import(file: &str) -> Scene {
    let mut scene = mocap::import(format!("{}/fixtures/real/{file}", env!("CARGO_MANIFEST_DIR"))).unwrap();
    Conversion::new()
        .first_frame(mocap::convert::FirstFrame::DropRestPose)
        .apply(&mut scene)
        .unwrap();
    scene
}

/// The positions of all nodes in every frame.
fn positions(scene: &Scene) -> Vec<Vec<Vec3>> {
    let animation = &scene.animations[0];
    let binding = Binding::new(scene, animation);
    let mut pose = Pose::rest(scene);
    (0..animation.frame_count())
        .map(|frame| {
            pose.sample(&binding, animation, frame as f64);
            (0..scene.nodes.len())
                .map(|node| pose.position(NodeId::new(node)))
                .collect()
        })
        .collect()
}

/// Every bone is as long after as before, in every frame, to a micrometre.
#[track_caller]
fn assert_bones_keep_their_lengths(before: &Scene, after: &Scene) {
    let (before_at, after_at) = (positions(before), positions(after));
    // A node that moves carries the figure, or has a bone of changing length in the file itself.
    let moving = after.animations[0]
        .channels
        .iter()
        .filter(|channel| channel.position_keys.len() > 1);
    let moving: Vec<&str> = moving.map(|channel| channel.node_name.as_str()).collect();
    for (frame, (old, new)) in before_at.iter().zip(&after_at).enumerate() {
        for (index, node) in before.nodes.iter().enumerate() {
            if let Some(parent) = node
                .parent
                .map(NodeId::index)
                .filter(|_| !moving.contains(&&*node.name))
            {
                let (old, new) = (old[index].distance(old[parent]), new[index].distance(new[parent]));
                assert!(
                    (old - new).abs() < 2e-6,
                    "{} in frame {frame}: {old}, then {new}",
                    node.name
                );
            }
        }
    }
}
