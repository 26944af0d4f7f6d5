//! The morph targets of a primitive: what each of them adds to the vertices that are kept.

use std::collections::BTreeMap;

use glam::Vec3;
use mocap_scene::scene::{Keys, MorphTarget};

use super::super::file::is_plausible;
use super::super::invalid::invalid;
use super::Buffers;
use crate::Failure;

/// The targets of a mesh in words: names, and the weights at rest.
pub(super) struct Stated<'a> {
    pub(super) names: &'a [String],
    pub(super) weights: &'a [f32],
    /// Of each target its weight in every animation, at seconds; empty where nothing moves them.
    pub(super) motion: &'a [Vec<Keys<f32>>],
    /// Whether they are read, and not only their weights at rest.
    pub(super) are_read: bool,
}

/// The targets of a primitive of which the vertices `kept` are kept, each with its number in the file; those that move
/// none of them are left out.
pub(super) fn read(
    targets: &[BTreeMap<String, usize>],
    stated: &Stated<'_>,
    kept: &[usize],
    buffers: &mut Buffers<'_>,
    pointer: &str,
) -> Result<Vec<(usize, MorphTarget)>, Failure> {
    let mut found = Vec::new();
    for (index, target) in targets.iter().enumerate().filter(|_| stated.are_read) {
        let pointer = format!("{pointer}/targets/{index}");
        // Targets may share their numbers, so that a few bytes say many of them.
        buffers.bytes.budget.take(kept.len() as u64, &pointer)?;
        let mut read = |name: &str| match target.get(name) {
            Some(&accessor) => buffers.numbers(accessor, 3, &pointer).map(Some),
            None => Ok(None),
        };
        let (offsets, normals) = (read("POSITION")?, read("NORMAL")?);
        let of = |numbers: &Option<std::rc::Rc<[f32]>>, vertex: usize| {
            let numbers = numbers
                .as_ref()
                .and_then(|numbers| numbers.get(3 * vertex..3 * vertex + 3));
            numbers.map_or(Vec3::ZERO, Vec3::from_slice)
        };
        let name = stated.names.get(index).filter(|name| !name.is_empty());
        let mut read = MorphTarget {
            name: name.cloned().unwrap_or_else(|| format!("target {}", index + 1)),
            weight: stated.weights.get(index).copied().unwrap_or_default(),
            weight_keys: stated
                .motion
                .get(index)
                .filter(|animations| animations.iter().any(|keys| !keys.is_empty()))
                .cloned()
                .unwrap_or_default(),
            ..MorphTarget::default()
        };
        for (vertex, &old) in kept.iter().enumerate() {
            let (offset, normal) = (of(&offsets, old), of(&normals, old));
            if offset == Vec3::ZERO && normal == Vec3::ZERO {
                continue;
            }
            let all = offset.to_array().into_iter().chain(normal.to_array());
            if !all.into_iter().all(is_plausible) {
                let message = format!("what it adds to vertex {old} is not finite, or too large");
                return Err(invalid(pointer, message).into());
            }
            read.vertex_ids.push(vertex as u32);
            read.offsets.push(offset);
            if normals.is_some() {
                read.normal_offsets.push(normal);
            }
        }
        if !read.vertex_ids.is_empty() {
            found.push((index, read));
        }
    }
    Ok(found)
}
