//! Reads the morph targets of a primitive: the offsets of the kept vertices.

use std::collections::BTreeMap;

use glam::Vec3;
use mocap_scene::scene::{Keys, MorphTarget};

use super::super::file::is_plausible;
use super::super::invalid::invalid;
use super::Buffers;
use crate::Failure;

/// The statements about a mesh's targets: names and rest weights.
pub(super) struct Stated<'a> {
    pub(super) names: &'a [String],
    pub(super) weights: &'a [f32],
    /// The weight curves of each target in every animation, with keys in seconds. Empty if nothing moves the targets.
    pub(super) motion: &'a [Vec<Keys<f32>>],
    /// Whether the targets are read. Otherwise only the rest weights of the targets are read.
    pub(super) are_read: bool,
}

/// The targets of a primitive for the vertices `kept`, each with its number in the file. Targets that move none of
/// these vertices are skipped.
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
        // Targets may share their numbers, so a few bytes can state many targets.
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
                let message = format!("its offset for vertex {old} is not finite, or too large");
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
