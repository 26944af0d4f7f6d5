//! Recognises creatures with legs and a trunk that are not humanoids.
//!
//! The evidence is the same in all clips of a skeleton: names of parts that people do not have, a tail, and the lengths
//! of a bird. If the limbs have the lengths of four legs, the stance in the motion is evidence too.

use glam::Vec3;
use mocap_scene::scene::{NodeId, Scene};
use serde::Serialize;

use super::super::poses::poses;
use super::body::Body;
use super::limb::Fit;
use super::quadruped;
use super::refusal::NAMED;
use super::sides::stands;
use super::topology::{Tree, pairs};
use crate::names::words::AnimalPart;

/// A kind of creature that is not a humanoid.
///
/// [`Humanoid`](crate::Humanoid) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Creature {
    /// The creature walks on four legs.
    FourLegged,
    /// The creature has wings, or the legs and the neck of a bird.
    Bird,
    /// The creature has a tail, and its skeleton does not show that it stands on four legs.
    Tailed,
}

impl Creature {
    /// The name of the creature in JSON.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::FourLegged => "four-legged",
            Self::Bird => "bird",
            Self::Tailed => "tailed",
        }
    }
}

/// The largest distance of the ends of four legs from one plane, as a fraction of the length of the legs.
const LEVEL: f32 = 0.2;

/// The smallest distance between the tops of front and hind legs, as a fraction of the length of the legs. A skirt or a
/// cape begins above the legs.
const LEGS_APART: f32 = 0.5;

/// The smallest length of a front or hind leg, as a fraction of the humanoid's thigh plus shin. Fingers are shorter.
const SHORTEST_LEG: f32 = 0.5;

/// The largest number of pairs of limbs that are examined as front and hind legs.
const MOST_PAIRS: usize = 64;

/// The smallest number of joints of a tail. A single joint may be a part of a coat.
const TAIL_JOINTS: usize = 2;

/// The smallest length of a tail, as a fraction of thigh plus shin. A shorter chain may be a part of a coat.
const SHORTEST_TAIL: f32 = 0.3;

/// The distance from the ankle to the toes of a bird, as a fraction of the shin. People have 0.35, with a spread of its
/// logarithm of 0.27 in `tools/figure/fit`. A bird stands on its toes, with the ankle where people have a knee.
const SOLE_OF_BIRD: f32 = 0.6;

/// The distance from the shoulders to the head of a bird, as a fraction of thigh plus shin. People have 0.3.
const NECK_OF_BIRD: f32 = 0.6;

/// The smallest length of upper arm plus forearm that can be front legs, as a fraction of thigh plus shin. People have
/// 0.6, with a spread of 0.06; dogs, cats and horses have 0.8 to 1.1.
const FRONT_LEGS: f32 = 0.78;

/// The smallest ratio of upper arm plus forearm to thigh plus shin, as in [`FRONT_LEGS`], for limbs without names of
/// arms. A dog whose hind legs have four bones has 0.78.
const FRONT_LEGS_WITHOUT_NAMES: f32 = 0.7;

/// The reason for an animal that stands on four limbs.
pub(super) const ON_FOUR_LEGS: &str =
    "the limbs at both ends of the trunk stand below the trunk: an animal on four legs";

/// The kind of creature that the skeleton is instead of a humanoid, with the reason.
pub(super) fn find(scene: &Scene, tree: &Tree, body: &Body) -> Option<(Creature, String)> {
    let name = |node: usize| &scene.nodes[node].name;
    if let Some((kind, node)) = named_part(tree, body) {
        let words = match kind {
            Creature::Bird => "a part of a bird",
            _ => "a part of an animal on four legs",
        };
        return Some((kind, format!("{:?} is {words}", name(node))));
    }
    if is_on_four_legs(scene, tree, body) || has_two_pairs_of_legs(tree, body) {
        return Some((Creature::FourLegged, ON_FOUR_LEGS.to_owned()));
    }
    if has_lengths_of_bird(tree, body) {
        let reason = "the body stands on its toes, and its neck is long: a bird";
        return Some((Creature::Bird, reason.to_owned()));
    }
    let tail = tail(tree, body)?;
    if quadruped::find(scene, tree).is_some() {
        return Some((Creature::FourLegged, ON_FOUR_LEGS.to_owned()));
    }
    Some((Creature::Tailed, format!("{:?} begins a tail: an animal", name(tail))))
}

