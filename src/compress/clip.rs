//! The compressed clip. Every joint has a translation track and a rotation track, each constant or animated.

use std::sync::Arc;

use glam::{Quat, Vec3};

use super::curves::JointCurves;
use super::key_frames::{self, Insertion, KeyFrames};
use super::quantize::{QuantizedRotation, QuantizedTranslation, RotationFormat, TranslationFormat};

/// A compressed animation. Its error is within the bound.
#[doc(hidden)]
pub struct CompressedClip {
    /// One track per node of the scene.
    #[doc(hidden)]
    pub tracks: Vec<CompressedTrack>,
    /// The tick of every frame.
    #[doc(hidden)]
    pub ticks: Vec<f64>,
    #[doc(hidden)]
    pub error: MeasuredError,
}

/// The tracks of one node.
#[doc(hidden)]
pub struct CompressedTrack {
    #[doc(hidden)]
    pub translation: TranslationTrack,
    #[doc(hidden)]
    pub rotation: RotationTrack,
    /// The curves that the tracks represent, if the encoding states [Euler angles](super::curves::EulerAngles).
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
        /// The key frames, shared by all tracks with keys at the same frames.
        key_frames: Arc<KeyFrames>,
        /// One key per key frame.
        keys: Vec<Key>,
    },
}

impl<Value, Format, Key: Copy> Track<Value, Format, Key> {
    /// Inserts the keys that `quantize` returns. `quantize` gets the format and the existing keys. A constant track
    /// does not change.
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

/// The error of a clip: the distances of joints from their positions in the source.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[doc(hidden)]
pub struct MeasuredError {
    /// The largest distance in metres.
    #[doc(hidden)]
    pub max: f64,
    /// The RMS of all distances in metres.
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
/// The approximate bytes of an accessor for key times in the JSON of a glTF file.
const TIME_ACCESSOR_BYTES: usize = 120;

impl CompressedClip {
    /// For each animated track, its key frames and the size of one key in bytes, without the time of the key.
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

    /// The distinct key frame lists of all tracks.
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

    /// The size of all keys and key times in bytes, if they are stored as plain numbers and not in compressed streams.
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
