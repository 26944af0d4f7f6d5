//! Changes the rest pose.

use std::collections::{HashMap, HashSet};

use glam::{Affine3A, Mat3, Mat4, Vec3};

use crate::pose::{Binding, Pose, Trs};
use crate::scene::{Channel, Keys, Mesh, NodeId, Scene};

impl Scene {
    /// Makes the pose at `tick` of the first animation the rest pose and the bind pose. Does nothing without an
    /// animation.
    ///
    /// The rest pose of a BVH file has zero rotations, which may not be a natural pose. Use this step if the target
    /// needs a T-pose, and the motion has one. The motion does not change.
    #[doc(hidden)]
    pub fn set_rest_pose_at(&mut self, tick: f64) {
        if let Some(pose) = Pose::at_tick(self, 0, tick) {
            set_rest_pose(self, &pose);
        }
    }
}

/// Makes a pose the rest pose and the bind pose. The motion does not change: a constant track keeps nodes without
/// animation in their place.
#[doc(hidden)]
pub fn set_rest_pose(scene: &mut Scene, pose: &Pose) {
    let changed: Vec<NodeId> = (0..scene.nodes.len())
        .filter(|node| !is_same(&scene.nodes[*node].transform, &pose.node_to_parent[*node]))
        .map(NodeId::new)
        .collect();
    for animation in 0..scene.animations.len() {
        let driven: HashSet<NodeId> = Binding::new(scene, &scene.animations[animation])
            .driven()
            .map(|(node, _)| node)
            .collect();
        for node in changed.iter().filter(|node| !driven.contains(node)) {
            let channel = still(scene, *node);
            scene.animations[animation].channels.push(channel);
        }
        scene.animations[animation].sort_channels();
    }
    for node in changed {
        scene.nodes[node.index()].transform = pose.node_to_parent[node.index()];
    }
    for mesh in &mut scene.meshes {
        rebind(mesh, pose);
    }
}

/// Inserts a pose before the first frame of an animation.
#[doc(hidden)]
pub fn put_first(scene: &mut Scene, animation: usize, pose: &Pose) {
    let Some(clip) = scene.animations.get(animation) else {
        return;
    };
    let driven: HashMap<NodeId, usize> = Binding::new(scene, clip).driven().collect();
    let positions = pose
        .node_to_world
        .iter()
        .map(|to_world| to_world.w_axis.truncate().length());
    let farthest = positions.fold(0.0, f32::max);
    for (index, node_to_parent) in pose.node_to_parent.iter().enumerate() {
        let node = NodeId::new(index);
        let first = Trs::from_matrix(*node_to_parent);
        let mut added = None;
        let channel = match driven.get(&node) {
            Some(channel) => &mut scene.animations[animation].channels[*channel],
            None if is_same(&scene.nodes[index].transform, node_to_parent) => continue,
            None => added.insert(still(scene, node)),
        };
        let parent = scene.nodes[index]
            .parent
            .map(|parent| pose.node_to_world[parent.index()]);
        let scale = parent.map_or(1.0, |parent| parent.determinant().abs().cbrt());
        let rounding = if scale > 0.0 { ROUNDINGS * farthest / scale } else { 0.0 };
        prepend(&mut channel.position_keys, first.translation, |a, b| {
            a.distance(b) <= f32::max(SAME * a.length(), rounding)
        });
        prepend(&mut channel.scaling_keys, first.scale, |a, b| {
            a.distance(b) <= SAME * a.length()
        });
        let after = channel.rotation_keys.values.first().copied().unwrap_or(first.rotation);
        // Choose the shorter arc to the next frame.
        let rotation = if after.dot(first.rotation) < 0.0 {
            -first.rotation
        } else {
            first.rotation
        };
        prepend(&mut channel.rotation_keys, rotation, |a, b| (a - b).length() <= SAME);
        scene.animations[animation].channels.extend(added);
    }
    let weights: Vec<f32> = scene.weights_in(animation).map(|(at_rest, _)| at_rest).collect();
    for (animations, at_rest) in std::iter::zip(scene.weight_keys(), weights) {
        if let Some(keys) = animations.get_mut(animation) {
            prepend(keys, at_rest, |a, b| a == b);
        }
    }
    let clip = &mut scene.animations[animation];
    clip.sort_channels();
    clip.duration += 1.0;
}

