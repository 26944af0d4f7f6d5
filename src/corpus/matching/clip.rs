//! The data that a database keeps of a clip.

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

/// Samples per second of the directions of the limbs. A search compares these samples.
pub(super) const SAMPLE_RATE: f64 = 20.0;
/// The largest error of a joint position in a packed motion, in metres. Retargeting to longer legs reads the bend of an
/// almost straight knee from the position of the knee. With an error of 1 mm, some knees bent sideways for a frame.
const PACKED_ERROR: f64 = 0.0001;
/// The distance from each joint, in metres, at which [`PACKED_ERROR`] also holds: rotations stay within 1/16 degree.
/// Without this limit, any roll of a hand would be within the error. But another body can have joints below the hand,
/// which the roll moves.
const PACKED_SHELL: f64 = 0.1;

/// The longest plausible leg, in metres. A larger number comes from a damaged file.
const LONGEST_LEG: f32 = 1000.0;

/// The latest plausible start of a clip, in seconds: 115 days.
const LATEST: f64 = 1e7;

/// A clip of a database.
///
/// The [module](crate::matching) has an example.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct IndexedClip {
    /// The row of the clip in a survey: the file with its SHA-256, the name of the clip, and measures of the motion.
    pub row: ClipRow,
    /// Whether left and right are exchanged.
    pub mirrored: bool,
    /// The length from hip through knee to ankle, in metres.
    pub leg: f32,
    /// The time of the first indexed frame in the file, in seconds: above 0 if the file has a rest pose before the
    /// motion.
    pub begin: f64,
    /// The features of each frame, at [`Database::RATE`](crate::matching::Database::RATE) frames per second.
    pub(super) features: Vec<[f32; FEATURES]>,
    pub(super) contacts: Vec<u8>,
    /// The directions of the limbs: [`SAMPLE_RATE`] samples per second, of [`WIDTH`] bytes each.
    pub(super) samples: Vec<i8>,
    /// The bytes of a packed clip (`.mclip`) with the motion. Empty for a mirrored clip, and empty if the database only
    /// refers to the file.
    pub(super) packed: Vec<u8>,
}

impl IndexedClip {
    /// The features of each frame, at [`Database::RATE`](crate::matching::Database::RATE) frames per second.
    /// `docs/search.md` lists the numbers.
    pub fn features(&self) -> &[[f32; FEATURES]] {
        &self.features
    }

    /// The parts of the feet that are at rest in each frame. A value is the sum of 1 for the left ankle, 2 for the
    /// right ankle, 4 for the left ball and 8 for the right ball.
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
    /// Indexes the clips of a file that move a humanoid. With `mirror`, also indexes the mirror image of each clip.
    /// `file` is the name of the file in the database. A clip that cannot be indexed is skipped.
    ///
    /// The [module](crate::matching) has an example.
    pub fn of(scene: &Scene, file: &str, mirror: bool) -> Vec<IndexedClip> {
        Self::of_read(scene.clone(), file, mirror)
    }

    /// Indexes a scene as [`of`](Self::of) does, but does not copy it.
    #[doc(hidden)]
    pub fn of_read(mut scene: Scene, file: &str, mirror: bool) -> Vec<IndexedClip> {
        let found = Self::with_animations(&mut scene, file);
        Self::with_mirrored(found.into_iter().map(|(clip, _)| clip), mirror)
    }

    /// Indexes clips as [`IndexedClip::of`] does, and keeps their compressed motions in the database. Every joint stays
    /// within 0.1 mm of its position in the file.
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
    /// The errors of [`PackedClip::encode`] and [`Conversion::apply`].
    pub fn packed(scene: &Scene, file: &str, mirror: bool) -> Result<Vec<IndexedClip>> {
        Self::packed_read(scene.clone(), file, mirror)
    }

    /// Indexes a scene as [`packed`](Self::packed) does, but does not copy it.
    #[doc(hidden)]
    pub fn packed_read(mut scene: Scene, file: &str, mirror: bool) -> Result<Vec<IndexedClip>> {
        let mut found = Self::with_animations(&mut scene, file);
        Conversion::new().apply(&mut scene)?;
        let bound = ErrorBound::new(PACKED_ERROR).shell_distance(PACKED_SHELL);
        for (clip, animation) in &mut found {
            clip.packed = PackedClip::encode(&scene, *animation, bound.clone())?.into_bytes();
        }
        Ok(Self::with_mirrored(found.into_iter().map(|(clip, _)| clip), mirror))
    }

    /// The clips, followed by their mirror images if `mirror` is set.
    fn with_mirrored(clips: impl Iterator<Item = IndexedClip>, mirror: bool) -> Vec<IndexedClip> {
        let mut clips: Vec<IndexedClip> = clips.collect();
        if mirror {
            let mirrored: Vec<IndexedClip> = clips.iter().map(IndexedClip::mirror).collect();
            clips.extend(mirrored);
        }
        clips
    }

    /// The clips that can be indexed, each with its index into the animations. The scene is unchanged afterwards.
    fn with_animations(scene: &mut Scene, file: &str) -> Vec<(IndexedClip, usize)> {
        let mut clips = Vec::new();
        let mut animation = 0;
        let figure = figure_of(scene);
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
                packed: Vec::new(),
            };
            clips.push((clip, animation - 1));
        });
        clips
    }

    /// The motion that the database has of the clip, in metres with +Y up.
    ///
    /// # Errors
    /// [`Code::NoMotion`] if the database only refers to the file of the motion, and the errors of [`Importer::read`].
    pub fn motion(&self) -> Result<Scene> {
        if !self.is_packed() {
            return Err(Diagnostic::new(
                Code::NoMotion,
                "the database has no motion of the clip, only a reference to its file",
            )
            .into());
        }
        let importer = Importer::new().skeleton_mesh(SkeletonMesh::None);
        importer.read(&self.packed, "packed.mclip")
    }

    /// Whether the database has the motion of the clip. A mirrored clip has none: the original clip has the motion.
    pub fn is_packed(&self) -> bool {
        !self.packed.is_empty()
    }
}

/// The figure of a scene. The joints of an animal on four legs are the bones of a humanoid, whose arms are the front
/// legs.
pub(super) fn figure_of(scene: &Scene) -> Figure {
    let figure = Figure::new(scene);
    match figure.quadruped(scene) {
        Some(animal) => Figure::with_bones(scene, animal.bones()),
        None => figure,
    }
}

/// Whether the length of a leg (in metres) and the start of a clip (in seconds) are plausible.
pub(super) fn has_leg_and_begin(leg: f32, begin: f64) -> bool {
    leg > 0.0 && leg <= LONGEST_LEG && (0.0..=LATEST).contains(&begin)
}

/// Whether a number can be a feature: no body moves 60 km in a second.
pub(super) fn is_plausible(value: f32) -> bool {
    value.abs() <= half::MOST
}

/// Rounds a number to the 16-bit precision of the database file.
fn rounded(value: f32) -> f32 {
    half::from_half(half::to_half(value))
}
