//! Which joint is which bone of a humanoid: from names, from the shape of the tree, and from the lengths of its bones.
//!
//! Names alone mislead: one word is another bone in another program, and many skeletons have numbers for names. So
//! every pair of limbs is tried as legs and as arms, each chain of joints in every reading that keeps their order, and
//! the reading is taken that fits names and lengths best. All of it rests on the skeleton, not on the motion, so that
//! two clips of one skeleton get one map; only where names and rest pose do not tell left from right the motion does.

mod body;
mod creature;
mod explain;
mod fingers;
mod limb;
mod map;
mod refusal;
mod sides;
mod tables;
mod topology;

use std::collections::BTreeMap;

use mocap_scene::error::{Code, Diagnostic, Result, nearest};
use mocap_scene::scene::{Format, HumanoidBone, NodeId, Scene};
use serde::Serialize;

pub use self::creature::Creature;
pub use self::explain::{Explanation, ExplanationRow, PartExplanation};
use self::sides::Found;
use self::topology::Tree;
pub(super) use self::topology::rest_positions;
use super::Confidence;
use crate::rig::Rig;

/// Why a joint of a file that states its bones, as VRM does, is a bone.
const STATED: &str = "the file says so";

/// Why a link of a robot is a bone.
const OF_ROBOT: &str = "the joints of the robot make it one";

/// Joints, by their names, that are bones of the humanoid; `None` for a bone that the skeleton does not have.
pub type HumanoidMap = BTreeMap<HumanoidBone, Option<String>>;

/// A joint that is a bone of the humanoid.
///
/// [`Humanoid`](crate::Humanoid) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct HumanoidJoint {
    /// The joint: where the bone begins.
    pub joint: NodeId,
    /// The confidence.
    pub confidence: Confidence,
    /// The reason, as one phrase.
    pub reason: String,
}

/// Whether the names of the sides are right.
///
/// [`Humanoid`](crate::Humanoid) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Sides {
    /// What is named left is on the left of the body.
    Agree,
    /// What is named left is on its right: the file is mirrored, or its names are meant as a camera sees them.
    Opposite,
    /// The names have no sides, or the body does not show them.
    Unknown,
}

impl Sides {
    /// Its name in JSON.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Agree => "agree",
            Self::Opposite => "opposite",
            Self::Unknown => "unknown",
        }
    }
}

/// The joints of a scene that are bones of the VRM humanoid.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::figure::{Confidence, HumanoidBone, Humanoid};
///
/// let scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// let found = Humanoid::of(&scene);
/// let thigh = &found.bones[&HumanoidBone::LeftUpperLeg];
/// assert_eq!(scene.nodes[thigh.joint.index()].name, "LeftUpLeg");
/// assert_eq!(thigh.confidence, Confidence::Sure);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Humanoid {
    /// Whether the skeleton is a humanoid.
    pub found: bool,
    /// Why it is one, or why not, as one phrase.
    pub reason: String,
    /// What it is instead, where its skeleton shows that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub creature: Option<Creature>,
    /// The bones; empty where the skeleton is not a humanoid.
    pub bones: BTreeMap<HumanoidBone, HumanoidJoint>,
    /// Whether the names of the sides are those of the body's sides.
    pub sides: Sides,
    /// How far to trust that.
    pub sides_confidence: Confidence,
    /// The reason, as one phrase.
    pub sides_reason: String,
}

impl Humanoid {
    /// The joint that is `bone`.
    pub fn joint(&self, bone: HumanoidBone) -> Option<NodeId> {
        self.bones.get(&bone).map(|found| found.joint)
    }

