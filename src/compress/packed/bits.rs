//! Numbers of a few bits each, the lowest bit first.

/// Bytes after the last bits of a file, so that eight bytes can be read anywhere.
pub(super) const PADDING: usize = 8;

/// The 57 bits or more at bit `at`; 0 beyond the end.
#[inline(always)]
pub(super) fn bits_at(bytes: &[u8], at: usize) -> u64 {
    let eight = bytes.get(at / 8..).and_then(|rest| rest.first_chunk::<8>());
    eight.map_or(0, |eight| u64::from_le_bytes(*eight)) >> (at % 8)
}

/// The lowest `count` bits of `value`, of at most 32.
#[inline(always)]
pub(super) fn lowest(value: u64, count: u32) -> u32 {
    (value & ((1 << count) - 1)) as u32
}

/// How many bits the numbers up to `largest` take.
pub(super) fn width(largest: u32) -> u32 {
    u32::BITS - largest.leading_zeros()
}

/// Appends numbers of a few bits each.
#[derive(Default)]
pub(super) struct BitWriter {
    pub(super) bytes: Vec<u8>,
    pending: u64,
    /// How many bits are pending: fewer than 8.
    count: u32,
}

impl BitWriter {
    /// Appends the lowest `count` bits of `value`, at most 32.
    pub(super) fn push(&mut self, value: u32, count: u32) {
        self.pending |= u64::from(lowest(value.into(), count)) << self.count;
        self.count += count;
        while self.count >= 8 {
            self.bytes.push(self.pending as u8);
            self.pending >>= 8;
            self.count -= 8;
        }
    }

    /// Fills the last byte.
    pub(super) fn align(&mut self) {
        if self.count > 0 {
            self.push(0, 8 - self.count);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
