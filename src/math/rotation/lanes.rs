//! Euler angles to quaternions, some frames at a time.
//!
//! Every step is a loop over lanes without branches, which the compiler turns into vector instructions.

use glam::Quat;

use super::Axis;

/// Frames that are turned into quaternions together.
const LANES: usize = 8;

/// One number a frame.
type Lanes = [f64; LANES];

/// Fills `keys` with the rotations that some columns of degrees stand for, one a frame: about each axis in turn, each
/// axis turned by the rotations before it, `R = R1 R2 R3` as matrices on column vectors. Without columns nothing turns.
pub(crate) fn fill(columns: &[(Axis, &[f64])], keys: &mut [Quat]) {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the processor was asked, and has these instructions.
        #[allow(
            unsafe_code,
            reason = "twice as fast, and nothing else differs: `tools/bench/README.md`"
        )]
        return unsafe { fill_with_avx2(columns, keys) };
    }
    fill_lanes(columns, keys);
}

/// The same code with vectors of four lanes in place of two. Sums and products are not fused, so that every processor
/// gives the same bits.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn fill_with_avx2(columns: &[(Axis, &[f64])], keys: &mut [Quat]) {
    fill_lanes(columns, keys);
}

// Everything from here on is inlined, because a function of its own would not be compiled for the wider vectors.
#[inline(always)]
fn fill_lanes(columns: &[(Axis, &[f64])], keys: &mut [Quat]) {
    let frames = keys.len();
    for (keys, start) in keys.chunks_mut(LANES).zip((0..).step_by(LANES)) {
        let mut rotations = Rotations::IDENTITY;
        if let Some((&(axis, column), others)) = columns.split_first() {
            rotations.begin(axis, lanes(&column[start..frames]));
            for &(axis, column) in others {
                rotations.rotate(axis, lanes(&column[start..frames]));
            }
        }
        if let Ok(keys) = <&mut [Quat; LANES]>::try_from(&mut *keys) {
            rotations.store(keys);
        } else {
            let mut all = [Quat::IDENTITY; LANES];
            rotations.store(&mut all);
            keys.copy_from_slice(&all[..keys.len()]);
        }
    }
}

/// The first values of a column, or all and zeros.
#[inline(always)]
fn lanes(column: &[f64]) -> Lanes {
    column.first_chunk().copied().unwrap_or_else(|| {
        let mut lanes = [0.0; LANES];
        lanes[..column.len()].copy_from_slice(column);
        lanes
    })
}

/// A value for every lane. Unlike the standard library's `from_fn` it is inlined here, and becomes vector instructions.
#[inline(always)]
fn of_lanes(value: impl Fn(usize) -> f64) -> Lanes {
    let mut lanes = [0.0; LANES];
    for (lane, to) in lanes.iter_mut().enumerate() {
        *to = value(lane);
    }
    lanes
}

/// Quaternions, component by component.
struct Rotations {
    x: Lanes,
    y: Lanes,
    z: Lanes,
    w: Lanes,
}

impl Rotations {
    const IDENTITY: Self = Self {
        x: [0.0; LANES],
        y: [0.0; LANES],
        z: [0.0; LANES],
        w: [1.0; LANES],
    };

    /// Turns the identity, which is what multiplying would come to.
    #[inline(always)]
    fn begin(&mut self, axis: Axis, degrees: Lanes) {
        let (sin, cos) = sin_cos_of_half(degrees);
        *match axis {
            Axis::X => &mut self.x,
            Axis::Y => &mut self.y,
            Axis::Z => &mut self.z,
        } = sin;
        self.w = cos;
    }

    /// Multiplies by `cos(a/2) + sin(a/2) axis` from the right.
    #[inline(always)]
    fn rotate(&mut self, axis: Axis, degrees: Lanes) {
        let (sin, cos) = sin_cos_of_half(degrees);
        // The products of i, j and k are the same for every axis but for a cyclic change of names: `about` is the
        // axis, `next` and `last` the two that follow it.
        let (about, next, last) = match axis {
            Axis::X => (&mut self.x, &mut self.y, &mut self.z),
            Axis::Y => (&mut self.y, &mut self.z, &mut self.x),
            Axis::Z => (&mut self.z, &mut self.x, &mut self.y),
        };
        // Copies, because the compiler does not see that the three references are to three arrays.
        let (a, n, l, w) = (*about, *next, *last, self.w);
        *about = of_lanes(|i| a[i] * cos[i] + w[i] * sin[i]);
        *next = of_lanes(|i| n[i] * cos[i] + l[i] * sin[i]);
        *last = of_lanes(|i| l[i] * cos[i] - n[i] * sin[i]);
        self.w = of_lanes(|i| w[i] * cos[i] - a[i] * sin[i]);
    }

