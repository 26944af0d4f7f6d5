//! The skin of a clip for a page: vertices, faces and bones as one block of bytes, and textures as unchanged files.
//!
//! The block has the following parts in order, for all meshes together. `skin.js` reads it.
//!
//! - positions (3 floats), texture coordinates (2 floats)
//! - offset matrices of the bones (16 floats, column by column)
//! - weights (4 numbers of 16 bits, which sum to 65,535), bones (4 numbers of 16 bits), corners of triangles (32 bits)
//! - position offsets of morph targets (`morphs.rs`)
//! - unit normals (4 signed bytes, the last unused), and normal offsets of morph targets

use std::collections::HashMap;

use mocap_scene::error::visible;
use mocap_scene::scene::{AlphaMode, Keys, Mesh, Primitive, Scene, Surface};
use serde::Serialize;

use super::morphs::{Morph, Morphs};
use crate::image_size::image_size;

/// The largest size of a skin in bytes, without its textures: about 700,000 vertices.
const LARGEST_SKIN: usize = 32 << 20;

/// The largest size of one texture in bytes, because a larger page opens slowly.
const LARGEST_TEXTURE: usize = 8 << 20;

/// The largest size of all textures of a clip in bytes.
const LARGEST_TEXTURES: usize = 32 << 20;

/// The largest width or height of a texture in pixels.
const WIDEST_TEXTURE: u32 = 4096;

/// The linear grey of a mesh whose file states no colour.
const PLAIN: [f32; 4] = [0.42, 0.43, 0.45, 1.0];

/// The description of a skin. Its bytes are stored separately.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Skin {
    /// The id of the element with the block. `page` sets it.
    pub(super) id: String,
    vertices: usize,
    corners: usize,
    /// The node of each bone.
    bones: Vec<usize>,
    parts: Vec<Part>,
    morphs: Vec<Morph>,
    pub(super) textures: Vec<TextureBlock>,
}

/// The faces of one material.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
struct Part {
    name: String,
    first: usize,
    count: usize,
    /// The linear colour: red, green, blue and opacity.
    color: [f32; 4],
    /// The index in `textures`, or -1.
    texture: i64,
    alpha: &'static str,
    cutoff: f32,
    two_sided: bool,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureBlock {
    /// The id of the element with the image file. `page` sets it.
    pub(super) id: String,
    media_type: &'static str,
    /// The index of the texture in the scene.
    #[serde(skip)]
    pub(super) source: usize,
}

/// A skin with its bytes.
pub(super) struct PackedSkin {
    pub(super) skin: Skin,
    pub(super) bytes: Vec<u8>,
    /// The animated sliders, with their weights.
    pub(super) motion: Vec<(usize, Keys<f32>)>,
}

/// The skin of a scene, if it can be shown, and the parts that are not shown.
pub(super) fn skin_of(scene: &Scene) -> (Option<PackedSkin>, Vec<String>) {
    let shown = |mesh: &&Mesh| mesh.primitive == Primitive::Triangles && !mesh.bones.is_empty();
    let meshes: Vec<&Mesh> = scene.own_meshes().filter(shown).collect();
    if meshes.is_empty() {
        return (None, Vec::new());
    }
    let vertices: usize = meshes.iter().map(|mesh| mesh.vertices.len()).sum();
    let corners: usize = meshes.iter().map(|mesh| mesh.indices.len()).sum();
    let size = 40 * vertices + 4 * corners;
    if size > LARGEST_SKIN {
        let note = format!(
            "the skin has {vertices} vertices and {} triangles, {} MB, and the limit is {} MB; the page shows only \
                the skeleton",
            corners / 3,
            size >> 20,
            LARGEST_SKIN >> 20
        );
        return (None, vec![note]);
    }
    let mut packer = Packer::default();
    let mut notes = Vec::new();
    let mut morphs = Morphs::new(&meshes, LARGEST_SKIN - size, &mut notes);
    let mut textures = Textures::default();
    for mesh in meshes {
        let surface = scene.materials.get(mesh.material_index);
        let two_sided = surface.is_none_or(|material| material.two_sided);
        let surface = surface.and_then(|material| material.surface);
        let texture = surface
            .and_then(|surface| surface.texture)
            .filter(|_| !mesh.texture_coords.is_empty());
        let texture = texture.and_then(|source| textures.index_of(scene, source, &mut notes));
        let Surface { base_color, alpha, .. } = surface.unwrap_or(Surface {
            base_color: PLAIN.into(),
            ..Surface::default()
        });
        let part = Part {
            name: visible(&mesh.name).into_owned(),
            first: packer.corners.len(),
            count: mesh.indices.len(),
            color: base_color.to_array(),
            texture: texture.map_or(-1, |index| index as i64),
            alpha: match alpha {
                AlphaMode::Opaque => "opaque",
                AlphaMode::Mask(_) => "mask",
                AlphaMode::Blend => "blend",
            },
            cutoff: match alpha {
                AlphaMode::Mask(cutoff) => cutoff,
                _ => 0.0,
            },
            two_sided,
        };
        morphs.push(mesh, packer.positions.len() / 3);
        if packer.push(mesh, part).is_none() {
            return (
                None,
                vec!["the skin has more than 65,536 bones; the page shows only the skeleton".to_owned()],
            );
        }
    }
    let skin = packer.finish(textures.blocks, morphs);
    (Some(skin), notes)
}

/// The shown textures, each once.
#[derive(Default)]
struct Textures {
    known: HashMap<usize, Option<usize>>,
    blocks: Vec<TextureBlock>,
    bytes: usize,
}

impl Textures {
    fn index_of(&mut self, scene: &Scene, source: usize, notes: &mut Vec<String>) -> Option<usize> {
        if let Some(known) = self.known.get(&source) {
            return *known;
        }
        let texture = scene.textures.get(source)?;
        let index = match self.fault(&texture.bytes) {
            Err(fault) => {
                let name = visible(&texture.name);
                notes.push(format!("the texture \"{name}\" is not shown: {fault}"));
                None
            }
            Ok(media_type) => {
                self.bytes += texture.bytes.len();
                self.blocks.push(TextureBlock {
                    id: String::new(),
                    media_type,
                    source,
                });
                Some(self.blocks.len() - 1)
            }
        };
        self.known.insert(source, index);
        index
    }

