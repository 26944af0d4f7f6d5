//! The quality of a motion on a robot, and whether the robot can perform it.

pub use super::collision::LinkCollision;
pub use super::feasibility::{Feasibility, InfeasibleCause};
pub use super::floor::Floor;
pub use super::robot_report::{ClampedJoint, RobotReport};
pub use super::scores::RobotScores;
pub use super::time_scale::TimeScale;
pub use super::verdict::Criterion;
