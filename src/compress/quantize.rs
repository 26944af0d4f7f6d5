//! Quantization: the stored form of rotations and translations, and the values that a reader decodes.

pub(crate) mod rotation;
mod rounding;
pub(crate) mod translation;

pub(crate) use self::rotation::QuantizedRotation;
pub(super) use self::rotation::dropped_component;
#[doc(hidden)]
pub use self::rotation::{Lattice, RotationFormat};
pub(crate) use self::translation::QuantizedTranslation;
#[doc(hidden)]
pub use self::translation::TranslationFormat;
