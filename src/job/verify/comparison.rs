//! The comparison of a source with a written file, phase by phase.

use std::borrow::Cow;
use std::cell::OnceCell;
use std::path::Path;

use mocap_formats::gltf::report::Provenance;
use mocap_io::import::Importer;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::process::SkeletonMesh;
use mocap_scene::scene::report::AppliedStep;
use mocap_scene::scene::{NodeKind, Scene};

use super::chain::Skeleton;
use super::change::{Change, Replay, named};
use super::claims::claims;
use super::clip::{self, ComparisonBasis, Errors};
use super::output::{Output, metres_of};
use super::pairs::Pairs;
use super::timeline::Timeline;
use super::units::Space;
use super::{Finding, FindingKind, Resampling, Verification, VerifiedClip, face, mesh, skin};

/// A comparison: the source, the written file, and the known changes between them.
pub(super) struct Comparison<'a> {
    /// The scene of the source, before any step.
    pub(super) original: &'a Scene,
    /// The file of the source, if any.
    pub(super) file: Option<&'a Path>,
    pub(super) output: &'a Output<'a>,
    /// The changes between source and file, if known.
    pub(super) provenance: Option<Provenance>,
    /// Whether the source is a character with retargeted motion. The file then lacks the character's own clips.
    pub(super) is_of_character: bool,
    /// The largest error that the caller allows, in metres. A smaller motion may be lost.
    pub(super) allowed: f64,
    pub(super) replay: Replay<'a>,
}

/// The source after the replayed steps, with the new names of its joints.
struct Expected<'a> {
    scene: Cow<'a, Scene>,
    /// The steps after the last edit. Their effect is computed for each point.
    steps: &'a [AppliedStep],
}

/// The joints of the source and of the file, and the intended changes.
struct Joints<'a> {
    ours: Skeleton<'a>,
    theirs: Skeleton<'a>,
    pairs: Pairs,
    change: Change,
    /// Whether joints intentionally have other axes in the file.
    has_new_axes: bool,
}

impl<'a> Comparison<'a> {
    pub(super) fn run(&self) -> Result<Verification> {
        let expected = self.replay_edits()?;
        let joints = self.pair_joints(&expected)?;
        let compared = joints.pairs.list.iter().map(|(ours, _)| *ours);
        let [joint_count, end_sites] = joints.ours.count(compared);
        let mut verification = Verification {
            joints: joint_count,
            end_sites,
            missing: joints.pairs.missing(&joints.ours, NodeKind::Joint),
            missing_end_sites: joints.pairs.missing(&joints.ours, NodeKind::EndSite),
            metres_per_unit: joints.change.metres_per_unit,
            has_provenance: self.output.is_ours(),
            ..Verification::default()
        };
        let findings = &mut verification.findings;
        self.check_space(&expected, &joints, findings);
        self.check_joints(&joints, findings);
        self.check_meshes(&expected, &joints, findings);
        findings.extend(self.output.miscounted());
        findings.extend(self.output.find_in_character(self.original)?);
        self.check_claims(&expected, &joints, findings)?;
        self.compare_clips(&expected, &joints, &mut verification)?;
        Ok(verification)
    }

    fn steps(&self) -> &[AppliedStep] {
        self.provenance.as_ref().map_or(&[][..], |provenance| &provenance.steps)
    }

