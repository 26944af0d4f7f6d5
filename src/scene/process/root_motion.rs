//! Removes or separates the motion of the root over the ground.
//!
//! For both steps the ground is the plane of x and z of the world, which is true after
//! [`convert_units`](crate::Scene::convert_units). A group above the root may be rotated, as in files with +Z up.

use glam::{DMat3, DMat4, DQuat, DVec3, Quat, Vec3};

use super::collapse_keys::collapse;
use crate::pose::Binding;
use crate::scene::report::AppliedStep;
use crate::scene::{Animation, Channel, Keys, Node, NodeId, NodeKind, Scene};

/// The name of the new node, unless another has it.
const ROOT_NAME: &str = "Root";

/// Ticks of a motion with few keys above which it gets none between them: two keys may be years apart.
const MOST_TICKS: f64 = 1_048_576.0;

/// Below this sum of squares the twist about the up axis is undefined: the figure is upside down.
const NO_HEADING: f64 = 1e-9;

impl Scene {
    /// Keeps every root above the point of the ground where its motion starts. Height and rotations do not change.
    #[doc(hidden)]
    pub fn put_in_place(&mut self) {
        let roots: Vec<_> = roots(self).collect();
        for index in 0..self.animations.len() {
            let driven: Vec<_> = Binding::new(self, &self.animations[index]).driven().collect();
            for (node, channel) in driven.into_iter().filter(|(node, _)| roots.contains(node)) {
                let to_world = DMat3::from_mat4(above(self, node));
                let from_world = to_world.inverse();
                let values = &mut self.animations[index].channels[channel].position_keys.values;
                let Some(&start) = values.first().filter(|_| from_world.is_finite()) else {
                    continue;
                };
                let start = to_world * start.as_dvec3();
                for value in values {
                    let height = (to_world * value.as_dvec3()).y;
                    *value = (from_world * DVec3::new(start.x, height, start.z)).as_vec3();
                }
            }
        }
        self.metadata.steps.push(AppliedStep::InPlace);
    }
}

impl Scene {
    /// Adds a joint named `Root` above the first root and moves the translation over the ground and the heading there,
    /// as game engines expect. The old root keeps its height and its other rotations. No node's position in the world
    /// changes. Returns the new joint; none where there is no root.
    #[doc(hidden)]
    pub fn extract_root_motion(&mut self) -> Option<NodeId> {
        let old_root = roots(self).next()?;
        let name = self.root_name();
        for index in 0..self.animations.len() {
            let driven = Binding::new(self, &self.animations[index])
                .driven()
                .find(|(node, _)| *node == old_root);
            if let Some((_, channel)) = driven {
                let rest = self.nodes[old_root.index()].transform.w_axis.truncate();
                let (_, to_world, _) = above(self, old_root).to_scale_rotation_translation();
                let to_world = if to_world.is_finite() {
                    to_world
                } else {
                    DQuat::IDENTITY
                };
                split_channel(&mut self.animations[index], channel, &name, (rest, to_world));
            }
        }

        self.insert_root_above(old_root);
        for channel in self.animations.iter_mut().flat_map(|animation| &mut animation.channels) {
            if channel.node_name == name {
                channel.node = Some(old_root);
            }
        }
        self.metadata.steps.push(AppliedStep::RootMotion);
        Some(old_root)
    }

    /// What a new root is called.
    fn root_name(&self) -> String {
        let is_taken = |name: &str| self.nodes.iter().any(|node| node.name == name);
        let numbered = (2..).map(|number| format!("{ROOT_NAME}_{number}"));
        let mut names = std::iter::once(ROOT_NAME.to_owned()).chain(numbered);
        names.find(|name| !is_taken(name)).unwrap_or_default()
    }

    /// Puts a joint named `Root`, without a transform, above a node. It takes the index of the node; from there on
    /// indices increase by one.
    #[doc(hidden)]
    #[doc(hidden)]
    pub fn insert_root_above(&mut self, below: NodeId) {
        let name = self.root_name();
        let shifted = |id: NodeId| if id < below { id } else { NodeId(id.0 + 1) };
        for node in &mut self.nodes {
            node.parent = node.parent.map(shifted);
        }
        for bone in self.meshes.iter_mut().flat_map(|mesh| &mut mesh.bones) {
            bone.node = shifted(bone.node);
        }
        for channel in self.animations.iter_mut().flat_map(|animation| &mut animation.channels) {
            channel.node = channel.node.map(shifted);
        }
        let parent = self.nodes[below.index()].parent.replace(below);
        self.nodes.insert(
            below.index(),
            Node {
                name,
                parent,
                ..Node::default()
            },
        );
    }
}

