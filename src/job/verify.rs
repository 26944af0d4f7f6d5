//! Proof that a motion survived: where a written file puts every joint at every frame of every clip, against its
//! source.
//!
//! Both sides are computed in double precision by kinematics of their own, and the file is read back by a reader, which
//! did not write it. The moment of a frame in glTF is the 32-bit number of seconds next to it, for glTF has no other.
//!
//! What the conversion did on purpose (unit, up axis, trim, frame rate, in place, edits) is in the [`Provenance`] of
//! glTF and FBX files of this crate, or in a file beside BVH, and is done to the source as well. Elsewhere the unit is
//! taken from the lengths of the links, and must be a unit of length; the up axis from what fits the first frame
//! better; and the motion is said to be whole.
//!
//! Joints are paired by their names, those of one name or without one by what stands above them; clips by their names,
//! or in their order where the format has no names. Each clip keeps its own frame rate. A cubic curve is looked at
//! between its keys too; BVH, FBX and markers, which are read as a pose for each frame, at their frames alone.
//! Rotations that move no joint show in points 3 cm away.
//!
//! A VRM animation has only the bones of a humanoid, in another rest pose. Compared are the positions of those that
//! stand on bones alone, and how each of them has rotated since the first frame. A joint that is left out and moves has
//! a part in both.
//!
//! A motion that was put on another skeleton cannot be compared so, and is refused.
//!
//! Distances are one half of the proof. The other are [`Finding`]s: frames that are missing at either end, clips or
//! joints that are missing, renamed or too many, joints on another parent, keys that step, lengths in no unit, a skin
//! that is bound elsewhere, another source than the file names. A file is what its source is where there is no finding
//! and no distance beyond the allowed; [`Verification::is_within`] says so.

mod arrays;
mod chain;
mod change;
mod claims;
mod clip;
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
mod report;
mod skin;
mod timeline;
mod trc;
mod units;

use std::cell::OnceCell;
use std::path::{Path, PathBuf};

use mocap_formats::gltf::Provenance;
use mocap_io::import::Importer;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::process::SkeletonMesh;
use mocap_scene::scene::{AppliedStep, Format, NodeKind, Origin, Scene, SecondMotion};

use crate::SourceSpace;

use self::chain::Skeleton;
use self::change::Change;
use self::claims::{claims, import_source, is_same_file};
use self::clip::Errors;
use self::output::{Output, metres_of};
use self::pairs::Pairs;
use self::rates::Rates;
pub use self::report::{Finding, FindingKind, Resampling, Verification, VerifiedClip, Worst};
use self::timeline::Timeline;
use self::units::Space;
#[cfg(feature = "npz")]
use mocap_formats::usd;

