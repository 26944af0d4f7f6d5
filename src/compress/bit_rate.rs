//! Bit rate selection: the fewest bits per component with which the QUATERNION filter keeps a track within its
//! tolerance, and the keys with that bit rate.
//!
//! A rotation about the arm to a child hardly moves the child. So among the [`candidates`](super::candidates) around a
//! target some are far better than the nearest, and a track needs about one bit less than if it were rounded. Variable
//! bit rates come from the Animation Compression Library: N. Frechette, "Animation Compression: Advanced
//! Quantization", <https://nfrechette.github.io/2017/03/12/anim_compression_advanced_quantization/>

use mocap_scene::math::soa::single::LANES;
use mocap_scene::math::wide;

use super::candidates::{Candidates, Dropped};
use super::compensation::Compensation;
use super::quantize::{Lattice, QuantizedRotation};

/// The coarsest lattice from `coarsest` on that keeps the error at every key frame within `tolerance`, and the keys. If
/// none does, the finest.
pub(super) fn select(
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
    /// The keys on a lattice; `None` if the error of one is above `tolerance`, unless it is the finest lattice.
    fn quantize(
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
    // With capacity for keys that refinement inserts.
    let mut keys: Vec<QuantizedRotation> = Vec::with_capacity(key_frames.len() + key_frames.len() / 4);
    for frames in key_frames.chunks(LANES) {
        let targets = joint.targets(frames);
        let dropped = Dropped::in_sequence(&targets.rotation, keys.last().map(QuantizedRotation::dropped));
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
    /// Whether a sample of the key frames is within `tolerance`: a lattice that is too coarse mostly shows in a few.
    fn may_suffice(joint: &Compensation<'_>, lattice: Lattice, key_frames: &[u32], tolerance: f32) -> bool {
        may_suffice_lanes(joint, lattice, key_frames, tolerance)
    }
}

#[inline(always)]
fn may_suffice_lanes(joint: &Compensation, lattice: Lattice, key_frames: &[u32], tolerance: f32) -> bool {
    const EVERY: usize = 13;
    let sample: Vec<u32> = key_frames.iter().step_by(EVERY).copied().collect();
    let mut keys = Vec::with_capacity(LANES);
    for frames in sample.chunks(LANES) {
        let targets = joint.targets(frames);
        let dropped = Dropped::independent(&targets.rotation, |_| None);
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
    /// Keys for some frames on a lattice, each given the key before it.
    pub(super) fn quantize_after(
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
        let dropped = Dropped::independent(&targets.rotation, dropped_before);
        let candidates = Candidates::new(joint.arms, lattice, tolerance, &targets, dropped);
        for (lane, previous) in previous.iter().enumerate() {
            keys.push(candidates.best(lane, Some(previous)));
        }
    }
    keys
}

#[cfg(test)]
mod tests {
    use glam::{Quat, Vec3};

    use super::super::error_metric::LeverArms;
    use super::super::object_space::ObjectSpaceTrack;
    use super::*;

    /// A joint that rotates in the raw clip, its lossy parent, whose rotation is a little off, and its lossy positions.
    fn joint_and_parent(frames: usize) -> (ObjectSpaceTrack, ObjectSpaceTrack, Vec<Vec3>) {
        let rotation = |frame: usize, speed: f32| {
            let angle = frame as f32 * speed;
            Quat::from_euler(glam::EulerRot::ZXY, angle, 0.6 * angle, (0.3 * angle).sin())
        };
        let off = Quat::from_rotation_x(4e-4);
        let track = |rotation: &dyn Fn(usize) -> Quat| ObjectSpaceTrack {
            positions: vec![Vec3::ZERO; frames],
            rotations: (0..frames).map(rotation).collect(),
        };
        let lossy_positions = (0..frames).map(|frame| Vec3::X * (frame as f32).sin() * 3e-4).collect();
        (
            track(&|frame| rotation(frame, 0.031)),
            track(&|frame| off * rotation(frame, 0.007)),
            lossy_positions,
        )
    }

    #[test]
    fn every_key_is_within_the_tolerance_and_a_lower_bit_rate_is_not() {
        const TOLERANCE: f32 = 0.001;
        let (raw, lossy_parent, lossy_positions) = joint_and_parent(1003);
        let arms = LeverArms::new(vec![Vec3::new(0.0, 0.3, 0.1)]);
        let joint = Compensation {
            arms: &arms,
            raw: &raw,
            lossy_positions: &lossy_positions,
            lossy_parent: Some(&lossy_parent),
        };
        let frames: Vec<u32> = (0..1003).collect();
        let (lattice, keys) = select(&joint, Lattice::of_filter(4), &frames, TOLERANCE);
        let bits = lattice.max().ilog2() + 2;
        assert!((6..12).contains(&bits), "{bits}");
        let coarser = Lattice::of_filter(bits - 1);
        for (frame, key) in keys.iter().enumerate() {
            // Where the child should be, and where it is.
            let arm = arms.arms[0];
            let expected = raw.rotations[frame] * arm;
            let found = lossy_positions[frame] + lossy_parent.rotations[frame] * (key.value.normalize() * arm);
            assert!(expected.distance(found) <= 1.001 * TOLERANCE, "{frame}: {found}");
        }
        assert!(
            quantize(&joint, coarser, &frames, TOLERANCE).is_none()
                || !may_suffice(&joint, coarser, &frames, TOLERANCE)
        );

        // Keys decoded eight at a time are those decoded alone.
        for coarsest in [Lattice::of_filter(4), Lattice::of_filter(12), Lattice::of_steps(300.0)] {
            let (lattice, keys) = select(&joint, coarsest, &frames, TOLERANCE);
            for key in keys {
                let [x, y, z, _] = key.stored.map(i32::from);
                let alone = lattice.at([x, y, z], key.dropped());
                assert_eq!(
                    (key.stored, key.value, key.ambiguous),
                    (alone.stored, alone.value, alone.ambiguous)
                );
            }
        }

        // So does a key that is inserted later.
        let stored = |keys: &[QuantizedRotation]| keys.iter().map(|key| key.stored).collect::<Vec<_>>();
        let later = quantize_after(&joint, lattice, &[500, 700], &[keys[499], keys[699]], TOLERANCE);
        assert_eq!(stored(&later), [keys[500].stored, keys[700].stored]);
    }
}
