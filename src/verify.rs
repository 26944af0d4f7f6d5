//! Proof that a motion survived: where a written file puts every joint at every frame of every clip, against its
//! source.
//!
//! Both sides are computed in double precision by kinematics of their own, and the file is read back by a reader, which
//! did not write it. The moment of a frame in glTF is the 32-bit number of seconds next to it, for glTF has no other.
//!
//! What the conversion did on purpose (unit, up axis, trim, frame rate, in place, edits) is in the [`Provenance`] of
//! glTF files of this crate and is done to the source as well. A file of another program has none, nor has BVH: there
//! the unit is taken from the lengths of the links, the up axis from what fits the first frame better, and the motion
//! is said to be whole.
//!
//! A VRM animation has only the bones of a humanoid, in another rest pose. Compared are the positions of those that
//! stand on bones alone, and how each of them has rotated since the first frame. A joint that is left out and moves has
//! a part in both.
//!
//! A motion that was put on another skeleton cannot be compared so, and is refused.
//!
//! Distances are one half of the proof. The other are [`Finding`]s: frames that are missing at either end, clips or
//! joints that are missing, renamed or too many, joints on another parent, keys that step. A file is what its source is
//! where there is no finding and no distance beyond the allowed; [`Verification::is_within`] says so.

mod arrays;
mod chain;
mod change;
mod clip;
mod csv;
#[cfg(feature = "npz")]
mod npz;
mod pairs;

use std::fmt;
use std::path::{Path, PathBuf};

use serde::Serialize;

use self::chain::Skeleton;
use self::change::{Change, Timeline};
use self::clip::Errors;
use self::pairs::Pairs;
use crate::error::{Code, Diagnostic, Result};
use crate::figure;
use crate::format::fbx;
use crate::format::gltf::{File, Provenance};
use crate::import::{Clips, Importer};
use crate::limits::Limits;
use crate::process::SkeletonMesh;
use crate::scene::{AppliedStep, Format, NodeKind, Origin, Scene, SecondMotion};

/// How far a written file is from its source.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Verification {
    /// Frames that were compared, of all clips.
    pub frames: usize,
    /// Joints and end sites that were compared.
    pub joints: usize,
    /// The largest distance of a joint from its position in the source, in metres.
    pub max_error: f64,
    /// The root of the mean square of all distances, in metres.
    pub rms_error: f64,
    /// Where and when the largest distance is. Absent where nothing was compared.
    pub worst: Option<Worst>,
    /// How far the rotation of a joint alone moves a point 3 cm from it, at most, in metres. Absent where the joints of
    /// the file may stand otherwise at rest, as in files of other programs.
    pub turn_error: Option<f64>,
    /// What the motion lost by another frame rate. Absent where it has its own. It is not part of the errors above:
    /// those are about the frames that the file has.
    pub resampling: Option<Resampling>,
    /// The clips that were compared.
    pub clips: Vec<VerifiedClip>,
    /// What is wrong beside distances.
    pub findings: Vec<Finding>,
    /// Joints of the source that the file does not have.
    pub missing: Vec<String>,
    /// End sites of the source that the file does not have; many programs leave them out.
    pub missing_end_sites: Vec<String>,
    /// Units of the file in one of the source.
    pub metres_per_unit: f64,
    /// Whether the file itself says how it was converted.
    pub has_provenance: bool,
}

impl Verification {
    /// Whether the file is what its source is: nothing was found, and no joint is farther from its position, in metres,
    /// than allowed.
    pub fn is_within(&self, max_error: f64) -> bool {
        // A NaN is not within anything.
        self.findings.is_empty()
            && self.max_error <= max_error
            && self.turn_error.is_none_or(|error| error <= max_error)
    }
}

/// One clip of a file.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct VerifiedClip {
    /// Its name in the source.
    pub name: String,
    /// Frames that were compared.
    pub frames: usize,
    /// The largest distance of a joint from its position in the source, in metres.
    pub max_error: f64,
}

/// What a motion lost by another frame rate: how far the joints are from their positions at the frames of the source,
/// up to the last frame of the file.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Resampling {
    /// Frames of the source that were compared.
    pub frames: usize,
    /// The largest distance, in metres.
    pub max_error: f64,
    /// The root of the mean square of all distances, in metres.
    pub rms_error: f64,
    /// Where and when the largest distance is.
    pub worst: Option<Worst>,
}

