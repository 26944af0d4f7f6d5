//! A humanoid with the frames of its T-pose.

use std::collections::BTreeMap;

use glam::{Quat, Vec3};

use super::level::{self, Foot};
use super::rotations::{arc, rotation_of};
use crate::error::{Code, Diagnostic, Result};
use crate::figure::{Humanoid, HumanoidBone as Bone, RestPose, Side, Sides, Skeleton, TPose, humanoid};
use crate::pose::{Pose, Trs};
use crate::scene::{Format, NodeId, NodeKind, Scene};

/// The largest angle between the facing of the rest pose and the axis that is nearest to it, in radians, which counts
/// as inexact. Above it the figure is turned to face along the axis.
const FACING_IS_INEXACT: f32 = 0.09;

/// A foot that points further down than this, as a share of its length, does not stand on its sole at rest.
const POINTED_FOOT: f32 = 0.9;

/// The largest angle by which a foot of a rest pose that stands may be off its sole, in radians, and of any other.
const LEVELLED: f32 = 0.5;
const LEVELLED_WITHOUT_REST: f32 = 1.2;

/// The cosine of the largest angle between a head and the chest, on the average of a motion, that a T-pose may leave.
const TIPPED_HEAD: f32 = 0.7;

/// The largest angle between a shoulder and the chest, likewise, in radians: in clips of bodies that stand at rest the
/// mean is at most 20 degrees.
const TURNED_SHOULDER: f32 = 0.35;

/// The smallest angle of a foot that counts, in radians.
const SMALLEST_LEVELLED: f32 = 0.02;

/// The smallest angle by which both feet of a rest pose that stands may be rolled, in radians, and by how much they may
/// differ. In motions whose rest pose has flat feet they are rolled by up to 0.09, and one by 0.25.
const SMALLEST_ROLL: f32 = 0.1;
const UNEQUAL_ROLL: f32 = 0.1;

/// A humanoid with the frames of its T-pose.
#[derive(Clone, Debug)]
pub(super) struct Body {
    /// Left, up and forward of the figure, from the frame of the T-pose (+X, +Y, +Z) to the world.
    pub(super) axes: Quat,
    pub(super) humanoid: Humanoid,
    pub(super) hips: NodeId,
    pub(super) bones: BTreeMap<Bone, NodeId>,
    /// For each bone, the rotation from the reference pose to the T-pose.
    to_t_pose: BTreeMap<Bone, Quat>,
    /// The reference pose: a standing figure, from which the limbs are turned to the T-pose.
    positions: Vec<Vec3>,
    rotations: Vec<Quat>,
    /// The scene's nodes.
    pub(super) parents: Vec<Option<usize>>,
    pub(super) names: Vec<String>,
    pub(super) rest_rotations: Vec<Quat>,
    pub(super) rest: Vec<Trs>,
    /// Joints between the hips and the neck, from below.
    pub(super) trunk: Vec<NodeId>,
    /// Joints from the neck to below the head.
    pub(super) neck: Vec<NodeId>,
    /// Metres in a unit of length.
    pub(super) metres_per_unit: f64,
    /// Thigh and shin, the mean of both sides.
    pub(super) leg: f32,
}

