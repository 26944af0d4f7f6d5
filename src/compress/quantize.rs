//! Quantization: how rotations and translations are stored, and what a reader decodes from that.

mod rotation;
mod translation;

pub(super) use self::rotation::{FINE_BITS, Lattice, dropped_component};
pub(crate) use self::rotation::{QuantizedRotation, RotationFormat};
pub(crate) use self::translation::{QuantizedTranslation, TranslationFormat};

/// The integer nearest to a number, halves away from zero, as meshoptimizer rounds in its filters.
fn round(value: f32) -> i32 {
    (value + 0.5f32.copysign(value)) as i32
}