/// A joint of a limb or of the face with the name of a part that people do not have.
fn named_part(tree: &Tree, body: &Body) -> Option<(Creature, usize)> {
    let limbs = || std::iter::once(&body.legs).chain(&body.arms);
    let is_in_limb = |node: usize| limbs().any(|fit| fit.pair.roots.iter().any(|root| tree.is_within(node, *root)));
    let is_in_face = |node: usize| body.trunk.head.is_some_and(|head| tree.is_within(node, head));
    (0..tree.names.len()).find_map(|node| match tree.names[node].animal? {
        AnimalPart::Wing if is_in_limb(node) => Some((Creature::Bird, node)),
        AnimalPart::Beak if is_in_face(node) => Some((Creature::Bird, node)),
        AnimalPart::Paw if is_in_limb(node) => Some((Creature::FourLegged, node)),
        _ => None,
    })
}

/// The first joint of a tail that branches from the trunk below the shoulders.
fn tail(tree: &Tree, body: &Body) -> Option<usize> {
    let is_tail = |node: usize| tree.is_joint[node] && tree.names[node].animal == Some(AnimalPart::Tail);
    let trunk = &body.trunk;
    let above = trunk.neck.or(trunk.head);
    let springs_from_trunk = |node: usize| {
        let parent = tree.parent[node]?;
        let is_above = above.is_some_and(|above| tree.is_within(parent, above));
        (!is_tail(parent) && !is_above).then_some(())
    };
    (0..tree.names.len()).filter(|&node| is_tail(node)).find(|&node| {
        let joints = tree.chain(node).into_iter().filter(|&node| tree.is_joint[node]).count();
        let length = tree.bone[node] + tree.reach[node];
        springs_from_trunk(node).is_some() && joints >= TAIL_JOINTS && length >= SHORTEST_TAIL * body.legs.long_bones
    })
}

/// Whether the body has the lengths of a bird: it stands on its toes, and its neck is long. The neck must also be
/// longer than the trunk, unlike in figures with large heads and short legs.
fn has_lengths_of_bird(tree: &Tree, body: &Body) -> bool {
    let stands_on_toes = body.legs.joints.iter().all(|joints| {
        let [_, Some(lower), Some(foot), Some(toes)] = *joints else {
            return false;
        };
        let (shin, sole) = (tree.between(lower, foot), tree.between(foot, toes));
        shin > 0.0 && sole >= SOLE_OF_BIRD * shin
    });
    let shoulders = body.arms.as_ref().map(|arms| arms.pair.branch);
    let neck = shoulders.zip(body.trunk.head);
    let neck = neck.map_or(0.0, |(shoulders, head)| tree.between(shoulders, head));
    let trunk = shoulders.map_or(0.0, |shoulders| tree.between(body.trunk.hips, shoulders));
    stands_on_toes && neck >= trunk && neck >= NECK_OF_BIRD * body.legs.long_bones
}

