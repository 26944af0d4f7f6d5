//! Names the joints of a humanoid.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fmt;

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::pose::Binding;
use mocap_scene::scene::report::{AppliedStep, JointRename};
use mocap_scene::scene::{HumanoidBone, NodeId, NodeKind, Scene};
use serde::Serialize;

use super::{Humanoid, HumanoidMap};

/// The prefix of an unnamed end site; the name of its parent follows.
const END_SITE: &str = "EndSite_";

/// The largest number of joints that a message lists.
const MOST_LISTED: usize = 8;

/// The joints that were renamed, and the joints that kept their names.
///
/// [`name_joints`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct NamingReport {
    /// The renamed nodes in their order, each with its earlier name.
    pub renamed: Vec<(NodeId, String)>,
    /// The bones without a new name, and the names of their joints.
    pub unnamed: BTreeMap<HumanoidBone, String>,
    /// The joints that are not bones, and keep their names.
    pub others: Vec<String>,
}

/// Renames the joints of a humanoid. A joint keeps its name if it is not a bone, or if `names` omits its bone or has
/// `None`. Meshes, channels, and end sites named after their joints are renamed too. No joint moves. If the old names
/// exchange left and right, the new names follow the sides of the body.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::figure::{BoneNames, Humanoid, name_joints};
///
/// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
/// let bones = Humanoid::of(&scene);
/// let naming = name_joints(&mut scene, &bones, &BoneNames::Unreal.names())?;
/// assert_eq!(scene.nodes[0].name, "pelvis");
/// assert!(naming.others.contains(&"LHipJoint".to_owned()));
/// # Ok::<(), mocap::Error>(())
/// ```
///
/// # Errors
/// - [`Code::NotHumanoid`] if no bones are found
/// - [`Code::InvalidValue`] if a name is empty or has control characters, if two bones have one name, or if a joint
///   that keeps its name has one of the new names
///
/// After an error, `scene` is unchanged.
pub fn name_joints(scene: &mut Scene, humanoid: &Humanoid, names: &HumanoidMap) -> Result<NamingReport> {
    if !humanoid.found {
        let message = format!(
            "joints get the names of humanoid bones, but the skeleton is not a humanoid: {}",
            humanoid.reason
        );
        return Err(Diagnostic::new(Code::NotHumanoid, message)
            .help("name the bones of the skeleton in a {map}, or do not rename joints")
            .into());
    }
    check(names)?;
    let humanoid = humanoid.clone().with_sides_of_the_body();
    let mut naming = NamingReport::default();
    let mut wanted: BTreeMap<NodeId, &str> = BTreeMap::new();
    for (&bone, joint) in &humanoid.bones {
        match names.get(&bone).and_then(Option::as_deref) {
            Some(name) => {
                wanted.insert(joint.joint, name);
            }
            None => {
                let name = scene.nodes[joint.joint.index()].name.clone();
                naming.unnamed.insert(bone, name);
            }
        }
    }
    let bones: HashSet<NodeId> = humanoid.bones.values().map(|joint| joint.joint).collect();
    let joints = scene.nodes.iter().enumerate();
    let others = joints.filter(|(index, node)| node.kind == NodeKind::Joint && !bones.contains(&NodeId::new(*index)));
    naming.others = others.map(|(_, node)| node.name.clone()).collect();
    let given: HashSet<&str> = wanted.values().copied().collect();
    let kept = naming.unnamed.values().chain(&naming.others);
    if let Some(name) = kept.clone().find(|name| given.contains(name.as_str())) {
        let bone = names.iter().find(|(_, given)| given.as_ref() == Some(name));
        let bone = bone.map_or("", |(bone, _)| bone.as_str());
        let message = format!("two joints would be called \"{name}\": {bone}, and a joint that keeps its name");
        return Err(Diagnostic::new(Code::InvalidValue, message)
            .help("give the bone another name in a file of names, or name the joint of the bone in a {map}")
            .into());
    }
    let joints = named(scene, &wanted);
    naming.renamed = apply_names(scene, &joints);
    scene.metadata.steps.push(AppliedStep::NameJoints { joints });
    Ok(naming)
}

