//! Writes meshes: a geometry and a model for each mesh, and a skin with a cluster for each bone.
//!
//! A mesh of FBX can have several materials, but a mesh of a scene has one. So consecutive meshes of one node with the
//! same name and bones become one mesh.

use std::collections::BTreeSet;

use glam::{DMat4, DVec3};
use mocap_scene::error::Result;
use mocap_scene::limits::is_plausible;
use mocap_scene::math::rotation::to_euler_xyz;
use mocap_scene::pose::complete_bind_pose;
use mocap_scene::scene::{Mesh, MorphTarget, Primitive, RotationOrder, Scene};

use super::blend_shapes::{self, WrittenTarget};
use super::document::{Document, Id, SCENE_ROOT};
use super::encode::{Array, Element};
use super::material::Materials;
use super::names::Names;
use super::properties::Properties;
use super::skeleton::{Placed, model};
use super::space::Space;
use super::{FbxReport, FbxTextures, unrepresentable};

/// The transforms from nodes to the world in the bind pose, from the first mesh that is bound to the node or an
/// ancestor. Nodes in their rest pose have `None`.
pub(super) fn binds(scene: &Scene, space: &Space, placed: &[Placed]) -> Vec<Option<DMat4>> {
    let mut binds = vec![None; placed.len()];
    for mesh in scene.meshes.iter().filter(|mesh| is_written(mesh)) {
        let to_world = to_world(mesh, space, placed);
        for bone in &mesh.bones {
            binds[bone.node.index()]
                .get_or_insert_with(|| to_world * space.map(bone.offset_matrix.as_dmat4()).inverse());
        }
    }
    let rest: Vec<DMat4> = placed.iter().map(|at_rest| at_rest.world).collect();
    complete_bind_pose(&scene.nodes, &rest, &mut binds);
    binds
}

/// The nodes to which a mesh is bound.
pub(super) fn bound_nodes(scene: &Scene) -> BTreeSet<usize> {
    let meshes = scene.meshes.iter().filter(|mesh| is_written(mesh));
    let bones = meshes.flat_map(|mesh| &mesh.bones);
    bones.map(|bone| bone.node.index()).collect()
}

/// The transform of a mesh with bones: the identity, unless the mesh has another size in the world. Blender assumes
/// that the bind pose is the pose of the skeleton in the world.
fn to_world(mesh: &Mesh, space: &Space, placed: &[Placed]) -> DMat4 {
    let Some(bone) = mesh.bones.first() else {
        return DMat4::IDENTITY;
    };
    let at_rest = placed[bone.node.index()].world * space.map(bone.offset_matrix.as_dmat4());
    let size = at_rest.determinant().abs().cbrt();
    let is_other = at_rest.is_finite() && size > 1e-9 && (size - 1.0).abs() > 1e-3;
    if is_other { at_rest } else { DMat4::IDENTITY }
}

/// The written meshes.
#[derive(Default)]
pub(super) struct Meshes<'a> {
    /// The models of meshes with bones, and their transforms in the bind pose.
    pub(super) skinned: Vec<(Id, DMat4)>,
    pub(super) targets: Vec<WrittenTarget<'a>>,
}

