//! Finds the bones of a humanoid from names, from the shape of the tree, and from the lengths of its bones.
//!
//! Names alone mislead: the same word means different bones in different programs, and many skeletons have numbers as
//! names. So every pair of limbs is tried as legs and as arms, with every assignment of its joints that keeps their
//! order. The assignment that fits names and lengths best wins. It depends only on the skeleton, not on the motion, so
//! all clips of one skeleton get the same map. The motion has an effect only if names and rest pose do not distinguish
//! left from right.

mod body;
mod creature;
mod explain;
mod fingers;
mod limb;
mod map;
mod quadruped;
mod refusal;
mod sides;
mod stated;
mod tables;
mod topology;

use std::collections::BTreeMap;

use mocap_scene::error::Result;
use mocap_scene::scene::{Format, HumanoidBone, NodeId, Scene};
use serde::Serialize;

pub use self::creature::Creature;
pub use self::explain::{Explanation, ExplanationRow, PartExplanation};
pub use self::quadruped::{Quadruped, QuadrupedLeg};
use self::sides::Found;
pub use self::stated::HumanoidMap;
use self::stated::StatedJoints;
use self::topology::Tree;
pub(super) use self::topology::rest_positions;
use super::Confidence;
use crate::rig::Rig;

/// The reason for bones that the file states, as VRM does.
const STATED: &str = "the file states the bones";

/// The reason for bones that a map states.
const OF_MAP: &str = "the map states the bones";

/// The reason for the bones of a robot.
const OF_ROBOT: &str = "the joints of the robot show the bones";

/// A joint that is a bone of the humanoid.
///
/// [`Humanoid`](crate::Humanoid) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct HumanoidJoint {
    /// The joint: where the bone begins.
    pub joint: NodeId,
    /// The confidence that the joint is this bone.
    pub confidence: Confidence,
    /// The reason for the choice, as one phrase.
    pub reason: String,
}

/// Whether the sides in the names are correct.
///
/// [`Humanoid`](crate::Humanoid) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Sides {
    /// Joints named left are on the left of the body.
    Agree,
    /// Joints named left are on the right of the body: the file is mirrored, or its names use the view of a camera.
    Opposite,
    /// The names have no sides, or the body does not show its sides.
    Unknown,
}

/// The animal on four legs in a scene. `None` if the figure does not walk on four legs.
pub(crate) fn quadruped_of(scene: &Scene, humanoid: &Humanoid) -> Option<Quadruped> {
    let is_one = humanoid.creature == Some(Creature::FourLegged);
    is_one.then(|| Quadruped::of(scene, humanoid)).flatten()
}

impl Sides {
    /// The name of the value in JSON.
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
    /// The reason, as one phrase.
    pub reason: String,
    /// The kind of creature, if the skeleton shows that the figure is an animal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub creature: Option<Creature>,
    /// The bones; empty if the skeleton is not a humanoid.
    pub bones: BTreeMap<HumanoidBone, HumanoidJoint>,
    /// Whether the sides in the names are the sides of the body.
    pub sides: Sides,
    /// The confidence in the sides.
    pub sides_confidence: Confidence,
    /// The reason, as one phrase.
    pub sides_reason: String,
    /// The joints that follow another joint than their parent, each with the joint that it follows. A map states these
    /// joints, or the skin shows them.
    #[serde(skip)]
    pub follow: BTreeMap<NodeId, NodeId>,
}

impl Humanoid {
    /// The joint that is `bone`.
    pub fn joint(&self, bone: HumanoidBone) -> Option<NodeId> {
        self.bones.get(&bone).map(|found| found.joint)
    }

    /// Explains the bones of `scene`: how each table scores the chosen assignment, and the second best assignment.
    /// `None` if the file states the bones, or if no two chains can be legs. If [`Humanoid::of`] refuses the skeleton,
    /// the refused assignment is explained.
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
        if scene.nodes.iter().any(|node| node.humanoid_bone.is_some()) {
            return None;
        }
        let rig = Rig::new(scene, &BTreeMap::new());
        explain::explain(rig.as_ref().map_or(scene, |rig| &rig.scene))
    }

    /// The bones that VRM requires, but the skeleton lacks.
    pub fn missing(&self) -> Vec<HumanoidBone> {
        let required = HumanoidBone::REQUIRED.into_iter();
        required.filter(|bone| !self.bones.contains_key(bone)).collect()
    }

    /// Applies a map. For a bone, the map may state another joint or no joint. It may also state the joint that a joint
    /// follows. A joint can only be one bone. If the map assigns a joint to a bone, another bone that was found at this
    /// joint loses it. A skeleton with a joint for each required bone is a humanoid. If the skeleton was no humanoid
    /// without the map, mocap searches the bones that the map omits, around the bones that the map names.
    ///
    /// # Errors
    /// [`Code::InvalidValue`](mocap_scene::Code::InvalidValue) if no joint has a name of the map, two bones have the
    /// same joint, or a joint would follow its own descendant.
    pub fn with_map(self, scene: &Scene, map: HumanoidMap) -> Result<Self> {
        let stated = StatedJoints::new(scene, &map, &self)?;
        let is_of_file = scene.nodes.iter().any(|node| node.humanoid_bone.is_some());
        let mut humanoid = match stated.follow.is_empty() || is_of_file {
            true => self,
            false => Self::search(scene, &stated.follow, None),
        };
        humanoid.state(&stated);
        if !humanoid.found && stated.has_joints() {
            let around = Self::search(scene, &stated.follow, Some(&stated));
            if around.found {
                humanoid = around;
                humanoid.state(&stated);
            }
        }
        if !humanoid.found && stated.has_joints() {
            let missing = humanoid.missing().into_iter().map(HumanoidBone::as_str);
            let missing = missing.collect::<Vec<_>>().join(", ");
            humanoid.reason = format!("{}; the map leaves out {missing}", humanoid.reason);
        }
        humanoid.follow.extend(stated.follow);
        Ok(humanoid)
    }

    /// Applies the bones of a map.
    fn state(&mut self, stated: &StatedJoints) {
        for (bone, joint) in &stated.bones {
            match joint {
                None => drop(self.bones.remove(bone)),
                Some(joint) => {
                    let joint = HumanoidJoint {
                        joint: *joint,
                        confidence: Confidence::Sure,
                        reason: OF_MAP.to_owned(),
                    };
                    self.bones.insert(*bone, joint);
                }
            }
        }
        self.bones
            .retain(|bone, found| stated.bone_at(found.joint).is_none_or(|own| own == *bone));
        if !self.found && self.missing().is_empty() {
            self.found = true;
            OF_MAP.clone_into(&mut self.reason);
            self.creature = None;
        }
    }

    /// These bones after a node was inserted into the scene. `inserted` is the new node.
    #[doc(hidden)]
    pub fn after(mut self, inserted: Option<NodeId>) -> Self {
        let after = |node: NodeId| match inserted {
            Some(inserted) if node >= inserted => NodeId::new(node.index() + 1),
            _ => node,
        };
        for bone in self.bones.values_mut() {
            bone.joint = after(bone.joint);
        }
        let follow = self.follow.iter().map(|(joint, other)| (after(*joint), after(*other)));
        self.follow = follow.collect();
        self
    }

    /// Converts these bones from nodes of the file to nodes of the scene of a rig.
    #[doc(hidden)]
    pub fn in_rig(mut self, rig: &Rig) -> Self {
        for bone in self.bones.values_mut() {
            bone.joint = rig.node(bone.joint);
        }
        self.follow.clear();
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
            follow: BTreeMap::new(),
        }
    }

    /// Exchanges the left and the right bones if the names contradict the body.
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
            follow: BTreeMap::new(),
        }
    }
}

