//! Finds the legs, the arms, and the trunk between them: hips, spine, neck and head.

use super::limb::{self, Fit, Kind};
use super::tables::{
    ARM_TO_LEG, FACE, HEAD, HEAD_BEHIND_FACE, HEAD_BELOW_SHOULDERS, HEAD_TO_LEG, LEFT_OUT_ABOVE_NECK,
    LEFT_OUT_BELOW_NECK, NECK_AT_SHOULDERS, NECK_BEHIND_SHOULDERS, NECK_TO_LEG, NO_ARMS, SHOULDERS_TO_LEG, Sums,
    TIP_TO_LEG, Tally, weight_of_name,
};
use super::topology::{Pair, Tree, pairs};
use crate::names::words::Part;

/// The largest number of pairs of limbs that are tried as arms and as legs.
const MOST_PAIRS: usize = 12;

/// The largest number of joints between hips and shoulders, and between shoulders and head. The longest known trunk has
/// ten.
const LONGEST_TRUNK: usize = 24;

/// If the score of an assignment is larger than the next score by this number of log-odds (2.7 to 1), the assignment is
/// clear.
pub(super) const CLEAR_LEAD: f32 = 1.0;

/// The largest score of a trunk, in log-odds: names of head, neck, spine and hips, a head with a face, and a neck above
/// the shoulders.
const MOST_OF_TRUNK: f32 = HEAD.log_odds
    + FACE.log_odds
    + NECK_BEHIND_SHOULDERS.log_odds
    + weight_of_name(Part::Head)
    + weight_of_name(Part::Neck)
    + weight_of_name(Part::Spine)
    + weight_of_name(Part::Hips);

/// The number of ratios that score the lengths of a trunk: to the head, to the tip of the head, and to the shoulders.
const LENGTHS_OF_TRUNK: f32 = 3.0;

/// The smallest distance of the head's tip from the head that counts, as a fraction of the leg. Some writers place the
/// tip a millimetre away.
const SHORTEST_TIP: f32 = 0.03;

/// The joints in the middle of a body: hips, spine, neck and head.
#[derive(Clone, Debug, Default)]
pub(super) struct Trunk {
    pub(super) hips: usize,
    /// The joints from the first joint after the hips to the joint that carries the arms.
    pub(super) spine: Vec<usize>,
    pub(super) neck: Option<usize>,
    pub(super) head: Option<usize>,
    /// The mean score of the lengths; 0 is the best score.
    pub(super) lengths: f32,
    pub(super) score: f32,
    /// The path of joints on which the trunk was found.
    path: TrunkPath,
    /// The indices of head and neck in the path.
    head_and_neck: [Option<usize>; 2],
}

/// The assignment of a skeleton's joints to a body.
#[derive(Clone, Debug)]
pub(super) struct Body {
    pub(super) legs: Fit,
    pub(super) arms: Option<Fit>,
    #[doc(hidden)]
    pub trunk: Trunk,
    pub(super) score: f32,
    /// The difference to the score of the best assignment with other limbs than this one; infinite if there is none.
    pub(super) lead: f32,
    /// The first joints of the limbs of the second best assignment, legs before arms, and the score of the assignment.
    pub(super) second: Option<(Vec<[usize; 2]>, f32)>,
}

