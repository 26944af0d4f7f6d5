//! Forward kinematics of a block of frames, node by node.
//!
//! [`Pose`](mocap_scene::pose::Pose) computes one frame at a time, which suits a viewer. For all frames, this module
//! reads the keys of a track in the order of memory, and chains a node to its parent in [many frames at
//! once](super::lanes).

use glam::{Mat4, Quat, Vec3};
use mocap_scene::pose::{Binding, Trs, forward_kinematics};
use mocap_scene::scene::{Animation, Channel, Keys, NodeId, Scene};

use crate::arrays::lanes::{LANES, Rotations, Transforms};

/// The nodes to compute.
pub(super) struct ChainRequest<'a> {
    /// The requested nodes.
    pub(super) nodes: &'a [NodeId],
    /// Whether the world axes of the nodes are requested too.
    pub(super) axes: bool,
    /// The matrix from the scene's axes to the world axes, if they differ.
    pub(super) turn: Option<Mat4>,
}

/// A skeleton in the frames of a block.
pub(super) struct Chain<'a> {
    links: Vec<Link<'a>>,
    to_world: Vec<Transforms>,
    turn: Option<Transforms>,
}

/// A requested node, or an ancestor of one.
struct Link<'a> {
    node: NodeId,
    /// The index of the parent in the chain.
    parent: Option<usize>,
    /// The tracks of the node. Tracks with one key are read when the chain is made.
    positions: Option<&'a Keys<Vec3>>,
    rotations: Option<&'a Keys<Quat>>,
    scalings: Option<&'a Keys<Vec3>>,
    still_scale: Vec3,
    to_parent: Transforms,
    rotation: Rotations,
    /// Whether any node needs its world axes.
    needs_axes: bool,
}

impl<'a> Chain<'a> {
    /// `animation` belongs to `scene`, and `binding` to `animation`.
    pub(super) fn new(scene: &Scene, animation: &'a Animation, binding: &Binding, wanted: &ChainRequest<'_>) -> Self {
        let mut channels: Vec<Option<&'a Channel>> = vec![None; scene.nodes.len()];
        for (node, channel) in binding.driven() {
            channels[node.index()] = animation.channels.get(channel);
        }
        let mut is_wanted = vec![false; scene.nodes.len()];
        let mut has_children = vec![false; scene.nodes.len()];
        for node in wanted.nodes {
            is_wanted[node.index()] = true;
        }
        let is_asked_for = is_wanted.clone();
        for (index, node) in scene.nodes.iter().enumerate().rev() {
            if let (true, Some(parent)) = (is_wanted[index], node.parent) {
                is_wanted[parent.index()] = true;
                has_children[parent.index()] = true;
            }
        }
        // Nodes that are not needed have no link.
        let mut link_of = vec![None; scene.nodes.len()];
        let mut links = Vec::with_capacity(scene.nodes.len());
        for (index, node) in scene.nodes.iter().enumerate().filter(|(index, _)| is_wanted[*index]) {
            link_of[index] = Some(links.len());
            let parent = node.parent.and_then(|parent| link_of[parent.index()]);
            let needs_axes = has_children[index] || (wanted.axes && is_asked_for[index]);
            links.push(Link::new(
                NodeId::new(index),
                parent,
                node.transform,
                channels[index],
                needs_axes,
            ));
        }
        Self {
            to_world: vec![Transforms::splat(Mat4::IDENTITY); links.len()],
            links,
            turn: wanted.turn.map(Transforms::splat),
        }
    }

    /// The index of a requested node in the chain, for the methods below.
    pub(super) fn index(&self, node: NodeId) -> usize {
        self.links.partition_point(|link| link.node < node)
    }

    /// Computes the chain at the ticks of a block.
    pub(super) fn sample(&mut self, ticks: &[f64; LANES]) {
        let first_key = first_of_whole_ticks(ticks);
        for link in &mut self.links {
            link.sample(ticks, first_key);
        }
        let links = &self.links;
        forward_kinematics(
            &mut self.to_world,
            |index| links[index].parent,
            |index, parent, to_world| {
                let link = &links[index];
                let Some(parent) = parent.or(self.turn.as_ref()) else {
                    to_world.clone_from(&link.to_parent);
                    return;
                };
                to_world.set_product_of_origins(parent, &link.to_parent);
                if link.needs_axes {
                    to_world.set_product_of_axes(parent, &link.to_parent);
                }
            },
        );
    }

