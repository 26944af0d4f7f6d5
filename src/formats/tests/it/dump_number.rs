//! Tests that numbers are printed as C++ streams print them.

use mocap_formats::internals::StreamNumber;
use proptest::prelude::*;

/// Each number with the output of `printf("%g")` of glibc 2.36.
const PRINTED: &[(f64, &str)] = &[
    (0.0, "0"),
    (-0.0, "-0"),
    (1.0, "1"),
    (-1.0, "-1"),
    (0.1, "0.1"),
    (0.0436194, "0.0436194"),
    (0.087155744, "0.0871557"),
    (123456.0, "123456"),
    (999999.0, "999999"),
    (999999.5, "1e+06"),
    (1000000.0, "1e+06"),
    (123456.7, "123457"),
    (1234567.0, "1.23457e+06"),
    (0.0001, "0.0001"),
    (9.999995e-5, "0.0001"),
    (9.9999949e-5, "9.99999e-05"),
    (1e-5, "1e-05"),
    (1.5e-7, "1.5e-07"),
    (3.5, "3.5"),
    (-2.25, "-2.25"),
    (1e100, "1e+100"),
    (1e-100, "1e-100"),
    (1.7976931348623157e308, "1.79769e+308"),
    (5e-324, "4.94066e-324"),
    (0.5, "0.5"),
    (2.5, "2.5"),
    (100000.5, "100000"),
    (100001.5, "100002"),
    (1000005.0, "1e+06"),
    (1000015.0, "1.00002e+06"),
    (0.3, "0.3"),
    (9.9999951, "10"),
    (9.99999, "9.99999"),
    (9.99999985, "10"),
    (1e22, "1e+22"),
    (16777216.0, "1.67772e+07"),
    (3.4028235e38, "3.40282e+38"),
    (1e-45, "1e-45"),
    (4294967295.0, "4.29497e+09"),
    (120.000477, "120"),
    (33.333333333, "33.3333"),
    (0.15625, "0.15625"),
    (1.000005, "1.00001"),
];

#[test]
fn numbers_print_as_printf_prints_them() {
    for (number, expected) in PRINTED {
        assert_eq!(StreamNumber(*number).to_string(), *expected);
    }
    assert_eq!(StreamNumber(f64::NAN.copysign(1.0)).to_string(), "nan");
    assert_eq!(StreamNumber(f64::NAN.copysign(-1.0)).to_string(), "-nan");
    assert_eq!(StreamNumber(f32::INFINITY).to_string(), "inf");
    assert_eq!(StreamNumber(f32::NEG_INFINITY).to_string(), "-inf");
}

proptest! {
    /// Checks the text against the C standard's definition of `%g`.
    #[test]
    fn six_digits_say_what_the_number_is(digits in 1.0..10.0f64, exponent in -40..40, negative: bool) {
        // Digits near zero would give numbers so small that the powers of ten below are not exact enough.
        let number = if negative { -digits } else { digits } * 10f64.powi(exponent);
        let text = StreamNumber(number).to_string();
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, ""));
        let significant = digits.trim_start_matches(['-', '0', '.']).replace('.', "");
        prop_assert!(significant.len() <= 6, "{text}");
        prop_assert!(!digits.contains('.') || !digits.ends_with(['0', '.']), "{text}");

        let read: f64 = text.parse().unwrap();
        let size = read.abs();
        prop_assert_eq!(exponent.is_empty(), (1e-4..1e6).contains(&size), "{}", text);
        prop_assert!(exponent.is_empty() || exponent.len() >= 3, "{text}");
        // The limit is half a unit of the sixth digit, which is at least a millionth of the number.
        prop_assert!((read - number).abs() <= 0.500_001 * 10f64.powi(size.log10().floor() as i32 - 5), "{text}");
    }
}
