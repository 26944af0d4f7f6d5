//! Retargets the motion of an animal on four legs to a robot with four legs.
//!
//! The base follows the trunk. Each foot follows its paw relative to the hip, scaled by the ratio of the leg lengths. A
//! foot in stance is shifted to keep its place. The shift fades in while the foot is in the air before the stance, and
//! fades out after it. The solver of the first pass bends the legs within their limits. If a joint would then be too
//! fast, its movement starts earlier and ends later.

mod judge;

use glam::{DQuat, DVec3};
use mocap_figure::animal::{AnimalFrame, AnimalTrack, RETURN, shifts};
use mocap_figure::report::Quadruped;
use mocap_figure::robot_bones::sole::SoleBall;
use mocap_figure::{Creature, Figure};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::robot::{Placement, Robot};
use mocap_scene::scene::{Animation, Scene};

use super::collision::Collisions;
use super::feasibility::feasibility;
use super::floor::{Floor, smooth};
use super::four_legs::{RobotLeg, RobotLegs};
use super::kinematics::{Kinematics, RobotPose};
use super::measure::raised;
use super::motion::{RobotMotion, rate};
use super::of_scene::world_of_robot;
use super::retargeter::{FIRST_STEPS, RobotOptions, STEPS, continued, own_motion};
use super::robot_report::RobotReport;
use super::solver::{Bounds, Solver};
use super::speed::within_steps;
use super::terms::{Goals, Reach, RotationGoal, Terms};
use crate::Scale;

/// The weight of the base, in 1/rad^2 and 1/m^2: a hundredth of a foot's weight, so that feet come first.
const BASE: f64 = 3.0;

/// The weight of a foot's position, in 1/m^2. At the end of a leg, it outweighs the base.
const FOOT: f64 = 300.0;

/// The weight of the position of a knee, an ankle or a paw, in 1/m^2: a third of a foot's weight.
const JOINT: f64 = 100.0;

/// The weight of the rotation of a part that carries a leg, in 1/rad^2. It keeps the spine and the girdles near their
/// rest rotation.
const CARRIER: f64 = 1.0;

/// The weight of the change of a joint from the previous frame, in 1/rad^2. It decides only what the feet leave
/// undetermined.
const HOLD: f64 = 1e-3;

/// The weight of the base of a robot whose legs have the joints of an animal, in 1/rad^2 and 1/m^2. Otherwise its long
/// spine would bend instead of its legs.
const ANIMAL_BASE: f64 = 100.0;

/// The weight of the change of a joint of such a robot, in 1/rad^2. With a smaller weight, the many joints of its spine
/// let the solution jump between frames.
const ANIMAL_HOLD: f64 = 1.0;

/// The standard deviation of the Gaussian that smooths the base, in seconds. Captures are noisy, and the base is heavy.
const SMOOTH_BASE: f64 = 0.04;

/// The length of a robot's legs that is compared with an animal's legs, as a fraction of the straight leg. Robots stand
/// with bent knees. The value 0.83 comes from takes of a dog that other authors retargeted to a robot. With this value,
/// mocap's paths are as long as their paths.
const STANDING: f64 = 0.83;

/// The largest distance of a held foot from its paw, as a fraction of the leg. Bends of the spine move paws this far.
const FARTHEST_HELD: f64 = 0.3;

/// The fraction of the straight leg within which feet are held. The knee of a straight leg would jump.
const WITHIN_REACH: f64 = 0.97;

/// The largest height at which the file's floor counts as at height 0, as a fraction of the leg. Joints of paws are
/// above the floor.
const NEAR_ZERO: f64 = 0.15;

/// The largest velocity of a joint whose file states no limit, in rad/s. Motors of such robots reach 20 to 30.
const FASTEST: f64 = 25.0;

/// Retargets the motions of one animal to a robot with four legs.
#[derive(Clone, Debug)]
pub(crate) struct QuadrupedRetargeter {
    robot: Robot,
    kinematics: Kinematics,
    legs: RobotLegs,
    collisions: Collisions,
    options: RobotOptions,
    figure: Figure,
    animal: Quadruped,
}

