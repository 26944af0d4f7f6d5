//! Checks whether a robot can perform a motion. Inverse dynamics gives the forces that the floor and the motors cannot
//! provide.

use std::fmt;

use glam::{DVec2, DVec3};
use mocap_scene::math::hull::convex_hull;
use mocap_scene::math::median::ranked;
use mocap_scene::scene::robot::{JointKind, Robot};
use serde::{Deserialize, Serialize};

use super::cones::Cones;
use super::dynamics::{Dynamics, GRAVITY, Rates, rates};
use super::kinematics::{Kinematics, RobotPose};
use super::motion::RobotMotion;
use mocap_figure::robot_bones::sole::SoleBall;

/// The height below which a point of a sole touches the floor, in metres.
const TOUCHING: f64 = 0.02;

/// The largest residual force of a feasible frame, as a fraction of the weight. Masses of models have an error of this
/// size.
const SPARE_FORCE: f64 = 0.1;

/// The largest residual moment of a feasible frame, as a lever arm of the weight in metres: less than half of a sole.
const SPARE_LEVER: f64 = 0.05;

/// The distance above which a centre of pressure is outside the soles, in metres. Smaller distances are rounding of
/// shapes.
const OUTSIDE: f64 = 0.01;

/// The fraction of the weight above which the floor has a centre of pressure. With a smaller load, its position is
/// arbitrary.
const CARRIED: f64 = 0.1;

/// The percentile of the reported residuals, as a fraction.
const PERCENTILE: f64 = 0.95;

/// The smallest height of the centre of mass that is used as the unit of moments, in metres.
const LOWEST: f64 = 0.2;

/// Whether a robot can perform a motion, by inverse dynamics with its masses. Only the soles have contacts.
///
/// The [module](crate::robot) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Feasibility {
    /// The mass of the robot, in kilograms.
    pub mass: f64,
    /// The fraction of feasible frames. In a feasible frame, soles on the floor with a friction of 1 leave a residual
    /// force at the base of at most 10 % of the weight. The residual moment is at most the weight times a lever arm of
    /// 5 cm.
    pub fraction_feasible: f64,
    /// The main cause of infeasible frames; absent if all frames are feasible.
    pub main_cause: Option<InfeasibleCause>,
    /// The residual force at the base that contacts do not provide, as a fraction of the weight: the 95th percentile.
    pub residual_force: f64,
    /// The residual moment at the base that contacts do not provide, as a lever arm of the weight in metres: the 95th
    /// percentile.
    pub residual_lever: f64,
    /// Of the frames in which soles carry the robot, the fraction whose centre of pressure would have to be more than 1
    /// cm outside the soles. Absent if soles never carry the robot.
    pub fraction_pressure_outside: Option<f64>,
    /// The fraction of samples in which a joint needs more torque than the robot's file allows; absent if the file
    /// states no efforts.
    pub fraction_over_effort: Option<f64>,
    /// The largest torque of a joint, as a multiple of its effort in the robot's file.
    pub max_effort: f64,
    /// The joint with the torque `max_effort`.
    pub most_loaded_joint: String,
}

/// The cause of an infeasible frame.
///
/// The [module](crate::robot) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum InfeasibleCause {
    /// No sole is on the floor, and the robot does not fall.
    NoSoleOnFloor,
    /// The centre of pressure would have to be outside the soles.
    PressureOutside,
    /// The floor would have to pull, or hold more than its friction.
    FloorForce,
}

impl InfeasibleCause {
    /// All causes.
    const ALL: [Self; 3] = [Self::NoSoleOnFloor, Self::PressureOutside, Self::FloorForce];

    /// The name of the cause, as in JSON.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::NoSoleOnFloor => "no-sole-on-floor",
            Self::PressureOutside => "pressure-outside",
            Self::FloorForce => "floor-force",
        }
    }
}

impl fmt::Display for InfeasibleCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoSoleOnFloor => "no sole is on the floor",
            Self::PressureOutside => "the centre of pressure is outside the soles",
            Self::FloorForce => "it needs more force than the floor gives",
        })
    }
}

/// The contacts that carry a robot.
struct Support<'a> {
    kinematics: &'a Kinematics,
    soles: &'a [(usize, Vec<SoleBall>)],
    cones: Cones,
    /// The points in contact, each with its body.
    touching: Vec<(usize, DVec3)>,
}

/// The force and moment of a frame that the contacts do not provide.
struct Residual {
    force: f64,
    lever: f64,
    /// Whether a sole is on the floor.
    touches: bool,
    /// The vector from the soles to the centre of pressure outside them.
    outside: Option<DVec2>,
}

