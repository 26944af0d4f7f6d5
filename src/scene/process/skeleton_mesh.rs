//! Generates a mesh for a skeleton: a pointer from each joint to each of its children, and a knob at each end.

use glam::{DVec3, Mat4, Vec3};
use serde::Serialize;

use crate::scene::{Bone, Material, Mesh, Node, NodeId, NodeKind, Primitive, SKELETON_MATERIAL, Scene, VertexWeight};

/// How the skeleton mesh is attached.
///
/// `Importer::skeleton_mesh` has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum SkeletonMesh {
    /// One mesh per node, in the node's own space. Mesh `i` belongs to the `i`-th node that has a piece.
    #[default]
    Segmented,
    /// One mesh on the root, with a bone for every node that has a piece.
    Skinned,
    /// No skeleton mesh, only the meshes of the file.
    Own,
    /// No mesh.
    None,
}

/// The length in the file's unit below which links are not drawn; Assimp's limit.
const SHORTEST_LINK: f64 = 1e-6;
/// Half the width of a pointer's base, as a fraction of its length; Assimp's proportion.
const POINTER_WIDTH: f64 = 0.1;
/// Radius of a knob, as a fraction of the distance to the node's parent; Assimp's proportion.
const KNOB_RADIUS: f64 = 0.18;

/// The radius of a knob in a group, as a fraction of the diagonal of the box around all such nodes. The distance to a
/// group is arbitrary.
const LONE_KNOB_RADIUS: f64 = 0.01;

impl Scene {
    /// Adds a mesh that shows the skeleton, and its material.
    ///
    /// Before: nodes without meshes. After: every node with children has a *pointer* to each child, a pyramid of four
    /// faces whose tip is the child's origin. Every node without children has a *knob*, an octahedron of eight faces.
    ///
    /// A child at the position of its parent gets no pointer. So a node whose children are all at its own position has
    /// no piece and no bone. A group, such as the one around the points of a C3D file, gets no pointers either. The
    /// shapes equal Assimp's dummy mesh, vertex for vertex. The normals have unit length, unlike Assimp's.
    ///
    /// `Skinned` puts the pieces into one mesh on the root, placed by the rest pose in the space of the root's parent.
    /// Each bone moves its node's piece with weight 1. A scene without pieces does not change.
    ///
    /// ```
    /// use mocap::glam::{Mat4, Vec3};
    /// use mocap::process::SkeletonMesh;
    /// use mocap::scene::{Node, NodeId, Scene};
    ///
    /// let elbow = Node {
    ///     name: "Elbow".into(),
    ///     parent: Some(NodeId(0)),
    ///     transform: Mat4::from_translation(Vec3::new(2.0, 0.0, 0.0)),
    ///     ..Node::default()
    /// };
    /// let mut scene = Scene { nodes: vec![Node::default(), elbow], ..Scene::default() };
    /// scene.add_skeleton_mesh(SkeletonMesh::Segmented);
    /// assert_eq!(scene.nodes[1].meshes, [1]);
    /// assert_eq!(scene.meshes[0].faces().len(), 4);
    /// assert_eq!(scene.meshes[0].vertices[1], Vec3::new(2.0, 0.0, 0.0));
    /// ```
    pub fn add_skeleton_mesh(&mut self, kind: SkeletonMesh) {
        let is_skinned = match kind {
            SkeletonMesh::Own | SkeletonMesh::None => return,
            SkeletonMesh::Segmented => false,
            SkeletonMesh::Skinned => true,
        };
        let pieces = pieces(&self.nodes);
        if pieces.is_empty() {
            return;
        }
        let material_index = self.materials.len();
        self.materials.push(Material {
            name: SKELETON_MATERIAL.into(),
            two_sided: true,
            surface: None,
        });
        let held: Vec<(usize, Mesh)> = if is_skinned {
            vec![(0, skinned(&self.nodes, &pieces))]
        } else {
            let meshes = pieces.iter().map(|(node, corners)| (*node, mesh_of(corners)));
            meshes.collect()
        };
        for (node, mesh) in held {
            self.nodes[node].meshes.push(self.meshes.len());
            self.meshes.push(Mesh { material_index, ..mesh });
        }
    }
}

