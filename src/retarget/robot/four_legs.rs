//! Finds the four legs of a robot, by the shape of its tree.

use glam::{DQuat, DVec3};
use mocap_figure::animal::AnimalFrame;
use mocap_figure::robot_bones::sole::{SoleBall, lowest_point, sole};
use mocap_figure::robot_bones::{sort_legs, standing_limbs};
use mocap_scene::scene::HumanoidBone as Bone;
use mocap_scene::scene::robot::Robot;

use super::kinematics::{Kinematics, RobotPose};
use super::solver::Bounds;
use crate::animal::SEGMENTS;

/// The smallest distance between the hips of front and hind legs, as a fraction of the leg. Legs of insects begin at
/// one place.
const APART: f64 = 0.4;

/// The smallest cosine of the angle between the sideways direction and the axis of a joint that swings or bends the
/// leg.
const SIDEWAYS: f64 = 0.8;

/// The smallest distance between two joints that bend a leg, as a fraction of the leg.
const BETWEEN: f64 = 0.08;

/// The number of steps in which the range of a joint is searched, of at most 7.5 degrees.
const STEPS: usize = 48;

/// The largest angle of the search, in radians, for joints without limits.
const LARGEST: f64 = std::f64::consts::PI;

/// The bend of a knee to either side at which both sides are compared, in radians: the bend of a stance.
const BENT: f64 = 1.2;

/// The smallest range of a knee on both sides of a straight leg at which there is a choice, in radians. A smaller range
/// is play at a stop.
const BOTH_SIDES: f64 = 0.3;

/// The distance of a hip from its limits above which a larger distance is no better, in radians: the swing of a step.
const ENOUGH: f64 = 0.5;

/// The smallest distance of a knee from a straight leg, in radians. Beyond the straight leg, it would bend to the other
/// side.
const NOT_STRAIGHT: f64 = 0.05;

/// A leg of a robot.
#[derive(Clone, Debug)]
pub(super) struct RobotLeg {
    /// The bodies of the leg's joints, from the trunk outwards.
    pub(super) bodies: Vec<usize>,
    /// The bodies of the joint that swings the leg, and of the knee.
    bends: [usize; 2],
    /// The lower parts of a leg with the joints of an animal.
    pub(super) of_animal: Option<AnimalLeg>,
    /// The position of the joint that swings the leg, with all joints at 0, in the frame of the base.
    pub(super) hip: DVec3,
    /// The middle of the sole, in the frame of the last body.
    pub(super) foot: DVec3,
    pub(super) sole: Vec<SoleBall>,
    /// Whether shapes of the robot's file show the sole.
    pub(super) is_shown: bool,
    /// The distance from the hip to the foot of the straight leg.
    pub(super) reach: f64,
    /// The height of the middle of the sole above its lowest point, with all joints at 0.
    pub(super) below_foot: f64,
}

impl RobotLeg {
    pub(super) fn foot_in(&self, pose: &RobotPose) -> DVec3 {
        pose.bodies[self.body()].point(self.foot)
    }

    /// The height of the lowest point of the sole.
    pub(super) fn sole_height(&self, pose: &RobotPose) -> f64 {
        lowest_point(&self.sole, &pose.bodies[self.body()])
    }

    /// The height of the middle of the sole above its lowest point.
    pub(super) fn foot_above_sole(&self, pose: &RobotPose) -> f64 {
        self.foot_in(pose).z - self.sole_height(pose)
    }

    /// The leg with the joints of an animal, and the directions of thigh, shin and foot of the leg `index` of an
    /// animal.
    pub(super) fn segments(&self, frame: &AnimalFrame, index: usize) -> Option<(&AnimalLeg, [DVec3; 3])> {
        let leg = self.of_animal.as_ref()?;
        let bones: [DVec3; 3] = frame.bones(index).try_into().ok()?;
        Some((leg, bones.map(DVec3::normalize_or_zero)))
    }

