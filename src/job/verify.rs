//! Proof that a motion survived: where a written file puts every joint at every frame of every clip, against its
//! source.
//!
//! Both sides are computed in double precision by kinematics of their own, and the file is read back by a reader, which
//! did not write it. The moment of a frame in glTF is the 32-bit number of seconds next to it, for glTF has no other.
//!
//! Intended changes (unit, up axis, trim, frame rate, in place, edits) are in the [`Provenance`] of glTF and FBX files
//! of this crate, or in a file beside BVH. They are applied to the source as well. Without this record, the unit
//! follows from the lengths of the links, and must be a unit of length. The up axis is the one that fits the first
//! frame better. The motion is assumed to be whole.
//!
//! Joints are paired by their names, and joints of one name or without a name by the joints above them. Clips are
//! paired by their names, or in their order if the format has no names. Each clip keeps its own frame rate. A cubic
//! curve is looked at between its keys too; BVH, FBX and markers, which are read as a pose for each frame, at their
//! frames alone. Rotations that move no joint show in points 3 cm away.
//!
//! A VRM animation has only the bones of a humanoid, in another rest pose. Compared are the positions of those that
//! stand on bones alone, and how each of them has rotated since the first frame. A joint that is left out and moves has
//! a part in both.
//!
//! A motion that was put on another skeleton cannot be compared so, and is refused.
//!
//! Distances are one half of the proof. The other are [`Finding`]s:
//!
//! - frames that are missing at either end
//! - clips or joints that are missing, renamed or too many, and joints on another parent
//! - keys that step, and lengths in no unit
//! - a skin that is bound elsewhere
//! - another source than the file names
//!
//! A file is what its source is where there is no finding and no distance beyond the allowed;
//! [`Verification::is_within`] says so.

mod arrays;
mod chain;
mod change;
mod claims;
mod clip;
mod comparison;
mod csv;
mod face;
mod kept;
mod mesh;
#[cfg(feature = "npz")]
mod npz;
mod output;
mod pairs;
#[cfg(feature = "parquet")]
mod parquet;
mod rates;
pub mod report;
mod skin;
mod timeline;
mod units;

use std::path::{Path, PathBuf};

use mocap_formats::gltf::report::Provenance;
use mocap_io::import::Importer;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::Scene;
use mocap_scene::scene::report::Origin;
use mocap_scene::scene::report::SecondMotion;

use crate::SourceSpace;

use self::claims::{import_source, is_same_file};
use self::comparison::Comparison;
use self::output::Output;
use self::rates::Rates;
use self::report::{Finding, FindingKind, LargestDeviation, Resampling, Verification, VerifiedClip};
#[cfg(feature = "npz")]
use mocap_formats::usd;

impl Verification {
    /// Compares `output` with `source`. `output` is the bytes of a `.glb`, of a `.gltf` with its buffer inside, or of
    /// any other file that is read. `source` is the scene of its source file, before any step that moves things.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::gltf::GltfOptions;
    /// use mocap::verify::report::Verification;
    ///
    /// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let verified = Verification::of(&scene, &GltfOptions::default().write_glb(&scene)?)?;
    /// assert_eq!((verified.frames, verified.joints, verified.end_sites), (10, 3, 1));
    /// assert!(verified.is_within(1e-6));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// Where the bytes cannot be read, have their buffer in another file, or have no joint in common with `source`.
    pub fn of(source: &Scene, output: &[u8]) -> Result<Verification> {
        let refuse = |other: &Path| {
            let message = format!("the buffer is in another file, \"{}\"", other.display());
            Err(Diagnostic::new(Code::InvalidGltf, message)
                .help("verify the files, not their bytes")
                .into())
        };
        let verifier = Verifier::new();
        let read = |rate| Output::read(output, "output".as_ref(), &refuse, rate);
        let output = verifier.sampled(read(None)?, source, &read)?;
        verifier.compare(source, None, &output)
    }
}

