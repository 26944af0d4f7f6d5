//! Writes meshes as glTF primitives. Equal vertices are merged, and normals are written only if they differ from the
//! face normals.

use std::collections::{BTreeMap, HashMap};

use glam::{Vec2, Vec3};
use gltf_json::mesh::{Mode, MorphTarget as JsonTarget, Primitive as JsonPrimitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Index, Material};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::{Mesh, MorphTarget, Primitive};

use super::buffer::{Buffer, Usage};
use crate::morph_targets;

/// The largest number of joints with 8-bit joint indices.
const JOINTS_IN_8_BITS: usize = 256;

/// The cosine of the angle between a vertex normal and its face's normal above which both count as equal.
const SAME_DIRECTION: f32 = 0.999;

/// The distance from the centre of a [`marker`] to its tips, in metres.
const MARKER_RADIUS: f32 = 0.01;

/// The number of joints in one attribute of a vertex.
const SET: usize = 4;

/// The joints of each vertex, as indices into the skin, and their weights.
struct Influences {
    /// The number of joint attributes of each vertex.
    sets: usize,
    /// The sum of a vertex's weights.
    whole: u16,
    /// All sets of each vertex, the strongest joint first. Entries without weight are 0.
    ties: Vec<(u16, u16)>,
}

impl Influences {
    fn of(&self, vertex: usize) -> &[(u16, u16)] {
        let count = SET * self.sets;
        &self.ties[count * vertex..count * (vertex + 1)]
    }
}

