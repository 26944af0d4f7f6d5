//! The joints of the target that move, and the joints of the source that they follow.

use std::collections::HashMap;

use glam::{Mat3, Quat, Vec3};
use mocap_figure::animal::Standing;
use mocap_figure::report::{Quadruped, QuadrupedLeg};
use mocap_scene::math::directions::{arc, rotation_of};
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::{NodeId, NodeKind, Scene};

use super::{SEGMENTS, Segment};
use crate::by_names::key;
use crate::plan::UnmappedBone;

/// The cosine of 45 degrees. If the directions of a segment in the two standing poses differ by a larger angle, the
/// segment has another role. The foot of a bear lies on the ground, but a dog stands on its toes.
const OTHER_ROLE: f32 = 0.7;

/// The cosine of the angle between a segment and the body's left direction. Above this cosine, both directions are so
/// near that the left direction does not determine the roll of the segment.
const SIDEWAYS: f32 = 0.8;

/// The rule for the rotation of a joint in the world. `was` has inverse rotations of source joints in the standing
/// pose.
#[derive(Clone, Copy, Debug)]
enum Rule {
    /// The rotation, since the standing pose, of a point between two joints of the source.
    Turn {
        joints: [NodeId; 2],
        fraction: f32,
        was: [Quat; 2],
    },
    /// The direction between two points, and the roll of a joint.
    Aim {
        joint: NodeId,
        was: Quat,
        points: [Point; 2],
    },
    /// The rotation of a joint relative to its parent. `across` rotates from the source's to the target's standing
    /// pose.
    Relative {
        joints: [NodeId; 2],
        was: [Quat; 2],
        across: Quat,
        parent_was: Quat,
    },
}

/// A point on the line between two joints.
#[derive(Clone, Copy, Debug)]
struct Point {
    joints: [NodeId; 2],
    fraction: f32,
}

impl Point {
    const fn at(joint: NodeId) -> Self {
        Self {
            joints: [joint; 2],
            fraction: 0.0,
        }
    }

    fn position(&self, pose: &Pose) -> Vec3 {
        let [from, to] = self.joints.map(|joint| pose.position(joint));
        from.lerp(to, self.fraction)
    }
}

/// A joint of the target that moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drive {
    pub(super) node: NodeId,
    rule: Rule,
    /// The coordinate frame of the source in its standing pose.
    frame: Quat,
    /// The rotation from the coordinate frame of the target to its joint, in the standing pose.
    after: Quat,
    /// The transform of the joint in the standing pose, relative to its parent.
    pub(super) stands: Trs,
}

impl Drive {
    /// The rotation of the joint in the world of the target. `above` is the rotation of its parent.
    pub(super) fn rotation(&self, from: &Pose, to_target: Quat, above: Quat) -> Quat {
        let now = |joint: NodeId| rotation_of(&from.node_to_world[joint.index()]);
        match self.rule {
            Rule::Turn { joints, fraction, was } => {
                let one = now(joints[0]) * was[0];
                let turned = match joints[0] == joints[1] {
                    true => one,
                    false => one.slerp(now(joints[1]) * was[1], fraction),
                };
                to_target * turned * self.frame * self.after
            }
            Rule::Aim { joint, was, points } => {
                let turned = now(joint) * was * self.frame;
                let [begin, end] = points.each_ref().map(|point| point.position(from));
                to_target * arc(turned * Vec3::Z, end - begin) * turned * self.after
            }
            Rule::Relative {
                joints,
                was,
                across,
                parent_was,
            } => {
                let [parent, own] = [now(joints[0]) * was[0], now(joints[1]) * was[1]];
                let relative = parent.inverse() * own;
                above * parent_was * across * relative * across.inverse() * self.after
            }
        }
    }
}