impl Body {
    /// The body of a scene. `role` says in errors which scene it is.
    pub(super) fn new(scene: &Scene, known: Option<Humanoid>, role: &str) -> Result<Self> {
        let refused = |reason: String| -> crate::error::Error {
            Diagnostic::new(Code::NotHumanoid, format!("the {role} is not a humanoid: {reason}"))
                .help("name its bones in a map, or choose another file")
                .into()
        };
        let found = sides_of_the_body(known.unwrap_or_else(|| humanoid(scene)));
        if !found.found {
            return Err(refused(found.reason));
        }
        let skeleton = Skeleton::of(scene, found);
        let bones: BTreeMap<Bone, NodeId> = skeleton
            .humanoid
            .bones
            .iter()
            .map(|(bone, joint)| (*bone, joint.joint))
            .collect();
        for bone in [
            Bone::Hips,
            Bone::LeftUpperLeg,
            Bone::LeftLowerLeg,
            Bone::RightUpperLeg,
            Bone::RightLowerLeg,
        ] {
            if !bones.contains_key(&bone) {
                return Err(refused(format!("no joint is the bone {}", bone.as_str())));
            }
        }
        let hips = bones[&Bone::Hips];
        let stands = matches!(
            skeleton.rest_pose.value,
            RestPose::TPose | RestPose::APose | RestPose::IPose
        );
        let reference = match TPose::new(scene, &skeleton) {
            Some(t_pose) if !stands => t_pose.pose,
            _ => Pose::rest(scene),
        };
        let parents: Vec<_> = scene.nodes.iter().map(|node| node.parent.map(NodeId::index)).collect();
        let rest: Vec<Trs> = scene
            .nodes
            .iter()
            .map(|node| Trs::from_matrix(node.transform))
            .collect();
        let mut body = Self {
            axes: Quat::IDENTITY,
            hips,
            to_t_pose: BTreeMap::new(),
            positions: (0..scene.nodes.len())
                .map(|node| reference.position(NodeId::new(node)))
                .collect(),
            rotations: reference.node_to_world.iter().map(rotation_of).collect(),
            rest_rotations: rest.iter().map(|trs| trs.rotation).collect(),
            names: scene.nodes.iter().map(|node| node.name.clone()).collect(),
            rest,
            trunk: Vec::new(),
            neck: Vec::new(),
            metres_per_unit: skeleton.survey.metres_per_unit,
            leg: 0.0,
            humanoid: skeleton.humanoid.clone(),
            parents,
            bones,
        };
        body.turn_to_t_pose(&skeleton);
        // The T-pose of a VRM animation is that of its rest pose.
        if scene.metadata.format != Some(Format::Vrma) {
            body.level_feet(scene, stands);
            if !stands {
                body.level_head(scene);
                body.level_shoulders(scene);
            }
        }
        body.trunk_and_neck(scene);
        body.leg = body.leg_length();
        if !(body.leg.is_finite() && body.leg > 0.0) {
            return Err(refused("its legs have no length at rest".to_owned()));
        }
        Ok(body)
    }

    /// The body that is moved.
    pub(super) fn target(scene: &Scene, known: Option<&Humanoid>) -> Result<Self> {
        let body = Self::new(scene, known.cloned(), "target")?;
        body.check_target(scene)?;
        Ok(body)
    }

    /// Refuses a target whose bones are not all below its hips: moving the hips would not move the body.
    fn check_target(&self, scene: &Scene) -> Result<()> {
        for (bone, &joint) in &self.bones {
            if joint != self.hips && !self.depends_on(joint, self.hips) {
                let name = |node: NodeId| &scene.nodes[node.index()].name;
                let message = format!(
                    "the target cannot be posed: its {} \"{}\" is not below its hips \"{}\"",
                    bone.as_str(),
                    name(joint),
                    name(self.hips)
                );
                return Err(Diagnostic::new(Code::NotHumanoid, message)
                    .help("name other joints in a map, or choose another character")
                    .into());
            }
        }
        Ok(())
    }

    pub(super) fn joint(&self, bone: Bone) -> Option<NodeId> {
        self.bones.get(&bone).copied()
    }

    fn above(&self, node: NodeId) -> impl Iterator<Item = usize> {
        std::iter::successors(self.parents[node.index()], |node| self.parents[*node])
    }

    /// Whether a node is below another in the hierarchy.
    pub(super) fn depends_on(&self, node: NodeId, ancestor: NodeId) -> bool {
        self.above(node).any(|above| above == ancestor.index())
    }

    /// The nodes strictly between a node and one above it, from above; `None` if it is not below it.
    fn path(&self, from: NodeId, to: NodeId) -> Option<Vec<NodeId>> {
        self.depends_on(to, from).then(|| {
            let between = self.above(to).take_while(|node| *node != from.index());
            let mut path: Vec<_> = between.map(NodeId::new).collect();
            path.reverse();
            path
        })
    }

    /// The joints that make up a bone: its own, and those on the way to the next bone.
    pub(super) fn segment(&self, bone: Bone) -> Vec<NodeId> {
        let Some(joint) = self.joint(bone) else {
            return Vec::new();
        };
        let mut joints = vec![joint];
        if let Some(end) = limb_end(bone).and_then(|next| self.joint(next)) {
            joints.extend(self.path(joint, end).unwrap_or_default());
        }
        joints
    }

