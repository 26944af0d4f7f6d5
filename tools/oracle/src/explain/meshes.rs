//! The explained differences of meshes.

use super::{Case, length};
use crate::difference::{BONE_COUNT, FACE_COUNT, NORMAL_COUNT, Place, VERTEX_COUNT, all_close, close};
use crate::scene::{Mesh, Scene};

/// The largest distance of a bone from the origin on each axis at which Assimp's Debone does not transform its mesh.
const DEBONE_IDENTITY: f64 = 0.01;

/// Below this length of a face's cross product Assimp gives the face the normal 1 0 0.
const SMALL_FACE: f64 = 1e-5;

impl Case<'_> {
    /// Whether the normals point the same way, within the rounding of Assimp's vertices.
    ///
    /// Assimp computes a normal from vertices in mesh space. Far from the origin, the rounding of the vertices turns
    /// the normal by about the rounding divided by the height of the triangle.
    fn same_direction(&self, mesh: usize, vertex: usize) -> bool {
        let (assimp, ours) = (&self.assimp.meshes[mesh], &self.ours.meshes[mesh]);
        let Some(face) = face_of(assimp, vertex) else {
            return false;
        };
        let origin = self.assimp.mesh_origin(mesh);
        let farthest = face
            .iter()
            .flat_map(|corner| corner.iter().zip(origin))
            .map(|(part, origin)| (part + origin).abs());
        let rounding = farthest.fold(0.0, f64::max) * f64::from(f32::EPSILON);
        let height = length(&cross(face)) / longest_edge(face);
        let normal = &assimp.normals[vertex];
        let along = ours.normals[vertex]
            .iter()
            .zip(normal)
            .map(|(ours, part)| (ours - part / length(normal)).abs());
        along.fold(0.0, f64::max) <= 1e-5 + 4.0 * rounding / height
    }

    /// The rest position of the node with the mesh, if Assimp's Debone treated its offset matrix as the identity.
    fn near_origin(&self, mesh: usize) -> Option<[f64; 3]> {
        let position = self.assimp.rest_position(self.assimp.holder(mesh)?);
        (self.processed && position.iter().all(|part| part.abs() <= DEBONE_IDENTITY)).then_some(position)
    }
}

pub(super) fn normal_not_unit(case: &Case<'_>, place: Place) -> bool {
    let Place::Normal(mesh, vertex) = place else {
        return false;
    };
    let normal_is_kept = !case.processed || case.near_origin(mesh).is_some();
    normal_is_kept && case.same_direction(mesh, vertex)
}

pub(super) fn normal_rounded(case: &Case<'_>, place: Place) -> bool {
    let Place::Normal(mesh, vertex) = place else {
        return false;
    };
    close(length(&case.assimp.meshes[mesh].normals[vertex]), 1.0) && case.same_direction(mesh, vertex)
}

pub(super) fn normal_of_small_face(case: &Case<'_>, place: Place) -> bool {
    let Place::Normal(mesh, vertex) = place else {
        return false;
    };
    let (assimp, ours) = (&case.assimp.meshes[mesh], &case.ours.meshes[mesh]);
    let (Some(assimp_face), Some(our_face)) = (face_of(assimp, vertex), face_of(ours, vertex)) else {
        return false;
    };
    let our_cross = cross(our_face);
    let unit = our_cross.iter().map(|part| part / length(&our_cross));
    // Single precision leaves fewer digits of a cross product this small.
    let along_face = ours.normals[vertex].iter().zip(unit).all(|(a, b)| (a - b).abs() < 1e-3);
    length(&cross(assimp_face)) < SMALL_FACE && all_close(&assimp.normals[vertex], &[1.0, 0.0, 0.0]) && along_face
}

/// The corners of the first triangle that has the vertex.
fn face_of(mesh: &Mesh, vertex: usize) -> Option<[&[f64]; 3]> {
    let face = mesh.faces.iter().find(|face| face.contains(&vertex))?;
    let &[a, b, c] = face.as_slice() else { return None };
    Some([mesh.vertices.get(a)?, mesh.vertices.get(b)?, mesh.vertices.get(c)?])
}

fn edge(from: &[f64], to: &[f64]) -> [f64; 3] {
    [to[0] - from[0], to[1] - from[1], to[2] - from[2]]
}

/// The cross product of two edges, in the order that Assimp's faces turn.
fn cross([a, b, c]: [&[f64]; 3]) -> [f64; 3] {
    let (u, v) = (edge(a, c), edge(a, b));
    [
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    ]
}

fn longest_edge([a, b, c]: [&[f64]; 3]) -> f64 {
    [(a, b), (b, c), (c, a)]
        .into_iter()
        .map(|(from, to)| length(&edge(from, to)))
        .fold(0.0, f64::max)
}

