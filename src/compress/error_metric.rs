//! The error metric: the distance by which a rotation error of a joint moves the points attached to the joint.
//!
//! The attached points are the joints at the ends of its lever arms, and a rigid shell around the joint. The shell
//! represents the skin, because a twist about the bone moves the skin but no joint. The metric and the shell distance
//! come from the Animation Compression Library: N. Frechette, "Animation Compression: Measuring Accuracy",
//! <https://nfrechette.github.io/2016/11/01/anim_compression_accuracy/>

use glam::{Mat3, Quat, Vec3};
use mocap_scene::math::soa::single::{Lanes, Vectors};

use super::raw_clip::RawClip;

/// The distance of the shell from the joint, in metres.
pub const SHELL_DISTANCE: f32 = 0.03;

/// The points that a joint's rotation moves.
pub struct LeverArms {
    /// The vectors to the joints that move with the joint as one rigid body, in the axes of the joint, in metres.
    pub arms: Vec<Vec3>,
    /// The length of the longest arm, or the shell distance.
    pub longest: f32,
    /// The length of the longest chain of descendants, in metres.
    pub chain_length: f32,
    /// A matrix, by rows. It maps the error of the joint's own position to the rotation (axis times angle) that moves
    /// the ends of the arms back as far as possible. The function `counter_rotation` derives the matrix.
    pub counter_rotation: [[f32; 3]; 3],
}

impl LeverArms {
    /// The lever arms of every joint.
    pub(super) fn of_clip(clip: &RawClip) -> Vec<Self> {
        let lengths = chain_lengths(clip).into_iter().enumerate();
        let of_joint = |(index, chain_length)| {
            let mut arms = Vec::new();
            collect_rigid_arms(clip, index, Vec3::ZERO, Quat::IDENTITY, &mut arms);
            Self {
                chain_length,
                ..Self::new(arms)
            }
        };
        lengths.map(of_joint).collect()
    }

    pub fn new(arms: Vec<Vec3>) -> Self {
        let longest = arms.iter().map(|arm| arm.length()).fold(SHELL_DISTANCE, f32::max);
        Self {
            counter_rotation: counter_rotation(&arms),
            arms,
            longest,
            chain_length: longest,
        }
    }

    /// The error of a joint with a position error and a rotation error, both in its own axes. The result is the largest
    /// error of an arm's end or of a point of the shell.
    pub fn error(&self, position_error: Vec3, rotation_error: Quat) -> f32 {
        let rotation = small_rotation_vector(rotation_error);
        let shell = rotation.length_squared() * (SHELL_DISTANCE * SHELL_DISTANCE);
        let at_ends = self.arms.iter();
        let at_ends = at_ends.map(|arm| (position_error + rotation.cross(*arm)).length_squared());
        at_ends.fold(shell, f32::max).sqrt()
    }

    /// The smallest change of a rotation error (axis times angle) that brings the largest error of a point to `goal`.
    /// If the position error is too large, the error comes as near to `goal` as possible. `None` if the largest error
    /// is at most `largest`.
    #[inline]
    pub(super) fn correction(&self, position_error: Vec3, rotation: Vec3, largest: f32, goal: f32) -> Option<Vec3> {
        let mut square = rotation.length_squared() * (SHELL_DISTANCE * SHELL_DISTANCE);
        let mut worst = None;
        for arm in &self.arms {
            let off = position_error + rotation.cross(*arm);
            if off.length_squared() > square {
                (square, worst) = (off.length_squared(), Some((arm, off)));
            }
        }
        if square <= largest * largest {
            return None;
        }
        let Some((arm, off)) = worst else {
            return Some(rotation * (goal / square.sqrt() - 1.0));
        };
        // A rotation moves the end of the arm only at right angles to the arm. The error along the arm does not change.
        let arm_square = arm.length_squared();
        let moment = arm.cross(off);
        let across = moment.length_squared() / arm_square.max(f32::MIN_POSITIVE);
        let rest = (goal * goal - (square - across)).max(0.0);
        let keep = (rest / across.max(f32::MIN_POSITIVE)).sqrt().min(1.0);
        Some(moment * ((keep - 1.0) / arm_square.max(f32::MIN_POSITIVE)))
    }

    /// The square of [`Self::error`] at several frames, for rotation errors given as axis times angle.
    #[inline(always)]
    pub(super) fn squared_errors(&self, position_error: Vectors, rotation_error: Vectors) -> Lanes {
        let mut largest = rotation_error.dot(rotation_error) * Lanes::all(SHELL_DISTANCE * SHELL_DISTANCE);
        for arm in &self.arms {
            let at_end = position_error + rotation_error.cross(Vectors::all(arm.to_array()));
            largest = largest.max(at_end.dot(at_end));
        }
        largest
    }
}

/// A small rotation as a vector: approximately axis times angle.
pub(super) fn small_rotation_vector(rotation: Quat) -> Vec3 {
    rotation.xyz() * if rotation.w < 0.0 { -2.0 } else { 2.0 }
}

/// The least-squares solution of `rotation x arm = -error` for all arms and any `error`, as the rows of a matrix to
/// apply to `error`. The shell counts as a further arm whose ends should not move. So the solution minimizes `sum
/// |rotation x arm + error|^2 + |SHELL_DISTANCE rotation|^2`.
fn counter_rotation(arms: &[Vec3]) -> [[f32; 3]; 3] {
    let mut normal = Mat3::from_diagonal(Vec3::splat(SHELL_DISTANCE * SHELL_DISTANCE));
    let mut sum = Vec3::ZERO;
    for &arm in arms {
        normal += Mat3::from_diagonal(Vec3::splat(arm.length_squared()))
            - Mat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z);
        sum += arm;
    }
    // The matrix of the cross product with the sum of all arms.
    let cross = Mat3::from_cols(
        Vec3::new(0.0, sum.z, -sum.y),
        Vec3::new(-sum.z, 0.0, sum.x),
        Vec3::new(sum.y, -sum.x, 0.0),
    );
    (normal.inverse() * cross * -1.0).transpose().to_cols_array_2d()
}

/// The length of the longest chain of descendants for every joint. A translating joint counts with its position in the
/// first frame.
fn chain_lengths(clip: &RawClip) -> Vec<f32> {
    let mut lengths = vec![0f32; clip.joints.len()];
    for (index, joint) in clip.joints.iter().enumerate().rev() {
        if let Some(parent) = joint.parent {
            let bone = joint.offset().length() * joint.parent_scale;
            lengths[parent] = lengths[parent].max(lengths[index] + bone);
        }
    }
    lengths
}

/// Collects the arms from a joint to its children. If a child does not rotate, also collects the arms from the joint to
/// the children of this child. `start` and `rotation` are the position and the rotation of joint `index`, in the axes
/// of the joint that owns the arms.
fn collect_rigid_arms(clip: &RawClip, index: usize, start: Vec3, rotation: Quat, arms: &mut Vec<Vec3>) {
    for &child in &clip.joints[index].children {
        let joint = &clip.joints[child];
        if joint.translates() {
            continue;
        }
        let arm = start + rotation * (joint.offset() * joint.parent_scale);
        arms.push(arm);
        if !joint.rotates() {
            collect_rigid_arms(clip, child, arm, rotation * joint.orientation(), arms);
        }
    }
}
