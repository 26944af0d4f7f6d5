//! Bit-packed numbers, lowest bit first.

/// Bytes after the last bits of a file, so that eight bytes can be read at any position.
pub const PADDING: usize = 8;

/// The bits from bit `at` on, at least 57 of them. Bits beyond the end of `bytes` are 0.
#[inline(always)]
pub fn bits_at(bytes: &[u8], at: usize) -> u64 {
    let eight = bytes.get(at / 8..).and_then(|rest| rest.first_chunk::<8>());
    eight.map_or(0, |eight| u64::from_le_bytes(*eight)) >> (at % 8)
}

/// The lowest `count` bits of `value`. `count` is at most 32.
#[inline(always)]
pub fn lowest(value: u64, count: u32) -> u32 {
    (value & ((1 << count) - 1)) as u32
}

/// The number of bits for numbers up to `largest`.
pub fn width(largest: u32) -> u32 {
    u32::BITS - largest.leading_zeros()
}

/// Appends bit-packed numbers.
#[derive(Default)]
pub struct BitWriter {
    pub bytes: Vec<u8>,
    pending: u64,
    /// The number of pending bits, below 8.
    count: u32,
}

impl BitWriter {
    /// Appends the lowest `count` bits of `value`. `count` is at most 32.
    pub fn push(&mut self, value: u32, count: u32) {
        self.pending |= u64::from(lowest(value.into(), count)) << self.count;
        self.count += count;
        while self.count >= 8 {
            self.bytes.push(self.pending as u8);
            self.pending >>= 8;
            self.count -= 8;
        }
    }

    /// Fills the last byte with zero bits.
    pub fn align(&mut self) {
        if self.count > 0 {
            self.push(0, 8 - self.count);
        }
    }
}