/// The best assignment of the skeleton's joints to a body; `None` if no two limbs can be legs.
pub(super) fn find(tree: &Tree) -> Option<Body> {
    let pairs = pairs(tree, MOST_PAIRS);
    let fits = |kind| -> Vec<Option<Fit>> {
        let as_stated = |fit: &Fit| limb::is_as_stated(tree, fit, kind);
        pairs
            .iter()
            .map(|pair| limb::fit(tree, pair, kind).filter(as_stated))
            .collect()
    };
    let (as_legs, as_arms) = (fits(Kind::Leg), fits(Kind::Arm));
    let mut limbs: Vec<(f32, &Fit, Option<&Fit>)> = Vec::new();
    for legs in as_legs.iter().flatten() {
        let apart = |arms: &&Fit| are_apart(tree, &legs.pair, &arms.pair);
        let arms = as_arms.iter().flatten().filter(apart).map(Some);
        let armless = (!limb::is_stated(tree, Kind::Arm)).then_some(None);
        limbs.extend(arms.chain(armless).map(|arms| (score_of_limbs(legs, arms), legs, arms)));
    }
    limbs.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut bodies: Vec<Body> = Vec::new();
    let mut best = f32::NEG_INFINITY;
    for (score, legs, arms) in limbs {
        // Even the best trunk could not give this body a score near the best score.
        if score + MOST_OF_TRUNK < best - CLEAR_LEAD {
            break;
        }
        bodies.extend(body(tree, legs, arms));
        best = bodies.last().map_or(best, |body| best.max(body.score));
    }
    bodies.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut best = bodies.first()?.clone();
    let limbs = |body: &Body| (body.legs.pair.roots, body.arms.as_ref().map(|arms| arms.pair.roots));
    let other = bodies
        .iter()
        .find(|other| limbs(other) != limbs(&best) && other.arms.is_some());
    best.lead = other.map_or(f32::INFINITY, |other| best.score - other.score);
    let roots = |body: &Body| {
        let pairs = std::iter::once(&body.legs).chain(&body.arms);
        pairs.map(|fit| fit.pair.roots).collect()
    };
    best.second = other.map(|other| (roots(other), other.score));
    Some(best)
}

/// Whether no limb of one pair is a descendant of a limb of the other pair.
fn are_apart(tree: &Tree, a: &Pair, b: &Pair) -> bool {
    a.roots
        .iter()
        .all(|&a| b.roots.iter().all(|&b| !tree.is_within(a, b) && !tree.is_within(b, a)))
}

/// The score of legs and arms without a trunk.
fn score_of_limbs(legs: &Fit, arms: Option<&Fit>) -> f32 {
    let mut sums = Sums::default();
    weigh_limbs(legs, arms, &mut sums);
    legs.score + arms.map_or(0.0, |arms| arms.score) + sums.sum()
}

/// Adds to `tally` the evidence of how well legs and arms fit each other.
pub(super) fn weigh_limbs(legs: &Fit, arms: Option<&Fit>, tally: &mut impl Tally) {
    match arms {
        None => tally.sign(&NO_ARMS, 1.0),
        Some(arms) => tally.ratio(&ARM_TO_LEG, arms.long_bones / legs.long_bones),
    }
}

fn body(tree: &Tree, legs: &Fit, arms: Option<&Fit>) -> Option<Body> {
    let trunk = trunk(tree, legs, arms)?;
    Some(Body {
        legs: legs.clone(),
        arms: arms.cloned(),
        score: score_of_limbs(legs, arms) + trunk.score,
        trunk,
        lead: f32::INFINITY,
        second: None,
    })
}

/// Moves the hips up the tree. In Biped, thighs are children of the first joint of the spine. In other skeletons, one
/// joint carries only the legs. In both cases, the hips are the parent joint with the name of hips.
pub(super) fn move_hips(tree: &Tree, body: &mut Body) {
    let trunk = &mut body.trunk;
    let pelvis = body.legs.pair.branch;
    let shoulders = body.arms.as_ref().map_or(pelvis, |arms| arms.pair.branch);
    // The common ancestor of the legs and the shoulders.
    let path = tree.path(pelvis, shoulders);
    let top = path
        .iter()
        .position(|node| tree.parent[*node].is_none_or(|above| !path.contains(&above)));
    if let Some(top) = top.filter(|&top| top > 0 && top + 1 < path.len()) {
        trunk.spine.retain(|node| !path[..=top].contains(node));
        if tree.length_of(&path[..=top]) < 0.3 * body.legs.long_bones {
            trunk.hips = path[top];
        }
    }
    let hips = trunk.hips;
    if tree.names[hips].says(Part::Hips) {
        return;
    }
    let above = tree.parent[hips].filter(|above| tree.is_joint[*above] && !trunk.spine.contains(above));
    if let Some(above) = above.filter(|above| tree.names[*above].says(Part::Hips)) {
        if tree.names[hips].says(Part::Spine) || trunk.spine.is_empty() {
            trunk.spine.insert(0, hips);
        }
        trunk.hips = above;
    }
}