/// Adds the meshes of `scene`. `bound` converts the bind transform of a node, as a mesh states it, to the transform in
/// the file.
pub(super) fn write<'a>(
    scene: &'a Scene,
    space: &Space,
    (placed, bound): (&[Placed], &dyn Fn(usize, DMat4) -> DMat4),
    textures: FbxTextures,
    names: &mut Names,
    document: &mut Document<'a>,
    report: &mut FbxReport,
) -> Result<Meshes<'a>> {
    let mut materials = Materials::new(scene, textures);
    let mut written = Meshes::default();
    for (index, node) in scene.nodes.iter().enumerate() {
        let own: Vec<&Mesh> = node.meshes.iter().map(|mesh| &scene.meshes[*mesh]).collect();
        let own: Vec<&Mesh> = own.into_iter().filter(|mesh| is_written(mesh)).collect();
        for parts in own.chunk_by(|a, b| is_one(a, b)) {
            let first = parts[0];
            let instead = if node.name.trim().is_empty() {
                "Mesh"
            } else {
                &node.name
            };
            let name = if first.bones.is_empty() && first.name.is_empty() {
                format!("{instead}_mesh")
            } else {
                first.name.clone()
            };
            let name = names.unique(&name, "Mesh");
            let (geometry, element) = document.object("Geometry", [&name, "Geometry", "Mesh"]);
            let element = shape(element, parts, space, &name, report)?;
            document.add("Geometry", element);
            let (id, element) = document.object("Model", [&name, "Model", "Mesh"]);
            let transform = to_world(first, space, placed);
            document.add("Model", model(element, placed_at(transform)));
            document.connect(geometry, id);
            // A skinned mesh has no parent: its bones move it in the world.
            let parent = if first.bones.is_empty() {
                placed[index].id
            } else {
                SCENE_ROOT
            };
            document.connect(id, parent);
            let mut used: Vec<usize> = Vec::new();
            for part in parts.iter().filter(|_| has_materials(scene, parts)) {
                if !used.contains(&part.material_index) {
                    used.push(part.material_index);
                    let material = materials.id(part.material_index, document);
                    document.connect(material, id);
                }
            }
            if !first.bones.is_empty() {
                skin(geometry, &name, parts, space, (placed, bound), document)?;
                written.skinned.push((id, transform));
            }
            written
                .targets
                .extend(blend_shapes::write(geometry, &name, parts, space, document)?);
        }
    }
    materials.report(report);
    Ok(written)
}

/// A mesh of points is not written.
fn is_written(mesh: &Mesh) -> bool {
    mesh.primitive == Primitive::Triangles && !mesh.indices.is_empty()
}

/// Whether two meshes of the scene become parts of one mesh in the file.
fn is_one(a: &Mesh, b: &Mesh) -> bool {
    let bones = |mesh: &Mesh| mesh.bones.len();
    let layers = |mesh: &Mesh| (mesh.normals.is_empty(), mesh.texture_coords.is_empty());
    let is_alike = |a: &MorphTarget, b: &MorphTarget| a.weight == b.weight && a.weight_keys == b.weight_keys;
    let moves_alike = |target: &MorphTarget| {
        let mut others = b.morph_targets.iter().filter(|other| other.name == target.name);
        others.all(|other| is_alike(target, other))
    };
    a.name == b.name
        && a.morph_targets.iter().all(moves_alike)
        && bones(a) == bones(b)
        && layers(a).0 == layers(b).0
        && a.material_index != b.material_index
        && std::iter::zip(&a.bones, &b.bones).all(|(a, b)| a.node == b.node && a.offset_matrix == b.offset_matrix)
}

/// Whether a part has a colour. Otherwise readers use their default material.
fn has_materials(scene: &Scene, parts: &[&Mesh]) -> bool {
    let surface = |mesh: &&Mesh| {
        let material = scene.materials.get(mesh.material_index);
        material.is_some_and(|material| material.surface.is_some())
    };
    parts.iter().any(surface)
}

fn placed_at<'a>(transform: DMat4) -> Properties<'a> {
    let (scale, rotation, translation) = transform.to_scale_rotation_translation();
    Properties::new()
        .flag("RotationActive", true)
        .choice("InheritType", 1)
        .property("DefaultAttributeIndex", ["int", "Integer", ""], [0.into()])
        .own("Lcl Translation", translation)
        .own("Lcl Rotation", to_euler_xyz(rotation, RotationOrder::Zyx, DVec3::ZERO))
        .own("Lcl Scaling", scale)
}

