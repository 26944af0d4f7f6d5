//! Limits of joint rotations.

use glam::{Quat, Vec3};

use crate::math::quaternion::twist_angle;

/// The rotations that a joint may have relative to its parent, from its rest rotation. Angles are in radians.
///
/// [`Pose::bend_chain`](crate::Pose::bend_chain) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum JointLimit {
    /// Any rotation.
    #[default]
    Free,
    /// A rotation about one axis, such as a knee's.
    Hinge {
        /// The rotation at angle 0.
        rest: Quat,
        /// The axis, in the axes of the joint.
        axis: Vec3,
        /// The smallest angle, in radians.
        min: f32,
        /// The largest angle, in radians.
        max: f32,
    },
    /// A rotation within a cone about the bone, such as a shoulder's.
    Cone {
        /// The rotation at the centre of the cone.
        rest: Quat,
        /// The direction of the bone, in the axes of the joint.
        axis: Vec3,
        /// The largest angle of the bone from the centre, in radians.
        swing: f32,
        /// The largest rotation about the bone, in either direction, in radians.
        twist: f32,
    },
}

impl JointLimit {
    /// `rotation` if the limit allows it, otherwise an allowed rotation near it.
    pub fn clamp(&self, rotation: Quat) -> Quat {
        let clamped = match *self {
            Self::Free => rotation,
            Self::Hinge { rest, axis, min, max } => {
                let axis = axis.normalize_or(Vec3::X);
                let angle = twist_angle(rest.inverse() * rotation, axis);
                rest * Quat::from_axis_angle(axis, angle.max(min).min(max))
            }
            Self::Cone {
                rest,
                axis,
                swing,
                twist,
            } => {
                let axis = axis.normalize_or(Vec3::X);
                let change = rest.inverse() * rotation;
                let angle = twist_angle(change, axis);
                let swung = change * Quat::from_axis_angle(axis, -angle);
                let (about, by) = if swung.w < 0.0 { -swung } else { swung }.to_axis_angle();
                let swung = Quat::from_axis_angle(about, by.min(swing.max(0.0)));
                rest * swung * Quat::from_axis_angle(axis, angle.max(-twist).min(twist))
            }
        };
        if clamped.is_finite() {
            clamped.normalize()
        } else {
            rotation
        }
    }
}
