//! The compressed clip: for every joint a translation track and a rotation track, each constant or animated.

use std::sync::Arc;

use glam::{Quat, Vec3};

use super::curves::JointCurves;
use super::key_frames::{self, Insertion, KeyFrames};
use super::quantize::{QuantizedRotation, QuantizedTranslation, RotationFormat, TranslationFormat};

/// An animation whose error is within the bound.
#[doc(hidden)]
pub struct CompressedClip {
    /// One per node of the scene.
    #[doc(hidden)]
    pub tracks: Vec<CompressedTrack>,
    /// The tick of every frame.
    #[doc(hidden)]
    pub ticks: Vec<f64>,
    #[doc(hidden)]
    pub error: MeasuredError,
}

/// What drives one node.
#[doc(hidden)]
pub struct CompressedTrack {
    #[doc(hidden)]
    pub translation: TranslationTrack,
    #[doc(hidden)]
    pub rotation: RotationTrack,
    /// What the tracks are made of, where the encoding states [Euler angles](super::curves::EulerAngles).
    #[doc(hidden)]
    pub curves: Option<Box<JointCurves>>,
}

pub(crate) type TranslationTrack = Track<Vec3, TranslationFormat, QuantizedTranslation>;
pub(crate) type RotationTrack = Track<Quat, RotationFormat, QuantizedRotation>;

#[doc(hidden)]
pub enum Track<Value, Format, Key> {
    Constant(Value),
    Animated {
        format: Format,
        /// Those of all tracks that have keys at these frames.
        key_frames: Arc<KeyFrames>,
        /// One per key frame.
        keys: Vec<Key>,
    },
}

impl<Value, Format, Key: Copy> Track<Value, Format, Key> {
    /// Inserts the keys that `quantize` makes, from the format and the keys so far. A constant track has nothing to
    /// insert.
    pub(super) fn insert(
        &mut self,
        new_key_frames: &Arc<KeyFrames>,
        insertions: &[Insertion],
        quantize: impl FnOnce(&Format, &[Key]) -> Vec<Key>,
    ) {
        if let Self::Animated {
            format,
            key_frames,
            keys,
        } = self
        {
            let new = quantize(format, keys);
            key_frames::insert(keys, insertions, &new);
            *key_frames = Arc::clone(new_key_frames);
        }
    }
}

/// The error of a clip: distances between where joints are and where they should be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[doc(hidden)]
pub struct MeasuredError {
    /// The largest distance, in metres.
    #[doc(hidden)]
    pub max: f64,
    /// The root of the mean square of all distances, in metres.
    #[doc(hidden)]
    pub rms: f64,
    /// The node with the largest distance.
    #[doc(hidden)]
    pub node: usize,
    /// The tick of the largest distance.
    #[doc(hidden)]
    pub tick: f64,
}

/// Bytes of a key time, a 32-bit float.
pub(super) const TIME_BYTES: usize = size_of::<f32>();
/// About the bytes that an accessor of key times takes in the JSON of a glTF file.
const TIME_ACCESSOR_BYTES: usize = 120;

impl CompressedClip {
    /// The key frames of all animated tracks, each with the bytes of a key without its time.
    pub(super) fn animated_tracks(&self) -> impl Iterator<Item = (&Arc<KeyFrames>, usize)> {
        self.tracks.iter().flat_map(|track| {
            let translation = match &track.translation {
                Track::Constant(_) => None,
                Track::Animated { key_frames, .. } => Some((key_frames, TranslationFormat::BYTES)),
            };
            let rotation = match &track.rotation {
                Track::Constant(_) => None,
                Track::Animated { key_frames, format, .. } => Some((key_frames, format.bytes())),
            };
            translation.into_iter().chain(rotation)
        })
    }

    /// The key frames of all tracks, each set once.
    #[doc(hidden)]
    pub fn distinct_key_frames(&self) -> Vec<&Arc<KeyFrames>> {
        let mut distinct: Vec<&Arc<KeyFrames>> = Vec::new();
        for (key_frames, _) in self.animated_tracks() {
            if !distinct.contains(&key_frames) {
                distinct.push(key_frames);
            }
        }
        distinct
    }

    /// The number of keys of all tracks.
    #[doc(hidden)]
    pub fn key_count(&self) -> usize {
        self.animated_tracks().map(|(key_frames, _)| key_frames.len()).sum()
    }

    /// Bytes of all keys and their times, where they are stored without streams.
    #[doc(hidden)]
    pub fn size(&self) -> usize {
        let keys: usize = self.animated_tracks().map(|(frames, bytes)| frames.len() * bytes).sum();
        let distinct = self.distinct_key_frames().into_iter();
        let times: usize = distinct
            .map(|key_frames| TIME_ACCESSOR_BYTES + key_frames.len() * TIME_BYTES)
            .sum();
        keys + times
    }
}
