//! Creatures are not humanoids, and the messages name the kind of creature.

use std::f32::consts::FRAC_PI_2;

use mocap::figure::{Creature, Humanoid};
use mocap::glam::{EulerRot, Mat4, Quat, Vec3};
use mocap::retarget::report::Verdict;
use mocap::retarget::{PoseRetargetOptions, PoseRetargeter};
use mocap::retarget::{RetargetOptions, Retargeter};
use mocap::scene::{Animation, Channel, Keys, Node, NodeId, NodeKind, UpAxis};
use mocap::{Pose, Scene};

/// A skeleton at rest, in centimetres: each joint with its parent and its OFFSET.
pub(crate) fn skeleton(joints: &[(String, Option<usize>, [f32; 3])]) -> Scene {
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
pub(crate) struct Body(pub(crate) Vec<(String, Option<usize>, [f32; 3])>);

impl Body {
    pub(crate) fn add(&mut self, name: &str, parent: Option<usize>, offset: [f32; 3]) -> usize {
        self.0.push((name.to_owned(), parent, offset));
        self.0.len() - 1
    }

    pub(crate) fn chain(&mut self, names: &[&str], mut parent: usize, offsets: &[[f32; 3]]) -> usize {
        for (name, offset) in names.iter().zip(offsets) {
            parent = self.add(name, Some(parent), *offset);
        }
        parent
    }

    /// Both limbs of a pair. `names` omit the side, and `offsets` belong to the left limb.
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

/// A dog of 55 cm. A program for people gave names to its joints.
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

/// The body of a person of 1.7 m with a tail. By its skeleton, it is a monkey.
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
        let found = Humanoid::of(&scene);
        assert_eq!(found.creature, Some(class), "{}", found.reason);
        assert!(!found.found && found.bones.is_empty());
        let hero = person(0);
        let refused = PoseRetargeter::new(&scene, &hero, &PoseRetargetOptions::default()).unwrap_err();
        let words = refused.to_string();
        assert!(
            words.contains("not a humanoid") && words.contains(&found.reason),
            "{words}"
        );
    }
}

/// A person stays a person: without a tail, and with a chain that is too short for a tail, such as the end of a coat.
#[test]
fn a_person_is_no_creature() {
    for tail in [0, 1] {
        let found = Humanoid::of(&person(tail));
        assert!(found.found && found.creature.is_none(), "{tail}: {}", found.reason);
    }
}

/// A map can make a humanoid of a refused skeleton.
#[test]
fn a_map_overrules_the_class() {
    let scene = person(5);
    let map = Humanoid::of(&person(0)).bones;
    let named = map
        .iter()
        .map(|(bone, joint)| (*bone, Some(scene.nodes[joint.joint.index()].name.clone())));
    let found = Humanoid::of(&scene).with_map(&scene, named.collect()).unwrap();
    assert!(found.found && found.creature.is_none() && found.missing().is_empty());
}

/// The skeleton, rotated about +Y and scaled, with other axes for each joint: the same animal in another size, built by
/// another program.
fn rebuilt(scene: &Scene, size: f32, heading: f32) -> Scene {
    let turn = Quat::from_rotation_y(heading);
    let rest = Pose::rest(scene);
    let axes = |node: usize| Quat::from_euler(EulerRot::XYZ, 0.3 * node as f32, 1.1, 0.7 * node as f32);
    let world = |node: usize| {
        let place = size * (turn * rest.position(NodeId::new(node)));
        Mat4::from_rotation_translation(axes(node), place)
    };
    let mut made = scene.clone();
    for (index, node) in made.nodes.iter_mut().enumerate() {
        let parent = node.parent.map_or(Mat4::IDENTITY, |parent| world(parent.index()));
        node.transform = parent.inverse() * world(index);
    }
    made
}