    /// The direction in which a bone points in the T-pose, in its frame; `None` for one that is not turned there.
    pub(super) fn direction(bone: Bone) -> Option<Vec3> {
        let outwards = if bone.side() == Some(Side::Right) {
            Vec3::NEG_X
        } else {
            Vec3::X
        };
        match bone.on(Side::Left) {
            Bone::LeftUpperLeg | Bone::LeftLowerLeg => Some(Vec3::NEG_Y),
            Bone::LeftUpperArm | Bone::LeftLowerArm | Bone::LeftHand => Some(outwards),
            Bone::LeftThumbMetacarpal | Bone::LeftThumbProximal | Bone::LeftThumbDistal => {
                Some((outwards + Vec3::Z).normalize())
            }
            finger if finger.is_finger() => Some(outwards),
            _ => None,
        }
    }

    /// From the frame of `bone` to a joint that moves with it, as a rotation: the joint's rotation in the T-pose.
    pub(super) fn frame_to_joint(&self, bone: Bone, joint: NodeId) -> Quat {
        (self.axes.inverse() * self.to_t_pose(bone) * self.rotations[joint.index()]).normalize()
    }

    /// A vector of the reference pose that turns with `bone`, in the T-pose and in the axes of the figure.
    pub(super) fn to_frame(&self, bone: Bone, vector: Vec3) -> Vec3 {
        self.axes.inverse() * self.to_t_pose(bone) * vector
    }

    /// From the reference pose of a bone to its T-pose.
    fn to_t_pose(&self, bone: Bone) -> Quat {
        self.to_t_pose.get(&bone).copied().unwrap_or(Quat::IDENTITY)
    }

    /// The place of a node in the reference pose, before any limb is turned to the T-pose.
    pub(super) fn position(&self, node: NodeId) -> Vec3 {
        self.positions[node.index()]
    }

    /// The rotation of a node to the world in the reference pose.
    pub(super) fn rotation(&self, node: NodeId) -> Quat {
        self.rotations[node.index()]
    }

    /// Up in the world.
    pub(super) fn up(&self) -> Vec3 {
        self.axes * Vec3::Y
    }

    fn turn_to_t_pose(&mut self, skeleton: &Skeleton) {
        let axes = skeleton.figure_to_world();
        let (up, forward) = (axes.y_axis, axes.z_axis);
        self.axes = Quat::from_mat3(&axes).normalize();
        let facing = self.turn_to_face(up, forward);
        let mut turned: BTreeMap<Bone, Quat> = BTreeMap::new();
        for (&bone, &joint) in &self.bones {
            let above = std::iter::successors(bone.parent(), |bone| bone.parent())
                .find_map(|above| turned.get(&above).copied())
                .unwrap_or(facing);
            let rotation = match (Self::direction(bone), bone.on(Side::Left)) {
                (Some(direction), part) => {
                    let start = match part {
                        Bone::LeftUpperArm | Bone::LeftUpperLeg => facing,
                        _ => above,
                    };
                    match self.next(bone, joint) {
                        Some(next) => {
                            let way = start * (self.positions[next.index()] - self.positions[joint.index()]);
                            arc(way, self.axes * direction) * start
                        }
                        None => start,
                    }
                }
                (None, Bone::LeftFoot) => self.foot(joint, bone, facing, up, forward),
                (None, Bone::LeftToes) => above,
                _ => facing,
            };
            turned.insert(bone, rotation.normalize());
        }
        self.to_t_pose = turned;
    }

