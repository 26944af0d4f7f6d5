//! Which joints of a chain are the bones of an arm or of a leg: the choice that fits names and lengths best.

use super::topology::{Pair, Tree};
use crate::figure::names::words::Part;

/// How much a name counts against a length that is off by one spread.
const NAME_WEIGHT: f32 = 2.5;

/// What one length may cost at most.
const MOST_OFF: f32 = 4.0;

/// What an optional bone adds where it is found: less than one that does not fit takes away.
const BONUS_OF_OPTIONAL: f32 = 0.6;

/// What is behind hand or foot and shorter than this share of the bone before does not count as a bone: some writers
/// put the tip a millimetre off.
const SHORTEST_TIP: f32 = 0.05;

/// How a chain of joints is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Leg,
    Arm,
}

impl Kind {
    /// Its bones, from the body outwards.
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
    /// How well the lengths fit, 0 at best, a bone in the mean.
    pub(super) lengths: f32,
    /// How well the names fit, a bone in the mean: 1 where all say so, 0 where none says anything.
    pub(super) names: f32,
    /// Both, to compare readings by.
    pub(super) score: f32,
    /// Length of the two long bones.
    pub(super) long_bones: f32,
}

/// The best reading of the two limbs of `pair`; none where they have too few joints.
pub(super) fn fit(tree: &Tree, pair: &Pair, kind: Kind) -> Option<Fit> {
    let chains = pair.roots.map(|root| Chain::new(tree, pair.branch, root, kind));
    let [a, b] = &chains;
    let readings = if a.nodes.len() == b.nodes.len() && a.are_joints == b.are_joints {
        let both = best(&[a, b], kind)?;
        [both, both]
    } else {
        [best(&[a], kind)?, best(&[b], kind)?]
    };
    let nodes = |side: usize| {
        readings[side]
            .places
            .map(|place| place.map(|place: usize| chains[side].nodes[place]))
    };
    let mean = |of: fn(&Reading) -> f32| 0.5 * (of(&readings[0]) + of(&readings[1]));
    Some(Fit {
        pair: pair.clone(),
        joints: [nodes(0), nodes(1)],
        lengths: mean(|reading| reading.lengths),
        names: mean(|reading| reading.names),
        score: mean(|reading| reading.score),
        long_bones: mean(|reading| reading.long_bones),
    })
}

/// The nodes of a limb, from the first that is not of the body.
struct Chain<'a> {
    tree: &'a Tree,
    nodes: Vec<usize>,
    are_joints: Vec<bool>,
    /// Length of the path from the branch to each node.
    along: Vec<f32>,
    /// How well the name of each node fits each of [`Kind::parts`].
    fits: Vec<[f32; 4]>,
    /// The first node from which three or more chains go on: a hand with fingers.
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
                .map(|node| kind.parts().map(|part| tree.names[*node].fits(part)))
                .collect(),
            are_joints: nodes.iter().map(|node| tree.is_joint[*node]).collect(),
            tree,
            nodes,
            along,
        }
    }

    /// How well the names at these places fit, in the sum.
    fn names(&self, places: [Option<usize>; 4]) -> f32 {
        let fits = places
            .iter()
            .enumerate()
            .filter_map(|(part, place)| place.map(|place| self.fits[place][part]));
        fits.sum()
    }

    /// What a reading without toes or collar bone is worth, but for the way to the upper arm.
    fn score(&self, kind: Kind, places: [Option<usize>; 4]) -> f32 {
        let (lengths, bonus, _) = match kind {
            Kind::Leg => leg(self, places),
            Kind::Arm => free_arm(self, places),
        };
        lengths + bonus + NAME_WEIGHT * self.names(places)
    }

    fn length(&self, from: usize, to: usize) -> f32 {
        self.along[to] - self.along[from]
    }

    /// How much longer the path between two nodes is than the straight line, as a share: 0 on one bone.
    fn detour(&self, from: usize, to: usize) -> f32 {
        let length = self.length(from, to);
        let straight = self.tree.at[self.nodes[from]].distance(self.tree.at[self.nodes[to]]);
        if length > 0.0 {
            (1.0 - straight / length).max(0.0)
        } else {
            0.0
        }
    }

    /// The cosine of the angle by which the chain turns at `place`, between `from` and `to`.
    fn turn(&self, from: usize, place: usize, to: usize) -> f32 {
        let at = |place: usize| self.tree.at[self.nodes[place]];
        let before = (at(place) - at(from)).normalize_or_zero();
        let after = (at(to) - at(place)).normalize_or_zero();
        before.dot(after)
    }
}

