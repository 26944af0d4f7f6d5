//! Translations as 32-bit floats, as the EXPONENTIAL filter of meshopt stores them, or as multiples of a step.

use glam::Vec3;

use super::rounding::round;

/// The stored form of a track's translations.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(hidden)]
pub enum TranslationFormat {
    /// Three 32-bit floats.
    Float32,
    /// The EXPONENTIAL filter of meshopt: three mantissas of 24 bits, times 2 to this power, in metres.
    ExponentialFilter(i32),
    /// Three multiples of this step, in metres.
    Multiples(f32),
}

/// One stored translation.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct QuantizedTranslation {
    /// The integers in the file.
    #[doc(hidden)]
    pub stored: [u32; 3],
    /// The decoded value.
    #[doc(hidden)]
    pub value: Vec3,
}

/// The largest mantissa of the EXPONENTIAL filter: 24 bits with sign.
const MAX_MANTISSA: f32 = 8_388_607.0;
/// The largest exponent of two of a step. The smallest exponent is its negative. Both are far within the filter's 8
/// bits with sign.
const MAX_EXPONENT: f32 = 100.0;

/// The largest multiple of a step. It is about half of the largest mantissa, so that candidates next to it fit.
const MAX_MULTIPLE: f32 = 4_000_000.0;

impl TranslationFormat {
    /// Bytes of a key, without its time.
    pub(crate) const BYTES: usize = size_of::<[f32; 3]>();

    /// The EXPONENTIAL filter with steps of at most `step`, or larger steps if values up to `largest` would not fit.
    #[doc(hidden)]
    pub fn exponential_filter(step: f32, largest: f32) -> Self {
        let fine = step.log2().floor();
        let range = (largest / MAX_MANTISSA).log2().ceil();
        Self::ExponentialFilter(fine.max(range).clamp(-MAX_EXPONENT, MAX_EXPONENT) as i32)
    }

    /// Multiples of `step`, or of a larger step if values up to `largest` would not fit.
    pub(crate) fn multiples(step: f32, largest: f32) -> Self {
        Self::Multiples(step.max(largest / MAX_MULTIPLE).max(f32::MIN_POSITIVE))
    }

    /// A stored translation within `tolerance` of `translation`. A component within a step of the previous key keeps
    /// the value of this key, because an unchanged number costs nothing in a stream of differences.
    pub(crate) fn quantize(
        self,
        translation: Vec3,
        previous: Option<&QuantizedTranslation>,
        tolerance: f32,
    ) -> QuantizedTranslation {
        let held = self.hold(translation, previous);
        if held.value.distance(translation) <= tolerance {
            held
        } else {
            self.hold(translation, None)
        }
    }

    /// The nearest stored translation, except that a component within a step of the previous key keeps the value of
    /// this key.
    fn hold(self, translation: Vec3, previous: Option<&QuantizedTranslation>) -> QuantizedTranslation {
        match self {
            Self::Float32 => QuantizedTranslation {
                stored: translation.to_array().map(f32::to_bits),
                // Adding zero turns -0 into 0.
                value: translation + Vec3::ZERO,
            },
            Self::Multiples(step) => {
                let multiples = translation.to_array().map(|c| round(c / step));
                QuantizedTranslation {
                    stored: multiples.map(|m| m as u32),
                    value: Vec3::from_array(multiples.map(|m| m as f32 * step)),
                }
            }
            Self::ExponentialFilter(exponent) => {
                let step = f32::exp2(exponent as f32);
                let mantissas: [i32; 3] = std::array::from_fn(|axis| {
                    let exact = (translation[axis] / step).clamp(-MAX_MANTISSA, MAX_MANTISSA);
                    match previous.map(|previous| previous.value[axis] / step) {
                        Some(before) if (exact - before).abs() <= 1.0 => before as i32,
                        _ => round(exact),
                    }
                });
                QuantizedTranslation {
                    stored: mantissas.map(|m| (m as u32 & 0x00ff_ffff) | ((exponent as u32) << 24)),
                    value: Vec3::from_array(mantissas.map(|m| m as f32 * step)),
                }
            }
        }
    }
}
