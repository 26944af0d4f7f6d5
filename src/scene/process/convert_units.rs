//! Converts a scene to another unit of length and another up axis, by default to metres with +Y up.

use glam::{Mat4, Quat, Vec3};

use crate::math::up_axis::{self, turn_to_y_up};
use crate::pose::Binding;
use crate::scene::report::AppliedStep;
use crate::scene::{Face, Mesh, Node, NodeId, Scene, UpAxis};

impl Scene {
    /// Scales all lengths by `metres_per_unit`, and rotates the scene so that `up` becomes +Y.
    ///
    /// Only the root is rotated, both its rest transform and its keys. Every joint keeps its own axes, and the
    /// rotations of other joints do not change. +Z up becomes +Y up by a rotation of 90 degrees about X: (x, y, z)
    /// becomes (x, z, -y).
    ///
    /// The metadata of the scene then state metres and +Y up. `Conversion` infers `metres_per_unit` and `up`, and calls
    /// this method.
    ///
    /// ```
    /// use mocap::glam::{Mat4, Vec3};
    /// use mocap::scene::{Node, Scene, UpAxis};
    ///
    /// let hips = Node { transform: Mat4::from_translation(Vec3::new(0.0, 0.0, 98.0)), ..Node::default() };
    /// let mut scene = Scene { nodes: vec![hips], ..Scene::default() };
    /// scene.convert_units(0.01, UpAxis::Z);
    /// assert_eq!(scene.nodes[0].transform.w_axis.truncate(), Vec3::new(0.0, 0.98, 0.0));
    /// ```
    pub fn convert_units(&mut self, metres_per_unit: f64, up: UpAxis) {
        convert_units_to(self, (metres_per_unit, up), (1.0, UpAxis::Y));
    }
}

/// Converts as [`convert_units`] does, from any unit and up axis to any other. `from` and `to` are the metres per unit
/// of length and the up axis.
#[doc(hidden)]
pub fn convert_units_to(scene: &mut Scene, from: (f64, UpAxis), to: (f64, UpAxis)) {
    let ((metres_per_unit, up), (out_metres_per_unit, out_up)) = (from, to);
    let factor = metres_per_unit / out_metres_per_unit;
    let scaled = |v: Vec3| (v.as_dvec3() * factor).as_vec3();
    let axes = Axes { from: up, to: out_up };
    // A morph weight has no unit.
    let is_weight = |node: &Node| matches!(node.face, Some(Face::Preset(_) | Face::Custom(_)));
    let weights: Vec<bool> = scene.nodes.iter().map(is_weight).collect();
    for node in &mut scene.nodes {
        if is_weight(node) {
            continue;
        }
        node.transform.w_axis = scaled(node.transform.w_axis.truncate()).extend(1.0);
        if node.parent.is_none() {
            node.transform = axes.matrix() * node.transform;
        }
    }
    for index in 0..scene.animations.len() {
        let (root_channel, of_weights) = (root_channel(scene, index), channels_of(scene, index, &weights));
        for (channel_index, channel) in scene.animations[index].channels.iter_mut().enumerate() {
            if of_weights.contains(&channel_index) {
                continue;
            }
            let of_channel = if Some(channel_index) == root_channel {
                axes
            } else {
                Axes::default()
            };
            for value in &mut channel.position_keys.values {
                *value = of_channel.point(scaled(*value));
            }
            if of_channel.from != of_channel.to {
                for value in &mut channel.rotation_keys.values {
                    *value = of_channel.rotation(*value);
                }
            }
        }
    }
    for mesh in &mut scene.meshes {
        convert_mesh(mesh, scaled, axes);
    }
    scene.metadata.metres_per_unit = Some(out_metres_per_unit);
    scene.metadata.up = Some(out_up);
    scene.metadata.steps.push(AppliedStep::ConvertUnits {
        metres_per_unit,
        up,
        out_metres_per_unit,
        out_up,
    });
}

/// The up axes before and after the conversion.
#[derive(Clone, Copy, Default)]
struct Axes {
    from: UpAxis,
    to: UpAxis,
}

impl Axes {
    fn matrix(self) -> Mat4 {
        up_axis::from_to(self.from, self.to)
    }

    fn point(self, point: Vec3) -> Vec3 {
        up_axis::turned(point, self.from, self.to)
    }

    /// Double precision, rounded once at the end.
    fn rotation(self, rotation: Quat) -> Quat {
        if self.from == self.to {
            return rotation;
        }
        let change = turn_to_y_up(self.to).inverse() * turn_to_y_up(self.from);
        (change * rotation.as_dquat()).as_quat()
    }
}

/// The channel that drives the first node.
fn root_channel(scene: &Scene, animation: usize) -> Option<usize> {
    let binding = Binding::new(scene, &scene.animations[animation]);
    let driven = binding.driven().find(|(node, _)| *node == NodeId(0));
    driven.map(|(_, channel)| channel)
}

/// The channels that drive nodes for which `is_driven` is true.
fn channels_of(scene: &Scene, animation: usize, is_driven: &[bool]) -> Vec<usize> {
    if !is_driven.contains(&true) {
        return Vec::new();
    }
    let binding = Binding::new(scene, &scene.animations[animation]);
    let driven = binding.driven().filter(|(node, _)| is_driven[node.index()]);
    driven.map(|(_, channel)| channel).collect()
}

/// A mesh with bones is in the space of the root's parent, so it is rotated. Any other mesh is in the space of its
/// node.
fn convert_mesh(mesh: &mut Mesh, scaled: impl Fn(Vec3) -> Vec3, axes: Axes) {
    let axes = if mesh.bones.is_empty() { Axes::default() } else { axes };
    for vertex in &mut mesh.vertices {
        *vertex = axes.point(scaled(*vertex));
    }
    for normal in &mut mesh.normals {
        *normal = axes.point(*normal);
    }
    for target in &mut mesh.morph_targets {
        for offset in &mut target.offsets {
            *offset = axes.point(scaled(*offset));
        }
        for offset in &mut target.normal_offsets {
            *offset = axes.point(*offset);
        }
    }
    for bone in &mut mesh.bones {
        let translation = scaled(bone.offset_matrix.w_axis.truncate());
        bone.offset_matrix *= up_axis::from_to(axes.to, axes.from);
        bone.offset_matrix.w_axis = translation.extend(1.0);
    }
}
