//! The encodings of glTF keys: 16-bit integers, or meshopt streams. For 32-bit floats the encoding is [`Float32`].

use mocap_compress::{CompressedClip, Encoding, Float32, KeyFrameChoice, Lattice, RotationFormat, TranslationFormat};

use super::Compression;
use super::stream_size;

/// Rotations as 16-bit normalized integers, translations as 32-bit floats.
struct Int16 {
    constant_step: Option<f64>,
}

/// Streams of differences, with meshopt filters.
struct Meshopt {
    constant_step: Option<f64>,
}

// Constants are rounded to a fraction of the error bound. The constants are in the JSON, where a digit takes a byte.
// The fractions are tuned on the fixtures.

/// The step of constants as a fraction of the bound, with 16-bit rotations. Another digit saves keys that take more
/// bytes than the digit.
const CONSTANT_STEP_OF_INT16: f64 = 1e-3;

/// The step of constants as a fraction of the bound, with meshopt, where another digit costs more than it saves.
const CONSTANT_STEP_OF_MESHOPT: f64 = 1e-2;

impl Compression {
    /// The encoding for a file whose nodes take the constants.
    pub(super) fn encoding(self) -> &'static dyn Encoding {
        match self {
            Self::None => &Float32,
            Self::Int16 => &Int16 {
                constant_step: Some(CONSTANT_STEP_OF_INT16),
            },
            Self::Meshopt | Self::MeshoptKhr => &Meshopt {
                constant_step: Some(CONSTANT_STEP_OF_MESHOPT),
            },
        }
    }

    /// The encoding for a file whose nodes stay unchanged.
    pub(super) fn encoding_with_exact_constants(self) -> &'static dyn Encoding {
        match self {
            Self::None => &Float32,
            Self::Int16 => &Int16 { constant_step: None },
            Self::Meshopt | Self::MeshoptKhr => &Meshopt { constant_step: None },
        }
    }
}

impl Encoding for Int16 {
    fn rotations(&self, _steps: f32) -> RotationFormat {
        RotationFormat::Int16
    }

    fn constant_step(&self) -> Option<f64> {
        self.constant_step
    }
}

/// Bits of a component of the QUATERNION filter: EXT_meshopt_compression, appendix B.
const FILTER_BITS: std::ops::RangeInclusive<i32> = 4..=16;

impl Encoding for Meshopt {
    fn rotations(&self, steps: f32) -> RotationFormat {
        // One bit is for the sign.
        let bits = steps.log2().ceil() as i32 + 1;
        let bits = bits.clamp(*FILTER_BITS.start(), *FILTER_BITS.end());
        RotationFormat::QuaternionFilter(Lattice::of_filter(bits as u32))
    }

    fn translations(&self, step: f32, largest: f32) -> TranslationFormat {
        TranslationFormat::exponential_filter(step, largest)
    }

    fn key_frames(&self) -> KeyFrameChoice {
        KeyFrameChoice::SharedOrAll
    }

    fn size(&self, clip: &CompressedClip) -> usize {
        stream_size::of_clip(clip)
    }

    fn constant_step(&self) -> Option<f64> {
        self.constant_step
    }
}
