//! The part `lengths` of the cleaning: gives each bone a constant length if noise changes its length.

use glam::Vec3;

use crate::work::Work;

/// Makes the position of a joint relative to its parent constant if noise moves the joint. Returns the number of such
/// joints.
pub(super) fn hold(work: &mut Work<'_>) -> usize {
    let mut held = 0;
    let carrier = work.carrier();
    let least = work.weights.length_noise as f32;
    let largest = work.weights.largest_length_change as f32;
    for column in 0..work.frames.nodes().len() {
        // The node that carries the body, and the nodes above it, keep their movement.
        let is_inside = carrier.is_some_and(|carrier| column > carrier);
        if !is_inside || is_root(work, column) {
            continue;
        }
        let mut track = work.frames.track(column);
        let middle = Vec3::from_array([0, 1, 2].map(|axis| {
            let mut values: Vec<f32> = track.iter().map(|trs| trs.translation[axis]).collect();
            median(&mut values).unwrap_or(0.0)
        }));
        let steps = track
            .windows(2)
            .map(|pair| pair[1].translation.distance(pair[0].translation));
        let trembles = steps.sum::<f32>() / track.len().max(2) as f32 * work.metres;
        let off = track.iter().map(|trs| trs.translation.distance(middle)).sum::<f32>() / track.len().max(1) as f32;
        if trembles > least && off < largest * middle.length() {
            for trs in &mut track {
                trs.translation = middle;
            }
            work.frames.set_track(column, &track);
            held += 1;
        }
    }
    held
}

/// Whether a node is the hips or above them.
fn is_root(work: &Work<'_>, column: usize) -> bool {
    let hips = work.figure.humanoid.joint(mocap_scene::scene::HumanoidBone::Hips);
    hips.is_none_or(|hips| work.frames.nodes()[column] <= hips)
}
use mocap_scene::math::median::median;