    /// Of a rotation's two quaternions, the one that Assimp takes.
    ///
    /// Assimp makes the quaternion of the rotation matrix: `w` is positive where the matrix's trace is, which is where
    /// `|w| > 1/2`; else the component of the largest diagonal element is positive, which is the largest of `x`, `y`,
    /// `z`.
    #[inline(always)]
    fn store(&self, keys: &mut [Quat; LANES]) {
        let mut components = [[0.0_f32; LANES]; 4];
        for lane in 0..LANES {
            let (x, y, z, w) = (self.x[lane], self.y[lane], self.z[lane], self.w[lane]);
            let (xx, yy, zz) = (x * x, y * y, z * z);
            let of_yz = if yy > zz { y } else { z };
            let of_xyz = if (xx > yy) & (xx > zz) { x } else { of_yz };
            let positive = if 3.0 * w * w > xx + yy + zz { w } else { of_xyz };
            let sign = if positive < 0.0 { -1.0 } else { 1.0 };
            for (to, component) in components.iter_mut().zip([x, y, z, w]) {
                // Adding zero turns the minus zeros of a rotation about a single axis into zeros.
                to[lane] = (component * sign + 0.0) as f32;
            }
        }
        let [x, y, z, w] = components;
        for lane in 0..LANES {
            keys[lane] = Quat::from_xyzw(x[lane], y[lane], z[lane], w[lane]);
        }
    }
}

/// The sine and cosine of half an angle in degrees, each within 1e-15 of the exact value. A key is a 32-bit float, whose
/// rounding is far coarser; but a file that is written from keys reads back to the very same keys only if the angles
/// found for them do not come to stand on the other side of a rounding.
///
/// Degrees can be brought near zero without an error: `half - 90 n` is exact in binary floating point, where the same
/// step in radians would need many digits of pi. What is left, at most 45 degrees, goes into the Taylor polynomials of
/// degree 15 and 16, whose next terms are 4.7e-17 and 2.1e-18 there.
#[inline(always)]
fn sin_cos_of_half(mut degrees: Lanes) -> (Lanes, Lanes) {
    /// Adding it rounds to a whole number, which then stands in the low bits.
    const ROUND: f64 = 1.5 * (1_u64 << 52) as f64;
    /// Beyond it `90 n` might not be exact.
    const LARGEST: f64 = 1e9;
    // All lanes are looked at, for a loop that may end early is no vector instruction.
    if degrees.iter().fold(false, |any, angle| any | (angle.abs() > LARGEST)) {
        degrees = without_whole_turns(degrees);
    }
    let (mut sin, mut cos) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        let half = 0.5 * degrees[lane];
        let rounded = half * (1.0 / 90.0) + ROUND;
        let quarters = rounded.to_bits();
        let x = (half - 90.0 * (rounded - ROUND)).to_radians();
        let (s, c) = (sin_near_zero(x).to_bits(), cos_near_zero(x).to_bits());
        // An odd number of quarter turns swaps the two, and every second one changes a sign.
        let swap = (quarters & 1).wrapping_neg();
        let sin_sign = (quarters & 2) << 62;
        let cos_sign = (quarters.wrapping_add(1) & 2) << 62;
        sin[lane] = f64::from_bits(((s & !swap) | (c & swap)) ^ sin_sign);
        cos[lane] = f64::from_bits(((c & !swap) | (s & swap)) ^ cos_sign);
    }
    (sin, cos)
}

/// Out of the way, because no real file has such angles.
#[cold]
#[inline(never)]
fn without_whole_turns(degrees: Lanes) -> Lanes {
    degrees.map(|angle| angle % 720.0)
}

/// `x - x^3/3! + x^5/5! - ...`
#[inline(always)]
fn sin_near_zero(x: f64) -> f64 {
    const TERMS: [f64; 7] = [
        -1.0 / 6.0,
        1.0 / 120.0,
        -1.0 / 5_040.0,
        1.0 / 362_880.0,
        -1.0 / 39_916_800.0,
        1.0 / 6_227_020_800.0,
        -1.0 / 1_307_674_368_000.0,
    ];
    let square = x * x;
    x + x * square * polynomial(TERMS, square)
}

/// The even and the odd powers by themselves, two chains of sums that need not wait for each other.
#[inline(always)]
fn polynomial<const N: usize>(terms: [f64; N], x: f64) -> f64 {
    let square = x * x;
    let (mut even, mut odd) = (0.0, 0.0);
    for power in (0..N).rev() {
        let sum = if power % 2 == 0 { &mut even } else { &mut odd };
        *sum = *sum * square + terms[power];
    }
    even + x * odd
}

