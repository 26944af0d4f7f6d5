//! Numbers as C++ streams print them.

use std::fmt;

/// Prints a number like `std::cout << x` with default settings, which is C's `%g`: six significant digits, no trailing
/// zeros, an exponent below 0.0001 and at 1000000 or more.
pub struct StreamNumber<T>(pub T);

impl fmt::Display for StreamNumber<f32> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        StreamNumber(f64::from(self.0)).fmt(f)
    }
}

impl fmt::Display for StreamNumber<f64> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(number) = *self;
        let sign = if number.is_sign_negative() { "-" } else { "" };
        if number.is_nan() {
            return write!(f, "{sign}nan");
        }
        if number.is_infinite() {
            return write!(f, "{sign}inf");
        }
        // Rounding to six digits can carry into the next power of ten, so read the exponent afterwards.
        let rounded = format!("{number:.5e}");
        let (digits, exponent) = rounded.split_once('e').unwrap_or((&rounded, "0"));
        let exponent: i32 = exponent.parse().unwrap_or(0);
        if (-4..6).contains(&exponent) {
            let decimals = (5 - exponent).unsigned_abs() as usize;
            f.write_str(without_trailing_zeros(&format!("{number:.decimals$}")))
        } else {
            let exponent_sign = if exponent < 0 { '-' } else { '+' };
            let digits = without_trailing_zeros(digits);
            write!(f, "{digits}e{exponent_sign}{:02}", exponent.unsigned_abs())
        }
    }
}

fn without_trailing_zeros(number: &str) -> &str {
    if number.contains('.') {
        number.trim_end_matches('0').trim_end_matches('.')
    } else {
        number
    }
}
