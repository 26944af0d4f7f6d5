//! Finds the fingers of a hand: the finger of each chain, and the three bones among the joints of the chain.

use glam::Vec3;
use mocap_scene::scene::HumanoidBone as Bone;

use super::topology::Tree;
use crate::names::Name;
use crate::names::words::{FingerKind, Part};

/// The joints of one finger, from the palm outwards, and whether their names show the finger.
pub(super) struct Finger {
    pub(super) kind: FingerKind,
    pub(super) joints: [Option<usize>; 3],
    pub(super) is_named: bool,
}

impl Finger {
    /// The bones of the left hand for [`joints`](Self::joints).
    pub(super) fn bones(&self) -> [Bone; 3] {
        match self.kind {
            FingerKind::Thumb => [
                Bone::LeftThumbMetacarpal,
                Bone::LeftThumbProximal,
                Bone::LeftThumbDistal,
            ],
            FingerKind::Index => [
                Bone::LeftIndexProximal,
                Bone::LeftIndexIntermediate,
                Bone::LeftIndexDistal,
            ],
            FingerKind::Middle => [
                Bone::LeftMiddleProximal,
                Bone::LeftMiddleIntermediate,
                Bone::LeftMiddleDistal,
            ],
            FingerKind::Ring => [Bone::LeftRingProximal, Bone::LeftRingIntermediate, Bone::LeftRingDistal],
            FingerKind::Little => [
                Bone::LeftLittleProximal,
                Bone::LeftLittleIntermediate,
                Bone::LeftLittleDistal,
            ],
        }
    }
}

const KINDS: [FingerKind; 5] = [
    FingerKind::Thumb,
    FingerKind::Index,
    FingerKind::Middle,
    FingerKind::Ring,
    FingerKind::Little,
];

/// The largest number of chains that are examined on one hand.
const MOST_CHAINS: usize = 16;

/// The distance of the knuckles from the wrist, as a fraction of the forearm.
const KNUCKLES: f32 = 0.36;

/// The largest distance of the first joint of a palm from the wrist, as a fraction of the forearm. If joints are
/// numbered from 1 and the first joint is farther, it is the knuckle, and a fourth joint is the tip, as in Mixamo. In
/// SOMA the first joint belongs to the palm, and a joint `End` follows the fourth.
const PALM: f32 = 0.2;

/// The fingers of `hand`. `forearm` is the length of the forearm.
pub(super) fn find(tree: &Tree, hand: usize, forearm: f32) -> Vec<Finger> {
    let mut chains = Vec::new();
    gather(tree, hand, &mut chains, 0);
    let named = by_name(tree, &chains);
    let is_named = !named.is_empty();
    let known = if is_named { named } else { by_place(tree, hand, &chains) };
    known
        .into_iter()
        .map(|(kind, chain)| Finger {
            kind,
            joints: three_joints(tree, hand, forearm, kind, &chain),
            is_named,
        })
        .filter(|finger| finger.joints[0].is_some())
        .collect()
}

/// Collects the chains of joints below the hand, each down to its tip. A joint of the palm carries several chains.
fn gather(tree: &Tree, above: usize, chains: &mut Vec<Vec<usize>>, depth: usize) {
    for &child in &tree.children[above] {
        if !tree.is_joint[child] || chains.len() >= MOST_CHAINS {
            continue;
        }
        let chain = unbranched(tree, child);
        let end = chain.last().copied().unwrap_or(child);
        let goes_on = tree.children[end].iter().any(|below| tree.is_joint[*below]);
        if goes_on && depth < 3 {
            // The joints that several chains have in common belong to the palm.
            gather(tree, end, chains, depth + 1);
        } else {
            chains.push(chain);
        }
    }
}

/// The joints from `start` up to the first joint with several children.
fn unbranched(tree: &Tree, start: usize) -> Vec<usize> {
    let mut chain = vec![start];
    let mut node = start;
    while chain.len() < 8 {
        let mut below = tree.children[node].iter().filter(|child| tree.is_joint[**child]);
        let (Some(&next), None) = (below.next(), below.next()) else {
            break;
        };
        chain.push(next);
        node = next;
    }
    chain
}

