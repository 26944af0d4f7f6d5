//! Finds the parts of an animal on four legs: trunk, legs, neck, head and tail.
//!
//! Two pairs of limbs are the legs if they stand one behind the other under a level trunk, at rest or in the motion.
//! The names, the axes of a robot's file, the direction of travel, the toes and the tree vote on the front pair. Left
//! and right follow from the front pair and the direction of the legs. Names of sides only raise or lower the
//! confidence.

mod stance;

use std::collections::BTreeMap;

use glam::Vec3;
use mocap_scene::scene::{Format, HumanoidBone as Bone, NodeId, Scene, Side};
use serde::Serialize;

use self::stance::Stance;
use super::super::poses::poses;
use super::Humanoid;
use super::topology::{Pair, Tree, pairs};
use crate::Confidence;
use crate::names::words::Part;
use crate::rig::Rig;

/// The largest number of pairs of limbs that are examined as front and hind legs. The longest pairs are examined.
const MOST_PAIRS: usize = 48;

/// The smallest fraction of the poses in which the legs stand. In jumps and gallops, some poses do not stand.
const LEAST_STANDING: f32 = 0.4;

/// The smallest distance between the tops of front and hind legs, as a fraction of the length of the legs. A skirt
/// begins above the legs.
const LEGS_APART: f32 = 0.4;

/// The cosine of the angle between trunk and leg above which the trunk is not level: 53 degrees.
const STEEP: f32 = 0.6;

/// The smallest cosine of the angle between a leg and straight down in a stance: 60 degrees.
const POINTS_DOWN: f32 = 0.5;

/// The largest height difference between paws, as a fraction of the length of the legs. Paws in the air count too.
const LEVEL: f32 = 0.5;

/// The smallest length of the shorter legs, as a fraction of the longer legs. The arms of a dinosaur are shorter.
const SHORTEST_LEG: f32 = 0.55;

/// The largest length of a girdle, the first bone of a leg, as a fraction of the chain. Thighs are longer.
const SHORT_GIRDLE: f32 = 0.2;

/// The largest distance between joints at one place, as a fraction of the chain: rounding.
const AT_ONE_PLACE: f32 = 1e-3;

/// A leg of an animal on four legs: the joints at which its segments begin.
///
/// [`Figure::quadruped`](crate::Figure::quadruped) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct QuadrupedLeg {
    /// Whether the leg is a front leg.
    pub is_fore: bool,
    /// The side of the body on which the leg is.
    pub side: Side,
    /// The shoulder blade, if it is a separate joint.
    pub girdle: Option<NodeId>,
    /// The hip, or the shoulder.
    pub upper: NodeId,
    /// The stifle, or the elbow.
    pub lower: NodeId,
    /// The hock, or the wrist.
    pub ankle: Option<NodeId>,
    /// The paw, or the hoof.
    pub paw: NodeId,
}

impl QuadrupedLeg {
    /// The name of the leg in JSON.
    pub const fn as_str(&self) -> &'static str {
        match (self.is_fore, self.side) {
            (true, Side::Left) => "leftFore",
            (true, Side::Right) => "rightFore",
            (false, Side::Left) => "leftHind",
            (false, Side::Right) => "rightHind",
        }
    }

    /// The joints of its segments, from the trunk to the paw, with their names in JSON.
    pub fn segments(&self) -> Vec<(&'static str, NodeId)> {
        let names = match self.is_fore {
            true => ["scapula", "shoulder", "elbow", "wrist", "paw"],
            false => ["ilium", "hip", "stifle", "hock", "paw"],
        };
        let joints = [
            self.girdle,
            Some(self.upper),
            Some(self.lower),
            self.ankle,
            Some(self.paw),
        ];
        let found = names.into_iter().zip(joints);
        found.filter_map(|(name, joint)| Some((name, joint?))).collect()
    }

    /// The joints that bend, from the hip or the shoulder to the paw.
    #[doc(hidden)]
    pub fn joints(&self) -> impl Iterator<Item = NodeId> {
        let joints = [Some(self.upper), Some(self.lower), self.ankle, Some(self.paw)];
        joints.into_iter().flatten()
    }
}