/// Refuses invalid names of joints, and one name for two bones.
fn check(names: &HumanoidMap) -> Result<()> {
    let mut bone_of: HashMap<&str, HumanoidBone> = HashMap::new();
    for (bone, name) in names.iter().filter_map(|(bone, name)| Some((*bone, name.as_deref()?))) {
        let message = if name.chars().all(char::is_whitespace) {
            format!("the name of {} is empty", bone.as_str())
        } else if name.contains(char::is_control) {
            format!("the name of {}, {name:?}, has a control character", bone.as_str())
        } else if let Some(other) = bone_of.insert(name, bone) {
            format!(
                "{} and {} have the same name, \"{name}\"",
                other.as_str(),
                bone.as_str()
            )
        } else {
            continue;
        };
        let help = "give each bone a different name; null keeps the name of a joint";
        return Err(Diagnostic::new(Code::InvalidValue, message).help(help).into());
    }
    Ok(())
}

/// The renamed joints, and their end sites.
fn named(scene: &Scene, wanted: &BTreeMap<NodeId, &str>) -> Vec<JointRename> {
    let mut seen: HashMap<&str, usize> = HashMap::new();
    let mut joints = Vec::new();
    for (index, node) in scene.nodes.iter().enumerate() {
        let earlier = seen.entry(&node.name).or_default();
        let name = wanted.get(&NodeId::new(index)).copied().map(str::to_owned).or_else(|| {
            let parent = node.parent.filter(|_| node.kind == NodeKind::EndSite)?;
            let is_after_parent = node.name.strip_prefix(END_SITE) == Some(scene.nodes[parent.index()].name.as_str());
            let name = wanted.get(&parent).filter(|_| is_after_parent)?;
            Some(format!("{END_SITE}{name}"))
        });
        if let Some(to) = name.filter(|name| *name != node.name) {
            joints.push(JointRename {
                from: node.name.clone(),
                to,
                earlier: *earlier,
            });
        }
        *earlier += 1;
    }
    joints
}

/// Renames joints, meshes and channels. Returns the nodes and their earlier names.
#[doc(hidden)]
pub fn apply_names(scene: &mut Scene, joints: &[JointRename]) -> Vec<(NodeId, String)> {
    let to: HashMap<(&str, usize), &str> = joints
        .iter()
        .map(|joint| ((joint.from.as_str(), joint.earlier), joint.to.as_str()))
        .collect();
    let mut seen: HashMap<String, usize> = HashMap::new();
    let mut renamed = Vec::new();
    let mut names: Vec<String> = Vec::with_capacity(scene.nodes.len());
    for (index, node) in scene.nodes.iter().enumerate() {
        let earlier = seen.entry(node.name.clone()).or_default();
        let name = to.get(&(node.name.as_str(), *earlier));
        if name.is_some() {
            renamed.push((NodeId::new(index), node.name.clone()));
        }
        names.push(name.map_or_else(|| node.name.clone(), |name| (*name).to_owned()));
        *earlier += 1;
    }
    // Find the nodes of channels by their old names, before the nodes are renamed.
    let driven: Vec<Vec<(NodeId, usize)>> = scene
        .animations
        .iter()
        .map(|animation| Binding::new(scene, animation).driven().collect())
        .collect();
    for (animation, driven) in scene.animations.iter_mut().zip(driven) {
        for (node, channel) in driven {
            let channel = &mut animation.channels[channel];
            channel.node_name.clone_from(&names[node.index()]);
            channel.node = Some(node);
        }
    }
    for bone in scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.bones) {
        bone.name.clone_from(&names[bone.node.index()]);
    }
    for (node, name) in scene.nodes.iter_mut().zip(names) {
        node.name = name;
    }
    renamed
}

/// One line for users.
impl fmt::Display for NamingReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "names: {} nodes renamed", self.renamed.len())?;
        if !self.unnamed.is_empty() {
            let bones = self
                .unnamed
                .iter()
                .map(|(bone, name)| format!("{} ({name})", bone.as_str()));
            write!(f, "; no name for {}", listed(bones))?;
        }
        if !self.others.is_empty() {
            let names = self.others.iter().map(|name| format!("\"{name}\""));
            write!(f, "; kept, because they are not bones: {}", listed(names))?;
        }
        Ok(())
    }
}

fn listed(items: impl ExactSizeIterator<Item = String>) -> String {
    let more = items.len().saturating_sub(MOST_LISTED);
    let shown = Vec::from_iter(items.take(MOST_LISTED)).join(", ");
    match more {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}