/// The best assignment of bones of the trunk to the joints that lie between the legs and the arms.
fn trunk(tree: &Tree, legs: &Fit, arms: Option<&Fit>) -> Option<Trunk> {
    trunk_but(tree, legs, arms, None)
}

/// The best assignment that differs from `but` in hips, neck or head.
pub(super) fn trunk_but(tree: &Tree, legs: &Fit, arms: Option<&Fit>, but: Option<&Trunk>) -> Option<Trunk> {
    let roots = legs.pair.roots;
    let pelvis = legs.pair.branch;
    let shoulders = arms.map(|arms| arms.pair.branch);
    if shoulders == Some(pelvis) && arms.is_some_and(|arms| arms.names < 0.5) {
        return None;
    }
    let taken = |node: usize| {
        let limbs = arms.iter().flat_map(|arms| arms.pair.roots);
        roots.into_iter().chain(limbs).any(|root| root == node)
    };
    // The path from the pelvis towards the arms. The head is at the end of a chain that branches off this path or
    // continues it.
    let path = tree.path(pelvis, shoulders.unwrap_or(pelvis));
    if path.len() > LONGEST_TRUNK {
        return None;
    }
    let mut best: Option<Trunk> = None;
    for (index, &from) in path.iter().enumerate() {
        // With arms, a chain that branches off at the pelvis is a tail, not a head.
        if arms.is_some() && index == 0 && path.len() > 1 {
            continue;
        }
        let before = index.checked_sub(1).map(|before| path[before]);
        let after = path.get(index + 1).copied();
        let away = |other: usize| Some(other) != before && Some(other) != after && !taken(other);
        let down = tree.children[from].iter().copied().filter(|&child| away(child));
        let up = tree.parent[from].filter(|&parent| away(parent));
        for next in down.map(Some).chain(up.map(Some)).chain([None]) {
            let branch = match next {
                Some(next) if tree.parent[from] == Some(next) => upwards(tree, next),
                Some(next) => tree.chain(next),
                None => Vec::new(),
            };
            let read = TrunkPath::new(tree, &path, index, &branch).read(tree, legs, but);
            if let Some(read) = read
                && best.as_ref().is_none_or(|best| read.score > best.score)
            {
                best = Some(read);
            }
        }
    }
    best
}

/// The chain from a node up to the root, for a skeleton whose root is the head.
fn upwards(tree: &Tree, from: usize) -> Vec<usize> {
    std::iter::successors(Some(from), |node| tree.parent[*node])
        .take(LONGEST_TRUNK)
        .collect()
}

/// The joints from the pelvis to the branch of the head's chain, and the joints of this chain.
#[derive(Clone, Debug, Default)]
struct TrunkPath {
    nodes: Vec<usize>,
    /// The length of the path to each node.
    along: Vec<f32>,
    /// Whether each node is a joint.
    are_joints: Vec<bool>,
    /// The index at which the head's chain branches off.
    branch_at: usize,
    /// The index of the joint that carries the arms, in the path from the pelvis; 0 without arms. The head's chain may
    /// branch off below this joint.
    shoulders_at: usize,
    /// The length of the path to the joint that carries the arms.
    to_shoulders: f32,
}