/// The largest difference of two values, as a fraction, that counts as rounding.
const SAME: f32 = 1e-6;

/// The distance by which rounding moves a joint, in a pose that was computed in world space. It is a fraction of the
/// distance of the farthest joint from the origin. Each joint of a chain adds a few roundings.
const ROUNDINGS: f32 = 64.0 * f32::EPSILON;

fn is_same(one: &Mat4, other: &Mat4) -> bool {
    let size = one.w_axis.truncate().length().max(1.0);
    one.abs_diff_eq(*other, SAME * size)
}

/// A channel that keeps a node in its rest pose.
fn still(scene: &Scene, node: NodeId) -> Channel {
    let rest = Trs::from_matrix(scene.nodes[node.index()].transform);
    Channel {
        node_name: scene.nodes[node.index()].name.clone(),
        node: Some(node),
        position_keys: Keys::constant(rest.translation),
        rotation_keys: Keys::constant(rest.rotation),
        scaling_keys: Keys::constant(rest.scale),
    }
}

/// Inserts a value at tick 0, and moves all others by a tick.
fn prepend<T: Copy>(keys: &mut Keys<T>, first: T, is_same: impl Fn(T, T) -> bool) {
    match (&mut keys.ticks, keys.values.as_slice()) {
        (_, []) => {}
        (_, [value]) if is_same(*value, first) => {}
        (_, &[value]) => *keys = Keys::at_ticks(vec![first, value], vec![0.0, 1.0]),
        (None, _) => keys.values.insert(0, first),
        (Some(ticks), values) => {
            let mut later = vec![0.0];
            let mut all = vec![first];
            // Before the first key, a track has the value of this key. So the old first frame gets a key too.
            if ticks[0] > 0.0 {
                later.push(1.0);
                all.push(values[0]);
            }
            later.extend(ticks.iter().map(|tick| tick + 1.0));
            all.extend(values);
            *keys = Keys::at_ticks(all, later);
        }
    }
}

/// Moves the vertices to their positions in `pose`, and makes this pose their bind pose.
fn rebind(mesh: &mut Mesh, pose: &Pose) {
    if mesh.bones.is_empty() {
        return;
    }
    let mut vertices = vec![Vec3::ZERO; mesh.vertices.len()];
    let mut normals = vec![Vec3::ZERO; mesh.normals.len()];
    let mut turns = vec![
        Mat3::ZERO;
        if mesh.morph_targets.is_empty() {
            0
        } else {
            mesh.vertices.len()
        }
    ];
    for bone in &mut mesh.bones {
        let node_to_world = pose.node_to_world[bone.node.index()];
        let moved: Mat4 = node_to_world * bone.offset_matrix;
        for tie in &bone.weights {
            let vertex = tie.vertex_id as usize;
            vertices[vertex] += tie.weight * moved.transform_point3(mesh.vertices[vertex]);
            if let (Some(sum), Some(normal)) = (normals.get_mut(vertex), mesh.normals.get(vertex)) {
                *sum += tie.weight * moved.transform_vector3(*normal);
            }
            if let Some(sum) = turns.get_mut(vertex) {
                *sum += tie.weight * Mat3::from_mat4(moved);
            }
        }
        // Inverted as an affine map, so that the last row stays exactly 0 0 0 1.
        bone.offset_matrix = Mat4::from(Affine3A::from_mat4(node_to_world).inverse());
    }
    mesh.map_morph_targets(|vertex, offset| turns[vertex] * offset);
    mesh.vertices = vertices;
    mesh.normals = normals.into_iter().map(|normal| normal.normalize_or(Vec3::X)).collect();
}
