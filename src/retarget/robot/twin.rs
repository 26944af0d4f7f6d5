//! The twin of a robot: a humanoid of its proportions in the T-pose, with joints that turn freely.
//!
//! A motion goes onto the twin as onto any character, with its feet held on the ground; the robot then follows the twin
//! as far as its joints go.

use std::collections::BTreeMap;

use glam::{DMat3, DQuat, DVec3, Mat4};
use mocap_figure::robot_bones::RobotBone;
use mocap_figure::{Figure, Humanoid};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::math::quaternion::wide_arc;
use mocap_scene::scene::robot::{JointKind, Placement, Robot, RobotShape};
use mocap_scene::scene::{HumanoidBone as Bone, Metadata, Node, NodeId, NodeKind, Scene, Side, UpAxis};

use super::sole::{SoleBall, sole};

/// A bone of the twin, and the link that follows it.
#[derive(Clone, Debug)]
pub(super) struct StandInBone {
    pub(super) bone: Bone,
    pub(super) node: NodeId,
    pub(super) link: usize,
    /// The joints between this bone and the one above.
    pub(super) joints: Vec<usize>,
    /// The link to the figure's axes in the T-pose, as a rotation.
    pub(super) link_to_frame: DQuat,
    /// Where the bone begins, in the frame of the link.
    pub(super) start: DVec3,
}

/// A humanoid in the T-pose, +Y up and facing +Z.
#[derive(Clone, Debug)]
pub struct StandIn {
    pub(super) scene: Scene,
    /// Its figure, in which every bone is known.
    pub(super) figure: Figure,
    pub(super) bones: Vec<StandInBone>,
    /// The tips of forearms without a hand: the node, and the link that it is fixed to with its position there.
    pub(super) tips: Vec<(NodeId, usize, DVec3)>,
    /// The figure's axes to the robot's world.
    pub(super) figure_to_world: DQuat,
    /// The soles of both feet, in the frame of the link.
    pub(super) soles: [Vec<SoleBall>; 2],
    /// Whether the robot has legs: an upper body, on wheels or fixed, has a twin with legs that nothing follows.
    pub(super) has_legs: bool,
    /// What nothing in the robot's file shows, in words.
    pub(super) guessed: Vec<String>,
}

/// What a bone is made of while the twin is built.
struct Part {
    /// From the pose with all joints at 0 to the T-pose, in the robot's axes.
    to_t_pose: DQuat,
    /// Where it begins in the T-pose, in the figure's axes.
    at: DVec3,
}

struct Builder<'a> {
    robot: &'a Robot,
    found: BTreeMap<Bone, &'a RobotBone>,
    transforms: Vec<Placement>,
    left: DVec3,
    forward: DVec3,
    figure_to_world: DQuat,
}