impl Residual {
    /// The cause, if the frame is infeasible.
    fn cause(&self) -> Option<InfeasibleCause> {
        match (self.force <= SPARE_FORCE, self.lever <= SPARE_LEVER) {
            (true, true) => None,
            _ if !self.touches => Some(InfeasibleCause::NoSoleOnFloor),
            (false, _) => Some(InfeasibleCause::FloorForce),
            (true, false) => Some(InfeasibleCause::PressureOutside),
        }
    }
}

/// Whether a robot with these soles can perform a motion; `None` if its file states no masses, or for fewer than three
/// frames.
pub(super) fn feasibility(
    robot: &Robot,
    kinematics: &Kinematics,
    soles: &[(usize, Vec<SoleBall>)],
    motion: &RobotMotion,
) -> Option<Feasibility> {
    let mut support = Support::new(kinematics, soles);
    let mut efforts = Efforts::new(robot);
    let mut residuals = Vec::with_capacity(motion.frames());
    let mass = each_frame(robot, kinematics, motion, |dynamics, pose, mut forces| {
        residuals.push(support.carry(dynamics, pose, &mut forces));
        efforts.add(&forces.joints);
    })?;
    let causes: Vec<InfeasibleCause> = residuals.iter().filter_map(Residual::cause).collect();
    let count = |cause: &InfeasibleCause| causes.iter().filter(|found| *found == cause).count();
    let feasible = residuals.len() - causes.len();
    let pressures = residuals.iter().filter_map(|residual| residual.outside);
    let pressures: Vec<f64> = pressures.map(DVec2::length).collect();
    let outside = pressures.iter().filter(|outside| **outside > OUTSIDE).count();
    Some(Feasibility {
        mass,
        fraction_feasible: feasible as f64 / residuals.len().max(1) as f64,
        main_cause: InfeasibleCause::ALL
            .into_iter()
            .filter(|cause| count(cause) > 0)
            .max_by_key(count),
        residual_force: largest(residuals.iter().map(|residual| residual.force)),
        residual_lever: largest(residuals.iter().map(|residual| residual.lever)),
        fraction_pressure_outside: (!pressures.is_empty()).then(|| outside as f64 / pressures.len() as f64),
        fraction_over_effort: efforts.fraction(),
        most_loaded_joint: efforts.most_loaded(robot),
        max_effort: efforts.greatest.0,
    })
}

/// The vector from the soles to the centre of pressure outside them in each frame, in metres: 0 if the floor does not
/// carry the robot. The last value is the mean height of the centre of mass. `None` as for [`feasibility`].
pub(super) fn pressures(
    robot: &Robot,
    kinematics: &Kinematics,
    soles: &[(usize, Vec<SoleBall>)],
    motion: &RobotMotion,
) -> Option<(Vec<DVec2>, f64)> {
    let mut support = Support::new(kinematics, soles);
    let (mut found, mut height) = (Vec::with_capacity(motion.frames()), 0.0);
    each_frame(robot, kinematics, motion, |dynamics, pose, forces| {
        support.touch(pose);
        let load = FloorLoad::new(dynamics, pose, &forces);
        found.push(support.pressure(&load).unwrap_or_default());
        height += load.centre.z / motion.frames() as f64;
    })?;
    Some((found, height))
}

/// Calls `take` with each frame of a motion and its forces by inverse dynamics. Returns the mass of the robot; `None`
/// as for [`feasibility`].
fn each_frame(
    robot: &Robot,
    kinematics: &Kinematics,
    motion: &RobotMotion,
    mut take: impl FnMut(&Dynamics, &RobotPose, Rates),
) -> Option<f64> {
    let mut dynamics = Dynamics::new(robot, kinematics);
    let mass = dynamics.mass();
    if !(mass > 0.0 && mass.is_finite()) {
        return None;
    }
    let mut pose = kinematics.rest();
    for frame in 0..motion.frames() {
        motion.set(frame, kinematics, &mut pose);
        let (velocity, acceleration) = rates(motion, frame)?;
        let forces = dynamics.inverse(kinematics, &pose, &velocity, &acceleration);
        take(&dynamics, &pose, forces);
    }
    Some(mass)
}

/// The load on the floor.
struct FloorLoad {
    /// The centre of mass.
    centre: DVec3,
    weight: f64,
    force: DVec3,
    /// The moment about the centre of mass.
    moment: DVec3,
}

impl FloorLoad {
    fn new(dynamics: &Dynamics, pose: &RobotPose, forces: &Rates) -> Self {
        let centre = dynamics.centre(pose);
        Self {
            centre,
            weight: dynamics.mass() * GRAVITY,
            force: forces.linear,
            moment: forces.angular + (pose.root.translation - centre).cross(forces.linear),
        }
    }
}

impl<'a> Support<'a> {
    fn new(kinematics: &'a Kinematics, soles: &'a [(usize, Vec<SoleBall>)]) -> Self {
        Self {
            kinematics,
            soles,
            cones: Cones::default(),
            touching: Vec::new(),
        }
    }