pub(super) fn near_origin_untransformed(case: &Case<'_>, place: Place) -> bool {
    let Place::Vertex(mesh, vertex) = place else {
        return false;
    };
    let Some(origin) = case.near_origin(mesh) else {
        return false;
    };
    let moved: Vec<f64> = case.assimp.meshes[mesh].vertices[vertex]
        .iter()
        .zip(origin)
        .map(|(part, origin)| part - origin)
        .collect();
    all_close(&moved, &case.ours.meshes[mesh].vertices[vertex])
}

pub(super) fn cache_locality_order(case: &Case<'_>, place: Place) -> bool {
    let Place::Faces(mesh) = place else { return false };
    let sorted = |mesh: &Mesh| {
        let mut faces = mesh.faces.clone();
        faces.sort_unstable();
        faces
    };
    let (assimp, ours) = (&case.assimp.meshes[mesh], &case.ours.meshes[mesh]);
    let corners: usize = assimp.faces.iter().map(Vec::len).sum();
    let shares_vertices = corners > assimp.vertices.len();
    case.processed && assimp.vertices.len() > 12 && shares_vertices && sorted(assimp) == sorted(ours)
}

pub(super) fn small_faces_joined(case: &Case<'_>, place: Place) -> bool {
    let (Place::Mesh(mesh, VERTEX_COUNT | NORMAL_COUNT)
    | Place::Vertex(mesh, _)
    | Place::Normal(mesh, _)
    | Place::Faces(mesh)) = place
    else {
        return false;
    };
    let is_small = |vertex: usize| {
        face_of(&case.assimp.meshes[mesh], vertex).is_some_and(|face| length(&cross(face)) < SMALL_FACE)
    };
    // Near the origin, Debone does not transform the mesh either.
    let origin = if case.near_origin(mesh).is_some() {
        [0.0; 3]
    } else {
        case.assimp.mesh_origin(mesh)
    };
    let ours = mesh_triangles(case.ours, mesh, case.ours.mesh_origin(mesh));
    case.processed
        && (0..case.assimp.meshes[mesh].vertices.len()).all(is_small)
        && same_triangles(mesh_triangles(case.assimp, mesh, origin), ours)
}

pub(super) fn joined_across_bones(case: &Case<'_>, place: Place) -> bool {
    let of_meshes = matches!(
        place,
        Place::Count("meshes")
            | Place::Node(_, "meshes")
            | Place::Mesh(_, VERTEX_COUNT | NORMAL_COUNT | FACE_COUNT | BONE_COUNT)
            | Place::Vertex(..)
            | Place::Normal(..)
            | Place::Faces(_)
            | Place::Bone(..)
    );
    of_meshes
        && case.processed
        && *case
            .draws_twins
            .get_or_init(|| has_twins(case.assimp) && same_triangles(triangles(case.assimp), triangles(case.ours)))
}

/// Whether two bones have the same pointer or knob at the same place.
fn has_twins(scene: &Scene) -> bool {
    let offset = |node: usize| [3, 7, 11].map(|element| scene.nodes[node].matrix[element]);
    let is_leaf = |node: usize| scene.nodes.iter().all(|other| other.parent != Some(node));
    let mut pointers = Vec::new();
    let mut knobs = Vec::new();
    for (index, node) in scene.nodes.iter().enumerate() {
        if let Some(parent) = node.parent.filter(|_| length(&offset(index)) > 0.0) {
            pointers.push((parent, scene.rest_position(parent), offset(index)));
        }
        if is_leaf(index) {
            knobs.push((index, scene.rest_position(index), [length(&offset(index)); 3]));
        }
    }
    [pointers, knobs].iter().any(|pieces| {
        pieces.iter().enumerate().any(|(index, a)| {
            pieces[..index]
                .iter()
                .any(|b| a.0 != b.0 && all_close(&a.1, &b.1) && all_close(&a.2, &b.2))
        })
    })
}

/// Whether these are the same triangles in any order.
fn same_triangles(assimp: Vec<Vec<f64>>, mut ours: Vec<Vec<f64>>) -> bool {
    assimp.len() == ours.len()
        && assimp.iter().all(|triangle| {
            let twin = ours.iter().position(|other| all_close(triangle, other));
            twin.map(|twin| ours.swap_remove(twin)).is_some()
        })
}

/// The triangles that a scene draws in the rest pose, independent of their mesh and node.
fn triangles(scene: &Scene) -> Vec<Vec<f64>> {
    (0..scene.meshes.len())
        .flat_map(|mesh| mesh_triangles(scene, mesh, scene.mesh_origin(mesh)))
        .collect()
}

/// The corners of every face of a mesh whose origin is at `origin`.
fn mesh_triangles(scene: &Scene, mesh: usize, origin: [f64; 3]) -> Vec<Vec<f64>> {
    let mesh = &scene.meshes[mesh];
    let corners = |face: &Vec<usize>| {
        let parts = face.iter().flat_map(|&vertex| mesh.vertices[vertex].iter().zip(origin));
        parts.map(|(part, origin)| part + origin).collect()
    };
    mesh.faces.iter().map(corners).collect()
}