/// The goals of the robot's base and feet in a frame.
#[derive(Clone, Copy, Debug)]
struct Wanted {
    base: Placement,
    feet: [DVec3; 4],
    /// The knee, the ankle and the paw of each leg with the joints of an animal, if each segment has the direction of
    /// the animal's segment.
    joints: [Option<[DVec3; 3]>; 4],
}

impl QuadrupedRetargeter {
    /// # Errors
    /// [`Code::NotHumanoid`] if the source is not an animal on four legs, or the robot does not have four legs.
    /// [`Code::InvalidValue`] for a time scale that the robot cannot have.
    pub(crate) fn new(source: &Scene, figure: Figure, robot: &Robot, options: &RobotOptions) -> Result<Self> {
        options.time_scale.check(robot)?;
        let kinematics = Kinematics::new(robot);
        let refused = |message: String| Diagnostic::new(Code::NotHumanoid, message);
        let legs = RobotLegs::new(robot, &kinematics).ok_or_else(|| {
            refused("the robot does not have four legs with three joints each below a trunk".to_owned())
        })?;
        let Some(animal) = figure.quadruped(source).cloned() else {
            let what = match (figure.humanoid.found, figure.humanoid.creature) {
                (true, _) => "a humanoid".to_owned(),
                (_, Some(Creature::FourLegged)) => "an animal on four legs whose legs were not found".to_owned(),
                (_, Some(creature)) => format!("{} ({})", creature.as_str(), figure.humanoid.reason),
                (_, None) => format!("not an animal on four legs: {}", figure.humanoid.reason),
            };
            let message = format!("the robot walks on four legs, and the source is {what}");
            return Err(refused(message)
                .help("choose the motion of an animal on four legs, or a robot with two legs")
                .into());
        };
        Ok(Self {
            collisions: Collisions::new(robot, &kinematics),
            robot: robot.clone(),
            kinematics,
            legs,
            options: options.clone(),
            figure,
            animal,
        })
    }

    /// Retargets an animation of `source` to the robot, and reports its quality. Also returns the source at the speed
    /// of the motion, if this speed is not the source's speed.
    ///
    /// # Errors
    /// [`Code::LimitExceeded`] if the time scale makes the motion far longer.
    pub(crate) fn clip(&self, source: &Scene, index: usize) -> Result<(RobotMotion, RobotReport, Option<Scene>)> {
        let animation = &source.animations[index];
        let mut track = AnimalTrack::new(source, animation, &self.figure, &self.animal);
        let scale = match self.options.scale {
            Scale::Factor(factor) => factor,
            Scale::Auto | Scale::None => 1.0,
        };
        let own = own_motion(&self.robot, (source, animation), &Bounds::of(&self.kinematics), scale);
        let own_world = own.as_ref().and_then(|_| world_of_robot(source));
        let mut motion = own.unwrap_or_else(|| self.follow(&track, animation));
        if let Some(to_world) = own_world {
            keep_world(&mut track, to_world, &motion);
        }
        motion.contacts = track.contacts.iter().map(|stands| [stands[0], stands[1]]).collect();
        motion.hind_contacts = track.contacts.iter().map(|stands| [stands[2], stands[3]]).collect();
        let steps = if own_world.is_some() {
            1.0
        } else {
            self.scales(&track).1
        };
        let soles = self.soles();
        let dynamics = |motion: &RobotMotion| feasibility(&self.robot, &self.kinematics, &soles, motion);
        let time_scale = self.options.time_scale;
        let Some(scaled) = time_scale.apply(&self.kinematics, (source, index), &motion, &[], &dynamics)? else {
            let report = self.report(&track, &motion, steps);
            return Ok((motion, report, None));
        };
        let (source, motion) = (scaled.source, scaled.motion);
        let mut track = AnimalTrack::new(&source, &source.animations[index], &self.figure, &self.animal);
        if let Some(to_world) = own_world {
            keep_world(&mut track, to_world, &motion);
        }
        let contacts = std::iter::zip(&motion.contacts, &motion.hind_contacts);
        track.contacts = contacts
            .map(|(front, hind)| [front[0], front[1], hind[0], hind[1]])
            .collect();
        let report = RobotReport {
            time_scale: scaled.speed,
            slowed_by: scaled.joint,
            ..self.report(&track, &motion, steps)
        };
        Ok((motion, report, Some(source)))
    }

