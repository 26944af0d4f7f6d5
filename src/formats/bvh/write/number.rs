//! Writes numbers as decimal text.

use std::fmt::Write;

/// The largest number of decimals of a double of usual size.
const MOST_DECIMALS: usize = 17;

/// Appends `value` with `digits` decimals, or with as many as are needed to read it back.
pub fn push(text: &mut String, value: f64, digits: Option<usize>) {
    let start = text.len();
    // Writing to a string cannot fail.
    let _ = match digits {
        Some(digits) => write!(text, "{value:.digits$}"),
        None => write!(text, "{value}"),
    };
    let is_minus_zero = text[start..]
        .strip_prefix('-')
        .is_some_and(|rest| rest.bytes().all(|byte| matches!(byte, b'0' | b'.')));
    if is_minus_zero {
        text.remove(start);
    }
}

/// Like [`push`], for a number that is read back in single precision.
pub(super) fn push_single(text: &mut String, value: f32, digits: Option<usize>) {
    match digits {
        Some(_) => push(text, f64::from(value), digits),
        // Negative zero is written as zero.
        None => {
            let _ = write!(text, "{}", value + 0.0);
        }
    }
}

/// The values with the fewest decimals that `accepts` accepts. The unrounded values are tried last. `None` if `accepts`
/// accepts no values.
pub fn shortest<const N: usize>(values: [f64; N], accepts: impl Fn([f64; N]) -> bool) -> Option<[f64; N]> {
    roundings(values).find(|rounded| accepts(*rounded))
}

/// The values with no decimals, with one decimal, and so on, and last the unrounded values.
pub(super) fn roundings<const N: usize>(values: [f64; N]) -> impl Iterator<Item = [f64; N]> {
    let scales = std::iter::successors(Some(1.0), |scale| Some(scale * 10.0)).take(MOST_DECIMALS + 1);
    // A quotient of two integers is rounded once, so it is the double nearest to the decimal number.
    let rounded = scales.map(move |scale| values.map(|value| (value * scale).round() / scale));
    rounded.chain(std::iter::once(values))
}