    /// The bones of a report with their directions on the robot, and on the leg `index` of the animal.
    pub(super) fn directions(&self, pose: &RobotPose, frame: &AnimalFrame, index: usize) -> Vec<(Bone, DVec3, DVec3)> {
        let Some((leg, directions)) = self.segments(frame, index) else {
            let is = pose.root.to_inner(self.foot_in(pose)) - self.hip;
            return vec![(SEGMENTS[index][0], is, frame.leg(index))];
        };
        let at = leg.parts.map(|(body, point)| pose.bodies[body].point(point));
        let parts = directions.into_iter().enumerate();
        parts
            .map(|(part, was)| (SEGMENTS[index][part], at[part + 1] - at[part], was))
            .collect()
    }

    pub(super) fn body(&self) -> usize {
        self.bodies[self.bodies.len() - 1]
    }

    /// The indices of two positions: of the joint that swings the leg, and of the knee.
    pub(super) fn hinges(&self) -> [usize; 2] {
        self.bends.map(|body| body - 1)
    }
}

/// A leg with the joints of an animal: below the knee, an ankle and a paw bend.
#[derive(Clone, Debug)]
pub(super) struct AnimalLeg {
    /// The bodies that begin at the hip, the knee, the ankle and the paw, each with the point of its joint.
    pub(super) parts: [(usize, DVec3); 4],
    /// The lengths from each joint to the next.
    pub(super) lengths: [f64; 3],
    /// The vector from the paw to the middle of the sole, with all joints at 0.
    pub(super) sole: DVec3,
    /// The bodies of the trunk and of the girdle that carry the leg, with their rotations with all joints at 0.
    pub(super) carriers: Vec<(usize, DQuat)>,
}

impl AnimalLeg {
    /// The knee, the ankle and the paw, with the paw at the given place. The shift of a joint is proportional to its
    /// distance from the hip along the leg. So no segment rotates much.
    pub(super) fn ending_at(&self, joints: [DVec3; 3], paw: DVec3) -> [DVec3; 3] {
        let shift = (paw - joints[2]) / self.lengths.iter().sum::<f64>();
        let mut along = 0.0;
        std::array::from_fn(|part| {
            along += self.lengths[part];
            joints[part] + along * shift
        })
    }
}

/// The four legs of a robot: the left and the right front leg, the left and the right hind leg.
#[derive(Clone, Debug)]
pub(super) struct RobotLegs {
    pub(super) legs: [RobotLeg; 4],
    /// The limits of all joints. The limits of knees end at the straight leg.
    pub(super) bounds: Bounds,
}

/// Whether a robot walks on four legs.
pub(crate) fn has_four_legs(robot: &Robot) -> bool {
    RobotLegs::new(robot, &Kinematics::new(robot)).is_some()
}

