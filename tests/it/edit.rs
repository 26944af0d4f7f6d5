//! Changes of a motion: the laws that every step keeps, and what each does to real files.

mod alike;
mod bent;
mod bones;
mod cleaned;
mod feet;
mod joined;
mod laws;
mod mirrored;
mod reached;

use mocap::glam::{DMat4, DVec3, Vec3};
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

/// The same in double precision, from the keys as they are: a quaternion that is not of unit length stretches.
fn exact_positions(scene: &Scene) -> Vec<Vec<DVec3>> {
    let animation = &scene.animations[0];
    let binding = Binding::new(scene, animation);
    let mut to_parent: Vec<DMat4> = scene.nodes.iter().map(|node| node.transform.as_dmat4()).collect();
    let frame = |frame: usize| {
        binding.sample(animation, frame as f64, |node, trs| {
            let (scale, turn, place) = (
                trs.scale.as_dvec3(),
                trs.rotation.as_dquat(),
                trs.translation.as_dvec3(),
            );
            to_parent[node.index()] = DMat4::from_scale_rotation_translation(scale, turn, place);
        });
        let mut to_world: Vec<DMat4> = Vec::new();
        for (node, own) in scene.nodes.iter().zip(&to_parent) {
            to_world.push(node.parent.map_or(*own, |parent| to_world[parent.index()] * *own));
        }
        to_world.iter().map(|matrix| matrix.w_axis.truncate()).collect()
    };
    (0..animation.frame_count()).map(frame).collect()
}

/// Every bone is as long after as before, in every frame, to a micrometre. Where the frames are others, it is compared
/// with the first one.
#[track_caller]
fn assert_bones_keep_their_lengths(before: &Scene, after: &Scene) {
    let (before_at, after_at) = (exact_positions(before), exact_positions(after));
    // A node that moves carries the figure, or has a bone of changing length in the file itself.
    let moving = before.animations[0]
        .channels
        .iter()
        .chain(&after.animations[0].channels);
    let moving = moving.filter(|channel| channel.position_keys.len() > 1);
    let moving: Vec<&str> = moving.map(|channel| channel.node_name.as_str()).collect();
    for (frame, new) in after_at.iter().enumerate() {
        let old = before_at
            .get(frame)
            .filter(|_| before_at.len() == after_at.len())
            .unwrap_or(&before_at[0]);
        for (index, node) in before.nodes.iter().enumerate() {
            if let Some(parent) = node
                .parent
                .map(NodeId::index)
                .filter(|_| !moving.contains(&&*node.name))
            {
                let (old, new) = (old[index].distance(old[parent]), new[index].distance(new[parent]));
                assert!(
                    (old - new).abs() < 1e-6,
                    "{} in frame {frame}: {old}, then {new}",
                    node.name
                );
            }
        }
    }
}
