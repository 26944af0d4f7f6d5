//! Finds the bones of an arm or a leg in a chain of joints: the assignment that fits names and lengths best.

use super::tables::{
    COLLAR_TO_UPPER_ARM, DETOUR, FINGERS_AT_HAND, FINGERS_ELSEWHERE, FOOT_STANDS_OFF, FOOT_TO_SHIN, HAND_TO_FOREARM,
    HIP_TO_THIGH, NO_FOOT, NO_HAND, OPTIONAL_BONE, SHOULDER_TO_UPPER_ARM, SOLE_TO_SHIN, Sums, THIGH_TO_SHIN, Tally,
    UPPER_ARM_TO_FOREARM, weight_of_name,
};
use super::topology::{Pair, Tree};
use crate::names::words::Part;

/// The smallest length of a bone after the hand or foot, as a fraction of the bone before. Shorter bones do not count:
/// some writers place the tip a millimetre away.
const SHORTEST_TIP: f32 = 0.05;

/// A larger detour of the joints from the straight line counts as this detour, as a fraction of the bone.
const MOST_DETOUR: f32 = 0.15;

/// A larger cosine of the angle between foot and shin counts as this cosine. In a T-pose, a foot is at right angles to
/// the shin, and in some files at 73 degrees.
const STANDS_OFF: f32 = 0.3;

/// The largest distance beyond the wrist at which fingers may branch off, as a fraction of the forearm.
const PALM: f32 = 0.35;

/// The kind of limb that a chain is assigned to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Leg,
    Arm,
}

impl Kind {
    /// The bones of the limb, from the body outwards.
    pub(super) fn parts(self) -> [Part; 4] {
        match self {
            Self::Leg => [Part::UpperLeg, Part::LowerLeg, Part::Foot, Part::Toes],
            Self::Arm => [Part::Shoulder, Part::UpperArm, Part::LowerArm, Part::Hand],
        }
    }
}

/// The bones of a pair of limbs.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    pub(super) pair: Pair,
    /// For the limb of each root, the node of each of [`Kind::parts`].
    pub(super) joints: [[Option<usize>; 4]; 2],
    /// The mean score of the lengths of the bones; 0 is the best score.
    pub(super) lengths: f32,
    /// The mean fit of the bones' names: 1 if all names agree, 0 if no name has a meaning.
    pub(super) names: f32,
    /// The sum of lengths and names, to compare assignments.
    pub(super) score: f32,
    /// The length of the two long bones.
    pub(super) long_bones: f32,
}

/// The best assignment of the two limbs of `pair`; `None` if the limbs have too few joints.
pub(super) fn fit(tree: &Tree, pair: &Pair, kind: Kind) -> Option<Fit> {
    fit_but(tree, pair, kind, None)
}

/// The best assignment that differs from the joints `but`.
pub(super) fn fit_but(tree: &Tree, pair: &Pair, kind: Kind, but: Option<[[Option<usize>; 4]; 2]>) -> Option<Fit> {
    let chains = pair.roots.map(|root| Chain::new(tree, pair.branch, root, kind));
    let [a, b] = &chains;
    let indices = |side: usize| but.map(|joints| joints[side].map(|joint| chains[side].index_of(joint?)));
    let readings = if a.nodes.len() == b.nodes.len() && a.are_joints == b.are_joints {
        let both = best(&[a, b], kind, indices(0))?;
        [both, both]
    } else {
        [best(&[a], kind, indices(0))?, best(&[b], kind, indices(1))?]
    };
    let nodes = |side: usize| {
        readings[side]
            .indices
            .map(|index| index.map(|index: usize| chains[side].nodes[index]))
    };
    let mean = |of: fn(&LimbHypothesis) -> f32| 0.5 * (of(&readings[0]) + of(&readings[1]));
    Some(Fit {
        pair: pair.clone(),
        joints: [nodes(0), nodes(1)],
        lengths: mean(|reading| reading.lengths),
        names: mean(|reading| reading.names),
        score: mean(|reading| reading.score),
        long_bones: mean(|reading| reading.long_bones),
    })
}

/// Whether a map states a bone of such a limb.
pub(super) fn is_stated(tree: &Tree, kind: Kind) -> bool {
    let names = || tree.stated.iter().map(|node| &tree.names[*node]);
    kind.parts().into_iter().any(|part| names().any(|name| name.says(part)))
}

/// Whether the assignment has each bone of such a limb at the joint that a map states.
pub(super) fn is_as_stated(tree: &Tree, fit: &Fit, kind: Kind) -> bool {
    tree.stated.iter().all(|node| {
        let part = kind.parts().into_iter().position(|part| tree.names[*node].says(part));
        part.is_none_or(|part| fit.joints.iter().any(|joints| joints[part] == Some(*node)))
    })
}