    /// Why the joints of `scene` are read as the bones that they are: what each table of the guess says of the chosen
    /// reading, and what came second. `None` where the file states the bones, and where no two chains can be legs.
    /// Where [`Humanoid::of`] refuses the skeleton, it is the reading that was refused.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// let scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let legs = &mocap::figure::Humanoid::explain(&scene).unwrap().parts[0];
    /// assert_eq!(legs.joints[0], "upperLeg \"LeftUpLeg\"");
    /// assert!(legs.second.as_ref().unwrap().1 < legs.log_likelihood);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn explain(scene: &Scene) -> Option<Explanation> {
        let is_stated = scene.nodes.iter().any(|node| node.humanoid_bone.is_some());
        if is_stated { None } else { explain::explain(scene) }
    }

    /// The bones that VRM requires and that no joint is.
    pub fn missing(&self) -> Vec<HumanoidBone> {
        let required = HumanoidBone::REQUIRED.into_iter();
        required.filter(|bone| !self.bones.contains_key(bone)).collect()
    }

    /// The same with other joints for some bones, each given by its name, or with no joint for a bone. A joint is one
    /// bone: another bone that was found at a joint of the map has none then. A skeleton with a joint for each required
    /// bone is a humanoid.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] where no joint has the name, or two bones have it.
    pub fn with_map(mut self, scene: &Scene, map: HumanoidMap) -> Result<Self> {
        let mut bone_of = BTreeMap::new();
        for (bone, name) in map {
            let Some(name) = name else {
                self.bones.remove(&bone);
                continue;
            };
            let Some(joint) = scene.nodes.iter().position(|node| node.name == name) else {
                let bone = bone.as_str();
                let message = format!("no joint is called {name:?}, which the map names as {bone}");
                let diagnostic = Diagnostic::new(Code::InvalidValue, message);
                return Err(
                    match nearest(&name, scene.nodes.iter().map(|node| node.name.as_str())) {
                        Some(near) => diagnostic.help(format!("did you mean {near:?}?")).into(),
                        None => diagnostic.into(),
                    },
                );
            };
            let joint = HumanoidJoint {
                joint: NodeId::new(joint),
                confidence: Confidence::Sure,
                reason: "the map says so".to_owned(),
            };
            if let Some(other) = bone_of.insert(joint.joint, bone) {
                let (other, bone) = (other.as_str(), bone.as_str());
                let message = format!("the map names {name:?} as {other} and as {bone}: a joint is one bone");
                return Err(Diagnostic::new(Code::InvalidValue, message).into());
            }
            self.bones.insert(bone, joint);
        }
        self.bones
            .retain(|bone, found| bone_of.get(&found.joint).is_none_or(|own| own == bone));
        if !self.found && self.missing().is_empty() {
            self.found = true;
            self.reason = "the map says so".to_owned();
            self.creature = None;
        }
        Ok(self)
    }

    /// Its bones after a node may have been inserted into the scene.
    #[doc(hidden)]
    pub fn after(mut self, inserted: Option<NodeId>) -> Self {
        for bone in self.bones.values_mut() {
            if inserted.is_some_and(|inserted| bone.joint >= inserted) {
                bone.joint = NodeId::new(bone.joint.index() + 1);
            }
        }
        self
    }

    /// Its bones in the scene of a rig, from those in the file.
    #[doc(hidden)]
    pub fn in_rig(mut self, rig: &Rig) -> Self {
        for bone in self.bones.values_mut() {
            bone.joint = rig.node(bone.joint);
        }
        self
    }

    /// A humanoid whose bones a file states.
    pub fn stated(bones: BTreeMap<HumanoidBone, NodeId>, reason: &str) -> Self {
        let joint = |joint| HumanoidJoint {
            joint,
            confidence: Confidence::Sure,
            reason: reason.to_owned(),
        };
        Self {
            found: true,
            reason: reason.to_owned(),
            creature: None,
            bones: bones.into_iter().map(|(bone, node)| (bone, joint(node))).collect(),
            sides: Sides::Agree,
            sides_confidence: Confidence::Sure,
            sides_reason: reason.to_owned(),
        }
    }

    /// With the sides that the body has, where the names say the opposite.
    #[doc(hidden)]
    pub fn with_sides_of_the_body(mut self) -> Self {
        if self.sides == Sides::Opposite {
            let bones = std::mem::take(&mut self.bones);
            self.bones = bones
                .into_iter()
                .map(|(bone, joint)| (bone.mirrored(), joint))
                .collect();
            self.sides = Sides::Agree;
        }
        self
    }

    fn refused(reason: String) -> Self {
        Self {
            found: false,
            sides_reason: reason.clone(),
            reason,
            creature: None,
            bones: BTreeMap::new(),
            sides: Sides::Unknown,
            sides_confidence: Confidence::Unsure,
        }
    }
}

impl Humanoid {
    /// The bones of the humanoid among the joints of `scene`: those that its file states, or else those that are found.
    pub fn of(scene: &Scene) -> Humanoid {
        let stated = scene.nodes.iter().enumerate();
        let stated = stated.filter_map(|(index, node)| Some((node.humanoid_bone?, NodeId::new(index))));
        let stated: BTreeMap<_, _> = stated.collect();
        if !stated.is_empty() {
            let reason = match scene.metadata.format {
                Some(Format::Urdf | Format::Mjcf) => OF_ROBOT,
                _ => STATED,
            };
            return Humanoid::stated(stated, reason);
        }
        #[cfg(debug_assertions)]
        super::found::count();
        let Some(mut rig) = Rig::new(scene, &BTreeMap::new()) else {
            return Humanoid::of_skeleton(scene);
        };
        rig.scene.animations = scene
            .animations
            .iter()
            .map(|motion| rig.in_rig(scene, motion))
            .collect();
        let mut humanoid = Humanoid::of_skeleton(&rig.scene);
        for bone in humanoid.bones.values_mut() {
            bone.joint = rig.node_of_file(bone.joint);
        }
        humanoid
    }

    /// The bones that are found in a scene whose joints are below those that they follow.
    fn of_skeleton(scene: &Scene) -> Humanoid {
        let tree = Tree::new(scene);
        let Some(mut body) = body::find(&tree) else {
            return Humanoid::refused(refusal::why_there_are_no_legs(&tree));
        };
        if let Some((kind, reason)) = creature::find(scene, &tree, &body) {
            return Humanoid {
                creature: Some(kind),
                ..Humanoid::refused(reason)
            };
        }
        let named = refusal::is_named(&tree, &body);
        if let Some(reason) = refusal::refusal(scene, &tree, &body, named) {
            return Humanoid::refused(reason);
        }
        body::move_hips(&tree, &mut body);
        let sides = Found::new(scene, &tree, &body);
        let bones = map::bones(&tree, &body, &sides);
        let reason = if named {
            "the joints have names of a body, and its shape".to_owned()
        } else {
            "two legs, two arms and a trunk have the lengths of a body; the names do not say what they are".to_owned()
        };
        Humanoid {
            found: true,
            reason,
            creature: None,
            bones,
            sides: sides.value,
            sides_confidence: sides.confidence,
            sides_reason: sides.reason,
        }
    }
}