/// The vertices, the polygons, and the layers with their attributes.
fn shape<'a>(
    element: Element<'a>,
    parts: &[&Mesh],
    space: &Space,
    name: &str,
    report: &mut FbxReport,
) -> Result<Element<'a>> {
    let vertices = || parts.iter().flat_map(|part| &part.vertices);
    report.vertices += vertices().count();
    let is_sound = vertices().all(|vertex| vertex.to_array().into_iter().all(|value| is_plausible(value.into())));
    let is_whole = parts.iter().all(|part| {
        let count = part.vertices.len();
        let fits = |length: usize| length == 0 || length == count;
        fits(part.normals.len())
            && fits(part.texture_coords.len())
            && part.indices.len() % 3 == 0
            && part.indices.iter().all(|vertex| (*vertex as usize) < count)
    });
    if !is_sound || !is_whole {
        let message = format!("a vertex of the mesh \"{name}\" is not finite, or a face refers to a missing vertex");
        return Err(unrepresentable(name, message));
    }
    let mut corners: Vec<i32> = Vec::new();
    let mut faces: Vec<i32> = Vec::new();
    let mut materials: Vec<usize> = Vec::new();
    let mut start = 0;
    for part in parts {
        let material = materials.iter().position(|known| *known == part.material_index);
        let material = material.unwrap_or_else(|| {
            materials.push(part.material_index);
            materials.len() - 1
        });
        for face in part.indices.chunks_exact(3) {
            let mut face = [face[0], face[1], face[2]];
            if part.name.is_empty() && faces_inward(part, face) {
                face.swap(1, 2);
            }
            corners.extend(face.map(|vertex| start + vertex as i32));
            faces.push(material as i32);
        }
        start += part.vertices.len() as i32;
    }
    // The last corner of a polygon is stored as its bitwise complement.
    let polygons = corners.iter().enumerate();
    let polygons = polygons.map(|(index, corner)| if index % 3 == 2 { !corner } else { *corner });
    let without = parts.iter().map(|part| part.vertices_without_targets());
    let without: Vec<_> = without.collect();
    let coordinates = without.iter().flat_map(|vertices| vertices.iter());
    let coordinates = coordinates.flat_map(|vertex| space.point(*vertex).to_array());
    let mut element = element
        .child(Element::of("GeometryVersion", 124))
        .child(Element::of("Vertices", Array::doubles(coordinates)))
        .child(Element::of("PolygonVertexIndex", Array::ints(polygons)));
    let corners = Array::ints(corners);
    let mut layer = Element::of("Layer", 0).child(Element::of("Version", 100));
    let in_layer = |kind: &'static str| {
        Element::new("LayerElement")
            .child(Element::of("Type", kind))
            .child(Element::of("TypedIndex", 0))
    };
    if parts.iter().all(|part| !part.normals.is_empty()) {
        let normals = parts.iter().flat_map(|part| &part.normals);
        let normals = normals.flat_map(|normal| space.direction(*normal).to_array());
        element = element.child(
            by_corner(Element::of("LayerElementNormal", 0))
                .child(Element::of("Normals", Array::doubles(normals)))
                .child(Element::of("NormalsIndex", corners.clone())),
        );
        layer = layer.child(in_layer("LayerElementNormal"));
    }
    if parts.iter().any(|part| !part.texture_coords.is_empty()) {
        let coords = parts.iter().flat_map(|part| {
            let own = part.texture_coords.iter().copied();
            let none = part.vertices.len() - part.texture_coords.len();
            own.chain(std::iter::repeat_n(glam::Vec2::ZERO, none))
        });
        // The origin of texture coordinates is the lower left corner in FBX, and the upper left corner in a scene.
        let coords = coords.flat_map(|uv| [f64::from(uv.x), 1.0 - f64::from(uv.y)]);
        element = element.child(
            by_corner(Element::of("LayerElementUV", 0))
                .child(Element::of("UV", Array::doubles(coords)))
                .child(Element::of("UVIndex", corners)),
        );
        layer = layer.child(in_layer("LayerElementUV"));
    }
    let (mapping, faces) = match materials.len() {
        1 => ("AllSame", vec![0]),
        _ => ("ByPolygon", faces),
    };
    element = element.child(
        Element::of("LayerElementMaterial", 0)
            .child(Element::of("Version", 101))
            .child(Element::of("Name", ""))
            .child(Element::of("MappingInformationType", mapping))
            .child(Element::of("ReferenceInformationType", "IndexToDirect"))
            .child(Element::of("Materials", Array::ints(faces))),
    );
    Ok(element.child(layer.child(in_layer("LayerElementMaterial"))))
}