    /// Puts the feet of the reference pose on their soles, as the motion shows them: both by the same angle. Where
    /// `stands` is false, the reference pose is computed, and says nothing about how the feet roll. Where it stands
    /// with its legs apart, as that of CMU's database, its feet may be rolled outwards with them.
    fn level_feet(&mut self, scene: &Scene, stands: bool) {
        let largest = if stands { LEVELLED } else { LEVELLED_WITHOUT_REST };
        let bones = [Bone::LeftFoot, Bone::RightFoot];
        let feet: Vec<Foot> = bones
            .into_iter()
            .filter_map(|bone| {
                let joint = self.joint(bone)?;
                Some(Foot {
                    joint,
                    world_to_frame: self.axes.inverse(),
                    joint_to_frame: self.frame_to_joint(bone, joint).inverse(),
                })
            })
            .collect();
        let [Some(left), Some(right)] = level::stances(scene, &feet)[..] else {
            return;
        };
        let counts = |pitch: &f32| (SMALLEST_LEVELLED..=largest).contains(&pitch.abs());
        let is_pitched = [left.pitch, right.pitch].iter().all(counts);
        let pitch = Some(0.5 * (left.pitch + right.pitch)).filter(|_| is_pitched);
        let rolls = match (stands, left.roll, right.roll) {
            (false, left, right) => [left, right],
            (true, Some(left), Some(right)) if is_mirrored(left, right) => {
                let roll = 0.5 * (left - right);
                [Some(roll), Some(-roll)]
            }
            (true, ..) => [None, None],
        };
        for (foot, roll) in bones.into_iter().zip(rolls) {
            let Some(&ankle) = self.bones.get(&foot) else { continue };
            let pitch = Quat::from_rotation_x(-pitch.unwrap_or(0.0));
            let turn = pitch * Quat::from_rotation_z(roll.unwrap_or(0.0));
            self.turn(foot, ankle, turn);
            if roll.is_some() {
                // The toes of a foot that is rolled point aside of where they point on the ground.
                let (up, forward) = (self.up(), self.axes * Vec3::Z);
                let facing = self.turn_to_face(up, forward);
                let rotation = self.foot(ankle, foot, facing, up, forward).normalize();
                let toes = if foot == Bone::LeftFoot {
                    Bone::LeftToes
                } else {
                    Bone::RightToes
                };
                for bone in [foot, toes] {
                    self.to_t_pose.entry(bone).and_modify(|to_t_pose| *to_t_pose = rotation);
                }
            }
        }
    }

    /// Turns a head that the motion shows tipped over against the chest all the time: the bones of a rest pose that had
    /// to be computed say nothing about how its joint is turned.
    fn level_head(&mut self, scene: &Scene) {
        let (Some(head), Some((chest, chest_joint))) = (self.joint(Bone::Head), self.chest()) else {
            return;
        };
        // With a head as the root, a turn of it would be one of the whole body.
        if !self.depends_on(head, chest_joint) {
            return;
        }
        let to_frame = |bone: Bone, joint: NodeId| self.frame_to_joint(bone, joint).inverse();
        let turned = level::mean_turn(
            scene,
            (head, to_frame(Bone::Head, head)),
            (chest_joint, to_frame(chest, chest_joint)),
        );
        let is_tipped = |turn: &Quat| (*turn * Vec3::Y).y < TIPPED_HEAD;
        let Some(turned) = turned.filter(is_tipped) else { return };
        self.turn(Bone::Head, head, turned);
    }

    /// Turns shoulders that the motion shows turned against the chest all the time, likewise. The arms keep their
    /// T-pose.
    fn level_shoulders(&mut self, scene: &Scene) {
        let Some((chest, chest_joint)) = self.chest() else {
            return;
        };
        for bone in [Bone::LeftShoulder, Bone::RightShoulder] {
            let Some(shoulder) = self.joint(bone).filter(|joint| self.depends_on(*joint, chest_joint)) else {
                continue;
            };
            let turned = level::mean_turn(
                scene,
                (shoulder, self.frame_to_joint(bone, shoulder).inverse()),
                (chest_joint, self.frame_to_joint(chest, chest_joint).inverse()),
            );
            let is_turned = |turn: &Quat| turn.angle_between(Quat::IDENTITY) > TURNED_SHOULDER;
            if let (Some(turned), Some(to_t_pose)) = (turned.filter(is_turned), self.to_t_pose.get_mut(&bone)) {
                *to_t_pose = (self.axes * turned * self.axes.inverse() * *to_t_pose).normalize();
            }
        }
    }

    /// The highest bone of the spine, and its joint.
    fn chest(&self) -> Option<(Bone, NodeId)> {
        [Bone::UpperChest, Bone::Chest, Bone::Spine]
            .into_iter()
            .find_map(|bone| Some((bone, self.joint(bone)?)))
    }

