//! The encoding of a packed clip's keys.

use super::layout::MUST_HAVE_KEY;
use super::write::packed_size;
use crate::clip::CompressedClip;
use crate::encoding::{Encoding, KeyFrameChoice};
use crate::key_frames::KeyFrames;
use crate::quantize::{Lattice, RotationFormat, TranslationFormat};

/// Rotations are points of a lattice with any number of steps. Translations are multiples of a step.
pub(super) struct Packed;

impl Encoding for Packed {
    fn rotations(&self, steps: f32) -> RotationFormat {
        RotationFormat::SmallestThree(Lattice::of_steps(steps))
    }

    fn translations(&self, step: f32, largest: f32) -> TranslationFormat {
        TranslationFormat::multiples(step, largest)
    }

    fn key_frames(&self) -> KeyFrameChoice {
        KeyFrameChoice::SharedOrAll
    }

    fn size(&self, clip: &CompressedClip) -> usize {
        packed_size(clip)
    }

    fn with_required(&self, mut key_frames: KeyFrames, frames: usize) -> KeyFrames {
        key_frames.extend((0..frames).step_by(MUST_HAVE_KEY).map(|frame| frame as u32));
        key_frames.sort_unstable();
        key_frames.dedup();
        key_frames
    }

    /// [`PackedClip::sample`](super::PackedClip::sample) computes and interpolates a rotation in single precision.
    fn roundings(&self) -> f64 {
        3.0
    }
}
