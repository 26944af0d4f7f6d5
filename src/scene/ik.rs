//! Inverse kinematics: turns joints so that the end of a limb comes to a goal.
//!
//! [`Pose::bend_limb`](crate::Pose::bend_limb) solves arms and legs exactly;
//! [`Pose::bend_chain`](crate::Pose::bend_chain) solves chains of any length, with limits, step by step. Both change a
//! [`Pose`](crate::Pose). [`TwoBone::solve`] and [`ChainOptions::bend_positions`] are these solvers on plain positions.
//!
//! No goal gives a pose that is not finite. A goal that is not finite changes nothing. A goal that the bones cannot
//! reach changes as much as is possible.

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
