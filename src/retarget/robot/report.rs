//! The quality of a motion on a robot, and whether the robot can perform it.

pub use super::collision::LinkCollision;
pub use super::feasibility::Feasibility;
pub use super::floor::Floor;
pub use super::robot_report::{ClampedJoint, RobotReport};
pub use super::verdict::Criterion;