    /// The vector from the points in contact to the centre of pressure outside them; `None` if the floor does not carry
    /// the robot.
    fn pressure(&self, load: &FloorLoad) -> Option<DVec2> {
        let FloorLoad {
            centre, force, moment, ..
        } = *load;
        if force.z <= CARRIED * load.weight || self.touching.is_empty() {
            return None;
        }
        let away = DVec2::new(moment.y + centre.z * force.x, centre.z * force.y - moment.x);
        let points = self.touching.iter().map(|(_, point)| point.truncate());
        Some(outside(points.collect(), centre.truncate() - away / force.z))
    }

    /// Lets the floor carry the robot as far as possible. Subtracts the contact forces from the torques of joints, and
    /// returns the residual at the base.
    fn carry(&mut self, dynamics: &Dynamics, pose: &RobotPose, forces: &mut Rates) -> Residual {
        let load = FloorLoad::new(dynamics, pose, forces);
        let FloorLoad {
            centre, weight, moment, ..
        } = load;
        let unit = centre.z.max(LOWEST);
        self.touch(pose);
        self.cones
            .set(self.touching.iter().map(|(_, point)| (*point - centre) / unit));
        let (given, force, lever) = self.cones.reach(forces.linear / weight, moment / (weight * unit));
        for ((body, point), given) in self.touching.iter().zip(given) {
            for &joint in &self.kinematics.bodies[*body].chain {
                let (axis, anchor) = self.kinematics.axis(pose, joint);
                forces.joints[joint - 1] -= weight
                    * match self.kinematics.bodies[joint].kind {
                        JointKind::Slide => axis.dot(given),
                        _ => axis.dot((*point - anchor).cross(given)),
                    };
            }
        }
        Residual {
            force: force.length(),
            lever: unit * lever.length(),
            touches: !self.touching.is_empty(),
            outside: self.pressure(&load),
        }
    }

    /// Finds the points of the soles that touch the floor.
    fn touch(&mut self, pose: &RobotPose) {
        self.touching.clear();
        for (body, balls) in self.soles {
            let points = balls
                .iter()
                .map(|ball| pose.bodies[*body].point(ball.centre) - ball.radius * DVec3::Z);
            let touching = points.filter(|point| point.z < TOUCHING);
            self.touching.extend(touching.map(|point| (*body, point)));
        }
    }
}

/// The torques of joints, relative to their efforts in the robot's file.
struct Efforts {
    limits: Vec<Option<f64>>,
    over: usize,
    samples: usize,
    /// The largest multiple of an effort, and the index of the joint.
    greatest: (f64, Option<usize>),
}

impl Efforts {
    fn new(robot: &Robot) -> Self {
        let joints = robot.moving_joints().into_iter();
        Self {
            limits: joints.map(|link| robot.links[link].joint.limits.effort).collect(),
            over: 0,
            samples: 0,
            greatest: (0.0, None),
        }
    }

    fn add(&mut self, torques: &[f64]) {
        for (index, (torque, limit)) in torques.iter().zip(&self.limits).enumerate() {
            let Some(limit) = limit else { continue };
            let load = torque.abs() / limit;
            self.samples += 1;
            self.over += usize::from(load > 1.0);
            if load > self.greatest.0 {
                self.greatest = (load, Some(index));
            }
        }
    }

    fn fraction(&self) -> Option<f64> {
        (self.samples > 0).then(|| self.over as f64 / self.samples as f64)
    }

    fn most_loaded(&self, robot: &Robot) -> String {
        let joint = self.greatest.1.map(|index| robot.moving_joints()[index]);
        joint.map_or_else(String::new, |link| robot.links[link].joint.name.clone())
    }
}

/// The [`PERCENTILE`] of the values.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    let count = (PERCENTILE * values.len() as f64).ceil() as usize;
    ranked(&mut values, count.saturating_sub(1)).unwrap_or_default()
}

/// The vector from the convex hull of at least one point to a point outside the hull.
pub fn outside(mut points: Vec<DVec2>, at: DVec2) -> DVec2 {
    let hull = convex_hull(&mut points);
    if hull.is_empty() {
        return points.first().map_or(DVec2::ZERO, |point| at - *point);
    }
    let edges = hull.iter().zip(hull.iter().cycle().skip(1));
    let is_inside = hull.len() > 2 && edges.clone().all(|(a, b)| (*b - *a).perp_dot(at - *a) >= 0.0);
    if is_inside {
        return DVec2::ZERO;
    }
    let away = |(a, b): (&DVec2, &DVec2)| {
        let along = ((at - *a).dot(*b - *a) / (*b - *a).length_squared()).clamp(0.0, 1.0);
        at - *a - if along.is_finite() { along } else { 0.0 } * (*b - *a)
    };
    let nearest = edges.map(away).min_by(|a, b| a.length().total_cmp(&b.length()));
    nearest.unwrap_or_default()
}
