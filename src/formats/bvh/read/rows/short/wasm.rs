//! Sixteen bytes in a WebAssembly vector.

use std::arch::wasm32::{
    i8x16_bitmask, i8x16_eq, i8x16_gt, i8x16_lt, i8x16_splat, i8x16_swizzle, i16x8_add, i16x8_mul, i16x8_narrow_i32x4,
    i16x8_splat, i32x4_dot_i16x8, i32x4_extract_lane, i32x4_splat, u8x16_splat, u8x16_sub_sat, u16x8_shr, u64x2, v128,
    v128_and,
};

#[inline(always)]
pub(super) fn load(bytes: &[u8; 16]) -> v128 {
    let [low, high]: [[u8; 8]; 2] = bytemuck::cast(*bytes);
    u64x2(u64::from_le_bytes(low), u64::from_le_bytes(high))
}

/// One bit for each byte, the first byte first: whether the byte, as a signed number, is below a limit.
#[inline(always)]
pub(super) fn bits_below(bytes: v128, limit: i8) -> u32 {
    i8x16_bitmask(i8x16_lt(bytes, i8x16_splat(limit))).into()
}

/// A mask of the bytes above a limit.
#[inline(always)]
pub(super) fn bits_above(bytes: v128, limit: i8) -> u32 {
    i8x16_bitmask(i8x16_gt(bytes, i8x16_splat(limit))).into()
}

/// A mask of the bytes equal to a value.
#[inline(always)]
pub(super) fn bits_equal(bytes: v128, byte: i8) -> u32 {
    i8x16_bitmask(i8x16_eq(bytes, i8x16_splat(byte))).into()
}

/// Saturating differences of unsigned bytes: zero instead of a negative result.
#[inline(always)]
pub(super) fn minus_or_zero(bytes: v128, byte: u8) -> v128 {
    u8x16_sub_sat(bytes, u8x16_splat(byte))
}

/// The numbers of the first eight and the last eight of sixteen digits. `order` selects the digits from `values`; an
/// index with its highest bit set gives zero.
#[inline(always)]
pub(super) fn eight_digits(values: v128, order: &[u8; 16]) -> [u32; 2] {
    let digits = i8x16_swizzle(values, load(order));
    // Combines neighbours: digits to pairs, pairs to fours, fours to eights.
    let tens = i16x8_mul(v128_and(digits, i16x8_splat(0xff)), i16x8_splat(10));
    let pairs = i16x8_add(tens, u16x8_shr(digits, 8));
    let fours = i32x4_dot_i16x8(pairs, i32x4_splat(0x1_0064));
    let eights = i32x4_dot_i16x8(i16x8_narrow_i32x4(fours, fours), i32x4_splat(0x1_2710));
    [
        i32x4_extract_lane::<0>(eights) as u32,
        i32x4_extract_lane::<1>(eights) as u32,
    ]
}
