//! Measures the skin of the target in a motion.
//!
//! This module does not use the bones, so it also detects an error in the map of the bones.

use glam::{Mat4, Vec3, Vec4};
use mocap_figure::body::Body;
use mocap_figure::ground;
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{Animation, Mesh, NodeId, Scene};

use super::Moving;
use super::hands_inside::Hand;
use crate::root::Root;
use crate::skin_report::SkinReport;

/// The largest number of frames in which the skin is examined.
const LOOKS: usize = 120;

/// The length of a stretched edge, as a multiple of its length at rest.
const STRETCHED: f32 = 2.0;

/// The smallest length of an edge that counts, as a fraction of the height. Shorter edges are not visible.
const SHORTEST: f32 = 1e-3;

/// The ratio of a joint's largest to smallest scale above which the scale is uneven.
const UNEVEN: f32 = 1.01;

/// An edge of a mesh, with its length at rest.
struct Edge {
    ends: [usize; 2],
    at_rest: f32,
}

/// A skin with its edges.
struct Skin<'a> {
    mesh: &'a Mesh,
    edges: Vec<Edge>,
}

/// A motion whose skin is examined.
pub(crate) struct SkinnedMotion<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) animation: &'a Animation,
    pub(crate) up: Vec3,
    pub(crate) metres_per_unit: f64,
    /// The height of the floor at rest. `None` if the lowest vertex at rest is on the floor.
    pub(crate) floor_at_rest: Option<f32>,
    /// The height of the floor in the motion.
    pub(crate) floor: f32,
    /// The joints of the body.
    pub(crate) joints: Vec<NodeId>,
    /// A person, whose hands are examined.
    pub(crate) person: Option<&'a Body>,
}

/// The skin of a person; `None` if the target has no skin.
pub(super) fn of(source: &Moving<'_>, target: &Moving<'_>, ticks: &[f64], root: &Root) -> Option<SkinReport> {
    let floor_of_source = root.source_ankle - ground::ankle(source.body);
    let binding = Binding::new(source.scene, source.animation);
    let mut was = Pose::rest(source.scene);
    let mut depth_of_source = |tick: f64| {
        was.sample(&binding, source.animation, tick);
        (floor_of_source - source.lowest_joint(&was)).max(0.0) * root.height_scale
    };
    let motion = SkinnedMotion {
        scene: target.scene,
        animation: target.animation,
        up: target.body.up(),
        metres_per_unit: target.body.metres_per_unit,
        floor_at_rest: Some(ground::floor(target.body)),
        floor: root.target_ankle - ground::ankle(target.body),
        joints: target.body.bones.values().copied().collect(),
        person: Some(target.body),
    };
    examine(&motion, ticks, &mut depth_of_source)
}

