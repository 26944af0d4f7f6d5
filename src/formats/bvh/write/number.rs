//! Numbers as decimal text.

use std::fmt::Write;

/// The largest number of decimals of a double precision number of usual size.
const MOST_DECIMALS: usize = 17;

/// Appends `value` with `digits` decimals, or with as many as are needed to read it back.
pub(super) fn push(text: &mut String, value: f64, digits: Option<usize>) {
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

/// As [`push`], for a number that is read back in single precision.
pub(super) fn push_single(text: &mut String, value: f32, digits: Option<usize>) {
    match digits {
        Some(_) => push(text, f64::from(value), digits),
        // A negative zero is a zero.
        None => {
            let _ = write!(text, "{}", value + 0.0);
        }
    }
}

/// The values with the fewest decimals that `accepts` returns true for; the unrounded values are tried last. `None` if
/// it accepts none.
pub(super) fn shortest<const N: usize>(values: [f64; N], accepts: impl Fn([f64; N]) -> bool) -> Option<[f64; N]> {
    let mut scale = 1.0;
    for _ in 0..=MOST_DECIMALS {
        // A quotient of two whole numbers is rounded once, so it is the number that the decimals denote.
        let rounded = values.map(|value| (value * scale).round() / scale);
        if accepts(rounded) {
            return Some(rounded);
        }
        scale *= 10.0;
    }
    accepts(values).then_some(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_decimals_asked_for_or_needed() {
        let printed = |value, digits| {
            let mut text = String::new();
            push(&mut text, value, digits);
            text
        };
        assert_eq!(printed(1.0, None), "1");
        assert_eq!(printed(-0.0, None), "0");
        assert_eq!(printed(0.1 + 0.2, None), "0.30000000000000004");
        assert_eq!(printed(-12.3456, Some(2)), "-12.35");
        assert_eq!(printed(-0.001, Some(2)), "0.00");
    }

    #[test]
    fn the_shortest_spelling_is_the_first_that_will_do() {
        assert_eq!(
            shortest([0.300_000_000_000_01], |[value]| (value - 0.3).abs() < 1e-9),
            Some([0.3])
        );
        assert_eq!(shortest([1.0 / 3.0], |[value]| value == 1.0 / 3.0), Some([1.0 / 3.0]));
        assert_eq!(shortest([1.0], |_| false), None);
    }
}