/// Where and when the largest distance is.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Worst {
    /// The index of the clip in the source.
    pub clip: usize,
    /// The joint, by its name in the source.
    pub joint: String,
    /// The frame of the source, or that before it.
    pub frame: usize,
    /// Seconds from the start of the file.
    pub seconds: f64,
}

/// Something that is wrong beside distances.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Finding {
    /// What kind of thing.
    pub kind: FindingKind,
    /// What exactly, as one sentence without a full stop.
    pub message: String,
}

impl Finding {
    fn new(kind: FindingKind, message: impl Into<String>) -> Self {
        let message = message.into();
        Self { kind, message }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.kind.as_str(), self.message)
    }
}

/// The kinds of [`Finding`]s.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum FindingKind {
    /// The motion of the file starts later or ends earlier than that of the source.
    MissingFrames,
    /// The motion of the file goes on behind the end of that of the source.
    ExtraFrames,
    /// The file holds values between its keys, where those of the source go straight.
    Stepped,
    /// The source has a clip that the file does not have.
    MissingClip,
    /// The file has a clip that the source does not have.
    ExtraClip,
    /// The source has a joint that the file does not have.
    MissingJoint,
    /// A joint has another name in the file.
    RenamedJoint,
    /// A joint has another parent in the file.
    MovedJoint,
    /// The file, which this crate wrote, has a joint that the source does not have.
    ExtraJoint,
    /// What the file says of itself is not so.
    Provenance,
}

impl FindingKind {
    /// Its name in kebab case.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::MissingFrames => "missing-frames",
            Self::ExtraFrames => "extra-frames",
            Self::Stepped => "stepped",
            Self::MissingClip => "missing-clip",
            Self::ExtraClip => "extra-clip",
            Self::MissingJoint => "missing-joint",
            Self::RenamedJoint => "renamed-joint",
            Self::MovedJoint => "moved-joint",
            Self::ExtraJoint => "extra-joint",
            Self::Provenance => "provenance",
        }
    }
}

/// Compares a written file with its source file. The source is read as the conversion read it, where the written file
/// says how that was.
///
/// # Errors
/// Where one of the two cannot be read, or they have no joint in common.
pub fn verify_files(source: impl AsRef<Path>, output: impl AsRef<Path>) -> Result<Verification> {
    Verifier::new().files(source, output)
}

/// Compares `output`, the bytes of a `.glb`, of a `.gltf` with its buffer inside, or of any other file that is read,
/// with `source`, the scene that its source file reads as, before any step that moves things.
///
/// ```
/// use mocap::gltf::{GltfOptions, write_glb};
/// use mocap::verify::verify;
///
/// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
/// let verified = verify(&scene, &write_glb(&scene, &GltfOptions::default())?)?;
/// assert_eq!((verified.frames, verified.joints), (10, 4));
/// assert!(verified.is_within(1e-6));
/// # Ok::<(), mocap::Error>(())
/// ```
///
/// # Errors
/// Where the bytes cannot be read, have their buffer in another file, or have no joint in common with `source`.
pub fn verify(source: &Scene, output: &[u8]) -> Result<Verification> {
    let refuse = |other: &Path| {
        let message = format!("the buffer is in another file, \"{}\"", other.display());
        Err(Diagnostic::new(Code::InvalidGltf, message)
            .help("verify the files, not their bytes")
            .into())
    };
    let output = Output::read(output, "output".as_ref(), &refuse)?;
    Verifier::new().compare(source, None, &output)
}

