//! The way back: rotations of bones from joint angles, as files of OpenSim have them.

use glam::DQuat;

use super::angles::{Joint, Rotations, ending};
use super::segments::{Segment, mirrored, parts};
use crate::scene::{HumanoidBone as Bone, Side};

/// A forearm whose file has no angle for it is turned so far inward that the thumb of a hanging hand points forward.
const RELAXED_FOREARM: f64 = 90.0;

/// The rotations of a body in the T-pose whose joints have these angles, in degrees, in its axes: +X left, +Y up, +Z
/// forward. That of the hips is to the world, the others are to the bone above. `angle` gives the value of a column of
/// [`JointAngles`](super::JointAngles); a joint without angles is as in a body that stands with arms hanging.
pub(crate) fn rotations_of(angle: &dyn Fn(&str) -> Option<f64>) -> Vec<(Bone, DQuat)> {
    let pelvis = Rotations::PLAIN.back(["pelvis_tilt", "pelvis_list", "pelvis_rotation"].map(angle));
    let mut all = vec![(Bone::Hips, to_t_pose_axes(pelvis))];
    for (segment, side) in parts().filter(|(segment, _)| *segment != Segment::Pelvis) {
        let angles_of = |joint: &Joint| joint.names.map(|name| angle(&format!("{name}{}", ending(side))));
        // A shoulder is stated in two ways, of which a file may have either.
        let mut joints = Joint::all().filter(|joint| joint.below == segment);
        let has_angles = |joint: &&Joint| angles_of(joint).iter().any(Option::is_some);
        let Some(joint) = joints.clone().find(has_angles).or_else(|| joints.next()) else {
            continue;
        };
        let mut angles = angles_of(joint);
        if segment == Segment::Forearm {
            angles[2] = angles[2].or(Some(RELAXED_FOREARM));
        }
        let turned = joint.above.to_t_pose() * joint.rotations.back(angles) * segment.to_t_pose().inverse();
        let turned = if side == Some(Side::Left) {
            mirrored(turned)
        } else {
            turned
        };
        let bone = segment.bones()[0];
        all.push((side.map_or(bone, |side| bone.on(side)), to_t_pose_axes(turned)));
    }
    all
}

/// A rotation in the axes of the International Society of Biomechanics in those of the T-pose.
fn to_t_pose_axes(DQuat { x, y, z, w }: DQuat) -> DQuat {
    DQuat::from_xyzw(-z, y, x, w)
}
