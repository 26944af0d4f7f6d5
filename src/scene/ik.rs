//! Inverse kinematics: rotates joints so that the end of a limb reaches a goal.
//!
//! [`Pose::bend_limb`](crate::Pose::bend_limb) solves arms and legs exactly.
//! [`Pose::bend_chain`](crate::Pose::bend_chain) solves chains of any length, with limits, iteratively. Both change a
//! [`Pose`](crate::Pose). [`TwoBone::solve`] and [`ChainOptions::bend_positions`] are the same solvers for plain
//! positions.
//!
//! Every pose stays finite. A goal that is not finite changes nothing. For a goal out of reach, the limb comes as near
//! as possible.

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
