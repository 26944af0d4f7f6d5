//! Creatures are no humanoids, and what is said of them names what they are.

use mocap::Scene;
use mocap::figure::{Creature, humanoid};
use mocap::glam::{Mat4, Vec3};
use mocap::retarget::{RetargetOptions, Retargeter};
use mocap::scene::{Node, NodeId, NodeKind, UpAxis};

/// A skeleton at rest, in centimetres: each joint with its parent and its OFFSET.
fn skeleton(joints: &[(String, Option<usize>, [f32; 3])]) -> Scene {
    let node = |(name, parent, offset): &(String, Option<usize>, [f32; 3])| Node {
        name: name.clone(),
        kind: NodeKind::Joint,
        parent: parent.map(NodeId::new),
        transform: Mat4::from_translation(Vec3::from(*offset)),
        ..Node::default()
    };
    let mut scene = Scene {
        nodes: joints.iter().map(node).collect(),
        ..Scene::default()
    };
    (scene.metadata.metres_per_unit, scene.metadata.up) = (Some(0.01), Some(UpAxis::Y));
    scene
}

/// Joints in the order in which they are added, parents first.
#[derive(Default)]
struct Body(Vec<(String, Option<usize>, [f32; 3])>);

impl Body {
    fn add(&mut self, name: &str, parent: Option<usize>, offset: [f32; 3]) -> usize {
        self.0.push((name.to_owned(), parent, offset));
        self.0.len() - 1
    }

    fn chain(&mut self, names: &[&str], mut parent: usize, offsets: &[[f32; 3]]) -> usize {
        for (name, offset) in names.iter().zip(offsets) {
            parent = self.add(name, Some(parent), *offset);
        }
        parent
    }

    /// Both limbs of a pair; `names` without the side, offsets of the left one.
    fn pair(&mut self, names: [&str; 5], parent: usize, offsets: [[f32; 3]; 5]) {
        for (side, sign) in [("Left", 1.0), ("Right", -1.0)] {
            let names = names.map(|name| format!("{side}{name}"));
            let offsets = offsets.map(|[x, y, z]| [sign * x, y, z]);
            self.chain(&names.each_ref().map(String::as_str), parent, &offsets);
        }
    }
}

const LEG: [&str; 5] = ["UpLeg", "Leg", "Foot", "ToeBase", "ToeEnd"];
const ARM: [&str; 5] = ["Shoulder", "Arm", "ForeArm", "Hand", "HandEnd"];

/// A dog of 55 cm, with the names that a program for people gives its joints.
fn dog(has_tail: bool) -> Scene {
    let mut dog = Body::default();
    let hips = dog.add("Hips", None, [0.0, 55.0, 0.0]);
    let spine = dog.chain(&["Spine", "Spine1"], hips, &[[0.0, 2.0, 18.0], [0.0, 1.0, 24.0]]);
    dog.chain(
        &["Neck", "Head", "HeadEnd"],
        spine,
        &[[0.0, 8.0, 8.0], [0.0, 10.0, 14.0], [0.0, -2.0, 18.0]],
    );
    let front = [
        [6.0, -2.0, 4.0],
        [0.0, -14.0, 6.0],
        [0.0, -17.0, -8.0],
        [0.0, -18.0, 3.0],
        [0.0, 0.0, 6.0],
    ];
    dog.pair(ARM, spine, front);
    let hind = [
        [7.0, -3.0, -4.0],
        [0.0, -19.0, 3.0],
        [0.0, -17.0, -10.0],
        [0.0, -14.0, 4.0],
        [0.0, 0.0, 6.0],
    ];
    dog.pair(LEG, hips, hind);
    if has_tail {
        dog.chain(&["Tail", "Tail1"], hips, &[[0.0, 4.0, -14.0], [0.0, -8.0, -12.0]]);
    }
    skeleton(&dog.0)
}