impl Scene {
    /// Removes the meshes, and the original glTF file that a writer would extend. The scene keeps the skeleton and its
    /// motion. The option `skeleton-only` has the same effect at import.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// let mut hero = mocap::Importer::new().gltf_meshes(true).import("fixtures/characters/human_default.glb")?;
    /// hero.leave_out_meshes();
    /// assert!(hero.meshes.is_empty() && hero.nodes.iter().all(|node| node.meshes.is_empty()));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn leave_out_meshes(&mut self) {
        self.original = None;
        self.metadata.fbx = None;
        self.meshes.clear();
        self.nodes.iter_mut().for_each(|node| node.meshes.clear());
    }
}

/// The corners of every node with a piece, three per face, in the node's space.
fn pieces(nodes: &[Node]) -> Vec<(usize, Vec<Vec3>)> {
    let mut corners: Vec<Vec<Vec3>> = vec![Vec::new(); nodes.len()];
    let mut is_leaf = vec![true; nodes.len()];
    let hangs_on_group = |node: &Node| {
        let parent = node.parent.map(|parent| nodes[parent.index()].kind);
        parent == Some(NodeKind::Group)
    };
    for node in nodes {
        if let Some(parent) = node.parent {
            is_leaf[parent.index()] = false;
            if !hangs_on_group(node) {
                corners[parent.index()].extend(pointer(offset(node)));
            }
        }
    }
    let lone = nodes.iter().filter(|node| hangs_on_group(node)).map(offset);
    let lone_radius = LONE_KNOB_RADIUS * diagonal(lone);
    for (index, node) in nodes.iter().enumerate() {
        if is_leaf[index] {
            corners[index].extend(knob(if hangs_on_group(node) {
                lone_radius
            } else {
                offset(node).length() * KNOB_RADIUS
            }));
        }
    }
    let mut pieces: Vec<_> = corners.into_iter().enumerate().collect();
    pieces.retain(|(_, corners)| !corners.is_empty() && corners.iter().all(|corner| corner.is_finite()));
    pieces
}

/// The diagonal of the box around points; 0 without points.
fn diagonal(points: impl Iterator<Item = DVec3>) -> f64 {
    let corners = points
        .map(|point| (point, point))
        .reduce(|(least, most), (point, _)| (least.min(point), most.max(point)));
    corners.map_or(0.0, |(least, most)| least.distance(most))
}

/// The vector from the parent's origin to the node's. Uses double precision, because squares of far offsets overflow
/// single precision.
fn offset(node: &Node) -> DVec3 {
    node.transform.w_axis.truncate().as_dvec3()
}

/// A pyramid with four faces from a square base to `tip`. Its axis runs from the origin to `tip`.
fn pointer(tip: DVec3) -> Vec<Vec3> {
    let length = tip.length();
    if length < SHORTEST_LINK {
        return Vec::new();
    }
    let up = tip / length;
    // Any axis that is not nearly parallel spans the base: X, unless the link runs along X.
    let across = if up.x.abs() > 0.99 { DVec3::Y } else { DVec3::X };
    let front_unit = up.cross(across).normalize();
    let front = front_unit * length * POINTER_WIDTH;
    let side = front_unit.cross(up).normalize() * length * POINTER_WIDTH;
    #[rustfmt::skip]
    let faces = [
        -front, tip, -side,
        -side, tip, front,
        front, tip, side,
        side, tip, -front,
    ];
    faces.map(rounded).to_vec()
}

/// An octahedron around the origin.
fn knob(radius: f64) -> Vec<Vec3> {
    let [x, y, z] = DVec3::AXES.map(|axis| axis * radius);
    #[rustfmt::skip]
    let faces = [
        -x, y, -z,
        y, x, -z,
        x, -y, -z,
        -y, -x, -z,
        -x, z, y,
        y, z, x,
        x, z, -y,
        -y, z, -x,
    ];
    faces.map(rounded).to_vec()
}

