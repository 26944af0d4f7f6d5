//! How numbers stand in a file, and what a reader makes of them.

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

/// One stored rotation: what stands in the file before any filter, and the unit quaternion that a reader has.
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
            Self::Short => {
                let stored = same_side(rotation.normalize(), previous_value).to_array();
                let code = stored.map(|c| (c * SHORT).round() as i16);
                let value = Quat::from_array(code.map(|c| f32::from(c) / SHORT)).normalize();
                CodedRotation { code, value, doubts: 0 }
            }
            Self::Filtered(bits) => filtered(rotation, bits, previous, 0.5),
        }
    }

    /// As [`Self::nearest`], with every component that is within `hold` steps of the one before staying as it was.
    /// Steps that do not change cost nothing in a stream of differences.
    pub(super) fn holding(self, rotation: Quat, previous: Option<&CodedRotation>, hold: f32) -> CodedRotation {
        match self {
            Self::Filtered(bits) => filtered(rotation, bits, previous, hold),
            _ => self.nearest(rotation, previous),
        }
    }
}

fn same_side(rotation: Quat, previous: Quat) -> Quat {
    if rotation.dot(previous) < 0.0 {
        -rotation
    } else {
        rotation
    }
}

/// The code of `rotation` for the QUATERNION filter.
///
/// The left-out component is the largest one. It stays the one of the code before as long as the others fit, because
/// a change of it changes everything.
fn filtered(rotation: Quat, bits: u32, previous: Option<&CodedRotation>, hold: f32) -> CodedRotation {
    const FITS: f32 = 0.705;
    let components = rotation.to_array();
    let largest = (1..4).fold(0, |best, c| {
        if components[c].abs() > components[best].abs() {
            c
        } else {
            best
        }
    });
    let kept = previous.map(|previous| (previous.code[3] & 3) as usize);
    let left_out = match kept {
        Some(kept) if kept == largest || (components[largest].abs() < FITS && components[kept].abs() > 0.3) => kept,
        _ => largest,
    };
    let one = ((1i32 << (bits - 1)) - 1) as f32;
    let scale = if components[left_out] < 0.0 { -one } else { one } * std::f32::consts::SQRT_2;
    let is_same = kept == Some(left_out);
    let mut code = [0i16; 4];
    let mut residues = [0.0; 3];
    for (slot, stored) in code.iter_mut().take(3).enumerate() {
        let exact = (components[(left_out + 1 + slot) & 3] * scale).clamp(-one, one);
        let before = previous.map_or(0, |previous| previous.code[slot]);
        *stored = if is_same && (exact - f32::from(before)).abs() <= hold {
            before
        } else {
            exact.round() as i16
        };
        residues[slot] = exact - f32::from(*stored);
    }
    code[3] = ((one as i32 & !3) | left_out as i32) as i16;
    let coded = decode_filtered(code);
    if coded.doubts == 0 || bits < FINE {
        return coded;
    }
    // Near it there are codes without doubt, the nearest of them on the side of what was rounded away.
    let next = |slot: usize, step: i16| {
        let mut code = code;
        code[slot] = (code[slot] + step).clamp(-(one as i16), one as i16);
        decode_filtered(code)
    };
    let to_residue = |slot: usize| if residues[slot] < 0.0 { -1 } else { 1 };
    let steps = (1..=4).flat_map(|far| (0..3).flat_map(move |slot| [(slot, far), (slot, -far)]));
    steps
        .map(|(slot, step)| (slot, step * to_residue(slot)))
        .map(|(slot, step)| next(slot, step))
        .find(|coded| coded.doubts == 0)
        .unwrap_or(coded)
}

/// From so many bits on a step is as small as what decoders may differ by, and it is cheap to avoid doubt.
const FINE: u32 = 10;

/// How near to the middle between two integers a component is in doubt: some roundings of a number below 32768 in
/// single precision.
const DOUBT: f32 = 0.005;

/// What a reader makes of a code of the QUATERNION filter: the unit quaternion of the four 16-bit integers after the
/// filter. The formula is that of EXT_meshopt_compression, appendix B.
pub(super) fn decode_filtered(code: [i16; 4]) -> CodedRotation {
    let one = f32::from(code[3] | 3);
    let left_out = (code[3] & 3) as usize;
    let [x, y, z] = [code[0], code[1], code[2]].map(f32::from);
    let w = (one * one * 2.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let to_short = SHORT / std::f32::consts::SQRT_2 / one;
    let exact = (Vec4::new(x, y, z, w) * to_short).to_array();
    let mut shorts = [0.0; 4];
    let mut doubts = 0;
    for slot in 0..4 {
        let rounded = exact[slot].round();
        // The left-out component is the root of a difference, whose error grows as the component gets smaller.
        let doubt = if slot < 3 {
            DOUBT
        } else {
            DOUBT * SHORT / exact[3].max(1.0)
        };
        doubts += u8::from((exact[slot] - rounded).abs() > 0.5 - doubt);
        shorts[(left_out + 1 + slot) & 3] = rounded;
    }
    CodedRotation {
        code,
        value: Quat::from_array(shorts).normalize(),
        doubts,
    }
}

impl CodedRotation {
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
    pub(super) fn nearest(self, translation: Vec3, previous: Option<&CodedTranslation>, hold: f32) -> CodedTranslation {
        match self {
            Self::Float => CodedTranslation {
                code: translation.to_array().map(f32::to_bits),
                // Adding zero turns -0 into 0.
                value: translation + Vec3::ZERO,
            },
            Self::Filtered(exponent) => {
                let step = f32::exp2(exponent as f32);
                let mut mantissas = [0i32; 3];
                for (axis, mantissa) in mantissas.iter_mut().enumerate() {
                    let exact = (translation[axis] / step).clamp(-MANTISSA, MANTISSA);
                    let before = previous.map(|previous| previous.value[axis] / step);
                    *mantissa = match before {
                        Some(before) if (exact - before).abs() <= hold => before as i32,
                        _ => exact.round() as i32,
                    };
                }
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
        let mut doubtful = 0;
        for bits in 5..=16 {
            let mut previous: Option<CodedRotation> = None;
            for _ in 0..1000 {
                let rotation = Quat::from_xyzw(random(), random(), random(), random()).normalize();
                // Every other one near the one before, so that the left-out component is not always the largest.
                let near = |previous: CodedRotation| (previous.value + rotation * 0.05).normalize();
                let rotation = previous.filter(|_| random() < 0.5).map_or(rotation, near);
                let coded = RotationCode::Filtered(bits).holding(rotation, previous.as_ref(), 0.75);
                let error = (coded.value - rotation).length().min((coded.value + rotation).length());
                let step = 1.0 / ((1 << (bits - 1)) - 1) as f32;
                assert!(
                    error < 3.0 * step + 1e-4,
                    "{bits} bits: {rotation} became {}",
                    coded.value
                );
                let mut reference = [coded.code];
                meshopt::decode_filter_quat(&mut reference);
                let reference = Quat::from_array(reference[0].map(|c| f32::from(c) / SHORT)).normalize();
                let difference = 2.0 * f64::from((coded.value - reference).length());
                assert!(
                    difference <= coded.doubt() + 1e-6,
                    "{bits} bits: {} became {reference}",
                    coded.value
                );
                doubtful += usize::from(coded.doubts > 0 && bits >= FINE);
                previous = Some(coded);
            }
        }
        assert!(doubtful < 40, "{doubtful} of 4000 fine codes");
    }
}