    /// The type of an image, or the reason why it is not shown.
    fn fault(&self, bytes: &[u8]) -> Result<&'static str, String> {
        let Some((media_type, [width, height])) = image_size(bytes) else {
            return Err("it is not PNG, JPEG or WebP".to_owned());
        };
        if width.max(height) > WIDEST_TEXTURE || width.min(height) == 0 {
            return Err(format!(
                "it has {width} x {height} pixels, and at most {WIDEST_TEXTURE} x {WIDEST_TEXTURE} are drawn"
            ));
        }
        let megabytes = |bytes: usize| format!("{:.1} MB", bytes as f64 / f64::from(1 << 20));
        if bytes.len() > LARGEST_TEXTURE {
            let most = megabytes(LARGEST_TEXTURE);
            return Err(format!(
                "it has {}, and at most {most} are put in a page",
                megabytes(bytes.len())
            ));
        }
        if self.bytes + bytes.len() > LARGEST_TEXTURES {
            let most = megabytes(LARGEST_TEXTURES);
            return Err(format!("all textures together have more than {most}"));
        }
        Ok(media_type)
    }
}

/// The parts of the block under construction.
#[derive(Default)]
struct Packer {
    positions: Vec<f32>,
    coords: Vec<f32>,
    offsets: Vec<f32>,
    weights: Vec<u16>,
    joints: Vec<u16>,
    corners: Vec<u32>,
    normals: Vec<i8>,
    bones: Vec<usize>,
    known: HashMap<(usize, [u32; 16]), u16>,
    parts: Vec<Part>,
}

impl Packer {
    fn push(&mut self, mesh: &Mesh, part: Part) -> Option<()> {
        let first = (self.positions.len() / 3) as u32;
        self.parts.push(part);
        self.corners.extend(mesh.indices.iter().map(|corner| first + corner));
        for (vertex, position) in mesh.vertices.iter().enumerate() {
            self.positions.extend(position.to_array());
            let coords = mesh.texture_coords.get(vertex).copied().unwrap_or_default();
            self.coords.extend(coords.to_array());
            let normal = mesh.normals.get(vertex).copied().unwrap_or(glam::Vec3::Y);
            self.normals
                .extend((normal * 127.0).to_array().map(|value| value.round() as i8));
            self.normals.push(0);
        }
        let mut ties: Vec<Vec<(u16, f32)>> = vec![Vec::new(); mesh.vertices.len()];
        for bone in &mesh.bones {
            let matrix = bone.offset_matrix.to_cols_array();
            let key = (bone.node.index(), matrix.map(f32::to_bits));
            let next = u16::try_from(self.bones.len()).ok();
            let index = match self.known.get(&key) {
                Some(&index) => index,
                None => {
                    let index = next?;
                    self.known.insert(key, index);
                    self.bones.push(bone.node.index());
                    self.offsets.extend(matrix);
                    index
                }
            };
            for weight in &bone.weights {
                if let Some(ties) = ties.get_mut(weight.vertex_id as usize) {
                    ties.push((index, weight.weight));
                }
            }
        }
        for mut ties in ties {
            let (joints, weights) = strongest_four(&mut ties);
            self.joints.extend(joints);
            self.weights.extend(weights);
        }
        Some(())
    }

    fn finish(self, textures: Vec<TextureBlock>, morphs: Morphs) -> PackedSkin {
        let mut bytes = Vec::new();
        for numbers in [&self.positions, &self.coords, &self.offsets] {
            bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        }
        for numbers in [&self.weights, &self.joints] {
            bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        }
        bytes.extend(self.corners.iter().flat_map(|corner| corner.to_le_bytes()));
        let morphs = morphs.pack();
        bytes.extend(morphs.moved);
        bytes.extend(self.normals.iter().flat_map(|number| number.to_le_bytes()));
        bytes.extend(morphs.normals);
        PackedSkin {
            motion: morphs.motion,
            skin: Skin {
                id: String::new(),
                vertices: self.positions.len() / 3,
                corners: self.corners.len(),
                bones: self.bones,
                parts: self.parts,
                morphs: morphs.morphs,
                textures,
            },
            bytes,
        }
    }
}

/// The four bones with the largest weights, scaled to a sum of 65,535.
pub fn strongest_four(ties: &mut [(u16, f32)]) -> ([u16; 4], [u16; 4]) {
    ties.sort_by(|a, b| b.1.total_cmp(&a.1));
    let four = &ties[..ties.len().min(4)];
    let sum: f32 = four.iter().map(|(_, weight)| weight).sum();
    let (mut joints, mut weights) = ([0; 4], [0u16; 4]);
    for (index, (joint, weight)) in four.iter().enumerate() {
        joints[index] = *joint;
        weights[index] = (weight / sum * 65_535.0).round() as u16;
    }
    // The largest weight takes the rounding error.
    let rest: u32 = weights[1..].iter().map(|weight| u32::from(*weight)).sum();
    weights[0] = 65_535_u32.saturating_sub(rest) as u16;
    (joints, weights)
}
