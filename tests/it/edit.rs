//! Changes of a motion: the laws that every step keeps, and what each does to real files.

mod feet;

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
    // The topmost node that moves carries the figure; it has no bone.
    let moving = |channel: &&mocap::scene::Channel| channel.position_keys.len() > 1;
    let carrier = after.animations[0]
        .channels
        .iter()
        .find(moving)
        .map(|channel| channel.node_name.clone());
    for (frame, (old, new)) in before_at.iter().zip(&after_at).enumerate() {
        for (index, node) in before.nodes.iter().enumerate() {
            if let Some(parent) = node
                .parent
                .map(NodeId::index)
                .filter(|_| carrier.as_ref() != Some(&node.name))
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
