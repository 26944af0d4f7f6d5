//! What of a clip is kept in a database.

use mocap_compress::{ErrorBound, PackedClip};
use mocap_figure::Figure;
use mocap_figure::convert::Conversion;
use mocap_io::import::Importer;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::math::half;
use mocap_scene::process::SkeletonMesh;
use mocap_scene::scene::Scene;

use super::features::{self, FEATURE_RATE, FEATURES, LEG, Track};
use crate::survey::report::ClipRow;
use crate::survey::{Fingerprint, Thresholds, WIDTH, examine_each, mirrored_row};

/// Samples in a second of where limbs point, by which parts are compared.
pub(super) const SAMPLE_RATE: f64 = 20.0;
/// The largest error of the position of a joint of a packed motion, in metres. On a body with longer legs the knee of a
/// leg that is almost straight bends as its position tells: with a millimetre some bent sideways for a frame.
const PACKED_ERROR: f64 = 0.0001;
/// The same distance around each joint, which keeps rotations within a sixteenth of a degree. Otherwise nothing bounds
/// the roll of a hand, which has more joints on another body.
const PACKED_SHELL: f64 = 0.1;

/// The longest leg in metres that is believed: larger numbers are damage.
const LONGEST_LEG: f32 = 1000.0;

/// The latest begin in seconds that is believed: 115 days.
const LATEST: f64 = 1e7;

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
    /// The file of a packed clip with its motion; empty where it is kept by reference, and for a mirrored clip.
    pub(super) packed: Vec<u8>,
}

impl IndexedClip {
    /// The features of each frame, [`Database::RATE`](crate::matching::Database::RATE) in a second; `docs/search.md`
    /// says what the numbers are.
    pub fn features(&self) -> &[[f32; FEATURES]] {
        &self.features
    }

    /// The parts of the feet that are at rest in each frame. It is the sum of 1 for the left ankle, 2 for the right
    /// one, 4 for the left ball, 8 for the right one.
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
            packed: Vec::new(),
            row: self.row.clone(),
            ..*self
        }
    }
}

impl IndexedClip {
    /// Indexes the clips of a file that move a humanoid, and with `mirror` each with left and right exchanged too.
    /// `file` is its name in the database. A clip that cannot be indexed is skipped.
    ///
    /// The [module](crate::matching) has an example.
    pub fn of(scene: &Scene, file: &str, mirror: bool) -> Vec<IndexedClip> {
        Self::with_motion(scene, file, mirror, |_| Ok(Vec::new())).unwrap_or_default()
    }

    /// Indexes clips as [`IndexedClip::of`] does, and keeps their motions in the database, packed: no joint is farther
    /// than 0.1 mm from its position in the file.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::matching::{Database, IndexedClip, Moves};
    ///
    /// let walk = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let database = Database::new(IndexedClip::packed(&walk, "walk.bvh", true)?);
    /// let mut hero = mocap::import("fixtures/real/rokoko_dance.bvh")?;
    /// mocap::Conversion::new().apply(&mut hero)?;
    /// let moves = Moves::of(&database, &hero, |file| unreachable!("{file} is within"))?;
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`PackedClip::encode`] and [`Conversion::apply`].
    pub fn packed(scene: &Scene, file: &str, mirror: bool) -> Result<Vec<IndexedClip>> {
        let mut metres = scene.clone();
        Conversion::new().apply(&mut metres)?;
        let bound = ErrorBound::new(PACKED_ERROR).shell_distance(PACKED_SHELL);
        Self::with_motion(scene, file, mirror, |animation| {
            Ok(PackedClip::encode(&metres, animation, bound.clone())?.into_bytes())
        })
    }

    fn with_motion(
        scene: &Scene,
        file: &str,
        mirror: bool,
        mut pack: impl FnMut(usize) -> Result<Vec<u8>>,
    ) -> Result<Vec<IndexedClip>> {
        let mut clips = Vec::new();
        let mut animation = 0;
        let mut failed = None;
        let figure = Figure::new(scene);
        examine_each(scene, &figure, file, &Thresholds::default(), |row, motion| {
            animation += 1;
            let Some(motion) = motion else { return };
            let Some(body) = &motion.body else { return };
            let Some(track) = Track::new(&motion, body) else { return };
            let features: Vec<_> = (0..track.frames())
                .map(|frame| track.features(frame, LEG / body.leg))
                .collect();
            let begin = motion.first as f64 / motion.rate;
            let are_plausible = features.iter().flatten().all(|value| is_plausible(*value));
            if !(are_plausible && has_leg_and_begin(body.leg, begin)) {
                return;
            }
            let packed = match pack(animation - 1) {
                Ok(packed) => packed,
                Err(error) => {
                    failed = Some(error);
                    return;
                }
            };
            let seconds = track.frames().saturating_sub(1) as f64 / FEATURE_RATE;
            let samples = (seconds * SAMPLE_RATE + 0.01).floor() as usize + 1;
            let samples = Fingerprint::sampled(&motion, SAMPLE_RATE, motion.first as f64, samples);
            let clip = IndexedClip {
                row,
                mirrored: false,
                leg: body.leg,
                begin,
                features: features.into_iter().map(|row| row.map(rounded)).collect(),
                contacts: track.contacts,
                samples: samples.values,
                packed,
            };
            if mirror {
                clips.push(clip.mirror());
            }
            clips.push(clip);
        });
        if let Some(error) = failed {
            return Err(error);
        }
        // The motion before its mirror image.
        clips.sort_by_key(|clip: &IndexedClip| clip.mirrored);
        Ok(clips)
    }

    /// The motion that is within the database, in metres with +Y up.
    ///
    /// # Errors
    /// [`Code::NoMotion`] where it is kept by reference, and as [`Importer::read`].
    pub fn motion(&self) -> Result<Scene> {
        if !self.is_packed() {
            return Err(Diagnostic::new(Code::NoMotion, "the motion of the clip is in its file alone").into());
        }
        let importer = Importer::new().skeleton_mesh(SkeletonMesh::None);
        importer.read(&self.packed, "packed.mclip")
    }

    /// Whether its motion is within the database; that of a mirrored clip is with the clip itself.
    pub fn is_packed(&self) -> bool {
        !self.packed.is_empty()
    }
}

/// Whether a clip can have a leg of so many metres, and begin after so many seconds.
pub(super) fn has_leg_and_begin(leg: f32, begin: f64) -> bool {
    leg > 0.0 && leg <= LONGEST_LEG && (0.0..=LATEST).contains(&begin)
}

/// Whether a number can be a feature: no body is sixty kilometres from where it was a second before.
pub(super) fn is_plausible(value: f32) -> bool {
    value.abs() <= half::MOST
}

/// A number as the file of a database has it.
fn rounded(value: f32) -> f32 {
    half::from_half(half::to_half(value))
}
