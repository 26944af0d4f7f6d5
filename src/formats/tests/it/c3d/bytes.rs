//! Tests numbers of C3D in the byte orders of three processors.

use mocap_formats::internals::c3d::Processor;

#[test]
fn one_is_one_on_every_processor() {
    // In the VAX format, 1.0 is binary 0.1 times 2^1. Its exponent has an excess of 128, so the first word is 0x4080.
    assert_eq!(Processor::Dec.real([0x80, 0x40, 0, 0]), 1.0);
    // -12.5 is binary -0.11001 times 2^4.
    assert_eq!(Processor::Dec.real([0x48, 0xC2, 0, 0]), -12.5);
    assert_eq!(Processor::Intel.real([0, 0, 0x80, 0x3F]), 1.0);
    assert_eq!(Processor::Sgi.real([0x3F, 0x80, 0, 0]), 1.0);
    assert_eq!(Processor::Dec.real([0, 0, 0, 0]), 0.0);
    assert_eq!(Processor::Sgi.word([1, 2]), 0x0102);
    assert_eq!(Processor::Dec.word([1, 2]), 0x0201);
}
