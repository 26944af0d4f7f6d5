//! Explains why the best assignment of joints to bones is not a humanoid.

use mocap_scene::scene::Scene;

use super::body::Body;
use super::limb::{Fit, Kind};
use super::map::LENGTHS_MAY_FIT;
use super::topology::Tree;
use crate::names::words::Part;

/// The mean score of the names of the limbs' bones, from 0 to 1, from which a body counts as named.
pub(super) const NAMED: f32 = 0.5;

/// Whether the joints have the names of a body.
pub(super) fn is_named(tree: &Tree, body: &Body) -> bool {
    let head = body.trunk.head.is_some_and(|head| tree.names[head].says(Part::Head));
    let arms = body.arms.as_ref().map_or(head, |arms| arms.names >= NAMED);
    body.legs.names >= NAMED && arms
}

/// Whether the skeleton is a pelvis with two legs and nothing else, as solved from markers on legs. Their joints have
/// the names and the lengths of legs with feet.
pub(super) fn is_lower_body(tree: &Tree, body: &Body) -> bool {
    let Body { legs, trunk, .. } = body;
    let is_of_legs = |node: usize| legs.pair.roots.iter().any(|root| tree.is_within(node, *root));
    let is_of_body = |node: usize| is_of_legs(node) || tree.is_within(trunk.hips, node);
    let of_leg = |joints: &[Option<usize>; 4]| joints[..3].iter().all(Option::is_some);
    body.arms.is_none()
        && tree.names[trunk.hips].says(Part::Hips)
        && legs.names >= NAMED
        && legs.lengths >= LENGTHS_MAY_FIT
        && legs.joints.iter().all(of_leg)
        && (0..tree.parent.len()).all(|node| !tree.is_joint[node] || is_of_body(node))
}

/// The reason why no two chains can be legs.
pub(super) fn why_there_are_no_legs(tree: &Tree) -> String {
    let joints = tree.is_joint.iter().filter(|is_joint| **is_joint).count();
    let root_children = tree.children.first().map_or(0, Vec::len);
    match joints {
        0 => "there are no joints".to_owned(),
        _ if root_children * 2 > joints && joints > 8 => {
            format!(
                "{root_children} of {joints} joints share one parent: they are markers or tracked points, not a body"
            )
        }
        _ => format!("no two chains among the {joints} joints can be legs"),
    }
}

/// The reason why the best assignment is not a body; `None` if it is a body. A `named` body is refused only without a
/// trunk.
pub(super) fn refusal(scene: &Scene, tree: &Tree, body: &Body, named: bool) -> Option<String> {
    let legs = &body.legs;
    let name = |node: usize| &scene.nodes[node].name;
    let limbs = |fit: &Fit| format!("{:?} and {:?}", name(fit.pair.roots[0]), name(fit.pair.roots[1]));
    if is_lower_body(tree, body) {
        return None;
    }
    let of_fingers = legs.joints.iter().flatten().flatten();
    if of_fingers.clone().any(|node| tree.names[*node].says(Part::Finger)) {
        return Some("the longest pairs of chains are fingers: the skeleton is one hand or two".to_owned());
    }
    if body.trunk.head.is_none() && body.arms.is_none() {
        return Some(format!("there is no trunk with a head or arms above {}", limbs(legs)));
    }
    if named {
        return None;
    }
    let Some(arms) = &body.arms else {
        return Some(format!(
            "there are no arms, and the names of {} do not mean legs",
            limbs(legs)
        ));
    };
    let says_otherwise = |fit: &Fit| fit.names < -0.2;
    for (fit, kind) in [(legs, Kind::Leg), (arms, Kind::Arm)] {
        let word = if kind == Kind::Leg { "legs" } else { "arms" };
        let missing = fit.joints.iter().any(|joints| joints.iter().flatten().count() < 3);
        if says_otherwise(fit) {
            return Some(format!(
                "the joint names of {} mean other parts than {word}",
                limbs(fit)
            ));
        }
        if fit.names < NAMED && (fit.lengths < LENGTHS_MAY_FIT || missing && kind == Kind::Leg) {
            return Some(format!("the lengths of {} do not fit {word}", limbs(fit)));
        }
    }
    let ratio = arms.long_bones / legs.long_bones;
    if !(0.42..=1.0).contains(&ratio) {
        return Some(format!(
            "arms without hands are {ratio:.2} times as long as legs without feet, not about 0.67 times"
        ));
    }
    if body.trunk.lengths < 2.0 * LENGTHS_MAY_FIT {
        return Some("the length of the trunk does not fit its legs and arms".to_owned());
    }
    None
}
