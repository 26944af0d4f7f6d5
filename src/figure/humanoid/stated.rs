//! Reads what a map states about the joints of a scene.

use std::collections::BTreeMap;
use std::ops::{Deref, DerefMut};

use mocap_scene::error::{Code, Diagnostic, Error, Result, nearest};
use mocap_scene::scene::{HumanoidBone, NodeId, Scene};
use serde::{Deserialize, Serialize};

use super::Humanoid;

/// A map: the names of the joints that are bones of the humanoid, and of the joints that follow another joint than
/// their parent.
///
/// ```
/// use mocap::figure::{HumanoidBone, HumanoidMap};
///
/// let map: HumanoidMap = serde_json::from_str(r#"{"hips": "Pelvis", "follow": {"FootIK.L": "leftFoot"}}"#)?;
/// assert_eq!(map[&HumanoidBone::Hips].as_deref(), Some("Pelvis"));
/// assert_eq!(map.follow["FootIK.L"], "leftFoot");
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct HumanoidMap {
    /// The joint of each bone; `None` for a bone that the skeleton lacks.
    #[serde(flatten)]
    pub bones: BTreeMap<HumanoidBone, Option<String>>,
    /// The joints that follow another joint than their parent, each with the bone or the joint that it follows.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub follow: BTreeMap<String, String>,
}

impl HumanoidMap {
    /// An empty map.
    pub fn new() -> Self {
        Self::default()
    }

    /// Whether the map is empty.
    pub fn is_empty(&self) -> bool {
        self.bones.is_empty() && self.follow.is_empty()
    }
}

impl Deref for HumanoidMap {
    type Target = BTreeMap<HumanoidBone, Option<String>>;

    fn deref(&self) -> &Self::Target {
        &self.bones
    }
}

impl DerefMut for HumanoidMap {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.bones
    }
}

impl From<BTreeMap<HumanoidBone, Option<String>>> for HumanoidMap {
    fn from(bones: BTreeMap<HumanoidBone, Option<String>>) -> Self {
        Self {
            bones,
            follow: BTreeMap::new(),
        }
    }
}

impl<const COUNT: usize> From<[(HumanoidBone, Option<String>); COUNT]> for HumanoidMap {
    fn from(bones: [(HumanoidBone, Option<String>); COUNT]) -> Self {
        BTreeMap::from(bones).into()
    }
}

impl FromIterator<(HumanoidBone, Option<String>)> for HumanoidMap {
    fn from_iter<T: IntoIterator<Item = (HumanoidBone, Option<String>)>>(bones: T) -> Self {
        BTreeMap::from_iter(bones).into()
    }
}

/// What a map states, with nodes of a scene instead of names.
pub(super) struct StatedJoints {
    pub(super) bones: BTreeMap<HumanoidBone, Option<NodeId>>,
    pub(super) follow: BTreeMap<NodeId, NodeId>,
}

impl StatedJoints {
    /// `found` has the bones that the map does not name.
    pub(super) fn new(scene: &Scene, map: &HumanoidMap, found: &Humanoid) -> Result<Self> {
        let mut bones = BTreeMap::new();
        let mut bone_of = BTreeMap::new();
        for (bone, name) in &map.bones {
            let Some(name) = name else {
                bones.insert(*bone, None);
                continue;
            };
            let joint = joint(scene, name, || format!("which the map names as {}", bone.as_str()))?;
            if let Some(other) = bone_of.insert(joint, *bone) {
                let (other, bone) = (other.as_str(), bone.as_str());
                let message = format!("the map names {name:?} as {other} and as {bone}: a joint can be only one bone");
                return Err(refused(message));
            }
            bones.insert(*bone, Some(joint));
        }
        let mut stated = Self {
            bones,
            follow: BTreeMap::new(),
        };
        for (follower, leader) in &map.follow {
            let node = joint(scene, follower, || format!("which the map lets follow {leader:?}"))?;
            let leader_node = stated.leader(scene, found, follower, leader)?;
            stated.follow.insert(node, leader_node);
            if stated.hangs_from(scene, leader_node, node) {
                let message = format!("the map lets {follower:?} follow {leader:?}, which is {follower:?} or below it");
                return Err(refused(message));
            }
        }
        Ok(stated)
    }

    /// The joint of the bone `leader`. If there is no such bone, the joint with the name `leader`.
    fn leader(&self, scene: &Scene, found: &Humanoid, follower: &str, leader: &str) -> Result<NodeId> {
        let of_bone = |bone: HumanoidBone| {
            let of_map = self.bones.get(&bone).copied().flatten();
            of_map.or_else(|| found.joint(bone))
        };
        let bone = HumanoidBone::from_name(leader);
        match bone.and_then(of_bone) {
            Some(joint) => Ok(joint),
            None => joint(scene, leader, || format!("which {follower:?} follows in the map")),
        }
    }

    /// Whether a node is another node or its descendant, if joints follow as the map states.
    fn hangs_from(&self, scene: &Scene, node: NodeId, above: NodeId) -> bool {
        let parent = |node: &NodeId| {
            let follows = self.follow.get(node).copied();
            follows.or(scene.nodes[node.index()].parent)
        };
        let mut path = std::iter::successors(Some(node), parent).take(scene.nodes.len() + 1);
        path.any(|node| node == above)
    }

    /// The bone that the map states for a joint.
    pub(super) fn bone_at(&self, joint: NodeId) -> Option<HumanoidBone> {
        let mut bones = self.bones.iter();
        bones.find_map(|(bone, stated)| (*stated == Some(joint)).then_some(*bone))
    }

    /// Whether the map names a joint.
    pub(super) fn has_joints(&self) -> bool {
        self.bones.values().any(Option::is_some)
    }

    /// A copy of the scene in which each joint of the map has the name of its bone.
    pub(super) fn name_joints(&self, scene: &Scene) -> Scene {
        let mut named = scene.clone();
        for (bone, joint) in &self.bones {
            if let Some(joint) = joint {
                bone.as_str().clone_into(&mut named.nodes[joint.index()].name);
            }
        }
        named
    }
}

/// The joint with a name. Fails if no joint has the name. `what` gives the end of the error message: what the map
/// states about the joint.
fn joint(scene: &Scene, name: &str, what: impl Fn() -> String) -> Result<NodeId> {
    let names = || scene.nodes.iter().map(|node| node.name.as_str());
    if let Some(joint) = names().position(|other| other == name) {
        return Ok(NodeId::new(joint));
    }
    let diagnostic = Diagnostic::new(Code::InvalidValue, format!("no joint is called {name:?}, {}", what()));
    let last = last_word(name);
    let same_word = || names().find(|other| last_word(other).eq_ignore_ascii_case(last));
    let near = nearest(name, names()).or_else(same_word);
    Err(match near {
        Some(near) => diagnostic.help(format!("did you mean {near:?}?")).into(),
        None => diagnostic.into(),
    })
}

/// A name without the namespaces and the path before it.
fn last_word(name: &str) -> &str {
    name.rsplit([':', '|']).next().unwrap_or(name)
}

fn refused(message: String) -> Error {
    Diagnostic::new(Code::InvalidValue, message).into()
}
