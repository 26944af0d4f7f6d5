//! How far a joint may turn.

use glam::{Quat, Vec3};

use crate::math::quaternion::twist_angle;

/// The rotations that a joint may have to its parent, from its rest rotation. Angles are in radians.
///
/// [`Pose::bend_chain`](crate::Pose::bend_chain) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum JointLimit {
    /// Any.
    #[default]
    Free,
    /// About one axis, as a knee.
    Hinge {
        /// The rotation at angle 0.
        rest: Quat,
        /// The axis, in the space of the joint.
        axis: Vec3,
        /// The smallest angle.
        min: f32,
        /// The largest angle.
        max: f32,
    },
    /// In a cone about the bone, as a shoulder.
    Cone {
        /// The rotation in the middle of the cone.
        rest: Quat,
        /// The direction of the bone, in the space of the joint.
        axis: Vec3,
        /// The largest angle of the bone from the middle.
        swing: f32,
        /// The largest angle about the bone, in either direction.
        twist: f32,
    },
}

impl JointLimit {
    /// The allowed rotation near `rotation`.
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
