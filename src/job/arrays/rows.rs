//! Converts the blocks of a [`Chain`] to rows, one for each frame.

use std::num::NonZeroUsize;
use std::thread;

use glam::{Quat, Vec3};
use mocap_scene::pose::{Binding, Trs};
use mocap_scene::scene::{Animation, Scene};

use crate::arrays::chain::{Chain, ChainRequest};
use crate::arrays::frame::Frame;
use crate::arrays::joints::Selection;
use crate::arrays::lanes::LANES;
use crate::arrays::timeline::Timeline;
use crate::arrays::{ArrayOptions, RotationSpace, Space};

/// The smallest number of values for which a second thread saves time.
const LARGE: usize = 1 << 19;

/// The data from which all rows are computed.
pub(super) struct Source<'a> {
    pub(super) scene: &'a Scene,
    pub(super) animation: &'a Animation,
    pub(super) options: &'a ArrayOptions,
    pub(super) frame: &'a Frame,
    pub(super) joints: &'a Selection,
    pub(super) timeline: &'a Timeline,
    /// Indices of the joints whose positions in the world are also needed, for contacts.
    pub(super) feet: &'a [usize],
}

/// Some frames of the output.
pub(super) struct Rows<'a> {
    /// Frames x joints x 3.
    pub(super) positions: &'a mut [f32],
    /// Frames x joints x the width of a rotation.
    pub(super) rotations: &'a mut [f32],
    /// Frames x feet x 3.
    pub(super) feet: &'a mut [f32],
}

/// The indices in the chain from which the values of an output joint are computed.
struct JointLinks {
    node: usize,
    root: usize,
    parent: Option<usize>,
    /// Whether the joint's rotation is relative to its direct parent in the scene.
    is_next_to_parent: bool,
}

impl Source<'_> {
    /// Fills all rows. The values do not depend on the number of threads.
    pub(super) fn fill(&self, mut rows: Rows<'_>) {
        let binding = Binding::new(self.scene, self.animation);
        let frames = self.timeline.frames;
        let threads = match rows.positions.len() + rows.rotations.len() {
            ..LARGE => 1,
            _ => thread::available_parallelism().map_or(1, NonZeroUsize::get),
        };
        let part = frames.div_ceil(threads).next_multiple_of(LANES);
        thread::scope(|scope| {
            let mut first = 0;
            while frames - first > part {
                let (here, later) = self.split(rows, part);
                let binding = &binding;
                scope.spawn(move || self.fill_part(binding, first, here));
                rows = later;
                first += part;
            }
            self.fill_part(&binding, first, rows);
        });
    }

    fn split<'r>(&self, rows: Rows<'r>, frames: usize) -> (Rows<'r>, Rows<'r>) {
        let joints = self.joints.nodes.len();
        let (positions, later_positions) = rows.positions.split_at_mut(frames * joints * 3);
        let (rotations, later_rotations) = rows
            .rotations
            .split_at_mut(frames * joints * self.options.rotation.width());
        let (feet, later_feet) = rows.feet.split_at_mut(frames * self.feet.len() * 3);
        let here = Rows {
            positions,
            rotations,
            feet,
        };
        let later = Rows {
            positions: later_positions,
            rotations: later_rotations,
            feet: later_feet,
        };
        (here, later)
    }

    /// Fills the rows, starting at frame `first`.
    fn fill_part(&self, binding: &Binding, first: usize, mut rows: Rows<'_>) {
        let joints = 0..self.joints.nodes.len();
        let wanted = ChainRequest {
            nodes: &self.joints.nodes,
            axes: self.options.rotation_space == RotationSpace::World
                || joints.clone().any(|joint| !self.is_next_to_parent(joint)),
            turn: self.frame.turn,
        };
        let mut chain = Chain::new(self.scene, self.animation, binding, &wanted);
        let of_joints: Vec<JointLinks> = joints.map(|joint| self.links(&chain, joint)).collect();
        let frames = rows.positions.len() / (3 * of_joints.len());
        for start in (0..frames).step_by(LANES) {
            chain.sample(&std::array::from_fn(|frame| self.timeline.tick(first + start + frame)));
            let (block, later) = self.split(rows, LANES.min(frames - start));
            self.fill_block(&chain, &of_joints, block);
            rows = later;
        }
    }

    fn links(&self, chain: &Chain<'_>, joint: usize) -> JointLinks {
        let parent = self.joints.joints[joint].parent;
        JointLinks {
            node: chain.index(self.joints.nodes[joint]),
            root: chain.index(self.joints.roots[joint]),
            parent: parent.map(|parent| chain.index(self.joints.nodes[parent])),
            is_next_to_parent: self.is_next_to_parent(joint),
        }
    }

    fn is_next_to_parent(&self, joint: usize) -> bool {
        let above = self.scene.nodes[self.joints.nodes[joint].index()].parent;
        let listed = self.joints.joints[joint].parent.map(|parent| self.joints.nodes[parent]);
        above == listed && (listed.is_some() || self.frame.turn.is_none())
    }

    fn fill_block(&self, chain: &Chain<'_>, of_joints: &[JointLinks], rows: Rows<'_>) {
        let scale = self.frame.scale;
        for (index, links) in of_joints.iter().enumerate() {
            let frames = rows.positions.chunks_exact_mut(3 * of_joints.len()).enumerate();
            for (frame, row) in frames {
                let position = self.position(chain, links, frame) * scale;
                row[3 * index..][..3].copy_from_slice(&position.to_array());
            }
            let width = self.options.rotation.width();
            let order = self.joints.joints[index].rotation_order;
            let frames = rows.rotations.chunks_exact_mut(width * of_joints.len()).enumerate();
            for (frame, row) in frames {
                let rotation = self.rotation(chain, links, frame);
                self.options
                    .rotation
                    .write(rotation, order, &mut row[width * index..][..width]);
            }
        }
        for (foot, joint) in self.feet.iter().enumerate() {
            let frames = rows.feet.chunks_exact_mut(3 * self.feet.len()).enumerate();
            for (frame, row) in frames {
                let position = chain.to_world(of_joints[*joint].node).origin(frame) * scale;
                row[3 * foot..][..3].copy_from_slice(&position.to_array());
            }
        }
    }

    #[inline]
    fn position(&self, chain: &Chain<'_>, links: &JointLinks, frame: usize) -> Vec3 {
        let in_world = || chain.to_world(links.node).origin(frame);
        match (self.options.space, links.parent) {
            (Space::World, _) | (Space::Local, None) => in_world(),
            (Space::Root, _) => in_world() - chain.to_world(links.root).origin(frame),
            (Space::Local, Some(_)) if links.is_next_to_parent => chain.to_parent(links.node).origin(frame),
            (Space::Local, Some(parent)) => chain.to_ancestor(links.node, parent, frame).w_axis.truncate(),
        }
    }

    #[inline]
    fn rotation(&self, chain: &Chain<'_>, links: &JointLinks, frame: usize) -> Quat {
        let matrix = match (self.options.rotation_space, links.parent) {
            (RotationSpace::Local, _) if links.is_next_to_parent => return chain.rotation(links.node, frame),
            (RotationSpace::Local, Some(parent)) => chain.to_ancestor(links.node, parent, frame),
            _ => chain.to_world(links.node).matrix(frame),
        };
        Trs::from_matrix(matrix).rotation
    }
}
