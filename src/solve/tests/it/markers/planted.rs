//! Markers that are planted on a body with known joints.

use mocap::glam::{Quat, Vec3};
use mocap::{Pose, Scene};

use super::lower_body::Markers;

/// The millimetres in one unit of CMU's BVH files: an inch, scaled by 1 / 0.45.
pub(super) const MILLIMETRES: f32 = 25.4 / 0.45;

/// A marker position: the joint that moves it, the joint that it is next to, and the offset from there in millimetres,
/// as outward, up and forward.
pub(super) type Place = (&'static str, &'static str, [f32; 3]);

pub(super) fn sided(side: &str, joint: &str) -> String {
    let is_of_trunk = ["Hips", "Spine", "Spine1", "Neck", "Head"].contains(&joint);
    if is_of_trunk {
        joint.to_owned()
    } else {
        format!("{side}{joint}")
    }
}

/// The position and rotation of a joint in a pose.
pub(super) fn joint(scene: &Scene, pose: &Pose, name: &str) -> (Vec3, Quat) {
    let node = scene.nodes.iter().position(|node| node.name == name).unwrap();
    let (_, rotation, position) = pose.node_to_world[node].to_scale_rotation_translation();
    (position, rotation)
}

/// CMU's walk, which is the ground truth. Its first frame is a T-pose.
pub(super) fn walk() -> Scene {
    mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap()
}

/// Markers in every `every`th frame of a motion after the first frame: their labels, sides and positions.
pub(super) fn planted(scene: &Scene, every: usize, markers: &[(String, &str, Place)]) -> Markers {
    let rest = Pose::rest(scene);
    let row = |frame: usize| {
        let pose = Pose::at_tick(scene, 0, frame as f64).unwrap();
        let at = |(_, side, (moved, beside, [outwards, up, forward])): &(String, &str, Place)| {
            let [moved, beside] = [moved, beside].map(|name| sided(side, name));
            let at_rest = joint(scene, &rest, &beside).0 - joint(scene, &rest, &moved).0;
            let (position, rotation) = joint(scene, &pose, &moved);
            let left = if *side == "Left" { *outwards } else { -outwards };
            (position + rotation * at_rest) * MILLIMETRES + rotation * Vec3::new(left, *up, *forward)
        };
        markers.iter().map(at).collect()
    };
    Markers {
        labels: markers.iter().map(|(label, ..)| label.clone()).collect(),
        frames: (1..scene.animations[0].frame_count()).step_by(every).map(row).collect(),
        rate: scene.animations[0].ticks_per_second / every as f64,
    }
}

/// The solved and the true hip, knee and ankle of a side in every frame, in millimetres.
pub(super) fn legs(solved: &Scene, truth: &Scene, every: usize, side: &str) -> Vec<[[Vec3; 3]; 2]> {
    let frames = solved.animations[0].frame_count();
    let frame = |frame: usize| {
        let own = Pose::at_tick(solved, 0, frame as f64).unwrap();
        let other = Pose::at_tick(truth, 0, (1 + frame * every) as f64).unwrap();
        let bones = ["UpperLeg", "LowerLeg", "Foot"].map(|bone| format!("{}{bone}", side.to_lowercase()));
        [
            bones.map(|bone| joint(solved, &own, &bone).0),
            ["UpLeg", "Leg", "Foot"].map(|name| joint(truth, &other, &sided(side, name)).0 * MILLIMETRES),
        ]
    };
    (0..frames).map(frame).collect()
}

/// The error of the bend of a knee, as RMS in degrees.
pub(super) fn knee(legs: &[[[Vec3; 3]; 2]]) -> f32 {
    let bend = |[hip, knee, ankle]: [Vec3; 3]| (knee - hip).angle_between(ankle - knee).to_degrees();
    let squares = legs.iter().map(|[own, truth]| (bend(*own) - bend(*truth)).powi(2));
    (squares.sum::<f32>() / legs.len() as f32).sqrt()
}
