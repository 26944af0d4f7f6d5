//! Checks the meshes of a character in a file of another format, by the values that both readers give.
//!
//! Face corners are compared, because writers join and split vertices. A corner has a rest position, joint weights and
//! texture coordinates. Meshes that were drawn for a skeleton are not part of the character.

use std::collections::BTreeMap;

use glam::{DMat4, DVec3, Vec3};
use mocap_scene::scene::{Bone, Mesh, Primitive, Scene};

use super::chain::Skeleton;
use super::change::Change;
use super::pairs::Pairs;
use super::{Finding, FindingKind};

/// The largest position error of a corner, as a fraction of the size of all meshes.
const SAME_PLACE: f64 = 1e-3;

/// The largest error of texture coordinates, as a fraction of the texture: half a pixel of 4096.
const SAME_COORDS: f32 = 1e-4;

/// The number of joints per vertex that every format can store.
const MOST_JOINTS: usize = 4;

/// The largest sum of the errors of the weights of a vertex: formats store them in 255ths.
const SAME_WEIGHTS: f64 = 0.03;

/// The largest error of a colour component: formats store linear or sRGB values.
const SAME_COLOUR: f32 = 0.01;

/// Finds missing or different meshes. `read` gives the meshes of the source. `keeps_rest` states that the rest pose is
/// the source's rest pose. A file without meshes is a skeleton.
pub(super) fn find(
    read: &dyn Fn() -> Option<Scene>,
    output: &Scene,
    change: &Change,
    keeps_rest: bool,
) -> Vec<Finding> {
    let mut theirs = meshes(output);
    // A file has the meshes in the node order of the source, but a reader may attach them to other nodes.
    theirs.sort_by_key(|(_, mesh)| output.meshes.iter().position(|other| std::ptr::eq(other, *mesh)));
    if theirs.is_empty() {
        return Vec::new();
    }
    let Some(source) = &read() else {
        return Vec::new();
    };
    let ours = meshes(source);
    if ours.is_empty() {
        return Vec::new();
    }
    let finding = |kind, message: String| vec![Finding::new(kind, message)];
    if ours.len() != theirs.len() {
        let message = format!(
            "the source has {} meshes, but the file has {}",
            ours.len(),
            theirs.len()
        );
        return finding(FindingKind::Mesh, message);
    }
    let skeletons = (Skeleton::of_scene(source, None), Skeleton::of_scene(output, None));
    let Ok(pairs) = Pairs::new(&skeletons.0, &skeletons.1) else {
        return Vec::new();
    };
    let their_joint: BTreeMap<usize, usize> = pairs.list.iter().copied().collect();
    let there = placed(&skeletons.1, &theirs, usize::MAX);
    // A file keeps the strongest weights of a vertex, up to the limit of its format.
    let counts = there.iter().flat_map(|mesh| mesh.weights.iter().map(Vec::len));
    let most_weights = counts.fold(MOST_JOINTS, usize::max);
    let here = placed(&skeletons.0, &ours, most_weights);
    let size = size(here.iter().flat_map(|mesh| &mesh.positions)) * change.metres_per_unit;
    for (here, there) in std::iter::zip(&here, &there) {
        let name = &here.mesh.name;
        if here.faces.len() != there.faces.len() {
            let (expected, found) = (here.faces.len(), there.faces.len());
            let message = format!("the mesh \"{name}\" has {found} faces in the file, but {expected} in its source");
            return finding(FindingKind::Mesh, message);
        }
        let is_at = |a: u32, b: u32| {
            let (a, b) = (here.positions[a as usize], there.positions[b as usize]);
            !keeps_rest || change.apply(a).distance(b) <= SAME_PLACE * size
        };
        let has_weights = |a: u32, b: u32| has_weights(here.weights(a), there.weights(b), &their_joint);
        for (ours, theirs) in std::iter::zip(&here.faces, &there.faces) {
            let is_same = |check: &dyn Fn(u32, u32) -> bool| {
                // A writer may flip a face that points inwards, so both directions count as equal.
                let [a, b, c] = *theirs;
                [[a, b, c], [a, c, b]]
                    .iter()
                    .any(|theirs| std::iter::zip(ours, theirs).all(|(a, b)| check(*a, *b)))
            };
            if !is_same(&is_at) {
                return finding(
                    FindingKind::Mesh,
                    format!("vertices of the mesh \"{name}\" have other positions"),
                );
            }
            if !is_same(&has_weights) {
                return finding(
                    FindingKind::Skin,
                    format!("other joints move vertices of the mesh \"{name}\""),
                );
            }
            if !is_same(&|a, b| has_coords(here.mesh, there.mesh, a, b)) {
                return finding(
                    FindingKind::Mesh,
                    format!("texture coordinates of the mesh \"{name}\" differ"),
                );
            }
        }
        if let Some(what) = other_material(source, here.mesh, output, there.mesh) {
            return finding(FindingKind::Material, format!("{what} of the mesh \"{name}\" differs"));
        }
    }
    Vec::new()
}

/// The meshes with faces, in the order of their nodes; none if all were drawn for a skeleton.
fn meshes(scene: &Scene) -> Vec<(usize, &Mesh)> {
    let nodes = scene.nodes.iter().enumerate();
    let all = nodes.flat_map(|(index, node)| node.meshes.iter().map(move |mesh| (index, *mesh)));
    let all = all.filter_map(|(node, mesh)| Some((node, scene.meshes.get(mesh)?)));
    let all: Vec<_> = all
        .filter(|(_, mesh)| mesh.primitive == Primitive::Triangles && !mesh.indices.is_empty())
        .collect();
    match all.iter().all(|(_, mesh)| scene.is_drawn_skeleton(mesh)) {
        true => Vec::new(),
        false => all,
    }
}

