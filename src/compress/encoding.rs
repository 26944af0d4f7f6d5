//! The encoding: how the keys of a clip are stored in a format.

use super::clip::CompressedClip;
use super::curves::EulerAngles;
use super::key_frames::KeyFrames;
use super::quantize::{RotationFormat, TranslationFormat};

/// How keys are stored in a format: what a format says, and [`compress`](super::compress()) asks.
///
/// Each format has an implementation beside its reader and writer, so that `compress` knows of none. It is asked once
/// for a track, a constant or a clip; the loops over frames run on what it answers, a [`RotationFormat`] or a
/// [`TranslationFormat`].
#[doc(hidden)]
pub trait Encoding {
    /// How the rotations of a joint are stored. `steps` is the number of steps of a component from 0 to the root of a
    /// half. One step moves the end of the joint's longest lever arm by about its tolerance. A format with a lattice is
    /// where the search for the lowest bit rate starts.
    fn rotations(&self, steps: f32) -> RotationFormat;

    /// How translations are stored whose components are up to `largest`, with steps of about `step`, both in one unit.
    /// Usually as 32-bit floats.
    fn translations(&self, _step: f32, _largest: f32) -> TranslationFormat {
        TranslationFormat::Float32
    }

    /// Which frames may have keys. Usually what is best for keys as plain numbers.
    fn key_frames(&self) -> KeyFrameChoice {
        KeyFrameChoice::OwnOrShared
    }

    /// About the bytes of a clip, to choose between two with different key frames.
    fn size(&self, clip: &CompressedClip) -> usize {
        clip.size()
    }

    /// Adds the key frames that the format needs of a clip of so many frames.
    fn with_required(&self, key_frames: KeyFrames, _frames: usize) -> KeyFrames {
        key_frames
    }

    /// To which fraction of the error bound the numbers of constant tracks are rounded; `None` where they stay exact.
    fn constant_step(&self) -> Option<f64> {
        None
    }

    /// The time of a tick as the file has it.
    fn time(&self, tick: f64, ticks_per_second: f64) -> f32 {
        (tick / ticks_per_second) as f32
    }

    /// How often a reader computes with single precision, in roundings of a position: once, to compute the position of
    /// a joint.
    fn roundings(&self) -> f64 {
        1.0
    }

    /// How the file states the rotations of a node, for formats of [curves](super::curves).
    fn euler_angles(&self, _node: usize) -> Option<EulerAngles> {
        None
    }

    /// What to do where the bound cannot be kept.
    fn help(&self) -> &'static str {
        "allow a larger error, or store 32-bit floats"
    }
}

/// Which frames may have keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub enum KeyFrameChoice {
    /// Each track has key frames of its own.
    Own,
    /// Each track has key frames of its own, or all tracks have common ones, whichever is smaller: for keys as plain
    /// numbers.
    OwnOrShared,
    /// All tracks have one list of key frames, or keys at all frames, whichever is smaller: for keys that are stored as
    /// differences. Times of each track's own hardly compress in streams, and took 1.4 to 3.2 times the bytes for five
    /// real clips within 1, 5, 10 and 25 mm.
    SharedOrAll,
}

/// Keys as 32-bit floats, in no format: for the keys of a scene.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct Float32;

impl Encoding for Float32 {
    fn rotations(&self, _steps: f32) -> RotationFormat {
        RotationFormat::Float32
    }
}
