//! Euler angles to quaternions, for several frames at a time.

use glam::Quat;

use super::Axis;
use crate::math::{soa, wide};

/// The number of frames that are converted together: two AVX2 vectors, or two WebAssembly vectors, which are half as
/// wide. Other numbers are slower: `tools/bench/README.md`.
pub const LANES: usize = if cfg!(target_family = "wasm") { 4 } else { 8 };

pub type Lanes = soa::Lanes<f64, LANES>;
type Quaternions = soa::Quaternions<f64, LANES>;

wide::dispatch! {
    /// Fills `keys` with one rotation for each frame, from columns of Euler angles in degrees about each axis in turn.
    /// Each axis is rotated by the rotations before it: `R = R1 R2 R3` as matrices on column vectors. Without columns
    /// the keys are identities.
    pub fn fill(columns: &[(Axis, &[f64])], keys: &mut [Quat]) {
        fill_lanes(columns, keys);
    }
}

#[inline(always)]
pub fn fill_lanes(columns: &[(Axis, &[f64])], keys: &mut [Quat]) {
    let frames = keys.len();
    for (keys, start) in keys.chunks_mut(LANES).zip((0..).step_by(LANES)) {
        let mut rotations = Quaternions::IDENTITY;
        if let Some((&(axis, column), others)) = columns.split_first() {
            begin(&mut rotations, axis, lanes(&column[start..frames]));
            for &(axis, column) in others {
                rotate(&mut rotations, axis, lanes(&column[start..frames]));
            }
        }
        if let Ok(keys) = <&mut [Quat; LANES]>::try_from(&mut *keys) {
            store(&rotations, keys);
        } else {
            let mut all = [Quat::IDENTITY; LANES];
            store(&rotations, &mut all);
            keys.copy_from_slice(&all[..keys.len()]);
        }
    }
}

/// The first values of a column, padded with zeros.
#[inline(always)]
fn lanes(column: &[f64]) -> Lanes {
    soa::Lanes(column.first_chunk().copied().unwrap_or_else(|| {
        let mut lanes = [0.0; LANES];
        lanes[..column.len()].copy_from_slice(column);
        lanes
    }))
}

/// Sets identities to the rotation about one axis: `cos(a/2) + sin(a/2) axis`.
#[inline(always)]
fn begin(rotations: &mut Quaternions, axis: Axis, degrees: Lanes) {
    let (sin, cos) = sin_cos_of_half(degrees);
    *match axis {
        Axis::X => &mut rotations.x,
        Axis::Y => &mut rotations.y,
        Axis::Z => &mut rotations.z,
    } = sin;
    rotations.w = cos;
}

/// Multiplies by the rotation about one axis, from the right.
#[inline(always)]
fn rotate(rotations: &mut Quaternions, axis: Axis, degrees: Lanes) {
    let (sin, cos) = sin_cos_of_half(degrees);
    let Quaternions { x, y, z, w } = rotations;
    // The products of i, j and k for the axes differ only by a cyclic permutation. `about` is the axis; `next` and
    // `last` are the two axes that follow it.
    let (about, next, last) = match axis {
        Axis::X => (x, y, z),
        Axis::Y => (y, z, x),
        Axis::Z => (z, x, y),
    };
    let (a, n, l, r) = (*about, *next, *last, *w);
    *about = Lanes::of(|i| a.0[i] * cos.0[i] + r.0[i] * sin.0[i]);
    *next = Lanes::of(|i| n.0[i] * cos.0[i] + l.0[i] * sin.0[i]);
    *last = Lanes::of(|i| l.0[i] * cos.0[i] - n.0[i] * sin.0[i]);
    *w = Lanes::of(|i| r.0[i] * cos.0[i] - a.0[i] * sin.0[i]);
}

/// Stores the rotations as keys, each with the sign that Assimp chooses.
/// Assimp makes the quaternion from the rotation matrix. `w` is positive if the matrix's trace is, that is if `|w| >
/// 1/2`. Otherwise the component of the largest diagonal element is positive, which is the largest of `x`, `y`, `z`.
#[inline(always)]
fn store(rotations: &Quaternions, keys: &mut [Quat; LANES]) {
    let mut components = [[0.0_f32; LANES]; 4];
    for lane in 0..LANES {
        let [x, y, z, w] = rotations.lane(lane);
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

/// The sine and cosine of half an angle in degrees, each within 1e-15 of the exact value. A key is a 32-bit float with
/// a much coarser rounding. But a file that is written from keys must read back to the same keys. So an error must not
/// move an angle across a rounding boundary.
///
/// Range reduction in degrees is exact: `half - 90 n` has no error in binary floating point, while radians would need
/// many digits of pi. The remainder, at most 45 degrees, goes into Taylor polynomials of degree 15 and 16. At 45
/// degrees, the next terms of the polynomials are 4.7e-17 and 2.1e-18.
#[inline(always)]
pub fn sin_cos_of_half(mut degrees: Lanes) -> (Lanes, Lanes) {
    /// Adding this number rounds to a whole number, which then occupies the low bits.
    const ROUND: f64 = 1.5 * (1_u64 << 52) as f64;

    /// The angle in degrees beyond which `90 n` might be inexact. The exact bound is 2^53 / 90, far above any angle in
    /// a file.
    const LARGEST: f64 = 1e9;
    // No early exit, so that the loop becomes vector instructions.
    if degrees.0.iter().fold(false, |any, angle| any | (angle.abs() > LARGEST)) {
        degrees = without_whole_turns(degrees);
    }
    let (mut sin, mut cos) = (Lanes::ZERO, Lanes::ZERO);
    for lane in 0..LANES {
        let half = 0.5 * degrees.0[lane];
        let rounded = half * (1.0 / 90.0) + ROUND;
        let quarters = rounded.to_bits();
        let x = (half - 90.0 * (rounded - ROUND)).to_radians();
        let (s, c) = (sin_near_zero(x).to_bits(), cos_near_zero(x).to_bits());
        // An odd number of quarter turns swaps sine and cosine, and every second one changes a sign.
        let swap = (quarters & 1).wrapping_neg();
        let sin_sign = (quarters & 2) << 62;
        let cos_sign = (quarters.wrapping_add(1) & 2) << 62;
        sin.0[lane] = f64::from_bits(((s & !swap) | (c & swap)) ^ sin_sign);
        cos.0[lane] = f64::from_bits(((c & !swap) | (s & swap)) ^ cos_sign);
    }
    (sin, cos)
}

/// Not inlined, because no real file has such angles.
#[cold]
#[inline(never)]
fn without_whole_turns(degrees: Lanes) -> Lanes {
    Lanes::of(|lane| degrees.0[lane] % 720.0)
}

/// `x - x^3/3! + x^5/5! - ...`
#[inline(always)]
fn sin_near_zero(x: f64) -> f64 {
    /// Coefficients of the Taylor series of the sine after the first: to x^15.
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

/// Sums even and odd powers separately, in two chains that do not wait for each other.
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
    /// Coefficients of the Taylor series of the cosine after the first: to x^16.
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
