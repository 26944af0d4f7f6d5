//! Removes shear from rest transforms, for formats whose nodes have only translation, rotation and scale.

use glam::{DMat4, Mat4};

use crate::pose::{Pose, Trs};
use crate::scene::Scene;

/// The cosine of the angle between two axes above which a transform has shear. The angle is then 0.006 degrees from a
/// right angle. Matrices that are printed with few digits have less shear.
const LEAST: f64 = 1e-4;

/// A scene without shear, and a description of the removed shear.
#[doc(hidden)]
pub struct ShearOutcome {
    #[doc(hidden)]
    pub scene: Scene,
    /// The number of nodes with shear.
    #[doc(hidden)]
    pub nodes: usize,
    /// The node with the largest deviation from right angles, and the deviation in degrees.
    #[doc(hidden)]
    pub most: String,
    #[doc(hidden)]
    pub degrees: f64,
}

/// A copy of the scene without shear. Each node with shear at rest gets the translation, rotation and scale of
/// [`Trs::from_matrix`]. The mesh vertices do not move in the rest pose. `None` if no node has shear.
#[doc(hidden)]
pub fn take_shear_out(scene: &Scene) -> Option<ShearOutcome> {
    let angles: Vec<f64> = scene
        .nodes
        .iter()
        .map(|node| off_right_angles(&node.transform))
        .collect();
    let (most, degrees) = (angles.iter().copied().enumerate()).max_by(|a, b| a.1.total_cmp(&b.1))?;
    let shears = |angle: f64| angle.to_radians().sin() > LEAST;
    if !shears(degrees) {
        return None;
    }
    let before = Pose::rest(scene).node_to_world;
    let mut scene = scene.clone();
    for (node, angle) in scene.nodes.iter_mut().zip(&angles) {
        if shears(*angle) {
            node.transform = Trs::from_matrix(node.transform).matrix();
        }
    }
    let after = Pose::rest(&scene).node_to_world;
    for bone in scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.bones) {
        let (Some(before), Some(after)) = (before.get(bone.node.index()), after.get(bone.node.index())) else {
            continue;
        };
        let moved = after.as_dmat4().inverse() * before.as_dmat4();
        if before != after && moved.is_finite() {
            bone.offset_matrix = (moved * bone.offset_matrix.as_dmat4()).as_mat4();
        }
    }
    Some(ShearOutcome {
        nodes: angles.iter().filter(|angle| shears(**angle)).count(),
        most: scene.nodes[most].name.clone(),
        degrees,
        scene,
    })
}

/// The largest deviation of two axes from right angles, in degrees. Axes without length have no angle.
fn off_right_angles(transform: &Mat4) -> f64 {
    let DMat4 {
        x_axis, y_axis, z_axis, ..
    } = transform.as_dmat4();
    let [x, y, z] = [x_axis, y_axis, z_axis].map(|axis| axis.truncate().normalize_or_zero());
    let cosine = [x.dot(y), y.dot(z), z.dot(x)]
        .into_iter()
        .map(f64::abs)
        .fold(0.0, f64::max);
    cosine.min(1.0).asin().to_degrees()
}
