//! An id of a skeleton. Scale and names do not change the id.

use sha2::{Digest, Sha256};

use mocap_scene::scene::{NodeKind, Scene};

/// The step to which bone lengths are rounded, as a fraction of the longest bone. Solvers fit the lengths to each take,
/// so the lengths of one skeleton differ slightly.
const GRAIN: f32 = 0.02;

/// A hash of the hierarchy, and of the bone lengths relative to the longest bone. The hash ignores end sites, which
/// some formats lack. It also ignores joints that only place the figure (`places`).
pub(super) fn id(scene: &Scene, places: &[bool]) -> String {
    let is_joint = |index: usize| scene.nodes[index].kind == NodeKind::Joint && !places[index];
    let joints: Vec<usize> = (0..scene.nodes.len()).filter(|index| is_joint(*index)).collect();
    let length = |index: usize| scene.nodes[index].transform.w_axis.truncate().length();
    // The position of the root is not a bone length.
    let lengths: Vec<f32> = joints.iter().skip(1).map(|index| length(*index)).collect();
    let longest = lengths.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
    let mut hash = Sha256::new();
    for (position, index) in joints.iter().enumerate() {
        let parent = scene.nodes[*index]
            .parent
            .and_then(|parent| joints.binary_search(&parent.index()).ok());
        hash.update(parent.map_or(u32::MAX, |parent| parent as u32).to_le_bytes());
        if position > 0 {
            let grains = lengths[position - 1] / longest / GRAIN;
            hash.update((grains.round() as u32).to_le_bytes());
        }
    }
    hash.finalize()
        .iter()
        .take(8)
        .map(|byte| format!("{byte:02x}"))
        .collect()
}
