//! Replaces bones that move whole faces by rigid meshes on nodes.

use glam::{Mat3, Mat4};

use super::split::{renumbered_bones, replace_mesh_indices, submesh};
use crate::scene::{Mesh, Scene};

impl Scene {
    /// Splits off the faces of skinned meshes that follow only one bone, and moves them to the bone's node.
    ///
    /// Before: mesh 0 on the root, with the bones `Shoulder`, `Elbow` and `Wrist`. After: mesh 0 on `Shoulder`, mesh 1
    /// on `Elbow`, mesh 2 on `Wrist`, each in its node's space, without bones. With the nodes' matrices, the drawings
    /// are equal in every pose.
    ///
    /// A bone is *needed* in two cases: it moves a vertex together with another bone, or a face has vertices of this
    /// bone and other vertices. The faces of needed bones and faces without bones stay in one mesh with those bones.
    /// This mesh stays on its old nodes, before the other meshes.
    ///
    /// Assimp does not transform the faces of a bone whose offset matrix is within 0.01 of the identity. So it draws
    /// links near the origin of a skeleton in metres at a wrong position. Here all faces are transformed.
    pub fn debone(&mut self) {
        let mut replacements = vec![Vec::new(); self.meshes.len()];
        let mut rigid_parts = Vec::new();
        let mut meshes = Vec::new();
        for (index, mesh) in self.meshes.drain(..).enumerate() {
            let FacesByBone { kept, split_off } = faces_by_bone(&mesh);
            if split_off.iter().all(Vec::is_empty) {
                replacements[index].push(meshes.len());
                meshes.push(mesh);
                continue;
            }
            if !kept.is_empty() {
                let (mut rest, new_ids) = submesh(&mesh, &kept);
                rest.bones = renumbered_bones(&mesh.bones, &new_ids);
                replacements[index].push(meshes.len());
                meshes.push(rest);
            }
            for (bone, faces) in mesh.bones.iter().zip(&split_off) {
                if !faces.is_empty() {
                    let (part, _) = submesh(&mesh, faces);
                    rigid_parts.push((bone.node, meshes.len()));
                    meshes.push(in_bone_space(part, bone.offset_matrix));
                }
            }
        }
        self.meshes = meshes;
        replace_mesh_indices(&mut self.nodes, &replacements);
        for (node, mesh) in rigid_parts {
            self.nodes[node.index()].meshes.push(mesh);
        }
    }
}

/// The faces of a mesh, as face indices.
struct FacesByBone {
    /// Faces with vertices of needed bones or of no bone.
    kept: Vec<usize>,
    /// For each bone, the faces that move to its node.
    split_off: Vec<Vec<usize>>,
}

/// The bones of a vertex.
#[derive(Clone, Copy, PartialEq)]
enum Tie {
    Loose,
    To(usize),
    Shared,
}

fn faces_by_bone(mesh: &Mesh) -> FacesByBone {
    let (ties, mut needed) = ties(mesh);
    for face in mesh.faces() {
        let first = ties[face[0] as usize];
        if face.iter().any(|&vertex| ties[vertex as usize] != first) {
            for &vertex in face {
                if let Tie::To(bone) = ties[vertex as usize] {
                    needed[bone] = true;
                }
            }
        }
    }
    let mut faces = FacesByBone {
        kept: Vec::new(),
        split_off: vec![Vec::new(); mesh.bones.len()],
    };
    for (index, face) in mesh.faces().enumerate() {
        match ties[face[0] as usize] {
            Tie::To(bone) if !needed[bone] => faces.split_off[bone].push(index),
            _ => faces.kept.push(index),
        }
    }
    faces
}

/// The bones of each vertex, and for each bone whether another bone moves one of its vertices.
fn ties(mesh: &Mesh) -> (Vec<Tie>, Vec<bool>) {
    let mut ties = vec![Tie::Loose; mesh.vertices.len()];
    let mut needed = vec![false; mesh.bones.len()];
    for (index, bone) in mesh.bones.iter().enumerate() {
        for weight in bone.weights.iter().filter(|weight| weight.weight != 0.0) {
            let tie = &mut ties[weight.vertex_id as usize];
            match *tie {
                Tie::Loose => *tie = Tie::To(index),
                Tie::To(other) if other == index => {}
                Tie::To(other) => {
                    needed[other] = true;
                    needed[index] = true;
                    *tie = Tie::Shared;
                }
                Tie::Shared => needed[index] = true,
            }
        }
    }
    (ties, needed)
}

/// The mesh in the space of the bone's node.
fn in_bone_space(mut mesh: Mesh, offset_matrix: Mat4) -> Mesh {
    for vertex in &mut mesh.vertices {
        *vertex = offset_matrix.transform_point3(*vertex);
    }
    let normals_to_bone = Mat3::from_mat4(offset_matrix).inverse().transpose();
    for normal in &mut mesh.normals {
        *normal = (normals_to_bone * *normal).normalize_or(*normal);
    }
    mesh.map_morph_targets(|_, offset| offset_matrix.transform_vector3(offset));
    mesh
}
