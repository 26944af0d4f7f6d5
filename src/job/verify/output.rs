//! A written file, as its reader gives it.

use std::collections::HashSet;
use std::path::Path;

use mocap_figure::Figure;
use mocap_formats::gltf::File;
use mocap_formats::gltf::report::Provenance;
use mocap_formats::{Contents, FormatInfo, Sidecar};
use mocap_io::import::Importer;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::Limits;
use mocap_scene::process::SkeletonMesh;
use mocap_scene::scene::report::AppliedStep;
use mocap_scene::scene::report::Origin;
use mocap_scene::scene::{Scene, UpAxis};

use super::chain::Skeleton;
use super::change::Change;
use super::claims::is_same_file;
use super::kept::{self, AnimationChoice, Parts};
use super::units::Space;
use super::{Finding, FindingKind, skin};

/// A written file.
pub(super) enum Output<'a> {
    /// A glTF file. [`Skinned`] is present if mocap wrote the file with a skin. [`Parts`] is present if mocap added
    /// animations to a character's file.
    Gltf(Box<File<'a>>, Option<Box<Skinned>>, Option<Box<Parts>>),
    /// Another format, as its reader gives it, and its provenance.
    Scene(Box<Scene>, Option<Box<Provenance>>),
}

/// The scenes of a glTF file with a skin.
pub(super) struct Skinned {
    /// The nodes of the file in their stored pose, which may be a frame of the motion, with the meshes.
    standing: Scene,
    /// The nodes of the file in the bind pose, which is the rest pose.
    bound: Scene,
}

impl<'a> Output<'a> {
    /// `rate` is the frame rate at which curves are sampled. Default: the rate of the file.
    pub(super) fn read(
        bytes: &'a [u8],
        name: &Path,
        open: &dyn Fn(&Path) -> Result<Vec<u8>>,
        rate: Option<f64>,
    ) -> Result<Self> {
        if File::sniff(bytes) {
            let file = File::read(bytes, open, &Limits::default())?;
            // A skin that was kept equals the source's skin.
            let is_new = file.provenance().is_some() && file.provenance_of_kept().is_none();
            let skinned = match is_new && file.has_skin() {
                true => {
                    let read = |of_nodes| skin::read(file.row(), (bytes, name), open, of_nodes);
                    let (standing, bound) = (read(true)?, read(false)?);
                    Some(Box::new(Skinned { standing, bound }))
                }
                false => None,
            };
            let parts = match file.provenances_of_animations().next() {
                Some(_) => Some(Box::new(Parts::read(bytes, open)?)),
                None => None,
            };
            return Ok(Self::Gltf(Box::new(file), skinned, parts));
        }
        let mut importer = Importer::new().hash(false);
        if let Some(rate) = rate {
            importer = importer.sampling_rate(rate);
        }
        let provenance = FormatInfo::provenance(bytes).map(Box::new);
        // The skin is only checked in files of this crate.
        let has_meshes = provenance.is_some();
        importer = importer.for_comparison(has_meshes).skeleton_mesh(if has_meshes {
            SkeletonMesh::Own
        } else {
            SkeletonMesh::None
        });
        let folder = name.parent().unwrap_or("".as_ref());
        let mut scene = importer.read_beside(bytes, name, &|path| open(path.strip_prefix(folder).unwrap_or(path)))?;
        let row = row_of(&scene);
        scene.warnings.extend((row.inspect)(bytes, &scene)?);
        if row.contents == Contents::Keys {
            let message = format!(
                "{} has no skeleton, so the positions of its joints are unknown",
                row.name
            );
            return Err(Diagnostic::new(Code::Unrepresentable, message)
                .help("write the motion as .glb too, and verify the .glb")
                .into());
        }
        let sidecar = match row.has_sidecar {
            true => sidecar(bytes, name, open)?,
            false => None,
        };
        Ok(Self::Scene(Box::new(scene), provenance.or(sidecar)))
    }

    /// Removes the provenance of the file.
    pub(super) fn forget_provenance(&mut self) {
        match self {
            Self::Gltf(file, skinned, _) => {
                file.forget_provenance();
                *skinned = None;
            }
            Self::Scene(_, provenance) => *provenance = None,
        }
    }

    pub(super) fn provenance(&self) -> Option<Provenance> {
        match self {
            Self::Gltf(file, ..) => file.provenance_of_kept().or_else(|| file.provenance()),
            Self::Scene(_, provenance) => provenance.as_deref().cloned(),
        }
    }