    /// The transforms from the node to the world.
    pub(super) fn to_world(&self, index: usize) -> &Transforms {
        &self.to_world[index]
    }

    /// The transforms from the node to its parent in the scene.
    pub(super) fn to_parent(&self, index: usize) -> &Transforms {
        &self.links[index].to_parent
    }

    /// The rotation of the node relative to its parent in the scene.
    #[inline]
    pub(super) fn rotation(&self, index: usize, frame: usize) -> Quat {
        self.links[index].rotation.get(frame)
    }

    /// The transform from the node to an ancestor, through the nodes between them.
    pub(super) fn to_ancestor(&self, index: usize, ancestor: usize, frame: usize) -> Mat4 {
        let mut matrix = self.to_parent(index).matrix(frame);
        let mut above = self.links[index].parent;
        while let Some(between) = above.filter(|&above| above != ancestor) {
            matrix = self.to_parent(between).matrix(frame) * matrix;
            above = self.links[between].parent;
        }
        matrix
    }
}

impl<'a> Link<'a> {
    fn new(
        node: NodeId,
        parent: Option<usize>,
        transform: Mat4,
        channel: Option<&'a Channel>,
        needs_axes: bool,
    ) -> Self {
        let rest = Trs::from_matrix(transform);
        let still = channel.map_or(rest, |channel| channel.sample(0.0, rest));
        // The matrix of a node without tracks may contain shear, which translation, rotation and scale cannot express.
        let to_parent = channel.map_or(transform, |_| still.matrix());
        Self {
            node,
            parent,
            positions: channel
                .map(|channel| &channel.position_keys)
                .filter(|keys| keys.len() > 1),
            rotations: channel
                .map(|channel| &channel.rotation_keys)
                .filter(|keys| keys.len() > 1),
            scalings: channel
                .map(|channel| &channel.scaling_keys)
                .filter(|keys| keys.len() > 1),
            still_scale: still.scale,
            to_parent: Transforms::splat(to_parent),
            rotation: Rotations::splat(still.rotation),
            needs_axes,
        }
    }

    /// Samples `rotation` and `to_parent` at the ticks of a block.
    fn sample(&mut self, ticks: &[f64; LANES], first_key: Option<usize>) {
        if let Some(keys) = self.positions {
            let transforms = &mut self.to_parent;
            for_each_value(keys, ticks, first_key, Keys::<Vec3>::sample, |frame, value| {
                transforms.set_origin(frame, value);
            });
        }
        if let Some(keys) = self.rotations {
            let rotations = &mut self.rotation;
            for_each_value(keys, ticks, first_key, Keys::<Quat>::sample, |frame, value| {
                rotations.set(frame, value);
            });
        }
        if self.rotations.is_some() || self.scalings.is_some() {
            self.to_parent.set_rotations(&self.rotation);
            let transforms = &mut self.to_parent;
            if let Some(keys) = self.scalings {
                for_each_value(keys, ticks, first_key, Keys::<Vec3>::sample, |frame, value| {
                    transforms.scale(frame, value);
                });
            } else if self.still_scale != Vec3::ONE {
                (0..LANES).for_each(|frame| transforms.scale(frame, self.still_scale));
            }
        }
    }
}

/// The first of `ticks`, if the ticks are consecutive integers.
fn first_of_whole_ticks(ticks: &[f64; LANES]) -> Option<usize> {
    let first = ticks[0] as usize;
    let counts_up = ticks.iter().zip(first..).all(|(&tick, count)| tick == count as f64);
    counts_up.then_some(first)
}

/// Passes the value of a track in every frame to `take`. If every frame has a key, the key is the value.
#[inline]
fn for_each_value<T: Copy>(
    keys: &Keys<T>,
    ticks: &[f64; LANES],
    first_key: Option<usize>,
    sample: impl Fn(&Keys<T>, f64) -> Option<T>,
    mut take: impl FnMut(usize, T),
) {
    if let (Some(first), None) = (first_key, &keys.ticks)
        && let Some(values) = keys.values.get(first..first + LANES)
    {
        for (frame, value) in values.iter().enumerate() {
            take(frame, *value);
        }
        return;
    }
    for (frame, &tick) in ticks.iter().enumerate() {
        if let Some(value) = sample(keys, tick) {
            take(frame, value);
        }
    }
}