/// Collects the drives.
pub(super) struct Drives<'a> {
    source: &'a Scene,
    animal: &'a Quadruped,
    from: &'a Standing,
    target: &'a Scene,
    other: &'a Quadruped,
    to: &'a Pose,
    /// The rotation from left, up and forward of the standing target to the world.
    axes: Quat,
    drives: Vec<Drive>,
    /// Joints of the source that a joint of the target follows.
    used: Vec<bool>,
    segments: Vec<Segment>,
    unmapped: Vec<UnmappedBone>,
    root: NodeId,
}

impl<'a> Drives<'a> {
    pub(super) fn new(
        source: &'a Scene,
        (animal, from): (&'a Quadruped, &'a Standing),
        target: &'a Scene,
        (other, to, axes): (&'a Quadruped, &'a Pose, Quat),
    ) -> Self {
        Self {
            used: vec![false; source.nodes.len()],
            root: common(target, &[other.pelvis, other.withers]),
            source,
            animal,
            from,
            target,
            other,
            to,
            axes,
            drives: Vec::new(),
            segments: Vec::new(),
            unmapped: Vec::new(),
        }
    }

    pub(super) fn add_all(&mut self) {
        let trunk = |animal: &Quadruped| {
            let mut nodes = vec![animal.pelvis];
            nodes.extend(&animal.spine);
            nodes.push(animal.withers);
            nodes.dedup();
            nodes
        };
        if self.root != self.other.pelvis && self.root != self.other.withers {
            self.turn(self.root, [self.animal.pelvis; 2], 0.0);
        }
        self.along(&trunk(self.animal), &trunk(self.other));
        self.along(&self.animal.tail, &self.other.tail);
        self.neck();
        for (index, (from, to)) in self.animal.legs.iter().zip(&self.other.legs).enumerate() {
            self.leg(index, from, to);
        }
        self.of_one_name();
    }

    /// The joints of the source that no joint of the target follows.
    pub(super) fn lacking(&self) -> Vec<String> {
        let root = common(self.source, &[self.animal.pelvis, self.animal.withers]);
        let nodes = self.source.nodes.iter().enumerate();
        let lacking = nodes.filter(|(index, node)| {
            let is_free = node.kind == NodeKind::Joint && !self.used[*index];
            is_free && is_below(self.source, NodeId::new(*index), root, root)
        });
        lacking.map(|(_, node)| node.name.clone()).collect()
    }

    /// Returns the drives (parents before children), the segments of legs, the segments that are not compared, and the
    /// index of the drive that gets the path.
    pub(super) fn into_parts(mut self) -> (Vec<Drive>, Vec<Segment>, Vec<UnmappedBone>, usize) {
        self.drives.sort_by_key(|drive| drive.node.index());
        let root = self.drives.iter().position(|drive| drive.node == self.root);
        (self.drives, self.segments, self.unmapped, root.unwrap_or(0))
    }

    fn add(&mut self, node: NodeId, rule: Rule, frame: Quat, target_frame: Quat) {
        let is_new = self.drives.iter().all(|drive| drive.node != node);
        if is_new && self.target.nodes[node.index()].kind == NodeKind::Joint {
            self.drives.push(Drive {
                node,
                rule,
                frame,
                after: target_frame.inverse() * self.is(node),
                stands: Trs::from_matrix(self.to.node_to_parent[node.index()]),
            });
        }
    }

    /// The inverse of the rotation of the source's joint in the standing pose.
    fn was(&self, joint: NodeId) -> Quat {
        rotation_of(&self.from.pose.node_to_world[joint.index()]).inverse()
    }

    /// The rotation of the target's joint in the standing pose.
    fn is(&self, node: NodeId) -> Quat {
        rotation_of(&self.to.node_to_world[node.index()])
    }

    /// Drives a joint by the rotation of a point between two joints of the source.
    fn turn(&mut self, node: NodeId, joints: [NodeId; 2], fraction: f32) {
        let was = joints.map(|joint| self.was(joint));
        joints.iter().for_each(|joint| self.used[joint.index()] = true);
        self.add(node, Rule::Turn { joints, fraction, was }, self.from.axes, self.axes);
    }