/// Compares files, where more is known than they say.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::Exporter;
/// use mocap::gltf::report::Provenance;
/// use mocap::verify::Verifier;
///
/// let walk = "fixtures/real/cmu_short.bvh";
/// let mut scene = mocap::import(walk)?;
/// scene.trim(10.0, 20.0);
/// let folder = tempfile::tempdir().unwrap();
/// let output = folder.path().join("part.bvh");
/// Exporter::new().export(&scene, &output)?;
/// // BVH does not say that it is a part.
/// let verified = Verifier::new().provenance(Provenance::of(&scene)).files(walk, &output)?;
/// assert_eq!(verified.frames, 11);
/// assert!(verified.is_within(1e-5));
/// assert!(!Verifier::new().files(walk, &output)?.is_within(1e-5));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Verifier {
    importer: Importer,
    provenance: Option<Provenance>,
    seconds: Vec<PathBuf>,
    space: SourceSpace,
    max_error: Option<f64>,
}

impl Verifier {
    /// Knows what the files say.
    pub fn new() -> Self {
        Self::default()
    }

    /// How the source is read. What the file says of that comes on top. Default: [`Importer::new`].
    #[must_use]
    pub fn importer(mut self, importer: Importer) -> Self {
        self.importer = importer;
        self
    }

    /// What was done between source and file, for files that do not say it.
    #[must_use]
    pub fn provenance(mut self, provenance: Provenance) -> Self {
        self.provenance = Some(provenance);
        self
    }

    /// The files of the second motions that steps took, in any order: a concat, a blend or a layer. Each is recognised
    /// by the SHA-256 that the file records.
    #[must_use]
    pub fn second_motions(mut self, files: impl IntoIterator<Item = impl Into<PathBuf>>) -> Self {
        self.seconds = files.into_iter().map(Into::into).collect();
        self
    }

    /// What is known of the unit and the up axis of the source. A file with the source's own space does not record it.
    pub(super) fn space(mut self, space: SourceSpace) -> Self {
        self.space = space;
        self
    }

    /// The largest error that the caller allows, in metres: a motion that is smaller may be lost.
    #[doc(hidden)]
    #[must_use]
    pub fn allowing(mut self, max_error: f64) -> Self {
        self.max_error = Some(max_error);
        self
    }

    /// Compares a written file with its source file. Arrays (`.npz`, `.csv`, `.parquet`) are compared in the space that
    /// they have; of several animations they have the first.
    ///
    /// # Errors
    /// As [`Verifier::files`].
    pub fn files(&self, source: impl AsRef<Path>, output: impl AsRef<Path>) -> Result<Verification> {
        let path = output.as_ref();
        let opener = Importer::new();
        let bytes = opener.open(path)?;
        let arrays = match &*bytes {
            #[cfg(feature = "npz")]
            bytes if npz::sniff(bytes) && !usd::is_archive(bytes) => Some(npz::read(bytes)),
            #[cfg(feature = "parquet")]
            bytes if parquet::sniff(bytes) => parquet::read(bytes).transpose(),
            bytes if csv::sniff(bytes) => Some(csv::read(bytes)),
            _ => None,
        };
        if let Some(file) = arrays {
            let file = file.map_err(|error| error.with_path(path))?;
            let importer = self.importer.clone().with_own_meshes();
            let scene = import_source(&file.header.provenance, importer, source.as_ref())?;
            return arrays::compare(&scene, &file).map_err(|error| error.with_path(path));
        }
        let open = |sibling: &Path| opener.open(&path.with_file_name(sibling));
        let read = |rate| Output::read(&bytes, path, &open, rate).map_err(|error| error.with_path(path));
        let source = source.as_ref();
        let mut output = read(None)?;
        let stated = provenance_of_file(source);
        let is_copy = self.provenance.is_none() && stated.is_some() && stated == output.provenance();
        if is_copy {
            output.forget_provenance();
        }
        if let (Some(stated), Some(other)) = (stated.filter(|_| !is_copy), output.provenance()) {
            check_not_siblings(&stated, &other)?;
        }
        let read = |rate| {
            let mut output = read(rate)?;
            if is_copy {
                output.forget_provenance();
            }
            Ok(output)
        };
        let importer = self.importer.clone().with_own_meshes();
        let provenance = self.provenance_of(&output);
        let character = match provenance.as_ref().and_then(Provenance::onto) {
            Some(_) => {
                Some(importer.import(source)?).filter(|scene| output.is_of_character(scene, self.provenance.as_ref()))
            }
            None => None,
        };
        let mut scene = match (character, &provenance) {
            (Some(character), _) => character,
            (None, Some(provenance)) => import_source(provenance, importer, source)?,
            (None, None) => importer.import(source)?,
        };
        self.space.state(&mut scene);
        let output = self.sampled(output, &scene, &read)?;
        self.compare(&scene, Some(source), &output)
            .map_err(|error| error.with_path(path))
    }