impl RobotLegs {
    /// `None` if no four chains of joints are at the corners of a trunk.
    pub(super) fn new(robot: &Robot, kinematics: &Kinematics) -> Option<Self> {
        let rest = kinematics.rest();
        let mut zero = rest.clone();
        zero.positions.fill(0.0);
        kinematics.update(&mut zero);
        let limbs = standing_limbs(robot);
        let chains = limbs
            .iter()
            .map(|limb| limb.iter().map(|link| kinematics.body_of(*link).0).collect());
        let chains: Vec<Vec<usize>> = chains.collect();
        let end = |chain: &[usize]| kinematics.axis(&zero, chain[chain.len() - 1]).1;
        let joints = |chain: &[usize]| bending(kinematics, &zero, chain);
        let hip = |chain: &[usize]| kinematics.axis(&zero, joints(chain)[0]).1;
        let mut chains: [Vec<usize>; 4] = chains.try_into().ok()?;
        sort_legs(&mut chains, |chain| hip(chain));
        let hips = chains.each_ref().map(|chain| hip(chain));
        let leg = (0..4)
            .map(|index| hips[index].distance(end(&chains[index])))
            .sum::<f64>()
            / 4.0;
        let stands_apart = hips[0].x.min(hips[1].x) > hips[2].x.max(hips[3].x) + APART * leg
            && hips[0].y.min(hips[2].y) > hips[1].y.max(hips[3].y)
            && chains.iter().zip(hips).all(|(chain, hip)| end(chain).z < hip.z);
        if !stands_apart {
            return None;
        }
        let mut bounds = Bounds::of(kinematics);
        let transforms = robot.zero_pose();
        let moving = robot.moving_joints();
        let legs = chains.map(|chain| {
            let last = chain[chain.len() - 1];
            let hip = hip(&chain);
            let length = hip.distance(end(&chain)) * 2.0;
            let found = sole(robot, moving[last - 1], &transforms, end(&chain), length);
            let centres = found.balls.iter().map(|ball| ball.centre);
            let foot = centres.sum::<DVec3>() / found.balls.len().max(1) as f64;
            let joints = joints(&chain);
            let of_animal = <[usize; 4]>::try_from(joints.as_slice()).ok().map(|bodies| {
                let at = bodies.map(|body| kinematics.axis(&zero, body).1);
                AnimalLeg {
                    parts: std::array::from_fn(|part| (bodies[part], zero.bodies[bodies[part]].to_inner(at[part]))),
                    lengths: std::array::from_fn(|part| at[part].distance(at[part + 1])),
                    sole: zero.bodies[last].point(foot) - at[3],
                    carriers: carriers(kinematics, &zero, &chain, at[0]),
                }
            });
            RobotLeg {
                hip,
                bends: [joints[0], joints[1]],
                of_animal,
                foot,
                sole: found.balls,
                is_shown: found.is_shown,
                reach: 0.0,
                below_foot: 0.0,
                bodies: chain,
            }
        });
        let mut found = Self {
            legs,
            bounds: bounds.clone(),
        };
        for index in 0..found.legs.len() {
            found.legs[index].below_foot = found.legs[index].foot_above_sole(&zero);
            found.legs[index].reach = match &found.legs[index].of_animal {
                Some(leg) => leg.lengths.iter().sum::<f64>() + leg.sole.length(),
                None => found.bend(kinematics, &zero, index, &mut bounds),
            };
        }
        found.bounds = bounds;
        Some(found)
    }