    /// Retargets the motion of another body to the robot.
    fn follow(&self, track: &AnimalTrack, animation: &Animation) -> RobotMotion {
        let fps = animation.ticks_per_second;
        let mut wanted = self.wanted(track, fps);
        if self.options.lock_feet {
            self.hold(track, fps, &mut wanted);
        }
        let mut motion = RobotMotion {
            name: animation.name.clone(),
            fps: rate(fps),
            dof_names: self.robot.dof_names(),
            ..RobotMotion::default()
        };
        self.solve(&wanted, &mut motion);
        self.slow_down(&mut motion);
        if self.options.floor != Floor::Keep {
            let lowest: Vec<f64> = self.heights(&motion).iter().map(lowest).collect();
            let raised = raised(&lowest, motion.fps);
            for (root, raised) in motion.root.iter_mut().zip(raised) {
                root.translation.z += raised;
            }
        }
        motion
    }

    /// The factors of heights and steps relative to the source.
    fn scales(&self, track: &AnimalTrack) -> (f64, f64) {
        let of_leg = |(index, leg): (usize, &RobotLeg)| match leg.segments(&track.frames[0], index) {
            Some((leg, _)) => leg.lengths.iter().sum(),
            None => STANDING * leg.reach,
        };
        let length = 0.25 * self.legs.legs.iter().enumerate().map(of_leg).sum::<f64>();
        let by_legs = length / track.leg.max(f64::EPSILON);
        let steps = match self.options.scale {
            Scale::Auto => by_legs,
            Scale::None => 1.0,
            Scale::Factor(factor) => factor,
        };
        (by_legs, steps)
    }

    fn wanted(&self, track: &AnimalTrack, fps: f64) -> Vec<Wanted> {
        let (height, steps) = self.scales(track);
        let along = DVec3::new(steps, steps, height);
        let legs = &self.legs.legs;
        let floor = self.floor(track);
        let hips = 0.25 * legs.iter().map(|leg| leg.hip).sum::<DVec3>();
        let frames = track.frames.iter();
        let mut rotations: Vec<DQuat> = frames.clone().map(|frame| frame.rotation).collect();
        for index in 1..rotations.len() {
            if rotations[index].dot(rotations[index - 1]) < 0.0 {
                rotations[index] = -rotations[index];
            }
        }
        let deviation = SMOOTH_BASE * fps;
        let parts = [0, 1, 2, 3].map(|part| {
            let values: Vec<f64> = rotations.iter().map(|rotation| rotation.to_array()[part]).collect();
            smooth(&values, deviation)
        });
        let above = |frame: &AnimalFrame| {
            let heights = (0..4).map(|index| frame.hips[index].z - track.ground[index]);
            0.25 * heights.sum::<f64>()
        };
        let middles: Vec<DVec3> = frames
            .clone()
            .map(|frame| along * DVec3::new(frame.centre.x, frame.centre.y, above(frame)))
            .collect();
        let middles = [0, 1, 2].map(|axis| {
            let values: Vec<f64> = middles.iter().map(|middle| middle[axis]).collect();
            smooth(&values, deviation)
        });
        // The height of paws above the floor.
        let below = |leg: &RobotLeg| leg.below_foot - leg.of_animal.as_ref().map_or(0.0, |leg| leg.sole.z);
        let radius = 0.25 * legs.iter().map(below).sum::<f64>();
        frames
            .enumerate()
            .map(|(at, frame)| {
                let rotation = DQuat::from_array(std::array::from_fn(|part| parts[part][at])).normalize();
                let middle = DVec3::new(middles[0][at], middles[1][at], middles[2][at] + radius + floor);
                let base = Placement {
                    rotation,
                    translation: middle - rotation * hips,
                };
                let mut joints = [None; 4];
                let feet = std::array::from_fn(|index| {
                    let hip = base.point(legs[index].hip);
                    let paw = match legs[index].segments(frame, index) {
                        Some((leg, [thigh, shin, foot])) => {
                            let knee = leg.lengths[0] * thigh;
                            let ankle = knee + leg.lengths[1] * shin;
                            let paw = ankle + leg.lengths[2] * foot;
                            joints[index] = Some([knee, ankle, paw].map(|joint| hip + joint));
                            paw + rotation * leg.sole
                        }
                        None => along * (frame.paws[index] - frame.hips[index]),
                    };
                    let rise = height * (frame.paws[index].z - track.ground[index]);
                    let z = legs[index].below_foot + floor + rise;
                    within(hip, (hip + paw).with_z(z), legs[index].reach)
                });
                Wanted { base, feet, joints }
            })
            .collect()
    }