/// The meshes in the rest pose, with the strongest `most_weights` weights of each vertex.
fn placed<'a>(skeleton: &Skeleton, all: &[(usize, &'a Mesh)], most_weights: usize) -> Vec<Placed<'a>> {
    let mut world = Vec::new();
    skeleton.world(0.0, &mut world);
    all.iter()
        .map(|(node, mesh)| Placed::new(mesh, *node, &world, most_weights))
        .collect()
}

/// A mesh in the rest pose.
struct Placed<'a> {
    mesh: &'a Mesh,
    /// The world position of every vertex.
    positions: Vec<DVec3>,
    /// For every vertex the nodes that move it, the strongest first.
    weights: Vec<Vec<(usize, f64)>>,
    /// The faces with an area.
    faces: Vec<[u32; 3]>,
}

impl<'a> Placed<'a> {
    fn new(mesh: &'a Mesh, node: usize, world: &[DMat4], most_weights: usize) -> Self {
        let mut weights = vec![Vec::new(); mesh.vertices.len()];
        for (index, bone) in mesh.bones.iter().enumerate() {
            for weight in &bone.weights {
                if let Some(weights) = weights.get_mut(weight.vertex_id as usize) {
                    weights.push((index, f64::from(weight.weight)));
                }
            }
        }
        for weights in &mut weights {
            weights.sort_by(|a, b| b.1.total_cmp(&a.1));
            weights.truncate(most_weights);
            let sum: f64 = weights.iter().map(|(_, weight)| weight).sum();
            if sum > 0.0 {
                weights.iter_mut().for_each(|(_, weight)| *weight /= sum);
            }
        }
        let of_bone = |bone: &Bone| world[bone.node.index()] * bone.offset_matrix.as_dmat4();
        let to_world: Vec<DMat4> = mesh.bones.iter().map(of_bone).collect();
        let place = |(position, weights): (&Vec3, &Vec<(usize, f64)>)| {
            let position = position.as_dvec3();
            let moved = |(bone, weight): &(usize, f64)| *weight * to_world[*bone].transform_point3(position);
            match mesh.bones.is_empty() {
                true => world[node].transform_point3(position),
                false => weights.iter().map(moved).sum(),
            }
        };
        let positions = std::iter::zip(&mesh.vertices, &weights).map(place).collect();
        for (bone, _) in weights.iter_mut().flatten() {
            *bone = mesh.bones[*bone].node.index();
        }
        let count = mesh.vertices.len();
        let faces = mesh.faces().filter_map(|face| <[u32; 3]>::try_from(face).ok());
        let has_area = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|vertex| mesh.vertices[vertex as usize]);
            a != b && b != c && c != a
        };
        let faces = faces.filter(|face| face.iter().all(|vertex| (*vertex as usize) < count) && has_area(face));
        Self {
            mesh,
            positions,
            weights,
            faces: faces.collect(),
        }
    }

    fn weights(&self, vertex: u32) -> &[(usize, f64)] {
        &self.weights[vertex as usize]
    }
}

/// The diagonal of the box around all points.
fn size<'a>(points: impl Iterator<Item = &'a DVec3>) -> f64 {
    let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for point in points {
        (least, most) = (least.min(*point), most.max(*point));
    }
    (most - least).length()
}

/// Whether the joints of a vertex move it as in the source.
fn has_weights(ours: &[(usize, f64)], theirs: &[(usize, f64)], their_joint: &BTreeMap<usize, usize>) -> bool {
    // A vertex without weights follows any joint.
    if ours.is_empty() {
        return true;
    }
    let mut of_joint: BTreeMap<usize, f64> = theirs.iter().copied().collect();
    let mut unpaired = 0.0;
    for (joint, weight) in ours {
        match their_joint.get(joint) {
            Some(joint) => *of_joint.entry(*joint).or_default() -= weight,
            None => unpaired += weight,
        }
    }
    let differs: f64 = of_joint.values().map(|weight| weight.abs()).sum::<f64>() + unpaired;
    differs <= SAME_WEIGHTS
}

fn has_coords(ours: &Mesh, theirs: &Mesh, a: u32, b: u32) -> bool {
    match (
        ours.texture_coords.get(a as usize),
        theirs.texture_coords.get(b as usize),
    ) {
        (Some(ours), Some(theirs)) => ours.abs_diff_eq(*theirs, SAME_COORDS * ours.abs().max_element().max(1.0)),
        (ours, _) => ours.is_none(),
    }
}

/// The first property of a mesh's material that differs.
fn other_material(source: &Scene, ours: &Mesh, output: &Scene, theirs: &Mesh) -> Option<&'static str> {
    let material = |scene: &Scene, mesh: &Mesh| scene.materials.get(mesh.material_index).cloned().unwrap_or_default();
    let (ours, theirs) = (material(source, ours), material(output, theirs));
    // Without a stated colour, each reader has its own default.
    let our_surface = ours.surface?;
    let Some(their_surface) = theirs.surface else {
        return Some("the material");
    };
    if !theirs.name.trim().starts_with(ours.name.trim()) {
        return Some("the name of the material");
    }
    if !our_surface
        .base_color
        .abs_diff_eq(their_surface.base_color, SAME_COLOUR)
    {
        return Some("the colour");
    }
    let is_other = texture(source, our_surface.texture) != texture(output, their_surface.texture);
    is_other.then_some("the texture")
}

/// The bytes of a texture.
fn texture(scene: &Scene, index: Option<usize>) -> Option<&[u8]> {
    Some(&scene.textures.get(index?)?.bytes)
}
