//! The axes of the rig's joints in the T-pose, and corrections for hands whose rotations do not match their positions.

use glam::{DMat3, DQuat, DVec3, EulerRot};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::scene::joint_tables::Joint;

use super::Sample;
use crate::warnings::Warnings;

/// Joints whose axes differ from their parent's axes in the T-pose. The angles in degrees about the fixed axes X, Y and
/// Z rotate the parent's axes to the joint's axes, in an upright body. The right side is the mirror image of the left.
/// The angles of a foot come from the vertices of standing feet in outputs of SAM 3D Body. With these angles, the sole
/// is flat on the ground. In the rig itself, the legs stand apart.
const TURNED: [(&str, [f64; 3]); 18] = [
    ("l_foot", [0.5, -19.0, -4.5]),
    ("l_talocrural", [2.0, 1.5, 12.5]),
    ("l_subtalar", [11.0, 1.5, 71.5]),
    ("l_transversetarsal", [3.5, 1.0, 0.0]),
    ("l_ball", [2.0, 13.5, 9.5]),
    ("c_spine2", [0.0, 0.0, -9.0]),
    ("l_clavicle", [38.0, -54.0, -53.0]),
    ("l_wrist_twist", [90.0, 0.0, 0.0]),
    ("l_thumb0", [78.0, 50.0, 47.0]),
    ("l_thumb1", [18.0, -22.0, 10.0]),
    ("l_thumb2", [-12.5, -3.5, 22.0]),
    ("l_thumb3", [10.0, 6.5, 3.5]),
    ("c_neck", [0.0, 0.0, 31.0]),
    ("c_head", [0.0, 0.0, -22.0]),
    ("c_tongue0", [-90.0, -64.0, 90.0]),
    ("c_tongue1", [0.0, 0.0, -6.0]),
    ("c_tongue2", [0.0, 0.0, -28.0]),
    ("c_tongue3", [0.0, 0.0, -16.0]),
];

/// The axes X, Y and Z of joints that are known in the T-pose. Thighs, spine and arms point along X and bend about Z. A
/// forearm bends forward.
fn stated(name: &str) -> Option<DMat3> {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    match name {
        "l_upleg" => Some(DMat3::from_cols(-y, -z, x)),
        "c_spine0" => Some(DMat3::from_cols(y, z, x)),
        "l_uparm" => Some(DMat3::from_cols(x, z, -y)),
        "body_world" | "c_jaw" | "l_eye" | "r_eye" => Some(DMat3::IDENTITY),
        _ => None,
    }
}

/// The axes of each joint in the T-pose, relative to the world axes: left +X, up +Y, forward +Z.
pub fn frames(joints: &[Joint]) -> Vec<DQuat> {
    let mut frames: Vec<DQuat> = Vec::with_capacity(joints.len());
    for joint in joints {
        let own = match joint.name.strip_prefix("r_") {
            Some(name) if !name.starts_with("eye") => mirrored(on_left(joints, &format!("l_{name}"))),
            _ => on_left(joints, &joint.name),
        };
        frames.push(own);
    }
    frames
}

/// The axes of a joint in the T-pose. The joint is in the middle or on the left of the body.
fn on_left(joints: &[Joint], name: &str) -> DQuat {
    if let Some(axes) = stated(name) {
        return DQuat::from_mat3(&axes);
    }
    let joint = joints.iter().find(|joint| joint.name == name);
    let above = joint
        .and_then(|joint| joint.parent)
        .map_or(DQuat::IDENTITY, |parent| on_left(joints, &joints[parent].name));
    let turned = TURNED.iter().find(|(turned, _)| *turned == name);
    let [x, y, z] = turned.map_or([0.0; 3], |(_, angles)| angles.map(f64::to_radians));
    match name {
        // The finger is straight; only its metacarpal is rotated.
        "l_pinky1" => on_left(joints, "l_wrist"),
        _ => above * DQuat::from_euler(EulerRot::ZYX, z, y, x),
    }
}

