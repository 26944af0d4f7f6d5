//! Blend shapes as morph targets.
//!
//! A channel may have several shapes on the way to its last one, which is at its full weight; that one is read.

use std::collections::HashMap;

use glam::{DMat4, DVec3, Vec3};
use mocap_scene::limits::is_plausible;
use mocap_scene::scene::MorphTarget;

use crate::{ReadOptions, Source};

/// What may be read of shapes yet.
pub(super) struct BlendShapes {
    are_read: bool,
    /// Vertices of shapes; a shape may be shown by many vertices of the mesh.
    left: u64,
    /// Whether some are left out.
    pub(super) are_too_many: bool,
}

impl BlendShapes {
    pub(super) fn new(origin: &Source<'_>, options: &ReadOptions) -> Self {
        Self {
            are_read: options.morph_targets,
            left: options.limits.expanded_values(origin.bytes.len() as u64),
            are_too_many: false,
        }
    }

    /// The targets of a mesh that has one vertex for each of these corners. `to_mesh` takes positions and normals from
    /// the file's space to the mesh's.
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
            let target = self.target(&channel.element.name, shape, &vertices, to_mesh);
            targets.extend(target.filter(|target| !target.vertex_ids.is_empty()));
        }
        targets
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
