//! Tests 16-bit floats.

use mocap_scene::math::half::{from_half, to_half};

#[test]
fn every_number_of_16_bits_stays() {
    for bits in 0..=u16::MAX {
        let value = from_half(bits);
        if value.is_finite() {
            assert_eq!(to_half(value), bits, "{value}");
        }
    }
    // Values of IEEE 754: one, the least subnormal number, and the largest number.
    assert_eq!(
        [0x3c00, 0x0001, 0x7bff].map(from_half),
        [1.0, 2.0_f32.powi(-24), 65_504.0]
    );
}

#[test]
fn a_number_goes_to_the_nearest() {
    for bits in 0..0x7bff_u16 {
        let (below, above) = (from_half(bits), from_half(bits + 1));
        let middle = below + (above - below) / 2.0;
        let even = bits + (bits & 1);
        assert_eq!(to_half(middle), even);
        assert_eq!(to_half(f32::from_bits(middle.to_bits() - 1)), bits);
        assert_eq!(to_half(-f32::from_bits(middle.to_bits() + 1)), (bits + 1) | 0x8000);
    }
    assert_eq!(to_half(1e30), 0x7bff);
}
