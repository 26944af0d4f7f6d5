//! Computes the T-pose of a robot from the axes of its joints. In the T-pose, the arms are horizontal, the legs point
//! down, and the feet stand on their soles.

use std::collections::BTreeMap;

use glam::{DMat3, DQuat, DVec3};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::math::quaternion::wide_arc;
use mocap_scene::scene::robot::{JointKind, Placement, Robot, RobotShape};
use mocap_scene::scene::{HumanoidBone as Bone, Side};

use super::RobotBone;
use super::sole::{SoleBall, sole};

/// A bone in the T-pose.
#[derive(Clone, Debug)]
pub struct BonePart {
    /// The rotation from the pose with all joints at 0 to the T-pose, in the robot's axes.
    pub to_t_pose: DQuat,
    /// The start of the bone in the T-pose, in the figure's axes.
    pub at: DVec3,
}

/// The end of a forearm without a hand.
#[derive(Clone, Debug)]
pub struct ForearmTip {
    /// The hand that is missing.
    pub bone: Bone,
    /// The position of the end in the T-pose, in the figure's axes.
    pub at: DVec3,
    /// The link to which the end is fixed.
    pub link: usize,
    /// The position of the end in the coordinate frame of the link.
    pub point: DVec3,
}

/// A robot in the T-pose.
#[derive(Clone, Debug)]
pub struct RobotTPose {
    /// The placement of each link with all joints at 0.
    pub zero_pose: Vec<Placement>,
    /// The bones. A robot without legs gets the legs of a person whose shoulders are as wide as those of the robot.
    pub parts: BTreeMap<Bone, BonePart>,
    /// The ends of forearms without a hand.
    pub tips: Vec<ForearmTip>,
    /// The rotation from the figure's axes to the robot's world.
    pub figure_to_world: DQuat,
    /// The soles of both feet, in the coordinate frames of their links.
    pub soles: [Vec<SoleBall>; 2],
    /// The height of the floor with all joints at 0, in the robot's world.
    pub floor: f64,
    /// Whether the robot has legs.
    pub has_legs: bool,
    /// Guesses that nothing in the robot's file supports, as text.
    pub guessed: Vec<String>,
}

impl RobotTPose {
    /// The T-pose of a robot with these bones.
    ///
    /// # Errors
    /// [`Code::NotHumanoid`] if both legs or both arms begin at one point, or if a leg has no length.
    pub fn new(robot: &Robot, bones: &[RobotBone]) -> Result<Self> {
        let found: BTreeMap<Bone, &RobotBone> = bones.iter().map(|bone| (bone.bone, bone)).collect();
        let at = |bone: Bone| found.get(&bone).map(|bone| bone.at);
        let has_legs = found.contains_key(&Bone::LeftUpperLeg);
        let [left, right] = match has_legs {
            true => [Bone::LeftUpperLeg, Bone::RightUpperLeg],
            false => [Bone::LeftUpperArm, Bone::RightUpperArm],
        };
        let across = at(left)
            .zip(at(right))
            .map(|(left, right)| left - right)
            .unwrap_or_default();
        let left = across.reject_from_normalized(DVec3::Z).try_normalize().ok_or_else(|| {
            let message = "the robot is not a humanoid: both legs or both arms begin at the same point";
            Diagnostic::new(Code::NotHumanoid, message)
        })?;
        let forward = left.cross(DVec3::Z);
        let builder = Builder {
            robot,
            found,
            transforms: robot.zero_pose(),
            left,
            forward,
            figure_to_world: DQuat::from_mat3(&DMat3::from_cols(left, DVec3::Z, forward)).normalize(),
        };
        builder.build()
    }

    /// The rotation from the link of a bone to the figure's axes in the T-pose.
    pub fn link_to_frame(&self, bone: &RobotBone) -> DQuat {
        let to_t_pose = self
            .parts
            .get(&bone.bone)
            .map_or(DQuat::IDENTITY, |part| part.to_t_pose);
        (self.figure_to_world.inverse() * to_t_pose * self.zero_pose[bone.link].rotation).normalize()
    }