    /// Turns the joint of a bone about itself in the reference pose, with all nodes below it; `turn` is in the bone's
    /// frame.
    fn turn(&mut self, bone: Bone, joint: NodeId, turn: Quat) {
        let axes = self.to_t_pose(bone).inverse() * self.axes;
        let turn = axes * turn * axes.inverse();
        let here = self.positions[joint.index()];
        for index in joint.index()..self.parents.len() {
            if index == joint.index() || self.depends_on(NodeId::new(index), joint) {
                self.positions[index] = here + turn * (self.positions[index] - here);
                self.rotations[index] = (turn * self.rotations[index]).normalize();
            }
        }
    }

    /// The rotation about the up axis that makes the figure of the reference pose face along an axis.
    fn turn_to_face(&self, up: Vec3, forward: Vec3) -> Quat {
        let across = |left: Bone, right: Bone| {
            let way = self.position(self.joint(left)?) - self.position(self.joint(right)?);
            (way - way.project_onto_normalized(up)).try_normalize()
        };
        let hips = across(Bone::LeftUpperLeg, Bone::RightUpperLeg).unwrap_or_default();
        let shoulders = across(Bone::LeftUpperArm, Bone::RightUpperArm).unwrap_or_default();
        let Some(seen) = (hips + shoulders).cross(up).try_normalize() else {
            return Quat::IDENTITY;
        };
        let angle = seen.cross(forward).dot(up).atan2(seen.dot(forward));
        if angle.abs() < FACING_IS_INEXACT {
            return Quat::IDENTITY;
        }
        Quat::from_axis_angle(up, angle)
    }

    /// A foot stands on its sole in the reference pose. Only its heading is turned, so that it points forward.
    fn foot(&self, joint: NodeId, bone: Bone, facing: Quat, up: Vec3, forward: Vec3) -> Quat {
        let side = bone.side().unwrap_or(Side::Left);
        let toes = self.joint(Bone::LeftToes.on(side)).or_else(|| self.only_child(joint));
        let Some(way) = toes.and_then(|toes| (facing * (self.position(toes) - self.position(joint))).try_normalize())
        else {
            return facing;
        };
        if way.dot(up).abs() > POINTED_FOOT {
            return arc(way, forward - 0.4 * up) * facing;
        }
        let flat = way - way.project_onto_normalized(up);
        arc(flat, forward) * facing
    }

    /// The node towards which a bone points: the next bone, else the only child of its joint.
    pub(super) fn next(&self, bone: Bone, joint: NodeId) -> Option<NodeId> {
        let side = bone.side().unwrap_or(Side::Left);
        let knuckles: &[Bone] = match bone.on(Side::Left) {
            Bone::LeftHand => &[
                Bone::LeftMiddleProximal,
                Bone::LeftIndexProximal,
                Bone::LeftRingProximal,
                Bone::LeftLittleProximal,
            ],
            _ => &[],
        };
        let knuckles = knuckles.iter().map(|knuckle| knuckle.on(side));
        let next = limb_end(bone).or_else(|| next_of_finger(bone));
        let mut named = knuckles.chain(next).filter_map(|next| self.joint(next));
        named
            .find(|next| self.depends_on(*next, joint))
            .or_else(|| self.only_child(joint))
    }

    /// The joint of a foot or of its toes; for toes without a joint the first node below the ankle.
    pub(super) fn foot_joint(&self, bone: Bone) -> Option<NodeId> {
        let below = || self.first_child(self.joint(Bone::LeftFoot.on(bone.side()?))?);
        match bone.on(Side::Left) {
            Bone::LeftToes => self.joint(bone).or_else(below),
            _ => self.joint(bone),
        }
    }

    /// How high a joint of a foot is when the body stands and its ankles are `ankle` high.
    pub(super) fn standing_height(&self, bone: Bone, ankle: f32) -> f32 {
        let joint = self.foot_joint(bone);
        let foot = self.joint(Bone::LeftFoot.on(bone.side().unwrap_or(Side::Left)));
        let above = |(joint, foot): (NodeId, NodeId)| (self.position(joint) - self.position(foot)).dot(self.up());
        ankle + joint.zip(foot).map_or(0.0, above)
    }