impl Humanoid {
    /// The bones of the humanoid in `scene`: the bones that its file states, or else the inferred bones.
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
        Self::search(scene, &BTreeMap::new(), None)
    }

    /// Searches for bones. `follow` has the joints that follow another joint, as a map states. `stated` has the joints
    /// that a map names. If it is given, these joints count as having the names of their bones, and the search refuses
    /// no skeleton.
    fn search(scene: &Scene, follow: &BTreeMap<NodeId, NodeId>, stated: Option<&StatedJoints>) -> Humanoid {
        #[cfg(debug_assertions)]
        super::found::count();
        let named = stated.map(|stated| stated.name_joints(scene));
        let scene = named.as_ref().unwrap_or(scene);
        let joints = || stated.iter().flat_map(|stated| stated.bones.values().flatten());
        let Some(mut rig) = Rig::new(scene, follow) else {
            return Humanoid::of_skeleton(scene, joints().map(|joint| joint.index()).collect());
        };
        rig.scene.animations = scene
            .animations
            .iter()
            .map(|motion| rig.in_rig(scene, motion))
            .collect();
        let joints = joints().map(|joint| rig.node(*joint).index());
        let mut humanoid = Humanoid::of_skeleton(&rig.scene, joints.collect());
        for bone in humanoid.bones.values_mut() {
            bone.joint = rig.node_of_file(bone.joint);
        }
        humanoid.follow = rig.followers().collect();
        humanoid
    }

    /// The bones in a scene in which each joint is a child of the joint that it follows. `stated` has the joints that a
    /// map names. If there are any, no skeleton is refused.
    fn of_skeleton(scene: &Scene, stated: Vec<usize>) -> Humanoid {
        let is_mapped = !stated.is_empty();
        let tree = Tree::new(scene, stated);
        let refused = |reason: String| {
            // If no assignment is a person, the skeleton may still be an animal on four legs.
            let is_animal = !is_mapped && quadruped::find(scene, &tree).is_some();
            Humanoid {
                creature: is_animal.then_some(Creature::FourLegged),
                ..Humanoid::refused(if is_animal {
                    creature::ON_FOUR_LEGS.to_owned()
                } else {
                    reason
                })
            }
        };
        let Some(mut body) = body::find(&tree) else {
            return refused(refusal::why_there_are_no_legs(&tree));
        };
        let named = refusal::is_named(&tree, &body);
        if !is_mapped {
            if let Some((kind, reason)) = creature::find(scene, &tree, &body) {
                return Humanoid {
                    creature: Some(kind),
                    ..Humanoid::refused(reason)
                };
            }
            if !named && quadruped::rests_on_four_legs(scene, &tree) {
                return refused(String::new());
            }
            if let Some(reason) = refusal::refusal(scene, &tree, &body, named) {
                return refused(reason);
            }
        }
        body::move_hips(&tree, &mut body);
        let sides = Found::new(scene, &tree, &body);
        let bones = map::bones(&tree, &body, &sides);
        let reason = if is_mapped {
            "the map states the bones of a body".to_owned()
        } else if refusal::is_lower_body(&tree, &body) {
            "two legs have the names and the lengths of a body; there are no joints above the pelvis".to_owned()
        } else if named {
            "the joints have the names and the shape of a body".to_owned()
        } else {
            "two legs, two arms and a trunk have the lengths of a body; their names have no meaning".to_owned()
        };
        Humanoid {
            found: true,
            reason,
            creature: None,
            bones,
            sides: sides.value,
            sides_confidence: sides.confidence,
            sides_reason: sides.reason,
            follow: BTreeMap::new(),
        }
    }
}