    /// The start of a bone, in the coordinate frame of its link. For a thigh or an upper arm, it is computed from the
    /// end of the bone in the T-pose and the length of the bone.
    pub fn start(&self, bone: &RobotBone, bones: &[RobotBone]) -> DVec3 {
        let to_link = |at: DVec3| self.zero_pose[bone.link].to_inner(at);
        let from_end = |next: Bone| {
            let next = next.on(bone.bone.side()?);
            let vector = self.parts.get(&next)?.at - self.parts.get(&bone.bone)?.at;
            let end = bones.iter().find(|other| other.bone == next)?;
            Some(to_link(end.at) - self.link_to_frame(bone).inverse() * vector)
        };
        let found = match bone.bone.on(Side::Left) {
            Bone::LeftUpperLeg => from_end(Bone::LeftLowerLeg),
            Bone::LeftUpperArm => from_end(Bone::LeftLowerArm),
            Bone::Hips => self
                .parts
                .get(&Bone::Hips)
                .map(|part| to_link(self.figure_to_world * part.at)),
            _ => None,
        };
        found.unwrap_or_else(|| to_link(bone.at))
    }
}

struct Builder<'a> {
    robot: &'a Robot,
    found: BTreeMap<Bone, &'a RobotBone>,
    transforms: Vec<Placement>,
    left: DVec3,
    forward: DVec3,
    figure_to_world: DQuat,
}

