//! Numbers of a few bits each, the lowest bit first.

/// Bytes after the last bits of a file, so that eight bytes can be read anywhere.
pub const PADDING: usize = 8;

/// The 57 bits or more at bit `at`; 0 beyond the end.
#[inline(always)]
pub fn bits_at(bytes: &[u8], at: usize) -> u64 {
    let eight = bytes.get(at / 8..).and_then(|rest| rest.first_chunk::<8>());
    eight.map_or(0, |eight| u64::from_le_bytes(*eight)) >> (at % 8)
}

/// The lowest `count` bits of `value`, of at most 32.
#[inline(always)]
pub fn lowest(value: u64, count: u32) -> u32 {
    (value & ((1 << count) - 1)) as u32
}

/// How many bits the numbers up to `largest` take.
pub fn width(largest: u32) -> u32 {
    u32::BITS - largest.leading_zeros()
}

/// Appends numbers of a few bits each.
#[derive(Default)]
pub struct BitWriter {
    pub bytes: Vec<u8>,
    pending: u64,
    /// How many bits are pending: fewer than 8.
    count: u32,
}

impl BitWriter {
    /// Appends the lowest `count` bits of `value`, at most 32.
    pub fn push(&mut self, value: u32, count: u32) {
        self.pending |= u64::from(lowest(value.into(), count)) << self.count;
        self.count += count;
        while self.count >= 8 {
            self.bytes.push(self.pending as u8);
            self.pending >>= 8;
            self.count -= 8;
        }
    }

    /// Fills the last byte.
    pub fn align(&mut self) {
        if self.count > 0 {
            self.push(0, 8 - self.count);
        }
    }
}
