//! The positions of all nodes of a scene, and the effect of a change of the motion on these positions.

use mocap::glam::{DMat4, DVec3, Vec3};
use mocap::scene::NodeId;
use mocap::{Binding, Conversion, Pose, Scene};

/// A real file in metres with +Y up, without the rest pose at the beginning of some files.
pub(crate) fn import(file: &str) -> Scene {
    let mut scene = mocap::import(format!("../../fixtures/real/{file}")).unwrap();
    Conversion::new()
        .first_frame(mocap::convert::FirstFrame::DropRestPose)
        .apply(&mut scene)
        .unwrap();
    scene
}

/// The positions of all nodes in every frame.
pub(crate) fn positions(scene: &Scene) -> Vec<Vec<Vec3>> {
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

/// The positions in double precision, from unchanged keys: a quaternion that is not of unit length stretches.
pub(crate) fn exact_positions(scene: &Scene) -> Vec<Vec<DVec3>> {
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

/// Every bone keeps its length in every frame, to a micrometre. If the frames change, the bone is compared with the
/// first frame.
#[track_caller]
pub(crate) fn assert_bones_keep_their_lengths(before: &Scene, after: &Scene) {
    let (before_at, after_at) = (exact_positions(before), exact_positions(after));
    // A node whose position changes carries the figure, or is the end of a bone that changes its length in the file
    // itself.
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

/// The largest ratio of `values` to the values of `free` within a quarter of a second. A value below `still`, or below
/// a quarter of the fastest moment, is no movement.
fn ratio(values: &[f32], free: &[f32], around: usize, still: f32) -> f32 {
    let most = |values: &[f32]| values.iter().copied().fold(0.0, f32::max);
    let floor = still.max(0.25 * most(free));
    let ratio = |(frame, value): (usize, &f32)| {
        let around = frame.saturating_sub(around)..(frame + around + 1).min(free.len());
        value / floor.max(most(&free[around]))
    };
    most(&values.iter().enumerate().map(ratio).collect::<Vec<_>>())
}

/// The largest ratios of speeds and of accelerations of the joints of both feet, with and without a lock.
pub(crate) fn ratios(locked: &[Vec<Vec3>], free: &[Vec<Vec3>], joints: &[NodeId], rate: f32) -> [f32; 2] {
    let around = (0.25 * rate).round() as usize;
    let mut found = [0.0_f32; 2];
    for joint in joints {
        let [locked, free] = [locked, free].map(|at| at.iter().map(|at| at[joint.index()]).collect::<Vec<Vec3>>());
        let speeds =
            |at: &[Vec3]| -> Vec<f32> { at.windows(3).map(|at| (at[2] - at[0]).length() * rate / 2.0).collect() };
        let changes = |at: &[Vec3]| -> Vec<f32> {
            at.windows(3)
                .map(|at| (at[2] - 2.0 * at[1] + at[0]).length() * rate * rate)
                .collect()
        };
        found[0] = found[0].max(ratio(&speeds(&locked), &speeds(&free), around, 0.1));
        found[1] = found[1].max(ratio(&changes(&locked), &changes(&free), around, 2.0));
    }
    found
}
