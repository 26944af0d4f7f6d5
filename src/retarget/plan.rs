//! The plan of a retargeting: which joints of the target follow which joints of the source, and how.

use std::collections::{BTreeMap, HashMap};

use glam::Quat;
use mocap_figure::body::Body;
use mocap_figure::names::Name;
use mocap_figure::t_pose::{direction, limb_end};
use mocap_figure::track::{Ends, Track, ends, is_twisted_at_beginning};
use mocap_figure::vrm_humanoid::ENDS;
use mocap_figure::watched::WatchedJoints;
use mocap_figure::{HumanoidBone as Bone, Side};
use mocap_scene::scene::{NodeId, NodeKind, Scene};
use serde::{Deserialize, Serialize};

use super::rules::{Drive, ParentRule, Rule, Twist};

/// A bone that is not retargeted.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct UnmappedBone {
    /// The bone.
    pub bone: Bone,
    /// The reason, as one phrase.
    pub reason: String,
}

/// The part of a retargeting that does not depend on the pose.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) watched: WatchedJoints,
    pub(super) tracks: Vec<Track>,
    pub(super) twists: Vec<Twist>,
    /// The driven joints in the order of the target's nodes, so that parents come before children.
    pub(super) drives: Vec<Drive>,
    /// The index of the hips among the driven joints.
    pub(super) hips: Option<usize>,
    pub(super) unmapped: Vec<UnmappedBone>,
}

impl Plan {
    pub(super) fn new(from: &Body, to: &Body, target: &Scene) -> Self {
        let mut builder = Builder {
            from,
            to,
            watched: WatchedJoints::default(),
            tracks: Vec::new(),
            twists: Vec::new(),
            known: HashMap::new(),
            drives: BTreeMap::new(),
            unmapped: Vec::new(),
        };
        builder.trunk_and_neck();
        for &bone in Bone::ALL {
            builder.bone(bone, target);
        }
        builder.joints_of_one_name(target);
        let mut drives: Vec<Drive> = builder.drives.into_values().collect();
        let index_of: HashMap<usize, usize> = drives.iter().map(|drive| drive.node.index()).zip(0..).collect();
        for drive in &mut drives {
            drive.above = above(to, drive.node, &index_of);
        }
        Self {
            watched: builder.watched,
            tracks: builder.tracks,
            twists: builder.twists,
            hips: index_of.get(&to.hips.index()).copied(),
            drives,
            unmapped: builder.unmapped,
        }
    }
}

/// The joint that the parent of `node` follows: the nearest ancestor in `drives`, which maps nodes to indices.
fn above(to: &Body, node: NodeId, drives: &HashMap<usize, usize>) -> ParentRule {
    let mut between = Quat::IDENTITY;
    let mut next = to.hierarchy.parents[node.index()];
    let direct = next;
    while let Some(parent) = next {
        if let Some(&drive) = drives.get(&parent) {
            let between = (direct != Some(parent)).then(|| between.inverse());
            return ParentRule::Drive { drive, between };
        }
        between = (to.rest_rotations[parent] * between).normalize();
        next = to.hierarchy.parents[parent];
    }
    ParentRule::Still((between.inverse() * to.axes).normalize())
}

struct Builder<'a> {
    from: &'a Body,
    to: &'a Body,
    watched: WatchedJoints,
    tracks: Vec<Track>,
    twists: Vec<Twist>,
    /// The index of each track. The key is the node of the track, and whether the track has the direction of a bone.
    known: HashMap<(NodeId, bool), usize>,
    drives: BTreeMap<NodeId, Drive>,
    unmapped: Vec<UnmappedBone>,
}

