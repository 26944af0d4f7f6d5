//! Parses short decimal numbers without a branch that depends on their lengths.
//!
//! The positions of a number's digits, point and end vary. So a parser that goes byte by byte mispredicts a branch at
//! about every second number. This parser examines 16 bytes at once, with SSE4.1 or WebAssembly vectors. It uses SSE4.1
//! on processors with AVX2, because [`wide`](mocap_scene::math::wide) requires AVX2.

#[cfg(target_arch = "wasm32")]
mod wasm;
#[cfg(target_arch = "x86_64")]
mod x86;

#[cfg(target_arch = "wasm32")]
use self::wasm as vector;
#[cfg(target_arch = "x86_64")]
use self::x86 as vector;

/// The number of examined bytes: a number of at most 15 bytes, including sign and point, and the byte after the number.
const WINDOW: usize = 16;

/// Powers of ten. These powers and integers of up to 15 digits are exact doubles, so the quotient of an integer and a
/// power is correctly rounded.
const POWERS: [f64; WINDOW] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
];

/// Shuffle indices by the positions of end and point. Digits are right-aligned, with leading zeros.
static DIGITS: [[[u8; WINDOW]; WINDOW]; WINDOW] = digits();

const fn digits() -> [[[u8; WINDOW]; WINDOW]; WINDOW] {
    /// The shuffle index that gives a zero.
    const ZERO: u8 = 0x80;
    let mut digits = [[[ZERO; WINDOW]; WINDOW]; WINDOW];
    let mut end = 0;
    while end < WINDOW {
        let mut point = 0;
        while point < WINDOW {
            let (mut from, mut to) = (end, WINDOW);
            while from > 0 {
                from -= 1;
                if from != point {
                    to -= 1;
                    digits[end][point][to] = from as u8;
                }
            }
            point += 1;
        }
        end += 1;
    }
    digits
}

/// The number at the start of a string, correctly rounded, and its length. The number consists of an optional `-`, of
/// digits, and of an optional point among the digits. A space or a line end follows. `None` for every other spelling,
/// and if the result may not be exact.
///
/// # Safety
/// On x86-64 the processor must have AVX2.
#[inline]
#[cfg_attr(target_arch = "x86_64", target_feature(enable = "avx2"))]
pub fn parse(text: &[u8]) -> Option<(f64, usize)> {
    let bytes = vector::load(text.first_chunk::<WINDOW>()?);
    // Comparisons are of signed bytes. Non-ASCII bytes are negative, so they end a number like a space.
    let ends = vector::bits_below(bytes, b' ' as i8 + 1);
    let minus = vector::bits_equal(bytes, b'-' as i8) & 1;
    let points = vector::bits_equal(bytes, b'.' as i8);
    let below_digits = vector::bits_below(bytes, b'0' as i8);
    // Sign and point become zeros.
    let values = vector::minus_or_zero(bytes, b'0');
    let above_digits = vector::bits_above(values, 9);

    let end_bit = ends & ends.wrapping_neg();
    let inside = end_bit.wrapping_sub(1);
    let others = below_digits & inside & !minus;
    let is_other = (above_digits & inside) | (others & !points) | (others & others.wrapping_sub(1));
    let has_point = u32::from(others != 0);
    let end = ends.trailing_zeros();
    let digits = end.wrapping_sub(minus + has_point);
    // Without an end the length is 32.
    if is_other != 0 || !(1..WINDOW as u32).contains(&digits) {
        return None;
    }
    let point = (others | end_bit).trailing_zeros();
    let order = &DIGITS[end as usize % WINDOW][point as usize % WINDOW];
    let [high, low] = vector::eight_digits(values, order);
    let whole = u64::from(high) * 100_000_000 + u64::from(low);
    let decimals = end - point - has_point;
    let value = whole as f64 / POWERS[decimals as usize % WINDOW];
    // Zero may be negative too.
    let value = f64::from_bits(value.to_bits() | u64::from(minus) << 63);
    Some((value, end as usize))
}