    /// Drives the joints of a chain by the rotations of another chain. Each joint takes the rotation at its own
    /// fraction of the chain's length.
    fn along(&mut self, from: &[NodeId], to: &[NodeId]) {
        if from.is_empty() || to.is_empty() {
            return;
        }
        let (was, is) = (fractions(&self.from.pose, from), fractions(self.to, to));
        for (node, at) in to.iter().zip(is) {
            let point = point_at(from, &was, at);
            self.turn(*node, point.joints, point.fraction);
        }
        from.iter().for_each(|joint| self.used[joint.index()] = true);
    }

    /// Drives a joint that points from one point to another in the same direction as in the source.
    fn aim(&mut self, node: NodeId, end: NodeId, joint: NodeId, points: [Point; 2]) {
        let [begin, to] = points.each_ref().map(|point| point.position(&self.from.pose));
        let directions = [to - begin, self.to.position(end) - self.to.position(node)];
        self.used[joint.index()] = true;
        let axes = [self.from.axes, self.axes];
        let sideways = |side: Vec3| {
            let across = |index: usize| (axes[index] * side).dot(directions[index].normalize_or_zero()).abs();
            across(0).max(across(1))
        };
        let side = if sideways(Vec3::X) < SIDEWAYS { Vec3::X } else { Vec3::Z };
        let [Some(frame), Some(other)] = [0, 1].map(|index| frame(directions[index], axes[index] * side)) else {
            return self.turn(node, [joint; 2], 0.0);
        };
        let was = self.was(joint);
        self.add(node, Rule::Aim { joint, was, points }, frame, other);
    }

    /// Drives the joints of the neck and the head.
    fn neck(&mut self) {
        let chain = |animal: &Quadruped| {
            let mut nodes = animal.neck.clone();
            nodes.extend(animal.head);
            nodes
        };
        let (from, to) = (chain(self.animal), chain(self.other));
        let Some(&last) = from.last() else { return };
        if from.len() < 2 || to.len() < 2 {
            self.along(&from, &to);
            return;
        }
        let (was, is) = (fractions(&self.from.pose, &from), fractions(self.to, &to));
        for (pair, at) in to.windows(2).zip(is.windows(2)) {
            let points = [at[0], at[1]].map(|at| point_at(&from, &was, at));
            let [one, other] = points[0].joints;
            let joint = if points[0].fraction > 0.5 { other } else { one };
            self.aim(pair[0], pair[1], joint, points);
        }
        from.iter().for_each(|joint| self.used[joint.index()] = true);
        self.turn(to[to.len() - 1], [last; 2], 0.0);
    }

    fn leg(&mut self, index: usize, from: &QuadrupedLeg, to: &QuadrupedLeg) {
        if let (Some(joint), Some(node)) = (from.girdle, to.girdle) {
            self.turn(node, [joint; 2], 0.0);
        }
        let mut anchors = vec![[from.upper, to.upper], [from.lower, to.lower]];
        anchors.extend(from.ankle.zip(to.ankle).map(|(joint, node)| [joint, node]));
        anchors.push([from.paw, to.paw]);
        let axes = [self.from.axes.inverse(), self.axes.inverse()];
        for (segment, pair) in anchors.windows(2).enumerate() {
            let [[joint, node], [end, other]] = [pair[0], pair[1]];
            let was = axes[0] * (self.from.pose.position(end) - self.from.pose.position(joint));
            let is = axes[1] * (self.to.position(other) - self.to.position(node));
            let cosine = was.normalize_or_zero().dot(is.normalize_or_zero());
            let bone = SEGMENTS[index][segment];
            if cosine < OTHER_ROLE {
                self.turn(node, [joint; 2], 0.0);
                let degrees = cosine.acos().to_degrees();
                self.unmapped.push(UnmappedBone {
                    bone,
                    reason: format!("its directions in the standing poses differ by {degrees:.0} degrees"),
                });
                continue;
            }
            self.aim(node, other, joint, [Point::at(joint), Point::at(end)]);
            self.segments.push(Segment {
                bone,
                source: [joint, end],
                target: [node, other],
            });
        }
        self.turn(to.paw, [from.paw; 2], 0.0);
    }