/// Compares files, where more is known than they say.
///
/// ```
/// use mocap::bvh;
/// use mocap::gltf::Provenance;
/// use mocap::process::trim;
/// use mocap::verify::Verifier;
///
/// let walk = "fixtures/real/cmu_short.bvh";
/// let mut scene = mocap::import(walk)?;
/// trim(&mut scene, 10.0, 20.0);
/// let folder = tempfile::tempdir().unwrap();
/// let output = folder.path().join("part.bvh");
/// bvh::export(&scene, &output, &bvh::BvhOptions::default())?;
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

    /// Compares a written file with its source file. Arrays (`.npz`, `.csv`) are compared in the space that they have;
    /// of several animations they have the first.
    ///
    /// # Errors
    /// As [`verify_files`].
    pub fn files(&self, source: impl AsRef<Path>, output: impl AsRef<Path>) -> Result<Verification> {
        let path = output.as_ref();
        let opener = Importer::new();
        let bytes = opener.open(path)?;
        let arrays = match &*bytes {
            #[cfg(feature = "npz")]
            bytes if npz::sniff(bytes) => Some(npz::read(bytes)),
            bytes if csv::sniff(bytes) => Some(csv::read(bytes)),
            _ => None,
        };
        if let Some(file) = arrays {
            let file = file.map_err(|error| error.with_path(path))?;
            let importer = file.header.provenance.importer(self.importer.clone());
            let scene = importer.skeleton_mesh(SkeletonMesh::None).import(source)?;
            return arrays::compare(&scene, &file).map_err(|error| error.with_path(path));
        }
        let output = Output::read(&bytes, path, &|sibling| opener.open(&path.with_file_name(sibling)))
            .map_err(|error| error.with_path(path))?;
        let importer = match self.provenance_of(&output) {
            Some(provenance) => provenance.importer(self.importer.clone()),
            None => self.importer.clone(),
        };
        let source = source.as_ref();
        let scene = importer.skeleton_mesh(SkeletonMesh::None).import(source)?;
        self.compare(&scene, Some(source), &output)
            .map_err(|error| error.with_path(path))
    }

    /// Imports the second motion of a step: that of the given files which the output names.
    fn second(&self, motion: &SecondMotion, source: Option<&Path>) -> Result<Scene> {
        let provenance = Provenance {
            source: motion.source.clone(),
            root_offset: motion.root_offset.clone(),
            steps: motion.steps.clone(),
            ..Provenance::default()
        };
        let importer = provenance
            .importer(self.importer.clone())
            .skeleton_mesh(SkeletonMesh::None);
        let wanted = motion.source.clone().unwrap_or_default();
        let is_it = |origin: &Origin| is_same_file(&wanted, origin);
        for file in self.seconds.iter().map(PathBuf::as_path).chain(source) {
            let scene = importer.clone().import(file)?;
            if scene.metadata.origin.as_ref().is_some_and(is_it) {
                return Ok(scene);
            }
        }
        let message = format!(
            "the second motion of the file, \"{}\", is not among the files given",
            wanted.name
        );
        Err(Diagnostic::new(Code::InvalidValue, message)
            .help("name it: mocap verify SOURCE OUTPUT --with FILE")
            .into())
    }

    fn provenance_of(&self, output: &Output<'_>) -> Option<Provenance> {
        output.provenance().or_else(|| self.provenance.clone())
    }

    fn compare(&self, source: &Scene, file: Option<&Path>, output: &Output<'_>) -> Result<Verification> {
        output.check_not_retargeted(source)?;
        let provenance = self.provenance_of(output);
        let steps = provenance.as_ref().map_or(&[][..], |provenance| &provenance.steps);
        let original = source;
        let edited = change::edited(original, steps, &|motion| self.second(motion, file))?;
        let (source, steps) = match &edited {
            Some((scene, done)) => (scene, &steps[*done..]),
            None => (source, steps),
        };
        let ours = Skeleton::of_scene(source, None);
        let theirs = output.skeleton(None)?;
        let pairs = Pairs::new(&ours, &theirs)?;
        let change = match &provenance {
            Some(_) => Change::recorded(steps),
            None => Change::guessed(
                &Skeleton::of_scene(source, Some(0)),
                &output.skeleton(Some(0))?,
                &pairs,
                output.stated_unit(source),
            ),
        };
        let mut verification = Verification {
            joints: pairs.list.len(),
            missing: pairs.missing(&ours, NodeKind::Joint),
            missing_end_sites: pairs.missing(&ours, NodeKind::EndSite),
            metres_per_unit: change.metres_per_unit,
            has_provenance: output.provenance().is_some(),
            ..Verification::default()
        };
        let is_ours = output.provenance().is_some();
        match change.humanoid {
            // Joints that are no bones are left out, and the others hang together as VRM demands.
            Some(_) => verification.findings.extend(output.missing_bones()),
            None => pairs.find(
                &ours,
                &theirs,
                is_ours,
                change.has_root_motion,
                &mut verification.findings,
            ),
        }
        if let Some(provenance) = output.provenance() {
            claims(original, source, &provenance, &change, &mut verification.findings)?;
        }
        let compared = clip::Compared {
            pairs: &pairs,
            change: &change,
            metres: output.metres_per_unit(source, &change),
            is_gltf: matches!(output, Output::Gltf(_)),
            turns: output.keeps_axes(source),
        };
        let (mut errors, mut lost) = (Errors::default(), Errors::default());
        let mut has_lost = false;
        for (ours_clip, theirs_clip) in clip::matched(source, output, &change, &mut verification.findings)? {
            let timeline = Timeline::new(source, ours_clip, &change)?;
            let ours = Skeleton::of_scene(source, ours_clip);
            let theirs = output.skeleton(theirs_clip)?;
            if let (Some(clip), Some(_)) = (ours_clip, theirs_clip) {
                let name = clip::name_of(source, clip);
                timeline.find(&name, &ours, &theirs, &mut verification.findings);
            }
            let of_clip = compared.frames(ours_clip, &ours, &theirs, &timeline, &timeline.moments);
            if timeline.is_resampled {
                let mut frames = timeline.source_frames();
                // What is left after the last whole frame of the file is less than one, and gone.
                let end = timeline.moments.last().copied().unwrap_or(0.0);
                frames.retain(|frame| *frame <= end);
                lost.add_all(&compared.frames(ours_clip, &ours, &theirs, &timeline, &frames));
                has_lost = true;
            }
            verification.clips.extend(ours_clip.map(|clip| VerifiedClip {
                name: source.animations[clip].name.clone(),
                frames: of_clip.frames,
                max_error: of_clip.max,
            }));
            errors.add_all(&of_clip);
        }
        verification.frames = errors.frames;
        verification.max_error = errors.max;
        verification.rms_error = errors.rms();
        verification.turn_error = errors.turn;
        verification.resampling = has_lost.then(|| Resampling {
            frames: lost.frames,
            max_error: lost.max,
            rms_error: lost.rms(),
            worst: lost.worst,
        });
        verification.worst = errors.worst;
        Ok(verification)
    }
}

