//! Tests that quantized rotations are decoded as meshoptimizer decodes them.

use mocap::compress::{Lattice, RotationFormat};
use mocap::glam::Quat;
use mocap_compress::internals::{INT16_MAX, QuantizedRotation};

/// The decoded values agree up to the stated ambiguity.
#[test]
fn the_filter_decodes_as_meshoptimizer_does() {
    let mut seed = 1u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / 8_388_608.0 - 1.0
    };
    for bits in 5..=16 {
        let mut previous: Option<QuantizedRotation> = None;
        for _ in 0..1000 {
            let rotation = Quat::from_xyzw(random(), random(), random(), random()).normalize();
            // Every second rotation is near the previous one, so that the dropped component is not always the largest.
            let near = |previous: QuantizedRotation| (previous.value + rotation * 0.05).normalize();
            let rotation = previous.filter(|_| random() < 0.5).map_or(rotation, near);
            let quantized =
                RotationFormat::QuaternionFilter(Lattice::of_filter(bits)).quantize(rotation, previous.as_ref());
            let error = (quantized.value - rotation)
                .length()
                .min((quantized.value + rotation).length());
            let step = 1.0 / ((1 << (bits - 1)) - 1) as f32;
            assert!(
                error < 3.0 * step + 1e-4,
                "{bits} bits: {rotation} became {}",
                quantized.value
            );
            let mut reference = [quantized.stored];
            meshopt::decode_filter_quat(&mut reference);
            let reference = Quat::from_array(reference[0].map(|c| f32::from(c) / INT16_MAX));
            let difference = 2.0 * f64::from((quantized.value - reference).length());
            assert!(
                difference <= quantized.ambiguity() + 1e-6,
                "{bits} bits: {} became {reference}",
                quantized.value
            );
            previous = Some(quantized);
        }
    }
}
