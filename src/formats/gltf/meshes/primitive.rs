//! Reads one primitive: vertices, faces, and the weights of its bones.

use std::collections::{BTreeMap, HashMap};

use glam::{Mat3, Vec2, Vec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::scene::{Bone, Mesh, VertexWeight};
use serde::Deserialize;
use serde_json::{Map, Value};

use super::super::file::is_plausible;
use super::super::invalid::invalid;
use super::{Binding, Buffers, materials, morph_targets};
use crate::Failure;
use crate::warnings::Warnings;

#[derive(Deserialize)]
pub(super) struct Primitive {
    attributes: BTreeMap<String, usize>,
    indices: Option<usize>,
    pub(super) material: Option<usize>,
    mode: Option<u32>,
    #[serde(default)]
    pub(super) targets: Vec<BTreeMap<String, usize>>,
    #[serde(default)]
    extensions: Map<String, Value>,
    #[serde(default)]
    pub(super) extras: Value,
}

const TRIANGLES: u32 = 4;
const TRIANGLE_STRIP: u32 = 5;
const TRIANGLE_FAN: u32 = 6;

/// Reads a mesh without its name and material, with unnamed bones. `None` if it has no faces. Normals and weights that
/// are not finite are replaced, and morph targets that cannot be read are skipped, each with a warning in `odd`. Also
/// returns the number of each morph target in the file.
pub(super) fn read_primitive(
    primitive: &Primitive,
    binding: &Binding,
    morphs: &morph_targets::Stated<'_>,
    material: Option<&materials::Read>,
    (buffers, odd): (&mut Buffers<'_>, &mut Warnings),
    pointer: &str,
) -> Result<Option<(Mesh, Vec<usize>)>, Failure> {
    if primitive.extensions.contains_key("KHR_draco_mesh_compression") {
        return Err(invalid(pointer, "meshes compressed with Draco are not read").into());
    }
    let mut read = |name: &str, columns: usize| match primitive.attributes.get(name) {
        None => Ok(None),
        Some(&accessor) => buffers
            .numbers(accessor, columns, &format!("{pointer}/attributes/{name}"))
            .map(Some),
    };
    let Some(positions) = read("POSITION", 3)? else {
        return Err(invalid(pointer, "the primitive has no positions").into());
    };
    let count = positions.len() / 3;
    let normals = read("NORMAL", 3)?.filter(|normals| normals.len() == positions.len());
    // Texture coordinates of a mesh without a texture are kept too, if they can be read: another program may add a
    // texture.
    let surface = material.and_then(|material| material.material.surface);
    let set = material.map_or(0, |material| material.coords);
    let coords = match read(&format!("TEXCOORD_{set}"), 2) {
        Err(fault) if surface.is_some_and(|surface| surface.texture.is_some()) => return Err(fault),
        coords => coords.ok().flatten().filter(|coords| coords.len() == 2 * count),
    };
    let mut ties = Vec::new();
    if !binding.is_rigid {
        for set in 0..4 {
            let joints = read(&format!("JOINTS_{set}"), 4)?;
            let weights = read(&format!("WEIGHTS_{set}"), 4)?;
            let Some((joints, weights)) = joints.zip(weights) else {
                break;
            };
            if joints.len() != 4 * count || weights.len() != 4 * count {
                return Err(invalid(pointer, "the numbers of joints, weights and positions differ").into());
            }
            ties.push((joints, weights));
        }
        if ties.is_empty() {
            return Err(invalid(pointer, "the mesh has a skin and no weights").into());
        }
    }
    let corners = match primitive.indices {
        None => (0..count as u32).collect(),
        Some(accessor) => buffers.indices(accessor, &format!("{pointer}/indices"))?,
    };
    if let Some(corner) = corners.iter().find(|corner| **corner as usize >= count) {
        return Err(invalid(
            format!("{pointer}/indices"),
            "a face refers to a vertex that does not exist",
        )
        .expected_found(format!("below {count}"), format!("{corner}"))
        .into());
    }
    let corners = triangles(corners, primitive.mode.unwrap_or(TRIANGLES));
    if corners.is_empty() {
        return Ok(None);
    }

    // Primitives may share the vertices of a whole body. Only the vertices of this primitive are kept.
    let mut new_ids: HashMap<u32, u32> = HashMap::new();
    let mut kept: Vec<usize> = Vec::new();
    let indices = corners.into_iter().map(|old| {
        *new_ids.entry(old).or_insert_with(|| {
            kept.push(old as usize);
            kept.len() as u32 - 1
        })
    });
    let indices: Vec<u32> = indices.collect();
    let vector = |numbers: &[f32], vertex: usize| Vec3::from_slice(&numbers[3 * vertex..]);
    let mut vertices: Vec<Vec3> = kept.iter().map(|&vertex| vector(&positions, vertex)).collect();
    for (target, &weight) in primitive.targets.iter().zip(morphs.weights) {
        let Some(&accessor) = target.get("POSITION").filter(|_| weight != 0.0) else {
            continue;
        };
        let offsets = buffers.numbers(accessor, 3, &format!("{pointer}/targets"))?;
        if offsets.len() == positions.len() {
            for (vertex, &old) in vertices.iter_mut().zip(&kept) {
                *vertex += weight * vector(&offsets, old);
            }
        }
    }
    let is_placed = |vertex: &Vec3| vertex.to_array().into_iter().all(is_plausible);
    if let Some(wrong) = vertices.iter().position(|vertex| !is_placed(vertex)) {
        let message = format!("the position of vertex {} is not finite, or too large", kept[wrong]);
        return Err(Box::new(
            Diagnostic::new(Code::NonFiniteValue, message)
                .at_pointer(pointer)
                .expected_found("finite numbers", format!("{}", vertices[wrong])),
        ));
    }
    let mut tell = |what: &str, columns: usize, numbers: &[f32]| {
        let is_broken = |vertex: &&usize| {
            !numbers[columns * **vertex..][..columns]
                .iter()
                .all(|number| number.is_finite())
        };
        if let Some(vertex) = kept.iter().find(is_broken) {
            let message = format!("the {what} of vertex {vertex} is not finite");
            odd.distinct(Diagnostic::new(Code::NonFiniteValue, message).at_pointer(pointer));
        }
    };
    if let Some(normals) = &normals {
        tell("normal", 3, normals);
    }
    ties.iter()
        .for_each(|(_, weights)| tell("weight of a joint", 4, weights));
    let normals = match normals {
        Some(normals) => kept.iter().map(|&vertex| unit(vector(&normals, vertex))).collect(),
        None => normals_of(&vertices, &indices),
    };
    let texture_coords = coords.map(|coords| {
        let to_texture = material.map_or(Mat3::IDENTITY, |material| material.to_texture);
        let coordinates = |vertex: usize| {
            let point = to_texture.transform_point2(Vec2::from_slice(&coords[2 * vertex..]));
            if point.is_finite() { point } else { Vec2::ZERO }
        };
        kept.iter().map(|&vertex| coordinates(vertex)).collect()
    });
    let targets = morph_targets::read(&primitive.targets, morphs, &kept, buffers, pointer);
    let targets = targets.unwrap_or_else(|fault| {
        let message = format!("its morph targets were dropped: {}", fault.message);
        let pointer = fault.pointer.as_deref().unwrap_or(pointer);
        odd.distinct(Diagnostic::new(Code::IgnoredMesh, message).at_pointer(pointer));
        Vec::new()
    });
    let (numbers, targets) = targets.into_iter().unzip();
    let mesh = Mesh {
        morph_targets: targets,
        vertices,
        normals,
        texture_coords: texture_coords.unwrap_or_default(),
        bones: bones(binding, &ties, &kept, pointer)?,
        indices,
        ..Mesh::default()
    };
    Ok(Some((mesh, numbers)))
}

type Ties = (std::rc::Rc<[f32]>, std::rc::Rc<[f32]>);

/// The bones with the weights of the kept vertices, which sum to 1.
fn bones(binding: &Binding, ties: &[Ties], kept: &[usize], pointer: &str) -> Result<Vec<Bone>, Failure> {
    let mut bones: Vec<Bone> = Vec::new();
    let mut bone_of_node = HashMap::new();
    // A node that a skin names twice is one bone.
    let bone_of_joint: Vec<usize> = (binding.joints.iter())
        .map(|(node, offset_matrix)| {
            *bone_of_node.entry(*node).or_insert_with(|| {
                bones.push(Bone {
                    name: String::new(),
                    node: *node,
                    offset_matrix: *offset_matrix,
                    weights: Vec::new(),
                });
                bones.len() - 1
            })
        })
        .collect();
    if bones.is_empty() {
        return Err(invalid(pointer, "the skin has no joints").into());
    }
    for (vertex_id, &old) in kept.iter().enumerate() {
        let vertex_id = vertex_id as u32;
        let mut of_bones: Vec<(usize, f32)> = Vec::new();
        for (joints, weights) in ties {
            for corner in 4 * old..4 * old + 4 {
                let (joint, weight) = (joints[corner] as usize, weights[corner]);
                if !(weight > 0.0 && weight.is_finite()) {
                    continue;
                }
                let bone = *bone_of_joint.get(joint).ok_or_else(|| {
                    invalid(
                        format!("{pointer}/attributes"),
                        "a vertex refers to a joint that the skin lacks",
                    )
                    .expected_found(format!("below {}", bone_of_joint.len()), format!("{joint}"))
                })?;
                match of_bones.iter_mut().find(|(known, _)| *known == bone) {
                    Some((_, sum)) => *sum += weight,
                    None => of_bones.push((bone, weight)),
                }
            }
        }
        let sum: f32 = of_bones.iter().map(|(_, weight)| weight).sum();
        if !(sum > 0.0 && sum.is_finite()) {
            // A mesh without a skin, or a vertex without weights.
            of_bones = vec![(bone_of_joint[0], 1.0)];
        }
        let sum = if sum > 0.0 && sum.is_finite() { sum } else { 1.0 };
        for (bone, weight) in of_bones {
            let weight = (weight / sum).min(1.0);
            bones[bone].weights.push(VertexWeight { vertex_id, weight });
        }
    }
    Ok(bones)
}

/// The corners of triangles, three each. Empty for points and lines.
fn triangles(corners: Vec<u32>, mode: u32) -> Vec<u32> {
    match mode {
        TRIANGLES => {
            let whole = corners.len() / 3 * 3;
            corners[..whole].to_vec()
        }
        // Every second triangle of a strip has the opposite orientation.
        TRIANGLE_STRIP => (corners.windows(3).enumerate())
            .flat_map(|(index, c)| {
                if index % 2 == 0 {
                    [c[0], c[1], c[2]]
                } else {
                    [c[1], c[0], c[2]]
                }
            })
            .collect(),
        TRIANGLE_FAN => (corners.windows(2).skip(1))
            .flat_map(|c| [corners[0], c[0], c[1]])
            .collect(),
        _ => Vec::new(),
    }
}

/// Area-weighted vertex normals from the faces, if the file has none.
fn normals_of(vertices: &[Vec3], indices: &[u32]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; vertices.len()];
    for face in indices.chunks_exact(3) {
        let [a, b, c] = [face[0], face[1], face[2]].map(|corner| vertices[corner as usize]);
        let normal = (b - a).cross(c - a);
        for &corner in face {
            normals[corner as usize] += normal;
        }
    }
    normals.into_iter().map(unit).collect()
}

/// In double precision, because squares of tiny numbers underflow single precision.
fn unit(normal: Vec3) -> Vec3 {
    let normal = normal.as_dvec3().try_normalize();
    normal.map_or(Vec3::Y, glam::DVec3::as_vec3)
}
