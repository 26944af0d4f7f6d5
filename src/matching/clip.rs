//! What of a clip is kept in a database.

use super::features::{self, FEATURE_RATE, FEATURES, LEG, Track};
use crate::figure::Figure;
use crate::scene::Scene;
use crate::survey::{ClipRow, Fingerprint, Thresholds, WIDTH, examine_each, mirrored_row};

/// Samples in a second of where limbs point, by which parts are compared.
pub(super) const SAMPLE_RATE: f64 = 20.0;

/// A clip of a database.
///
/// The [module](crate::matching) has an example.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct IndexedClip {
    /// Its row in a survey: the file with its SHA-256, the name of the clip, and what the motion is like.
    pub row: ClipRow,
    /// Whether left and right are exchanged.
    pub mirrored: bool,
    /// From hip through knee to ankle, in metres.
    pub leg: f32,
    /// The time of the first frame in the file, in seconds: above 0 where a rest pose stands before the motion.
    pub begin: f64,
    /// Of each frame, [`Database::RATE`](crate::matching::Database::RATE) in a second.
    pub(super) features: Vec<[f32; FEATURES]>,
    pub(super) contacts: Vec<u8>,
    /// [`SAMPLE_RATE`] in a second, [`WIDTH`] bytes each.
    pub(super) samples: Vec<i8>,
}

impl IndexedClip {
    /// The features of each frame, [`Database::RATE`](crate::matching::Database::RATE) in a second; `docs/search.md`
    /// says what the numbers are.
    pub fn features(&self) -> &[[f32; FEATURES]] {
        &self.features
    }

    /// What of the feet is at rest in each frame: the sum of 1 for the left ankle, 2 for the right one, 4 for the left
    /// ball, 8 for the right one.
    pub fn contacts(&self) -> &[u8] {
        &self.contacts
    }

    /// The clip with left and right exchanged.
    #[must_use]
    pub fn mirror(&self) -> Self {
        let rows = self.samples.chunks_exact(WIDTH);
        Self {
            mirrored: !self.mirrored,
            features: self.features.iter().map(features::mirrored).collect(),
            contacts: self
                .contacts
                .iter()
                .map(|bits| features::mirrored_contacts(*bits))
                .collect(),
            samples: rows.flat_map(mirrored_row).collect(),
            ..self.clone()
        }
    }
}

impl IndexedClip {
    /// Indexes the clips of a file that move a humanoid, and with `mirror` each with left and right exchanged too.
    /// `file` is its name in the database. A clip that cannot be indexed is left out.
    ///
    /// The [module](crate::matching) has an example.
    pub fn of(scene: &Scene, file: &str, mirror: bool) -> Vec<IndexedClip> {
        let mut clips = Vec::new();
        let figure = Figure::new(scene);
        examine_each(scene, &figure, file, &Thresholds::default(), |row, motion| {
            let Some(motion) = motion else { return };
            let Some(body) = &motion.body else { return };
            let Some(track) = Track::new(&motion, body) else { return };
            let features: Vec<_> = (0..track.frames())
                .map(|frame| track.features(frame, LEG / body.leg))
                .collect();
            if !features.iter().flatten().all(|value| is_plausible(*value)) {
                return;
            }
            let seconds = track.frames().saturating_sub(1) as f64 / FEATURE_RATE;
            let samples = (seconds * SAMPLE_RATE + 0.01).floor() as usize + 1;
            let samples = Fingerprint::sampled(&motion, SAMPLE_RATE, motion.first as f64, samples);
            let clip = IndexedClip {
                row,
                mirrored: false,
                leg: body.leg,
                begin: motion.first as f64 / motion.rate,
                features,
                contacts: track.contacts,
                samples: samples.values,
            };
            if mirror {
                clips.push(clip.mirror());
            }
            clips.push(clip);
        });
        // The motion before its mirror image.
        clips.sort_by_key(|clip| clip.mirrored);
        clips
    }
}

/// Whether a number can be a feature: no body is a thousand kilometres from where it was a second before.
pub(super) fn is_plausible(value: f32) -> bool {
    value.abs() <= 1e6
}
