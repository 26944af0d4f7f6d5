//! 16-bit floats, IEEE 754's binary16: 11 significant bits, up to 65,504.

/// The largest 16-bit float: (2 - 2^-10) 2^15.
pub const MOST: f32 = 65_504.0;
/// The number of mantissa bits that a 32-bit float has and a 16-bit float lacks.
const DROPPED: u32 = 13;
/// The difference between the exponent biases of 32-bit and 16-bit floats, shifted to the exponent's bits.
const REBIAS: u32 = (127 - 15) << 23;
/// The smallest normal 16-bit number: 2^-14.
const LEAST_NORMAL: f32 = 6.103_515_6e-5;
/// The factor that makes a subnormal 16-bit number whole: 2^24.
const SUBNORMAL: f32 = 16_777_216.0;

/// The 16-bit float nearest to a finite number. Of two equally near floats, it is the one with an even mantissa. Above
/// [`MOST`], it is [`MOST`].
pub fn to_half(value: f32) -> u16 {
    let sign = (value.to_bits() >> 16) as u16 & 0x8000;
    let magnitude = value.abs().min(MOST);
    if magnitude < LEAST_NORMAL {
        return sign | (magnitude * SUBNORMAL).round_ties_even() as u16;
    }
    let bits = magnitude.to_bits();
    let odd = (bits >> DROPPED) & 1;
    let rounded = bits + (1 << (DROPPED - 1)) - 1 + odd;
    sign | ((rounded - REBIAS) >> DROPPED) as u16
}

/// The number that the 16 bits represent.
pub fn from_half(bits: u16) -> f32 {
    let (exponent, mantissa) = ((bits >> 10) & 31, u32::from(bits & 0x3ff));
    let magnitude = match exponent {
        0 => mantissa as f32 / SUBNORMAL,
        31 if mantissa == 0 => f32::INFINITY,
        31 => f32::NAN,
        _ => f32::from_bits((u32::from(exponent) << 23 | mantissa << DROPPED) + REBIAS),
    };
    if bits & 0x8000 == 0 { magnitude } else { -magnitude }
}
