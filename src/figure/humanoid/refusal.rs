//! Why the best reading of a skeleton is not a humanoid.

use mocap_scene::scene::Scene;

use super::body::Body;
use super::limb::{Fit, Kind};
use super::map::LENGTHS_MAY_FIT;
use super::topology::Tree;
use crate::names::words::Part;

/// The mean score of the names of the bones of limbs, from 0 to 1, from which on a body is named: half of them.
pub(super) const NAMED: f32 = 0.5;

/// Whether the names say that it is a body.
pub(super) fn is_named(tree: &Tree, body: &Body) -> bool {
    let head = body.trunk.head.is_some_and(|head| tree.names[head].says(Part::Head));
    let arms = body.arms.as_ref().map_or(head, |arms| arms.names >= NAMED);
    body.legs.names >= NAMED && arms
}

/// What is there where no chains can be legs.
pub(super) fn why_there_are_no_legs(tree: &Tree) -> String {
    let joints = tree.is_joint.iter().filter(|is_joint| **is_joint).count();
    let root_children = tree.children.first().map_or(0, Vec::len);
    match joints {
        0 => "there are no joints".to_owned(),
        _ if root_children * 2 > joints && joints > 8 => {
            format!(
                "{root_children} of {joints} joints have one parent: these are markers or tracked points, not a body"
            )
        }
        _ => format!("no two of the {joints} joints begin chains that can be legs"),
    }
}

/// Why the best reading is not a body.
pub(super) fn refusal(scene: &Scene, tree: &Tree, body: &Body, named: bool) -> Option<String> {
    let legs = &body.legs;
    let name = |node: usize| &scene.nodes[node].name;
    let limbs = |fit: &Fit| format!("{:?} and {:?}", name(fit.pair.roots[0]), name(fit.pair.roots[1]));
    let of_fingers = legs.joints.iter().flatten().flatten();
    if of_fingers.clone().any(|node| tree.names[*node].says(Part::Finger)) {
        return Some("the longest pairs of chains are fingers: this is a hand, or two".to_owned());
    }
    if body.trunk.head.is_none() && body.arms.is_none() {
        return Some(format!(
            "nothing that can be a trunk with a head or arms is above {}",
            limbs(legs)
        ));
    }
    if named {
        return None;
    }
    let Some(arms) = &body.arms else {
        return Some(format!(
            "there are no arms, and the names do not say that {} are legs",
            limbs(legs)
        ));
    };
    let says_otherwise = |fit: &Fit| fit.names < -0.2;
    for (fit, kind) in [(legs, Kind::Leg), (arms, Kind::Arm)] {
        let word = if kind == Kind::Leg { "legs" } else { "arms" };
        let missing = fit.joints.iter().any(|joints| joints.iter().flatten().count() < 3);
        if says_otherwise(fit) {
            return Some(format!("{} have names of something else than {word}", limbs(fit)));
        }
        if fit.names < NAMED && (fit.lengths < LENGTHS_MAY_FIT || missing && kind == Kind::Leg) {
            return Some(format!("{} have not the lengths of {word}", limbs(fit)));
        }
    }
    let ratio = arms.long_bones / legs.long_bones;
    if !(0.42..=1.0).contains(&ratio) {
        return Some(format!(
            "upper arms and forearms are {ratio:.2} of thighs and shins, not about 0.67"
        ));
    }
    if body.trunk.lengths < 2.0 * LENGTHS_MAY_FIT {
        return Some("the trunk has not the length of one that is between such legs and arms".to_owned());
    }
    None
}