/// An animal on four legs, with the joints of its body parts.
///
/// [`Figure::quadruped`](crate::Figure::quadruped) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Quadruped {
    /// The confidence in which legs are front legs, and which side is left.
    pub confidence: Confidence,
    /// The reason, as one phrase.
    pub reason: String,
    /// The joint that carries the hind legs.
    pub pelvis: NodeId,
    /// The joints between pelvis and withers.
    pub spine: Vec<NodeId>,
    /// The joint that carries the front legs. If one joint is the whole trunk, the joint that carries the hind legs.
    pub withers: NodeId,
    /// The joints from the withers to the head.
    pub neck: Vec<NodeId>,
    /// The joint of the head.
    pub head: Option<NodeId>,
    /// The joints of the tail.
    pub tail: Vec<NodeId>,
    /// The left and the right front leg, the left and the right hind leg.
    pub legs: [QuadrupedLeg; 4],
}

impl Quadruped {
    /// The animal in a scene. `humanoid` has the bones that were found, and the kind of the creature. `None` unless the
    /// creature walks on four legs.
    pub(crate) fn of(scene: &Scene, humanoid: &Humanoid) -> Option<Self> {
        let Some(mut rig) = Rig::new(scene, &humanoid.follow) else {
            return find(scene, &Tree::new(scene, Vec::new()));
        };
        let animations = scene.animations.iter();
        rig.scene.animations = animations.map(|motion| rig.in_rig(scene, motion)).collect();
        let found = find(&rig.scene, &Tree::new(&rig.scene, Vec::new()))?;
        Some(found.map(|node| rig.node_of_file(node)))
    }

    /// The joints of the animal as the bones of a humanoid, for steps that only need to know pairs of joints. The front
    /// legs become arms.
    #[doc(hidden)]
    pub fn bones(&self) -> Humanoid {
        let mut bones = BTreeMap::from([(Bone::Hips, self.pelvis)]);
        if self.withers != self.pelvis {
            bones.insert(Bone::Chest, self.withers);
        }
        let middle = [(Bone::Neck, self.neck.first().copied()), (Bone::Head, self.head)];
        bones.extend(middle.into_iter().filter_map(|(bone, joint)| Some((bone, joint?))));
        for leg in &self.legs {
            let names = match leg.is_fore {
                true => [
                    Bone::LeftShoulder,
                    Bone::LeftUpperArm,
                    Bone::LeftLowerArm,
                    Bone::LeftHand,
                ],
                false => [Bone::LeftFoot, Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftToes],
            };
            // Without a hock, the paw is the foot.
            let (first, last) = match (leg.is_fore, leg.ankle) {
                (true, _) => (leg.girdle, Some(leg.paw)),
                (false, None) => (Some(leg.paw), None),
                (false, hock) => (hock, Some(leg.paw)),
            };
            let joints = [first, Some(leg.upper), Some(leg.lower), last];
            let found = names.into_iter().zip(joints);
            bones.extend(found.filter_map(|(bone, joint)| Some((bone.on(leg.side), joint?))));
        }
        Humanoid::stated(bones, &self.reason)
    }

    /// The same animal in another scene. `to` converts a node of the old scene to a node of the new scene.
    #[doc(hidden)]
    pub fn map(self, to: impl Fn(NodeId) -> NodeId) -> Self {
        let all = |nodes: Vec<NodeId>| nodes.into_iter().map(&to).collect();
        Self {
            pelvis: to(self.pelvis),
            spine: all(self.spine),
            withers: to(self.withers),
            neck: all(self.neck),
            head: self.head.map(&to),
            tail: all(self.tail),
            legs: self.legs.map(|leg| QuadrupedLeg {
                girdle: leg.girdle.map(&to),
                upper: to(leg.upper),
                lower: to(leg.lower),
                ankle: leg.ankle.map(&to),
                paw: to(leg.paw),
                ..leg
            }),
            ..self
        }
    }
}

/// A chain of joints that is assigned as a leg, by the indices of its nodes.
#[derive(Clone, Debug)]
struct Limb {
    root: usize,
    girdle: Option<usize>,
    upper: usize,
    lower: usize,
    ankle: Option<usize>,
    paw: usize,
    /// The last node of the chain.
    tip: usize,
    /// The length from the hip or shoulder to the paw, along the bones.
    length: f32,
}

