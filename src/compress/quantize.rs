//! Quantization: how rotations and translations are stored, and what a reader decodes from that.

mod rotation;
mod rounding;
mod translation;

pub(super) use self::rotation::dropped_component;
pub(crate) use self::rotation::{Lattice, QuantizedRotation, RotationFormat};
pub(crate) use self::translation::{QuantizedTranslation, TranslationFormat};
