//! The extensions that state which node is which bone of a humanoid: those of VRM 1.0, of VRM 0 and of VRM animations.

use serde::Deserialize;
use serde_json::Value;

use super::invalid::{self, invalid};
use crate::format::Failure;
use crate::scene::{HumanoidBone as Bone, NodeId, Scene};

/// The extension of a VRM animation.
pub(super) const VRM_ANIMATION: &str = "VRMC_vrm_animation";

/// Those of a file's extensions that state a humanoid.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Extensions {
    #[serde(rename = "VRMC_vrm")]
    vrm1: Option<Value>,
    #[serde(rename = "VRM")]
    vrm0: Option<Value>,
    #[serde(rename = "VRMC_vrm_animation")]
    pub(super) vrm_animation: Option<Value>,
}

/// A bone that a file states, its node, and where the file says so.
type StatedBone = (Bone, usize, String);

/// Tells the nodes of `scene` which bones they are, as far as the file states it. `placed` has the node of the file and
/// that of the scene.
///
/// # Errors
/// Where the node of a bone is not in the scene, or two bones have the same node.
pub(super) fn state(
    extensions: &Extensions,
    placed: &[(usize, NodeId)],
    nodes: usize,
    scene: &mut Scene,
) -> Result<(), Failure> {
    for (bone, index, pointer) in stated_bones(extensions) {
        let found = placed.iter().find(|(node, _)| *node == index);
        let (_, id) = found.ok_or_else(|| invalid::missing(&pointer, "node in the scene", index, nodes))?;
        if let Some(other) = scene.nodes[id.index()].humanoid_bone.replace(bone) {
            let message = format!("node {index} is the bone {}, and cannot be another one", other.as_str());
            return Err(invalid(pointer, message).into());
        }
    }
    Ok(())
}

/// The bones that VRM requires and that are not stated.
pub(super) fn missing(extensions: &Extensions) -> Vec<&'static str> {
    let stated = stated_bones(extensions);
    let is_missing = |bone: &Bone| stated.iter().all(|(stated, ..)| stated != bone);
    Bone::REQUIRED
        .into_iter()
        .filter(is_missing)
        .map(Bone::as_str)
        .collect()
}

/// The parts of a VRM animation that are no bones and are not read, each with a name for it: expressions, and the point
/// to look at.
pub(super) fn not_read(extensions: &Extensions) -> Vec<(&'static str, String)> {
    let Some(animation) = &extensions.vrm_animation else {
        return Vec::new();
    };
    let of_kind = |kind: &str| animation["expressions"][kind].as_object();
    let names: Vec<&str> = ["preset", "custom"]
        .into_iter()
        .filter_map(of_kind)
        .flat_map(|expressions| expressions.keys().map(String::as_str))
        .collect();
    let mut found = Vec::new();
    if !names.is_empty() {
        let plural = if names.len() == 1 {
            "the expression"
        } else {
            "the expressions"
        };
        let verb = if names.len() == 1 { "is" } else { "are" };
        found.push(("expressions", format!("{plural} {} {verb}", names.join(", "))));
    }
    if animation["lookAt"].is_object() {
        found.push(("lookAt", "the point to look at is".to_owned()));
    }
    found
}

fn stated_bones(extensions: &Extensions) -> Vec<StatedBone> {
    let node = |value: &Value| value["node"].as_u64().and_then(|node| usize::try_from(node).ok());
    let named = |extension: &'static str, value: &Value| -> Vec<StatedBone> {
        let bones = value["humanoid"]["humanBones"].as_object();
        let bones = bones.into_iter().flatten().filter_map(|(name, value)| {
            let pointer = format!("/extensions/{extension}/humanoid/humanBones/{name}/node");
            Some((Bone::from_name(name)?, node(value)?, pointer))
        });
        bones.collect()
    };
    match extensions {
        Extensions {
            vrm_animation: Some(value),
            ..
        } => named(VRM_ANIMATION, value),
        Extensions { vrm1: Some(value), .. } => named("VRMC_vrm", value),
        Extensions { vrm0: Some(value), .. } => {
            let bones = value["humanoid"]["humanBones"].as_array();
            let bones = bones.into_iter().flatten().enumerate().filter_map(|(index, value)| {
                let pointer = format!("/extensions/VRM/humanoid/humanBones/{index}/node");
                Some((bone_of_vrm0(value["bone"].as_str()?)?, node(value)?, pointer))
            });
            bones.collect()
        }
        _ => Vec::new(),
    }
}

/// A bone by its name in VRM 0, which calls the joints of the thumb as those of other fingers.
fn bone_of_vrm0(name: &str) -> Option<Bone> {
    Bone::from_name(match name {
        "leftThumbProximal" => "leftThumbMetacarpal",
        "leftThumbIntermediate" => "leftThumbProximal",
        "rightThumbProximal" => "rightThumbMetacarpal",
        "rightThumbIntermediate" => "rightThumbProximal",
        other => other,
    })
}