    /// If `source` is the character to which the file's motion was retargeted: the provenance relative to the
    /// character, from the file or else from `given`.
    pub(super) fn provenance_of_character(&self, source: &Scene, given: Option<&Provenance>) -> Option<Provenance> {
        let provenance = self.provenance().or_else(|| given.cloned())?;
        let onto = provenance.onto()?.clone();
        let is_onto = |step: &AppliedStep| matches!(step, AppliedStep::Retarget { .. });
        // The steps on the body, before and after retargeting.
        let after = provenance.steps.iter().rev().take_while(|step| !is_onto(step)).count();
        let after = &provenance.steps[provenance.steps.len() - after..];
        is_file_of(source, onto.source.as_ref()).then(|| Provenance {
            source: onto.source,
            root_offset: onto.root_offset,
            steps: [&*onto.steps, after].concat(),
            ..Provenance::default()
        })
    }

    /// Whether motion of other files was retargeted to `source`, a character or a robot.
    pub(super) fn is_of_character(&self, source: &Scene, given: Option<&Provenance>) -> bool {
        let Self::Gltf(file, ..) = self else {
            return self.is_of_robot(source) || self.provenance_of_character(source, given).is_some();
        };
        let is_onto = |provenance: Provenance| {
            let onto = provenance.onto();
            onto.is_some_and(|onto| is_file_of(source, onto.source.as_ref()))
        };
        self.is_of_robot(source)
            || self.provenance_of_character(source, given).is_some()
            || file.provenance_of_kept().is_none() && file.provenances_of_animations().any(is_onto)
    }

    /// Whether the file has a motion of a robot. One frame is not a motion: some formats store a static robot as one
    /// frame.
    fn is_of_robot(&self, source: &Scene) -> bool {
        let moves = match self {
            Self::Gltf(file, ..) => file.animations().next().is_some(),
            Self::Scene(scene, _) => scene.animations.iter().any(|clip| clip.frame_count() > 1),
        };
        moves && is_robot(source)
    }

    /// Whether the file has other clips of its source, besides the changed clip.
    pub(super) fn keeps_other_clips(&self) -> bool {
        self.only_clip().is_some()
    }

    /// The changed clip in a file with other clips.
    fn only_clip(&self) -> Option<usize> {
        let Self::Gltf(file, ..) = self else { return None };
        let provenance = file.provenance_of_kept()?;
        provenance.steps.iter().find_map(|step| match step {
            AppliedStep::SelectClip { index } => Some(*index),
            _ => None,
        })
    }

    /// Finds missing or different contents of the character's file to which this crate added animations.
    ///
    /// # Errors
    /// If the file of the character is broken.
    pub(super) fn find_in_character(&self, source: &Scene) -> Result<Vec<Finding>> {
        let (Self::Gltf(_, _, Some(parts)), Some(original)) = (self, &source.original) else {
            return Ok(Vec::new());
        };
        let changed = match (self.is_of_character(source, None), self.only_clip()) {
            (true, _) => AnimationChoice::Added,
            (false, Some(clip)) => AnimationChoice::One(clip),
            (false, None) => AnimationChoice::All,
        };
        kept::find(&original.file, parts, changed)
    }

    /// Refuses a retargeted motion: its joints have other positions on purpose.
    pub(super) fn check_not_retargeted(&self, source: &Scene, given: Option<&Provenance>) -> Result<()> {
        // A character's other animations can still be compared with the original character.
        let is_source = |provenance: &Provenance| is_file_of(source, provenance.source.as_ref());
        let added: Vec<Provenance> = match self {
            Self::Gltf(file, ..) => file.provenances_of_animations().filter(is_source).collect(),
            Self::Scene(..) => Vec::new(),
        };
        let own = self.provenance().or_else(|| given.cloned());
        let all = own.into_iter().chain(added);
        let Some(onto) = all.filter_map(|provenance| provenance.onto().cloned()).next() else {
            return Ok(());
        };
        if is_file_of(source, onto.source.as_ref()) {
            return Ok(());
        }
        let name = onto
            .source
            .map_or_else(String::new, |origin| format!(" of \"{}\"", origin.name));
        let message = format!("the motion was retargeted to the skeleton{name}, so its joints differ from the source");
        Err(Diagnostic::new(Code::Unrepresentable, message)
            .help("mocap retarget measures the angles between the limbs of both; {max-angle} sets a limit")
            .into())
    }