impl Provenance {
    /// `importer`, reading the source as it was read for the conversion.
    fn importer(&self, mut importer: Importer) -> Importer {
        if let Some(used) = &self.root_offset {
            importer = importer.root_offset(used.policy);
        }
        if let Some(origin) = self.source.as_ref().filter(|origin| origin.frame_time > 0.0) {
            importer = importer.frame_rate(origin.frame_time.recip());
        }
        for step in &self.steps {
            if let AppliedStep::SelectClip { index } = step {
                importer = importer.clips(Clips::Index(*index));
            }
        }
        importer
    }
}

/// Whether two files are one: by their hashes, else by their names.
fn is_same_file(a: &Origin, b: &Origin) -> bool {
    match a.sha256.is_empty() || b.sha256.is_empty() {
        true => a.name == b.name,
        false => a.sha256 == b.sha256,
    }
}

/// Holds what a file says of its frames against what is to be in it.
fn claims(
    original: &Scene,
    source: &Scene,
    provenance: &Provenance,
    change: &Change,
    findings: &mut Vec<Finding>,
) -> Result<()> {
    let mut claim = |what: &str, claimed: u64, found: u64| {
        if claimed != found {
            let message = format!("the file says that {what} {claimed} frames, but there are {found}");
            findings.push(Finding::new(FindingKind::Provenance, message));
        }
    };
    let frames = |scene: &Scene| scene.animations.first().map_or(0, |clip| clip.frame_count() as u64);
    if let Some(origin) = &provenance.source {
        claim("its source has", origin.frames, frames(original));
    }
    if !source.animations.is_empty() {
        let timeline = Timeline::new(source, Some(0), change)?;
        claim("it has", provenance.frames, timeline.frame_count());
    }
    Ok(())
}

/// A file that was written.
enum Output<'a> {
    Gltf(Box<File<'a>>),
    /// Another format, as its reader gives it, and what the file says of itself.
    Scene(Box<Scene>, Option<Box<Provenance>>),
}

impl<'a> Output<'a> {
    fn read(bytes: &'a [u8], name: &Path, open: &dyn Fn(&Path) -> Result<Vec<u8>>) -> Result<Self> {
        if File::sniff(bytes) {
            return Ok(Self::Gltf(Box::new(File::read(bytes, open, &Limits::default())?)));
        }
        let importer = Importer::new().skeleton_mesh(SkeletonMesh::None).hash(false);
        let provenance = fbx::provenance(bytes).map(Box::new);
        if provenance.is_some() && !fbx::is_whole(bytes) {
            let message = "the file does not end with the footer that every FBX file has";
            return Err(Diagnostic::new(Code::UnexpectedEnd, message)
                .help("it was cut off, or changed, after it was written; write it again")
                .into());
        }
        Ok(Self::Scene(Box::new(importer.read(bytes, name)?), provenance))
    }