impl Verification {
    /// Compares `output`, the bytes of a `.glb`, of a `.gltf` with its buffer inside, or of any other file that is
    /// read, with `source`, the scene that its source file reads as, before any step that moves things.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::gltf::GltfOptions;
    /// use mocap::verify::Verification;
    ///
    /// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let verified = Verification::of(&scene, &GltfOptions::default().write_glb(&scene)?)?;
    /// assert_eq!((verified.frames, verified.joints), (10, 4));
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
/// use mocap::gltf::Provenance;
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
            let importer = self.importer.clone().skeleton_mesh(SkeletonMesh::None);
            let scene = import_source(&file.header.provenance, importer, source.as_ref())?;
            return arrays::compare(&scene, &file).map_err(|error| error.with_path(path));
        }
        let open = |sibling: &Path| opener.open(&path.with_file_name(sibling));
        let read = |rate| Output::read(&bytes, path, &open, rate).map_err(|error| error.with_path(path));
        let source = source.as_ref();
        let mut output = read(None)?;
        let is_copy = self.provenance.is_none() && is_of_same_steps(&output, source);
        if is_copy {
            output.forget_provenance();
        }
        let read = |rate| {
            let mut output = read(rate)?;
            if is_copy {
                output.forget_provenance();
            }
            Ok(output)
        };
        let importer = self.importer.clone().skeleton_mesh(SkeletonMesh::None);
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
    /// FBX has keys between its frames then.
    fn sampled<'a>(
        &self,
        output: Output<'a>,
        source: &Scene,
        read: &dyn Fn(Option<f64>) -> Result<Output<'a>>,
    ) -> Result<Output<'a>> {
        let provenance = self.provenance_of(&output);
        let steps = provenance.as_ref().map_or(&[][..], |provenance| &provenance.steps);
        if output.format() != Some(Format::Fbx) {
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
        let importer = self.importer.clone().skeleton_mesh(SkeletonMesh::None);
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
            .help("name it: mocap verify SOURCE OUTPUT --with FILE")
            .into())
    }

    fn provenance_of(&self, output: &Output<'_>) -> Option<Provenance> {
        output.provenance().or_else(|| self.provenance.clone())
    }

    fn compare(&self, source: &Scene, file: Option<&Path>, output: &Output<'_>) -> Result<Verification> {
        let given = self.provenance.as_ref();
        output.check_not_retargeted(source, given)?;
        let is_of_character = output.is_of_character(source, given);
        let provenance = output
            .provenance_of_character(source, given)
            .or_else(|| self.provenance_of(output));
        let steps = provenance.as_ref().map_or(&[][..], |provenance| &provenance.steps);
        let all_steps = steps;
        let original = source;
        let second = |motion: &SecondMotion| self.second(motion, file);
        let replay = change::Replay {
            second: &second,
            keeps_units: output.keeps_units(),
        };
        let edited = replay.edits(original, steps)?;
        let (source, steps) = match &edited {
            Some((scene, done)) => (scene, &steps[*done..]),
            None => (source, steps),
        };
        let takes_new_axes = steps.iter().any(AppliedStep::takes_new_axes);
        let named = change::named(source, steps);
        let source = named.as_ref().unwrap_or(source);
        let ours = Skeleton::of_scene(source, None);
        let theirs = output.skeleton(None)?;
        let pairs = Pairs::new(&ours, &theirs)?;
        // The clips of one name may stand in another order in the file.
        let clips = clip::pairs(source, output).into_iter().enumerate();
        let shown = clips.filter_map(|(ours, theirs)| Some((ours, theirs?))).next();
        // Of a character the rest pose is compared: its clips are those of other files.
        let shown = match is_of_character {
            true => (None, None),
            false => shown.map_or((Some(0), Some(0)), |(ours, theirs)| (Some(ours), Some(theirs))),
        };
        let change = match &provenance {
            Some(_) => Change::recorded(steps).in_unit_of(output.written_unit()),
            None => Change::guessed(
                &Skeleton::of_scene(source, shown.0),
                &output.skeleton(shown.1)?,
                &pairs,
                metres_of(source),
                output.stated_unit(source),
            ),
        };
        let pairs = match change.humanoid {
            Some(_) => pairs.of_bones(source, &ours, &theirs)?,
            None => pairs,
        };
        if is_of_character && !output.has_rest_of(source, &change) {
            let message = "the file has no rest pose of the body, and its motion is that of another file";
            return Err(Diagnostic::new(Code::Unrepresentable, message)
                .help("write the motion as .glb too, and compare that with the body")
                .into());
        }
        // Joints of BVH rest without a rotation, so that another up axis turns their axes. A file alone does not say
        // that it has another rest pose on purpose.
        let is_bvh = output.format() == Some(Format::Bvh);
        let has_new_axes = takes_new_axes
            || is_bvh && change.has_another_up()
            || provenance.is_none() && change.rests_elsewhere(&pairs, &ours, &theirs);
        let mut verification = Verification {
            joints: pairs.list.len(),
            missing: pairs.missing(&ours, NodeKind::Joint),
            missing_end_sites: pairs.missing(&ours, NodeKind::EndSite),
            metres_per_unit: change.metres_per_unit,
            has_provenance: output.is_ours(),
            ..Verification::default()
        };
        let is_ours = output.is_ours();
        verification.findings.extend(change.finding());
        let expected = match &provenance {
            Some(_) => Space::recorded(source, steps),
            None => Space::guessed(source, &change),
        };
        expected.find(
            output.stated(provenance.is_some()),
            provenance.is_some(),
            &mut verification.findings,
        );
        match change.humanoid {
            // Joints that are no bones are left out, and the others hang together as VRM demands.
            Some(_) => verification.findings.extend(output.missing_bones()),
            None => pairs.find(&ours, &theirs, is_ours, change.added_roots, &mut verification.findings),
        }
        if output.is_of_points() {
            verification
                .findings
                .retain(|found| found.kind != FindingKind::MovedJoint);
        }
        let replayed = |scene: &Scene| {
            let scene = replay.steps(scene, all_steps).ok()?;
            let named = change::named(&scene, all_steps);
            Some(named.unwrap_or(scene))
        };
        if let Some(skinned) = output.skinned() {
            let own_meshes = Importer::new()
                .gltf_meshes(true)
                .skeleton_mesh(SkeletonMesh::Own)
                .hash(false);
            let read = OnceCell::new();
            let with_meshes = || match file {
                Some(path) => read.get_or_init(|| own_meshes.import(path).ok()).as_ref(),
                None => Some(original),
            };
            let keeps_axes = output.keeps_axes(source) && !has_new_axes;
            // The steps change bind poses too.
            let bound = || replayed(with_meshes()?);
            let found = skin::find(source, skinned, (&change, keeps_axes), &bound);
            verification.findings.extend(found);
            // Vertices are compared with those of the file, before its steps.
            let unchanged = || {
                let scene = with_meshes()?;
                Some(change::named(scene, all_steps).unwrap_or_else(|| scene.clone()))
            };
            let whole = provenance.as_ref().map(|all| Change::recorded(&all.steps));
            let change = whole.as_ref().unwrap_or(&change);
            let named = change::named(original, all_steps);
            let unchanged_joints = Skeleton::of_scene(named.as_ref().unwrap_or(original), None);
            let unchanged_pairs = Pairs::new(&unchanged_joints, &theirs);
            let rests_there =
                unchanged_pairs.is_ok_and(|pairs| !change.rests_elsewhere(&pairs, &unchanged_joints, &theirs));
            let keeps_rest = !has_new_axes && rests_there;
            let found = mesh::find(&unchanged, skinned, change, keeps_rest);
            verification.findings.extend(found);
        }
        verification.findings.extend(output.miscounted());
        verification.findings.extend(output.find_in_character(original)?);
        if let Some(provenance) = output.provenance().filter(|_| !is_of_character) {
            let timeline = (!source.animations.is_empty()).then(|| Timeline::new(source, Some(0), &change));
            let frames = timeline.transpose()?.map(|timeline| timeline.frame_count());
            claims(original, &provenance, frames, &mut verification.findings);
        }
        let metres = output.metres_per_unit(source, &change);
        let compared = clip::Compared {
            pairs: &pairs,
            change: &change,
            metres,
            skin: clip::skin_of(&ours, metres * change.metres_per_unit),
            is_gltf: output.format() == Some(Format::Gltf),
            is_packed: output.format() == Some(Format::Mclip),
            rotations: output.keeps_axes(source) && !has_new_axes,
            new_axes: None,
        };
        // Where steps give joints other axes, the steps themselves say which.
        let replayed = match takes_new_axes && output.keeps_axes(source) {
            true => replayed(original),
            false => None,
        };
        let allowed = self.max_error.unwrap_or(timeline::SMALLEST_MOTION);
        let (mut errors, mut lost) = (Errors::default(), Errors::default());
        let mut has_lost = false;
        let clips = match is_of_character {
            true => vec![(None, None)],
            false => clip::matched(source, output, &change, &mut verification.findings)?,
        };
        for (ours_clip, theirs_clip) in clips {
            let timeline = Timeline::new(source, ours_clip, &change)?;
            let timeline = match output.has_key_times() {
                true => timeline,
                false => timeline.of_whole_frames(),
            };
            let ours = Skeleton::of_scene(source, ours_clip);
            let theirs = output.skeleton(theirs_clip)?;
            let new_axes = replayed
                .as_ref()
                .and_then(|replayed| compared.axes_of(replayed, (ours_clip, &ours), &timeline));
            let compared = clip::Compared { new_axes, ..compared };
            let mut of_clip = compared.frames(ours_clip, &ours, &theirs, &timeline, &timeline.moments);
            if let (Some(clip), Some(_)) = (ours_clip, theirs_clip) {
                let name = clip::name_of(source, clip);
                timeline.find(
                    &name,
                    &ours,
                    &theirs,
                    (of_clip.farthest(), allowed),
                    &mut verification.findings,
                );
                if change.humanoid.is_some() {
                    let missing = face::compare((clip, &name), &ours, &theirs, &timeline, &mut of_clip);
                    verification.findings.extend(missing);
                }
            }
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
        // Points have no rotations.
        verification.rotation_error = errors.rotation.filter(|_| !output.is_of_points());
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

/// Whether the source says of itself what the output says, as a copy does: no step lies between the two.
fn is_of_same_steps(output: &Output<'_>, source: &Path) -> bool {
    let Some(provenance) = output.provenance() else {
        return false;
    };
    let opener = Importer::new();
    let open = |sibling: &Path| opener.open(&source.with_file_name(sibling));
    let stated = opener
        .open(source)
        .and_then(|bytes| output::provenance_of(&bytes, source, &open));
    stated.is_ok_and(|stated| stated.is_some_and(|stated| stated == provenance))
}