impl Builder<'_> {
    /// The track of a joint of the source that moves with `bone`.
    fn track(&mut self, bone: Bone, node: NodeId, ends: Option<Ends>) -> usize {
        let next = self.tracks.len();
        let track = *self.known.entry((node, ends.is_some())).or_insert(next);
        if track == next {
            let track = Track::new(self.from, bone, node, ends, &mut self.watched);
            self.tracks.push(track);
        }
        track
    }

    /// The track of a whole bone: its direction, and the twist of its end.
    fn whole(&mut self, bone: Bone) -> Option<usize> {
        let (node, ends) = ends(self.from, bone)?;
        Some(self.track(bone, node, ends))
    }

    fn drive(&mut self, bone: Bone, node: NodeId, rule: Rule) {
        let drive = || Drive {
            node,
            rest: self.to.rest[node.index()],
            frame_to_joint: self.to.frame_to_joint(bone, node),
            above: ParentRule::Still(Quat::IDENTITY),
            rule,
        };
        self.drives.entry(node).or_insert_with(drive);
    }

    fn copy(&mut self, bone: Bone, node: NodeId, track: usize) {
        let (from, to, fraction) = (track, track, 0.0);
        self.drive(bone, node, Rule::Between { from, to, fraction });
    }

    /// Drives the joints of a chain by a chain with another number of joints. Each joint takes the rotation of the
    /// source's chain at the same fraction of the chain, counted in joints from `base`.
    fn chain(&mut self, bone: Bone, base: usize, tracks: &[usize], joints: &[NodeId]) {
        let (have, want) = (tracks.len(), joints.len());
        for (index, &joint) in joints.iter().enumerate() {
            let (whole, rest) = ((index + 1) * have / want, (index + 1) * have % want);
            let at = |index: usize| if index == 0 { base } else { tracks[index - 1] };
            let rule = Rule::Between {
                from: at(whole),
                to: at((whole + 1).min(have)),
                fraction: rest as f32 / want as f32,
            };
            self.drive(bone, joint, rule);
        }
    }

    fn trunk_and_neck(&mut self) {
        let Some(hips) = self.whole(Bone::Hips) else { return };
        self.copy(Bone::Hips, self.to.hips, hips);
        let trunk: Vec<_> = self
            .from
            .trunk
            .iter()
            .map(|joint| self.track(Bone::Spine, *joint, None))
            .collect();
        self.chain(Bone::Spine, hips, &trunk, &self.to.trunk);
        let top = trunk.last().copied().unwrap_or(hips);
        let mut neck: Vec<_> = self
            .from
            .neck
            .iter()
            .map(|joint| self.track(Bone::Neck, *joint, None))
            .collect();
        let mut joints = self.to.neck.clone();
        if neck.is_empty() {
            // The rotation of the head is spread over the neck, and the head takes the last part.
            neck.extend(self.whole(Bone::Head));
            joints.extend(self.to.joint(Bone::Head));
        }
        if !neck.is_empty() {
            self.chain(Bone::Neck, top, &neck, &joints);
        }
    }

    fn bone(&mut self, bone: Bone, target: &Scene) {
        let is_of_chain = matches!(bone, Bone::Spine | Bone::Chest | Bone::UpperChest | Bone::Neck);
        if bone == Bone::Hips || is_of_chain {
            return;
        }
        let (from, to) = (self.from.joint(bone), self.to.joint(bone));
        let lacks = match (from, to) {
            (None, None) => return,
            (Some(_), None) => "the target has no such joint",
            (None, Some(to)) => match self.follow_above(bone, to) {
                true => "the source has no such joint; the target's joint follows its parent bone",
                false => "the source has no such joint; the target's joint keeps its rest pose",
            },
            (Some(_), Some(_)) => {
                self.limb(bone, target);
                return;
            }
        };
        let reason = lacks.to_owned();
        self.unmapped.push(UnmappedBone { bone, reason });
    }

    /// Whether a head, hand or foot that the source lacks follows the target's parent bone, as in a VRM animation.
    /// Otherwise it keeps its rest pose, in which a palm may face up.
    fn follow_above(&mut self, bone: Bone, joint: NodeId) -> bool {
        let mut above = std::iter::successors(bone.parent(), |above| above.parent());
        let above = above.find(|above| self.from.joint(*above).is_some());
        let track = above
            .filter(|_| ENDS.contains(&bone))
            .and_then(|above| self.whole(above));
        if let Some(track) = track {
            self.copy(bone, joint, track);
        }
        track.is_some()
    }

    fn limb(&mut self, bone: Bone, target: &Scene) {
        let (mine, theirs) = (self.to.segment(bone), self.from.segment(bone));
        let Some(whole) = self.whole(bone) else { return };
        let name = |body: &Body, joint: &NodeId| body.names[joint.index()].clone();
        let is_same = mine.len() == theirs.len()
            && std::iter::zip(&mine, &theirs).all(|(joint, other)| name(self.to, joint) == name(self.from, other));
        if is_same && mine.len() > 1 && self.has_rest_of_others() {
            for (joint, other) in std::iter::zip(&mine, &theirs) {
                let track = self.track(bone, *other, None);
                self.copy(bone, *joint, track);
            }
        } else {
            self.share_twist(bone, whole, &mine, target);
        }
    }

    /// Whether the T-poses of both bodies show the rotation of joints that are not bones. The computed T-pose of a body
    /// does not.
    fn has_rest_of_others(&self) -> bool {
        [self.from, self.to].iter().all(|body| !body.is_computed())
    }

    /// Drives the joints of a bone, and the helpers next to it, by fractions of its twist. A thigh or an upper arm is
    /// twisted at its end and not at its beginning. A shin or a forearm takes a part of the twist of the bone at its
    /// end.
    fn share_twist(&mut self, bone: Bone, whole: usize, segment: &[NodeId], target: &Scene) {
        let side = bone.side().unwrap_or(Side::Left);
        let ends = limb_end(bone).and_then(|end| self.to.joint(bone).zip(self.to.joint(end)));
        let helpers = ends.map_or(Vec::new(), |(start, end)| self.helpers(segment, start, end, target));
        let axis = direction(bone).filter(|_| segment.len() > 1 || !helpers.is_empty());
        let other = match bone.on(Side::Left) {
            Bone::LeftUpperLeg => self.whole(Bone::Hips),
            Bone::LeftUpperArm => self.whole(Bone::LeftShoulder.on(side)).or_else(|| {
                let top = self.from.trunk.last().copied()?;
                Some(self.track(Bone::Spine, top, None))
            }),
            Bone::LeftLowerLeg => self.whole(Bone::LeftFoot.on(side)),
            Bone::LeftLowerArm => self.whole(Bone::LeftHand.on(side)),
            _ => None,
        };
        let (Some(axis), Some(other), Some((_, end))) = (axis, other, ends) else {
            segment.iter().for_each(|joint| self.copy(bone, *joint, whole));
            return;
        };
        let at_beginning = is_twisted_at_beginning(bone);
        let count = segment.len() as f32;
        let fraction = |index: usize| match at_beginning {
            true => 1.0 - (index + 1) as f32 / count,
            false => index as f32 / count,
        };
        let nexts = segment.iter().skip(1).chain([&end]);
        let joints = segment.iter().zip(nexts).enumerate().map(|(index, (joint, next))| {
            let to_frame = self.to.frame_to_joint(bone, *joint) * self.to.rotation(*joint).inverse();
            (
                fraction(index),
                to_frame * (self.to.position(*next) - self.to.position(*joint)),
            )
        });
        let joints: Vec<_> = joints.collect();
        let twist = self.twists.len();
        let placed: Vec<_> = joints.iter().map(|(fraction, _)| *fraction).collect();
        self.twists.push(Twist {
            bone: whole,
            other,
            axis,
            joints,
        });
        for (&joint, fraction) in segment.iter().zip(placed) {
            self.drive(bone, joint, Rule::Twisted { twist, fraction });
        }
        for (helper, along) in helpers {
            let fraction = if at_beginning { 1.0 - along } else { along };
            self.drive(bone, helper, Rule::Twisted { twist, fraction });
        }
    }

    /// The helper joints that spread the twist of a bone over the skin, found by their names. Each has its position
    /// along the bone, from 0 to 1.
    fn helpers(&self, segment: &[NodeId], start: NodeId, end: NodeId, target: &Scene) -> Vec<(NodeId, f32)> {
        let start = self.to.position(start);
        let line = self.to.position(end) - start;
        let mut helpers = Vec::new();
        for (index, node) in target.nodes.iter().enumerate() {
            let id = NodeId::new(index);
            let is_named = node.kind == NodeKind::Joint && Name::read(&node.name).is_twist;
            let is_child = node.parent.is_some_and(|parent| segment.contains(&parent));
            let is_bone = segment.contains(&id) || self.to.bones.values().any(|other| *other == id);
            let along = (self.to.position(id) - start).dot(line) / line.length_squared();
            if is_named && is_child && !is_bone && along.is_finite() {
                helpers.push((id, along.clamp(0.0, 1.0)));
            }
        }
        helpers
    }

    /// Drives joints that are not bones by the source's joints with the same name, if both depend on the same bone.
    fn joints_of_one_name(&mut self, target: &Scene) {
        if !self.has_rest_of_others() {
            return;
        }
        let bone_of = |body: &Body| -> HashMap<usize, Bone> {
            body.bones.iter().map(|(bone, joint)| (joint.index(), *bone)).collect()
        };
        let (from_bones, to_bones) = (bone_of(self.from), bone_of(self.to));
        let carrier = |body: &Body, bones: &HashMap<usize, Bone>, node: usize| {
            let above = std::iter::successors(body.hierarchy.parents[node], |node| body.hierarchy.parents[*node]);
            above.filter_map(|node| bones.get(&node).copied()).next()
        };
        let mut by_name: HashMap<&str, Option<usize>> = HashMap::new();
        for (index, name) in self.from.names.iter().enumerate() {
            // A repeated name identifies no joint.
            by_name
                .entry(name)
                .and_modify(|known| *known = None)
                .or_insert(Some(index));
        }
        for (index, node) in target.nodes.iter().enumerate() {
            let id = NodeId::new(index);
            if node.kind != NodeKind::Joint || self.drives.contains_key(&id) || to_bones.contains_key(&index) {
                continue;
            }
            let Some(&Some(other)) = by_name.get(node.name.as_str()) else {
                continue;
            };
            if from_bones.contains_key(&other) {
                continue;
            }
            let carriers = carrier(self.from, &from_bones, other).zip(carrier(self.to, &to_bones, index));
            if let Some((bone, same)) = carriers
                && bone == same
            {
                let track = self.track(bone, NodeId::new(other), None);
                self.copy(bone, id, track);
            }
        }
    }
}