/// The root joints: the first node, or its children if it is only a group.
fn roots(scene: &Scene) -> impl Iterator<Item = NodeId> {
    let is_top =
        |parent: Option<NodeId>| parent.is_none_or(|parent| scene.nodes[parent.index()].kind == NodeKind::Group);
    let tops = scene
        .nodes
        .iter()
        .enumerate()
        .filter(move |(_, node)| node.kind == NodeKind::Joint && is_top(node.parent));
    tops.map(|(index, _)| NodeId::new(index))
}

/// From the space in which a node stands to the world, at rest.
fn above(scene: &Scene, node: NodeId) -> DMat4 {
    let parent = |node: &NodeId| scene.nodes[node.index()].parent;
    let above = std::iter::successors(parent(&node), parent);
    above.fold(DMat4::IDENTITY, |below, node| {
        scene.nodes[node.index()].transform.as_dmat4() * below
    })
}

/// One key where all values are equal.
fn keys<T: Copy + PartialEq>(values: Vec<T>, ticks: &[f64]) -> Keys<T> {
    let mut keys = Keys::at_ticks(values, ticks.to_vec());
    collapse(&mut keys, |a, b| a == b);
    keys
}

/// Splits a root's channel in two: one for the new node `name`, inserted before it, and the rest. `to_world` is the
/// rotation from its space.
fn split_channel(animation: &mut Animation, index: usize, name: &str, (rest, to_world): (Vec3, DQuat)) {
    let duration = animation.duration;
    let channel = &mut animation.channels[index];
    let ticks: Vec<f64> = {
        let (positions, rotations) = (&channel.position_keys, &channel.rotation_keys);
        let mut ticks: Vec<_> = (0..positions.len()).map(|key| positions.tick(key)).collect();
        ticks.extend((0..rotations.len()).map(|key| rotations.tick(key)));
        // Between two keys the heading and the rest go along arcs of their own, which together are another.
        if rotations.ticks.is_some() && duration < MOST_TICKS {
            ticks.extend((0..=duration as u32).map(f64::from));
        }
        ticks.sort_by(f64::total_cmp);
        ticks.dedup();
        ticks
    };
    let from_world = to_world.inverse();
    let mut heading = DQuat::IDENTITY;
    let (mut on_ground, mut headings) = (Vec::with_capacity(ticks.len()), Vec::with_capacity(ticks.len()));
    let (mut heights, mut leans) = (Vec::with_capacity(ticks.len()), Vec::with_capacity(ticks.len()));
    for &tick in &ticks {
        let position = to_world * channel.position_keys.sample(tick).unwrap_or(rest).as_dvec3();
        let rotation = channel.rotation_keys.sample(tick).unwrap_or(Quat::IDENTITY).as_dquat();
        let rotation = to_world * rotation * from_world;
        // The twist about Y of the swing-twist decomposition.
        if rotation.y * rotation.y + rotation.w * rotation.w > NO_HEADING {
            heading = DQuat::from_xyzw(0.0, rotation.y, 0.0, rotation.w).normalize();
        }
        let lean = heading.inverse() * rotation;
        on_ground.push((from_world * DVec3::new(position.x, 0.0, position.z)).as_vec3());
        headings.push((from_world * heading * to_world).as_quat());
        heights.push((from_world * DVec3::new(0.0, position.y, 0.0)).as_vec3());
        leans.push((from_world * lean * to_world).as_quat());
    }
    let root = Channel {
        node_name: name.to_owned(),
        node: None,
        position_keys: keys(on_ground, &ticks),
        rotation_keys: keys(headings, &ticks),
        scaling_keys: Keys::constant(Vec3::ONE),
    };
    channel.position_keys = keys(heights, &ticks);
    channel.rotation_keys = keys(leans, &ticks);
    animation.channels.insert(index, root);
}
