//! Writes the skins of a document, and the meshes that are bound to them.

use glam::{Affine3A, Mat4};
use gltf_json::accessor::Accessor;
use gltf_json::mesh::Primitive;
use gltf_json::{Index, Node, Skin};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::pose::{Pose, complete_bind_pose};
use mocap_scene::scene::{self, NodeId, NodeKind};

use super::super::{Compression, mesh};
use super::Builder;

impl Builder<'_> {
    /// Writes the skin, and a mesh node at the scene's root for every mesh with bones. A scene with only rigid meshes
    /// has no skin: optimisers drop an unused skin, and validators report it. If no mesh has an area, such as the mesh
    /// of a skeleton with a single joint, a marker is written instead of the meshes.
    pub(super) fn skins(&mut self, skinned: &[usize]) -> Result<()> {
        let scene = self.scene;
        let mut joints = Vec::new();
        let mut slots = vec![None; scene.nodes.len()];
        for (index, node) in scene.nodes.iter().enumerate() {
            if node.kind != NodeKind::Group {
                let slot = u16::try_from(joints.len()).map_err(|_| {
                    Diagnostic::new(Code::LimitExceeded, "a skin has at most 65,536 joints")
                        .help("write a segmented mesh, which has no skin")
                });
                slots[index] = Some(slot?);
                joints.push(index);
            }
        }
        if joints.is_empty() || (skinned.is_empty() && !self.root.meshes.is_empty()) {
            return Ok(());
        }
        for &index in skinned {
            let mesh = &scene.meshes[index];
            if let Some(written) = mesh::write(mesh, Some(&slots), joints.len(), &mut self.buffer)? {
                let skin = self.skin(&joints, &mesh.bones);
                self.skinned_mesh(&mesh.name, written, skin, Some(index));
            }
        }
        if self.root.skins.is_empty() && scene.meshes.is_empty() && self.options.compression != Compression::None {
            // No mesh is bound to the joints, so the inverse bind matrices (64 bytes per joint) are omitted.
            self.skin_with(&joints, None);
        } else if self.root.skins.is_empty() {
            let skin = self.skin(&joints, &[]);
            if let Some(mesh) = scene.meshes.first() {
                let first_joint = Pose::rest(scene).position(NodeId::new(joints[0]));
                let marker = mesh::marker(first_joint, mesh.material_index);
                if let Some(written) = mesh::write(&marker, Some(&slots), joints.len(), &mut self.buffer)? {
                    self.skinned_mesh("", written, skin, None);
                }
            }
        }
        Ok(())
    }

    /// Adds a node at the scene's root with a primitive and a skin, for a mesh of the scene or a marker.
    fn skinned_mesh(
        &mut self,
        name: &str,
        (primitive, vertices): (Primitive, usize),
        skin: Index<Skin>,
        source: Option<usize>,
    ) {
        self.report.vertices += vertices;
        let name = self.names.unique(if name.is_empty() { "SkeletonMesh" } else { name });
        let mesh = self.mesh(vec![primitive], Some(&name), source);
        let node = Node {
            mesh,
            skin: Some(skin),
            name: Some(name),
            ..Node::default()
        };
        let node = self.root.push(node);
        self.root.scenes[0].nodes.push(node);
        self.morphed.extend(source.map(|mesh| (node.value(), mesh)));
    }

    /// Adds a skin of all joints. A mesh with the same bind matrices as the previous mesh shares the skin of that mesh.
    /// A joint with a bone has the bone's bind pose. Another joint follows its nearest ancestor with a bone, or keeps
    /// its rest pose.
    fn skin(&mut self, joints: &[usize], bones: &[scene::Bone]) -> Index<Skin> {
        let node_to_world = Pose::rest(self.scene).node_to_world;
        // As affine maps, because the last row of an inverse bind matrix must be exactly 0 0 0 1. With a scale of 0 all
        // positions coincide, so any matrix works.
        let inverse = |matrix: &Mat4| match Mat4::from(Affine3A::from_mat4(*matrix).inverse()) {
            inverse if inverse.is_finite() => inverse,
            _ => Mat4::from_translation(-matrix.w_axis.truncate()),
        };
        let mut inverse_bind: Vec<_> = node_to_world.iter().map(inverse).collect();
        let rest: Vec<_> = node_to_world.iter().map(Mat4::as_dmat4).collect();
        let mut bind = vec![None; rest.len()];
        for bone in bones {
            bind[bone.node.index()] = Some(bone.offset_matrix.as_dmat4().inverse());
        }
        complete_bind_pose(&self.scene.nodes, &rest, &mut bind);
        for (inverse_bind, bind) in std::iter::zip(&mut inverse_bind, bind) {
            *inverse_bind = bind.map_or(*inverse_bind, |bind| inverse(&bind.as_mat4()));
        }
        for bone in bones {
            inverse_bind[bone.node.index()] = bone.offset_matrix;
        }
        // Adding zero turns -0 into 0.
        let matrices: Vec<_> = joints
            .iter()
            .map(|&joint| inverse_bind[joint].to_cols_array().map(|value| value + 0.0))
            .collect();
        if let Some((_, skin)) = self.last_skin.as_ref().filter(|(last, _)| *last == matrices) {
            return *skin;
        }
        let accessor = self.buffer.push_matrices(self.options.compression, &matrices);
        let skin = self.skin_with(joints, Some(accessor));
        self.last_skin = Some((matrices, skin));
        skin
    }

    fn skin_with(&mut self, joints: &[usize], inverse_bind_matrices: Option<Index<Accessor>>) -> Index<Skin> {
        self.report.joints = joints.len();
        self.root.push(Skin {
            inverse_bind_matrices,
            joints: joints.iter().map(|&joint| Index::new(joint as u32)).collect(),
            skeleton: Some(Index::new(0)),
            name: None,
            extensions: None,
            extras: None,
        })
    }
}
