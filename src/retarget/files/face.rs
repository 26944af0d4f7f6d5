//! The scene of the target with the clips, and with the faces of their sources.

use mocap_scene::process::SkeletonMesh;
use mocap_scene::scene::Scene;
use mocap_scene::scene::report::{DataKind, DataLoss};

use super::{Retargeter, Target};

impl Retargeter {
    /// The target with the clips alone. What the faces of the sources say goes to nodes of the target that are a part
    /// of a face too.
    pub(super) fn with_clips(&self) -> Scene {
        let mut scene = self.target.scene().into_owned();
        scene.animations = self.clips.iter().map(|clip| clip.animation.clone()).collect();
        // Those of the target's own animations.
        scene.weight_keys().for_each(Vec::clear);
        if let Target::Robot(_) = self.target {
            scene.add_skeleton_mesh(SkeletonMesh::Skinned);
        }
        for (index, clip) in self.clips.iter().enumerate() {
            scene.set_face(index, &clip.face, false);
        }
        scene
    }

    /// Gives a scene that was made of the target the nodes that it lacks for the faces of the sources.
    #[doc(hidden)]
    pub fn add_faces(&self, scene: &mut Scene) {
        for (index, clip) in self.clips.iter().enumerate() {
            scene.set_face(index, &clip.face, true);
        }
    }

    /// The parts of a face that the target has no node for, and a sentence on them about an output of `format`.
    #[doc(hidden)]
    pub fn lost_faces(&self, format: &str) -> Option<(DataLoss, String)> {
        let target = self.target.scene();
        let mut names: Vec<&str> = Vec::new();
        for track in self.clips.iter().flat_map(|clip| &clip.face) {
            let is_it =
                |node: &mocap_scene::scene::Node| node.face.as_ref().is_some_and(|face| face.is_part(&track.face));
            if !names.contains(&track.face.name()) && !target.nodes.iter().any(is_it) {
                names.push(track.face.name());
            }
        }
        let listed = names.join(", ");
        (!names.is_empty()).then(|| {
            let lost = DataLoss::new(DataKind::FaceCurves, names.len() as u64);
            let said = format!(
                "face: {listed} left out, because {format} has no expressions; a VRM animation, and a character as \
                 .vrm or .glb, keep them"
            );
            (lost, said)
        })
    }
}
