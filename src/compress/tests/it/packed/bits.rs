//! Tests that bit-packed numbers are read as they were written.

use mocap_compress::internals::bits::{BitWriter, PADDING, bits_at, lowest, width};

#[test]
fn what_was_written_is_read() {
    let numbers = [(1, 1), (0, 0), (0x1234, 16), (5, 3), (u32::MAX, 32), (0, 7), (77, 7)];
    let mut writer = BitWriter::default();
    for (value, count) in numbers {
        writer.push(value, count);
    }
    writer.align();
    let mut bytes = writer.bytes;
    assert_eq!(bytes.len(), 9);
    bytes.extend([0; PADDING]);
    let mut at = 0;
    for (value, count) in numbers {
        assert_eq!(lowest(bits_at(&bytes, at), count), value);
        at += count as usize;
    }
    assert_eq!(bits_at(&bytes, 8 * bytes.len()), 0);
    assert_eq!([0, 1, 2, 255, 256].map(width), [0, 1, 2, 8, 9]);
}