impl Limb {
    fn new(tree: &Tree, root: usize) -> Option<Self> {
        let chain = tree.chain(root);
        let tip = *chain.last()?;
        let is_bone = |node: &usize| tree.is_joint[*node] && (!tree.names[*node].is_helper || *node == root);
        let total = tree.length_of(&chain);
        let mut joints: Vec<usize> = Vec::new();
        for node in chain.iter().copied().filter(is_bone) {
            match joints.last_mut() {
                // Hinges of a robot at one place are one joint. Its links move with the last hinge.
                Some(last) if tree.between(*last, node) <= AT_ONE_PLACE * total => *last = node,
                _ => joints.push(node),
            }
        }
        let mut girdle = None;
        // Several hinges of a robot may carry a leg.
        while let [first, second, _, ..] = joints[..] {
            let says = |node: usize, part| tree.names[node].says(part);
            let is_named = says(first, Part::Shoulder) && (joints.len() > 4 || says(second, Part::UpperArm));
            let is_short = girdle.is_none() && tree.between(first, second) < SHORT_GIRDLE * total;
            if !is_short && !is_named {
                break;
            }
            girdle = Some(joints.remove(0));
        }
        let (upper, lower, ankle, paw) = match joints[..] {
            [upper, lower, ankle, paw, ..] => (upper, lower, Some(ankle), paw),
            [upper, lower, paw] => (upper, lower, None, paw),
            [upper, lower] if tip != lower => (upper, lower, None, tip),
            _ => return None,
        };
        let length = tree.between(upper, paw);
        (length > 0.0).then_some(Self {
            root,
            girdle,
            upper,
            lower,
            ankle,
            paw,
            tip,
            length,
        })
    }

    fn nodes(&self) -> impl Iterator<Item = usize> {
        [Some(self.root), Some(self.upper), Some(self.lower), self.ankle]
            .into_iter()
            .flatten()
    }

    fn is_apart(&self, other: &Self, tree: &Tree) -> bool {
        !tree.is_within(self.root, other.root) && !tree.is_within(other.root, self.root)
    }
}

/// A pair of limbs of one branch.
#[derive(Clone, Debug)]
struct Legs {
    branch: usize,
    limbs: [Limb; 2],
}

impl Legs {
    fn new(tree: &Tree, pair: &Pair) -> Option<Self> {
        let [one, other] = pair.roots.map(|root| Limb::new(tree, root));
        Some(Self {
            branch: pair.branch,
            limbs: [one?, other?],
        })
    }

    fn length(&self) -> f32 {
        0.5 * (self.limbs[0].length + self.limbs[1].length)
    }

    fn middle(&self, view: &[Vec3]) -> Vec3 {
        0.5 * (view[self.limbs[0].upper] + view[self.limbs[1].upper])
    }

    /// 1 if the names mean front legs, -1 if the names mean hind legs.
    fn named(&self, tree: &Tree) -> f32 {
        let of_name = |node: usize| {
            let name = &tree.names[node];
            let has = |words: &[&str]| words.iter().any(|word| name.without_side.contains(word));
            let is_arm = [Part::Shoulder, Part::UpperArm, Part::LowerArm, Part::Hand]
                .iter()
                .any(|part| name.says(*part));
            if has(&["hind", "rear", "back"]) {
                -1.0
            } else if is_arm || has(&["front", "fore"]) {
                1.0
            } else {
                0.0
            }
        };
        let nodes = self.limbs.iter().flat_map(Limb::nodes);
        let sum: f32 = nodes.map(of_name).sum();
        sum.clamp(-1.0, 1.0)
    }
}

/// The animal on four legs in a scene.
pub(super) fn find(scene: &Scene, tree: &Tree) -> Option<Quadruped> {
    let legs = legs(tree);
    search(scene, tree, &legs).map(Stance::read)
}

/// Whether an animal also stands on four legs at rest, unlike a person.
pub(super) fn rests_on_four_legs(scene: &Scene, tree: &Tree) -> bool {
    let legs = legs(tree);
    search(scene, tree, &legs).is_some_and(|stance| stands(&tree.at, stance.pairs))
}

fn legs(tree: &Tree) -> Vec<Legs> {
    let pairs = pairs(tree, MOST_PAIRS);
    pairs.iter().filter_map(|pair| Legs::new(tree, pair)).collect()
}