/// Rounds to single precision. Adding zero turns -0 into 0, so that equal positions are equal bit by bit.
fn rounded(point: DVec3) -> Vec3 {
    (point + DVec3::ZERO).as_vec3()
}

/// A mesh whose face `i` has the corners from `3 * i` to `3 * i + 2`, each with its own vertex.
fn mesh_of(corners: &[Vec3]) -> Mesh {
    Mesh {
        primitive: Primitive::Triangles,
        vertices: corners.to_vec(),
        normals: corners.chunks_exact(3).flat_map(|face| [normal(face); 3]).collect(),
        indices: (0..corners.len() as u32).collect(),
        ..Mesh::default()
    }
}

/// The unit normal of a face; X if the face has no extent, as in Assimp.
///
/// Uses double precision, because the area of a small face underflows single precision.
fn normal(face: &[Vec3]) -> Vec3 {
    let [a, b, c] = [face[0], face[1], face[2]].map(Vec3::as_dvec3);
    (c - a).cross(b - a).normalize_or(DVec3::X).as_vec3()
}

/// All pieces in one mesh, each bound to its node by a bone.
fn skinned(nodes: &[Node], pieces: &[(usize, Vec<Vec3>)]) -> Mesh {
    let offset_matrices = offset_matrices(nodes);
    let mut whole = Mesh::default();
    for (node, corners) in pieces {
        let piece = mesh_of(corners);
        let node_to_mesh = offset_matrices[*node].inverse();
        let is_placed = |vertex: &Vec3| node_to_mesh.transform_point3(*vertex).is_finite();
        if offset_matrices[*node].determinant() == 0.0 || !corners.iter().all(is_placed) {
            continue;
        }
        let first = whole.vertices.len() as u32;
        let ids = first..first + corners.len() as u32;
        let turned = |normal: Vec3| node_to_mesh.transform_vector3(normal).normalize_or(Vec3::X);
        whole.vertices.extend(
            piece
                .vertices
                .iter()
                .map(|&vertex| node_to_mesh.transform_point3(vertex)),
        );
        whole.normals.extend(piece.normals.iter().map(|&normal| turned(normal)));
        whole.indices.extend(ids.clone());
        whole.bones.push(Bone {
            name: nodes[*node].name.clone(),
            node: NodeId::new(*node),
            offset_matrix: offset_matrices[*node],
            weights: ids.map(|vertex_id| VertexWeight { vertex_id, weight: 1.0 }).collect(),
        });
    }
    whole
}

/// The inverse of an affine matrix. The general inverse also rounds the last row, which is always 0 0 0 1. A minus zero
/// in this row stays, because it equals zero and Assimp prints it.
fn affine_inverse(matrix: Mat4) -> Mat4 {
    let mut inverse = matrix.inverse();
    for (axis, last) in std::iter::zip(0..4, [0.0, 0.0, 0.0, 1.0]) {
        let w = &mut inverse.col_mut(axis).w;
        if *w != last {
            *w = last;
        }
    }
    inverse
}

/// For each node, the matrix from the space of the root's parent to the node's own space, in the rest pose.
///
/// Multiplied from the node outwards, as in Assimp, so that the numbers equal Assimp's to the last digit.
fn offset_matrices(nodes: &[Node]) -> Vec<Mat4> {
    let parent_to_node: Vec<Mat4> = nodes.iter().map(|node| affine_inverse(node.transform)).collect();
    let offset_matrix = |index: usize| {
        let mut matrix = parent_to_node[index];
        let mut ancestor = nodes[index].parent;
        while let Some(id) = ancestor {
            matrix *= parent_to_node[id.index()];
            ancestor = nodes[id.index()].parent;
        }
        matrix
    };
    (0..nodes.len()).map(offset_matrix).collect()
}
