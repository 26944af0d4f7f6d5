//! Inverse kinematics: turns joints so that the end of a limb comes to a goal.
//!
//! [`Pose::bend_limb`](crate::Pose::bend_limb) solves arms and legs exactly;
//! [`Pose::bend_chain`](crate::Pose::bend_chain) solves chains of any length, with limits, step by step. Both change a
//! [`Pose`](crate::Pose). [`TwoBone::solve`] and [`ChainOptions::bend_positions`] are these solvers on plain positions.
//!
//! No goal gives a pose that is not finite: one that is not finite itself, or that asks for what the bones cannot do,
//! changes nothing, or as much as is possible.

mod chain;
mod goal;
pub(crate) mod hinge;
mod limit;
mod two_bone;

pub use self::chain::ChainOptions;
pub use self::goal::Goal;
#[doc(hidden)]
pub use self::hinge::{bend_about_hinge, hinge_rotations, plane_normal, seen_hinge};
pub use self::limit::JointLimit;
pub use self::two_bone::TwoBone;

use glam::{DQuat, DVec3};

/// The smallest rotation from one direction to another, which need not have unit length; about `axis` where they are
/// opposite. Exact for small angles too, where glam's gives none at all.
fn arc(from: DVec3, to: DVec3, axis: DVec3) -> DQuat {
    let length = (from.length_squared() * to.length_squared()).sqrt();
    let (w, v) = (length + from.dot(to), from.cross(to));
    // 1 + cos is 1e-12 at 1.4e-6 radians from opposite: the axis has no digits left.
    if w.is_nan() || length <= 0.0 {
        DQuat::IDENTITY
    } else if w <= 1e-12 * length {
        DQuat::from_xyzw(axis.x, axis.y, axis.z, 0.0).normalize()
    } else {
        DQuat::from_xyzw(v.x, v.y, v.z, w).normalize()
    }
}