fn by_name(tree: &Tree, chains: &[Vec<usize>]) -> Vec<(FingerKind, Vec<usize>)> {
    let mut known: Vec<(FingerKind, Vec<usize>)> = Vec::new();
    for chain in chains {
        // A joint such as `LeftFingerBase` above `LeftHandIndex1` belongs to all fingers at once.
        let names_of_fingers = chain.iter().map(|node| &tree.names[*node]);
        let first = names_of_fingers
            .clone()
            .find(|name| !name.is_helper && name.says(Part::Finger));
        let kind = first.and_then(|name| name.finger);
        if let Some(kind) = kind.filter(|kind| known.iter().all(|(other, _)| other != kind)) {
            known.push((kind, chain.clone()));
        }
    }
    if known.is_empty() {
        return by_number(tree, chains);
    }
    known
}

/// Assigns fingers by number: `Finger01` of Biped counts from 0, and `finger1-1` of MakeHuman counts from 1.
fn by_number(tree: &Tree, chains: &[Vec<usize>]) -> Vec<(FingerKind, Vec<usize>)> {
    let number = |name: &Name| {
        let first = name.numbers.first()?.chars().next()?;
        let is_finger = name.meaning.first().is_some_and(|(part, _)| *part == Part::Finger);
        first.to_digit(10).filter(|_| is_finger).map(|digit| digit as usize)
    };
    let numbered: Vec<(usize, &Vec<usize>)> = chains
        .iter()
        .filter_map(|chain| {
            let number = chain.iter().find_map(|node| number(&tree.names[*node]))?;
            Some((number, chain))
        })
        .collect();
    let first = usize::from(numbered.iter().all(|(number, _)| *number > 0));
    let mut known: Vec<(FingerKind, Vec<usize>)> = Vec::new();
    for (number, chain) in numbered {
        let Some(&kind) = KINDS.get(number - first) else {
            continue;
        };
        if known.iter().all(|(other, _)| *other != kind) {
            // A joint of the palm above the finger has a different kind of name.
            let begins = chain
                .iter()
                .position(|node| !tree.names[*node].numbers.is_empty() && !tree.names[*node].is_helper);
            known.push((kind, chain[begins.unwrap_or(0)..].to_vec()));
        }
    }
    known
}

/// Assigns fingers by the positions of the knuckles. The thumb has one joint less, or begins nearest to the wrist. The
/// other fingers form a row that begins next to the thumb. All five fingers must exist.
fn by_place(tree: &Tree, hand: usize, chains: &[Vec<usize>]) -> Vec<(FingerKind, Vec<usize>)> {
    let long: Vec<&Vec<usize>> = chains.iter().filter(|chain| chain.len() >= 2).collect();
    if long.len() != KINDS.len() {
        return Vec::new();
    }
    let wrist = tree.at[hand];
    let most = long.iter().map(|chain| chain.len()).max().unwrap_or(0);
    let mut shorter = long.iter().filter(|chain| chain.len() < most);
    let thumb = match (shorter.next(), shorter.next()) {
        (Some(thumb), None) => *thumb,
        _ => {
            let from_wrist = |chain: &Vec<usize>| tree.at[chain[0]].distance(wrist);
            let nearest = long.iter().min_by(|a, b| from_wrist(a).total_cmp(&from_wrist(b)));
            let Some(nearest) = nearest else { return Vec::new() };
            *nearest
        }
    };
    let mut row: Vec<&Vec<usize>> = long.iter().copied().filter(|chain| chain[0] != thumb[0]).collect();
    // Metacarpals begin close together, so the position of the second joint counts, too.
    let knuckle = |chain: &Vec<usize>| 0.5 * (tree.at[chain[0]] + tree.at[chain[1]]) - wrist;
    let along_hand = row.iter().map(|chain| knuckle(chain)).sum::<Vec3>().normalize_or_zero();
    let across_hand = |chain: &Vec<usize>| knuckle(chain) - knuckle(chain).dot(along_hand) * along_hand;
    let ends = row
        .iter()
        .enumerate()
        .flat_map(|(index, a)| row[index + 1..].iter().map(move |b| (a, b)));
    let span = ends.map(|(a, b)| across_hand(a) - across_hand(b));
    let Some(axis) = span.max_by(|a, b| a.length().total_cmp(&b.length())) else {
        return Vec::new();
    };
    row.sort_by(|a, b| knuckle(a).dot(axis).total_cmp(&knuckle(b).dot(axis)));
    let to_thumb = |chain: &Vec<usize>| (tree.at[chain[0]] - tree.at[thumb[1]]).dot(axis).abs();
    if to_thumb(row[row.len() - 1]) < to_thumb(row[0]) {
        row.reverse();
    }
    std::iter::once(thumb)
        .chain(row)
        .zip(KINDS)
        .map(|(chain, kind)| (kind, chain.clone()))
        .collect()
}

