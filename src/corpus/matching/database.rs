//! Clips with their features.

use super::clip::IndexedClip;
use super::features::{FEATURE_RATE, FEATURES};

/// Clips with the features of their frames, in memory. `.mdb` is its file.
///
/// The [module](crate::matching) has an example.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Database {
    pub(super) clips: Vec<IndexedClip>,
}

impl Database {
    /// The numbers of the features of a frame.
    pub const FEATURES: usize = FEATURES;

    /// Frames of features in a second: the rate at which all motions are compared.
    pub const RATE: f64 = FEATURE_RATE;

    /// The database of these clips, in the order of their files.
    pub fn new(mut clips: Vec<IndexedClip>) -> Self {
        clips.sort_by(|a, b| (&a.row.file, &a.row.clip, a.mirrored).cmp(&(&b.row.file, &b.row.clip, b.mirrored)));
        Self { clips }
    }

    /// Its clips.
    pub fn clips(&self) -> &[IndexedClip] {
        &self.clips
    }

    /// The clips themselves.
    pub fn into_clips(self) -> Vec<IndexedClip> {
        self.clips
    }

    /// The frames of all clips.
    pub fn frames(&self) -> usize {
        self.clips.iter().map(|clip| clip.features.len()).sum()
    }

    /// The features of all frames, clip by clip.
    pub fn features(&self) -> impl Iterator<Item = &[f32; FEATURES]> {
        self.clips.iter().flat_map(|clip| &clip.features)
    }
    /// The clip that has the motion of a clip packed within: the clip itself, or the one that it mirrors.
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