/// The axes of the right side: the left axes mirrored in the plane of the spine, with all three axes reversed.
fn mirrored(left: DQuat) -> DQuat {
    DQuat::from_xyzw(left.x, -left.y, -left.z, left.w) * DQuat::from_rotation_x(std::f64::consts::PI)
}

/// The smallest deviation in degrees at which the rotations of a hand do not match its positions. Both the wrist must
/// deviate from the palm, and a joint of the middle finger from its bone. Hands of other bodies deviate less.
const MISFIT: f64 = 15.0;

/// Computes the rotations of hands and fingers from their positions, if the stated rotations do not match the
/// positions.
pub(super) fn fit_hands(joints: &[Joint], samples: &mut [Sample], warnings: &mut Warnings) {
    for (word, side) in [("left", 1.0), ("right", -1.0)] {
        let fitted = samples
            .iter_mut()
            .filter_map(|sample| fit_hand(joints, sample, &word[..1], side));
        let count = fitted.count();
        if count > 0 {
            warnings.push(Code::NotCarriedOver, || {
                let frames = samples.len();
                let message = format!(
                    "the rotations of the {word} hand contradict its positions in {count} of {frames} frames, and are \
                        ignored there"
                );
                Diagnostic::new(Code::NotCarriedOver, message).help("the positions determine the hand's rotation there")
            });
        }
    }
}

/// Rotates a hand if its rotations do not match its positions.
fn fit_hand(joints: &[Joint], sample: &mut Sample, letter: &str, side: f64) -> Option<()> {
    /// Vectors in the axes of a left wrist, in metres. The first goes from the wrist to the first joint of the middle
    /// finger. The second goes from the first joint of the ring finger to the first joint of the index finger. No body
    /// shape changes their directions by a degree.
    const PALM: [DVec3; 2] = [DVec3::new(0.0745, 0.003, 0.0), DVec3::new(0.006, 0.001, -0.039)];
    let find = |name: &str| joints.iter().position(|joint| joint.name == format!("{letter}_{name}"));
    let (Some(wrist), Some(middle), Some(index), Some(ring)) =
        (find("wrist"), find("middle1"), find("index1"), find("ring1"))
    else {
        return None;
    };
    let at = |joint: usize| sample.at(joint);
    let palm = axes(PALM[0] * side, PALM[1] * side);
    let own = axes(at(middle) - at(wrist), at(index) - at(ring));
    let fitted = own? * palm?.inverse();
    let names = ["middle1", "middle2", "middle3", "middle_null"].map(find);
    let bends = names.windows(2).filter_map(|pair| {
        let (joint, next) = (pair[0]?, pair[1]?);
        let direction = (at(next) - at(joint)).try_normalize()?;
        Some(direction.angle_between(sample.rotation(joint) * DVec3::X * side))
    });
    let bent = bends.fold(0.0, f64::max).to_degrees();
    if fitted.angle_between(sample.rotation(wrist)).to_degrees() < MISFIT || bent < MISFIT {
        return None;
    }
    let turn = fitted * sample.rotation(wrist).inverse();
    let below =
        |joint: usize| std::iter::successors(Some(joint), |above| joints[*above].parent).any(|above| above == wrist);
    for joint in (0..joints.len()).filter(|joint| below(*joint)) {
        sample.rotations[joint] = (turn * sample.rotation(joint)).as_quat();
    }
    // Each finger joint points to the next.
    for joint in (wrist + 1..joints.len()).filter(|joint| below(*joint)) {
        let Some(next) = joints.iter().position(|other| other.parent == Some(joint)) else {
            continue;
        };
        let direction = (sample.at(next) - sample.at(joint)).try_normalize();
        if let Some(direction) = direction {
            let own = sample.rotation(joint) * DVec3::X * side;
            let turned = DQuat::from_rotation_arc(own, direction) * sample.rotation(joint);
            sample.rotations[joint] = turned.as_quat();
        }
    }
    Some(())
}

/// Axes: the first along `along`, the second in the plane of `along` and `across`.
fn axes(along: DVec3, across: DVec3) -> Option<DQuat> {
    let x = along.try_normalize()?;
    let y = (across - x * x.dot(across)).try_normalize()?;
    Some(DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y))))
}
