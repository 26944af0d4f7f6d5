//! A glTF file to which animations are added. All other bytes stay unchanged.

use std::borrow::Cow;
use std::cell::OnceCell;
use std::collections::BTreeSet;

use mocap_figure::Humanoid;
use mocap_scene::error::Result;
use mocap_scene::pose::FaceTrack;
use mocap_scene::scene::report::{DataKind, DataLoss};
use mocap_scene::scene::{Animation, Face, Keys, NodeId, Scene};
use serde_json::Value;

use super::BufferPlace;
use super::face::CharacterFace;
use super::meshes::TargetPlace;
use super::read::{Placed, RestPose, read_placed};
use super::write::dangling;
use super::write::patch::{self, Clip, Replaced};
use super::write::{GltfOptions, GltfReport};
use super::{json, meshes};
use crate::provenance::Provenance;
use crate::{Export, ExportFile, ReadOptions, Source, read_back};

/// A character from a glTF or VRM file: its skeleton as a scene, and the file itself.
///
/// [`Character::with_animations`] returns the file with added animations. Everything else stays byte for byte: meshes,
/// materials, textures, morph targets, extensions. The exception is an invalid index: it is removed, with a warning.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::Importer;
/// use mocap::retarget::{PoseRetargetOptions, PoseRetargeter};
///
/// let motion = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// let character = Importer::new().import_character("fixtures/skeletons/human_vrm1.gltf")?;
/// let options = PoseRetargetOptions::new().target(character.humanoid().cloned());
/// let mut retargeter = PoseRetargeter::new(&motion, character.scene(), &options)?;
/// let mut walk = retargeter.animation(&motion, &motion.animations[0]);
/// walk.name = "walk".to_owned();
/// let file: Vec<u8> = character.with_animations(&[walk], false)?;
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Character {
    bytes: Vec<u8>,
    #[doc(hidden)]
    pub scene: Scene,
    /// The index in the file of each node of the scene; `None` for the group that the reader adds above several roots.
    nodes: Vec<Option<usize>>,
    targets: Vec<TargetPlace>,
    humanoid: Option<Humanoid>,
}

impl Character {
    #[doc(hidden)]
    pub fn read(source: &Source<'_>, options: &ReadOptions) -> Result<Self> {
        let Placed {
            mut scene,
            nodes: placed,
            bones,
            targets,
            ..
        } = read_placed(source, options, RestPose::Nodes)?;
        bones?;
        let broken = meshes::broken_numbers(source, &placed, &scene.nodes, options);
        scene.warnings.extend(broken.into_iter().map(|mut fault| {
            fault.message = format!("mocap copies the mesh unchanged: {}", fault.message);
            let help = "other programs may not draw it; repair the number, or export the file again";
            fault.help(help)
        }));
        let (bytes, dangling) = dangling::without(source.bytes)?;
        scene.warnings.extend(dangling);
        let mut nodes = vec![None; scene.nodes.len()];
        for (index, id) in placed {
            nodes[id.index()] = Some(index);
        }
        let is_stated = scene.nodes.iter().any(|node| node.humanoid_bone.is_some());
        let humanoid = is_stated.then(|| Humanoid::of(&scene));
        Ok(Self {
            bytes: bytes.into_owned(),
            scene,
            nodes,
            targets,
            humanoid,
        })
    }

    /// The skeleton and the animations of the file, in metres with +Y up.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The joint of each bone, as a VRM file states it; `None` for other files, in which
    /// [`Humanoid::of`](mocap_figure::Humanoid::of) finds the joints.
    pub fn humanoid(&self) -> Option<&Humanoid> {
        self.humanoid.as_ref()
    }

    /// The companion files to which this file refers: buffers and images. A copy of the file in another folder does not
    /// find these companion files.
    ///
    /// # Errors
    /// The errors of [`Character::with_animations`].
    pub fn external_files(&self) -> Result<Vec<String>> {
        patch::external_files(&self.bytes)
    }