/// A layer with an index for each corner of a polygon.
fn by_corner(element: Element<'_>) -> Element<'_> {
    element
        .child(Element::of("Version", 101))
        .child(Element::of("Name", ""))
        .child(Element::of("MappingInformationType", "ByPolygonVertex"))
        .child(Element::of("ReferenceInformationType", "IndexToDirect"))
}

/// Whether a face is clockwise according to its normals, as in Assimp's skeleton mesh.
fn faces_inward(mesh: &Mesh, face: [u32; 3]) -> bool {
    let [a, b, c] = face.map(|vertex| mesh.vertices[vertex as usize]);
    let normal = mesh.normals.get(face[0] as usize);
    normal.is_some_and(|normal| (b - a).cross(c - a).dot(*normal) < 0.0)
}

/// Adds the skin of a mesh, with a cluster for each bone.
fn skin(
    geometry: Id,
    name: &str,
    parts: &[&Mesh],
    space: &Space,
    (placed, bound): (&[Placed], &dyn Fn(usize, DMat4) -> DMat4),
    document: &mut Document<'_>,
) -> Result<()> {
    let (skin, element) = document.object("Deformer", [name, "Deformer", "Skin"]);
    let element = element
        .child(Element::of("Version", 101))
        .child(Element::of("Link_DeformAcuracy", 50.0));
    document.add("Deformer", element);
    document.connect(skin, geometry);
    let bones = &parts[0].bones;
    let transform = to_world(parts[0], space, placed);
    let mut ties: Vec<(Vec<i32>, Vec<f64>)> = vec![(Vec::new(), Vec::new()); bones.len()];
    let mut start = 0;
    for part in parts {
        let mut is_tied = vec![false; part.vertices.len()];
        for (bone, ties) in std::iter::zip(&part.bones, &mut ties) {
            for tie in bone.weights.iter().filter(|tie| tie.weight > 0.0) {
                let Some(is_tied) = is_tied.get_mut(tie.vertex_id as usize) else {
                    let message = format!("a bone of the mesh \"{name}\" refers to a missing vertex");
                    return Err(unrepresentable(&bone.name, message));
                };
                *is_tied = true;
                ties.0.push(start + tie.vertex_id as i32);
                ties.1.push(tie.weight.into());
            }
        }
        // A vertex without a weight follows the first bone.
        for (vertex, _) in is_tied.iter().enumerate().filter(|(_, is_tied)| !**is_tied) {
            ties[0].0.push(start + vertex as i32);
            ties[0].1.push(1.0);
        }
        start += part.vertices.len() as i32;
    }
    for (bone, (vertices, weights)) in std::iter::zip(bones, ties) {
        let to_bone = space.map(bone.offset_matrix.as_dmat4());
        let to_world = bound(bone.node.index(), transform * to_bone.inverse());
        if !to_bone.is_finite() || !to_world.is_finite() {
            let message = format!("its bind pose in the mesh \"{name}\" has no inverse");
            return Err(unrepresentable(&bone.name, message));
        }
        let (cluster, element) = document.object("Deformer", [&bone.name, "SubDeformer", "Cluster"]);
        let mut element = element
            .child(Element::of("Version", 100))
            .child(Element::of("UserData", "").with(""));
        if !vertices.is_empty() {
            element = element
                .child(Element::of("Indexes", Array::ints(vertices)))
                .child(Element::of("Weights", Array::doubles(weights)));
        }
        let element = element
            .child(Element::of("Transform", Array::doubles(to_bone.to_cols_array())))
            .child(Element::of("TransformLink", Array::doubles(to_world.to_cols_array())));
        document.add("Deformer", element);
        document.connect(cluster, skin);
        document.connect(placed[bone.node.index()].id, cluster);
    }
    Ok(())
}
