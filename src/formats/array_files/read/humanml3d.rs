//! HumanML3D's 263 numbers per frame, from the positions of the 22 joints of SMPL at 20 frames per second, and back.
//!
//! | numbers | |
//! |---|---|
//! | 1 | half of the root's rotation angle about +Y to the next frame |
//! | 2 | the root's ground displacement to the next frame, relative to its heading |
//! | 1 | the root's height |
//! | 21 x 3 | the other joints, relative to the root's ground position and heading |
//! | 21 x 6 | rotations of the joints along their chains, as the first two columns of matrices |
//! | 22 x 3 | the displacements of all joints to the next frame, relative to the heading |
//! | 4 | whether left ankle, left toes, right ankle and right toes hardly move to the next frame |
//!
//! The definition is Guo and others, *Generating Diverse and Natural 3D Human Motions from Text* (CVPR 2022), as their
//! `motion_representation.ipynb` computes it. mocap keeps two oddities: the sign of the shoulders in the heading, and
//! the arm chains that start at the root's rotation. Lengths are the input's lengths, because the data set's common
//! skeleton comes from a licensed body.

use glam::{DMat3, DQuat, DVec3};

/// The number of joints in a frame: the joints of SMPL without hands.
pub(crate) const JOINTS: usize = 22;

/// The count of numbers in a frame of HumanML3D.
pub const NUMBERS: usize = 263;

/// The frame rate of HumanML3D in frames per second. HumanML3D's authors resampled all motions to this rate.
pub const RATE: f64 = 20.0;

/// The joint chains from the root, in the data set's order.
const CHAINS: [&[usize]; 5] = [
    &[0, 2, 5, 8, 11],
    &[0, 1, 4, 7, 10],
    &[0, 3, 6, 9, 12, 15],
    &[9, 14, 17, 19, 21],
    &[9, 13, 16, 18, 20],
];

/// The position of each joint at rest, relative to its parent.
#[rustfmt::skip]
const AT_REST: [DVec3; JOINTS] = [
    DVec3::ZERO, DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::NEG_Y, DVec3::Y, DVec3::NEG_Y, DVec3::NEG_Y,
    DVec3::Y, DVec3::Z, DVec3::Z, DVec3::Y, DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Y, DVec3::NEG_Y, DVec3::NEG_Y,
    DVec3::NEG_Y, DVec3::NEG_Y, DVec3::NEG_Y,
];

/// The index of the left hip among the joints of SMPL.
const LEFT_HIP: usize = 1;

/// The index of the right hip among the joints of SMPL.
const RIGHT_HIP: usize = 2;

/// The index of the left shoulder among the joints of SMPL.
const LEFT_SHOULDER: usize = 16;

/// The index of the right shoulder among the joints of SMPL.
const RIGHT_SHOULDER: usize = 17;
/// The joints of the feet: left ankle, left toes, right ankle, right toes.
const FEET: [usize; 4] = [7, 10, 8, 11];
/// A foot joint is in contact if the square of its displacement to the next frame is below this number, in square
/// metres.
const CONTACT: f64 = 0.002;

/// The standard deviation in frames of the Gaussian that smooths headings, as in HumanML3D's code.
const SMOOTHING: f64 = 20.0;

/// The reach of the Gaussian in standard deviations: SciPy's default, which HumanML3D uses.
const REACH: f64 = 4.0;

type Frame = [DVec3; JOINTS];

/// HumanML3D's numbers for every frame except the last, which has no next frame.
pub fn numbers(joints: &[Frame]) -> Vec<[f32; NUMBERS]> {
    let frames = standing(joints);
    let headings = headings(&frames);
    let mut rows = Vec::with_capacity(frames.len().saturating_sub(1));
    for index in 0..frames.len().saturating_sub(1) {
        let (now, next) = (&frames[index], &frames[index + 1]);
        let (heading, next_heading) = (headings[index], headings[index + 1]);
        let turned = next_heading * heading.inverse();
        let step = next_heading * (next[0] - now[0]);
        let mut row = Vec::with_capacity(NUMBERS);
        row.extend([turned.y.clamp(-1.0, 1.0).asin(), step.x, step.z, now[0].y]);
        let ground = DVec3::new(now[0].x, 0.0, now[0].z);
        row.extend(
            now[1..]
                .iter()
                .flat_map(|position| (heading * (*position - ground)).to_array()),
        );
        row.extend(rotations(now, heading)[1..].iter().flat_map(|rotation| {
            let matrix = DMat3::from_quat(*rotation);
            [matrix.x_axis.to_array(), matrix.y_axis.to_array()].concat()
        }));
        row.extend(std::iter::zip(now, next).flat_map(|(now, next)| (heading * (*next - *now)).to_array()));
        row.extend(FEET.map(|joint| f64::from(u8::from((next[joint] - now[joint]).length_squared() < CONTACT))));
        let mut numbers = [0.0; NUMBERS];
        std::iter::zip(&mut numbers, row).for_each(|(number, value)| *number = value as f32);
        rows.push(numbers);
    }
    rows
}

