//! Changes the rest pose.

use glam::{Affine3A, Mat4, Vec3};

use crate::pose::Pose;
use crate::scene::{Mesh, Scene};

/// Makes the pose at `tick` of the first animation the rest pose and the bind pose. Does nothing without an animation.
///
/// The rest pose of a BVH file has zero rotations, which may not be a natural pose. Use this step where a target needs
/// a T-pose, and the motion has one. The motion does not change.
pub fn rest_pose(scene: &mut Scene, tick: f64) {
    let Some(pose) = Pose::at_tick(scene, 0, tick) else {
        return;
    };
    for (node, node_to_parent) in scene.nodes.iter_mut().zip(&pose.node_to_parent) {
        node.transform = *node_to_parent;
    }
    for mesh in &mut scene.meshes {
        rebind(mesh, &pose);
    }
}

/// Moves the vertices to their positions in `pose`, and binds them there.
fn rebind(mesh: &mut Mesh, pose: &Pose) {
    if mesh.bones.is_empty() {
        return;
    }
    let mut vertices = vec![Vec3::ZERO; mesh.vertices.len()];
    let mut normals = vec![Vec3::ZERO; mesh.normals.len()];
    for bone in &mut mesh.bones {
        let node_to_world = pose.node_to_world[bone.node.index()];
        let moved: Mat4 = node_to_world * bone.offset_matrix;
        for tie in &bone.weights {
            let vertex = tie.vertex_id as usize;
            vertices[vertex] += tie.weight * moved.transform_point3(mesh.vertices[vertex]);
            if let (Some(sum), Some(normal)) = (normals.get_mut(vertex), mesh.normals.get(vertex)) {
                *sum += tie.weight * moved.transform_vector3(*normal);
            }
        }
        // As an affine map, so that the last row stays 0 0 0 1 to the last digit.
        bone.offset_matrix = Mat4::from(Affine3A::from_mat4(node_to_world).inverse());
    }
    mesh.vertices = vertices;
    mesh.normals = normals.into_iter().map(|normal| normal.normalize_or(Vec3::X)).collect();
}
