//! How numbers stand in a file, and what a reader makes of them.

use std::f32::consts::SQRT_2;

use glam::{Quat, Vec3, Vec4};

/// The largest 16-bit integer: glTF's normalised integers divide by it.
const SHORT: f32 = 32767.0;

/// How the rotations of a joint are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RotationCode {
    /// Four 32-bit floats.
    Float,
    /// Four 16-bit normalised integers, core glTF: `max(c / 32767, -1)`.
    Short,
    /// The QUATERNION filter of meshopt: the three smaller components, each an integer of so many bits.
    Filtered(u32),
}

/// One stored rotation: what stands in the file before any filter, and the quaternion that a reader has.
/// The length of that is 1 but for rounding; some readers make it 1, and some do not.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CodedRotation {
    pub(crate) code: [i16; 4],
    pub(crate) value: Quat,
    /// How many components another decoder may round to the other side, by one of 32767.
    pub(super) doubts: u8,
}

impl RotationCode {
    /// Bytes of a key, without those of its time.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::Float => 16,
            Self::Short | Self::Filtered(_) => 8,
        }
    }

    /// The code nearest to `rotation`, in the hemisphere of `previous` where signs are stored.
    pub(super) fn nearest(self, rotation: Quat, previous: Option<&CodedRotation>) -> CodedRotation {
        let previous_value = previous.map_or(Quat::IDENTITY, |previous| previous.value);
        match self {
            Self::Float => CodedRotation {
                code: [0; 4],
                value: same_side(rotation.normalize(), previous_value),
                doubts: 0,
            },
            Self::Short => short(same_side(rotation.normalize(), previous_value)),
            Self::Filtered(bits) => Lattice::new(bits).nearest(rotation, previous),
        }
    }
}

/// Of the two quaternions that stand for `rotation` the one that is nearer to `previous`.
pub(super) fn same_side(rotation: Quat, previous: Quat) -> Quat {
    if rotation.dot(previous) < 0.0 {
        -rotation
    } else {
        rotation
    }
}

/// Four integers next to the components of `rotation`: of the sixteen choices the one whose length is nearest to 1, for
/// there are readers that take the length as it is, and so stretch what the joint carries.
fn short(rotation: Quat) -> CodedRotation {
    let exact = rotation.to_array().map(|c| c * SHORT);
    let below = exact.map(floor);
    let mut best = ([0; 4], f32::INFINITY);
    for corner in 0..16 {
        let code: [i32; 4] = std::array::from_fn(|c| (below[c] + (corner >> c & 1)).clamp(-32767, 32767));
        // Whole numbers, so that nothing is lost to rounding: the squares of all four are near 2^30.
        let squares: i32 = code.iter().map(|c| c * c).sum();
        let off = (squares - 32767 * 32767).unsigned_abs() as f32;
        let distance: f32 = std::iter::zip(code, exact)
            .map(|(c, exact)| (c as f32 - exact).powi(2))
            .sum();
        // An error in length of one step weighs as much as one in angle; 2 * 32767 of `off` are such a step.
        let score = (off / SHORT).powi(2) + distance;
        if score < best.1 {
            best = (code, score);
        }
    }
    let code = best.0.map(|c| c as i16);
    let value = Quat::from_array(code.map(|c| f32::from(c) / SHORT));
    CodedRotation { code, value, doubts: 0 }
}

/// The integer below. `f32::floor` is a call on processors of 2003.
fn floor(value: f32) -> i32 {
    let towards_zero = value as i32;
    towards_zero - i32::from(towards_zero as f32 > value)
}

/// The integer next to a number, the larger of two in its size, as the filters' reference has it.
fn round(value: f32) -> i32 {
    (value + 0.5f32.copysign(value)) as i32
}

