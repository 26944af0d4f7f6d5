//! A motion that has the joints of MHR itself.

use glam::{DQuat, DVec3};
use mocap_formats::mhr_frames;
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::Scene;
use mocap_scene::scene::joint_tables::{Joint, mhr};

/// The joints in a frame: their world rotations relative to the T-pose, and their positions in metres.
pub(super) type Posed = (Vec<DQuat>, Vec<DVec3>);

/// The offsets of the face joints from their parents, in metres, in the axes of the parents. The offsets are equal in
/// all outputs of SAM 3D Body, because neither shape nor scale of a person changes the head of the rig.
const FACE: [(&str, [f64; 3]); 11] = [
    ("c_jaw", [0.01799, 0.01889, 0.0]),
    ("c_teeth", [0.0, -0.00897, 0.02375]),
    ("c_jaw_null", [0.0, -0.04297, 0.0788]),
    ("c_tongue0", [0.0, -0.00897, 0.00047]),
    ("c_tongue1", [0.01098, 0.0, 0.0]),
    ("c_tongue2", [0.02168, 0.0, 0.0]),
    ("c_tongue3", [0.0184, 0.0, 0.0]),
    ("c_tongue4", [0.01079, 0.0, 0.0]),
    ("r_eye", [0.08833, 0.06988, -0.03208]),
    ("l_eye", [0.08833, 0.06988, 0.03208]),
    ("eye_null", [0.0, 0.0, 0.01697]),
];

/// All frames of a scene in metres with +Y up. The scene must have the joints of MHR, and the rest pose in which mocap
/// reads MHR. `None` for another skeleton. A face joint that the scene lacks does not move relative to the head. Any
/// other missing joint is at the position of its parent.
pub(super) fn own_mhr(scene: &Scene) -> Option<Vec<Posed>> {
    /// The cosine of 5 degrees: the largest angle between the directions of a bone in the rest pose and in MHR's
    /// T-pose.
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
    let offset = |joint: &Joint| {
        let of_name = |(name, _): &&(&str, [f64; 3])| joint.name.ends_with(name);
        FACE.iter()
            .find(of_name)
            .map_or(DVec3::ZERO, |(_, offset)| DVec3::from_array(*offset))
    };
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
                None => {
                    let (rotation, position) = above.unwrap_or_default();
                    let parent = joint.parent.unwrap_or_default();
                    (rotation, position + rotation * axes[parent] * offset(joint))
                }
            };
            posed.0.push(rotation);
            posed.1.push(position);
        }
        posed
    };
    Some((0..animation.frame_count()).map(posed).collect())
}