impl TrunkPath {
    /// `path` leads from the pelvis to the joint that carries the arms. `branch` branches off at `index` of `path`.
    fn new(tree: &Tree, path: &[usize], index: usize, branch: &[usize]) -> Self {
        let nodes: Vec<usize> = path[..=index].iter().chain(branch).copied().collect();
        Self {
            along: (0..nodes.len()).map(|end| tree.length_of(&nodes[..=end])).collect(),
            are_joints: nodes.iter().map(|node| tree.is_joint[*node]).collect(),
            nodes,
            branch_at: index,
            shoulders_at: path.len() - 1,
            to_shoulders: tree.length_of(path),
        }
    }

    /// The first index at which a head can be.
    fn first_head(&self) -> usize {
        if self.shoulders_at > 0 { self.branch_at + 1 } else { 1 }
    }

    fn joints(&self) -> impl Iterator<Item = usize> {
        (1..self.nodes.len()).filter(|&index| self.are_joints[index])
    }

    fn says_spine(&self, tree: &Tree, index: usize) -> bool {
        tree.names[self.nodes[index]].says(Part::Spine)
    }

    /// The best assignment of these joints that differs from `but`.
    fn read(&self, tree: &Tree, legs: &Fit, but: Option<&Trunk>) -> Option<Trunk> {
        let mut best: Option<(f32, f32, [Option<usize>; 2])> = None;
        let heads = self.joints().filter(|&index| index >= self.first_head());
        for head in heads.map(Some).chain([None]) {
            let end = head.unwrap_or(self.nodes.len());
            let necks = self
                .joints()
                .filter(|&index| index >= self.branch_at.max(1) && index < end);
            for neck in necks.map(Some).chain([None]) {
                let mut sums = Sums::default();
                self.weigh(tree, legs.long_bones, [head, neck], &mut sums);
                let [as_head, as_neck] = [head, neck].map(|index| index.map(|index| self.nodes[index]));
                let is_other =
                    but.is_none_or(|but| (but.hips, but.head, but.neck) != (self.nodes[0], as_head, as_neck));
                if is_other && best.is_none_or(|(score, ..)| sums.sum() > score) {
                    best = Some((sums.sum(), sums.lengths, [head, neck]));
                }
            }
        }
        let (mut score, mut lengths, mut head_and_neck) = best?;
        if let [Some(holder), neck] = head_and_neck
            && self.holds_a_face(tree, legs.long_bones, holder, neck)
        {
            head_and_neck = [Some(holder - 1), neck];
            let mut sums = Sums::default();
            self.weigh(tree, legs.long_bones, head_and_neck, &mut sums);
            (score, lengths) = (sums.sum(), sums.lengths);
        }
        let [head, neck] = head_and_neck;
        let node = |index: usize| self.nodes[index];
        Some(Trunk {
            hips: node(0),
            spine: self.spine(tree, head_and_neck).into_iter().map(node).collect(),
            neck: neck.map(node),
            head: head.map(node),
            lengths: lengths / LENGTHS_OF_TRUNK,
            score,
            path: self.clone(),
            head_and_neck,
        })
    }

    /// Whether the joint at an index only holds the joints of a face, as `face` of Rigify's rig does. The joint above
    /// it is the head, at the same position.
    fn holds_a_face(&self, tree: &Tree, leg: f32, index: usize, neck: Option<usize>) -> bool {
        let above = index - 1;
        let is_above_neck = above >= self.first_head() && neck.is_none_or(|neck| above > neck);
        let fit = tree.fits(self.nodes[index], Part::Head);
        let says_face = fit > 0.0 && fit < 1.0;
        says_face
            && is_above_neck
            && self.are_joints[above]
            && self.along[index] - self.along[above] < SHORTEST_TIP * leg
    }

    /// The indices of the spine. Without arms, the spine ends at the neck.
    fn spine(&self, tree: &Tree, [head, neck]: [Option<usize>; 2]) -> Vec<usize> {
        let end = head.unwrap_or(self.nodes.len());
        let last = if self.shoulders_at > 0 {
            self.branch_at
        } else {
            neck.or(head).map_or(0, |index| index - 1)
        };
        let above_shoulders = (last + 1..neck.or(head).unwrap_or(0)).filter(|&index| self.says_spine(tree, index));
        (1..=last.min(end - 1))
            .filter(|&index| self.are_joints[index] && Some(index) != neck)
            .chain(above_shoulders.filter(|&index| self.are_joints[index]))
            .collect()
    }

