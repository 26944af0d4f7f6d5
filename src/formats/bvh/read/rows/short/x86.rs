//! Sixteen bytes in an SSE4.1 vector.

use std::arch::x86_64::{
    __m128i, _mm_cmpeq_epi8, _mm_cmpgt_epi8, _mm_cmplt_epi8, _mm_cvtsi128_si64, _mm_madd_epi16, _mm_maddubs_epi16,
    _mm_movemask_epi8, _mm_packus_epi32, _mm_set_epi64x, _mm_set1_epi8, _mm_set1_epi16, _mm_set1_epi32,
    _mm_shuffle_epi8, _mm_subs_epu8,
};

#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn load(bytes: &[u8; 16]) -> __m128i {
    let [low, high]: [[u8; 8]; 2] = bytemuck::cast(*bytes);
    _mm_set_epi64x(i64::from_le_bytes(high), i64::from_le_bytes(low))
}

/// One bit for each byte, the first byte first: whether the byte, as a signed number, is below a limit.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn bits_below(bytes: __m128i, limit: i8) -> u32 {
    _mm_movemask_epi8(_mm_cmplt_epi8(bytes, _mm_set1_epi8(limit))) as u32
}

/// A mask of the bytes above a limit.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn bits_above(bytes: __m128i, limit: i8) -> u32 {
    _mm_movemask_epi8(_mm_cmpgt_epi8(bytes, _mm_set1_epi8(limit))) as u32
}

/// A mask of the bytes equal to a value.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn bits_equal(bytes: __m128i, byte: i8) -> u32 {
    _mm_movemask_epi8(_mm_cmpeq_epi8(bytes, _mm_set1_epi8(byte))) as u32
}

/// Saturating differences of unsigned bytes: zero instead of a negative result.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn minus_or_zero(bytes: __m128i, byte: u8) -> __m128i {
    _mm_subs_epu8(bytes, _mm_set1_epi8(byte as i8))
}

/// The numbers of the first eight and the last eight of sixteen digits. `order` selects the digits from `values`; an
/// index with its highest bit set gives zero.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn eight_digits(values: __m128i, order: &[u8; 16]) -> [u32; 2] {
    // Combines neighbours: digits to pairs, pairs to fours, fours to eights.
    let pairs = _mm_maddubs_epi16(_mm_shuffle_epi8(values, load(order)), _mm_set1_epi16(0x01_0a));
    let fours = _mm_madd_epi16(pairs, _mm_set1_epi32(0x1_0064));
    let eights = _mm_madd_epi16(_mm_packus_epi32(fours, fours), _mm_set1_epi32(0x1_2710));
    let eights = _mm_cvtsi128_si64(eights) as u64;
    [eights as u32, (eights >> 32) as u32]
}
