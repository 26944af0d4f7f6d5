//! Rotates the axes of joints in the rest pose.

use glam::{Mat4, Quat, Vec3};

use crate::error::{Code, Diagnostic, Result};
use crate::pose::{Binding, Trs};
use crate::scene::report::AppliedStep;
use crate::scene::{Animation, Keys, Mesh, Scene};

/// The largest relative difference between the scales of a node's axes that counts as rounding.
const UNIFORM: f32 = 1e-4;

/// Aligns the axes of every node with the world axes in the rest pose, so that all rotations of the rest pose are zero.
/// No position changes, neither at rest nor in motion.
///
/// # Errors
/// The errors of [`set_rest_rotations`].
#[doc(hidden)]
pub fn zero_rest_rotations(scene: &mut Scene) -> Result<()> {
    set_rest_rotations(scene, &vec![Quat::IDENTITY; scene.nodes.len()])?;
    scene.metadata.steps.push(AppliedStep::ZeroRestRotations);
    Ok(())
}

/// Sets the axes of every node in the rest pose to the world rotation in `wanted`. No position changes, neither at rest
/// nor in motion.
///
/// # Errors
/// A node has different scales along its axes. Relative to rotated axes, these factors would not be scales. After an
/// error, `scene` is unchanged.
#[doc(hidden)]
pub fn set_rest_rotations(scene: &mut Scene, wanted: &[Quat]) -> Result<()> {
    can_zero_rest_rotations(scene)?;
    let rest: Vec<Trs> = scene
        .nodes
        .iter()
        .map(|node| Trs::from_matrix(node.transform))
        .collect();
    // The rotation from the old axes of each node to the new ones.
    let mut worlds: Vec<Quat> = Vec::with_capacity(rest.len());
    let mut turned: Vec<Quat> = Vec::with_capacity(rest.len());
    for ((node, rest), wanted) in scene.nodes.iter().zip(&rest).zip(wanted) {
        let above = node.parent.map_or(Quat::IDENTITY, |parent| worlds[parent.index()]);
        let world = (above * rest.rotation).normalize();
        worlds.push(world);
        turned.push((wanted.inverse() * world).normalize());
    }
    let above: Vec<Quat> = scene
        .nodes
        .iter()
        .map(|node| node.parent.map_or(Quat::IDENTITY, |parent| turned[parent.index()]))
        .collect();
    for animation in 0..scene.animations.len() {
        let driven: Vec<_> = Binding::new(scene, &scene.animations[animation]).driven().collect();
        let Animation { channels, .. } = &mut scene.animations[animation];
        for (node, channel) in driven {
            let (above, turned) = (above[node.index()], turned[node.index()]);
            let channel = &mut channels[channel];
            each(&mut channel.position_keys, |position| above * position);
            each(&mut channel.rotation_keys, |rotation| {
                (above * rotation * turned.inverse()).normalize()
            });
        }
    }
    for (index, (node, rest)) in std::iter::zip(&mut scene.nodes, &rest).enumerate() {
        let parent = node.parent.map_or(Quat::IDENTITY, |parent| wanted[parent.index()]);
        let rotation = (parent.inverse() * wanted[index]).normalize();
        let translation = above[index] * rest.translation;
        node.transform = Mat4::from_scale_rotation_translation(rest.scale, rotation, translation);
    }
    for (node, turned) in turned.iter().enumerate() {
        rotate_meshes(scene, node, *turned);
    }
    for bone in scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.bones) {
        bone.offset_matrix = Mat4::from_quat(turned[bone.node.index()]) * bone.offset_matrix;
    }
    Ok(())
}

/// Checks that every node has one scale along all axes.
///
/// # Errors
/// The errors of [`zero_rest_rotations`].
#[doc(hidden)]
pub fn can_zero_rest_rotations(scene: &Scene) -> Result<()> {
    let is_uniform = |scale: &Vec3| scale.max_element() - scale.min_element() <= UNIFORM * scale.abs().max_element();
    let of_nodes = scene
        .nodes
        .iter()
        .map(|node| (&node.name, is_uniform(&Trs::from_matrix(node.transform).scale)));
    let channels = scene.animations.iter().flat_map(|animation| &animation.channels);
    let of_channels = channels.map(|channel| {
        let scales = &channel.scaling_keys.values;
        (&channel.node_name, scales.iter().all(is_uniform))
    });
    match of_nodes.chain(of_channels).find(|(_, is_uniform)| !is_uniform) {
        None => Ok(()),
        Some((joint, _)) => {
            let message = "the joint has different scales along its axes, so its rest rotation cannot change";
            Err(Diagnostic::new(Code::Unrepresentable, message)
                .in_joint(joint)
                .help("keep the rest pose of the file: {rest} zero")
                .into())
        }
    }
}

fn each<T: Copy>(keys: &mut Keys<T>, change: impl Fn(T) -> T) {
    for value in &mut keys.values {
        *value = change(*value);
    }
}

/// Rotates the rigid meshes of a node. If several nodes hold a mesh, each gets its own copy.
fn rotate_meshes(scene: &mut Scene, node: usize, rotation: Quat) {
    for at in 0..scene.nodes[node].meshes.len() {
        let index = scene.nodes[node].meshes[at];
        if !scene.meshes[index].bones.is_empty() {
            continue;
        }
        let mut mesh: Mesh = scene.meshes[index].clone();
        mesh.vertices.iter_mut().for_each(|vertex| *vertex = rotation * *vertex);
        mesh.normals.iter_mut().for_each(|normal| *normal = rotation * *normal);
        mesh.map_morph_targets(|_, offset| rotation * offset);
        let holders = scene.nodes.iter().flat_map(|node| &node.meshes);
        if holders.filter(|held| **held == index).count() > 1 {
            scene.nodes[node].meshes[at] = scene.meshes.len();
            scene.meshes.push(mesh);
        } else {
            scene.meshes[index] = mesh;
        }
    }
}