    /// Applies the edits that the file records to the source.
    fn replay_edits(&self) -> Result<Expected<'_>> {
        let (scene, done) = match self.replay.edits(self.original, self.steps())? {
            Some((scene, done)) => (Cow::Owned(scene), done),
            None => (Cow::Borrowed(self.original), 0),
        };
        let steps = &self.steps()[done..];
        let scene = named(&scene, steps).map_or(scene, Cow::Owned);
        Ok(Expected { scene, steps })
    }

    /// A scene after all steps.
    fn replay_all(&self, scene: &Scene) -> Option<Scene> {
        let scene = self.replay.steps(scene, self.steps()).ok()?;
        Some(named(&scene, self.steps()).unwrap_or(scene))
    }

    /// Pairs the joints of the source with the joints of the file.
    fn pair_joints<'e>(&'e self, expected: &'e Expected<'_>) -> Result<Joints<'e>> {
        let (source, output) = (&*expected.scene, self.output);
        let ours = Skeleton::of_scene(source, None);
        let theirs = self.theirs(None)?;
        let pairs = Pairs::new(&ours, &theirs)?;
        let change = match &self.provenance {
            Some(_) => Change::recorded(expected.steps).in_unit_of(output.written_unit()),
            None => {
                let (here, there) = self.shown_clips(source);
                Change::guessed(
                    &Skeleton::of_scene(source, here),
                    &output.skeleton(there)?,
                    &pairs,
                    metres_of(source),
                    output.stated_unit(source),
                )
            }
        };
        let pairs = match change.humanoid {
            Some(_) => pairs.of_bones(source, &ours, &theirs)?,
            None => pairs,
        };
        if self.is_of_character && !output.has_rest_of(source, &change) {
            let message = "the file does not have the rest pose of the body, so it cannot be compared with the body";
            return Err(Diagnostic::new(Code::Unrepresentable, message)
                .help("write the motion as .glb too, and compare the .glb with the body")
                .into());
        }
        // If joints rest without a rotation, another up axis rotates their axes. Without a record, a different rest
        // pose counts as an error.
        let has_new_axes = expected.takes_new_axes()
            || !output.row().has_rest_rotations && change.has_another_up()
            || self.provenance.is_none() && change.rests_elsewhere(&pairs, &ours, &theirs);
        Ok(Joints {
            ours,
            theirs,
            pairs,
            change,
            has_new_axes,
        })
    }

    /// The joints of the output in a clip. The joints of a character are compared at rest.
    fn theirs(&self, clip: Option<usize>) -> Result<Skeleton<'_>> {
        match self.is_of_character {
            true => self.output.rest(),
            false => self.output.skeleton(clip),
        }
    }

    /// A clip of the source and its clip of the file. These clips determine an unknown unit and up axis.
    fn shown_clips(&self, source: &Scene) -> (Option<usize>, Option<usize>) {
        // For a character, the rest pose is compared: its clips come from other files.
        if self.is_of_character {
            return (None, None);
        }
        // The clips of the file may be in another order, so the first clip of each may not be a pair.
        let clips = clip::pairs(source, self.output).into_iter().enumerate();
        let shown = clips.filter_map(|(ours, theirs)| Some((ours, theirs?))).next();
        shown.map_or((Some(0), Some(0)), |(ours, theirs)| (Some(ours), Some(theirs)))
    }

    /// Checks the unit and the axes that the file states.
    fn check_space(&self, expected: &Expected<'_>, joints: &Joints<'_>, findings: &mut Vec<Finding>) {
        findings.extend(joints.change.finding());
        let is_recorded = self.provenance.is_some();
        let space = match is_recorded {
            true => Space::recorded(&expected.scene, expected.steps),
            false => Space::guessed(&expected.scene, &joints.change),
        };
        space.find(self.output.stated(is_recorded), is_recorded, findings);
    }

    /// Checks that the hierarchy of joints equals the source's hierarchy.
    fn check_joints(&self, joints: &Joints<'_>, findings: &mut Vec<Finding>) {
        let (ours, theirs, change) = (&joints.ours, &joints.theirs, &joints.change);
        match change.humanoid {
            // Joints that are not bones are omitted. The hierarchy of the bones follows the VRM specification.
            Some(_) => findings.extend(self.output.missing_bones()),
            None => {
                let is_ours = self.output.is_ours();
                joints.pairs.find(ours, theirs, is_ours, change.added_roots, findings);
            }
        }
        if self.output.is_of_points() {
            findings.retain(|found| found.kind != FindingKind::MovedJoint);
        }
    }

    /// Checks the skin and the meshes of a file of this crate.
    fn check_meshes(&self, expected: &Expected<'_>, joints: &Joints<'_>, findings: &mut Vec<Finding>) {
        let Some(skinned) = self.output.skinned() else { return };
        let own_meshes = Importer::new()
            .gltf_meshes(true)
            .skeleton_mesh(SkeletonMesh::Own)
            .hash(false);
        let read = OnceCell::new();
        let with_meshes = || match self.file {
            Some(path) => read.get_or_init(|| own_meshes.import(path).ok()).as_ref(),
            None => Some(self.original),
        };
        let keeps_axes = self.output.keeps_axes(&expected.scene) && !joints.has_new_axes;
        // Steps also change bind poses.
        let bound = || self.replay_all(with_meshes()?);
        findings.extend(skin::find(
            &expected.scene,
            skinned,
            (&joints.change, keeps_axes),
            &bound,
        ));

        // Vertices are compared with the source file's vertices, before any step.
        let unchanged = || {
            let scene = with_meshes()?;
            Some(named(scene, self.steps()).unwrap_or_else(|| scene.clone()))
        };
        let whole = self.provenance.as_ref().map(|all| Change::recorded(&all.steps));
        let change = whole.as_ref().unwrap_or(&joints.change);
        let named = named(self.original, self.steps());
        let ours = Skeleton::of_scene(named.as_ref().unwrap_or(self.original), None);
        let pairs = Pairs::new(&ours, &joints.theirs);
        let rests_there = pairs.is_ok_and(|pairs| !change.rests_elsewhere(&pairs, &ours, &joints.theirs));
        let keeps_rest = rests_there && !joints.has_new_axes;
        findings.extend(mesh::find(&unchanged, skinned, change, keeps_rest));
    }

    /// Checks the file's statements about its source.
    fn check_claims(&self, expected: &Expected<'_>, joints: &Joints<'_>, findings: &mut Vec<Finding>) -> Result<()> {
        let Some(provenance) = self.output.provenance().filter(|_| !self.is_of_character) else {
            return Ok(());
        };
        let has_clips = !expected.scene.animations.is_empty();
        let timeline = has_clips.then(|| Timeline::new(&expected.scene, Some(0), &joints.change));
        let frames = timeline.transpose()?.map(|timeline| timeline.frame_count());
        claims(self.original, &provenance, frames, findings);
        Ok(())
    }

    /// Compares joint positions, clip by clip and frame by frame.
    fn compare_clips(
        &self,
        expected: &Expected<'_>,
        joints: &Joints<'_>,
        verification: &mut Verification,
    ) -> Result<()> {
        let (source, output) = (&*expected.scene, self.output);
        let keeps_axes = output.keeps_axes(source);
        let metres = output.metres_per_unit(source, &joints.change);
        let compared = ComparisonBasis {
            pairs: &joints.pairs,
            change: &joints.change,
            metres,
            skin: clip::skin_of(&joints.ours, metres * joints.change.metres_per_unit),
            has_short_times: output.has_short_times(),
            is_packed: output.row().is_packed,
            rotations: keeps_axes && !joints.has_new_axes,
            new_axes: None,
        };
        // If steps change the axes of joints, the steps determine the new axes.
        let replayed = match keeps_axes && expected.takes_new_axes() {
            true => self.replay_all(self.original),
            false => None,
        };
        let clips = match self.is_of_character {
            true => vec![(None, None)],
            false => clip::matched(source, output, &joints.change, &mut verification.findings)?,
        };
        let (mut errors, mut lost) = (Errors::default(), None);
        for clips in clips {
            let of_clip = self.compare_clip(source, clips, compared.clone(), replayed.as_ref(), verification)?;
            if let Some(of_frames) = of_clip.lost {
                lost.get_or_insert_with(Errors::default).add_all(&of_frames);
            }
            errors.add_all(&of_clip.errors);
        }
        verification.frames = errors.frames;
        verification.max_error = errors.max;
        verification.rms_error = errors.rms();
        // Points have no rotations.
        verification.rotation_error = errors.rotation.filter(|_| !output.is_of_points());
        verification.resampling = lost.map(|lost| Resampling {
            frames: lost.frames,
            max_error: lost.max,
            rms_error: lost.rms(),
            worst: lost.worst,
        });
        verification.worst = errors.worst;
        Ok(())
    }

    /// Compares a clip of the source with its clip of the file.
    fn compare_clip(
        &self,
        source: &Scene,
        (here, there): (Option<usize>, Option<usize>),
        mut compared: ComparisonBasis<'_>,
        replayed: Option<&Scene>,
        verification: &mut Verification,
    ) -> Result<ClipDeviation> {
        let change = compared.change;
        let timeline = Timeline::new(source, here, change)?;
        let timeline = match self.output.row().has_key_times {
            true => timeline,
            false => timeline.of_whole_frames(),
        };
        let ours = Skeleton::of_scene(source, here);
        let theirs = self.theirs(there)?;
        compared.new_axes = replayed.and_then(|replayed| compared.axes_of(replayed, (here, &ours), &timeline));
        let mut errors = compared.frames(here, &ours, &theirs, &timeline, &timeline.moments);
        let findings = &mut verification.findings;
        if let (Some(clip), Some(_)) = (here, there) {
            let name = clip::name_of(source, clip);
            timeline.find(&name, &ours, &theirs, (errors.farthest(), self.allowed), findings);
            if change.humanoid.is_some() {
                findings.extend(face::compare((clip, &name), &ours, &theirs, &timeline, &mut errors));
            }
        }
        let lost = timeline.is_resampled.then(|| {
            let mut frames = timeline.source_frames();
            // The motion after the last whole frame of the file is shorter than a frame, and is not in the file.
            let end = timeline.moments.last().copied().unwrap_or(0.0);
            frames.retain(|frame| *frame <= end);
            compared.frames(here, &ours, &theirs, &timeline, &frames)
        });
        verification.clips.extend(here.map(|clip| VerifiedClip {
            name: source.animations[clip].name.clone(),
            frames: errors.frames,
            max_error: errors.max,
        }));
        Ok(ClipDeviation { errors, lost })
    }
}

/// The deviation of a clip of the file from its source.
struct ClipDeviation {
    /// Errors at the frames of the file.
    errors: Errors,
    /// Errors at the frames of the source, if its frames differ.
    lost: Option<Errors>,
}

impl Expected<'_> {
    /// Whether a remaining step changes the axes of joints.
    fn takes_new_axes(&self) -> bool {
        self.steps.iter().any(AppliedStep::takes_new_axes)
    }
}
