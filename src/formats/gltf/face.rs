//! The face of a VRM animation on a character: what its expressions move, as far as animations of glTF can say it.
//!
//! VRM 1.0 and VRM 0 say of each expression which morph targets it moves, by how much at weight 1, and how far the eyes
//! turn with the gaze. Those are animated; colours of materials and places of textures are not, for glTF has no
//! animations of them.

mod binds;
mod gaze;

use std::collections::BTreeMap;

use mocap_scene::pose::{FaceTrack, Trs};
use mocap_scene::scene::{Animation, Face, HumanoidBone, NodeId, Scene};
use serde_json::Value;

pub(super) use self::binds::morph_targets;
use self::binds::{Expression, expressions};
use self::gaze::Gaze;

/// The animated weights of the morph targets of a node.
#[derive(Clone, Debug)]
pub(super) struct MorphTrack {
    /// The index of the node in the file.
    pub(super) node: usize,
    pub(super) ticks: Vec<f64>,
    /// At each tick the weights of all targets.
    pub(super) weights: Vec<Vec<f32>>,
}

/// What a character can do with its face.
#[derive(Clone, Debug, Default)]
pub(super) struct CharacterFace {
    expressions: Vec<Expression>,
    gaze: Option<Gaze>,
    /// The weights at rest of the nodes that have morph targets.
    targets: BTreeMap<usize, Vec<f32>>,
}

impl CharacterFace {
    /// Of the JSON of a file. What it states wrongly is left out.
    pub(super) fn read(text: &[u8]) -> Self {
        let root: Value = serde_json::from_slice(text).unwrap_or_default();
        let targets = morph_targets(&root);
        Self {
            expressions: expressions(&root, &targets),
            gaze: Gaze::read(&root),
            targets,
        }
    }

    /// The tracks of a face on the character: the weights of its morph targets, with the rotations of its eyes in
    /// `animation`. Returns what they cannot say, as sentences.
    pub(super) fn onto(
        &self,
        tracks: &[FaceTrack],
        scene: &Scene,
        animation: &mut Animation,
    ) -> (Vec<MorphTrack>, Vec<String>) {
        let mut notes = Vec::new();
        let is_known = |track: &&FaceTrack| self.expressions.iter().any(|own| own.is_of(&track.face));
        let expressions = || tracks.iter().filter(|track| !matches!(track.face, Face::LookAt { .. }));
        let lacks: Vec<_> = expressions()
            .filter(|track| !is_known(track))
            .map(|track| track.face.name())
            .collect();
        if !lacks.is_empty() {
            notes.push(format!(
                "expressions that the character does not have, left out: {}",
                lacks.join(", ")
            ));
        }
        let has_more = |track: &&FaceTrack| {
            self.expressions
                .iter()
                .any(|own| own.has_more && own.is_of(&track.face))
        };
        let partly: Vec<_> = expressions().filter(has_more).map(|track| track.face.name()).collect();
        if !partly.is_empty() {
            let names = partly.join(", ");
            notes.push(format!(
                "of the expressions {names} the morph targets alone move: glTF has no animation of materials"
            ));
        }
        let ticks = ticks_of(tracks, animation.duration);
        let look = tracks.iter().find(|track| matches!(track.face, Face::LookAt { .. }));
        let mut looks = vec![[0.0; 4]; ticks.len()];
        match (look, &self.gaze) {
            (Some(track), Some(gaze)) => {
                let at = |tick: &f64| track.keys.sample(*tick, Trs::IDENTITY).rotation;
                let rotations: Vec<_> = ticks.iter().map(at).collect();
                match gaze.is_of_bones {
                    true if !gaze.turn_eyes(scene, animation, &ticks, &rotations) => {
                        notes.push("the gaze is left out: the character has no eyes that turn".to_owned());
                    }
                    true => {}
                    false => looks = rotations.iter().map(|rotation| gaze.looks(*rotation)).collect(),
                }
            }
            (Some(_), None) => notes.push("the gaze is left out: the character does not say how it looks".to_owned()),
            (None, _) => {}
        }
        (self.morphs(tracks, &ticks, &looks), notes)
    }

    /// The weights of the morph targets that differ from those at rest.
    fn morphs(&self, tracks: &[FaceTrack], ticks: &[f64], looks: &[[f32; 4]]) -> Vec<MorphTrack> {
        let of_expression: Vec<_> = (self.expressions.iter())
            .map(|own| tracks.iter().find(|track| own.is_of(&track.face)))
            .collect();
        let mut morphs: BTreeMap<usize, Vec<Vec<f32>>> = BTreeMap::new();
        for (&tick, looks) in std::iter::zip(ticks, looks) {
            let weight = |(own, track): (&Expression, &Option<&FaceTrack>)| {
                let said = track.map(|track| track.keys.sample(tick, Trs::IDENTITY).translation.x);
                own.weight(said.unwrap_or_else(|| own.look.map_or(0.0, |look| looks[look])))
            };
            let mut weights: Vec<f32> = std::iter::zip(&self.expressions, &of_expression).map(weight).collect();
            binds::override_weights(&self.expressions, &mut weights);
            let mut now = self.targets.clone();
            for (own, weight) in std::iter::zip(&self.expressions, weights) {
                for bind in own.binds.iter().filter(|_| weight != 0.0) {
                    if let Some(target) = now.get_mut(&bind.node).and_then(|all| all.get_mut(bind.target)) {
                        *target += weight * bind.weight;
                    }
                }
            }
            for (node, weights) in now {
                morphs.entry(node).or_default().push(weights);
            }
        }
        let moves = |(node, weights): &(usize, Vec<Vec<f32>>)| weights.iter().any(|now| *now != self.targets[node]);
        let track = |(node, weights): (usize, Vec<Vec<f32>>)| MorphTrack {
            node,
            ticks: ticks.to_vec(),
            weights,
        };
        morphs.into_iter().filter(moves).map(track).collect()
    }
}

/// The ticks of the keys of all tracks, within the animation.
fn ticks_of(tracks: &[FaceTrack], duration: f64) -> Vec<f64> {
    let of_track = |track: &FaceTrack| -> Vec<f64> {
        let (positions, rotations) = (&track.keys.position_keys, &track.keys.rotation_keys);
        let positions = (0..positions.len()).map(|key| positions.tick(key));
        positions
            .chain((0..rotations.len()).map(|key| rotations.tick(key)))
            .collect()
    };
    let mut ticks: Vec<f64> = tracks
        .iter()
        .flat_map(of_track)
        .filter(|tick| (0.0..=duration).contains(tick))
        .collect();
    ticks.push(0.0);
    ticks.sort_by(f64::total_cmp);
    ticks.dedup();
    ticks
}

/// The joint of an eye.
fn eye(scene: &Scene, bone: HumanoidBone) -> Option<NodeId> {
    let eye = scene.nodes.iter().position(|node| node.humanoid_bone == Some(bone));
    eye.map(NodeId::new)
}