    /// The output, read again where its format has one frame rate for all clips and those of its source have several.
    /// It has keys between its frames then.
    fn sampled<'a>(
        &self,
        output: Output<'a>,
        source: &Scene,
        read: &dyn Fn(Option<f64>) -> Result<Output<'a>>,
    ) -> Result<Output<'a>> {
        let provenance = self.provenance_of(&output);
        let steps = provenance.as_ref().map_or(&[][..], |provenance| &provenance.steps);
        if !output.row().has_one_rate {
            return Ok(output);
        }
        let rates = Rates::new(source, steps, &output);
        let clips = clip::pairs(source, &output);
        let mut sampled = match rates.common() {
            Some(rate) => read(Some(rate))?,
            None => output,
        };
        for rate in rates.several() {
            let others = read(Some(rate))?;
            let has_rate = |(ours, _): &(usize, _)| rates.written(*ours) == rate;
            let taken = clips
                .iter()
                .enumerate()
                .filter(has_rate)
                .filter_map(|(_, theirs)| *theirs);
            sampled.take_clips(others, &taken.collect());
        }
        for (ours, theirs) in clips.into_iter().enumerate() {
            sampled.play_slower(theirs, rates.written(ours) / rates.of_clips[ours]);
        }
        Ok(sampled)
    }

    /// Imports the second motion of a step: the one of the given files that the output names.
    fn second(&self, motion: &SecondMotion, source: Option<&Path>) -> Result<Scene> {
        let provenance = Provenance {
            source: motion.source.clone(),
            root_offset: motion.root_offset.clone(),
            steps: motion.steps.clone(),
            ..Provenance::default()
        };
        let importer = self.importer.clone().with_own_meshes();
        let wanted = motion.source.clone().unwrap_or_default();
        let is_it = |origin: &Origin| is_same_file(&wanted, origin);
        for file in self.seconds.iter().map(PathBuf::as_path).chain(source) {
            let mut scene = import_source(&provenance, importer.clone(), file)?;
            self.space.state(&mut scene);
            if scene.metadata.origin.as_ref().is_some_and(is_it) {
                return Ok(scene);
            }
        }
        let message = format!(
            "the second motion of the file, \"{}\", is not among the files given",
            wanted.name
        );
        Err(Diagnostic::new(Code::InvalidValue, message)
            .help("name it: {with} FILE")
            .into())
    }

    fn provenance_of(&self, output: &Output<'_>) -> Option<Provenance> {
        output.provenance().or_else(|| self.provenance.clone())
    }

    fn compare(&self, source: &Scene, file: Option<&Path>, output: &Output<'_>) -> Result<Verification> {
        output.check_not_retargeted(source, self.provenance.as_ref())?;
        let second = |motion: &SecondMotion| self.second(motion, file);
        let replay = change::Replay {
            second: &second,
            keeps_units: output.row().keeps_units(),
        };
        let given = self.provenance.as_ref();
        let comparison = Comparison {
            original: source,
            file,
            output,
            provenance: output
                .provenance_of_character(source, given)
                .or_else(|| self.provenance_of(output)),
            is_of_character: output.is_of_character(source, given),
            allowed: self.max_error.unwrap_or(timeline::SMALLEST_MOTION),
            replay,
        };
        comparison.run()
    }
}

/// What the source says of itself, if this crate wrote it.
fn provenance_of_file(source: &Path) -> Option<Provenance> {
    let opener = Importer::new();
    let open = |sibling: &Path| opener.open(&source.with_file_name(sibling));
    let bytes = opener.open(source).ok()?;
    output::provenance_of(&bytes, source, &open).ok()?
}

/// Refuses two files that were made of one source by other steps: neither says what lies between the two.
fn check_not_siblings(stated: &Provenance, other: &Provenance) -> Result<()> {
    match (&stated.source, &other.source) {
        (Some(source), Some(of_other)) if is_same_file(source, of_other) && other.onto().is_none() => {
            let message = format!("both files were made of \"{}\", by other steps", source.name);
            Err(Diagnostic::new(Code::InvalidValue, message)
                .help("compare each of them with the file that it was made of")
                .into())
        }
        _ => Ok(()),
    }
}
