//! Clips with their features.

use super::clip::IndexedClip;
use super::features::FEATURES;

/// Clips with the features of their frames, in memory. `.mdb` is its file.
///
/// The [module](crate::matching) has an example.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Database {
    pub(super) clips: Vec<IndexedClip>,
}

impl Database {
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
}
