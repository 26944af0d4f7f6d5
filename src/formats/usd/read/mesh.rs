//! The meshes of a layer with the joints that move them, their materials and their textures, for a comparison.

use std::collections::HashMap;
use std::path::Path;

use glam::{DMat4, Vec2, Vec3, Vec4};
use mocap_scene::error::Result;
use mocap_scene::scene::{Bone, Material, Mesh, NodeId, Scene, Surface, Texture, VertexWeight};

use super::skeleton::Skeleton;
use crate::usd::archive;
use crate::usd::parse::{Layer, Prim};
use crate::{Source, usd};

/// The joints that may move all vertices of a mesh alike: one moves a rigid mesh.
const MOST_FOR_ALL: usize = 8;

/// Adds the meshes whose numbers fit each other; others are left out.
pub(super) fn add(layer: &Layer, skeleton: &Skeleton, source: &Source<'_>, scene: &mut Scene) {
    let Some(joints) = Joints::of(layer, skeleton) else {
        return;
    };
    let is_look = |prim: &&Prim| matches!(prim.kind.as_str(), "Material" | "Shader");
    let looks = layer.prims.iter().enumerate().filter(|(_, prim)| is_look(prim));
    let looks: HashMap<String, &Prim> = looks.map(|(index, prim)| (layer.path(index), prim)).collect();
    let mut materials: HashMap<&str, usize> = HashMap::new();
    for (path, prim) in looks.iter().filter(|(_, prim)| prim.kind == "Material") {
        materials.insert(path, scene.materials.len());
        let material = material(&looks, prim, source, &mut scene.textures);
        scene.materials.push(material);
    }
    // A mesh without a material has one without a colour.
    let plain = scene.materials.len();
    scene.materials.push(Material::default());
    for prim in layer.prims.iter().filter(|prim| prim.kind == "Mesh") {
        let Some(mut mesh) = joints.mesh(prim) else { continue };
        let bound = prim.texts("material:binding").first();
        let material = bound.and_then(|path| materials.get(path.as_str()));
        mesh.material_index = material.copied().unwrap_or(plain);
        let node = mesh.bones.first().map_or(0, |bone| bone.node.index());
        scene.nodes[node].meshes.push(scene.meshes.len());
        scene.meshes.push(mesh);
    }
}

/// The joints of a skeleton in its own order.
struct Joints<'a> {
    skeleton: &'a Skeleton,
    /// The node of each, and its matrix in the bind pose.
    all: Vec<(usize, DMat4)>,
}

impl<'a> Joints<'a> {
    fn of(layer: &Layer, skeleton: &'a Skeleton) -> Option<Self> {
        let prim = layer
            .prims
            .iter()
            .find(|prim| prim.kind == "Skeleton" && !prim.texts("joints").is_empty())?;
        let nodes = prim
            .texts("joints")
            .iter()
            .map(|path| skeleton.joints.get(path).copied());
        let nodes = nodes.collect::<Option<Vec<usize>>>()?;
        let (matrices, rest) = numbers(prim, "bindTransforms").as_chunks::<16>();
        let matrices = matrices.iter().map(DMat4::from_cols_array);
        let all: Vec<_> = std::iter::zip(nodes, matrices).collect();
        (rest.is_empty() && all.len() == skeleton.joints.len()).then_some(Self { skeleton, all })
    }

    fn mesh(&self, prim: &Prim) -> Option<Mesh> {
        let vectors = |name: &str| -> Vec<Vec3> {
            let (vectors, _) = numbers(prim, name).as_chunks::<3>();
            vectors
                .iter()
                .map(|vector| Vec3::from(vector.map(|number| number as f32)))
                .collect()
        };
        let (vertices, mut normals) = (vectors("points"), vectors("normals"));
        // Normals follow from the faces where a file has none, and are not compared.
        normals.resize(vertices.len(), Vec3::Y);
        normals
            .iter_mut()
            .for_each(|normal| *normal = normal.normalize_or(Vec3::Y));
        if numbers(prim, "faceVertexCounts").iter().any(|count| *count != 3.0) {
            return None;
        }
        let indices = numbers(prim, "faceVertexIndices").iter().map(|index| *index as u32);
        let indices: Vec<u32> = indices.collect();
        if !indices.len().is_multiple_of(3) || indices.iter().any(|index| *index as usize >= vertices.len()) {
            return None;
        }
        let (coords, _) = numbers(prim, "primvars:st").as_chunks::<2>();
        let coords = coords.iter().map(|[u, v]| Vec2::new(*u as f32, 1.0 - *v as f32));
        let coords: Vec<Vec2> = coords.collect();
        let bind = numbers(prim, "primvars:skel:geomBindTransform");
        let bind = <[f64; 16]>::try_from(bind).map_or(DMat4::IDENTITY, |columns| DMat4::from_cols_array(&columns));
        Some(Mesh {
            name: display_name(prim),
            texture_coords: if coords.len() == vertices.len() {
                coords
            } else {
                Vec::new()
            },
            bones: self.bones(prim, vertices.len(), bind)?,
            vertices,
            normals,
            indices,
            ..Mesh::default()
        })
    }