    /// Joints of the same name move relative to their parents as in the source: ears, jaws and toes.
    fn of_one_name(&mut self) {
        let is_joint = |scene: &Scene, node: NodeId| scene.nodes[node.index()].kind == NodeKind::Joint;
        let mut by_name: HashMap<String, NodeId> = HashMap::new();
        let pelvis = self.animal.pelvis;
        for node in (0..self.source.nodes.len()).map(NodeId::new) {
            let is_free = !self.used[node.index()] && is_joint(self.source, node);
            if is_free && is_below(self.source, node, pelvis, self.animal.withers) {
                by_name
                    .entry(key(&self.source.nodes[node.index()].name))
                    .or_insert(node);
            }
        }
        let across = self.axes * self.from.axes.inverse();
        for node in (0..self.target.nodes.len()).map(NodeId::new) {
            let own = &self.target.nodes[node.index()];
            let Some(&joint) = by_name.get(&key(&own.name)) else {
                continue;
            };
            let parents = own.parent.zip(self.source.nodes[joint.index()].parent);
            if let Some((above, parent)) = parents
                && is_below(self.target, node, self.other.pelvis, self.other.withers)
            {
                let rule = Rule::Relative {
                    joints: [parent, joint],
                    was: [self.was(parent), self.was(joint)],
                    across,
                    parent_was: self.is(above).inverse(),
                };
                self.used[joint.index()] = true;
                self.add(node, rule, Quat::IDENTITY, Quat::IDENTITY);
            }
        }
    }
}

/// Whether a node is below one of two nodes.
fn is_below(scene: &Scene, node: NodeId, one: NodeId, other: NodeId) -> bool {
    let mut above = std::iter::successors(scene.nodes[node.index()].parent, |node| {
        scene.nodes[node.index()].parent
    });
    above.any(|above| above == one || above == other)
}

/// The lowest common ancestor of two nodes. A node counts as its own ancestor.
fn common(scene: &Scene, nodes: &[NodeId; 2]) -> NodeId {
    let above = |node: NodeId| std::iter::successors(Some(node), |node| scene.nodes[node.index()].parent);
    let found = above(nodes[0]).find(|one| above(nodes[1]).any(|other| other == *one));
    found.unwrap_or(nodes[0])
}

/// The coordinate frame of a direction: +Z along the direction, +X towards a side. `None` if a vector has no length, or
/// if they are parallel.
fn frame(direction: Vec3, side: Vec3) -> Option<Quat> {
    let forward = direction.try_normalize()?;
    let side = side.reject_from_normalized(forward).try_normalize()?;
    Some(Quat::from_mat3(&Mat3::from_cols(side, forward.cross(side), forward)).normalize())
}

/// The position of each joint along a chain, from 0 at its start to 1 at its end.
fn fractions(pose: &Pose, chain: &[NodeId]) -> Vec<f32> {
    let mut lengths = vec![0.0_f32];
    for pair in chain.windows(2) {
        let length = pose.position(pair[0]).distance(pose.position(pair[1]));
        lengths.push(lengths[lengths.len() - 1] + length);
    }
    let whole = lengths[lengths.len() - 1];
    lengths.truncate(chain.len());
    let place = |length: &f32| if whole > 0.0 { length / whole } else { 0.0 };
    lengths.iter().map(place).collect()
}

/// The point of a chain at the position `at`. `places` has the positions of the joints.
fn point_at(chain: &[NodeId], places: &[f32], at: f32) -> Point {
    let next = places.iter().position(|place| *place >= at);
    match next {
        Some(next) if next > 0 => Point {
            joints: [chain[next - 1], chain[next]],
            fraction: (at - places[next - 1]) / (places[next] - places[next - 1]).max(f32::EPSILON),
        },
        Some(next) => Point::at(chain[next]),
        None => Point::at(chain[chain.len() - 1]),
    }
}
