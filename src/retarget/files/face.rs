//! The scene of the target with the clips, and with the faces of their sources.

use mocap_scene::pose::FaceTrack;
use mocap_scene::process::SkeletonMesh;
use mocap_scene::scene::report::{DataKind, DataLoss};
use mocap_scene::scene::{Animation, ClipExtras, Face, Keys, MorphTarget, Node, Scene, face_shape};

use super::{Retargeter, Target};

impl Retargeter {
    /// The target with only the new clips. Expressions of the sources also move nodes of the target's face. They also
    /// move the morph targets and the eyes of a character whose morph targets were read.
    pub(super) fn with_clips(&self, animations: Vec<Animation>) -> Scene {
        let mut scene = self.target.scene().into_owned();
        scene.animations = animations;
        // The weight keys of the target's own animations.
        scene.weight_keys().for_each(Vec::clear);
        scene.metadata.clip_extras = ClipExtras::default();
        if let Some(fbx) = &mut scene.metadata.fbx {
            fbx.keeps_clips = !self.options.replace_animations;
        }
        for (index, clip) in self.clips.iter().enumerate() {
            scene.set_clip_extras(index, clip.extras.clone().unwrap_or_default());
        }
        if let Target::Robot(_) = self.target {
            scene.add_skeleton_mesh(SkeletonMesh::Skinned);
        }
        for (index, clip) in self.clips.iter().enumerate() {
            scene.set_face(index, &clip.face, false);
            match &self.target {
                Target::Character(character) => character.set_face(&mut scene, index, &clip.face),
                Target::Skeleton(_) => set_shapes(&mut scene, index, &clip.face),
                Target::Robot(_) => {}
            }
        }
        scene
    }

    /// Adds the nodes that a scene made from the target lacks for the faces of the sources.
    #[doc(hidden)]
    pub fn add_faces(&self, scene: &mut Scene) {
        for (index, clip) in self.clips.iter().enumerate() {
            scene.set_face(index, &clip.face, true);
        }
    }

    /// The expressions of the sources that an output of `format` loses, because the format has no expressions, and
    /// messages about the loss. Further messages state the expressions that become curves of morph targets.
    #[doc(hidden)]
    pub fn faces_in(&self, format: &str) -> (Option<DataLoss>, Vec<String>) {
        let target = self.target.scene();
        let mut faces: Vec<&Face> = Vec::new();
        for FaceTrack { face, .. } in self.clips.iter().flat_map(|clip| &clip.face) {
            let is_it = |node: &Node| node.face.as_ref().is_some_and(|own| own.is_part(face));
            if !faces.iter().any(|known| known.name() == face.name()) && !target.nodes.iter().any(is_it) {
                faces.push(face);
            }
        }
        let (shown, partly) = match &self.target {
            Target::Character(character) => character.shown_faces(&faces),
            Target::Skeleton(scene) => {
                let is_shown = |face: &&Face| targets(scene).any(|target| is_shape(target, face));
                (faces.iter().copied().filter(is_shown).collect(), Vec::new())
            }
            Target::Robot(_) => Default::default(),
        };
        faces.retain(|face| !shown.contains(face));
        let listed = |faces: &[&Face]| faces.iter().map(|face| face.name()).collect::<Vec<_>>().join(", ");
        let mut said = Vec::new();
        if !shown.is_empty() {
            let names = listed(&shown);
            said.push(format!(
                "face: {names} move morph targets and eyes, because {format} has no expressions"
            ));
        }
        if !partly.is_empty() {
            let names = listed(&partly);
            said.push(format!("face: {names} move only morph targets, and no materials"));
        }
        if !faces.is_empty() {
            let names = listed(&faces);
            said.push(format!(
                "face: {names} left out, because {format} has no expressions; a VRM animation, and a character as .vrm \
                 or .glb, keep them"
            ));
        }
        let lost = DataLoss::new(DataKind::FaceCurves, faces.len() as u64);
        (Some(lost).filter(|lost| lost.count > 0), said)
    }
}

fn targets(scene: &Scene) -> impl Iterator<Item = &MorphTarget> {
    scene.meshes.iter().flat_map(|mesh| &mesh.morph_targets)
}

/// Whether a morph target is an expression, by its name or by the name of an ARKit shape.
fn is_shape(target: &MorphTarget, face: &Face) -> bool {
    match face {
        Face::LookAt { .. } => false,
        Face::Preset(name) | Face::Custom(name) => {
            let shape = face_shape(name);
            target.name == *name || shape.is_some() && shape == face_shape(&target.name)
        }
    }
}

/// Gives the tracks of expressions to the morph targets that show these expressions, for example in a scene for FBX.
fn set_shapes(scene: &mut Scene, animation: usize, tracks: &[FaceTrack]) {
    let count = scene.animations.len();
    for target in scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.morph_targets) {
        let Some(track) = tracks.iter().find(|track| is_shape(target, &track.face)) else {
            continue;
        };
        let keys = &track.keys.position_keys;
        target.weight_keys.resize(count, Keys::default());
        target.weight_keys[animation] = Keys {
            values: keys.values.iter().map(|weight| weight.x).collect(),
            ticks: keys.ticks.clone(),
        };
    }
}
