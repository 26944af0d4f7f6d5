//! Blend shapes as morph targets.
//!
//! A channel may have several shapes (in-betweens). The reader takes the last shape, at full weight, and counts the
//! others as lost. Weights are sampled in the frames of each clip, like transforms.

use std::collections::HashMap;

use glam::{DMat4, DVec3, Vec3};
use mocap_scene::limits::is_plausible;
use mocap_scene::scene::{Keys, MorphTarget};

use super::Stack;
use crate::{ReadOptions, Source};

/// Reads blend shapes until their vertices reach the limit.
pub(super) struct BlendShapes<'a> {
    are_read: bool,
    /// The clips, in which the weights are sampled.
    stacks: &'a [Stack<'a>],
    /// The weights of channels at rest and in each clip, by the ids of the channels.
    weights: HashMap<u32, (f32, Vec<Keys<f32>>)>,
    /// The number of vertices that may still be read. Several vertices of the mesh can share a vertex of a shape.
    left: u64,
    /// Whether the limit dropped some shapes.
    pub(super) are_too_many: bool,
}

/// The number of channels whose weight changes in a clip.
pub(super) fn moving_channels(file: &ufbx::Scene) -> usize {
    let is_moving = |channel: &ufbx::BlendChannel| {
        let properties = file.anim_stacks.iter().flat_map(|stack| &stack.layers);
        let mut properties = properties.flat_map(|layer| layer.anim_props.iter());
        properties.any(|property| {
            let curves = property.anim_value.curves.iter().flatten();
            property.element.element_id == channel.element.element_id && curves.into_iter().any(|curve| varies(curve))
        })
    };
    let channels = file.blend_channels.iter();
    channels.filter(|channel| is_moving(channel)).count()
}

fn varies(curve: &ufbx::AnimCurve) -> bool {
    curve.min_value < curve.max_value
}

/// The weight at which a channel shows its shape fully.
pub(in super::super) fn full_weight(channel: &ufbx::BlendChannel) -> f64 {
    let last = channel.keyframes.iter().last();
    let full = last.map(|keyframe| keyframe.target_weight);
    full.filter(|full| full.is_finite() && *full > 0.0).unwrap_or(1.0)
}

impl<'a> BlendShapes<'a> {
    pub(super) fn new(origin: &Source<'_>, options: &ReadOptions, stacks: &'a [Stack<'a>]) -> Self {
        Self {
            are_read: options.morph_targets,
            stacks,
            weights: HashMap::new(),
            left: options.limits.expanded_values(origin.bytes.len() as u64),
            are_too_many: false,
        }
    }

    /// The targets of a mesh that has one vertex for each of `corners`. `to_mesh` transforms positions and normals from
    /// the file's space to the mesh's space.
    pub(super) fn of(&mut self, source: &ufbx::Mesh, corners: &[usize], to_mesh: (DMat4, DMat4)) -> Vec<MorphTarget> {
        let channels = source.blend_deformers.iter().flat_map(|deformer| &deformer.channels);
        let mut channels = channels.peekable();
        if !self.are_read || channels.peek().is_none() {
            return Vec::new();
        }
        let mut vertices: HashMap<u32, Vec<u32>> = HashMap::new();
        for (id, &corner) in corners.iter().enumerate() {
            vertices
                .entry(source.vertex_indices[corner])
                .or_default()
                .push(id as u32);
        }
        let mut targets = Vec::new();
        for channel in channels {
            let Some(shape) = &channel.target_shape else { continue };
            let Some(mut target) = self.target(&channel.element.name, shape, &vertices, to_mesh) else {
                continue;
            };
            if !target.vertex_ids.is_empty() {
                (target.weight, target.weight_keys) = self.weights(channel);
                targets.push(target);
            }
        }
        targets
    }

    /// The weights of a channel at rest and in each clip. If the channel stays at rest in all clips, it has no keys.
    fn weights(&mut self, channel: &ufbx::BlendChannel) -> (f32, Vec<Keys<f32>>) {
        let stacks = self.stacks;
        let sampled = || {
            let full = full_weight(channel);
            let sound = |weight: f64| is_plausible(weight).then_some((weight / full) as f32);
            let at_rest = sound(channel.weight).unwrap_or_default();
            let of_stack = |stack: &Stack<'_>| {
                let at = |time: f64| sound(ufbx::evaluate_blend_weight(&stack.stack.anim, channel, time));
                let weights: Vec<f32> = stack.times().map(|time| at(time).unwrap_or(at_rest)).collect();
                match weights.iter().all(|weight| *weight == weights[0]) {
                    true if weights[0] == at_rest => Keys::default(),
                    true => Keys::constant(weights[0]),
                    false => Keys::every_tick(weights),
                }
            };
            let keys: Vec<Keys<f32>> = stacks.iter().map(of_stack).collect();
            let moves = keys.iter().any(|keys| !keys.is_empty());
            (at_rest, if moves { keys } else { Vec::new() })
        };
        self.weights
            .entry(channel.element.element_id)
            .or_insert_with(sampled)
            .clone()
    }

    fn target(
        &mut self,
        name: &str,
        shape: &ufbx::BlendShape,
        vertices: &HashMap<u32, Vec<u32>>,
        (to_mesh, to_mesh_normal): (DMat4, DMat4),
    ) -> Option<MorphTarget> {
        let mut target = MorphTarget {
            name: name.to_owned(),
            ..MorphTarget::default()
        };
        let has_normals = shape.normal_offsets.len() == shape.offset_vertices.len();
        for (at, vertex) in shape.offset_vertices.iter().enumerate() {
            let of_vertex = vertices.get(vertex).map(Vec::as_slice).unwrap_or_default();
            let Some(left) = self.left.checked_sub(1 + of_vertex.len() as u64) else {
                self.are_too_many = true;
                return None;
            };
            self.left = left;
            let placed = |matrix: DMat4, offset: ufbx::Vec3| -> Option<Vec3> {
                let offset = DVec3::new(offset.x, offset.y, offset.z);
                let offset = matrix.transform_vector3(offset).as_vec3();
                offset
                    .to_array()
                    .into_iter()
                    .all(|value| is_plausible(value.into()))
                    .then_some(offset)
            };
            let offset = placed(to_mesh, *shape.position_offsets.get(at)?);
            let normal = match has_normals {
                true => placed(to_mesh_normal, shape.normal_offsets[at]),
                false => Some(Vec3::ZERO),
            };
            let (Some(offset), Some(normal)) = (offset, normal) else {
                continue;
            };
            for &id in of_vertex {
                target.vertex_ids.push(id);
                target.offsets.push(offset);
                if has_normals {
                    target.normal_offsets.push(normal);
                }
            }
        }
        Some(target)
    }
}
