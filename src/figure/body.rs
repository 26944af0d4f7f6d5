//! A humanoid with the coordinate frames of its T-pose.

use std::collections::BTreeMap;

use glam::{Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::{FrameBudget, Limits};
use mocap_scene::pose::Trs;
use mocap_scene::scene::{NodeId, NodeKind, Scene, Side, Topic};

use crate::axes::bend_axis;
use crate::hierarchy::Hierarchy;
use crate::knuckles::Knuckles;
use crate::report::{TPoseBone, TPoseReason, TPoseSource};
use crate::t_pose::{self, limb_end};
use crate::{Confidence, Figure, HumanoidBone as Bone, TPose};

/// A motion with fewer frames than this number may show only one part of a step. This was measured on motions whose
/// rest pose is not a standing pose. In excerpts of 20 to 24 frames, feet, pelvis and head deviate by up to 37 degrees
/// from the whole motion.
const FEW_FRAMES: usize = 30;

/// A motion with fewer frames than this number is no evidence.
const TOO_FEW_FRAMES: usize = 5;

/// A humanoid with the coordinate frames of its T-pose.
#[derive(Clone, Debug)]
pub struct Body {
    /// The rotation from the T-pose's coordinate frame (+X left, +Y up, +Z forward) to the world.
    pub axes: Quat,
    /// The figure. Its left and right bones are on the left and right of the body, even if the names exchange both.
    pub figure: Figure,
    pub hips: NodeId,
    pub bones: BTreeMap<Bone, NodeId>,
    /// The assumed up axis of the file, if nothing shows the axis.
    unsure_up: Option<String>,
    /// The T-pose, and the reference pose from which it is made.
    t_pose: TPose,
    /// The scene's nodes.
    pub hierarchy: Hierarchy,
    knuckles: Knuckles,
    pub names: Vec<String>,
    pub rest_rotations: Vec<Quat>,
    pub rest: Vec<Trs>,
    /// Joints between the hips and the neck, from the bottom up.
    pub trunk: Vec<NodeId>,
    /// Joints from the neck up to the head, without the head.
    pub neck: Vec<NodeId>,
    /// Metres per unit of length.
    pub metres_per_unit: f64,
    /// The length of thigh plus shin, averaged over both sides.
    pub leg: f32,
}

impl Body {
    /// The help text for the error that a scene has no humanoid.
    pub fn help(scene: &Scene) -> &'static str {
        match scene.has_points() {
            true => "solve a skeleton from the markers: {markers} auto, or mocap solve",
            false => "name the bones of the skeleton in a map, or choose another file",
        }
    }

    /// The body of `figure`, the figure of `scene`. `role` names the scene in errors.
    pub fn of_figure(scene: &Scene, mut figure: Figure, role: &str) -> Result<Self> {
        // Every user of a body samples the frames of the scene, so their number is limited here.
        FrameBudget::of_scene(&Limits::default()).check(scene)?;
        let refused = |reason: String| -> mocap_scene::error::Error {
            Diagnostic::new(Code::NotHumanoid, format!("the {role} is not a humanoid: {reason}"))
                .help(Self::help(scene))
                .into()
        };
        let Some(t_pose) = figure.t_pose(scene).cloned() else {
            return Err(refused(figure.humanoid.reason));
        };
        let bones: BTreeMap<Bone, NodeId> = t_pose.bones.iter().map(|(bone, found)| (*bone, found.joint)).collect();
        for bone in [
            Bone::Hips,
            Bone::LeftUpperLeg,
            Bone::LeftLowerLeg,
            Bone::RightUpperLeg,
            Bone::RightLowerLeg,
        ] {
            if !bones.contains_key(&bone) {
                return Err(refused(format!("no joint has the bone {}", bone.as_str())));
            }
        }
        let rest: Vec<Trs> = scene
            .nodes
            .iter()
            .map(|node| Trs::from_matrix(node.transform))
            .collect();
        figure.humanoid = figure.humanoid.with_sides_of_the_body();
        let hierarchy = Hierarchy::new(scene);
        // If a step has already rotated the scene upright, the guess of the up axis is in the record of this step.
        let mut assumptions = figure
            .survey
            .assumptions()
            .into_iter()
            .chain(scene.metadata.assumptions.iter().cloned());
        let unsure_up = assumptions.find(|all| all.topic == Topic::Up && all.confidence == Some(Confidence::Unsure));
        let mut body = Self {
            unsure_up: unsure_up.map(|up| up.choice),
            knuckles: Knuckles::new(scene, &hierarchy, &bones),
            axes: t_pose.axes,
            hips: bones[&Bone::Hips],
            t_pose,
            rest_rotations: rest.iter().map(|trs| trs.rotation).collect(),
            names: scene.nodes.iter().map(|node| node.name.clone()).collect(),
            rest,
            trunk: Vec::new(),
            neck: Vec::new(),
            metres_per_unit: figure.survey.metres_per_unit,
            leg: 0.0,
            figure,
            hierarchy,
            bones,
        };
        body.trunk_and_neck(scene);
        body.leg = body.leg_length();
        if !(body.leg.is_finite() && body.leg > 0.0) {
            return Err(refused("the legs have no length at rest".to_owned()));
        }
        Ok(body)
    }

    /// The target body of a retargeting.
    pub fn target(scene: &Scene, figure: Figure) -> Result<Self> {
        let body = Self::of_figure(scene, figure, "target")?;
        body.check_target(scene)?;
        Ok(body)
    }

    /// Refuses a target with bones that are not below its hips. Moving the hips would not move such a bone.
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

    pub fn joint(&self, bone: Bone) -> Option<NodeId> {
        self.bones.get(&bone).copied()
    }

    /// Whether a node is a descendant of another.
    pub fn depends_on(&self, node: NodeId, ancestor: NodeId) -> bool {
        self.hierarchy.is_below(node, ancestor)
    }

    /// The joints of a bone: its own joint, and the joints between it and the next bone.
    pub fn segment(&self, bone: Bone) -> Vec<NodeId> {
        let Some(joint) = self.joint(bone) else {
            return Vec::new();
        };
        let mut joints = vec![joint];
        if let Some(end) = limb_end(bone).and_then(|next| self.joint(next)) {
            joints.extend(self.hierarchy.path(joint, end).unwrap_or_default());
        }
        joints
    }

    /// The rotation from the coordinate frame of `bone` to a joint that moves with it: the joint's rotation in the
    /// T-pose.
    pub fn frame_to_joint(&self, bone: Bone, joint: NodeId) -> Quat {
        self.t_pose.frame_to_joint(bone, joint)
    }

    /// Converts a vector that is fixed to `bone`: from its direction in the reference pose to its direction in the
    /// T-pose, in the axes of the figure.
    pub(crate) fn to_frame(&self, bone: Bone, vector: Vec3) -> Vec3 {
        self.axes.inverse() * self.t_pose.reference_to_t_pose(bone) * vector
    }

    /// The direction of a limb's bone in the T-pose, from its joint to its end, in the coordinate frame of the bone. If
    /// the file states the T-pose, as a VRM animation does, limbs may not point exactly down or sideways.
    pub(crate) fn direction(&self, bone: Bone, joint: NodeId, end: NodeId) -> Option<Vec3> {
        let usual = t_pose::direction(bone)?;
        let is_stated = self
            .t_pose
            .bones
            .get(&bone)
            .is_some_and(|found| found.reason == TPoseReason::Stands);
        let stated = is_stated.then(|| self.to_frame(bone, self.position(end) - self.position(joint)));
        Some(stated.and_then(Vec3::try_normalize).unwrap_or(usual))
    }

    /// The position of a node in the reference pose, before any limb is rotated to the T-pose.
    pub fn position(&self, node: NodeId) -> Vec3 {
        self.t_pose.positions[node.index()]
    }

    /// The world rotation of a node in the reference pose.
    pub fn rotation(&self, node: NodeId) -> Quat {
        self.t_pose.rotations[node.index()]
    }

    /// Whether the T-pose is computed from the bones, because the figure does not stand in its rest pose.
    pub fn is_computed(&self) -> bool {
        self.t_pose.source == TPoseSource::Computed
    }

    /// Whether the T-pose is made from the rest pose, because the figure stands in its rest pose.
    pub fn stands_at_rest(&self) -> bool {
        self.t_pose.source == TPoseSource::RestPose
    }

    /// Whether neither the rest pose nor the motion shows the orientation of the whole body. The motion has too few
    /// frames, or nothing shows which axis is up, or which side is left.
    pub fn is_turned_by_guess(&self) -> bool {
        let is_unsure = self.unsure_up.is_some() || self.are_sides_unsure();
        self.is_computed() && (is_unsure || self.t_pose.frames < TOO_FEW_FRAMES)
    }

    /// Whether neither names nor the body distinguish left from right.
    fn are_sides_unsure(&self) -> bool {
        let leg = self.figure.humanoid.bones.get(&Bone::LeftUpperLeg);
        let is_unsure = leg.is_some_and(|leg| leg.confidence == Confidence::Unsure);
        is_unsure && self.figure.humanoid.sides_confidence == Confidence::Unsure
    }

    /// The bones whose roll is not certain, each with the reason. These are limbs, hands, neck and head if only an
    /// average shows their roll. If only a few frames show the rolls, hips and feet are uncertain, too.
    pub fn guessed(&self) -> Vec<(Bone, String)> {
        if !self.is_computed() {
            return Vec::new();
        }
        let frames = self.t_pose.frames;
        let guess = |(&bone, found): (&Bone, &TPoseBone)| {
            let is_limb = bend_axis(bone).is_some();
            let is_end = matches!(bone.on(Side::Left), Bone::LeftHand | Bone::Neck | Bone::Head);
            let is_base = matches!(bone.on(Side::Left), Bone::Hips | Bone::LeftFoot);
            let (is_unsure, how) = (found.confidence == Confidence::Unsure, found.reason.as_str());
            let reason = match frames < FEW_FRAMES {
                true if is_limb || is_end || is_base => {
                    format!("turned to its average over only {frames} frames")
                }
                false if is_unsure && is_limb => {
                    format!("rolled {how}: the motion does not bend it enough")
                }
                false if is_unsure && is_end => format!("rolled {how}: the file has no other evidence"),
                _ => return None,
            };
            Some((bone, reason))
        };
        let up = self.unsure_up.iter().map(|up| {
            let reason = format!("turned for the up axis {up}, which is only a guess: state the up axis of the file");
            (Bone::Hips, reason)
        });
        let sides = self.are_sides_unsure().then(|| {
            let reason = &self.figure.humanoid.sides_reason;
            (Bone::Hips, format!("left and right may be exchanged: {reason}"))
        });
        let turned = self.t_pose.bones.iter().filter_map(guess);
        up.chain(sides).chain(turned).collect()
    }

    /// The up direction in the world.
    pub fn up(&self) -> Vec3 {
        self.axes * Vec3::Y
    }

    /// The node towards which a bone points: the joint of the next bone, or otherwise the only child of the bone's
    /// joint.
    pub(crate) fn next(&self, bone: Bone, joint: NodeId) -> Option<NodeId> {
        t_pose::next(&self.hierarchy, &self.bones, &self.knuckles, bone, joint)
    }

    /// The joint of a foot or of its toes; for toes without a joint, the first child node of the ankle.
    pub fn foot_joint(&self, bone: Bone) -> Option<NodeId> {
        let below = || self.hierarchy.first_child(self.joint(Bone::LeftFoot.on(bone.side()?))?);
        match bone.on(Side::Left) {
            Bone::LeftToes => self.joint(bone).or_else(below),
            _ => self.joint(bone),
        }
    }

    /// The height of a joint of the foot when the body stands. `ankle` is the height of the ankles in this pose.
    pub fn standing_height(&self, bone: Bone, ankle: f32) -> f32 {
        let joint = self.foot_joint(bone);
        let foot = self.joint(Bone::LeftFoot.on(bone.side().unwrap_or(Side::Left)));
        let above = |(joint, foot): (NodeId, NodeId)| (self.position(joint) - self.position(foot)).dot(self.up());
        ankle + joint.zip(foot).map_or(0.0, above)
    }

    fn trunk_and_neck(&mut self, scene: &Scene) {
        let is_joint = |node: &NodeId| scene.nodes[node.index()].kind == NodeKind::Joint;
        let named = |bones: &[Bone]| -> Vec<NodeId> { bones.iter().filter_map(|bone| self.joint(*bone)).collect() };
        let spine = named(&[Bone::Spine, Bone::Chest, Bone::UpperChest]);
        let top = self.joint(Bone::Neck).or(self.joint(Bone::Head));
        // The path goes from the hips upwards, unless the head is the root of the skeleton.
        let trunk = top.and_then(|top| self.hierarchy.path(self.hips, top));
        let trunk = trunk.map(|path| path.into_iter().filter(is_joint).collect::<Vec<_>>());
        let trunk = trunk.filter(|path| spine.iter().all(|joint| path.contains(joint)));
        let neck = named(&[Bone::Neck]);
        let between = self.joint(Bone::Neck).zip(self.joint(Bone::Head));
        let between = between.and_then(|(neck, head)| self.hierarchy.path(neck, head));
        let between = between.unwrap_or_default().into_iter().filter(is_joint);
        let neck = neck.into_iter().chain(between).collect();
        // Joints between the hips and the spine, such as a second pelvis, belong to the hips.
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
        let length_between = |from: Bone, to: Bone| {
            let (from, to) = (self.joint(from)?, self.joint(to)?);
            Some(self.position(from).distance(self.position(to)))
        };
        let leg = |upper: Bone, lower: Bone, foot: Bone| {
            Some(length_between(upper, lower)? + length_between(lower, foot).unwrap_or(0.0))
        };
        let left = leg(Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot);
        let right = leg(Bone::RightUpperLeg, Bone::RightLowerLeg, Bone::RightFoot);
        match (left, right) {
            (Some(left), Some(right)) => 0.5 * (left + right),
            _ => 0.0,
        }
    }
}
