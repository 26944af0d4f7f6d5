//! A robot that follows a motion as it arrives. Each pose is solved from the previous pose, without future frames.

use mocap_scene::error::Result;
use mocap_scene::pose::Pose;
use mocap_scene::scene::Scene;
use mocap_scene::scene::robot::{Placement, Robot};

use super::super::kinematics::RobotPose;
use super::super::solver::Bounds;
use super::{FIRST_STEPS, RobotOptions, RobotRetargeter, STEPS, continued};

/// Retargets poses of a source to a robot, one after the other. Unlike a clip, a stream does not lock feet in contact,
/// and does not use future frames for smoothness. A stream keeps the limits of joints, and soles above the floor.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::retarget::robot::{RobotOptions, RobotStream};
/// use mocap::{Conversion, Importer, Pose};
///
/// let mut walk = mocap::import("fixtures/real/cmu_short.bvh")?;
/// Conversion::new().apply(&mut walk)?;
/// let robot = Importer::new().import_robot("fixtures/robots/h1.urdf")?;
/// let mut stream = RobotStream::new(&walk, &robot, &RobotOptions::new())?;
/// let pose = Pose::at_tick(&walk, 0, 10.0).unwrap();
/// let (base, positions) = stream.pose(&pose, 0.01);
/// assert_eq!(positions.len(), robot.dof_names().len());
/// assert!(base.translation.z > 0.5);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct RobotStream {
    retargeter: RobotRetargeter,
    limits: Bounds,
    twin: Pose,
    pose: RobotPose,
    before: Option<Placement>,
}

impl RobotStream {
    /// Prepares to retarget poses of the skeleton of `source` to `robot`. Options for clips have no effect.
    ///
    /// # Errors
    /// The errors of [`RobotRetargeter::new`].
    pub fn new(source: &Scene, robot: &Robot, options: &RobotOptions) -> Result<Self> {
        let retargeter = RobotRetargeter::new(source, robot, options)?;
        Ok(Self {
            limits: retargeter.limits(),
            twin: Pose::rest(&retargeter.twin.scene),
            pose: retargeter.kinematics.rest(),
            before: None,
            retargeter,
        })
    }

    /// The base, in metres with +Z up, and the positions of the joints for a pose of the source, which is `seconds`
    /// after the previous pose.
    pub fn pose(&mut self, source: &Pose, seconds: f64) -> (Placement, &[f64]) {
        let Self {
            retargeter, twin, pose, ..
        } = self;
        retargeter.retargeter.pose(source, twin);
        retargeter.following.aim(twin, 0.0);
        // Raises soles that are below the floor.
        let lowest = retargeter.following.heights().into_iter().fold(f64::INFINITY, f64::min);
        if lowest < 0.0 {
            retargeter.following.aim(twin, lowest);
        }
        let (bounds, steps) = match self.before {
            None => {
                retargeter.begin(pose);
                (self.limits.clone(), FIRST_STEPS)
            }
            Some(_) => (
                retargeter.reachable(&self.limits, pose, seconds.max(SHORTEST).recip()),
                STEPS,
            ),
        };
        let goals = &retargeter.following.goals;
        retargeter
            .solver
            .solve(&retargeter.kinematics, goals, &bounds, pose, steps);
        let root = match retargeter.following.stand {
            Some(stand) => stand,
            None => continued(pose.root, self.before.as_ref()),
        };
        self.before = Some(root);
        (root, &self.pose.positions)
    }
}

/// The smallest time between two poses that limits the steps of joints, in seconds.
const SHORTEST: f64 = 1e-4;
