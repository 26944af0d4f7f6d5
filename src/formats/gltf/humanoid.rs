//! The extensions that state the nodes of humanoid bones: VRM 1.0, VRM 0 and VRM animations. VRM animations also state
//! the nodes of a face.

use glam::Vec3;
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::scene::{Face, HumanoidBone as Bone, NodeId, NodeKind, Scene};
use serde::Deserialize;
use serde_json::Value;

use super::invalid::{self, invalid};
use crate::Failure;

/// The extension of a VRM animation.
pub(super) use super::VRM_ANIMATION_EXTENSION as VRM_ANIMATION;

/// The look expressions of VRM. A VRM animation must not have look expressions, because its gaze replaces them.
const LOOKS: [&str; 4] = ["lookUp", "lookDown", "lookLeft", "lookRight"];

/// The extensions of a file that state a humanoid.
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

/// A bone that a file states, its node, and the JSON pointer to the statement.
type BoneStatement = (Bone, usize, String);

/// Sets the humanoid bones of the nodes of `scene`, as the file states them. `placed` maps nodes of the file to nodes
/// of the scene.
///
/// # Errors
/// The node of a bone is not in the scene, or two bones have the same node.
pub(super) fn state(
    extensions: &Extensions,
    placed: &[(usize, NodeId)],
    nodes: usize,
    scene: &mut Scene,
) -> Result<(), Failure> {
    for (bone, index, pointer) in stated_bones(extensions) {
        let found = placed.iter().find(|(node, _)| *node == index);
        let (_, id) = found.ok_or_else(|| invalid::missing(&pointer, "scene node", index, nodes))?;
        if let Some(other) = scene.nodes[id.index()].humanoid_bone.replace(bone) {
            let message = format!(
                "node {index} is the bone {}, and cannot be a second bone",
                other.as_str()
            );
            return Err(invalid(pointer, message).into());
        }
    }
    Ok(())
}

/// The bones that VRM requires and the file does not state.
pub(super) fn missing(extensions: &Extensions) -> Vec<&'static str> {
    let stated = stated_bones(extensions);
    let is_missing = |bone: &Bone| stated.iter().all(|(stated, ..)| stated != bone);
    Bone::REQUIRED
        .into_iter()
        .filter(is_missing)
        .map(Bone::as_str)
        .collect()
}

/// Sets the face roles of the nodes of `scene` from a VRM animation. Returns the skipped statements, with the reasons.
pub(super) fn state_face(extensions: &Extensions, placed: &[(usize, NodeId)], scene: &mut Scene) -> Vec<Diagnostic> {
    let mut warnings = Vec::new();
    for (face, index, pointer) in stated_faces(extensions) {
        let found = placed.iter().find(|(node, _)| Some(*node) == index);
        let node = found.map(|(_, id)| &mut scene.nodes[id.index()]);
        let is_looked = matches!(&face, Face::Preset(name) if LOOKS.contains(&name.as_str()));
        let wrong = match &node {
            _ if is_looked => "a VRM animation stores the gaze in lookAt, not in expressions".to_owned(),
            None => "its node is not in the scene".to_owned(),
            Some(node) => match (node.humanoid_bone, &node.face) {
                (Some(bone), _) => format!("its node is the bone {}", bone.as_str()),
                (_, Some(other)) => format!("its node already belongs to {}", other.name()),
                _ => String::new(),
            },
        };
        match node.filter(|_| wrong.is_empty()) {
            Some(node) => {
                node.face = Some(face);
                node.kind = NodeKind::Group;
            }
            None => {
                let what = match &face {
                    Face::LookAt { .. } => "the gaze".to_owned(),
                    expression => format!("the expression {}", expression.name()),
                };
                let message = format!("{what} was dropped: {wrong}");
                warnings.push(Diagnostic::new(Code::IgnoredChannel, message).at_pointer(pointer));
            }
        }
    }
    warnings
}

/// The expressions and the gaze of a VRM animation, each with its node and the JSON pointer to the statement of the
/// file.
pub(super) fn stated_faces(extensions: &Extensions) -> Vec<(Face, Option<usize>, String)> {
    let Some(animation) = &extensions.vrm_animation else {
        return Vec::new();
    };
    let at = format!("/extensions/{VRM_ANIMATION}");
    let mut found = Vec::new();
    for kind in ["preset", "custom"] {
        let expressions = animation["expressions"][kind].as_object();
        for (name, value) in expressions.into_iter().flatten() {
            let is_preset = kind == "preset" || Face::PRESETS.contains(&name.as_str());
            let face = match is_preset {
                true => Face::Preset(name.clone()),
                false => Face::Custom(name.clone()),
            };
            found.push((face, node_of(value), format!("{at}/expressions/{kind}/{name}/node")));
        }
    }
    let look = &animation["lookAt"];
    if look.is_object() {
        let numbers: Option<[f32; 3]> = serde_json::from_value(look["offsetFromHeadBone"].clone()).ok();
        let offset_from_head = numbers.map(Vec3::from_array).filter(|offset| offset.is_finite());
        found.push((
            Face::LookAt { offset_from_head },
            node_of(look),
            format!("{at}/lookAt/node"),
        ));
    }
    found
}

fn node_of(value: &Value) -> Option<usize> {
    value["node"].as_u64().and_then(|node| usize::try_from(node).ok())
}

fn stated_bones(extensions: &Extensions) -> Vec<BoneStatement> {
    let named = |extension: &'static str, value: &Value| -> Vec<BoneStatement> {
        let bones = value["humanoid"]["humanBones"].as_object();
        let bones = bones.into_iter().flatten().filter_map(|(name, value)| {
            let pointer = format!("/extensions/{extension}/humanoid/humanBones/{name}/node");
            Some((Bone::from_name(name)?, node_of(value)?, pointer))
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
                Some((bone_of_vrm0(value["bone"].as_str()?)?, node_of(value)?, pointer))
            });
            bones.collect()
        }
        _ => Vec::new(),
    }
}

/// A bone by its name in VRM 0, which names thumb joints like joints of other fingers.
fn bone_of_vrm0(name: &str) -> Option<Bone> {
    Bone::from_name(match name {
        "leftThumbProximal" => "leftThumbMetacarpal",
        "leftThumbIntermediate" => "leftThumbProximal",
        "rightThumbProximal" => "rightThumbMetacarpal",
        "rightThumbIntermediate" => "rightThumbProximal",
        other => other,
    })
}
