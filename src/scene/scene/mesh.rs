//! Meshes, the bones that move them, and their materials.

use std::borrow::Cow;

use glam::{Mat4, Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};

#[cfg(doc)]
use super::Node;
#[cfg(doc)]
use super::Scene;
use super::{Keys, NodeId};

/// The type of a mesh's faces.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Primitive {
    /// Three indices per face.
    #[default]
    Triangles,
    /// One index per face.
    Points,
}

impl Primitive {
    /// The number of indices of one face.
    pub fn indices_per_face(self) -> usize {
        match self {
            Self::Triangles => 3,
            Self::Points => 1,
        }
    }
}

/// Vertices and faces, in the space of the node that holds the mesh.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mesh {
    /// The name; empty on a skeleton mesh.
    pub name: String,
    /// The type of the faces.
    pub primitive: Primitive,
    /// Positions, one per vertex.
    pub vertices: Vec<Vec3>,
    /// Unit normals, one per vertex.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, one per vertex, or none. (0, 0) is the upper left corner of the image, as in glTF.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub texture_coords: Vec<Vec2>,
    /// Vertex indices, [`Primitive::indices_per_face`] for each face.
    pub indices: Vec<u32>,
    /// Bindings of vertices to nodes; empty for a rigid mesh.
    pub bones: Vec<Bone>,
    /// Shapes into which the mesh can deform. They are read if `Importer::morph_targets` is set.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub morph_targets: Vec<MorphTarget>,
    /// Index into [`Scene::materials`].
    pub material_index: usize,
}

impl Mesh {
    /// The faces, each as its vertex indices.
    pub fn faces(&self) -> std::slice::ChunksExact<'_, u32> {
        self.indices.chunks_exact(self.primitive.indices_per_face())
    }

    /// The vertices without the rest weights of morph targets.
    #[doc(hidden)]
    pub fn vertices_without_targets(&self) -> Cow<'_, [Vec3]> {
        let mut vertices = Cow::Borrowed(self.vertices.as_slice());
        for (vertex, added) in added_at_rest(&self.morph_targets) {
            if let Some(vertex) = vertices.to_mut().get_mut(vertex) {
                *vertex -= added;
            }
        }
        vertices
    }

    /// Adds the rest weights of morph targets to the vertices.
    #[doc(hidden)]
    pub fn add_targets_at_rest(&mut self) {
        for (vertex, added) in added_at_rest(&self.morph_targets) {
            if let Some(vertex) = self.vertices.get_mut(vertex) {
                *vertex += added;
            }
        }
    }

    /// Transforms the offsets of morph targets together with the vertex positions.
    pub(crate) fn map_morph_targets(&mut self, change: impl Fn(usize, Vec3) -> Vec3) {
        for target in &mut self.morph_targets {
            let MorphTarget {
                vertex_ids,
                offsets,
                normal_offsets,
                ..
            } = target;
            for changed in [offsets, normal_offsets] {
                for (vertex, offset) in std::iter::zip(&*vertex_ids, changed) {
                    *offset = change(*vertex as usize, *offset);
                }
            }
        }
    }
}

/// The vertices that morph targets move at rest, and their offsets.
fn added_at_rest(targets: &[MorphTarget]) -> impl Iterator<Item = (usize, Vec3)> {
    let moving = targets.iter().filter(|target| target.weight != 0.0);
    moving.flat_map(|target| {
        let moved = std::iter::zip(&target.vertex_ids, &target.offsets);
        moved.map(|(vertex, offset)| (*vertex as usize, target.weight * *offset))
    })
}

