//! Matches the keys of a motion to the bones of a model.

use std::collections::HashMap;

use glam::DVec3;
use mocap_scene::error::{Code, Diagnostic};

use super::model::Model;
use super::motion::{BoneKey, Motion};
use super::names;
use crate::Failure;
use crate::warnings::Warnings;

/// The keys of each bone of the model, with a warning about keys without a bone.
pub(super) fn tracks<'k>(motion: &'k Motion, model: &Model, warnings: &mut Warnings) -> Vec<Option<&'k [BoneKey]>> {
    let mut tracks: Vec<Option<&[BoneKey]>> = vec![None; model.bones.len()];
    let mut by_key: HashMap<Vec<u8>, usize> = HashMap::new();
    for (index, bone) in model.bones.iter().enumerate() {
        if let Some(key) = names::key(&bone.name) {
            by_key.entry(key).or_insert(index);
        }
    }
    for (name, keys) in &motion.bones {
        match by_key.get(name) {
            Some(bone) => tracks[*bone] = Some(keys),
            None if keys.iter().any(BoneKey::moves) => warnings.push(Code::IgnoredChannel, || {
                let message = "the model has no bone with this name; its keys were dropped";
                Diagnostic::new(Code::IgnoredChannel, message)
                    .in_joint(names::decode(name))
                    .help("if the motion was made for another model, name that model: {skeleton} MODEL.pmx")
            }),
            None => {}
        }
    }
    tracks
}

/// Refuses a motion that moves only bones that the model lacks: the figure would not move.
pub(super) fn check_moves(motion: &Motion, model: &Model, tracks: &[Option<&[BoneKey]>]) -> Result<(), Failure> {
    let moves = |keys: &[BoneKey]| keys.iter().any(BoneKey::moves);
    if tracks.iter().flatten().any(|keys| moves(keys)) || motion.morphs.values().any(|keys| keys.len() > 1) {
        return Ok(());
    }
    /// The largest number of bones in a message.
    const NAMED: usize = 8;
    let moving = motion.bones.iter().filter(|(_, keys)| moves(keys));
    let unknown: Vec<String> = moving.map(|(name, _)| names::decode(name)).take(NAMED).collect();
    if unknown.is_empty() {
        return Ok(());
    }
    let message = "the model has none of the bones that the motion moves";
    let known: Vec<&str> = model.bones.iter().take(NAMED).map(|bone| bone.name.as_str()).collect();
    Err(Diagnostic::new(Code::InvalidMmd, message)
        .expected_found(format!("bones such as {}", known.join(", ")), unknown.join(", "))
        .help("name the model of the motion, which has bones with these names: {skeleton} MODEL.pmx")
        .into())
}

impl BoneKey {
    /// Whether the keys differ from the rest pose.
    fn moves(&self) -> bool {
        self.position != DVec3::ZERO || self.rotation.w.abs() < 1.0
    }
}