    /// The file with additional animations. With `replace`, these animations replace the animations of the file. A
    /// `.glb` or `.vrm` keeps its container. A `.gltf` gets its buffer as a data URI.
    ///
    /// # Errors
    /// - [`Code::InvalidGltf`](mocap_scene::Code::InvalidGltf) if the JSON is not UTF-8 or names a section twice.
    /// - [`Code::Unrepresentable`](mocap_scene::Code::Unrepresentable) if an animation moves no node of the file, or if
    ///   a value is not finite.
    /// - [`Code::LimitExceeded`](mocap_scene::Code::LimitExceeded) if a `.glb` would have more than 4 GiB.
    /// - The errors of reading, if the result could not be read.
    pub fn with_animations(&self, animations: &[Animation], replace: bool) -> Result<Vec<u8>> {
        let clip = |animation| Clip {
            animation,
            provenance: None,
            morphs: &[],
            extras: None,
        };
        let animations: Vec<_> = animations.iter().map(clip).collect();
        Ok(self.embedded(&animations, replace, &GltfOptions::default())?.0)
    }

    /// Like [`Character::with_animations`]. Each animation also states its origin in `extras.mocap`, from `provenance`
    /// in the same order. `mocap verify` uses the origin. The origin also lets a later output replace the file: see
    /// [`ReplacePolicy`](mocap_scene::files::ReplacePolicy).
    ///
    /// `motions` is a scene with the nodes of [`Character::scene`], followed by the nodes of faces; `Retargeter::scene`
    /// makes such a scene. The tracks of a face become weights of morph targets and rotations of the eyes. The notes of
    /// the result list the tracks that cannot be converted.
    ///
    /// Only the animations are compressed, by [`GltfOptions::compression`] and [`GltfOptions::error_bound`] (in metres)
    /// of `options`. The rest of the file stays unchanged, so constant values of its nodes are not rounded.
    /// [`GltfOptions::buffer`] has no effect.
    ///
    /// # Errors
    /// - the errors of [`Character::with_animations`]
    /// - [`Code::ErrorBound`](mocap_scene::Code::ErrorBound) if the largest error cannot be kept
    /// - [`Code::MissingFeature`](mocap_scene::Code::MissingFeature) if this build has no meshopt
    pub fn with_clips(
        &self,
        motions: &Scene,
        provenance: &[Provenance],
        replace: bool,
        options: &GltfOptions,
    ) -> Result<Export> {
        let clip = |animation| {
            let faces = motions.face_tracks(animation);
            let mut body = animation.clone();
            let is_body = |id: NodeId| motions.nodes.get(id.index()).is_none_or(|node| node.face.is_none());
            body.channels.retain(|channel| channel.node.is_none_or(is_body));
            (body, faces)
        };
        let clips: Vec<_> = motions.animations.iter().map(clip).collect();
        let clips = std::iter::zip(&clips, provenance).enumerate();
        let clips = clips.map(|(index, ((body, faces), from))| (body, from, &**faces, motions.clip_extras(index)));
        let options = options.clone().buffer(BufferPlace::Embedded);
        self.clip_files(clips, replace, &options, "")
    }

    /// The files to write. The character is the last file. If the `.gltf` does not embed the clip buffer, the buffer
    /// comes before the `.gltf`. A clip may have face tracks, and extras.
    #[doc(hidden)]
    pub fn clip_files<'a>(
        &self,
        clips: impl IntoIterator<Item = (&'a Animation, &'a Provenance, &'a [FaceTrack], Option<Value>)>,
        replace: bool,
        options: &GltfOptions,
        name: &str,
    ) -> Result<Export> {
        let (mut made, mut notes, mut lost) = (Vec::new(), Vec::new(), BTreeSet::new());
        let face = OnceCell::new();
        for (animation, provenance, tracks, extras) in clips {
            let mut animation = Cow::Borrowed(animation);
            let mut morphs = Vec::new();
            if !tracks.is_empty() {
                let face = face.get_or_init(|| self.face());
                let (found, unsaid) = face.onto(tracks, &self.scene, animation.to_mut());
                morphs = found;
                notes.extend((unsaid.notes.iter()).map(|note| format!("{}: {note}", animation.name)));
                lost.extend(unsaid.lost);
            }
            made.push((animation, provenance, morphs, extras));
        }
        let clips: Vec<_> = (made.iter())
            .map(|(animation, provenance, morphs, extras)| Clip {
                animation,
                provenance: Some(*provenance),
                morphs,
                extras: extras.clone(),
            })
            .collect();
        let (files, report) = self.with(&clips, replace, options, name)?;
        let lost = DataLoss::new(DataKind::FaceCurves, lost.len() as u64);
        Ok(Export {
            notes,
            losses: Vec::from_iter(Some(lost).filter(|lost| lost.count > 0)),
            warnings: report.warnings,
            renamed: report.renamed,
            error: report.achieved,
            nodes: self.scene.nodes.len(),
            ..Export::of(files)
        })
    }

