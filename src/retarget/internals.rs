//! Exports for the tests of this package only.

pub use crate::robot::band::Band;
pub use crate::robot::collision::{Collisions, SelfCollision};
pub use crate::robot::cones::Cones;
pub use crate::robot::drawn::surface_of;
pub use crate::robot::dynamics::{Dynamics, GRAVITY, Rates};
pub use crate::robot::feasibility::outside;
pub use crate::robot::floor::drops;
pub use crate::robot::following::SolverGoals;
pub use crate::robot::given::Given;
pub use crate::robot::kinematics::{Body, Kinematics, RobotPose};
pub use crate::robot::retargeter::balance::shifts;
pub use crate::robot::solver::{Bounds, Solver};
pub use crate::robot::source_rotations::SourceRotations;
pub use crate::robot::swing::clearances;
pub use crate::robot::terms::{Goals, Reach, RotationGoal, Terms};
pub use crate::robot::twin::StandIn;
pub use crate::robot::verdict::Measures;

pub mod branches {
    pub use crate::robot::branches::{Branches, Follow, Free, Limb, SUSPECT, Track, shortest, suspects};
}
pub mod capsule {
    pub use crate::robot::capsule::{Capsule, add_box, distance};
}
pub mod fingers {
    pub use crate::robot::fingers::{FINGER, FingerBend, Fingers, Joint, curl};
}
pub mod sole {
    pub use mocap_figure::robot_bones::sole::{Sole, SoleBall, balls, on_the_floor};
}
#[cfg(feature = "live")]
pub mod vmc {
    pub use crate::live::vmc::{BonePose, bone, mirrored, unity_name};
}
pub mod window {
    pub use crate::robot::window::{SMALL, near};
}
