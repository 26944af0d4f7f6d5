//! The inverse dynamics of a motion, in MuJoCo's layout.

use mocap_scene::scene::robot::{Placement, Robot};

use super::dynamics::{Dynamics, Rates, rates};
use super::kinematics::Kinematics;
use super::motion::RobotMotion;

/// The velocities, the accelerations and the forces of each frame: six numbers for the base and one for each joint.
#[derive(Clone, Debug, Default)]
#[doc(hidden)]
pub struct InverseDynamics {
    #[doc(hidden)]
    pub velocities: Vec<f64>,
    #[doc(hidden)]
    pub accelerations: Vec<f64>,
    #[doc(hidden)]
    pub forces: Vec<f64>,
}

impl InverseDynamics {
    /// The values of every frame of a motion. Empty for fewer than three frames, which have no accelerations.
    #[doc(hidden)]
    pub fn new(robot: &Robot, motion: &RobotMotion) -> Self {
        let kinematics = Kinematics::new(robot);
        let mut dynamics = Dynamics::new(robot, &kinematics);
        let mut pose = kinematics.rest();
        let mut all = Self::default();
        for frame in 0..motion.frames() {
            let Some((velocity, acceleration)) = rates(motion, frame) else {
                break;
            };
            motion.set(frame, &kinematics, &mut pose);
            let forces = dynamics.inverse(&kinematics, &pose, &velocity, &acceleration);
            for (values, of) in [
                (&mut all.velocities, &velocity),
                (&mut all.accelerations, &acceleration),
                (&mut all.forces, &forces),
            ] {
                values.extend(row(&pose.root, of));
            }
        }
        all
    }
}

/// A row in MuJoCo's layout: along the axes of the world, about the axes of the base, then the joints.
fn row(root: &Placement, rates: &Rates) -> Vec<f64> {
    let mut values = rates.linear.to_array().to_vec();
    values.extend((root.rotation.inverse() * rates.angular).to_array());
    values.extend(&rates.joints);
    values
}