/// Examines the skin at these ticks. `depth_of_source` is the depth of the source below its own floor, in units of the
/// target. `None` without a skin.
pub(crate) fn examine(
    target: &SkinnedMotion<'_>,
    ticks: &[f64],
    depth_of_source: &mut dyn FnMut(f64) -> f32,
) -> Option<SkinReport> {
    let up = target.up;
    let rest = Pose::rest(target.scene);
    let (mut skins, mut extent) = (Vec::new(), None);
    for mesh in target.scene.own_meshes().filter(|mesh| !mesh.bones.is_empty()) {
        let vertices = rest.skin(mesh);
        for vertex in vertices.iter().filter(|vertex| vertex.is_finite()) {
            let (least, most) = extent.get_or_insert((*vertex, *vertex));
            (*least, *most) = (least.min(*vertex), most.max(*vertex));
        }
        let mut ends: Vec<[usize; 2]> = Vec::new();
        for face in mesh.faces() {
            for (corner, vertex) in face.iter().enumerate() {
                let (one, other) = (*vertex as usize, face[(corner + 1) % face.len()] as usize);
                if one.max(other) < vertices.len() && one != other {
                    ends.push([one.min(other), one.max(other)]);
                }
            }
        }
        ends.sort_unstable();
        ends.dedup();
        let edges = ends.into_iter().map(|ends| Edge {
            at_rest: vertices[ends[0]].distance(vertices[ends[1]]),
            ends,
        });
        skins.push(Skin {
            mesh,
            edges: edges.collect(),
        });
    }
    let (least, most) = extent?;
    let height = (most - least).max_element();
    if !(height.is_finite() && height > 0.0) {
        return None;
    }
    let lowest_at_rest = skins
        .iter()
        .flat_map(|skin| rest.skin(skin.mesh))
        .map(|vertex| vertex.dot(up));
    let lowest_at_rest = lowest_at_rest.fold(f32::INFINITY, f32::min);
    // At rest, the skin of a sole may be below the floor.
    let sole = target
        .floor_at_rest
        .map_or(0.0, |floor| (lowest_at_rest - floor).min(0.0));
    let metres = target.metres_per_unit;
    let meshes: Vec<&Mesh> = skins.iter().map(|skin| skin.mesh).collect();
    let at_rest: Vec<_> = meshes.iter().map(|mesh| rest.skin(mesh)).collect();
    let hands = target
        .person
        .map_or(Vec::new(), |body| Hand::of(target.scene, body, &meshes, &at_rest));
    let binding = Binding::new(target.scene, target.animation);
    let mut is = rest;
    let mut report = SkinReport {
        height: metres * f64::from(height),
        uneven_joint: uneven_joint(target),
        ..SkinReport::default()
    };
    let (mut stretched, mut count, mut worst) = (0_usize, 0_usize, None);
    let (mut looks, mut inside) = (0_usize, 0_usize);
    for &tick in ticks.iter().step_by(ticks.len().div_ceil(LOOKS).max(1)) {
        is.sample(&binding, target.animation, tick);
        let mut lowest = f32::INFINITY;
        let posed: Vec<_> = meshes.iter().map(|mesh| is.skin(mesh)).collect();
        if hands.iter().any(|hand| hand.is_inside(&posed)) {
            inside += 1;
            report.hands_tick.get_or_insert(tick);
        }
        looks += 1;
        for (index, (skin, vertices)) in skins.iter().zip(&posed).enumerate() {
            lowest = vertices.iter().map(|vertex| vertex.dot(up)).fold(lowest, f32::min);
            for (edge, Edge { ends, at_rest }) in skin.edges.iter().enumerate() {
                let length = vertices[ends[0]].distance(vertices[ends[1]]);
                let stretch = f64::from((length - at_rest) / height);
                if stretch > report.largest_stretch {
                    (report.largest_stretch, report.stretch_tick) = (stretch, tick);
                    worst = Some((index, edge));
                }
                stretched += usize::from(length > STRETCHED * at_rest && length > SHORTEST * height);
            }
            count += skin.edges.len();
        }
        let below = metres * f64::from(target.floor + sole - lowest - depth_of_source(tick));
        if below > report.below_floor {
            (report.below_floor, report.floor_tick) = (below, tick);
        }
    }
    report.hands_inside = inside as f64 / looks.max(1) as f64;
    report.fraction_stretched = stretched as f64 / count.max(1) as f64;
    if let Some((skin, edge)) = worst {
        let ends = skins[skin].edges[edge].ends;
        report.stretched_between = ends.map(|vertex| strongest(target.scene, skins[skin].mesh, vertex));
    }
    Some(report)
}

/// The first node, from the root down to a bone, whose scale is mirrored or not uniform.
fn uneven_joint(target: &SkinnedMotion<'_>) -> Option<String> {
    let bones = &target.joints;
    let nodes = &target.scene.nodes;
    let carries = |node: usize| {
        let above = |bone: &NodeId| std::iter::successors(Some(*bone), |node| nodes[node.index()].parent);
        bones.iter().any(|bone| above(bone).any(|above| above.index() == node))
    };
    let is_uneven = |matrix: &Mat4| {
        let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(Vec4::length);
        let (least, most) = (
            axes.iter().copied().fold(f32::MAX, f32::min),
            axes.iter().copied().fold(0.0, f32::max),
        );
        matrix.determinant() < 0.0 || most > UNEVEN * least
    };
    let uneven = nodes
        .iter()
        .enumerate()
        .find(|(index, node)| is_uneven(&node.transform) && carries(*index));
    uneven.map(|(_, node)| node.name.clone())
}

/// The name of the joint that moves a vertex most.
fn strongest(scene: &Scene, mesh: &Mesh, vertex: usize) -> String {
    let weights = mesh.bones.iter().filter_map(|bone| {
        let weight = bone.weights.iter().find(|weight| weight.vertex_id as usize == vertex)?;
        Some((bone.node, weight.weight))
    });
    let strongest = weights.max_by(|a, b| a.1.total_cmp(&b.1));
    strongest.map_or(String::new(), |(node, _)| scene.nodes[node.index()].name.clone())
}
