//! A cube root that is equal on every machine.

/// The number to add to a third of a number's bits, for a first guess of the cube root within 4 % (W. Kahan, as in
/// FreeBSD's `cbrt`).
const THIRD: u64 = 715_094_163 << 32;

/// The number of iterations of Newton's method, each of which doubles the digits.
const STEPS: usize = 5;

/// The cube root of a finite number above 0. The cube root of the standard library differs in its last bit in
/// WebAssembly, which would change the choice of keys.
pub fn cube_root(value: f32) -> f32 {
    let value = f64::from(value);
    let mut root = f64::from_bits(value.to_bits() / 3 + THIRD);
    for _ in 0..STEPS {
        root -= (root * root * root - value) / (3.0 * root * root);
    }
    root as f32
}
