//! Reads blend shapes as morph targets.
//!
//! In-between shapes count as lost. Weights come from the animations. A file has no rest weights, so a weight that is
//! equal in all animations becomes the rest weight.

use std::collections::{HashMap, HashSet};

use glam::Vec3;
use mocap_scene::limits::is_plausible;
use mocap_scene::scene::{Keys, MorphTarget};

use super::animation::Weights;
use super::index::Index;
use crate::ReadOptions;
use crate::usd::parse::Prim;

/// The remaining budget for shapes, and their weights.
pub(super) struct Shapes<'a> {
    index: &'a Index<'a>,
    are_read: bool,
    /// The weights by shape name in each animation.
    weights: &'a [Weights],
    /// The prims of shapes that were read.
    read: HashSet<usize>,
    /// The remaining number of shape values. One point may become many vertices.
    left: u64,
    /// The number of targets that exceeded the budget.
    left_out: usize,
}

impl<'a> Shapes<'a> {
    pub(super) fn new(index: &'a Index<'a>, weights: &'a [Weights], options: &ReadOptions) -> Self {
        Self {
            index,
            are_read: options.morph_targets,
            weights,
            read: HashSet::new(),
            left: options.limits.expanded_values(index.layer.text.len() as u64),
            left_out: 0,
        }
    }

    /// The targets of a mesh's points.
    pub(super) fn of_mesh(&mut self, mesh: usize, points: &[Vec3]) -> Vec<MorphTarget> {
        let index = self.index;
        let prims = &index.layer.prims;
        let mut targets = Vec::new();
        if !self.are_read {
            return targets;
        }
        let (names, paths) = (
            prims[mesh].texts("skel:blendShapes"),
            prims[mesh].texts("skel:blendShapeTargets"),
        );
        for (name, path) in std::iter::zip(names, paths) {
            let shape = index.find(path, mesh);
            let Some(shape) = shape.filter(|shape| prims[*shape].kind == "BlendShape") else {
                continue;
            };
            let prim = &prims[shape];
            let keys = self.weights.iter().filter_map(|weights| weights.get(name));
            let keys: usize = keys.map(Keys::len).sum();
            // Many meshes may share one shape, and many shapes may share one weight.
            if !self.take(prim.numbers("offsets").len() + keys) {
                continue;
            }
            if let Some(target) = target(prim, points) {
                self.read.insert(shape);
                targets.push(self.weighed(target, name));
            }
        }
        targets
    }

    /// Takes the values of a target from the budget, if possible.
    fn take(&mut self, values: usize) -> bool {
        let left = self.left.checked_sub(1 + values as u64);
        self.left = left.unwrap_or(self.left);
        left.is_some()
    }

    /// A target with the weights that the animations state for a name.
    fn weighed(&self, mut target: MorphTarget, name: &str) -> MorphTarget {
        if target.name.is_empty() {
            name.clone_into(&mut target.name);
        }
        let stated = || self.weights.iter().map(|weights| weights.get(name));
        let constant = |keys: &Keys<f32>| {
            let first = *keys.values.first()?;
            keys.values.iter().all(|weight| *weight == first).then_some(first)
        };
        let first = stated().next().flatten().and_then(constant);
        let stays = stated().all(|keys| keys.and_then(constant) == first);
        target.weight = first.filter(|_| stays).unwrap_or_default();
        let moves = |keys: &&Keys<f32>| !keys.is_empty() && constant(keys) != Some(target.weight);
        if stated().flatten().any(|keys| moves(&keys)) {
            let keys = stated().map(|keys| keys.filter(moves).cloned().unwrap_or_default());
            target.weight_keys = keys.collect();
        }
        target
    }

    /// The targets of a mesh with these points as vertices.
    pub(super) fn on(&mut self, targets: &[MorphTarget], points: impl Iterator<Item = u32>) -> Vec<MorphTarget> {
        if targets.is_empty() {
            return Vec::new();
        }
        let mut vertices: HashMap<u32, Vec<u32>> = HashMap::new();
        for (vertex, point) in (0_u32..).zip(points) {
            vertices.entry(point).or_default().push(vertex);
        }
        let mut found = Vec::new();
        for target in targets {
            let mut own = MorphTarget {
                name: target.name.clone(),
                weight: target.weight,
                weight_keys: target.weight_keys.clone(),
                ..MorphTarget::default()
            };
            for (at, point) in target.vertex_ids.iter().enumerate() {
                for &vertex in vertices.get(point).map(Vec::as_slice).unwrap_or_default() {
                    own.vertex_ids.push(vertex);
                    own.offsets.push(target.offsets[at]);
                    own.normal_offsets.extend(target.normal_offsets.get(at));
                }
            }
            let keys: usize = own.weight_keys.iter().map(Keys::len).sum();
            match self.take(own.vertex_ids.len() + keys) {
                true if own.vertex_ids.is_empty() => {}
                true => found.push(own),
                false => self.left_out += 1,
            }
        }
        found
    }

    /// The number of shapes of the layer that were not read, including in-between shapes.
    pub(super) fn unread(&self) -> usize {
        let between = |prim: &Prim| {
            let names = prim
                .attributes
                .keys()
                .filter_map(|name| name.strip_prefix("inbetweens:"));
            names.filter(|name| !name.contains(':')).count()
        };
        let prims = self.index.layer.prims.iter().enumerate();
        let shapes = prims.filter(|(_, prim)| prim.kind == "BlendShape");
        let unread = |(index, prim)| usize::from(!self.read.contains(&index)) + between(prim);
        self.left_out + shapes.map(unread).sum::<usize>()
    }
}

/// The offsets of a shape for points; `None` if its numbers do not match the points.
fn target(prim: &Prim, points: &[Vec3]) -> Option<MorphTarget> {
    let vectors = |name: &str| -> Option<Vec<Vec3>> {
        let (vectors, rest) = prim.numbers(name).as_chunks::<3>();
        let is_sound = rest.is_empty() && vectors.iter().flatten().all(|number| is_plausible(*number));
        let vectors = vectors
            .iter()
            .map(|vector| Vec3::from(vector.map(|number| number as f32)));
        is_sound.then(|| vectors.collect())
    };
    let (offsets, normals) = (vectors("offsets")?, vectors("normalOffsets")?);
    let stated = prim.numbers("pointIndices");
    let ids: Vec<u32> = match stated.is_empty() {
        // Without indices, the shape has one offset for each point.
        true => (0..offsets.len() as u32).collect(),
        false => stated.iter().map(|id| *id as u32).collect(),
    };
    let mut seen = HashSet::new();
    let is_whole = ids.len() == offsets.len()
        && (normals.is_empty() || normals.len() == ids.len())
        && ids.iter().all(|id| (*id as usize) < points.len() && seen.insert(*id));
    is_whole.then(|| MorphTarget {
        name: prim.display_name().cloned().unwrap_or_default(),
        vertex_ids: ids,
        offsets,
        normal_offsets: normals,
        ..MorphTarget::default()
    })
}