    /// The nodes and the keys of a clip; without a clip, the rest pose.
    pub(super) fn skeleton(&self, clip: Option<usize>) -> Result<Skeleton<'_>> {
        match self {
            Self::Gltf(file, ..) => Skeleton::of_file(file, clip),
            Self::Scene(scene, _) => Ok(Skeleton::of_scene(scene, clip)),
        }
    }

    /// The rest pose: the bind pose of the file's own skin, if any.
    pub(super) fn rest(&self) -> Result<Skeleton<'_>> {
        match self {
            Self::Gltf(_, Some(skinned), _) => Ok(Skeleton::of_scene(&skinned.bound, None)),
            _ => self.skeleton(None),
        }
    }

    /// Reports missing required bones of a VRM animation.
    pub(super) fn missing_bones(&self) -> Option<Finding> {
        let Self::Gltf(file, ..) = self else { return None };
        let missing = file.missing_bones();
        let message = || {
            format!(
                "no node is the bone {}, which a VRM animation must have",
                missing.join(", ")
            )
        };
        (!missing.is_empty()).then(|| Finding::new(FindingKind::MissingJoint, message()))
    }

    /// Reports a wrong frame count in the file: other readers rely on it.
    pub(super) fn miscounted(&self) -> Option<Finding> {
        let Self::Scene(scene, _) = self else { return None };
        let warning = scene.warnings.iter().find(|warning| warning.code == Code::FrameCount)?;
        Some(Finding::new(FindingKind::MissingFrames, warning.message.clone()))
    }

    /// Whether the file states that this crate wrote it.
    pub(super) fn is_ours(&self) -> bool {
        self.provenance().is_some()
    }

    /// The file with its meshes, if this crate wrote it.
    pub(super) fn skinned(&self) -> Option<&Scene> {
        match self {
            Self::Gltf(_, skinned, _) => skinned.as_deref().map(|skinned| &skinned.standing),
            Self::Scene(scene, provenance) => provenance.is_some().then_some(scene),
        }
    }

    /// The row of the file's format.
    pub(super) fn row(&self) -> &'static FormatInfo {
        match self {
            Self::Gltf(file, ..) => file.row(),
            Self::Scene(scene, _) => row_of(scene),
        }
    }

    /// Whether the times of the file are 32-bit seconds.
    pub(super) fn has_short_times(&self) -> bool {
        matches!(self, Self::Gltf(..))
    }

    /// Replaces the clips at these indices with the clips of `other`.
    pub(super) fn take_clips(&mut self, other: Self, taken: &HashSet<usize>) {
        let (Self::Scene(scene, _), Self::Scene(other, _)) = (self, other) else {
            return;
        };
        let clips = scene.animations.iter_mut().zip(other.animations).enumerate();
        for (_, (clip, other)) in clips.filter(|(index, _)| taken.contains(index)) {
            *clip = other;
        }
    }

    /// Plays a clip slower by the factor `times`.
    pub(super) fn play_slower(&mut self, clip: Option<usize>, times: f64) {
        let Self::Scene(scene, _) = self else { return };
        if let Some(clip) = clip.and_then(|clip| scene.animations.get_mut(clip)) {
            clip.ticks_per_second /= times;
        }
    }

    /// Frames per second of the first clip, as stated in the file.
    pub(super) fn frame_rate(&self) -> Option<f64> {
        let Self::Scene(scene, _) = self else { return None };
        scene.animations.first().map(|clip| clip.ticks_per_second)
    }

    pub(super) fn clip_names(&self) -> Vec<String> {
        match self {
            Self::Gltf(file, ..) => {
                let clips = file.animations();
                clips.map(|clip| clip.name.clone().unwrap_or_default()).collect()
            }
            Self::Scene(scene, _) => scene.animations.iter().map(|clip| clip.name.clone()).collect(),
        }
    }

    /// Units of the file per unit of the source, if the file states its unit.
    pub(super) fn stated_unit(&self, source: &Scene) -> Option<f64> {
        let Self::Scene(scene, _) = self else { return None };
        scene.metadata.metres_per_unit.map(|metres| metres_of(source) / metres)
    }

    /// The unit and the up axis that the file or its format states. For points with a record, the unit is not checked:
    /// a wrong unit would show in the distances.
    pub(super) fn stated(&self, is_recorded: bool) -> Space {
        let Self::Scene(scene, _) = self else {
            return Space {
                metres_per_unit: Some(1.0),
                up: Some(UpAxis::Y),
            };
        };
        Space {
            metres_per_unit: (scene.metadata.metres_per_unit).filter(|_| !(is_recorded && self.is_of_points())),
            up: scene.metadata.up,
        }
    }

    /// Metres per unit of the file, if its writer converts metres to a unit that readers keep.
    pub(super) fn written_unit(&self) -> Option<f64> {
        let Self::Scene(scene, _) = self else { return None };
        scene.metadata.metres_per_unit.filter(|_| self.is_of_points())
    }

    /// Whether the format has points without parents.
    pub(super) fn is_of_points(&self) -> bool {
        self.row().contents == Contents::Points
    }

    /// Whether joints have the rest pose of `source`. Four kinds of files have another rest pose. Points have none. VRM
    /// animations have a T-pose. In BVH from another format, joints rest without rotation. In glTF of robots, a
    /// constant joint has its rotation in its node.
    pub(super) fn has_rest_of(&self, source: &Scene, change: &Change) -> bool {
        let is_new_rest = !self.row().has_rest_rotations && source.metadata.format != Some(self.row().format);
        let is_of_robot = matches!(self, Self::Gltf(..)) && self.is_of_robot(source);
        !self.is_of_points() && change.humanoid.is_none() && !is_new_rest && !is_of_robot
    }

    /// Metres per unit of the file: as the file states, else the converted unit of the source.
    pub(super) fn metres_per_unit(&self, source: &Scene, change: &Change) -> f64 {
        let Self::Scene(scene, _) = self else { return 1.0 };
        match scene.metadata.metres_per_unit {
            Some(metres) => metres,
            None => change
                .out_metres_per_unit
                .unwrap_or_else(|| metres_of(source) / change.metres_per_unit),
        }
    }

    /// Whether the joints have the axes of the source. Joints keep these axes in glTF of this crate, packed clips, BVH
    /// made from BVH, and FBX of this crate with the axes of the scene.
    pub(super) fn keeps_axes(&self, source: &Scene) -> bool {
        let row = self.row();
        match self {
            Self::Gltf(..) => self.is_ours(),
            Self::Scene(..) if !row.has_rest_rotations => source.metadata.format == Some(row.format),
            Self::Scene(_, Some(provenance)) => provenance.up.is_none(),
            Self::Scene(_, None) => row.is_packed,
        }
    }
}

