//! Which two limbs are the legs, which the arms, and what is between them: hips, spine, neck and head.

use super::limb::{self, Fit, Kind};
use super::topology::{Pair, Tree, pairs};
use crate::figure::names::words::Part;

/// Pairs that are tried as arms and as legs.
const MOST_PAIRS: usize = 12;

/// Joints between hips and shoulders, and from there to the head. The longest that was met has ten.
const LONGEST_TRUNK: usize = 24;

/// What a body without arms costs: more than arms that fit badly.
const WITHOUT_ARMS: f32 = -10.0;

/// A lead of more than this is clear.
pub(super) const CLEAR_LEAD: f32 = 1.0;

/// What a trunk is worth at most: names of head, neck, spine and hips, a head with a face, and a neck behind the
/// shoulders.
const MOST_OF_TRUNK: f32 = 2.5 + 4.0 + 1.0 + 2.5 + 1.2 + 2.0 + 1.5;

/// A tip that is nearer than this, as a share of the leg, does not count: some writers put it a millimetre off.
const SHORTEST_TIP: f32 = 0.03;

/// The middle of a body.
#[derive(Clone, Debug, Default)]
pub(super) struct Trunk {
    pub(super) hips: usize,
    /// From the joint above the hips to the one that carries the arms.
    pub(super) spine: Vec<usize>,
    pub(super) neck: Option<usize>,
    pub(super) head: Option<usize>,
    /// How well the lengths fit, 0 at best, each in the mean.
    pub(super) lengths: f32,
    pub(super) score: f32,
}

/// A body as it was found.
#[derive(Clone, Debug)]
pub(super) struct Body {
    pub(super) legs: Fit,
    pub(super) arms: Option<Fit>,
    pub(super) trunk: Trunk,
    pub(super) score: f32,
    /// How much better it is than the next reading with other limbs; infinite where there is no other.
    pub(super) lead: f32,
}

/// The reading of the skeleton as a body that fits best; none where no two limbs can be legs.
pub(super) fn find(tree: &Tree) -> Option<Body> {
    let pairs = pairs(tree, MOST_PAIRS);
    let fits = |kind| -> Vec<Option<Fit>> { pairs.iter().map(|pair| limb::fit(tree, pair, kind)).collect() };
    let (as_legs, as_arms) = (fits(Kind::Leg), fits(Kind::Arm));
    let mut limbs: Vec<(f32, &Fit, Option<&Fit>)> = Vec::new();
    for legs in as_legs.iter().flatten() {
        let apart = |arms: &&Fit| are_apart(tree, &legs.pair, &arms.pair);
        let arms = as_arms.iter().flatten().filter(apart).map(Some);
        limbs.extend(arms.chain([None]).map(|arms| (score_of_limbs(legs, arms), legs, arms)));
    }
    limbs.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut bodies: Vec<Body> = Vec::new();
    let mut best = f32::NEG_INFINITY;
    for (score, legs, arms) in limbs {
        // No trunk makes this body the best, or one that the best has to be compared with.
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
    Some(best)
}

/// Whether no limb of one pair is a descendant of a limb of the other.
fn are_apart(tree: &Tree, a: &Pair, b: &Pair) -> bool {
    a.roots
        .iter()
        .all(|&a| b.roots.iter().all(|&b| !tree.is_within(a, b) && !tree.is_within(b, a)))
}

/// What legs and arms are worth without a trunk.
fn score_of_limbs(legs: &Fit, arms: Option<&Fit>) -> f32 {
    legs.score
        + match arms {
            None => WITHOUT_ARMS,
            // Upper arm and forearm are two thirds of thigh and shin.
            Some(arms) => arms.score + 1.5 * limb::near(arms.long_bones / legs.long_bones, 0.67, 0.16),
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
    })
}

