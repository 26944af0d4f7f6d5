//! Bytes of C3D.

use mocap_formats::internals::c3d::Processor;

#[test]
fn one_is_one_on_every_processor() {
    // The VAX's 1.0 is 0.1 in binary times 2^1, its exponent in excess of 128: 0x4080 in the first word.
    assert_eq!(Processor::Dec.real([0x80, 0x40, 0, 0]), 1.0);
    // -12.5 is -0.11001 in binary times 2^4.
    assert_eq!(Processor::Dec.real([0x48, 0xC2, 0, 0]), -12.5);
    assert_eq!(Processor::Intel.real([0, 0, 0x80, 0x3F]), 1.0);
    assert_eq!(Processor::Sgi.real([0x3F, 0x80, 0, 0]), 1.0);
    assert_eq!(Processor::Dec.real([0, 0, 0, 0]), 0.0);
    assert_eq!(Processor::Sgi.word([1, 2]), 0x0102);
    assert_eq!(Processor::Dec.word([1, 2]), 0x0201);
}
