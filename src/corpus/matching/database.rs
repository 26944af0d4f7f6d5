//! The clips of a database with their features.

use super::clip::IndexedClip;
use super::features::{FEATURE_RATE, FEATURES};

/// Clips with the features of their frames, in memory. [`Database::to_bytes`] writes the file (`.mdb`).
///
/// The [module](crate::matching) has an example.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Database {
    pub(super) clips: Vec<IndexedClip>,
}

impl Database {
    /// The number of features of a frame.
    pub const FEATURES: usize = FEATURES;

    /// The frame rate of the features, in frames per second. All motions are compared at this rate.
    pub const RATE: f64 = FEATURE_RATE;

    /// Makes a database of clips, in the order of their files.
    pub fn new(mut clips: Vec<IndexedClip>) -> Self {
        clips.sort_by(|a, b| (&a.row.file, &a.row.clip, a.mirrored).cmp(&(&b.row.file, &b.row.clip, b.mirrored)));
        Self { clips }
    }

    /// The clips of the database, in the order of their files.
    pub fn clips(&self) -> &[IndexedClip] {
        &self.clips
    }

    /// The clips of the database, without copying them.
    pub fn into_clips(self) -> Vec<IndexedClip> {
        self.clips
    }

    /// The number of frames of all clips.
    pub fn frames(&self) -> usize {
        self.clips.iter().map(|clip| clip.features.len()).sum()
    }

    /// The features of all frames, clip by clip.
    pub fn features(&self) -> impl Iterator<Item = &[f32; FEATURES]> {
        self.clips.iter().flat_map(|clip| &clip.features)
    }
    /// The clip that has the packed motion of `clip`: the clip itself, or the original of a mirrored clip.
    pub(super) fn packed<'a>(&'a self, clip: &'a IndexedClip) -> Option<&'a IndexedClip> {
        let is_own = |other: &&IndexedClip| {
            other.is_packed() && other.row.file == clip.row.file && other.row.clip == clip.row.clip
        };
        match clip.is_packed() {
            true => Some(clip),
            false if clip.mirrored => self.clips.iter().find(is_own),
            false => None,
        }
    }
}