    /// Applies face tracks to an animation of a scene that was made from this character. The tracks move the morph
    /// targets of the character's meshes and its eyes.
    #[doc(hidden)]
    pub fn set_face(&self, scene: &mut Scene, animation: usize, tracks: &[FaceTrack]) {
        if tracks.is_empty() || self.targets.is_empty() {
            return;
        }
        let count = scene.animations.len();
        let mut clip = std::mem::take(&mut scene.animations[animation]);
        let (morphs, _) = self.face().onto(tracks, &self.scene, &mut clip);
        scene.animations[animation] = clip;
        for place in &self.targets {
            let target = scene.meshes.get_mut(place.mesh);
            let target = target.and_then(|mesh| mesh.morph_targets.get_mut(place.target));
            let morph = morphs.iter().find(|morph| morph.node == place.of_node.0);
            let (Some(target), Some(morph)) = (target, morph) else {
                continue;
            };
            let weights: Option<Vec<f32>> = (morph.weights.iter())
                .map(|weights| weights.get(place.of_node.1).copied())
                .collect();
            let moving = weights.filter(|weights| weights.iter().any(|weight| *weight != target.weight));
            if let Some(weights) = moving {
                target.weight_keys.resize(count, Keys::default());
                target.weight_keys[animation] = Keys::at_ticks(weights, morph.ticks.clone());
            }
        }
    }

    /// The face parts that an output shows if the character's file is not written. The first list has the parts that
    /// [`Self::set_face`] shows. The second list has the parts that [`Self::set_face`] shows without their effect on
    /// materials.
    #[doc(hidden)]
    pub fn shown_faces<'a>(&self, faces: &[&'a Face]) -> (Vec<&'a Face>, Vec<&'a Face>) {
        let face = self.face();
        let is_there = |node: usize, target: usize| self.targets.iter().any(|place| place.of_node == (node, target));
        let shown = faces
            .iter()
            .copied()
            .filter(|part| face.shows(part, &self.scene, &is_there));
        let shown: Vec<&Face> = match self.targets.is_empty() {
            true => Vec::new(),
            false => shown.collect(),
        };
        let partly = shown
            .iter()
            .copied()
            .filter(|part| face.is_partly_of_targets(part))
            .collect();
        (shown, partly)
    }

    /// The character with a new node `Root` as the parent of a node that has no parent in the file.
    #[doc(hidden)]
    pub fn with_root_above(&self, below: NodeId) -> Result<Self> {
        let Some(root) = self.nodes[below.index()] else {
            return Ok(self.clone());
        };
        let mut made = self.clone();
        made.scene.insert_root_above(below);
        let name = &made.scene.nodes[below.index()].name;
        let (bytes, added) = patch::with_root(&self.bytes, root, name)?;
        made.bytes = bytes;
        made.nodes.insert(below.index(), Some(added));
        made.humanoid = self.humanoid.is_some().then(|| Humanoid::of(&made.scene));
        Ok(made)
    }

    fn face(&self) -> CharacterFace {
        json::split(&self.bytes).map_or_else(|_| CharacterFace::default(), |(text, _)| CharacterFace::read(text))
    }

    /// The character with these clips as a single file.
    fn embedded(&self, clips: &[Clip<'_>], replace: bool, options: &GltfOptions) -> Result<(Vec<u8>, GltfReport)> {
        let options = options.clone().buffer(BufferPlace::Embedded);
        let (mut files, report) = self.with(clips, replace, &options, "")?;
        Ok((files.pop().unwrap_or_default().into_bytes(), report))
    }

    fn with(
        &self,
        clips: &[Clip<'_>],
        replace: bool,
        options: &GltfOptions,
        name: &str,
    ) -> Result<(Vec<ExportFile>, GltfReport)> {
        let skeleton = patch::Skeleton {
            scene: &self.scene,
            nodes: &self.nodes,
        };
        let replaced = if replace { Replaced::All } else { Replaced::None };
        let (files, report) = patch::with_animations(&self.bytes, &skeleton, clips, replaced, options, name)?;
        let own = self.scene.animations.iter().filter(|_| !replace);
        let read =
            |source: &Source<'_>, options: &ReadOptions| Ok(read_placed(source, options, RestPose::Nodes)?.scene);
        read_back::check(
            &read,
            &files,
            &self.scene.nodes,
            own.chain(clips.iter().map(|clip| clip.animation)),
        )?;
        Ok((files, report))
    }
}
