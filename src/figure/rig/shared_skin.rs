//! Finds joints that move the same parts of a skin.

use std::collections::{BTreeMap, HashMap};

use glam::Vec3;
use mocap_scene::scene::{Mesh, Scene};

/// The score that two joints get for an edge of a face between their vertices. For a shared vertex, they get the
/// smaller of its two weights, which is at most 0.5.
const SHARED_FACE: f32 = 0.1;

/// The number of a limb's vertices whose nearest neighbours are searched.
const SAMPLES: usize = 64;

/// A weight of a vertex below this fraction is ignored as stray.
const STRAY: f32 = 0.01;

/// The parts of the skin that joints share.
pub(super) struct SharedSkin {
    /// Whether a node moves vertices of the skin.
    has_skin: Vec<bool>,
    /// For each pair of joints, how much of the skin both move. The lower index is first in the key.
    shared: HashMap<(usize, usize), f32>,
}

impl SharedSkin {
    pub(super) fn new(scene: &Scene) -> Self {
        let mut skin = Self {
            has_skin: vec![false; scene.nodes.len()],
            shared: HashMap::new(),
        };
        for mesh in skins(scene) {
            let influences = influences(mesh);
            for joints in &influences {
                for (index, (joint, weight)) in joints.iter().enumerate() {
                    skin.has_skin[*joint] = true;
                    for (other, also) in &joints[..index] {
                        skin.add(*joint, *other, weight.min(*also));
                    }
                }
            }
            let strongest: Vec<Option<usize>> = influences.iter().map(|joints| strongest(joints)).collect();
            for face in mesh.faces() {
                for (corner, vertex) in face.iter().enumerate() {
                    let next = face[(corner + 1) % face.len()];
                    let of = |vertex: u32| strongest.get(vertex as usize).copied().flatten();
                    if let (Some(joint), Some(other)) = (of(*vertex), of(next))
                        && joint != other
                    {
                        skin.add(joint, other, SHARED_FACE);
                    }
                }
            }
        }
        skin
    }

    fn add(&mut self, joint: usize, other: usize, shared: f32) {
        *self.shared.entry((joint.min(other), joint.max(other))).or_default() += shared;
    }

    /// Whether a node moves vertices of the skin.
    pub(super) fn has(&self, node: usize) -> bool {
        self.has_skin[node]
    }

    /// The nodes that move vertices.
    pub(super) fn weighted(&self) -> impl Iterator<Item = usize> {
        (0..self.has_skin.len()).filter(|node| self.has_skin[*node])
    }

    /// How much of the skin both joints move.
    pub(super) fn shared(&self, joint: usize, other: usize) -> f32 {
        let pair = (joint.min(other), joint.max(other));
        self.shared.get(&pair).copied().unwrap_or_default()
    }

    /// For each other joint, how much of the skin it moves together with one of `joints`.
    pub(super) fn shared_by(&self, joints: &[usize]) -> BTreeMap<usize, f32> {
        let mut others = BTreeMap::new();
        for ((low, high), shared) in &self.shared {
            match (joints.contains(low), joints.contains(high)) {
                (true, false) => *others.entry(*high).or_default() += shared,
                (false, true) => *others.entry(*low).or_default() += shared,
                _ => {}
            }
        }
        others
    }

    /// The joint with the most vertices nearest to a limb's vertices, if half of the limb's vertices are within the
    /// distance `within`.
    pub(super) fn nearest(&self, scene: &Scene, limb: &[usize], within: f32) -> Option<usize> {
        let (mut own, mut others) = (Vec::new(), Vec::new());
        for mesh in skins(scene) {
            for (vertex, joints) in mesh.vertices.iter().zip(influences(mesh)) {
                match strongest(&joints) {
                    Some(joint) if limb.contains(&joint) => own.push(*vertex),
                    Some(joint) => others.push((*vertex, joint)),
                    None => {}
                }
            }
        }
        let step = own.len().div_ceil(SAMPLES).max(1);
        let samples: Vec<Vec3> = own.into_iter().step_by(step).collect();
        let mut votes: BTreeMap<usize, usize> = BTreeMap::new();
        for sample in &samples {
            let distance = |(vertex, _): &(Vec3, usize)| vertex.distance_squared(*sample);
            let nearest = others.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
            if let Some(nearest) = nearest.filter(|nearest| distance(nearest).sqrt() < within) {
                *votes.entry(nearest.1).or_default() += 1;
            }
        }
        let near: usize = votes.values().sum();
        let best = votes
            .into_iter()
            .max_by_key(|(joint, votes)| (*votes, std::cmp::Reverse(*joint)));
        best.filter(|_| 2 * near > samples.len()).map(|(joint, _)| joint)
    }
}

/// The meshes with a skin.
fn skins(scene: &Scene) -> impl Iterator<Item = &Mesh> {
    scene.own_meshes().filter(|mesh| !mesh.bones.is_empty())
}

/// The joints of each vertex, with their weights.
fn influences(mesh: &Mesh) -> Vec<Vec<(usize, f32)>> {
    let mut influences = vec![Vec::new(); mesh.vertices.len()];
    for bone in &mesh.bones {
        for weight in bone.weights.iter().filter(|weight| weight.weight > STRAY) {
            if let Some(joints) = influences.get_mut(weight.vertex_id as usize) {
                joints.push((bone.node.index(), weight.weight));
            }
        }
    }
    influences
}

/// The joint with the most weight.
fn strongest(joints: &[(usize, f32)]) -> Option<usize> {
    let best = joints.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    best.map(|(joint, _)| *joint)
}