/// The two pairs of limbs that stand in most poses. If several stand equally often, the longest pairs.
fn search<'a>(scene: &Scene, tree: &'a Tree, all: &'a [Legs]) -> Option<Stance<'a>> {
    let positions = |pose: &mocap_scene::pose::Pose| -> Vec<Vec3> {
        (0..tree.at.len())
            .map(|node| pose.position(NodeId::new(node)))
            .collect()
    };
    let mut views: Vec<Vec<Vec3>> = poses(scene).iter().map(positions).collect();
    views.push(tree.at.clone());
    let mut best: Option<(f32, Stance<'a>)> = None;
    for (index, one) in all.iter().enumerate() {
        for other in &all[..index] {
            let mut limbs = one
                .limbs
                .iter()
                .flat_map(|a| other.limbs.iter().map(move |b| a.is_apart(b, tree)));
            let (short, long) = (one.length().min(other.length()), one.length().max(other.length()));
            if short < SHORTEST_LEG * long || !limbs.all(|is_apart| is_apart) {
                continue;
            }
            let standing: Vec<&[Vec3]> = (views.iter().map(Vec::as_slice))
                .filter(|view| stands(view, [one, other]))
                .collect();
            let fraction = standing.len() as f32 / views.len() as f32;
            let score = fraction * (short + long) * length_of_trunk(&standing, [one, other]);
            let at_rest = scene.animations.is_empty() && stands(&tree.at, [one, other]);
            if (fraction >= LEAST_STANDING || at_rest) && best.as_ref().is_none_or(|(least, _)| score > *least) {
                let stance = Stance {
                    tree,
                    views: standing.into_iter().map(<[Vec3]>::to_vec).collect(),
                    pairs: [one, other],
                    length: 0.5 * (short + long),
                    is_robot: matches!(scene.metadata.format, Some(Format::Urdf | Format::Mjcf)),
                };
                best = Some((score, stance));
            }
        }
    }
    best.map(|(_, stance)| stance)
}

/// The length of the trunk between two pairs of limbs, as a fraction of the sum of its length and its width. It shows
/// the right pairs: four limbs that begin at one joint can be paired across the trunk or along the trunk.
fn length_of_trunk(views: &[&[Vec3]], pairs: [&Legs; 2]) -> f32 {
    let of_view = |view: &&[Vec3]| {
        let along = pairs[0].middle(view).distance(pairs[1].middle(view));
        let width = |legs: &&Legs| view[legs.limbs[0].upper].distance(view[legs.limbs[1].upper]);
        along / (along + 0.5 * pairs.iter().map(width).sum::<f32>()).max(f32::EPSILON)
    };
    views.iter().map(of_view).sum::<f32>() / views.len().max(1) as f32
}

/// Whether two pairs of limbs stand one in front of the other below a level trunk.
fn stands(view: &[Vec3], pairs: [&Legs; 2]) -> bool {
    let limbs = pairs.iter().flat_map(|legs| &legs.limbs);
    let vectors: Vec<Vec3> = limbs.clone().map(|limb| view[limb.paw] - view[limb.upper]).collect();
    let length = 0.25 * vectors.iter().map(|vector| vector.length()).sum::<f32>();
    let down = vectors
        .iter()
        .map(|vector| vector.normalize_or_zero())
        .sum::<Vec3>()
        .normalize_or_zero();
    let along = pairs[0].middle(view) - pairs[1].middle(view);
    let forward = along.normalize_or_zero();
    // During a step, all legs may lean in one direction. So down is measured at right angles to the trunk.
    let below = down.reject_from(along.normalize_or(Vec3::X)).normalize_or_zero();
    let levels = limbs.map(|limb| view[limb.paw].dot(below));
    let (least, most) = levels.fold((f32::MAX, f32::MIN), |(least, most), level| {
        (least.min(level), most.max(level))
    });
    let is_across = |legs: &&Legs| {
        let across = view[legs.limbs[0].upper] - view[legs.limbs[1].upper];
        across.normalize_or_zero().dot(forward).abs() < STEEP
    };
    length > 0.0
        && along.length() > LEGS_APART * length
        && forward.dot(down).abs() < STEEP
        && vectors
            .iter()
            .filter(|vector| vector.normalize_or_zero().dot(down) > POINTS_DOWN)
            .count()
            > 2
        && most - least < LEVEL * length
        && pairs.iter().all(is_across)
}