    fn provenance(&self) -> Option<Provenance> {
        match self {
            Self::Gltf(file) => file.provenance(),
            Self::Scene(_, provenance) => provenance.as_deref().cloned(),
        }
    }

    /// Refuses a motion on another skeleton: its joints are elsewhere on purpose.
    fn check_not_retargeted(&self, source: &Scene) -> Result<()> {
        // Other animations of a character may still be compared with what it was before.
        let is_source = |provenance: &Provenance| {
            let origins = (provenance.source.as_ref(), source.metadata.origin.as_ref());
            matches!(origins, (Some(recorded), Some(found)) if is_same_file(recorded, found))
        };
        let added: Vec<Provenance> = match self {
            Self::Gltf(file) => file.provenances_of_animations().filter(is_source).collect(),
            Self::Scene(..) => Vec::new(),
        };
        let all = self.provenance().into_iter().chain(added);
        let Some(onto) = all.filter_map(|provenance| provenance.onto().cloned()).next() else {
            return Ok(());
        };
        let name = onto
            .source
            .map_or_else(String::new, |origin| format!(" of \"{}\"", origin.name));
        let message = format!("the motion is on the skeleton{name}, so its joints are elsewhere than in the source");
        Err(Diagnostic::new(Code::Unrepresentable, message)
            .help("mocap retarget measures how far the limbs of both are apart: see --json and --max-angle")
            .into())
    }

    /// The nodes and the keys of a clip; without one, the rest pose.
    fn skeleton(&self, clip: Option<usize>) -> Result<Skeleton<'_>> {
        match self {
            Self::Gltf(file) => Skeleton::of_file(file, clip),
            Self::Scene(scene, _) => Ok(Skeleton::of_scene(scene, clip)),
        }
    }

    /// Says so where a VRM animation lacks bones that it must have.
    fn missing_bones(&self) -> Option<Finding> {
        let Self::Gltf(file) = self else { return None };
        let missing = file.missing_bones();
        let message = || {
            format!(
                "no node is the bone {}, which a VRM animation must have",
                missing.join(", ")
            )
        };
        (!missing.is_empty()).then(|| Finding::new(FindingKind::MissingJoint, message()))
    }

    fn clip_names(&self) -> Vec<String> {
        match self {
            Self::Gltf(file) => {
                let clips = file.animations();
                clips.map(|clip| clip.name.clone().unwrap_or_default()).collect()
            }
            Self::Scene(scene, _) => scene.animations.iter().map(|clip| clip.name.clone()).collect(),
        }
    }

    /// Units of the file in one of the source, where the file states its unit.
    fn stated_unit(&self, source: &Scene) -> Option<f64> {
        let Self::Scene(scene, _) = self else { return None };
        scene.metadata.metres_per_unit.map(|metres| metres_of(source) / metres)
    }

    /// Metres in a unit of the file: what the file says, else the unit of the source.
    fn metres_per_unit(&self, source: &Scene, change: &Change) -> f64 {
        let Self::Scene(scene, _) = self else { return 1.0 };
        match scene.metadata.metres_per_unit {
            Some(metres) => metres,
            None => change
                .out_metres_per_unit
                .unwrap_or_else(|| metres_of(source) / change.metres_per_unit),
        }
    }

    /// Whether the joints have the axes of the source: in glTF of this crate, in its FBX where the axes of the file are
    /// those of the scene, and in BVH that was made of BVH.
    fn keeps_axes(&self, source: &Scene) -> bool {
        match self {
            Self::Gltf(file) => file.provenance().is_some(),
            Self::Scene(_, Some(provenance)) => provenance.up.is_none(),
            Self::Scene(scene, None) => {
                scene.metadata.format == source.metadata.format && source.metadata.format == Some(Format::Bvh)
            }
        }
    }
}

/// Metres in a unit of the source: what it states, else what is guessed.
fn metres_of(source: &Scene) -> f64 {
    let stated = source.metadata.metres_per_unit;
    stated.unwrap_or_else(|| figure::survey(source).unit.value.metres())
}
