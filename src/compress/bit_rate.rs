//! Bit rate selection: the fewest bits per component with which the QUATERNION filter keeps a track within its
//! tolerance, and the resulting keys.
//!
//! A rotation about the lever arm to a child hardly moves the child. So some lattice points around a target, its
//! [`candidates`](super::candidates), cause a far smaller error than the nearest lattice point. With the candidates, a
//! component needs about one bit less than with rounding to the nearest point. Variable bit rates come from the
//! Animation Compression Library: N. Frechette, "Animation Compression: Advanced Quantization",
//! <https://nfrechette.github.io/2017/03/12/anim_compression_advanced_quantization/>

use mocap_scene::math::soa::single::LANES;
use mocap_scene::math::wide;

use super::candidates::{Candidates, DroppedComponents};
use super::compensation::Compensation;
use super::quantize::{Lattice, QuantizedRotation};

/// Returns the coarsest lattice that keeps the error at every key frame within `tolerance`, and the keys on this
/// lattice. The search starts at `coarsest`. If every lattice is too coarse, returns the finest one and its keys.
pub fn select(
    joint: &Compensation,
    coarsest: Lattice,
    key_frames: &[u32],
    tolerance: f32,
) -> (Lattice, Vec<QuantizedRotation>) {
    let mut lattice = coarsest;
    loop {
        let finer = lattice.finer();
        if (finer.is_none() || may_suffice(joint, lattice, key_frames, tolerance))
            && let Some(keys) = quantize(joint, lattice, key_frames, tolerance)
        {
            return (lattice, keys);
        }
        lattice = finer.unwrap_or(lattice);
    }
}

wide::dispatch! {
    /// Returns the keys on a lattice, or `None` if the error of a key is above `tolerance`. On the finest lattice,
    /// always returns keys.
    pub fn quantize(
        joint: &Compensation<'_>,
        lattice: Lattice,
        key_frames: &[u32],
        tolerance: f32,
    ) -> Option<Vec<QuantizedRotation>> {
        quantize_lanes(joint, lattice, key_frames, tolerance)
    }
}

#[inline(always)]
fn quantize_lanes(
    joint: &Compensation,
    lattice: Lattice,
    key_frames: &[u32],
    tolerance: f32,
) -> Option<Vec<QuantizedRotation>> {
    // The extra capacity is for the keys that refinement inserts.
    let mut keys: Vec<QuantizedRotation> = Vec::with_capacity(key_frames.len() + key_frames.len() / 4);
    for frames in key_frames.chunks(LANES) {
        let targets = joint.targets(frames);
        let dropped = DroppedComponents::in_sequence(&targets.rotation, keys.last().map(QuantizedRotation::dropped));
        let candidates = Candidates::new(joint.arms, lattice, tolerance, &targets, dropped);
        let first = keys.len();
        candidates.push_best(frames.len(), &mut keys);
        if lattice.finer().is_some() && targets.largest_error(joint.arms, &keys[first..]) > tolerance {
            return None;
        }
    }
    Some(keys)
}

wide::dispatch! {
    /// Whether the error is within `tolerance` in a sample of the key frames. A lattice that is too coarse usually
    /// exceeds the tolerance in a few of these frames.
    pub fn may_suffice(joint: &Compensation<'_>, lattice: Lattice, key_frames: &[u32], tolerance: f32) -> bool {
        may_suffice_lanes(joint, lattice, key_frames, tolerance)
    }
}

#[inline(always)]
fn may_suffice_lanes(joint: &Compensation, lattice: Lattice, key_frames: &[u32], tolerance: f32) -> bool {
    /// The step between the sampled key frames: a prime number, so that no period of a motion coincides with it.
    const EVERY: usize = 13;
    let sample: Vec<u32> = key_frames.iter().step_by(EVERY).copied().collect();
    let mut keys = Vec::with_capacity(LANES);
    for frames in sample.chunks(LANES) {
        let targets = joint.targets(frames);
        let dropped = DroppedComponents::independent(&targets.rotation, |_| None);
        let candidates = Candidates::new(joint.arms, lattice, tolerance, &targets, dropped);
        keys.clear();
        for lane in 0..frames.len() {
            keys.push(candidates.best(lane, None));
        }
        if targets.largest_error(joint.arms, &keys) > tolerance {
            return false;
        }
    }
    true
}

wide::dispatch! {
    /// The keys for some frames on a lattice. `previous` has, for each of these frames, the key before the frame.
    pub fn quantize_after(
        joint: &Compensation<'_>,
        lattice: Lattice,
        frames: &[u32],
        previous: &[QuantizedRotation],
        tolerance: f32,
    ) -> Vec<QuantizedRotation> {
        quantize_after_lanes(joint, lattice, frames, previous, tolerance)
    }
}

#[inline(always)]
fn quantize_after_lanes(
    joint: &Compensation,
    lattice: Lattice,
    frames: &[u32],
    previous: &[QuantizedRotation],
    tolerance: f32,
) -> Vec<QuantizedRotation> {
    let mut keys = Vec::with_capacity(frames.len());
    for (frames, previous) in std::iter::zip(frames.chunks(LANES), previous.chunks(LANES)) {
        let targets = joint.targets(frames);
        let dropped_before = |lane: usize| previous.get(lane).map(QuantizedRotation::dropped);
        let dropped = DroppedComponents::independent(&targets.rotation, dropped_before);
        let candidates = Candidates::new(joint.arms, lattice, tolerance, &targets, dropped);
        for (lane, previous) in previous.iter().enumerate() {
            keys.push(candidates.best(lane, Some(previous)));
        }
    }
    keys
}