/// `1 - x^2/2! + x^4/4! - ...`
#[inline(always)]
fn cos_near_zero(x: f64) -> f64 {
    const TERMS: [f64; 8] = [
        -1.0 / 2.0,
        1.0 / 24.0,
        -1.0 / 720.0,
        1.0 / 40_320.0,
        -1.0 / 3_628_800.0,
        1.0 / 479_001_600.0,
        -1.0 / 87_178_291_200.0,
        1.0 / 20_922_789_888_000.0,
    ];
    let square = x * x;
    1.0 + square * polynomial(TERMS, square)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rotation::{from_euler, with_assimp_sign};

    fn key(rotations: &[(Axis, f64)]) -> Quat {
        let columns: Vec<(Axis, &[f64])> = rotations
            .iter()
            .map(|(axis, angle)| (*axis, std::slice::from_ref(angle)))
            .collect();
        let mut keys = [Quat::NAN];
        fill(&columns, &mut keys);
        keys[0]
    }

    #[test]
    fn a_key_is_that_of_one_rotation_after_the_other() {
        let mut angle = 0.0;
        for order in [
            [0, 1, 2],
            [0, 2, 1],
            [1, 0, 2],
            [1, 2, 0],
            [2, 0, 1],
            [2, 1, 0],
            [2, 2, 0],
        ] {
            for _ in 0..5_000 {
                let rotations = order.map(|axis| {
                    // No fraction of a turn, so that every part of the circle is met.
                    angle += 0.377;
                    (Axis::ALL[axis], angle % 1_000.0 - 500.0)
                });
                let expected = with_assimp_sign(from_euler(rotations.into_iter()));
                // Half a unit in the last place, and once more where the two fall on different sides of a rounding.
                assert!(
                    key(&rotations).abs_diff_eq(expected, f32::EPSILON / 2.0),
                    "{rotations:?}"
                );
            }
        }
    }

    #[test]
    fn sine_and_cosine_are_those_of_the_standard_library() {
        for step in -200_000..=200_000 {
            // 0.37 degrees are no fraction of a turn, so that every part of the circle is met.
            let degrees: Lanes = of_lanes(|lane| f64::from(step) * 0.37 + lane as f64 * 0.043);
            let (sin, cos) = sin_cos_of_half(degrees);
            for lane in 0..LANES {
                // In -360 to 360, without an error; as radians it is rounded twice, by 7e-16 at most.
                let angle = degrees[lane] - 720.0 * (degrees[lane] / 720.0).round();
                let (expected_sin, expected_cos) = (0.5 * angle).to_radians().sin_cos();
                assert!((sin[lane] - expected_sin).abs() < 1e-15, "{}", degrees[lane]);
                assert!((cos[lane] - expected_cos).abs() < 1e-15, "{}", degrees[lane]);
            }
        }
    }

    #[test]
    fn whole_quarter_turns_are_exact() {
        for (degrees, expected) in [
            (0.0, (0.0, 1.0)),
            (180.0, (1.0, 0.0)),
            (360.0, (0.0, -1.0)),
            (-180.0, (-1.0, 0.0)),
            (540.0, (-1.0, 0.0)),
            (720e9 + 180.0, (1.0, 0.0)),
            (720.0, (0.0, 1.0)),
        ] {
            let (sin, cos) = sin_cos_of_half([degrees; LANES]);
            assert_eq!((sin[0], cos[0]), expected, "{degrees}");
        }
    }

    #[test]
    fn angles_of_any_size_give_rotations() {
        for angle in [1e9, 1e12, -3.4e38, 1e-300, -0.0] {
            let rotation = key(&[(Axis::X, angle), (Axis::Y, angle), (Axis::Z, angle)]);
            assert!(rotation.is_normalized(), "{angle}: {rotation}");
        }
    }

    #[test]
    fn wider_vectors_give_the_same_bits() {
        let column: Vec<f64> = (0..1003).map(|frame| f64::from(frame) * 1.37 - 700.0).collect();
        let columns: [(Axis, &[f64]); 3] = [(Axis::Z, &column), (Axis::X, &column[1..]), (Axis::Y, &column[2..])];
        let (mut here, mut anywhere) = ([Quat::NAN; 1001], [Quat::NAN; 1001]);
        fill(&columns, &mut here);
        fill_lanes(&columns, &mut anywhere);
        assert_eq!(here, anywhere);
    }

    #[test]
    fn a_key_does_not_depend_on_its_neighbours() {
        let column: Vec<f64> = (0..37).map(|frame| f64::from(frame) * 33.3).collect();
        let mut together = vec![Quat::NAN; column.len()];
        fill(&[(Axis::Y, &column), (Axis::X, &column)], &mut together);
        let alone: Vec<Quat> = column
            .iter()
            .map(|&angle| key(&[(Axis::Y, angle), (Axis::X, angle)]))
            .collect();
        assert_eq!(together, alone);
    }
}
