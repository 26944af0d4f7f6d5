//! A glTF file that gets further animations, and is otherwise passed through byte by byte.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::Value;

use super::invalid::{invalid, missing};
use super::json;
use super::read::read_placed;
use super::write::patch;
use crate::error::Result;
use crate::format::{Failure, ReadOptions, Source};
use crate::scene::{Animation, NodeId, Scene};
use crate::skeleton::{Humanoid, HumanoidBone as Bone};

/// A character of a glTF or VRM file: its skeleton as a scene, and the file itself.
///
/// [`Character::with_animations`] is the file with animations added. Meshes, materials, textures, morph targets,
/// extensions and everything else of it stay as they are, byte by byte.
///
/// ```
/// use mocap::Importer;
/// use mocap::retarget::{RetargetOptions, Retargeter};
///
/// let motion = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// let character = Importer::new().import_character("fixtures/skeletons/human_vrm1.gltf")?;
/// let options = RetargetOptions {
///     target: character.humanoid().cloned(),
///     ..RetargetOptions::default()
/// };
/// let mut retargeter = Retargeter::new(&motion, character.scene(), &options)?;
/// let mut walk = retargeter.animation(&motion, &motion.animations[0]);
/// walk.name = "walk".to_owned();
/// let file: Vec<u8> = character.with_animations(&[walk], false)?;
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Character {
    bytes: Vec<u8>,
    pub(crate) scene: Scene,
    /// The index in the file of each node of the scene; none for a group that the reader has put above several roots.
    nodes: Vec<Option<usize>>,
    humanoid: Option<Humanoid>,
}

impl Character {
    pub(crate) fn read(source: &Source<'_>, options: &ReadOptions) -> Result<Self> {
        let (scene, placed) = read_placed(source, options)?;
        let mut nodes = vec![None; scene.nodes.len()];
        for (index, id) in placed {
            nodes[id.index()] = Some(index);
        }
        let (text, _) = json::split(source.bytes)?;
        let stated = stated_bones(text)?;
        let humanoid = match stated {
            Some(bones) => Some(humanoid(&bones, &nodes)?),
            None => None,
        };
        Ok(Self {
            bytes: source.bytes.to_vec(),
            scene,
            nodes,
            humanoid,
        })
    }

    /// The skeleton and the animations of the file, in metres with +Y up.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Which joints are which bones, as a VRM file states it; `None` for other files, where
    /// [`humanoid`](crate::skeleton::humanoid()) finds them.
    pub fn humanoid(&self) -> Option<&Humanoid> {
        self.humanoid.as_ref()
    }

    /// The files beside this one that it refers to: buffers and images. An output in another folder does not find them.
    ///
    /// # Errors
    /// As [`Character::with_animations`].
    pub fn external_files(&self) -> Result<Vec<String>> {
        patch::external_files(&self.bytes)
    }

    /// The file with further animations, or with these in place of its own. A `.glb` or `.vrm` stays one; the buffer of a
    /// `.gltf` is added as a data URI.
    ///
    /// # Errors
    /// [`Code::InvalidGltf`](crate::Code::InvalidGltf) where the JSON is not UTF-8 or names a section twice,
    /// [`Code::LimitExceeded`](crate::Code::LimitExceeded) beyond the 4 GiB of a `.glb`.
    pub fn with_animations(&self, animations: &[Animation], replace: bool) -> Result<Vec<u8>> {
        patch::with_animations(&self.bytes, &self.scene, &self.nodes, animations, replace)
    }
}

/// The extensions that state a humanoid.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Root {
    extensions: Extensions,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Extensions {
    #[serde(rename = "VRMC_vrm")]
    vrm1: Option<Value>,
    #[serde(rename = "VRM")]
    vrm0: Option<Value>,
}

/// A bone that a file states, its node, and where the file says so.
type StatedBone = (Bone, usize, String);

/// The bones that a VRM file states; none for other files.
fn stated_bones(text: &[u8]) -> Result<Option<Vec<StatedBone>>, Failure> {
    let text = String::from_utf8_lossy(text);
    let root: Root = serde_json::from_str(&text)
        .map_err(|error| invalid("/extensions", format!("the extensions cannot be read: {error}")))?;
    let node = |value: &Value| value["node"].as_u64().and_then(|node| usize::try_from(node).ok());
    let mut bones = Vec::new();
    if let Some(humanoid) = root
        .extensions
        .vrm1
        .as_ref()
        .and_then(|vrm| vrm["humanoid"]["humanBones"].as_object())
    {
        for (name, value) in humanoid {
            if let (Some(bone), Some(node)) = (Bone::from_name(name), node(value)) {
                bones.push((
                    bone,
                    node,
                    format!("/extensions/VRMC_vrm/humanoid/humanBones/{name}/node"),
                ));
            }
        }
    } else if let Some(humanoid) = root
        .extensions
        .vrm0
        .as_ref()
        .and_then(|vrm| vrm["humanoid"]["humanBones"].as_array())
    {
        for (index, value) in humanoid.iter().enumerate() {
            let bone = value["bone"].as_str().and_then(bone_of_vrm0);
            if let (Some(bone), Some(node)) = (bone, node(value)) {
                bones.push((bone, node, format!("/extensions/VRM/humanoid/humanBones/{index}/node")));
            }
        }
    } else {
        return Ok(None);
    }
    Ok(Some(bones))
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

fn humanoid(bones: &[StatedBone], nodes: &[Option<usize>]) -> Result<Humanoid, Failure> {
    let mut joints = BTreeMap::new();
    for (bone, index, pointer) in bones {
        let place = nodes.iter().position(|node| *node == Some(*index));
        let place = place.ok_or_else(|| missing(pointer, "node in the scene", *index, nodes.len()))?;
        joints.insert(*bone, NodeId::new(place));
    }
    Ok(Humanoid::stated(joints, "the file's VRM extension says so"))
}