impl Builder<'_> {
    fn at(&self, bone: Bone) -> Option<DVec3> {
        self.found.get(&bone).map(|found| found.at)
    }

    /// The axis of the first joint of a bone with all joints at 0, and the middle of its range. The middle is 0 for a
    /// joint without a range.
    fn hinge(&self, bone: Bone) -> Option<(DVec3, f64)> {
        let &link = self.found.get(&bone)?.joints.first()?;
        let joint = &self.robot.links[link].joint;
        let middle = 0.5 * (joint.limits.lower + joint.limits.upper);
        let axis = self.transforms[link].rotation * joint.axis;
        (joint.kind == JointKind::Hinge).then_some((axis, if middle.is_finite() { middle } else { 0.0 }))
    }

    /// The end of a forearm without a hand. Its distance from the elbow is a multiple of the distance from the elbow to
    /// the forearm's centre of mass. If the file has no mass, the centre of the shapes is used.
    fn tip(&self, forearm: Bone) -> Option<DVec3> {
        /// The distance from the elbow to the end of a forearm, as a multiple of the distance to its centre of mass.
        /// For a uniform bar, it is 2. For a forearm that is thicker at the elbow, it is less.
        const BEYOND: f64 = 1.8;

        /// The distance from the elbow, in metres, within which the centre of mass shows no direction. Rounding in
        /// files causes such distances.
        const NOWHERE: f64 = 1e-3;
        let bone = self.found.get(&forearm)?;
        let from_joint = |centre: DVec3| {
            let vector = centre - bone.at;
            let vector = match self.hinge(forearm) {
                Some((axis, _)) => vector.reject_from_normalized(axis),
                None => vector,
            };
            Some(vector).filter(|vector| vector.length() > NOWHERE)
        };
        let inertial = self.robot.links[bone.link].inertial;
        let by_mass =
            inertial.and_then(|inertial| from_joint(self.transforms[bone.link].point(inertial.origin.translation)));
        let vector = by_mass.or_else(|| from_joint(self.centre_of_shapes(bone.link)?))?;
        Some(bone.at + BEYOND * vector)
    }

    /// The middle of the shapes of a link and of the links fixed to it.
    fn centre_of_shapes(&self, link: usize) -> Option<DVec3> {
        let mut carrier = vec![usize::MAX; self.robot.links.len()];
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (index, part) in self.robot.links.iter().enumerate().skip(link) {
            let above = part
                .parent
                .filter(|_| !part.joint.moves())
                .map(|parent| carrier[parent]);
            carrier[index] = if index == link {
                link
            } else {
                above.unwrap_or(usize::MAX)
            };
            if carrier[index] != link {
                continue;
            }
            for (centre, radius) in part.shapes.iter().flat_map(RobotShape::balls) {
                let at = self.transforms[index].point(centre);
                (low, high) = (low.min(at - radius), high.max(at + radius));
            }
        }
        (low.x <= high.x).then(|| 0.5 * (low + high))
    }

    fn build(self) -> Result<RobotTPose> {
        let mut parts: BTreeMap<Bone, BonePart> = BTreeMap::new();
        let mut tips = Vec::new();
        let to_figure = |vector: DVec3| self.figure_to_world.inverse() * vector;
        let mut soles = [Vec::new(), Vec::new()];
        let mut guessed = Vec::new();
        let mut floor = f64::INFINITY;
        let has_legs = self.found.contains_key(&Bone::LeftUpperLeg);
        if !has_legs {
            floor = self.add_legs(&mut parts);
        }
        for side in Side::ALL {
            let [upper, lower, foot] =
                [Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot].map(|bone| bone.on(side));
            let (Some(hip), Some(knee), Some(ankle)) = (self.at(upper), self.at(lower), self.at(foot)) else {
                continue;
            };
            // Legs are side by side at rest. They lean forward or back if knees and hips are bent at rest.
            let flat = |vector: DVec3| vector.reject_from_normalized(self.left);
            let down = |vector: DVec3| turn_about(vector, DVec3::NEG_Z, self.left);
            let (thigh, shin) = (flat(knee - hip), flat(ankle - knee));
            if thigh.length() < 1e-3 || shin.length() < 1e-3 {
                let message = format!(
                    "the robot is not a humanoid: its {} or the next bone has no length",
                    upper.as_str()
                );
                return Err(Diagnostic::new(Code::NotHumanoid, message).into());
            }
            let aside = self.left * ankle.dot(self.left);
            let top = aside + flat(hip);
            let mut add = |bone: Bone, to_t_pose: DQuat, at: DVec3| {
                let at = to_figure(at);
                parts.insert(bone, BonePart { to_t_pose, at });
            };
            let middle = top - DVec3::Z * thigh.length();
            add(upper, down(thigh), top);
            add(lower, down(shin), middle);
            let leg = thigh.length() + shin.length();
            let link = self.found[&foot].link;
            let sole = sole(self.robot, link, &self.transforms, ankle, leg);
            add(foot, sole.to_flat, middle - DVec3::Z * shin.length());
            if !sole.is_shown {
                let name = &self.robot.links[link].name;
                guessed.push(format!("the sole of {name}, which has no shape"));
            }
            let depth = |ball: &SoleBall| {
                let vector = self.transforms[link].point(ball.centre) - ankle;
                ball.radius - (sole.to_flat * vector).z
            };
            let deepest = sole.balls.iter().map(depth).fold(0.0, f64::max);
            floor = f64::min(floor, top.z - leg - deepest);
            soles[side as usize] = sole.balls;
        }
        for side in Side::ALL {
            self.arm(side, &mut parts, &mut tips);
        }
        for bone in [Bone::Hips, Bone::Chest, Bone::Head] {
            let at = match bone {
                Bone::Hips => {
                    let hip = |bone: Bone| parts.get(&bone).map_or(DVec3::ZERO, |part| part.at);
                    Some(0.5 * (hip(Bone::LeftUpperLeg) + hip(Bone::RightUpperLeg)))
                }
                _ => self.at(bone).map(to_figure),
            };
            if let Some(at) = at {
                let to_t_pose = DQuat::IDENTITY;
                parts.insert(bone, BonePart { to_t_pose, at });
            }
        }
        Ok(RobotTPose {
            zero_pose: self.transforms,
            parts,
            tips,
            figure_to_world: self.figure_to_world,
            soles,
            floor,
            has_legs,
            guessed,
        })
    }

    /// Gives a robot without legs the legs of a person whose shoulders are as wide as those of the robot. Returns the
    /// height of the floor.
    fn add_legs(&self, parts: &mut BTreeMap<Bone, BonePart>) -> f64 {
        /// The width of a person's hips, as a fraction of the width of the shoulders.
        const WIDTH: f64 = 0.5;

        /// The height of a person's hips, as a fraction of the height of the shoulders.
        const HIPS: f64 = 0.6;

        /// The height of a person's knees, as a fraction of the height of the shoulders.
        const KNEES: f64 = 0.3;
        /// The height of a person's shoulders, as a multiple of their width.
        const HEIGHT: f64 = 4.0;
        let [left, right] = [Bone::LeftUpperArm, Bone::RightUpperArm].map(|bone| self.found[&bone].at);
        let (middle, across) = (0.5 * (left + right), (left - right).reject_from_normalized(DVec3::Z));
        let height = HEIGHT * across.length();
        let floor = middle.z - height;
        for (side, sign) in Side::ALL.into_iter().zip([0.5, -0.5]) {
            let legs = [Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot].map(|bone| bone.on(side));
            for (bone, up) in legs.into_iter().zip([HIPS, KNEES, 0.0]) {
                let at = middle + sign * WIDTH * across - (1.0 - up) * height * DVec3::Z;
                let part = BonePart {
                    to_t_pose: DQuat::IDENTITY,
                    at: self.figure_to_world.inverse() * at,
                };
                parts.insert(bone, part);
            }
        }
        floor
    }

    fn arm(&self, side: Side, parts: &mut BTreeMap<Bone, BonePart>, tips: &mut Vec<ForearmTip>) {
        let [upper, lower, hand] = [Bone::LeftUpperArm, Bone::LeftLowerArm, Bone::LeftHand].map(|bone| bone.on(side));
        let (Some(shoulder), Some(elbow)) = (self.at(upper), self.at(lower)) else {
            return;
        };
        let to_figure = |vector: DVec3| self.figure_to_world.inverse() * vector;
        let outwards = if side == Side::Left { self.left } else { -self.left };
        let end = self.at(hand).or_else(|| self.tip(lower));
        let vector = end.map_or(DVec3::ZERO, |end| end - elbow);
        // An arm that points inwards is rotated outwards about the forward direction.
        let to_side = |along: DVec3| wide_arc(along, outwards, self.forward);
        let mut turn = to_side(elbow - shoulder);
        let hinge = self
            .hinge(lower)
            .filter(|(axis, _)| axis.dot((elbow - shoulder).normalize_or_zero()).abs() < 0.8);
        if let Some((axis, middle)) = hinge
            && vector.length() > 1e-3
        {
            // The joint position at which the arm is straight, and the bending direction from there.
            let along = turn_about(vector, elbow - shoulder, axis);
            let straight = along.to_scaled_axis().dot(axis);
            let bends = if middle >= straight { axis } else { -axis };
            // In the T-pose an arm bends forward.
            turn = turn_about(turn * bends, outwards.cross(self.forward), outwards) * turn;
            let fore = turn * along;
            let fore = to_side(fore * vector) * fore;
            parts.insert(
                lower,
                BonePart {
                    to_t_pose: fore,
                    at: DVec3::ZERO,
                },
            );
        } else {
            let fore = to_side(turn * vector) * turn;
            parts.insert(
                lower,
                BonePart {
                    to_t_pose: fore,
                    at: DVec3::ZERO,
                },
            );
        }
        let at = to_figure(shoulder);
        parts.insert(upper, BonePart { to_t_pose: turn, at });
        let at = at + to_figure(outwards) * elbow.distance(shoulder);
        let fore = parts.get_mut(&lower).map(|part| {
            part.at = at;
            part.to_t_pose
        });
        let Some(fore) = fore else { return };
        let at = at + to_figure(outwards) * vector.length();
        match (self.at(hand), end) {
            (Some(_), _) => {
                parts.insert(hand, BonePart { to_t_pose: fore, at });
            }
            (None, Some(end)) => {
                let link = self.found[&lower].link;
                let point = self.transforms[link].to_inner(end);
                tips.push(ForearmTip {
                    bone: hand,
                    at,
                    link,
                    point,
                });
            }
            (None, None) => {}
        }
    }
}

/// The rotation about an axis that brings one direction as near as possible to another.
fn turn_about(from: DVec3, to: DVec3, axis: DVec3) -> DQuat {
    let (from, to) = (from.reject_from_normalized(axis), to.reject_from_normalized(axis));
    let angle = from.cross(to).dot(axis).atan2(from.dot(to));
    DQuat::from_axis_angle(axis, if angle.is_finite() { angle } else { 0.0 })
}