    fn first_child(&self, node: NodeId) -> Option<NodeId> {
        let is_child = |child: &usize| self.parents[*child] == Some(node.index());
        (node.index() + 1..self.parents.len()).find(is_child).map(NodeId::new)
    }

    fn only_child(&self, node: NodeId) -> Option<NodeId> {
        let is_child = |child: &usize| self.parents[*child] == Some(node.index());
        let mut children = (node.index() + 1..self.parents.len()).filter(is_child);
        let child = children.next()?;
        children.next().is_none().then(|| NodeId::new(child))
    }

    fn trunk_and_neck(&mut self, scene: &Scene) {
        let is_joint = |node: &NodeId| scene.nodes[node.index()].kind == NodeKind::Joint;
        let named = |bones: &[Bone]| -> Vec<NodeId> { bones.iter().filter_map(|bone| self.joint(*bone)).collect() };
        let spine = named(&[Bone::Spine, Bone::Chest, Bone::UpperChest]);
        let top = self.joint(Bone::Neck).or(self.joint(Bone::Head));
        // From the hips up, unless the head is the root of the body.
        let trunk = top.and_then(|top| self.path(self.hips, top));
        let trunk = trunk.map(|path| path.into_iter().filter(is_joint).collect::<Vec<_>>());
        let trunk = trunk.filter(|path| spine.iter().all(|joint| path.contains(joint)));
        let neck = named(&[Bone::Neck]);
        let between = self.joint(Bone::Neck).zip(self.joint(Bone::Head));
        let between = between.and_then(|(neck, head)| self.path(neck, head));
        let between = between.unwrap_or_default().into_iter().filter(is_joint);
        let neck = neck.into_iter().chain(between).collect();
        // Joints below the spine, as a second pelvis, belong to the hips.
        let trunk = trunk.map(|mut path| {
            let first = spine
                .first()
                .and_then(|spine| path.iter().position(|node| node == spine));
            path.drain(..first.unwrap_or(0));
            path
        });
        self.trunk = trunk.unwrap_or(spine);
        self.neck = neck;
    }

    fn leg_length(&self) -> f32 {
        let way = |from: Bone, to: Bone| {
            let (from, to) = (self.joint(from)?, self.joint(to)?);
            Some(self.position(from).distance(self.position(to)))
        };
        let leg = |upper: Bone, lower: Bone, foot: Bone| Some(way(upper, lower)? + way(lower, foot).unwrap_or(0.0));
        let left = leg(Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot);
        let right = leg(Bone::RightUpperLeg, Bone::RightLowerLeg, Bone::RightFoot);
        match (left, right) {
            (Some(left), Some(right)) => 0.5 * (left + right),
            _ => 0.0,
        }
    }
}

/// Whether two feet that stand are rolled by the same angle, inwards or outwards, more than feet are that stand on
/// their soles.
fn is_mirrored(left: f32, right: f32) -> bool {
    (left + right).abs() <= UNEQUAL_ROLL && (SMALLEST_ROLL..=LEVELLED).contains(&(0.5 * (left - right)).abs())
}

/// The bone that ends a bone of a limb.
pub(super) fn limb_end(bone: Bone) -> Option<Bone> {
    let next = match bone.on(Side::Left) {
        Bone::LeftUpperLeg => Bone::LeftLowerLeg,
        Bone::LeftLowerLeg => Bone::LeftFoot,
        Bone::LeftUpperArm => Bone::LeftLowerArm,
        Bone::LeftLowerArm => Bone::LeftHand,
        _ => return None,
    };
    Some(next.on(bone.side()?))
}

/// The next bone of a finger.
fn next_of_finger(bone: Bone) -> Option<Bone> {
    Bone::ALL
        .iter()
        .copied()
        .find(|next| next.is_finger() && bone.is_finger() && next.parent() == Some(bone))
}

/// With the sides that the body has, where the names say the opposite.
fn sides_of_the_body(mut humanoid: Humanoid) -> Humanoid {
    if humanoid.sides == Sides::Opposite {
        let bones = std::mem::take(&mut humanoid.bones);
        humanoid.bones = bones
            .into_iter()
            .map(|(bone, joint)| (bone.mirrored(), joint))
            .collect();
        humanoid.sides = Sides::Agree;
    }
    humanoid
}