/// Adds to `tally` the evidence for and against the assignment of one limb.
pub(super) fn weigh(tree: &Tree, fit: &Fit, side: usize, kind: Kind, tally: &mut impl Tally) {
    let chain = Chain::new(tree, fit.pair.branch, fit.pair.roots[side], kind);
    let indices = fit.joints[side].map(|joint| chain.index_of(joint?));
    chain.weigh(kind, indices, tally);
}

/// The nodes of a limb, from the first node that does not belong to the trunk.
struct Chain<'a> {
    tree: &'a Tree,
    nodes: Vec<usize>,
    are_joints: Vec<bool>,
    /// The length of the path from the branch to each node.
    along: Vec<f32>,
    /// The fit of each node's name to each of [`Kind::parts`].
    fits: Vec<[f32; 4]>,
    /// The first node with three or more chains below it: a hand with fingers.
    fan: Option<usize>,
}

impl<'a> Chain<'a> {
    fn new(tree: &'a Tree, branch: usize, root: usize, kind: Kind) -> Self {
        let nodes = tree.chain(root);
        let mut length = tree.at[branch].distance(tree.at[root]);
        let mut along = vec![length];
        for &node in &nodes[1..] {
            length += tree.bone[node];
            along.push(length);
        }
        let fans = |node: &usize| {
            let joints = tree.children[*node].iter().filter(|child| tree.is_joint[**child]);
            joints.count() >= 3
        };
        Self {
            fan: nodes.iter().position(fans),
            fits: nodes
                .iter()
                .map(|node| kind.parts().map(|part| tree.fits(*node, part)))
                .collect(),
            are_joints: nodes.iter().map(|node| tree.is_joint[*node]).collect(),
            tree,
            nodes,
            along,
        }
    }

    /// The sum of the fits of these joints' names.
    fn names(&self, indices: [Option<usize>; 4]) -> f32 {
        let fits = indices
            .iter()
            .enumerate()
            .filter_map(|(part, index)| index.map(|index| self.fits[index][part]));
        fits.sum()
    }

    /// The index of a node in the chain.
    fn index_of(&self, node: usize) -> Option<usize> {
        self.nodes.iter().position(|other| *other == node)
    }

    /// Adds to `tally` the evidence for and against an assignment. Returns the length of its long bones.
    fn weigh(&self, kind: Kind, indices: [Option<usize>; 4], tally: &mut impl Tally) -> f32 {
        for (part, (index, fits)) in kind.parts().into_iter().zip(indices.iter().zip(0..)) {
            if let Some(index) = *index {
                tally.name(part, self.nodes[index], self.fits[index][fits], 1.0);
            }
        }
        match kind {
            Kind::Leg => leg(self, indices, tally),
            Kind::Arm => arm(self, indices, tally),
        }
    }

    /// The score of an assignment without toes or collar bone, and without the path to the upper arm.
    fn score(&self, kind: Kind, indices: [Option<usize>; 4]) -> f32 {
        let mut sums = Sums::default();
        match kind {
            Kind::Leg => leg(self, indices, &mut sums),
            Kind::Arm => free_arm(self, indices, &mut sums),
        };
        sums.sum() + self.weighted_names(kind, indices)
    }

    fn weighted_names(&self, kind: Kind, indices: [Option<usize>; 4]) -> f32 {
        let parts = kind.parts().into_iter().zip(indices).enumerate();
        parts
            .filter_map(|(at, (part, index))| Some(weight_of_name(part) * self.fits[index?][at]))
            .sum()
    }

    /// The score that the fourth bone adds to the score of three bones.
    fn fourth(&self, kind: Kind, index: usize, of_lengths: impl FnOnce(&mut Sums)) -> f32 {
        let mut sums = Sums::default();
        of_lengths(&mut sums);
        let part = if kind == Kind::Leg { 3 } else { 0 };
        sums.sum() + weight_of_name(kind.parts()[part]) * self.fits[index][part]
    }

    fn length(&self, from: usize, to: usize) -> f32 {
        self.along[to] - self.along[from]
    }

    /// The detour of the path between two nodes, relative to the straight line, as a fraction: 0 along one bone.
    fn detour(&self, from: usize, to: usize) -> f32 {
        let length = self.length(from, to);
        let straight = self.tree.at[self.nodes[from]].distance(self.tree.at[self.nodes[to]]);
        if length > 0.0 {
            (1.0 - straight / length).max(0.0)
        } else {
            0.0
        }
    }