    /// Keeps a knee on one side of the straight leg. It is the side on which the hip is farther from its limits, else
    /// the side on which the knee is behind the leg. Returns the length of the straight leg.
    fn bend(&self, kinematics: &Kinematics, zero: &RobotPose, index: usize, bounds: &mut Bounds) -> f64 {
        let leg = &self.legs[index];
        let [swing, knee] = leg.hinges();
        let mut pose = zero.clone();
        let mut at = |swing_at: f64, knee_at: f64| {
            pose.positions[swing] = swing_at;
            pose.positions[knee] = knee_at;
            kinematics.update(&mut pose);
            let foot = leg.foot_in(&pose) - leg.hip;
            (foot, kinematics.axis(&pose, knee + 1).1 - leg.hip)
        };
        let (low, high) = range(&self.bounds, knee);
        let knees = steps(low, high);
        let length = |at: DVec3| at.length();
        let straight = knees.clone().map(|angle| (angle, length(at(0.0, angle).0)));
        let (straight, reach) = straight.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0.0, 0.0));
        let swings = range(&self.bounds, swing);
        let mut side = |sign: f64| {
            let bent = (straight + sign * BENT).clamp(low, high);
            // The swing that moves the foot below the hip.
            let below = |found: &(f64, DVec3, DVec3)| (found.1.truncate().length(), found.1.z > 0.0);
            let angles = steps(-LARGEST, LARGEST).map(|angle| {
                let (foot, knee) = at(angle, bent);
                (angle, foot, knee)
            });
            let found = angles.filter(|found| !below(found).1);
            let best = found.min_by(|a, b| below(a).0.total_cmp(&below(b).0));
            best.map_or((f64::NEG_INFINITY, 0.0), |(angle, _, knee)| {
                let room = (angle - swings.0).min(swings.1 - angle).min(ENOUGH);
                (room, knee.x)
            })
        };
        if high - straight > BOTH_SIDES && straight - low > BOTH_SIDES {
            let (up, down) = (side(1.0), side(-1.0));
            let is_up = match up.0 == down.0 {
                true => up.1 < down.1,
                false => up.0 > down.0,
            };
            match is_up {
                true => bounds.lower[knee] = straight + NOT_STRAIGHT,
                false => bounds.upper[knee] = straight - NOT_STRAIGHT,
            }
        }
        reach
    }

    /// Bends the legs of a pose so that the feet come nearest to these positions in the frame of the base.
    pub(super) fn begin(&self, kinematics: &Kinematics, pose: &mut RobotPose, feet: [DVec3; 4]) {
        for (leg, wanted) in self.legs.iter().zip(feet) {
            let [swing, knee] = leg.hinges();
            let mut best = (f64::INFINITY, 0.0, 0.0);
            let [swings, knees] = [swing, knee].map(|position| range(&self.bounds, position));
            for swing_at in steps(swings.0, swings.1) {
                for knee_at in steps(knees.0, knees.1) {
                    pose.positions[swing] = swing_at;
                    pose.positions[knee] = knee_at;
                    kinematics.update(pose);
                    let apart = pose.root.to_inner(leg.foot_in(pose)).distance(wanted);
                    if apart < best.0 {
                        best = (apart, swing_at, knee_at);
                    }
                }
            }
            (pose.positions[swing], pose.positions[knee]) = (best.1, best.2);
        }
        kinematics.update(pose);
    }
}

/// The bodies of the joints that bend a leg: the joint that swings the leg, and the knee. If the leg has the joints of
/// an animal, the ankle and the paw follow. A girdle above the hip bends no leg, so it is not in the list.
fn bending(kinematics: &Kinematics, zero: &RobotPose, chain: &[usize]) -> Vec<usize> {
    let axis = |body: usize| kinematics.axis(zero, body);
    let length = axis(chain[0]).1.distance(axis(chain[chain.len() - 1]).1);
    let mut found: Vec<usize> = Vec::new();
    for &body in chain {
        let is_apart = |before: &usize| axis(*before).1.distance(axis(body).1) > BETWEEN * length;
        if axis(body).0.y.abs() > SIDEWAYS && found.last().is_none_or(is_apart) {
            found.push(body);
        }
    }
    match found.len() {
        0 | 1 => vec![chain[1], chain[2]],
        2 | 3 => found[..2].to_vec(),
        count => found[count - 4..].to_vec(),
    }
}

/// The moving bodies of the trunk and of the girdle that carry a leg: the parent of the limb, and the last body above
/// the hip.
fn carriers(kinematics: &Kinematics, zero: &RobotPose, chain: &[usize], hip: DVec3) -> Vec<(usize, DQuat)> {
    let length = hip.distance(kinematics.axis(zero, chain[chain.len() - 1]).1);
    let is_above = |body: &&usize| kinematics.axis(zero, **body).1.distance(hip) > BETWEEN * length;
    let girdle = chain.iter().take_while(is_above).last();
    let parent = kinematics.bodies[chain[0]].parent;
    let found = [Some(parent), girdle.copied()].into_iter().flatten();
    found
        .filter(|body| *body != 0)
        .map(|body| (body, zero.bodies[body].rotation))
        .collect()
}

/// The searched range of a position.
fn range(bounds: &Bounds, position: usize) -> (f64, f64) {
    (
        bounds.lower[position].max(-LARGEST),
        bounds.upper[position].min(LARGEST),
    )
}

fn steps(low: f64, high: f64) -> impl Iterator<Item = f64> + Clone {
    (0..=STEPS).map(move |step| low + (high - low) * step as f64 / STEPS as f64)
}
