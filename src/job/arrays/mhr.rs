//! A motion that has the joints of MHR itself.

use glam::{DQuat, DVec3};
use mocap_formats::mhr_frames;
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::Scene;
use mocap_scene::scene::joint_tables::{Joint, mhr};

/// World rotations since the T-pose, and positions in metres, of the joints in a frame.
pub(super) type Posed = (Vec<DQuat>, Vec<DVec3>);

/// The frames of a scene in metres with +Y up that has the joints of MHR in the rest pose in which they are read.
/// `None` for another skeleton. A joint that the scene lacks is at its parent.
pub(super) fn own_mhr(scene: &Scene) -> Option<Vec<Posed>> {
    /// The cosine of 5 degrees, by which a bone in rest may differ from the T-pose.
    const STRAIGHT: f32 = 0.996;
    let joints = mhr();
    let node = |joint: &Joint| scene.nodes.iter().position(|node| node.name == joint.name);
    let nodes: Vec<Option<usize>> = joints.iter().map(node).collect();
    let rest = Pose::rest(scene);
    let axes = mhr_frames(&joints);
    // The bones of the limbs point along the X axes of their joints.
    for (bone, child) in [("upleg", "lowleg"), ("lowleg", "foot"), ("uparm", "lowarm")] {
        for (side, sign) in [("l", 1.0), ("r", -1.0)] {
            let index = |name: &str| joints.iter().position(|joint| joint.name == format!("{side}_{name}"));
            let (bone, child) = (index(bone)?, index(child)?);
            let at = |joint: usize| nodes[joint].map(|node| rest.node_to_world[node].w_axis.truncate());
            let along = (at(child)? - at(bone)?).normalize_or_zero();
            if along.dot((axes[bone] * DVec3::X * sign).as_vec3()) < STRAIGHT {
                return None;
            }
        }
    }
    let turn = |pose: &Pose, node: usize| DQuat::from_mat4(&pose.node_to_world[node].as_dmat4()).normalize();
    let turned: Vec<DQuat> = nodes
        .iter()
        .map(|node| node.map_or(DQuat::IDENTITY, |node| turn(&rest, node).inverse()))
        .collect();
    let animation = scene.animations.first()?;
    let binding = Binding::new(scene, animation);
    let mut pose = rest.clone();
    let posed = |frame: usize| {
        pose.sample(&binding, animation, frame as f64);
        let mut posed: Posed = (Vec::with_capacity(joints.len()), Vec::with_capacity(joints.len()));
        for (index, joint) in joints.iter().enumerate() {
            let above = joint.parent.map(|parent| (posed.0[parent], posed.1[parent]));
            let (rotation, position) = match nodes[index] {
                Some(node) => (
                    turn(&pose, node) * turned[index],
                    pose.node_to_world[node].w_axis.truncate().as_dvec3(),
                ),
                None => above.unwrap_or_default(),
            };
            posed.0.push(rotation);
            posed.1.push(position);
        }
        posed
    };
    Some((0..animation.frame_count()).map(posed).collect())
}
