//! Motions of the robot itself, and the start of a motion.

use glam::DVec3;
use mocap_scene::scene::robot::{Placement, Robot};
use mocap_scene::scene::{Animation, Scene};

use super::super::kinematics::RobotPose;
use super::super::motion::RobotMotion;
use super::super::solver::Bounds;
use super::RobotRetargeter;

/// The largest difference from 1 of the scale for a motion of the robot itself: the rounding of a scene.
const SAME_SCALE: f64 = 1e-3;

/// The largest excess over a limit in a motion of the robot itself, in radians or metres: the rounding of files.
const SAME_POSITION: f64 = 1e-4;

/// The unchanged motion, if the robot itself moves in it within `limits`. `scale` is the wanted factor of the steps.
pub(in super::super) fn own_motion(
    robot: &Robot,
    (source, animation): (&Scene, &Animation),
    limits: &Bounds,
    scale: f64,
) -> Option<RobotMotion> {
    let is_as_long = (scale - 1.0).abs() < SAME_SCALE;
    let mut given = RobotMotion::of_same_robot(robot, source, animation).filter(|_| is_as_long)?;
    let joints = given.dof_names.len();
    for (index, position) in given.dof_pos.iter_mut().enumerate() {
        let (lower, upper) = (limits.lower[index % joints], limits.upper[index % joints]);
        let kept = position.max(lower).min(upper);
        if (kept - *position).abs() > SAME_POSITION {
            return None;
        }
        *position = kept;
    }
    Some(given)
}

impl RobotRetargeter {
    /// The unchanged motion, if the robot itself moves in it, and no map states other bones.
    pub(super) fn own_motion(&self, source: &Scene, animation: &Animation) -> Option<RobotMotion> {
        let own = || {
            own_motion(
                &self.robot,
                (source, animation),
                &self.limits(),
                self.retargeter.scale(),
            )
        };
        self.options.map.is_empty().then(own).flatten()
    }

    /// Moves the base so that the hips have their wanted position.
    pub(super) fn begin(&self, pose: &mut RobotPose) {
        let Some((turn, reach)) = self.following.hips() else {
            return;
        };
        let transform = pose.bodies[turn.body];
        let rotation = (turn.target * transform.rotation.inverse()).normalize();
        pose.root = Placement {
            rotation: (rotation * pose.root.rotation).normalize(),
            translation: DVec3::ZERO,
        };
        self.kinematics.update(pose);
        pose.root.translation = reach.target - pose.bodies[reach.body].point(reach.point);
        self.kinematics.update(pose);
    }
}