/// The joint positions that rows of HumanML3D's numbers describe. In the first frame the root is above the origin.
pub(crate) fn joints(rows: &[f64]) -> Vec<Frame> {
    let (mut angle, mut root) = (0.0_f64, DVec3::ZERO);
    let mut frames = Vec::new();
    for row in rows.chunks_exact(NUMBERS) {
        let heading = DQuat::from_xyzw(0.0, angle.sin(), 0.0, angle.cos());
        root.y = row[3];
        let mut frame = [root; JOINTS];
        for (position, numbers) in std::iter::zip(&mut frame[1..], row[4..].chunks_exact(3)) {
            *position = heading.inverse() * DVec3::from_slice(numbers) + DVec3::new(root.x, 0.0, root.z);
        }
        frames.push(frame);
        angle += row[0];
        let next = DQuat::from_xyzw(0.0, angle.sin(), 0.0, angle.cos());
        root += next.inverse() * DVec3::new(row[1], 0.0, row[2]);
    }
    frames
}

/// Moves the body to the ground. In the first frame, the result is above the origin and faces +Z.
fn standing(joints: &[Frame]) -> Vec<Frame> {
    let Some(first) = joints.first() else { return Vec::new() };
    let floor = joints
        .iter()
        .flatten()
        .map(|position| position.y)
        .fold(f64::INFINITY, f64::min);
    let origin = DVec3::new(first[0].x, floor, first[0].z);
    let across = first[RIGHT_HIP] - first[LEFT_HIP] + first[RIGHT_SHOULDER] - first[LEFT_SHOULDER];
    let facing = DVec3::Y.cross(across.normalize_or_zero()).normalize_or(DVec3::Z);
    let turn = between(facing, DVec3::Z);
    joints
        .iter()
        .map(|frame| frame.map(|position| turn * (position - origin)))
        .collect()
}

/// The rotations from the smoothed headings to +Z.
fn headings(frames: &[Frame]) -> Vec<DQuat> {
    let facing = |frame: &Frame| {
        // As published: the hips from right to left, but the shoulders from left to right.
        let across = frame[LEFT_HIP] - frame[RIGHT_HIP] + frame[RIGHT_SHOULDER] - frame[LEFT_SHOULDER];
        DVec3::Y.cross(across.normalize_or_zero())
    };
    let facing: Vec<DVec3> = frames.iter().map(facing).collect();
    let reach = (REACH * SMOOTHING + 0.5) as isize;
    let weight = |step: isize| (-0.5 * (step as f64 / SMOOTHING).powi(2)).exp();
    let last = facing.len() as isize - 1;
    (0..facing.len() as isize)
        .map(|at| {
            let near = |step: isize| facing[(at + step).clamp(0, last) as usize] * weight(step);
            let sum: DVec3 = (-reach..=reach).map(near).sum();
            match at {
                // The authors computed the data set in this way: their code ran a line that is a comment in the
                // notebook.
                0 => DQuat::IDENTITY,
                _ => between(sum.normalize_or(DVec3::Z), DVec3::Z),
            }
        })
        .collect()
}

/// The rotations of the joints, each relative to its parent in its chain.
fn rotations(frame: &Frame, heading: DQuat) -> Frame4 {
    let mut rotations = [heading; JOINTS];
    for chain in CHAINS {
        let mut above = heading;
        for pair in chain.windows(2) {
            let to = (frame[pair[1]] - frame[pair[0]]).normalize_or(AT_REST[pair[1]]);
            let own = between(AT_REST[pair[1]], to);
            rotations[pair[1]] = above.inverse() * own;
            above = own;
        }
    }
    rotations
}

type Frame4 = [DQuat; JOINTS];

/// The shortest rotation between unit vectors.
fn between(from: DVec3, to: DVec3) -> DQuat {
    let axis = from.cross(to);
    let rotation = DQuat::from_xyzw(axis.x, axis.y, axis.z, 1.0 + from.dot(to));
    match rotation.length_squared() > 1e-24 {
        true => rotation.normalize(),
        false => DQuat::from_axis_angle(from.any_orthonormal_vector(), std::f64::consts::PI),
    }
}
