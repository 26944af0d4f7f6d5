//! Verifies a written file: compares the position of every joint, in every frame of every clip, with its source.
//!
//! This module computes the positions of the source and of the file in double precision, with its own kinematics code.
//! The module uses what mocap's reader finds in the file, not data of the writer. In glTF, the time of a frame is
//! rounded to 32-bit seconds, because glTF stores no other times.
//!
//! Intended changes (unit, up axis, trim, frame rate, edits) are in the [`Provenance`] of this crate's glTF and FBX
//! files, or in the JSON file of a BVH file. `verify` applies these changes to the source as well. Without this record,
//! the unit is inferred from the lengths of the links, and must be a known unit of length. The up axis is the axis with
//! the smaller distances. The file is assumed to have the whole motion.
//!
//! Joints are paired by name. Joints without a name, or with a repeated name, are paired by their ancestors. Clips are
//! paired by name, or in their order if the format has no names. Each clip keeps its own frame rate. Cubic curves are
//! also compared between their keys. BVH, FBX and markers are read as one pose for each frame, and compared only at
//! their frames. Rotations that move no joint are compared by points 3 cm away from the joint.
//!
//! A VRM animation has only the bones of a humanoid, in a different rest pose. Two things are compared: the positions
//! of bones whose ancestors are all bones, and the rotation of each bone since the first frame. An omitted joint that
//! moves would affect both.
//!
//! A retargeted motion cannot be compared this way, and is refused.
//!
//! Apart from distances, the result has [`Finding`]s:
//!
//! - missing frames at either end
//! - missing, renamed or additional clips and joints, and joints with another parent
//! - stepped keys, and lengths that match no unit
//! - a skin with another bind pose
//! - a source that differs from the source that the file names
//!
//! A file equals its source if there is no finding, and no distance exceeds the allowed distance: see
//! [`Verification::is_within`].

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
    /// Compares `output` with `source`. `output` has the bytes of a `.glb`, of a `.gltf` with an embedded buffer, or of
    /// any other readable file. `source` is the scene of its source file, before any step.
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
    /// If the bytes cannot be read, have their buffer in another file, or have no joint in common with `source`.
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

/// Compares files, with information that the files lack.
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
    /// A verifier without further information.
    pub fn new() -> Self {
        Self::default()
    }

    /// The importer of the source. The file's record of reading options is applied in addition. Default:
    /// [`Importer::new`].
    #[must_use]
    pub fn importer(mut self, importer: Importer) -> Self {
        self.importer = importer;
        self
    }

    /// The changes between source and file, for files that do not record them.
    #[must_use]
    pub fn provenance(mut self, provenance: Provenance) -> Self {
        self.provenance = Some(provenance);
        self
    }

    /// The files of second motions of the steps concat, blend and layer, in any order. Each file is recognised by the
    /// SHA-256 that the file records.
    #[must_use]
    pub fn second_motions(mut self, files: impl IntoIterator<Item = impl Into<PathBuf>>) -> Self {
        self.seconds = files.into_iter().map(Into::into).collect();
        self
    }

    /// The unit and the up axis of the source, if known. A file that keeps the source's space does not record them.
    pub(super) fn space(mut self, space: SourceSpace) -> Self {
        self.space = space;
        self
    }

    /// The largest error that the caller allows, in metres. A smaller motion may be lost.
    #[doc(hidden)]
    #[must_use]
    pub fn allowing(mut self, max_error: f64) -> Self {
        self.max_error = Some(max_error);
        self
    }

    /// Compares a written file with its source file. Arrays (`.npz`, `.csv`, `.parquet`) are compared in their own
    /// space. Arrays have only the first animation of the source.
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

    /// Reads the output again if its format has one frame rate for all clips, but the source's clips have several
    /// rates. The output then has keys between its frames.
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

    /// Imports the second motion of a step from the given files. The output names the file.
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
            .help("name the second motion: {with} FILE")
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

/// The provenance of the source, if this crate wrote it.
fn provenance_of_file(source: &Path) -> Option<Provenance> {
    let opener = Importer::new();
    let open = |sibling: &Path| opener.open(&source.with_file_name(sibling));
    let bytes = opener.open(source).ok()?;
    output::provenance_of(&bytes, source, &open).ok()?
}

/// Refuses two files that were made from one source by different steps: neither file records the difference.
fn check_not_siblings(stated: &Provenance, other: &Provenance) -> Result<()> {
    match (&stated.source, &other.source) {
        (Some(source), Some(of_other)) if is_same_file(source, of_other) && other.onto().is_none() => {
            let message = format!("both files were made from \"{}\", by different steps", source.name);
            Err(Diagnostic::new(Code::InvalidValue, message)
                .help("compare each file with its source")
                .into())
        }
        _ => Ok(()),
    }
}
