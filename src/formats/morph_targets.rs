//! The checks of morph targets that all writers share.

use mocap_scene::limits::is_plausible;
use mocap_scene::scene::{Mesh, MorphTarget};

/// Returns an error text for morph targets with invalid numbers, or with a vertex that does not exist.
pub(crate) fn check(mesh: &Mesh) -> Result<(), String> {
    let is_sound = |target: &&MorphTarget| {
        let count = target.vertex_ids.len();
        let moved = target.offsets.iter().chain(&target.normal_offsets);
        let keys = target.weight_keys.iter().flat_map(|keys| &keys.values).copied();
        let mut numbers = moved.flat_map(glam::Vec3::to_array).chain(keys).chain([target.weight]);
        count == target.offsets.len()
            && (target.normal_offsets.is_empty() || target.normal_offsets.len() == count)
            && target.vertex_ids.iter().all(|id| (*id as usize) < mesh.vertices.len())
            && numbers.all(|number| is_plausible(number.into()))
    };
    match mesh.morph_targets.iter().find(|target| !is_sound(target)) {
        None => Ok(()),
        Some(target) => Err(format!(
            "a number of the morph target {:?} is not finite, or it moves a vertex that does not exist",
            target.name
        )),
    }
}