/// Writes `mesh`. `joints` has the skin index of every node; if it is given, the mesh is skinned.
///
/// Returns the primitive and its number of vertices, or `None` if no face has an area.
pub(super) fn write(
    mesh: &Mesh,
    joints: Option<&[Option<u16>]>,
    joint_count: usize,
    buffer: &mut Buffer,
) -> Result<Option<(JsonPrimitive, usize)>> {
    morph_targets::check(mesh).map_err(|message| Diagnostic::new(Code::Unrepresentable, message))?;
    let vertices = mesh.vertices_without_targets();
    if !vertices.iter().all(|vertex| vertex.is_finite()) {
        return Err(Diagnostic::new(Code::Unrepresentable, "a vertex is not finite").into());
    }
    let influences = joints.map(|joints| influences(mesh, joints));
    let normals = Some(&mesh.normals).filter(|normals| normals.len() == mesh.vertices.len() && !is_flat(mesh));
    let coords = Some(&mesh.texture_coords).filter(|coords| coords.len() == mesh.vertices.len());

    let mut known = HashMap::new();
    let mut sources = Vec::new();
    let mut indices = Vec::with_capacity(mesh.indices.len());
    for face in mesh.faces() {
        let corners = face.iter().map(|&vertex| {
            let vertex = vertex as usize;
            let bits = |v: Vec3| (v + Vec3::ZERO).to_array().map(f32::to_bits);
            let bits_of_two = |v: Vec2| (v + Vec2::ZERO).to_array().map(f32::to_bits);
            let key = (
                bits(mesh.vertices[vertex]),
                normals.map(|normals| bits(normals[vertex])),
                coords.map(|coords| bits_of_two(coords[vertex])),
                influences.as_ref().map(|influences| influences.of(vertex)),
                // Targets may move coincident vertices differently.
                (!mesh.morph_targets.is_empty()).then_some(vertex),
            );
            *known.entry(key).or_insert_with(|| {
                sources.push(vertex);
                sources.len() as u32 - 1
            })
        });
        let corners: Vec<_> = corners.collect();
        if let [a, b, c] = corners[..] {
            if a == b || b == c || c == a {
                continue;
            }
            indices.extend(if faces_inward(mesh, face) { [a, c, b] } else { [a, b, c] });
        } else {
            indices.extend(corners);
        }
    }
    if indices.is_empty() {
        return Ok(None);
    }

    let mut attributes = BTreeMap::new();
    let positions: Vec<_> = sources
        .iter()
        .map(|&vertex| (vertices[vertex] + Vec3::ZERO).to_array())
        .collect();
    attributes.insert(
        Checked::Valid(Semantic::Positions),
        buffer.push_bounded(Usage::Vertices, &positions),
    );
    if let Some(normals) = normals {
        let normals: Vec<_> = sources.iter().map(|&vertex| normals[vertex].to_array()).collect();
        attributes.insert(
            Checked::Valid(Semantic::Normals),
            buffer.push(Usage::Vertices, &normals),
        );
    }
    if let Some(coords) = coords {
        let coords: Vec<_> = sources
            .iter()
            .map(|&vertex| (coords[vertex] + Vec2::ZERO).to_array())
            .collect();
        attributes.insert(
            Checked::Valid(Semantic::TexCoords(0)),
            buffer.push(Usage::Vertices, &coords),
        );
    }
    for set in 0..influences.as_ref().map_or(0, |influences| influences.sets) {
        let ties = |vertex: usize| {
            influences
                .iter()
                .flat_map(move |all| &all.of(vertex)[SET * set..][..SET])
        };
        let numbers = |pick: fn(&(u16, u16)) -> u16| -> Vec<[u16; SET]> {
            let four = |vertex: usize| {
                let mut ties = ties(vertex);
                std::array::from_fn(|_| ties.next().map_or(0, pick))
            };
            sources.iter().map(|&vertex| four(vertex)).collect()
        };
        let (joints, weights) = (numbers(|tie| tie.0), numbers(|tie| tie.1));
        let small = |numbers: &[[u16; SET]]| -> Vec<[u8; SET]> {
            let bytes = |four: &[u16; SET]| four.map(|number| number as u8);
            numbers.iter().map(bytes).collect()
        };
        let joints = match joint_count <= JOINTS_IN_8_BITS {
            true => buffer.push(Usage::Vertices, &small(&joints)),
            false => buffer.push(Usage::Vertices, &joints),
        };
        let weights = match influences.as_ref().is_some_and(|all| all.whole == u16::MAX) {
            true => buffer.push_normalized(Usage::Vertices, &weights),
            false => buffer.push_normalized(Usage::Vertices, &small(&weights)),
        };
        attributes.insert(Checked::Valid(Semantic::Joints(set as u32)), joints);
        attributes.insert(Checked::Valid(Semantic::Weights(set as u32)), weights);
    }
    // The largest 16-bit index is reserved.
    let indices = if sources.len() <= usize::from(u16::MAX) {
        let small: Vec<_> = indices.iter().map(|&index| [index as u16]).collect();
        buffer.push(Usage::Indices, &small)
    } else {
        let large: Vec<_> = indices.iter().map(|&index| [index]).collect();
        buffer.push(Usage::Indices, &large)
    };
    let primitive = JsonPrimitive {
        attributes,
        indices: Some(indices),
        material: Some(Index::<Material>::new(mesh.material_index as u32)),
        mode: Checked::Valid(match mesh.primitive {
            Primitive::Triangles => Mode::Triangles,
            Primitive::Points => Mode::Points,
        }),
        targets: (!mesh.morph_targets.is_empty()).then(|| {
            let has_normals = normals.is_some();
            let targets = mesh.morph_targets.iter();
            targets
                .map(|own| target(own, mesh.vertices.len(), &sources, has_normals, buffer))
                .collect()
        }),
        extensions: None,
        extras: None,
    };
    Ok(Some((primitive, sources.len())))
}

/// The offsets of a target for the vertices `sources` of a mesh with `count` vertices.
fn target(own: &MorphTarget, count: usize, sources: &[usize], has_normals: bool, buffer: &mut Buffer) -> JsonTarget {
    let mut added = |offsets: &[Vec3]| {
        let mut all = vec![Vec3::ZERO; count];
        for (vertex, offset) in std::iter::zip(&own.vertex_ids, offsets) {
            all[*vertex as usize] = *offset;
        }
        let kept: Vec<_> = sources
            .iter()
            .map(|&vertex| (all[vertex] + Vec3::ZERO).to_array())
            .collect();
        buffer.push_bounded(Usage::Vertices, &kept)
    };
    JsonTarget {
        positions: Some(added(&own.offsets)),
        normals: (has_normals && !own.normal_offsets.is_empty()).then(|| added(&own.normal_offsets)),
        tangents: None,
    }
}