/// Where thighs are children of the first joint of the spine, as in Biped, or legs of a joint of their own, the hips
/// are the joint above that has their name.
pub(super) fn move_hips(tree: &Tree, body: &mut Body) {
    let trunk = &mut body.trunk;
    let pelvis = body.legs.pair.branch;
    let shoulders = body.arms.as_ref().map_or(pelvis, |arms| arms.pair.branch);
    // Up from the joint of the legs and down again to the shoulders: where both meet.
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

fn trunk(tree: &Tree, legs: &Fit, arms: Option<&Fit>) -> Option<Trunk> {
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
    // From the pelvis towards the arms; the head is at the end of a chain that branches off this path, or continues it.
    let path = tree.path(pelvis, shoulders.unwrap_or(pelvis));
    if path.len() > LONGEST_TRUNK {
        return None;
    }
    let mut best: Option<Trunk> = None;
    for (place, &from) in path.iter().enumerate() {
        // With arms, a head that leaves at the pelvis is a tail.
        if arms.is_some() && place == 0 && path.len() > 1 {
            continue;
        }
        let before = place.checked_sub(1).map(|before| path[before]);
        let after = path.get(place + 1).copied();
        let away = |other: usize| Some(other) != before && Some(other) != after && !taken(other);
        let down = tree.children[from].iter().copied().filter(|&child| away(child));
        let up = tree.parent[from].filter(|&parent| away(parent));
        for next in down.map(Some).chain(up.map(Some)).chain([None]) {
            let branch = match next {
                Some(next) if tree.parent[from] == Some(next) => upwards(tree, next),
                Some(next) => tree.chain(next),
                None => Vec::new(),
            };
            let lead_to_head = &path[..=place];
            let mut found = read_trunk(tree, legs, lead_to_head, path.len() - 1, &branch);
            found.score -= 1.5 * (path.len() - 1 - place) as f32;
            if best.as_ref().is_none_or(|best| found.score > best.score) {
                best = Some(found);
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

/// Reads the joints from the pelvis to where the head's chain branches off, `path`, and that chain, `branch`.
/// `shoulders_at` is the place of the joint that carries the arms, 0 where there are none.
fn read_trunk(tree: &Tree, legs: &Fit, path: &[usize], shoulders_at: usize, branch: &[usize]) -> Trunk {
    let leg = legs.long_bones;
    let nodes: Vec<usize> = path.iter().chain(branch).copied().collect();
    let along: Vec<f32> = (0..nodes.len()).map(|end| tree.length_of(&nodes[..=end])).collect();
    let is_joint = |place: usize| tree.is_joint[nodes[place]];
    let says_spine = |place: usize| tree.names[nodes[place]].says(Part::Spine);
    let fans = |place: usize| {
        let joints = tree.children[nodes[place]]
            .iter()
            .filter(|child| tree.is_joint[**child]);
        joints.count() >= 2
    };
    let name = |place: usize, part| tree.names[nodes[place]].fits(part);
    let tip = nodes.len() - 1;
    let branch_at = path.len() - 1;
    let mut best = Trunk {
        hips: path[0],
        score: f32::NEG_INFINITY,
        ..Trunk::default()
    };
    let places: Vec<usize> = (1..nodes.len()).filter(|&place| is_joint(place)).collect();
    let first_head = if shoulders_at > 0 { branch_at + 1 } else { 1 };
    let heads = places.iter().copied().filter(|&place| place >= first_head);
    for head in heads.map(Some).chain([None]) {
        let end = head.unwrap_or(tip + 1);
        let necks = places
            .iter()
            .copied()
            .filter(|&place| place >= branch_at.max(1) && place < end);
        for neck in necks.map(Some).chain([None]) {
            let mut lengths = 0.0;
            let mut score = 0.0;
            if let Some(head) = head {
                let behind = along[tip] - along[head];
                score += 2.5 * name(head, Part::Head) + 4.0;
                if behind > SHORTEST_TIP * leg {
                    lengths += 0.7 * limb::near(behind / leg, 0.24, 0.5).max(-2.0);
                }
                lengths += limb::near((along[head] / leg).max(0.02), 0.82, 0.25);
                // Eyes and jaw spring from the head; nothing that springs from a joint of the neck is a head.
                score += if fans(head) { 1.0 } else { 0.0 };
                let behind_a_fan = (first_head..head).any(fans);
                score -= if behind_a_fan { 2.0 } else { 0.0 };
            }
            if let Some(neck) = neck {
                // A neck may be called as the last of the spine.
                let called = name(neck, Part::Neck);
                score += 2.5 * if says_spine(neck) { called.max(-0.1) } else { called };
                // The neck begins behind the shoulders, and is not the joint that carries them but by its name.
                score += if neck > branch_at { 1.2 } else { -1.5 };
                if let Some(head) = head {
                    score += 0.5 * limb::near(((along[head] - along[neck]) / leg).max(0.01), 0.13, 0.6);
                }
            }
            // Without arms the spine ends at the neck.
            let last_of_spine = if shoulders_at > 0 {
                branch_at
            } else {
                neck.or(head).map_or(0, |place| place - 1)
            };
            let above_shoulders = (last_of_spine + 1..neck.or(head).unwrap_or(0)).filter(|&place| says_spine(place));
            let spine: Vec<usize> = (1..=last_of_spine.min(end - 1))
                .filter(|&place| is_joint(place) && Some(place) != neck)
                .chain(above_shoulders.filter(|&place| is_joint(place)))
                .collect();
            let named: f32 = spine.iter().map(|&place| name(place, Part::Spine)).sum();
            score += 2.0 * named / spine.len().max(1) as f32;
            // What is left between spine and neck, or between neck and head, and has no bone.
            let left_out = |place: &&usize| **place > branch_at && **place < end && !spine.contains(place);
            for &place in places.iter().filter(left_out).filter(|place| Some(**place) != neck) {
                let is_in_front = neck.is_some_and(|neck| place < neck);
                score -= if is_in_front { 0.6 } else { 0.1 };
            }
            if shoulders_at > 0 {
                lengths += 1.5 * limb::near(along[shoulders_at.min(tip)] / leg, 0.52, 0.35);
            }
            score += 1.5 * name(0, Part::Hips) + lengths;
            if score > best.score {
                best = Trunk {
                    hips: path[0],
                    spine: spine.iter().map(|place| nodes[*place]).collect(),
                    neck: neck.map(|place| nodes[place]),
                    head: head.map(|place| nodes[place]),
                    lengths: lengths / 3.0,
                    score,
                };
            }
        }
    }
    best
}
