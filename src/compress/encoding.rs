//! The encoding: how a format stores the keys of a clip.

use super::clip::CompressedClip;
use super::curves::EulerAngles;
use super::key_frames::KeyFrames;
use super::quantize::{RotationFormat, TranslationFormat};

/// How a format stores keys. [`compress`](super::compress()) calls this trait.
///
/// Each format implements the trait next to its reader and writer, so `compress` knows no format. A method is called
/// once for a track, a constant or a clip. Its result is a [`RotationFormat`] or a [`TranslationFormat`], which the
/// loops over frames use.
#[doc(hidden)]
pub trait Encoding {
    /// The storage of a joint's rotations. `steps` is the number of steps of a component from 0 to the square root of
    /// 1/2. One step moves the end of the joint's longest lever arm by about its tolerance. For a format with a
    /// lattice, the result is the start of the search for the lowest bit rate.
    fn rotations(&self, steps: f32) -> RotationFormat;

    /// The storage of translations with components up to `largest` and steps of about `step`, both in the same unit.
    /// The default is 32-bit floats.
    fn translations(&self, _step: f32, _largest: f32) -> TranslationFormat {
        TranslationFormat::Float32
    }

    /// The frames that may have keys. The default is the best choice for formats that store keys as plain numbers.
    fn key_frames(&self) -> KeyFrameChoice {
        KeyFrameChoice::OwnOrShared
    }

    /// The approximate bytes of a clip, to choose between two clips with different key frames.
    fn size(&self, clip: &CompressedClip) -> usize {
        clip.size()
    }

    /// Adds the key frames that the format requires, for a clip of `_frames` frames.
    fn with_required(&self, key_frames: KeyFrames, _frames: usize) -> KeyFrames {
        key_frames
    }

    /// The step to which constant tracks are rounded, as a fraction of the error bound; `None` if they stay exact.
    fn constant_step(&self) -> Option<f64> {
        None
    }

    /// The time of a tick in the file.
    fn time(&self, tick: f64, ticks_per_second: f64) -> f32 {
        (tick / ticks_per_second) as f32
    }

    /// How often a reader rounds a position to single precision, including the rounding in the computation of the
    /// joint's position.
    fn roundings(&self) -> f64 {
        1.0
    }

    /// How the file states the rotation of a node relative to its parent, for formats with [curves](super::curves).
    /// Default: `None`.
    fn euler_angles(&self, _node: usize) -> Option<EulerAngles> {
        None
    }

    /// The help text if the bound cannot be kept.
    fn help(&self) -> &'static str {
        "allow a larger error, or store 32-bit floats"
    }
}

/// The frames that may have keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub enum KeyFrameChoice {
    /// Each track has its own key frames.
    Own,
    /// Each track has its own key frames, or all tracks share key frames, whichever is smaller. This choice is for
    /// formats that store keys as plain numbers.
    OwnOrShared,
    /// All tracks share key frames, or have keys at all frames, whichever is smaller. This choice is for formats that
    /// store keys as differences. The times of separate key frames hardly compress in streams. With separate key
    /// frames, five real clips took 1.4 to 3.2 times the bytes, at bounds of 1, 5, 10 and 25 mm.
    SharedOrAll,
}

/// 32-bit floats, for keys that stay in a scene and are not written to a file.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct Float32;

impl Encoding for Float32 {
    fn rotations(&self, _steps: f32) -> RotationFormat {
        RotationFormat::Float32
    }
}