/// An octahedron around `centre`, for a skeleton without extent, because several clients refuse a skin that no mesh
/// uses.
pub(super) fn marker(centre: Vec3, material_index: usize) -> Mesh {
    let tips = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z];
    #[rustfmt::skip]
    let indices = vec![
        0, 1, 2,  1, 3, 2,  3, 4, 2,  4, 0, 2,
        1, 0, 5,  3, 1, 5,  4, 3, 5,  0, 4, 5,
    ];
    Mesh {
        vertices: tips.map(|tip| centre + MARKER_RADIUS * tip).to_vec(),
        indices,
        material_index,
        ..Mesh::default()
    }
}

/// The joints of each vertex, with weights that sum to 1. A vertex without weights follows the first joint. Weights
/// have 8 bits if four joints suffice for every vertex, otherwise 16.
fn influences(mesh: &Mesh, joints: &[Option<u16>]) -> Influences {
    let mut all: Vec<Vec<(f32, u16)>> = vec![Vec::new(); mesh.vertices.len()];
    for bone in &mesh.bones {
        let Some(joint) = joints[bone.node.index()] else {
            continue;
        };
        for tie in bone.weights.iter().filter(|tie| tie.weight > 0.0) {
            all[tie.vertex_id as usize].push((tie.weight, joint));
        }
    }
    let most = all.iter().map(Vec::len).max().unwrap_or(0);
    let whole = if most <= SET { u8::MAX.into() } else { u16::MAX };
    let rounded = all.into_iter().map(|ties| rounded(ties, whole)).collect::<Vec<_>>();
    let most = rounded.iter().map(Vec::len).max().unwrap_or(0);
    let sets = most.div_ceil(SET).max(1);
    let ties = rounded.into_iter().flat_map(|mut ties| {
        ties.resize(SET * sets, (0, 0));
        ties
    });
    Influences {
        sets,
        whole,
        ties: ties.collect(),
    }
}

/// Integer weights that sum to `whole`, the strongest first. Weights that round to 0 are dropped.
fn rounded(mut ties: Vec<(f32, u16)>, whole: u16) -> Vec<(u16, u16)> {
    ties.sort_by(|a, b| b.0.total_cmp(&a.0));
    let sum: f32 = ties.iter().map(|tie| tie.0).sum();
    let others = ties.iter().skip(1).map(|(weight, joint)| {
        let weight = (weight / sum * f32::from(whole)).round() as u16;
        (*joint, weight)
    });
    let others: Vec<(u16, u16)> = others.filter(|(_, weight)| *weight > 0).collect();
    // The strongest weight takes the rounding error, so that the sum is exact.
    let left = others
        .iter()
        .fold(whole, |left, (_, weight)| left.saturating_sub(*weight));
    let first = (ties.first().map_or(0, |tie| tie.1), left);
    std::iter::once(first).chain(others).collect()
}

/// The normal of a triangle that is counter-clockwise from outside. Its length is twice the area.
fn face_normal(mesh: &Mesh, face: &[u32]) -> Vec3 {
    let [a, b, c] = [0, 1, 2].map(|corner| mesh.vertices[face[corner] as usize]);
    (b - a).cross(c - a)
}

/// Whether the normals show that a face is clockwise, as in Assimp's skeleton mesh. glTF needs counter-clockwise faces.
fn faces_inward(mesh: &Mesh, face: &[u32]) -> bool {
    mesh.normals.len() == mesh.vertices.len() && face_normal(mesh, face).dot(mesh.normals[face[0] as usize]) < 0.0
}

/// Whether every vertex has the normal of its face.
fn is_flat(mesh: &Mesh) -> bool {
    mesh.primitive == Primitive::Triangles
        && mesh.faces().all(|face| {
            let normal = face_normal(mesh, face).normalize_or_zero();
            normal == Vec3::ZERO
                || face
                    .iter()
                    .all(|&v| mesh.normals[v as usize].dot(normal).abs() > SAME_DIRECTION)
        })
}