    /// The detours of two consecutive bones, up to the largest that counts.
    fn detours(&self, [from, middle, to]: [usize; 3]) -> f32 {
        (self.detour(from, middle) + self.detour(middle, to)).min(MOST_DETOUR)
    }

    /// The cosine of the angle at `index` between the directions from `from` and to `to`.
    fn turn(&self, from: usize, index: usize, to: usize) -> f32 {
        let at = |index: usize| self.tree.at[self.nodes[index]];
        let before = (at(index) - at(from)).normalize_or_zero();
        let after = (at(to) - at(index)).normalize_or_zero();
        before.dot(after)
    }
}

#[derive(Clone, Copy, Debug)]
struct LimbHypothesis {
    indices: [Option<usize>; 4],
    lengths: f32,
    names: f32,
    score: f32,
    long_bones: f32,
}

/// The best assignment of two similar chains.
///
/// A chain of 16 joints has thousands of assignments. So the score of three bones is computed only once, and not again
/// for each position of the fourth bone. Positions of the fourth bone are tried only if they can still give the best
/// assignment.
fn best(chains: &[&Chain<'_>], kind: Kind, but: Option<[Option<usize>; 4]>) -> Option<LimbHypothesis> {
    let fourth = if kind == Kind::Leg { Part::Toes } else { Part::Shoulder };
    let most_of_fourth = OPTIONAL_BONE.log_odds + weight_of_name(fourth);
    let first = chains[0];
    let joints: Vec<usize> = (0..first.nodes.len())
        .filter(|&index| first.are_joints[index])
        .collect();
    let mut best: Option<(f32, [Option<usize>; 4])> = None;
    let mut consider = |score: f32, indices: [Option<usize>; 4]| {
        if Some(indices) != but && best.is_none_or(|(most, _)| score > most) {
            best = Some((score, indices));
        }
        best.map_or(score, |(most, _)| most)
    };
    let mean = |of: &dyn Fn(&Chain<'_>) -> f32| {
        let sum: f32 = chains.iter().map(|chain| of(chain)).sum();
        sum / chains.len() as f32
    };
    let optional = |after: usize| {
        let later = joints.iter().copied().filter(move |joint| *joint > after).map(Some);
        std::iter::once(None).chain(later)
    };
    for (index, &upper) in joints.iter().enumerate() {
        for &lower in &joints[index + 1..] {
            for end in optional(lower) {
                let three = match kind {
                    Kind::Leg => [Some(upper), Some(lower), end, None],
                    Kind::Arm => [None, Some(upper), Some(lower), end],
                };
                let base = mean(&|chain| chain.score(kind, three));
                let most = match kind {
                    Kind::Leg => consider(base, three),
                    Kind::Arm => {
                        let path = |chain: &Chain<'_>| {
                            let mut sums = Sums::default();
                            without_shoulder(chain, upper, lower, &mut sums);
                            sums.sum()
                        };
                        consider(base + mean(&path), three)
                    }
                };
                if base + most_of_fourth <= most {
                    continue;
                }
                match kind {
                    Kind::Leg => {
                        let Some(foot) = end else { continue };
                        for &toes in joints.iter().filter(|joint| **joint > foot) {
                            let of_toes = |chain: &Chain<'_>| {
                                chain.fourth(kind, toes, |sums| toes_fit(chain, lower, foot, toes, sums))
                            };
                            consider(base + mean(&of_toes), [three[0], three[1], end, Some(toes)]);
                        }
                    }
                    Kind::Arm => {
                        for &shoulder in &joints[..index] {
                            let of_shoulder = |chain: &Chain<'_>| {
                                let collar = |sums: &mut Sums| shoulder_fits(chain, shoulder, upper, lower, sums);
                                chain.fourth(kind, shoulder, collar)
                            };
                            consider(base + mean(&of_shoulder), [Some(shoulder), three[1], three[2], end]);
                        }
                    }
                }
            }
        }
    }
    best.map(|(_, indices)| read(chains, kind, indices))
}