/// The component of a quaternion that the QUATERNION filter leaves out: the largest one. It stays the one of the code
/// before as long as the others fit, because a change of it changes everything.
pub(super) fn left_out(components: [f32; 4], kept: Option<usize>) -> usize {
    /// The others are below the root of a half; some room is left to choose in.
    const FITS: f32 = 0.705;
    let larger = |a: usize, b: usize| {
        if components[b].abs() > components[a].abs() {
            b
        } else {
            a
        }
    };
    let largest = larger(larger(0, 1), larger(2, 3));
    match kept {
        Some(kept) if components[largest].abs() < FITS && components[kept].abs() > 0.3 => kept,
        _ => largest,
    }
}

/// The codes of the QUATERNION filter with so many bits: a grid in three dimensions.
#[derive(Clone, Copy)]
pub(super) struct Lattice {
    /// The largest number that a component can be.
    one: i32,
}

impl Lattice {
    pub(super) fn new(bits: u32) -> Self {
        Self {
            one: (1 << (bits - 1)) - 1,
        }
    }

    /// The steps of a component of the size 1.
    pub(super) fn scale(self) -> f32 {
        self.one as f32 * SQRT_2
    }

    /// The fourth number of a code.
    fn mark(self, left_out: usize) -> i16 {
        ((self.one & !3) | left_out as i32) as i16
    }

    /// The numbers of the code before, if differences to them mean something.
    pub(super) fn before(self, left_out: usize, previous: &CodedRotation) -> Option<[i32; 3]> {
        let [x, y, z, mark] = previous.code;
        (mark == self.mark(left_out)).then(|| [x, y, z].map(i32::from))
    }

    /// What stands for three whole numbers: the components after the one that is left out.
    pub(super) fn code(self, stored: [i32; 3], left_out: usize) -> CodedRotation {
        let [x, y, z] = stored.map(|c| c.clamp(-self.one, self.one) as i16);
        decode_filtered([x, y, z, self.mark(left_out)])
    }

    fn nearest(self, rotation: Quat, previous: Option<&CodedRotation>) -> CodedRotation {
        let components = rotation.to_array();
        let left_out = left_out(components, previous.map(CodedRotation::left_out));
        let scale = self.scale().copysign(components[left_out]);
        let stored = [1, 2, 3].map(|slot| round(components[(left_out + slot) & 3] * scale));
        self.code(stored, left_out)
    }
}

/// From so many bits on a step is as small as what decoders may differ by, and it is cheap to avoid doubt.
pub(super) const FINE: u32 = 10;

/// How near to the middle between two integers a component is in doubt: some roundings of a number below 32768 in
/// single precision.
const DOUBT: f32 = 0.005;

/// What a reader makes of a code of the QUATERNION filter: the quaternion of the four 16-bit integers after the filter.
/// The formula is that of EXT_meshopt_compression, appendix B.
fn decode_filtered(code: [i16; 4]) -> CodedRotation {
    let one = f32::from(code[3] | 3);
    let left_out = (code[3] & 3) as usize;
    let [x, y, z] = [code[0], code[1], code[2]].map(f32::from);
    let w = (one * one * 2.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let to_short = SHORT / SQRT_2 / one;
    let exact = (Vec4::new(x, y, z, w) * to_short).to_array();
    let [a, b, c, d] = exact.map(|exact| round(exact) as f32);
    // The left-out component is the root of a difference, whose error grows as the component gets smaller.
    let doubt = [DOUBT, DOUBT, DOUBT, DOUBT * SHORT / exact[3].max(1.0)];
    let in_doubt = |slot: usize, rounded: f32| u8::from((exact[slot] - rounded).abs() > 0.5 - doubt[slot]);
    let shorts = match left_out {
        0 => [d, a, b, c],
        1 => [c, d, a, b],
        2 => [b, c, d, a],
        _ => [a, b, c, d],
    };
    CodedRotation {
        code,
        value: Quat::from_array(shorts.map(|c| c / SHORT)),
        doubts: in_doubt(0, a) + in_doubt(1, b) + in_doubt(2, c) + in_doubt(3, d),
    }
}

impl CodedRotation {
    /// The component that the QUATERNION filter leaves out.
    pub(super) fn left_out(&self) -> usize {
        (self.code[3] & 3) as usize
    }

    /// The angle, in radians, by which another decoder's rotation may differ.
    pub(super) fn doubt(&self) -> f64 {
        2.0 * f64::from(self.doubts).sqrt() / f64::from(SHORT)
    }
}

/// How the translations of a joint are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TranslationCode {
    /// Three 32-bit floats.
    Float,
    /// The EXPONENTIAL filter of meshopt: multiples of 2 to this power, in metres.
    Filtered(i32),
}