    /// The height on which paws rest. It differs from 0 only under two conditions: the option puts the floor at height
    /// 0 of the file, and the joints of resting paws are not near this height.
    fn floor(&self, track: &AnimalTrack) -> f64 {
        let lowest = track.ground.iter().copied().fold(f64::INFINITY, f64::min);
        match self.options.floor {
            Floor::Zero if lowest.abs() > NEAR_ZERO * track.leg => self.scales(track).0 * lowest,
            _ => 0.0,
        }
    }

    /// Keeps feet in stance at their place. The shift fades out in the air.
    fn hold(&self, track: &AnimalTrack, fps: f64, wanted: &mut [Wanted]) {
        let floor = self.floor(track);
        for (index, leg) in self.legs.legs.iter().enumerate() {
            let ground = leg.below_foot + floor;
            let stands: Vec<bool> = track.contacts.iter().map(|contacts| contacts[index]).collect();
            let feet: Vec<DVec3> = wanted.iter().map(|wanted| wanted.feet[index]).collect();
            let shifts = shifts(&stands, &feet, Some(ground), FARTHEST_HELD * leg.reach, RETURN * fps);
            for (wanted, shift) in wanted.iter_mut().zip(shifts) {
                wanted.feet[index] += shift;
                wanted.feet[index].z = wanted.feet[index].z.max(ground);
            }
        }
    }

    fn solve(&self, wanted: &[Wanted], motion: &mut RobotMotion) {
        let legs = &self.legs.legs;
        let (base, hold) = match legs.iter().any(|leg| leg.of_animal.is_some()) {
            true => (ANIMAL_BASE, ANIMAL_HOLD),
            false => (BASE, HOLD),
        };
        let mut goals = Goals {
            rotations: vec![RotationGoal {
                body: 0,
                weight_axes: DQuat::IDENTITY,
                weights: DVec3::splat(base),
                target: DQuat::IDENTITY,
            }],
            reaches: Vec::new(),
            clearances: [0.0; 2],
        };
        let reach = |body: usize, point: DVec3, weight: f64| Reach {
            body,
            point,
            weight: DVec3::splat(weight),
            target: DVec3::ZERO,
        };
        let hips = 0.25 * legs.iter().map(|leg| leg.hip).sum::<DVec3>();
        goals.reaches.push(reach(0, hips, base));
        goals
            .reaches
            .extend(legs.iter().map(|leg| reach(leg.body(), leg.foot, FOOT)));
        let mut carriers: Vec<DQuat> = Vec::new();
        for leg in legs.iter().filter_map(|leg| leg.of_animal.as_ref()) {
            for &(body, rotation) in &leg.carriers {
                carriers.push(rotation);
                goals.rotations.push(RotationGoal {
                    body,
                    weight_axes: DQuat::IDENTITY,
                    weights: DVec3::splat(CARRIER),
                    target: rotation,
                });
            }
        }
        for (leg, joints) in legs
            .iter()
            .zip(wanted.first().map_or([None; 4], |wanted| wanted.joints))
        {
            let parts = leg
                .of_animal
                .iter()
                .filter(|_| joints.is_some())
                .flat_map(|leg| &leg.parts[1..4]);
            goals
                .reaches
                .extend(parts.map(|(body, point)| reach(*body, *point, JOINT)));
        }
        let mut solver = Solver::new(Terms::new(&self.kinematics, &goals), hold);
        let mut pose = self.kinematics.rest();
        // For each foot: the depth of the sole's lowest point below the goal of the sole's middle, less this depth at a
        // straight leg.
        let mut sunk = [0.0; 4];
        for (frame, wanted) in wanted.iter().enumerate() {
            goals.rotations[0].target = wanted.base.rotation;
            goals.reaches[0].target = wanted.base.point(hips);
            for (index, foot) in wanted.feet.iter().enumerate() {
                goals.reaches[index + 1].target = *foot + sunk[index] * DVec3::Z;
            }
            for (goal, rotation) in goals.rotations[1..].iter_mut().zip(&carriers) {
                goal.target = wanted.base.rotation * *rotation;
            }
            let joints = legs.iter().zip(&wanted.joints).zip(&wanted.feet);
            let joints = joints.filter_map(|((leg, joints), foot)| {
                let (leg, joints) = (leg.of_animal.as_ref()?, (*joints)?);
                let paw = *foot - wanted.base.rotation * leg.sole;
                Some(leg.ending_at(joints, paw))
            });
            for (reach, joint) in goals.reaches[5..].iter_mut().zip(joints.flatten()) {
                reach.target = joint;
            }
            if frame == 0 {
                pose.root = wanted.base;
                let feet = wanted.feet.map(|foot| wanted.base.to_inner(foot));
                self.legs.begin(&self.kinematics, &mut pose, feet);
            }
            let steps = if frame == 0 { FIRST_STEPS } else { STEPS };
            solver.solve(&self.kinematics, &goals, &self.legs.bounds, &mut pose, steps);
            for (sunk, leg) in sunk.iter_mut().zip(legs) {
                *sunk = leg.foot_above_sole(&pose) - leg.below_foot;
            }
            motion.root.push(continued(pose.root, motion.root.last()));
            motion.dof_pos.extend(&pose.positions);
        }
    }