/// A flamingo of 1.4 m. Its wings are called arms.
fn flamingo() -> Scene {
    let mut bird = Body::default();
    let hips = bird.add("Hips", None, [0.0, 72.0, 0.0]);
    let spine = bird.add("Spine", Some(hips), [0.0, 4.0, 14.0]);
    bird.chain(
        &["Neck", "Neck1", "Neck2", "Neck3", "Head", "HeadEnd"],
        spine,
        &[
            [0.0, 8.0, 8.0],
            [0.0, 13.0, 4.0],
            [0.0, 13.0, 2.0],
            [0.0, 13.0, -1.0],
            [0.0, 12.0, 4.0],
            [0.0, -3.0, 14.0],
        ],
    );
    let wing = [
        [4.0, 4.0, 2.0],
        [16.0, 0.0, -4.0],
        [18.0, 0.0, 3.0],
        [16.0, 0.0, -6.0],
        [12.0, 0.0, -4.0],
    ];
    bird.pair(ARM, spine, wing);
    let leg = [
        [6.0, -4.0, 0.0],
        [0.0, -12.0, 6.0],
        [0.0, -24.0, -14.0],
        [0.0, -30.0, 2.0],
        [0.0, 0.0, 9.0],
    ];
    bird.pair(LEG, hips, leg);
    skeleton(&bird.0)
}

/// A body of a person of 1.7 m, but for its tail: a monkey, as far as its skeleton tells.
fn person(tail: usize) -> Scene {
    let mut body = Body::default();
    let hips = body.add("Hips", None, [0.0, 95.0, 0.0]);
    let spine = body.chain(&["Spine", "Spine1"], hips, &[[0.0, 12.0, 0.0], [0.0, 20.0, 0.0]]);
    body.chain(
        &["Neck", "Head", "HeadEnd"],
        spine,
        &[[0.0, 18.0, 0.0], [0.0, 10.0, 1.0], [0.0, 18.0, 0.0]],
    );
    let arm = [
        [4.0, 14.0, 0.0],
        [14.0, 0.0, 0.0],
        [28.0, 0.0, 0.0],
        [26.0, 0.0, 0.0],
        [16.0, 0.0, 0.0],
    ];
    body.pair(ARM, spine, arm);
    let leg = [
        [9.0, -5.0, 0.0],
        [0.0, -42.0, 0.0],
        [0.0, -42.0, -2.0],
        [0.0, -6.0, 14.0],
        [0.0, 0.0, 7.0],
    ];
    body.pair(LEG, hips, leg);
    let names: Vec<String> = (0..tail).map(|joint| format!("Tail{joint}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    body.chain(&names, hips, &vec![[0.0, 2.0, -12.0]; tail]);
    skeleton(&body.0)
}

#[test]
fn creatures_are_refused_by_their_class() {
    for (scene, class) in [
        (dog(true), Creature::FourLegged),
        (dog(false), Creature::FourLegged),
        (flamingo(), Creature::Bird),
        (person(5), Creature::Tailed),
    ] {
        let found = humanoid(&scene);
        assert_eq!(found.creature, Some(class), "{}", found.reason);
        assert!(!found.found && found.bones.is_empty());
        let hero = person(0);
        let refused = Retargeter::new(&scene, &hero, &RetargetOptions::default()).unwrap_err();
        let words = refused.to_string();
        assert!(
            words.contains("not a humanoid") && words.contains(&found.reason),
            "{words}"
        );
    }
}

/// What is a person stays one: without a tail, and with what is too short for one, as the end of a coat.
#[test]
fn a_person_is_no_creature() {
    for tail in [0, 1] {
        let found = humanoid(&person(tail));
        assert!(found.found && found.creature.is_none(), "{tail}: {}", found.reason);
    }
}

/// A map says what the guess refuses.
#[test]
fn a_map_overrules_the_class() {
    let scene = person(5);
    let map = humanoid(&person(0)).bones;
    let named = map
        .iter()
        .map(|(bone, joint)| (*bone, Some(scene.nodes[joint.joint.index()].name.clone())));
    let found = humanoid(&scene).with_map(&scene, named.collect()).unwrap();
    assert!(found.found && found.creature.is_none() && found.missing().is_empty());
}