#[derive(Clone, Copy, Debug)]
struct Reading {
    places: [Option<usize>; 4],
    lengths: f32,
    names: f32,
    score: f32,
    long_bones: f32,
}

/// The best reading of chains that are alike.
///
/// A chain of 16 joints has thousands of readings. What three of the bones cost is computed once for all places of the
/// fourth, and only where the fourth can still make it the best.
fn best(chains: &[&Chain<'_>], kind: Kind) -> Option<Reading> {
    /// What a fourth bone adds at most.
    const MOST_OF_FOURTH: f32 = BONUS_OF_OPTIONAL + NAME_WEIGHT;
    let first = chains[0];
    let joints: Vec<usize> = (0..first.nodes.len())
        .filter(|&place| first.are_joints[place])
        .collect();
    let mut best: Option<(f32, [Option<usize>; 4])> = None;
    let mut consider = |score: f32, places: [Option<usize>; 4]| {
        if best.is_none_or(|(most, _)| score > most) {
            best = Some((score, places));
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
    for (place, &upper) in joints.iter().enumerate() {
        for &lower in &joints[place + 1..] {
            for end in optional(lower) {
                let three = match kind {
                    Kind::Leg => [Some(upper), Some(lower), end, None],
                    Kind::Arm => [None, Some(upper), Some(lower), end],
                };
                let base = mean(&|chain| chain.score(kind, three));
                let most = match kind {
                    Kind::Leg => consider(base, three),
                    Kind::Arm => consider(base + mean(&|chain| without_shoulder(chain, upper, lower)), three),
                };
                if base + MOST_OF_FOURTH <= most {
                    continue;
                }
                match kind {
                    Kind::Leg => {
                        let Some(foot) = end else { continue };
                        for &toes in joints.iter().filter(|joint| **joint > foot) {
                            let of_toes = |chain: &Chain<'_>| {
                                toes_fit(chain, lower, foot, toes) + NAME_WEIGHT * chain.fits[toes][3]
                            };
                            consider(base + mean(&of_toes), [three[0], three[1], end, Some(toes)]);
                        }
                    }
                    Kind::Arm => {
                        for &shoulder in &joints[..place] {
                            let of_shoulder = |chain: &Chain<'_>| {
                                shoulder_fits(chain, shoulder, upper, lower) + NAME_WEIGHT * chain.fits[shoulder][0]
                            };
                            consider(base + mean(&of_shoulder), [Some(shoulder), three[1], three[2], end]);
                        }
                    }
                }
            }
        }
    }
    best.map(|(_, places)| read(chains, kind, places))
}

fn read(chains: &[&Chain<'_>], kind: Kind, places: [Option<usize>; 4]) -> Reading {
    let share = 1.0 / chains.len() as f32;
    let mut reading = Reading {
        places,
        lengths: 0.0,
        names: 0.0,
        score: 0.0,
        long_bones: 0.0,
    };
    let found = places.iter().flatten().count() as f32;
    for chain in chains {
        let (lengths, bonus, long_bones) = match kind {
            Kind::Leg => leg(chain, places),
            Kind::Arm => arm(chain, places),
        };
        let names = chain.names(places);
        reading.lengths += share * lengths / found;
        reading.names += share * names / found;
        reading.long_bones += share * long_bones;
        reading.score += share * (lengths + bonus + NAME_WEIGHT * names);
    }
    reading
}

/// How far a ratio is from what is expected, in squares of `spread`: 0 at best.
pub(super) fn near(ratio: f32, expected: f32, spread: f32) -> f32 {
    if !ratio.is_finite() || ratio <= 0.0 {
        return -MOST_OFF;
    }
    let off = (ratio / expected).ln() / spread;
    -(0.5 * off * off).min(MOST_OFF)
}

/// The lengths' fit, what optional bones add, and the length of thigh and shin. The ratios are those of grown bodies
/// and of the skeletons that programs ship; children and giants differ by less than the spreads.
fn leg(chain: &Chain<'_>, [upper, lower, foot, toes]: [Option<usize>; 4]) -> (f32, f32, f32) {
    let (Some(upper), Some(lower)) = (upper, lower) else {
        return (-MOST_OFF, 0.0, 0.0);
    };
    let tip = chain.nodes.len() - 1;
    let ankle = foot.unwrap_or(tip);
    let (thigh, shin) = (chain.length(upper, lower), chain.length(lower, ankle));
    let mut lengths = near(thigh / shin, 1.0, 0.16);
    // The hip joint is a hand's breadth from the hips.
    lengths += 0.5 * near((chain.along[upper] / thigh).max(0.02), 0.27, 0.6).max(-2.0);
    lengths -= 20.0 * (chain.detour(upper, lower) + chain.detour(lower, ankle)).min(0.15);
    let mut bonus = 0.0;
    match foot {
        None => bonus -= 3.0,
        Some(foot) => {
            let behind = chain.length(foot, tip);
            if behind > SHORTEST_TIP * shin {
                lengths += 0.5 * near(behind / shin, 0.45, 0.45);
                // A foot stands off from the shin, where the rest pose is one.
                let turn = chain.turn(lower, foot, (foot + 1).min(tip));
                bonus += 1.0 - turn.abs().max(0.3);
            }
            bonus += toes.map_or(0.0, |toes| toes_fit(chain, lower, foot, toes));
        }
    }
    (lengths, bonus, thigh + shin)
}

/// What toes add to a leg.
fn toes_fit(chain: &Chain<'_>, lower: usize, foot: usize, toes: usize) -> f32 {
    let (shin, sole) = (chain.length(lower, foot), chain.length(foot, toes));
    BONUS_OF_OPTIONAL + 0.7 * near((sole / shin).max(0.02), 0.36, 0.4)
}

/// The same of an arm: upper arm and forearm.
fn arm(chain: &Chain<'_>, places: [Option<usize>; 4]) -> (f32, f32, f32) {
    let (lengths, bonus, long_bones) = free_arm(chain, places);
    match places {
        [Some(shoulder), Some(upper), Some(lower), _] => {
            let collar = shoulder_fits(chain, shoulder, upper, lower);
            (lengths, bonus + collar, long_bones)
        }
        [None, Some(upper), Some(lower), _] => {
            let without = without_shoulder(chain, upper, lower);
            (lengths + without, bonus, long_bones)
        }
        _ => (lengths, bonus, long_bones),
    }
}

/// An arm from the upper arm on.
fn free_arm(chain: &Chain<'_>, [_, upper, lower, hand]: [Option<usize>; 4]) -> (f32, f32, f32) {
    let (Some(upper), Some(lower)) = (upper, lower) else {
        return (-MOST_OFF, 0.0, 0.0);
    };
    let tip = chain.nodes.len() - 1;
    let wrist = hand.unwrap_or(tip);
    let (upper_arm, forearm) = (chain.length(upper, lower), chain.length(lower, wrist));
    let mut lengths = near(upper_arm / forearm, 1.08, 0.16);
    lengths -= 20.0 * (chain.detour(upper, lower) + chain.detour(lower, wrist)).min(0.15);
    let mut bonus = 0.0;
    match hand {
        None => bonus -= 3.0,
        Some(hand) => {
            let behind = chain.length(hand, tip);
            if behind > SHORTEST_TIP * forearm {
                lengths += 0.5 * near(behind / forearm, 0.6, 0.5);
            }
        }
    }
    // Fingers spring from the hand, or from a joint of the palm right behind it.
    if let Some(fan) = chain.fan {
        match hand {
            Some(hand) if fan >= hand && chain.length(hand, fan) <= 0.35 * forearm => bonus += 2.0,
            _ => bonus -= 2.0,
        }
    }
    (lengths, bonus, upper_arm + forearm)
}

/// What a collar bone adds to an arm.
fn shoulder_fits(chain: &Chain<'_>, shoulder: usize, upper: usize, lower: usize) -> f32 {
    let (collar, upper_arm) = (chain.length(shoulder, upper), chain.length(upper, lower));
    BONUS_OF_OPTIONAL + 0.7 * near((collar / upper_arm).max(0.02), 0.55, 0.35)
}

/// How well the way to an upper arm without a collar bone fits.
fn without_shoulder(chain: &Chain<'_>, upper: usize, lower: usize) -> f32 {
    let upper_arm = chain.length(upper, lower);
    0.5 * near((chain.along[upper] / upper_arm).max(0.02), 0.6, 0.6)
}
