//! Robots, and retargeting of human motion to robots.
//!
//! A [`Robot`] has links, and joints with limits, as URDF and MJCF describe them. [`Importer::import_robot`] reads a
//! robot. [`RobotRetargeter`] retargets the motion of a humanoid to the robot: positions of joints within their limits,
//! frame by frame. `docs/robots-algorithm.md` explains the algorithm.
//!
//! [`Importer::import_robot`]: mocap_io::Importer::import_robot
//!
//! ```
//! # std::env::set_current_dir("../..").unwrap();
//! use mocap::Importer;
//! use mocap::retarget::robot::{RobotOptions, RobotRetargeter};
//!
//! let robot = Importer::new().import_robot("fixtures/robots/g1_29dof_rev_1_0.urdf")?;
//! let walk = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
//! let mut retargeter = RobotRetargeter::new(&walk, &robot, &RobotOptions::default())?;
//! let (motion, report) = retargeter.clip(&walk, 0)?;
//! assert_eq!(motion.dof_names.len(), 29);
//! assert_eq!(report.limit_violations, 0);
//! # Ok::<(), mocap::Error>(())
//! ```

#[doc(hidden)]
pub(crate) mod band;
#[doc(hidden)]
pub(crate) mod branches;
#[doc(hidden)]
pub(crate) mod capsule;
pub(crate) mod collision;
pub(crate) mod cones;
pub(crate) mod drawn;
#[doc(hidden)]
pub(crate) mod dynamics;
pub(crate) mod feasibility;
#[doc(hidden)]
pub(crate) mod fingers;
pub(crate) mod floor;
#[doc(hidden)]
pub(crate) mod following;
pub(crate) mod four_legs;
#[doc(hidden)]
pub(crate) mod given;
#[doc(hidden)]
pub(crate) mod kinematics;
mod links;
mod measure;
mod motion;
mod of_scene;
pub(crate) mod quadruped;
pub mod report;
pub(crate) mod retargeter;
pub(crate) mod robot_report;
mod scores;
mod smooth_stream;
#[doc(hidden)]
pub(crate) mod solver;
pub(crate) mod source_rotations;
mod speed;
#[doc(hidden)]
pub(crate) mod swing;
#[doc(hidden)]
pub(crate) mod terms;
pub(crate) mod time_scale;
mod torques;
mod touches;
#[doc(hidden)]
pub(crate) mod twin;
pub(crate) mod verdict;
pub(crate) mod weights;
pub(crate) mod window;

#[doc(hidden)]
pub use self::drawn::add_links;
#[doc(hidden)]
pub use self::links::{LinkMotion, LinkOrder};
pub use self::motion::RobotMotion;
pub use self::retargeter::{RobotOptions, RobotRetargeter, RobotStream};
#[doc(hidden)]
pub use self::smooth_stream::SmoothRobotStream;
#[doc(hidden)]
pub use self::torques::InverseDynamics;
pub use self::weights::Weights;
pub use mocap_figure::robot_bones::{RobotBone, RobotMap};
#[doc(hidden)]
pub use mocap_figure::robot_bones::{robot_bones, robot_scene};
pub use mocap_scene::scene::robot::{
    Inertial, JointKind, JointLimits, Mimic, Placement, Robot, RobotJoint, RobotLink, RobotShape, ShapeKind,
};