fn read(chains: &[&Chain<'_>], kind: Kind, indices: [Option<usize>; 4]) -> LimbHypothesis {
    let weight = 1.0 / chains.len() as f32;
    let mut reading = LimbHypothesis {
        indices,
        lengths: 0.0,
        names: 0.0,
        score: 0.0,
        long_bones: 0.0,
    };
    let found = indices.iter().flatten().count() as f32;
    for chain in chains {
        let mut sums = Sums::default();
        let long_bones = chain.weigh(kind, indices, &mut sums);
        reading.lengths += weight * sums.lengths / found;
        reading.names += weight * chain.names(indices) / found;
        reading.long_bones += weight * long_bones;
        reading.score += weight * sums.sum();
    }
    reading
}

/// Adds the evidence of a leg's lengths and shape. Returns the length of thigh plus shin.
fn leg(chain: &Chain<'_>, [upper, lower, foot, toes]: [Option<usize>; 4], tally: &mut impl Tally) -> f32 {
    let (Some(upper), Some(lower)) = (upper, lower) else {
        return 0.0;
    };
    let tip = chain.nodes.len() - 1;
    let ankle = foot.unwrap_or(tip);
    let (thigh, shin) = (chain.length(upper, lower), chain.length(lower, ankle));
    tally.ratio(&THIGH_TO_SHIN, thigh / shin);
    tally.ratio(&HIP_TO_THIGH, chain.along[upper] / thigh);
    tally.sign(&DETOUR, chain.detours([upper, lower, ankle]));
    match foot {
        None => tally.sign(&NO_FOOT, 1.0),
        Some(foot) => {
            let behind = chain.length(foot, tip);
            if behind > SHORTEST_TIP * shin {
                tally.ratio(&FOOT_TO_SHIN, behind / shin);
                let turn = chain.turn(lower, foot, (foot + 1).min(tip));
                tally.sign(&FOOT_STANDS_OFF, 1.0 - turn.abs().max(STANDS_OFF));
            }
            if let Some(toes) = toes {
                toes_fit(chain, lower, foot, toes, tally);
            }
        }
    }
    thigh + shin
}

/// The score of toes.
fn toes_fit(chain: &Chain<'_>, lower: usize, foot: usize, toes: usize, tally: &mut impl Tally) {
    let (shin, sole) = (chain.length(lower, foot), chain.length(foot, toes));
    tally.sign(&OPTIONAL_BONE, 1.0);
    tally.ratio(&SOLE_TO_SHIN, sole / shin);
}

/// Adds the evidence of an arm's lengths and shape. Returns the length of upper arm plus forearm.
fn arm(chain: &Chain<'_>, indices: [Option<usize>; 4], tally: &mut impl Tally) -> f32 {
    match indices {
        [Some(shoulder), Some(upper), Some(lower), _] => shoulder_fits(chain, shoulder, upper, lower, tally),
        [None, Some(upper), Some(lower), _] => without_shoulder(chain, upper, lower, tally),
        _ => {}
    }
    free_arm(chain, indices, tally)
}

/// The evidence of an arm, starting at the upper arm.
fn free_arm(chain: &Chain<'_>, [_, upper, lower, hand]: [Option<usize>; 4], tally: &mut impl Tally) -> f32 {
    let (Some(upper), Some(lower)) = (upper, lower) else {
        return 0.0;
    };
    let tip = chain.nodes.len() - 1;
    let wrist = hand.unwrap_or(tip);
    let (upper_arm, forearm) = (chain.length(upper, lower), chain.length(lower, wrist));
    tally.ratio(&UPPER_ARM_TO_FOREARM, upper_arm / forearm);
    tally.sign(&DETOUR, chain.detours([upper, lower, wrist]));
    match hand {
        None => tally.sign(&NO_HAND, 1.0),
        Some(hand) => {
            let behind = chain.length(hand, tip);
            if behind > SHORTEST_TIP * forearm {
                tally.ratio(&HAND_TO_FOREARM, behind / forearm);
            }
        }
    }
    // Fingers branch from the hand, or from a joint of the palm right after the hand.
    if let Some(fan) = chain.fan {
        match hand {
            Some(hand) if fan >= hand && chain.length(hand, fan) <= PALM * forearm => tally.sign(&FINGERS_AT_HAND, 1.0),
            _ => tally.sign(&FINGERS_ELSEWHERE, 1.0),
        }
    }
    upper_arm + forearm
}

/// The score of a collar bone.
fn shoulder_fits(chain: &Chain<'_>, shoulder: usize, upper: usize, lower: usize, tally: &mut impl Tally) {
    let (collar, upper_arm) = (chain.length(shoulder, upper), chain.length(upper, lower));
    tally.sign(&OPTIONAL_BONE, 1.0);
    tally.ratio(&COLLAR_TO_UPPER_ARM, collar / upper_arm);
}

/// The score of the path to an upper arm without a collar bone.
fn without_shoulder(chain: &Chain<'_>, upper: usize, lower: usize, tally: &mut impl Tally) {
    tally.ratio(&SHOULDER_TO_UPPER_ARM, chain.along[upper] / chain.length(upper, lower));
}
