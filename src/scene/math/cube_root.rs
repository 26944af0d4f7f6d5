//! The cube root, the same on every machine.

/// The bits of a third of the exponent of 1, for a first guess within 4 %: W. Kahan's, as in FreeBSD's `cbrt`.
const THIRD: u64 = 715_094_163 << 32;

/// Steps of Newton's method, each of which doubles the digits.
const STEPS: usize = 5;

/// The cube root of a number that is finite and above 0. That of the standard library is another in its last bit in
/// WebAssembly, and then another key is left out.
pub fn cube_root(value: f32) -> f32 {
    let value = f64::from(value);
    let mut root = f64::from_bits(value.to_bits() / 3 + THIRD);
    for _ in 0..STEPS {
        root -= (root * root * root - value) / (3.0 * root * root);
    }
    root as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_nearest_number() {
        for value in [1e-38_f32, 1e-20, 3e-7, 0.001, 0.5, 1.0, 2.0, 27.0, 1e6, 3e38] {
            let expected = f64::from(value).cbrt() as f32;
            assert_eq!(cube_root(value).to_bits(), expected.to_bits(), "{value}");
        }
    }
}
