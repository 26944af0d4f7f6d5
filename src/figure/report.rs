//! The types that describe what was found about a figure, with reasons.

pub use mocap_scene::scene::report::Guess;

pub use crate::axis::RestPose;
pub use crate::humanoid::{
    Explanation, ExplanationRow, HumanoidJoint, PartExplanation, Quadruped, QuadrupedLeg, Sides,
};
pub use crate::name_joints::NamingReport;
pub use crate::t_pose::{TPoseBone, TPoseReason, TPoseSource};