/// One stored translation: what stands in the file before any filter, and the vector that a reader has.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CodedTranslation {
    pub(crate) code: [u32; 3],
    pub(crate) value: Vec3,
}

/// The largest mantissa of the EXPONENTIAL filter.
pub(super) const MANTISSA: f32 = 8_388_607.0;

impl TranslationCode {
    /// Bytes of a key, without those of its time.
    pub(super) const BYTES: usize = size_of::<[f32; 3]>();

    pub(super) fn nearest(self, translation: Vec3) -> CodedTranslation {
        self.holding(translation, None)
    }

    /// As [`Self::nearest`], with every component that is within a step of the one before staying as it was. Steps
    /// that do not change cost nothing in a stream of differences.
    pub(super) fn holding(self, translation: Vec3, previous: Option<&CodedTranslation>) -> CodedTranslation {
        match self {
            Self::Float => CodedTranslation {
                code: translation.to_array().map(f32::to_bits),
                // Adding zero turns -0 into 0.
                value: translation + Vec3::ZERO,
            },
            Self::Filtered(exponent) => {
                let step = f32::exp2(exponent as f32);
                let mantissas: [i32; 3] = std::array::from_fn(|axis| {
                    let exact = (translation[axis] / step).clamp(-MANTISSA, MANTISSA);
                    match previous.map(|previous| previous.value[axis] / step) {
                        Some(before) if (exact - before).abs() <= 1.0 => before as i32,
                        _ => round(exact),
                    }
                });
                let code = mantissas.map(|m| (m as u32 & 0x00ff_ffff) | ((exponent as u32) << 24));
                let value = Vec3::from_array(mantissas.map(|m| m as f32 * step));
                CodedTranslation { code, value }
            }
        }
    }
}

#[cfg(all(test, feature = "meshopt"))]
mod tests {
    use super::*;

    /// But for what is said to be in doubt.
    #[test]
    fn the_filter_decodes_as_the_reference_does() {
        let mut seed = 1u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / 8_388_608.0 - 1.0
        };
        for bits in 5..=16 {
            let mut previous: Option<CodedRotation> = None;
            for _ in 0..1000 {
                let rotation = Quat::from_xyzw(random(), random(), random(), random()).normalize();
                // Every other one near the one before, so that the left-out component is not always the largest.
                let near = |previous: CodedRotation| (previous.value + rotation * 0.05).normalize();
                let rotation = previous.filter(|_| random() < 0.5).map_or(rotation, near);
                let coded = RotationCode::Filtered(bits).nearest(rotation, previous.as_ref());
                let error = (coded.value - rotation).length().min((coded.value + rotation).length());
                let step = 1.0 / ((1 << (bits - 1)) - 1) as f32;
                assert!(
                    error < 3.0 * step + 1e-4,
                    "{bits} bits: {rotation} became {}",
                    coded.value
                );
                let mut reference = [coded.code];
                meshopt::decode_filter_quat(&mut reference);
                let reference = Quat::from_array(reference[0].map(|c| f32::from(c) / SHORT));
                let difference = 2.0 * f64::from((coded.value - reference).length());
                assert!(
                    difference <= coded.doubt() + 1e-6,
                    "{bits} bits: {} became {reference}",
                    coded.value
                );
                previous = Some(coded);
            }
        }
    }
}