/// Whether two pairs of limbs stand on one level at rest, one pair in front of the other. Any limbs may be the legs,
/// except limbs with the names of arms.
fn has_two_pairs_of_legs(tree: &Tree, body: &Body) -> bool {
    if body.arms.as_ref().is_some_and(|arms| arms.names >= NAMED) {
        return false;
    }
    let tip = |root: usize| tree.at[tree.chain(root).last().copied().unwrap_or(root)];
    let middle = |points: [Vec3; 2]| 0.5 * (points[0] + points[1]);
    let pairs: Vec<[usize; 2]> = pairs(tree, MOST_PAIRS).iter().map(|pair| pair.roots).collect();
    let apart = |a: &[usize; 2], b: &[usize; 2]| {
        let mut roots = a.iter().flat_map(|a| b.iter().map(move |b| (*a, *b)));
        roots.all(|(a, b)| !tree.is_within(a, b) && !tree.is_within(b, a))
    };
    let stand = |a: &[usize; 2], b: &[usize; 2]| {
        let limbs = [a[0], a[1], b[0], b[1]].map(|root| (tree.at[root], tip(root)));
        let along = limbs.iter().map(|(root, tip)| *tip - *root).sum::<Vec3>();
        let length = 0.25 * along.length();
        // The normal of the plane through the ends of the four limbs.
        let [left, right, other, opposite] = limbs.map(|(_, tip)| tip);
        let (one, two) = (right - left, opposite - other);
        let sideways = one + two * one.dot(two).signum();
        let lengthways = middle([left, right]) - middle([other, opposite]);
        let across = sideways.cross(lengthways).normalize_or_zero();
        let down = across * across.dot(along).signum();
        let levels = limbs.map(|(_, tip)| tip.dot(down));
        let (least, most) = levels.into_iter().fold((f32::MAX, f32::MIN), |(least, most), level| {
            (least.min(level), most.max(level))
        });
        let between = middle(a.map(|root| tree.at[root])) - middle(b.map(|root| tree.at[root]));
        let points_down = |(root, tip): &(Vec3, Vec3)| (*tip - *root).normalize_or_zero().dot(down) > 0.75;
        length > SHORTEST_LEG * body.legs.long_bones
            && limbs.iter().all(points_down)
            && most - least < LEVEL * length
            && between.length() > LEGS_APART * length
            && between.normalize_or_zero().dot(down).abs() < 0.5
    };
    let mut both = pairs
        .iter()
        .enumerate()
        .flat_map(|(index, a)| pairs[..index].iter().map(move |b| (a, b)));
    both.any(|(a, b)| apart(a, b) && stand(a, b))
}

/// Whether the limbs at both ends of the trunk stand on the ground: they point in one direction, across the trunk, and
/// have similar lengths. A rest pose whose bones lie along axes is no evidence, so only the motion decides.
fn is_on_four_legs(scene: &Scene, tree: &Tree, body: &Body) -> bool {
    let Some(arms) = &body.arms else { return false };
    let least = if arms.names >= NAMED {
        FRONT_LEGS
    } else {
        FRONT_LEGS_WITHOUT_NAMES
    };
    if arms.long_bones < least * body.legs.long_bones {
        return false;
    }
    let stands_on_four = |at: &dyn Fn(usize) -> Vec3| {
        let direction = |fit: &Fit, start: usize, end: usize| {
            let limb_vectors = fit.joints.map(|joints| {
                let end = joints[end].or(joints[end - 1]);
                joints[start]
                    .zip(end)
                    .map(|(start, end)| (at(end) - at(start)).normalize_or_zero())
            });
            let [Some(a), Some(b)] = limb_vectors else {
                return Vec3::ZERO;
            };
            0.5 * (a + b)
        };
        let legs = direction(&body.legs, 0, 2);
        let front = direction(arms, 1, 3);
        let trunk = (at(arms.pair.branch) - at(body.trunk.hips)).normalize_or_zero();
        legs.dot(front) > 0.75 && legs.dot(trunk).abs() < 0.5 && front.dot(trunk).abs() < 0.5
    };
    if !stands_on_four(&|node| tree.at[node]) && (stands(tree, body) || scene.animations.is_empty()) {
        return false;
    }
    // A body whose bones lie along axes may look like an animal at rest, but not in motion.
    let poses = poses(scene);
    let in_motion = poses
        .iter()
        .filter(|pose| stands_on_four(&|node| pose.position(NodeId::new(node))))
        .count();
    2 * in_motion >= poses.len()
}