    /// Keeps joints within the velocities of the robot's file, and below the threshold of a jump.
    fn slow_down(&self, motion: &mut RobotMotion) {
        let (count, speed) = (motion.dof_names.len(), self.options.time_scale.while_solved());
        for (position, body) in self.kinematics.bodies[1..].iter().enumerate() {
            let most = match body.limits.velocity.filter(|most| *most > 0.0) {
                // The time scale follows from the velocities of the path.
                Some(_) if speed == 0.0 => continue,
                Some(most) => (most / speed).min(most.max(FASTEST)),
                None => FASTEST,
            };
            let most = most / motion.fps;
            let mut values: Vec<f64> = motion.dof_pos.iter().skip(position).step_by(count).copied().collect();
            within_steps(&mut values, |_| most);
            for (at, value) in motion.dof_pos.iter_mut().skip(position).step_by(count).zip(values) {
                *at = value;
            }
        }
    }

    fn soles(&self) -> Vec<(usize, Vec<SoleBall>)> {
        let legs = self.legs.legs.iter();
        legs.map(|leg| (leg.body(), leg.sole.clone())).collect()
    }

    /// Calls `see` with each pose of a motion.
    fn poses(&self, motion: &RobotMotion, mut see: impl FnMut(usize, &RobotPose)) {
        let mut pose = self.kinematics.rest();
        for frame in 0..motion.frames() {
            motion.set(frame, &self.kinematics, &mut pose);
            see(frame, &pose);
        }
    }

    /// The heights of the soles in each frame.
    fn heights(&self, motion: &RobotMotion) -> Vec<[f64; 4]> {
        let mut heights = Vec::with_capacity(motion.frames());
        self.poses(motion, |_, pose| {
            heights.push(self.legs.legs.each_ref().map(|leg| leg.sole_height(pose)));
        });
        heights
    }
}

/// Compares the robot's own motion in the axes of its file, and relative to its base.
fn keep_world(track: &mut AnimalTrack, to_world: DQuat, motion: &RobotMotion) {
    track.turn(to_world);
    for (frame, root) in std::iter::zip(&mut track.frames, &motion.root) {
        frame.rotation = root.rotation;
    }
}

fn lowest(heights: &[f64; 4]) -> f64 {
    heights.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Moves a foot's position within the reach of its leg.
fn within(hip: DVec3, foot: DVec3, reach: f64) -> DVec3 {
    hip + (foot - hip).clamp_length_max(WITHIN_REACH * reach)
}