/// The row of a scene's format. A scene without a format gets a row without special properties.
fn row_of(scene: &Scene) -> &'static FormatInfo {
    scene.metadata.format.map_or(&FormatInfo::BASE, FormatInfo::of)
}

/// Whether a scene is a robot. A robot file has no motion.
fn is_robot(scene: &Scene) -> bool {
    row_of(scene).contents == Contents::Robot
}

/// Whether a scene was read from this file.
fn is_file_of(scene: &Scene, recorded: Option<&Origin>) -> bool {
    let origins = (recorded, scene.metadata.origin.as_ref());
    matches!(origins, (Some(recorded), Some(found)) if is_same_file(recorded, found))
}

/// The provenance of the file `name` with these bytes, if this crate wrote it.
pub(super) fn provenance_of(
    bytes: &[u8],
    name: &Path,
    open: &dyn Fn(&Path) -> Result<Vec<u8>>,
) -> Result<Option<Provenance>> {
    if File::sniff(bytes) {
        let file = File::read(bytes, open, &Limits::default())?;
        return Ok(file.provenance_of_kept().or_else(|| file.provenance()));
    }
    match FormatInfo::provenance(bytes) {
        Some(provenance) => Ok(Some(provenance)),
        None => Ok(sidecar(bytes, name, open)?.map(|provenance| *provenance)),
    }
}

/// The statements in the JSON file of a BVH file.
fn sidecar(bytes: &[u8], name: &Path, open: &dyn Fn(&Path) -> Result<Vec<u8>>) -> Result<Option<Box<Provenance>>> {
    let beside = Sidecar::path(name);
    let found = open(beside.file_name().unwrap_or_default().as_ref());
    let Some(sidecar) = found.ok().and_then(|bytes| Sidecar::read(&bytes)) else {
        return Ok(None);
    };
    if sidecar.is_about_bytes(bytes) {
        return Ok(Some(Box::new(sidecar.mocap)));
    }
    let message = format!("\"{}\" describes another file: the SHA-256 differs", beside.display());
    Err(Diagnostic::new(Code::InvalidValue, message)
        .help("the file was changed after writing: write it again, or remove its JSON file")
        .into())
}

/// Metres per unit of the source: the stated unit, else the guessed unit.
pub(super) fn metres_of(source: &Scene) -> f64 {
    let stated = source.metadata.metres_per_unit;
    stated.unwrap_or_else(|| Figure::new(source).survey.unit.value.metres())
}