    fn bones(&self, prim: &Prim, count: usize, bind: DMat4) -> Option<Vec<Bone>> {
        let (ties, weights) = (
            numbers(prim, "primvars:skel:jointIndices"),
            numbers(prim, "primvars:skel:jointWeights"),
        );
        if ties.len() != weights.len() || ties.is_empty() || count == 0 {
            return None;
        }
        // One list for each vertex, or a short one for all.
        let each = match ties.len() % count {
            0 => ties.len() / count,
            _ if ties.len() <= MOST_FOR_ALL => ties.len(),
            _ => return None,
        };
        let mut weights_of: Vec<Vec<VertexWeight>> = vec![Vec::new(); self.all.len()];
        for vertex in 0..count {
            let start = if ties.len() == each { 0 } else { vertex * each };
            let sum: f64 = weights[start..start + each]
                .iter()
                .filter(|weight| **weight > 0.0)
                .sum();
            for (joint, weight) in std::iter::zip(&ties[start..start + each], &weights[start..start + each]) {
                let of_joint = weights_of.get_mut(*joint as usize)?;
                if *weight > 0.0 && sum > 0.0 {
                    of_joint.push(VertexWeight {
                        vertex_id: vertex as u32,
                        weight: (*weight / sum) as f32,
                    });
                }
            }
        }
        let bones = std::iter::zip(&self.all, weights_of).filter(|(_, weights)| !weights.is_empty());
        let bone = |(&(node, matrix), weights): (&(usize, DMat4), Vec<VertexWeight>)| Bone {
            name: self.skeleton.nodes[node].name.clone(),
            node: NodeId::new(node),
            offset_matrix: (matrix.inverse() * bind).as_mat4(),
            weights,
        };
        Some(bones.map(bone).collect())
    }
}

fn numbers<'a>(prim: &'a Prim, name: &str) -> &'a [f64] {
    let value = prim.attributes.get(name).and_then(|attribute| attribute.value.as_ref());
    value.map_or(&[], |value| &value.numbers)
}

fn display_name(prim: &Prim) -> String {
    let stated = prim.metadata.get("displayName").and_then(|value| value.texts.first());
    stated.unwrap_or(&prim.name).clone()
}

/// A material with its colour, as the surface that it is connected to has it.
fn material(looks: &HashMap<String, &Prim>, prim: &Prim, source: &Source<'_>, textures: &mut Vec<Texture>) -> Material {
    let connected = |prim: &Prim, input: &str| {
        let output = prim.texts(&format!("{input}.connect")).first()?;
        looks.get(output.split('.').next()?).copied()
    };
    let name = display_name(prim);
    let Some(surface) = connected(prim, "outputs:surface") else {
        return Material {
            name,
            ..Material::default()
        };
    };
    let image = connected(surface, "inputs:diffuseColor");
    let color = match image {
        Some(image) => numbers(image, "inputs:scale"),
        None => numbers(surface, "inputs:diffuseColor"),
    };
    let opacity = numbers(surface, "inputs:opacity").first();
    let part = |index: usize| color.get(index).map_or(1.0, |part| *part as f32);
    let mut looks = Surface {
        base_color: Vec4::new(
            part(0),
            part(1),
            part(2),
            opacity.map_or(part(3), |alpha| *alpha as f32),
        ),
        ..Surface::default()
    };
    let file = image.and_then(|image| image.texts("inputs:file").first());
    if let Some(bytes) = file.and_then(|file| open(file, source).ok()) {
        looks.texture = Some(textures.len());
        textures.push(Texture {
            bytes,
            ..Texture::default()
        });
    }
    Material {
        name,
        surface: Some(looks),
        ..Material::default()
    }
}

/// The bytes of a texture: in the archive, or beside the file.
fn open(file: &str, source: &Source<'_>) -> Result<Vec<u8>> {
    match usd::is_archive(source.bytes) {
        true => Ok(archive::file(source.bytes, file)?.to_vec()),
        false => (source.open)(
            &source
                .name
                .with_file_name(Path::new(file).file_name().unwrap_or_default()),
        ),
    }
}