/// A trot: every joint swings, and the hips move forward, up and down.
fn trot(mut scene: Scene) -> Scene {
    const FRAMES: usize = 40;
    let channels = scene.nodes.iter().enumerate().map(|(index, node)| {
        let rest = node.transform.w_axis.truncate();
        let swing = |frame: usize| {
            let angle = 0.3 * (0.4 * frame as f32 + index as f32).sin();
            Quat::from_rotation_x(angle) * Quat::from_rotation_y(0.3 * angle)
        };
        let way = |frame: usize| rest + Vec3::new(0.0, (0.5 * frame as f32).sin(), 3.0 * frame as f32);
        Channel {
            node_name: node.name.clone(),
            node: Some(NodeId::new(index)),
            position_keys: match index {
                0 => Keys::every_tick((0..FRAMES).map(way).collect()),
                _ => Keys::constant(rest),
            },
            rotation_keys: Keys::every_tick((0..FRAMES).map(swing).collect()),
            scaling_keys: Keys::constant(Vec3::ONE),
        }
    });
    let channels = channels.collect();
    scene.animations = vec![Animation {
        name: "trot".to_owned(),
        ticks_per_second: 30.0,
        duration: (FRAMES - 1) as f64,
        channels,
    }];
    scene
}

/// The dog of another size and facing moves like the dog. Every joint has the position of the source's joint, rotated
/// and scaled, except for the height of the ground.
#[test]
fn a_creature_moves_as_another_of_its_kind() {
    for (size, heading) in [(1.0, 0.0), (1.7, FRAC_PI_2), (0.4, -FRAC_PI_2)] {
        let source = trot(dog(true));
        let target = rebuilt(&dog(true), size, heading);
        let options = RetargetOptions::new().lock_feet(false);
        let done = Retargeter::new(source.clone(), target, options).unwrap();
        let report = done.clips()[0].report.body().unwrap();
        let names = report.by_names.as_ref().unwrap();
        assert_eq!((names.joints, names.by_parts), (source.nodes.len(), true));
        assert_eq!(names.creature, "four-legged");
        // The generated trot has no floor. Its feet go below the floor, and the verdict counts this.
        assert_ne!(report.verdict, Verdict::Poor, "{report}");
        assert!(report.max_degrees < 0.1, "{}", report.max_degrees);
        assert!((report.scale - f64::from(size)).abs() < 1e-4);
        let moved = done.scene();
        let turn = Quat::from_rotation_y(heading);
        let mut ground: Option<f32> = None;
        for tick in [0.0, 7.0, 19.0, 39.0] {
            let [from, to] = [&source, &moved].map(|scene| Pose::at_tick(scene, 0, tick).unwrap());
            for node in (0..source.nodes.len()).map(NodeId::new) {
                let off = to.position(node) - size * (turn * from.position(node));
                let ground = *ground.get_or_insert(off.y);
                assert!(off.distance(ground * Vec3::Y) < 0.02, "{size}: {off}, in centimetres");
            }
        }
    }
}

/// Joints that only one animal has are reported, and the other joints move.
#[test]
fn what_a_creature_lacks_is_said() {
    let done = Retargeter::new(trot(dog(true)), dog(false), RetargetOptions::new()).unwrap();
    let report = done.clips()[0].report.body().unwrap().by_names.clone().unwrap();
    assert_eq!(report.lacking, ["Tail", "Tail1"]);
    assert_eq!(report.joints, done.scene().nodes.len());
}

#[test]
fn creatures_of_other_kinds_and_names_are_refused() {
    let refused = |source: Scene, target: Scene| {
        let error = Retargeter::new(source, target, RetargetOptions::new()).unwrap_err();
        assert_eq!(error.code().as_str(), "not-humanoid");
        error.to_string()
    };
    let words = refused(trot(dog(true)), flamingo());
    assert!(
        words.contains("the target is bird (") && words.contains("the source is four-legged ("),
        "{words}"
    );
    let words = refused(trot(person(0)), dog(true));
    assert!(
        words.contains("the target is four-legged (") && words.contains("the source is a humanoid"),
        "{words}"
    );
    let words = refused(trot(dog(true)), person(0));
    assert!(words.contains("the source is not a humanoid"), "{words}");
    let mut named = trot(person(5));
    let others = named.nodes.iter_mut().enumerate().skip(3);
    for (index, node) in others.filter(|(_, node)| !node.name.starts_with("Tail")) {
        node.name = format!("joint_{index}");
        named.animations[0].channels[index].node_name.clone_from(&node.name);
    }
    let words = refused(named, person(6));
    assert!(
        words.contains("joints of the source have the name of a joint of the target"),
        "{words}"
    );
}