/// A shape into which a mesh can deform, such as a smile: a morph target in glTF, a blend shape in FBX.
///
/// `Importer::morph_targets` has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MorphTarget {
    /// The name.
    pub name: String,
    /// The weight at rest, which [`Mesh::vertices`] already include.
    pub weight: f32,
    /// The weight over time in each of [`Scene::animations`](crate::Scene::animations). An animation in which the
    /// weight stays at rest has no keys. Empty if no animation changes the weight. Steps that change times also change
    /// these keys.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub weight_keys: Vec<Keys<f32>>,
    /// The affected vertices, each once.
    pub vertex_ids: Vec<u32>,
    /// The position offset of each affected vertex at weight 1.
    pub offsets: Vec<Vec3>,
    /// The normal offset of each affected vertex at weight 1, or empty.
    pub normal_offsets: Vec<Vec3>,
}

impl MorphTarget {
    /// The target for a renumbered mesh. `new_id` gives the new id of each kept vertex.
    pub(crate) fn renumbered(&self, new_id: impl Fn(u32) -> Option<u32>) -> Self {
        let kept = self.vertex_ids.iter().enumerate();
        let kept: Vec<(usize, u32)> = kept.filter_map(|(at, old)| Some((at, new_id(*old)?))).collect();
        let of = |all: &[Vec3]| kept.iter().filter_map(|(at, _)| all.get(*at).copied()).collect();
        Self {
            name: self.name.clone(),
            weight: self.weight,
            weight_keys: self.weight_keys.clone(),
            vertex_ids: kept.iter().map(|(_, new)| *new).collect(),
            offsets: of(&self.offsets),
            normal_offsets: of(&self.normal_offsets),
        }
    }
}

/// A binding of vertices to a node.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bone {
    /// The name of the node.
    pub name: String,
    /// The node. It is unique, while names may repeat.
    pub node: NodeId,
    /// Mesh space to the node's space, in the bind pose.
    pub offset_matrix: Mat4,
    /// The affected vertices.
    pub weights: Vec<VertexWeight>,
}

/// The influence of a bone on a vertex.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct VertexWeight {
    /// Index into [`Mesh::vertices`].
    pub vertex_id: u32,
    /// The fraction of the vertex's motion, from 0 to 1.
    pub weight: f32,
}

/// The appearance of a mesh's faces.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Material {
    /// The name.
    pub name: String,
    /// Whether back faces are drawn.
    pub two_sided: bool,
    /// The colour, if the file states it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<Surface>,
}

/// The appearance of a material, in the terms of glTF.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Surface {
    /// Red, green, blue and alpha, linear. They multiply the texture.
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 4]"))]
    pub base_color: Vec4,
    /// The colour texture, an index into [`Scene::textures`].
    pub texture: Option<usize>,
    /// The meaning of alpha.
    pub alpha: AlphaMode,
    /// The wrap mode of the texture along u and along v.
    pub wrap: [Wrap; 2],
    /// From 0, a dielectric such as skin or cloth, to 1, a metal.
    pub metallic: f32,
    /// From 0, a mirror, to 1, a surface without highlights.
    pub roughness: f32,
    /// The light that the surface emits: red, green and blue, linear.
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
    pub emissive: Vec3,
}

impl Default for Surface {
    fn default() -> Self {
        Self {
            base_color: Vec4::ONE,
            texture: None,
            alpha: AlphaMode::Opaque,
            wrap: [Wrap::Repeat; 2],
            metallic: 0.0,
            // The roughness of cloth and skin.
            roughness: 0.8,
            emissive: Vec3::ZERO,
        }
    }
}

/// The repetition of a texture beyond its edges.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Wrap {
    /// The texture repeats.
    #[default]
    Repeat,
    /// The texture repeats, mirrored each time. FBX cannot express this mode.
    Mirror,
    /// The colours of the edge continue.
    Clamp,
}

/// The meaning of a colour's alpha.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum AlphaMode {
    /// None: the surface is opaque.
    #[default]
    Opaque,
    /// Below this alpha the surface is invisible, above it opaque.
    Mask(f32),
    /// The fraction of the colour over the background.
    Blend,
}

/// An image in its file format.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Texture {
    /// The name.
    pub name: String,
    /// The media type, such as `image/png`.
    pub media_type: String,
    /// The bytes of the image file.
    #[serde(skip)]
    pub bytes: Vec<u8>,
}
