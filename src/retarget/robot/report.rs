//! How good a motion is on a robot, and what the robot can do of it.

pub use super::collision::LinkCollision;
pub use super::feasibility::Feasibility;
pub use super::floor::Floor;
pub use super::robot_report::{ClampedJoint, RobotReport};
pub use super::verdict::Criterion;