/// Whether the joints are numbered 1, 2, 3, ...
fn counts_from_one(tree: &Tree, joints: &[usize]) -> bool {
    let number = |node: &usize| tree.names[*node].numbers.last()?.parse().ok();
    joints
        .iter()
        .enumerate()
        .all(|(index, node)| number(node) == Some(index + 1))
}

/// The three bones of a finger among the joints of its chain. The chain may begin with a joint of the palm, and end
/// with the finger's tip.
fn three_joints(tree: &Tree, hand: usize, forearm: f32, kind: FingerKind, chain: &[usize]) -> [Option<usize>; 3] {
    let of_palm = |node: &usize| {
        let joined = &tree.names[*node].without_side;
        ["inhand", "carpal", "palm"].iter().any(|word| joined.contains(word))
    };
    let is_end = |node: &usize| {
        ["end", "nub"]
            .iter()
            .any(|word| tree.names[*node].without_side.ends_with(word))
    };
    // In VRM, the three bones of a thumb include the metacarpal. The three bones of other fingers do not.
    let is_metacarpal_of_thumb =
        |node: &usize| kind == FingerKind::Thumb && tree.names[*node].without_side.contains("thumbmetacarpal");
    let mut joints: Vec<usize> = chain.iter().copied().filter(|node| !is_end(node)).collect();
    if kind != FingerKind::Thumb {
        let palm = joints.iter().take_while(|node| of_palm(node)).count();
        if palm < joints.len() {
            joints.drain(..palm);
        }
    }
    // Helpers such as MakeHuman's `__Thumb1` above `Thumb1`.
    let is_helper = |node: &&usize| tree.names[**node].is_helper && !is_metacarpal_of_thumb(node);
    let helpers = joints.iter().take_while(is_helper).count();
    if helpers < joints.len() {
        joints.drain(..helpers);
    }
    // Among joints with names of fingers, a joint with another name is a tip or a joint of the palm.
    let says_something = |node: &usize| !tree.names[*node].meaning.is_empty() || is_metacarpal_of_thumb(node);
    if joints.iter().any(|node| tree.names[*node].says(Part::Finger)) {
        joints.retain(says_something);
    }
    let from_wrist = |node: usize| tree.between(hand, node) / forearm.max(f32::MIN_POSITIVE);
    // Of four joints, one belongs to the palm or is a tip. The knuckle is at a third of the forearm.
    let is_counted_from_knuckle = counts_from_one(tree, &joints)
        && !chain.iter().any(is_end)
        && joints.first().is_some_and(|first| from_wrist(*first) > PALM);
    while joints.len() > 3 && !is_counted_from_knuckle && kind != FingerKind::Thumb {
        let off = |node: usize| (from_wrist(node) / KNUCKLES).max(1e-3).ln().abs();
        if off(joints[1]) < off(joints[0]) {
            joints.remove(0);
        } else {
            break;
        }
    }
    let mut found = [None; 3];
    for (slot, joint) in found.iter_mut().zip(joints) {
        *slot = Some(joint);
    }
    found
}
