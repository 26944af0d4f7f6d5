//! Kimodo: `posed_joints` (frames, joints, 3) in metres, +Y up, and `global_rot_mats` or `local_rot_mats` (frames,
//! joints, 3, 3), which are the identity in the T-pose. mocap computes the joint offsets from the positions and the
//! rotations.

use glam::{DMat3, DQuat, DVec3, Vec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::math::median::median_vector;
use mocap_scene::scene::joint_tables::{self, Joint};
use mocap_scene::scene::{Confidence, Topic, UpAxis};

use super::Reader;
use crate::Failure;
use crate::array_files::read::motion::Motion;

const POSITIONS: &str = "posed_joints";

/// The number of frames from which the offset of a joint is computed.
const SAMPLES: usize = 64;

pub(super) fn motion(reader: &Reader<'_, '_>) -> Result<Motion, Failure> {
    let shape = reader
        .entries
        .get(POSITIONS)
        .map(|array| array.shape.clone())
        .unwrap_or_default();
    let joints = match shape.as_slice() {
        [.., 34, 3] => Some(joint_tables::g1()),
        [.., count, 3] => joint_tables::soma(*count).or_else(|| joint_tables::smpl(*count)),
        _ => None,
    };
    let Some(joints) = joints else {
        return Err(Box::new(
            Diagnostic::new(
                Code::RowLength,
                format!("the joints of the array {POSITIONS} match no known skeleton"),
            )
            .expected_found(
                "(frames, 30, 3) or (frames, 77, 3) of SOMA, (frames, 34, 3) of G1, or (frames, 22, 3) of SMPL-X",
                reader.entries.describe(),
            ),
        ));
    };
    let count = joints.len();
    let (frames, positions) = reader.numbers(POSITIONS, None, &[count, 3])?;
    let (name, is_local) = match reader.entries.get("global_rot_mats") {
        Some(_) => ("global_rot_mats", false),
        None => ("local_rot_mats", true),
    };
    let (_, matrices) = reader.numbers(name, Some(frames), &[count, 3, 3])?;
    let mut global = rotations(&matrices, count);
    if is_local {
        for (joint, described) in joints.iter().enumerate() {
            if let Some(parent) = described.parent {
                let (above, own) = global.split_at_mut(joint);
                for (rotation, above) in own[0].iter_mut().zip(&above[parent]) {
                    *rotation = *above * *rotation;
                }
            }
        }
    }
    let at = |frame: usize, joint: usize| DVec3::from_slice(&positions[3 * (frame * count + joint)..][..3]);
    let mut motion = Motion {
        rest: rest(&joints, &global, frames, &at),
        up: UpAxis::Y,
        root: (0..frames).map(|frame| at(frame, 0)).collect(),
        ..Motion::default()
    };
    motion.rotations = (0..count).map(|joint| local(&joints, &global, joint)).collect();
    motion.joints = joints;
    motion.assume(
        Topic::Body,
        "the joint offsets come from the positions",
        "the arrays have positions and rotations",
        Confidence::Sure,
    );
    reader.frame_rate(30.0, &mut motion)?;
    Ok(motion)
}

/// The rotations of row-major matrices: for each joint, a list with one rotation per frame.
fn rotations(matrices: &[f64], joints: usize) -> Vec<Vec<DQuat>> {
    let mut tracks = vec![Vec::new(); joints];
    for row in matrices.chunks_exact(9 * joints) {
        for (track, matrix) in std::iter::zip(&mut tracks, row.as_chunks::<9>().0) {
            track.push(DQuat::from_mat3(&DMat3::from_cols_array(matrix).transpose()).normalize());
        }
    }
    tracks
}

/// The rotations of a joint relative to its parent.
fn local(joints: &[Joint], global: &[Vec<DQuat>], joint: usize) -> Vec<DQuat> {
    match joints[joint].parent {
        None => global[joint].clone(),
        Some(parent) => std::iter::zip(&global[parent], &global[joint])
            .map(|(above, own)| above.inverse() * *own)
            .collect(),
    }
}

/// The joint positions in the T-pose. The position of a joint relative to its parent is the median over the frames. The
/// ground is at the lowest joint.
fn rest(joints: &[Joint], global: &[Vec<DQuat>], frames: usize, at: &dyn Fn(usize, usize) -> DVec3) -> Vec<Vec3> {
    let step = (frames / SAMPLES).max(1);
    let mut rest: Vec<Vec3> = Vec::with_capacity(joints.len());
    for (index, joint) in joints.iter().enumerate() {
        let Some(parent) = joint.parent else {
            rest.push(Vec3::ZERO);
            continue;
        };
        let offset = |frame: usize| global[parent][frame].inverse() * (at(frame, index) - at(frame, parent));
        let offsets = (0..frames).step_by(step).map(offset);
        rest.push(rest[parent] + median_vector(offsets).as_vec3());
    }
    let lowest = rest.iter().map(|position| position.y).fold(0.0, f32::min);
    rest.iter_mut().for_each(|position| position.y -= lowest);
    rest
}
