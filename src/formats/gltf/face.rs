//! Converts the face of a VRM animation to a character's expressions, as far as glTF animations allow.
//!
//! VRM 1.0 and VRM 0 state the morph targets that each expression moves, with the weights of the targets when the
//! expression has weight 1. VRM also states how far the eyes rotate with the gaze. These effects are animated. Material
//! colours and texture offsets are not animated, because glTF cannot animate them.

mod binds;
mod gaze;
mod shapes;

use std::collections::BTreeMap;

use mocap_scene::pose::{FaceTrack, Trs};
use mocap_scene::scene::{Animation, Face, HumanoidBone, NodeId, Scene};
use serde_json::Value;

use self::binds::{Expression, expressions};
pub(super) use self::binds::{morph_targets, names_of_targets};
use self::gaze::Gaze;

/// The animated weights of the morph targets of a node.
#[derive(Clone, Debug)]
pub(super) struct MorphTrack {
    /// The index of the node in the file.
    pub(super) node: usize,
    pub(super) ticks: Vec<f64>,
    /// The weights of all targets at each tick.
    pub(super) weights: Vec<Vec<f32>>,
}

/// The name of the gaze among the names of lost expressions.
const GAZE: &str = "lookAt";

/// The face data of a VRM animation that a character cannot show.
#[derive(Clone, Debug, Default)]
pub(super) struct Unsaid {
    /// The reasons, as sentences.
    pub(super) notes: Vec<String>,
    /// The names of the parts that are lost.
    pub(super) lost: Vec<String>,
}

/// The capabilities of a character's face.
#[derive(Clone, Debug, Default)]
pub(super) struct CharacterFace {
    expressions: Vec<Expression>,
    gaze: Option<Gaze>,
    /// The rest weights of the nodes with morph targets.
    targets: BTreeMap<usize, Vec<f32>>,
}

impl CharacterFace {
    /// Reads the face from the JSON of a file. Invalid statements are skipped.
    pub(super) fn read(text: &[u8]) -> Self {
        let root: Value = serde_json::from_slice(text).unwrap_or_default();
        let targets = morph_targets(&root);
        let mut expressions = expressions(&root, &targets);
        let of_targets = shapes::of_targets(&root, &expressions);
        let is_there = |own: &Expression| own.binds.iter().all(|bind| targets.contains_key(&bind.node));
        expressions.extend(of_targets.into_iter().filter(is_there));
        Self {
            expressions,
            gaze: Gaze::read(&root),
            targets,
        }
    }

    /// Converts face tracks to the character: the weights of its morph targets, and the rotations of its eyes in
    /// `animation`. Returns the data that cannot be converted.
    pub(super) fn onto(
        &self,
        tracks: &[FaceTrack],
        scene: &Scene,
        animation: &mut Animation,
    ) -> (Vec<MorphTrack>, Unsaid) {
        let mut unsaid = Unsaid::default();
        let notes = &mut unsaid.notes;
        let presets = shapes::presets(tracks, &self.expressions);
        if !presets.is_empty() {
            let names: Vec<_> = presets.iter().map(|track| track.face.name()).collect();
            notes.push(format!(
                "the character lacks some blend shapes of ARKit; its expressions {} replace them",
                names.join(", ")
            ));
        }
        let is_known = |track: &&FaceTrack| self.expressions.iter().any(|own| own.is_of(&track.face));
        let expressions = || tracks.iter().filter(|track| !matches!(track.face, Face::LookAt { .. }));
        let moves_preset = |track: &&FaceTrack| {
            let mut moved = shapes::presets_of(&track.face, &self.expressions);
            moved.any(|name| presets.iter().any(|preset| preset.face.name() == name))
        };
        let lacks: Vec<_> = expressions()
            .filter(|track| !is_known(track) && !moves_preset(track))
            .map(|track| track.face.name())
            .collect();
        if !lacks.is_empty() {
            notes.push(format!(
                "expressions that the character lacks, dropped: {}",
                lacks.join(", ")
            ));
            unsaid.lost.extend(lacks.into_iter().map(str::to_owned));
        }
        let has_more = |track: &&FaceTrack| self.is_partly_of_targets(&track.face);
        let partly: Vec<_> = expressions().filter(has_more).map(|track| track.face.name()).collect();
        if !partly.is_empty() {
            let names = partly.join(", ");
            notes.push(format!(
                "the expressions {names} move only their morph targets, because glTF cannot animate materials"
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
                        notes.push("the gaze was dropped: the character has no movable eyes".to_owned());
                        unsaid.lost.push(GAZE.to_owned());
                    }
                    true => {}
                    false => looks = rotations.iter().map(|rotation| gaze.looks(*rotation)).collect(),
                }
            }
            (Some(_), None) => {
                notes.push("the gaze was dropped: the character does not state how its eyes move".to_owned());
                unsaid.lost.push(GAZE.to_owned());
            }
            (None, _) => {}
        }
        let tracks = [tracks, &presets].concat();
        (self.morphs(&tracks, &ticks, &looks), unsaid)
    }

    /// Whether a face part affects the eyes, or the morph targets of an existing node.
    pub(super) fn shows(&self, part: &Face, scene: &Scene, is_there: &dyn Fn(usize, usize) -> bool) -> bool {
        let binds = |own: &Expression| own.binds.iter().any(|bind| is_there(bind.node, bind.target));
        let has_eyes = || {
            let eyes = [HumanoidBone::LeftEye, HumanoidBone::RightEye];
            eyes.into_iter().any(|bone| eye(scene, bone).is_some())
        };
        match (part, &self.gaze) {
            (Face::LookAt { .. }, Some(gaze)) if gaze.is_of_bones => has_eyes(),
            (Face::LookAt { .. }, Some(_)) => self.expressions.iter().any(|own| own.look.is_some() && binds(own)),
            (Face::LookAt { .. }, None) => false,
            (part, _) => {
                let presets = shapes::presets_of(part, &self.expressions);
                let presets: Vec<Face> = presets.map(|name| Face::Preset(name.to_owned())).collect();
                let is_of = |own: &Expression| own.is_of(part) || presets.iter().any(|preset| own.is_of(preset));
                self.expressions.iter().any(|own| is_of(own) && binds(own))
            }
        }
    }

    /// Whether an expression also changes materials.
    pub(super) fn is_partly_of_targets(&self, part: &Face) -> bool {
        self.expressions.iter().any(|own| own.has_more && own.is_of(part))
    }

    /// The tracks of morph target weights that leave the rest weights.
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
    ticks.sort_unstable_by(f64::total_cmp);
    ticks.dedup();
    ticks
}

/// The joint of an eye.
fn eye(scene: &Scene, bone: HumanoidBone) -> Option<NodeId> {
    let eye = scene.nodes.iter().position(|node| node.humanoid_bone == Some(bone));
    eye.map(NodeId::new)
}
