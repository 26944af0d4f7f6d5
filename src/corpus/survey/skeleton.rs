//! An id that is equal for equal skeletons up to scale and names.

use sha2::{Digest, Sha256};

use mocap_scene::scene::{NodeKind, Scene};

/// The fraction of the largest length by which lengths are told apart: solvers fit each take on its own.
const GRAIN: f32 = 0.02;

/// A hash of which joint is below which, and of the lengths of bones beside the longest. End sites do not count, since
/// some formats leave them out, and neither do joints that only place the figure, `places`.
pub(super) fn id(scene: &Scene, places: &[bool]) -> String {
    let is_joint = |index: usize| scene.nodes[index].kind == NodeKind::Joint && !places[index];
    let joints: Vec<usize> = (0..scene.nodes.len()).filter(|index| is_joint(*index)).collect();
    let length = |index: usize| scene.nodes[index].transform.w_axis.truncate().length();
    // Where the root stands is no length of the skeleton.
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
