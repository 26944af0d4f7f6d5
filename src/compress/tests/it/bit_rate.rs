//! Tests the choice of the bit rate of a track.

use mocap::compress::Lattice;
use mocap::glam::{EulerRot, Quat, Vec3};
use mocap_compress::internals::bit_rate::{may_suffice, quantize, quantize_after, select};
use mocap_compress::internals::{Compensation, LeverArms, ObjectSpaceTrack, QuantizedRotation};

/// A joint that rotates in the raw clip, and its lossy parent. The parent's rotation has a small error, and its
/// positions are lossy.
fn joint_and_parent(frames: usize) -> (ObjectSpaceTrack, ObjectSpaceTrack, Vec<Vec3>) {
    let rotation = |frame: usize, speed: f32| {
        let angle = frame as f32 * speed;
        Quat::from_euler(EulerRot::ZXY, angle, 0.6 * angle, (0.3 * angle).sin())
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
        // The expected and the actual position of the child.
        let arm = arms.arms[0];
        let expected = raw.rotations[frame] * arm;
        let found = lossy_positions[frame] + lossy_parent.rotations[frame] * (key.value.normalize() * arm);
        assert!(expected.distance(found) <= 1.001 * TOLERANCE, "{frame}: {found}");
    }
    assert!(
        quantize(&joint, coarser, &frames, TOLERANCE).is_none() || !may_suffice(&joint, coarser, &frames, TOLERANCE)
    );

    // Decoding eight keys at a time gives the same values as decoding each key alone.
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

    // A key that is inserted later also gives the same value.
    let stored = |keys: &[QuantizedRotation]| keys.iter().map(|key| key.stored).collect::<Vec<_>>();
    let later = quantize_after(&joint, lattice, &[500, 700], &[keys[499], keys[699]], TOLERANCE);
    assert_eq!(stored(&later), [keys[500].stored, keys[700].stored]);
}
