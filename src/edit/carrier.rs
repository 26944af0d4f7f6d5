//! The position and the heading of a figure on the ground. Also rigid motions that move the whole figure over the
//! ground.

use glam::{Mat4, Quat, Vec3};
use mocap_figure::up;
use mocap_scene::math::quaternion::twist;
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::{NodeId, Scene};

use super::frames::Frames;

/// The node that carries the figure over the ground.
pub(super) struct Carrier {
    /// The index of this node in [`Frames::nodes`].
    pub(super) column: usize,
    /// The transform from the node's parent to the world. It is constant, because nothing above the node moves.
    parent: Mat4,
    rotation: Quat,
    pub(super) up: Vec3,
}

/// A rotation about the up axis and a translation over the ground.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    rotation: Quat,
    from: Vec3,
    to: Vec3,
}

impl Carrier {
    /// Chooses the topmost node whose position moves. If no position moves, chooses the topmost node.
    pub(super) fn new(scene: &Scene, frames: &Frames) -> Self {
        let moves = |column: &usize| {
            let track = frames.track(*column);
            track.windows(2).any(|pair| pair[0].translation != pair[1].translation)
        };
        let column = (0..frames.nodes().len()).find(moves).unwrap_or(0);
        let parent = match frames.nodes().get(column) {
            Some(node) => parent_at(scene, frames, *node, 0),
            None => Mat4::IDENTITY,
        };
        Self {
            column,
            rotation: Trs::from_matrix(parent).rotation,
            parent,
            up: up(scene).direction().unwrap_or(Vec3::Y),
        }
    }

    /// Gives the nodes above the figure in the motion `second` the transforms that these nodes have in the motion
    /// `first`. The transform of the figure is adapted, so that the figure stays where it is in the world.
    pub(super) fn share_parents(&self, scene: &Scene, first: &Frames, second: &mut Frames) {
        let Some(&node) = second.nodes().get(self.column) else {
            return;
        };
        let to_parent = self.parent.inverse();
        let parents: Vec<Mat4> = (0..second.len())
            .map(|frame| parent_at(scene, second, node, frame))
            .collect();
        if parents.iter().all(|parent| *parent == self.parent) {
            return;
        }
        let mut track = second.track(self.column);
        for (trs, parent) in track.iter_mut().zip(parents) {
            *trs = Trs::from_matrix(to_parent * parent * trs.matrix());
        }
        second.set_track(self.column, &track);
        for above in ancestors(scene, node) {
            if let Some(column) = second.nodes().iter().position(|node| *node == above) {
                second.set_track(column, &vec![first.at(0, column); second.len()]);
            }
        }
    }

    fn pose(&self, row: &[Trs]) -> (Vec3, Quat) {
        let trs = row[self.column];
        (
            self.parent.transform_point3(trs.translation),
            self.rotation * trs.rotation,
        )
    }

    /// The position of the figure in the world. `row` has the transforms of one frame.
    pub(super) fn position(&self, row: &[Trs]) -> Vec3 {
        self.pose(row).0
    }

    /// The rotation about the up axis from the heading in the frame `from` to the heading in the frame `to`. Each frame
    /// is a row of transforms.
    pub(super) fn turn(&self, from: &[Trs], to: &[Trs]) -> Quat {
        twist(self.pose(to).1 * self.pose(from).1.inverse(), self.up)
    }

    /// The rigid motion over the ground that gives the figure of the frame `from` the position and the heading of the
    /// figure of the frame `to`.
    pub(super) fn placement(&self, from: &[Trs], to: &[Trs]) -> Placement {
        let rotation = self.turn(from, to);
        let (from, to) = (self.position(from), self.position(to));
        Placement {
            rotation,
            from,
            to: to - (to - from).project_onto_normalized(self.up),
        }
    }

    /// Moves the figure in one frame by a rigid motion. `row` has the transforms of this frame.
    pub(super) fn apply(&self, placement: &Placement, row: &mut [Trs]) {
        let (position, rotation) = self.pose(row);
        let position = placement.to + placement.rotation * (position - placement.from);
        let trs = &mut row[self.column];
        trs.translation = self.parent.inverse().transform_point3(position);
        trs.rotation = (self.rotation.inverse() * placement.rotation * rotation).normalize();
    }
}

/// The nodes above a node, from its parent to the root.
fn ancestors(scene: &Scene, node: NodeId) -> impl Iterator<Item = NodeId> {
    std::iter::successors(scene.nodes[node.index()].parent, |node| {
        scene.nodes[node.index()].parent
    })
}

/// The transform from the parent of a node to the world, in a frame.
fn parent_at(scene: &Scene, frames: &Frames, node: NodeId, frame: usize) -> Mat4 {
    ancestors(scene, node).fold(Mat4::IDENTITY, |below, node| {
        let held = frames.nodes().iter().position(|held| *held == node);
        held.map_or(scene.nodes[node.index()].transform, |column| {
            frames.at(frame, column).matrix()
        }) * below
    })
}

/// Moves all nodes of `frames` in every frame by `motion`, a rigid motion of the world. Returns the nodes whose
/// transforms changed: the topmost nodes, which carry all other nodes.
pub(super) fn move_all(scene: &Scene, frames: &mut Frames, motion: Mat4) -> Vec<NodeId> {
    let rest = Pose::rest(scene);
    let held = frames.nodes().to_vec();
    let tops = held
        .iter()
        .enumerate()
        .filter(|(_, node)| !ancestors(scene, **node).any(|node| held.contains(&node)));
    let tops: Vec<(usize, NodeId)> = tops.map(|(column, node)| (column, *node)).collect();
    for (column, node) in &tops {
        let parent = scene.nodes[node.index()].parent;
        let parent = parent.map_or(Mat4::IDENTITY, |parent| rest.node_to_world[parent.index()]);
        let motion = parent.inverse() * motion * parent;
        let rotation = Trs::from_matrix(motion).rotation;
        let mut track = frames.track(*column);
        for trs in &mut track {
            trs.translation = motion.transform_point3(trs.translation);
            trs.rotation = (rotation * trs.rotation).normalize();
        }
        frames.set_track(*column, &track);
    }
    tops.into_iter().map(|(_, node)| node).collect()
}

impl Placement {
    /// A rotation about the up axis through the origin, followed by a translation over the ground.
    pub(super) fn new(rotation: Quat, offset: Vec3) -> Self {
        Self {
            rotation,
            from: Vec3::ZERO,
            to: offset,
        }
    }

    /// The inverse motion.
    pub(super) fn inverse(&self) -> Self {
        Self {
            rotation: self.rotation.inverse(),
            from: self.to,
            to: self.from,
        }
    }

    /// A fraction of this motion, from 0 to 1. The path to the full motion is an arc. For a figure on this arc, the
    /// speed over the ground and the speed of rotation are constant.
    pub(super) fn part(&self, fraction: f32) -> Self {
        let rotation = self.rotation * self.rotation.w.signum();
        let (axis, angle) = rotation.to_axis_angle();
        let chord = if angle > 1e-4 {
            (0.5 * fraction * angle).sin() / (0.5 * angle).sin()
        } else {
            fraction
        };
        let chord_turned = Quat::from_axis_angle(axis, 0.5 * (fraction - 1.0) * angle) * (self.to - self.from);
        Self {
            rotation: Quat::IDENTITY.slerp(self.rotation, fraction),
            from: self.from,
            to: self.from + chord * chord_turned,
        }
    }

    /// The distance over the ground, in units of the scene.
    pub(super) fn distance(&self) -> f32 {
        self.from.distance(self.to)
    }
}