impl StandIn {
    pub fn new(robot: &Robot, bones: &[RobotBone]) -> Result<Self> {
        let found: BTreeMap<Bone, &RobotBone> = bones.iter().map(|bone| (bone.bone, bone)).collect();
        let position = |bone: Bone| found[&bone].at;
        let has_legs = found.contains_key(&Bone::LeftUpperLeg);
        let [left, right] = match has_legs {
            true => [Bone::LeftUpperLeg, Bone::RightUpperLeg],
            false => [Bone::LeftUpperArm, Bone::RightUpperArm],
        };
        let across = position(left) - position(right);
        let left = across.reject_from_normalized(DVec3::Z).try_normalize().ok_or_else(|| {
            let message = "the robot is not a humanoid: both legs or arms begin at one point";
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

    /// How many forearms have no end, by which their direction could be measured.
    pub(super) fn unmeasured_limbs(&self) -> usize {
        let has = |bone: Bone| self.bone(bone).is_some();
        let is_open = |side: Side| {
            let [forearm, hand] = [Bone::LeftLowerArm, Bone::LeftHand].map(|bone| bone.on(side));
            let name = hand.as_str();
            let has_tip = self.tips.iter().any(|tip| self.scene.nodes[tip.0.index()].name == name);
            has(forearm) && !has(hand) && !has_tip
        };
        Side::ALL.into_iter().filter(|side| is_open(*side)).count()
    }

    pub(super) fn bone(&self, bone: Bone) -> Option<&StandInBone> {
        self.bones.iter().find(|found| found.bone == bone)
    }
}

impl Builder<'_> {
    fn at(&self, bone: Bone) -> Option<DVec3> {
        self.found.get(&bone).map(|found| found.at)
    }

    /// The axis of the first joint of a bone with all joints at 0, and the middle of its range if it has one.
    fn hinge(&self, bone: Bone) -> Option<(DVec3, f64)> {
        let &link = self.found.get(&bone)?.joints.first()?;
        let joint = &self.robot.links[link].joint;
        let middle = 0.5 * (joint.limits.lower + joint.limits.upper);
        let axis = self.transforms[link].rotation * joint.axis;
        (joint.kind == JointKind::Hinge).then_some((axis, if middle.is_finite() { middle } else { 0.0 }))
    }

    /// The end of a forearm that has no hand: along the forearm, as far beyond its centre of mass as that is from the
    /// elbow, and a little less. The centre of its shapes is taken where the file states no mass.
    fn tip(&self, forearm: Bone) -> Option<DVec3> {
        /// The distance of the end of a forearm from the elbow, as a multiple of the distance of its centre of mass: 2
        /// for a bar, less for a forearm that is thicker at the elbow.
        const BEYOND: f64 = 1.8;

        /// The distance in metres of a centre from the elbow below which it tells no direction: rounding of files.
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

    /// The middle of the shapes of a link and of what is fixed to it.
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

    fn build(&self) -> Result<StandIn> {
        let mut parts: BTreeMap<Bone, Part> = BTreeMap::new();
        let mut tips: Vec<(Bone, DVec3, usize, DVec3)> = Vec::new();
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
            // Legs stand side by side at rest; they lean forward or back where knees and hips are bent there.
            let flat = |vector: DVec3| vector.reject_from_normalized(self.left);
            let down = |vector: DVec3| turn_about(vector, DVec3::NEG_Z, self.left);
            let (thigh, shin) = (flat(knee - hip), flat(ankle - knee));
            if thigh.length() < 1e-3 || shin.length() < 1e-3 {
                let message = format!(
                    "the robot is not a humanoid: its {} or what follows has no length",
                    upper.as_str()
                );
                return Err(Diagnostic::new(Code::NotHumanoid, message).into());
            }
            let aside = self.left * ankle.dot(self.left);
            let top = aside + flat(hip);
            let mut add = |bone: Bone, to_t_pose: DQuat, at: DVec3| {
                let at = to_figure(at);
                parts.insert(bone, Part { to_t_pose, at });
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
                parts.insert(bone, Part { to_t_pose, at });
            }
        }
        let mut twin = self.assemble(parts, tips, soles, floor);
        twin.guessed = guessed;
        twin.has_legs = has_legs;
        Ok(twin)
    }

    /// Adds the legs of a person with such shoulders, for a robot without; returns the height of the floor.
    fn add_legs(&self, parts: &mut BTreeMap<Bone, Part>) -> f64 {
        /// The width of hips, as a fraction of the width of shoulders: that of an upper body without legs, of a person.
        const WIDTH: f64 = 0.5;

        /// The height of hips, as a fraction of the height of shoulders, of a person.
        const HIPS: f64 = 0.6;

        /// The height of knees, as a fraction of the height of shoulders, of a person.
        const KNEES: f64 = 0.3;
        /// How high the shoulders of a person are, as a multiple of their width.
        const HEIGHT: f64 = 4.0;
        let [left, right] = [Bone::LeftUpperArm, Bone::RightUpperArm].map(|bone| self.found[&bone].at);
        let (middle, across) = (0.5 * (left + right), (left - right).reject_from_normalized(DVec3::Z));
        let height = HEIGHT * across.length();
        let floor = middle.z - height;
        for (side, sign) in Side::ALL.into_iter().zip([0.5, -0.5]) {
            let legs = [Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot].map(|bone| bone.on(side));
            for (bone, up) in legs.into_iter().zip([HIPS, KNEES, 0.0]) {
                let at = middle + sign * WIDTH * across - (1.0 - up) * height * DVec3::Z;
                let part = Part {
                    to_t_pose: DQuat::IDENTITY,
                    at: self.figure_to_world.inverse() * at,
                };
                parts.insert(bone, part);
            }
        }
        floor
    }

    fn arm(&self, side: Side, parts: &mut BTreeMap<Bone, Part>, tips: &mut Vec<(Bone, DVec3, usize, DVec3)>) {
        let [upper, lower, hand] = [Bone::LeftUpperArm, Bone::LeftLowerArm, Bone::LeftHand].map(|bone| bone.on(side));
        let (Some(shoulder), Some(elbow)) = (self.at(upper), self.at(lower)) else {
            return;
        };
        let to_figure = |vector: DVec3| self.figure_to_world.inverse() * vector;
        let outwards = if side == Side::Left { self.left } else { -self.left };
        let end = self.at(hand).or_else(|| self.tip(lower));
        let vector = end.map_or(DVec3::ZERO, |end| end - elbow);
        // An arm that points inwards goes outwards about the forward direction.
        let to_side = |along: DVec3| wide_arc(along, outwards, self.forward);
        let mut turn = to_side(elbow - shoulder);
        let hinge = self
            .hinge(lower)
            .filter(|(axis, _)| axis.dot((elbow - shoulder).normalize_or_zero()).abs() < 0.8);
        if let Some((axis, middle)) = hinge
            && vector.length() > 1e-3
        {
            // The position at which the arm is straight, and the direction in which it bends from there.
            let along = turn_about(vector, elbow - shoulder, axis);
            let straight = along.to_scaled_axis().dot(axis);
            let bends = if middle >= straight { axis } else { -axis };
            // In the T-pose an arm bends forward.
            turn = turn_about(turn * bends, outwards.cross(self.forward), outwards) * turn;
            let fore = turn * along;
            let fore = to_side(fore * vector) * fore;
            parts.insert(
                lower,
                Part {
                    to_t_pose: fore,
                    at: DVec3::ZERO,
                },
            );
        } else {
            let fore = to_side(turn * vector) * turn;
            parts.insert(
                lower,
                Part {
                    to_t_pose: fore,
                    at: DVec3::ZERO,
                },
            );
        }
        let at = to_figure(shoulder);
        parts.insert(upper, Part { to_t_pose: turn, at });
        let at = at + to_figure(outwards) * elbow.distance(shoulder);
        let fore = parts.get_mut(&lower).map(|part| {
            part.at = at;
            part.to_t_pose
        });
        let Some(fore) = fore else { return };
        let at = at + to_figure(outwards) * vector.length();
        match (self.at(hand), end) {
            (Some(_), _) => {
                parts.insert(hand, Part { to_t_pose: fore, at });
            }
            (None, Some(end)) => {
                let link = self.found[&lower].link;
                tips.push((hand, at, link, self.transforms[link].to_inner(end)));
            }
            (None, None) => {}
        }
    }

    fn assemble(
        &self,
        parts: BTreeMap<Bone, Part>,
        tips: Vec<(Bone, DVec3, usize, DVec3)>,
        soles: [Vec<SoleBall>; 2],
        floor: f64,
    ) -> StandIn {
        let mut scene = Scene {
            metadata: Metadata {
                metres_per_unit: Some(1.0),
                up: Some(UpAxis::Y),
                ..Metadata::default()
            },
            ..Scene::default()
        };
        let lift = DVec3::Y * -floor;
        let mut world: Vec<DVec3> = Vec::new();
        let mut push = |scene: &mut Scene, name: &str, parent: Option<NodeId>, at: DVec3| {
            let offset = parent.map_or(at, |parent| at - world[parent.index()]);
            world.push(at);
            scene.nodes.push(Node {
                name: name.to_owned(),
                kind: NodeKind::Joint,
                parent,
                transform: Mat4::from_translation(offset.as_vec3()),
                ..Node::default()
            });
            NodeId::new(scene.nodes.len() - 1)
        };
        let mut nodes: BTreeMap<Bone, NodeId> = BTreeMap::new();
        let mut bones = Vec::new();
        let mut tip_nodes = Vec::new();
        let limb = |side: Side, bones: [Bone; 3]| bones.map(|bone| bone.on(side));
        let arm = [Bone::LeftUpperArm, Bone::LeftLowerArm, Bone::LeftHand];
        let leg_bones = [Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot];
        let mut order = vec![vec![Bone::Hips], vec![Bone::Chest], vec![Bone::Head]];
        order.extend(Side::ALL.map(|side| limb(side, arm).to_vec()));
        order.extend(Side::ALL.map(|side| limb(side, leg_bones).to_vec()));
        for chain in order {
            let chest = nodes.get(&Bone::Chest).copied();
            let hips = nodes.get(&Bone::Hips).copied();
            let mut parent = match chain[0].on(Side::Left) {
                Bone::LeftUpperLeg | Bone::Chest => hips,
                _ => chest.or(hips),
            };
            for bone in chain {
                if let Some((_, at, link, position)) = tips.iter().find(|tip| tip.0 == bone) {
                    let node = push(&mut scene, bone.as_str(), parent, *at + lift);
                    nodes.insert(bone, node);
                    tip_nodes.push((node, *link, *position));
                    continue;
                }
                let Some(part) = parts.get(&bone) else { continue };
                let node = push(&mut scene, bone.as_str(), parent, part.at + lift);
                nodes.insert(bone, node);
                parent = Some(node);
                let Some(found) = self.found.get(&bone) else { continue };
                let link = found.link;
                let link_to_frame = self.figure_to_world.inverse() * part.to_t_pose * self.transforms[link].rotation;
                bones.push(StandInBone {
                    bone,
                    node,
                    link,
                    joints: found.joints.clone(),
                    link_to_frame: link_to_frame.normalize(),
                    start: self.transforms[link].to_inner(found.at),
                });
            }
        }
        // The thigh and the upper arm begin where the twin has them: the end of the bone, less its length.
        let starts: Vec<(usize, DVec3)> = bones
            .iter()
            .enumerate()
            .filter_map(|(index, bone)| {
                let next = match bone.bone.on(Side::Left) {
                    Bone::LeftUpperLeg => Bone::LeftLowerLeg,
                    Bone::LeftUpperArm => Bone::LeftLowerArm,
                    _ => return None,
                };
                let next = next.on(bone.bone.side()?);
                let vector = parts.get(&next)?.at - parts.get(&bone.bone)?.at;
                let end = self.transforms[bone.link].to_inner(self.at(next)?);
                Some((index, end - bone.link_to_frame.inverse() * vector))
            })
            .collect();
        for (index, start) in starts {
            bones[index].start = start;
        }
        if let Some(hips) = bones.iter_mut().find(|bone| bone.bone == Bone::Hips) {
            let middle = self.figure_to_world * parts[&Bone::Hips].at;
            hips.start = self.transforms[hips.link].to_inner(middle);
        }
        let humanoid = Humanoid::stated(nodes, "the robot's bones");
        StandIn {
            figure: Figure::with_bones(&scene, humanoid),
            scene,
            bones,
            tips: tip_nodes,
            figure_to_world: self.figure_to_world,
            soles,
            has_legs: true,
            guessed: Vec::new(),
        }
    }
}

/// The rotation about an axis that turns one direction to another as far as it can.
fn turn_about(from: DVec3, to: DVec3, axis: DVec3) -> DQuat {
    let (from, to) = (from.reject_from_normalized(axis), to.reject_from_normalized(axis));
    let angle = from.cross(to).dot(axis).atan2(from.dot(to));
    DQuat::from_axis_angle(axis, if angle.is_finite() { angle } else { 0.0 })
}