    /// Adds to `tally` the evidence for and against a head and a neck at these indices. `leg` is the length of the
    /// thigh and the shin together.
    fn weigh(&self, tree: &Tree, leg: f32, [head, neck]: [Option<usize>; 2], tally: &mut impl Tally) {
        let fit = |index: usize, part| tree.fits(self.nodes[index], part);
        let along = |index: usize| self.along[index];
        let tip = self.nodes.len() - 1;
        if let Some(head) = head {
            tally.sign(&HEAD, 1.0);
            tally.name(Part::Head, self.nodes[head], fit(head, Part::Head), 1.0);
            let behind = along(tip) - along(head);
            if behind > SHORTEST_TIP * leg {
                tally.ratio(&TIP_TO_LEG, behind / leg);
            }
            tally.ratio(&HEAD_TO_LEG, along(head) / leg);
            // Eyes and jaw branch from the head. A chain that branches from a joint of the neck is not a head.
            let fans = |index: usize| {
                let children = tree.children[self.nodes[index]].iter();
                children.filter(|child| tree.is_joint[**child]).count() >= 2
            };
            if fans(head) && !tree.names[self.nodes[head]].is_helper {
                tally.sign(&FACE, 1.0);
            }
            if (self.first_head()..head).any(fans) {
                tally.sign(&HEAD_BEHIND_FACE, 1.0);
            }
        }
        if let Some(neck) = neck {
            // A neck may have the name of the last spine joint.
            let called = fit(neck, Part::Neck);
            let called = if self.says_spine(tree, neck) {
                called.max(-0.1)
            } else {
                called
            };
            tally.name(Part::Neck, self.nodes[neck], called, 1.0);
            // The neck begins above the shoulders. The joint that carries the shoulders counts as the neck only if it
            // has the name of a neck.
            let is_behind = neck > self.branch_at;
            tally.sign(
                if is_behind {
                    &NECK_BEHIND_SHOULDERS
                } else {
                    &NECK_AT_SHOULDERS
                },
                1.0,
            );
            if let Some(head) = head {
                tally.ratio(&NECK_TO_LEG, (along(head) - along(neck)) / leg);
            }
        }
        let spine = self.spine(tree, [head, neck]);
        let weight = 1.0 / spine.len().max(1) as f32;
        for &index in &spine {
            tally.name(Part::Spine, self.nodes[index], fit(index, Part::Spine), weight);
        }
        // Joints without a bone between spine and neck, or between neck and head.
        let end = head.unwrap_or(self.nodes.len());
        let left_out =
            |index: &usize| *index > self.branch_at && *index < end && !spine.contains(index) && Some(*index) != neck;
        for index in self.joints().filter(left_out) {
            let is_below = neck.is_some_and(|neck| index < neck);
            tally.sign(
                if is_below {
                    &LEFT_OUT_BELOW_NECK
                } else {
                    &LEFT_OUT_ABOVE_NECK
                },
                1.0,
            );
        }
        if self.shoulders_at > 0 {
            tally.ratio(&SHOULDERS_TO_LEG, self.to_shoulders / leg);
            let below = self.shoulders_at - self.branch_at;
            if below > 0 {
                tally.sign(&HEAD_BELOW_SHOULDERS, below as f32);
            }
        }
        tally.name(Part::Hips, self.nodes[0], fit(0, Part::Hips), 1.0);
    }
}

/// Adds to `tally` the evidence for and against the trunk of a body.
pub(super) fn weigh_trunk(tree: &Tree, legs: &Fit, trunk: &Trunk, tally: &mut impl Tally) {
    trunk.path.weigh(tree, legs.long_bones, trunk.head_and_neck, tally);
}
