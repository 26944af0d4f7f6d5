//! Front and hind, left and right of animals on four legs, inferred from the shape. Names are removed, and the world is
//! rotated.

use mocap::figure::report::Quadruped;
use mocap::figure::{Confidence, Creature, Figure};
use mocap::glam::{Mat4, Quat, Vec3};
use mocap::scene::{NodeId, Scene};
use mocap_figure::animal::LegGoal;

use crate::animals::{CAT, DOG, LLAMA, PERSON};
use crate::placed_joints::{Joint, scene};

/// The hip or shoulder and the paw of each leg, by the index of the joint: left and right in front, left and right
/// behind. +Y is up. The cat and the dog face +X, the llama faces +Z.
const LEGS_OF_CAT: [[usize; 2]; 4] = [[10, 12], [6, 8], [18, 20], [22, 24]];
const LEGS_OF_LLAMA: [[usize; 2]; 4] = [[13, 25], [5, 2], [17, 26], [9, 24]];

fn dog() -> [Joint; 26] {
    let mut dog = CAT;
    for (joint, at) in dog.iter_mut().zip(DOG) {
        joint.2 = at;
    }
    dog
}

fn read(file: &str) -> Scene {
    mocap::import(format!("../../fixtures/{file}")).unwrap()
}

fn found(scene: &Scene) -> Option<Quadruped> {
    Figure::new(scene).quadruped(scene).cloned()
}

fn legs(animal: &Quadruped) -> [[usize; 2]; 4] {
    animal
        .legs
        .each_ref()
        .map(|leg| [leg.upper, leg.paw].map(NodeId::index))
}

/// The joints of a scene with other names, in a rotated and scaled world.
fn changed(joints: &[Joint], rename: &dyn Fn(usize, &str) -> String, turn: Quat, scale: f32) -> Scene {
    let mut scene = scene(joints);
    for (index, node) in scene.nodes.iter_mut().enumerate() {
        node.name = rename(index, &node.name);
        let at = node.transform.w_axis.truncate();
        node.transform = Mat4::from_translation(turn * (scale * at));
    }
    scene
}

#[test]
fn front_and_hind_left_and_right_need_no_names() {
    let numbered = |index: usize, _: &str| format!("Bone.{index:03}");
    let as_it_is = |_: usize, name: &str| name.to_owned();
    let turns = [
        Quat::IDENTITY,
        Quat::from_rotation_y(1.2),
        // A world with +Z up.
        Quat::from_rotation_x(std::f32::consts::FRAC_PI_2),
        Quat::from_rotation_y(-2.0) * Quat::from_rotation_z(0.2),
    ];
    type Animal<'a> = (&'a str, &'a [Joint], [[usize; 2]; 4]);
    let animals: [Animal<'_>; 3] = [
        ("cat", &CAT, LEGS_OF_CAT),
        ("dog", &dog(), LEGS_OF_CAT),
        ("llama", &LLAMA, LEGS_OF_LLAMA),
    ];
    for (name, joints, expected) in animals {
        for turn in turns {
            for scale in [0.01, 1.0, 250.0] {
                for rename in [&numbered as &dyn Fn(usize, &str) -> String, &as_it_is] {
                    let scene = changed(joints, rename, turn, scale);
                    let animal = found(&scene).unwrap_or_else(|| panic!("{name} {turn} {scale}"));
                    let uppers = |legs: [[usize; 2]; 4]| legs.map(|[upper, _]| upper);
                    let reason = &animal.reason;
                    assert_eq!(
                        uppers(legs(&animal)),
                        uppers(expected),
                        "{name} {turn} {scale}: {reason}"
                    );
                    // Without names, the end of a leg is a joint like the others.
                    if scene.nodes[1].name != "Bone.001" {
                        assert_eq!(legs(&animal), expected, "{name} {turn} {scale}: {reason}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_mirrored_animal_without_names_has_its_sides_swapped() {
    let mut joints = CAT;
    for joint in &mut joints {
        joint.2[2] = -joint.2[2];
    }
    let [left_fore, right_fore, left_hind, right_hind] = LEGS_OF_CAT;
    assert_eq!(
        found(&scene(&joints)).map(|animal| legs(&animal)),
        Some([right_fore, left_fore, right_hind, left_hind])
    );
}

/// In a mirrored file, the names of the sides are wrong, and the report is no longer sure.
#[test]
fn names_of_the_other_sides_are_not_trusted() {
    let sure = found(&scene(&LLAMA)).unwrap();
    assert_eq!(sure.confidence, Confidence::Sure, "{}", sure.reason);
    let mut joints = LLAMA;
    for joint in &mut joints {
        joint.2[0] = -joint.2[0];
    }
    let mirrored = found(&scene(&joints)).unwrap();
    assert_eq!(mirrored.confidence, Confidence::Unsure);
    let [left_fore, right_fore, left_hind, right_hind] = LEGS_OF_LLAMA;
    assert_eq!(legs(&mirrored), [right_fore, left_fore, right_hind, left_hind]);
}

#[test]
fn trunk_head_and_tail_are_found() {
    let scene = scene(&CAT);
    let cat = found(&scene).unwrap();
    let name = |node: &NodeId| scene.nodes[node.index()].name.as_str();
    assert_eq!((name(&cat.pelvis), name(&cat.withers)), ("Bone", "Bone.001"));
    assert_eq!(cat.neck.iter().map(name).collect::<Vec<_>>(), ["Bone.002"]);
    assert_eq!(cat.head.as_ref().map(name), Some("Bone.003"));
    assert_eq!(cat.tail.first().map(name), Some("Bone.004"));
}

#[test]
fn a_person_has_no_four_legs() {
    assert_eq!(found(&scene(&PERSON)), None);
    let walk = read("real/cmu_12_01_walk.bvh");
    assert_eq!(found(&walk), None);
}

/// A Labrador whose bones lie along one axis at rest. It has the names of a person with a tail.
#[test]
fn a_dog_is_found_in_its_motion() {
    let scene = read("made/dog_walk.bvh");
    let figure = Figure::new(&scene);
    assert_eq!(figure.humanoid.creature, Some(Creature::FourLegged));
    let dog = figure.quadruped(&scene).unwrap();
    assert_eq!(dog.confidence, Confidence::Sure, "{}", dog.reason);
    let name = |node: NodeId| scene.nodes[node.index()].name.as_str();
    let parts = |index: usize| -> Vec<(&str, &str)> {
        let segments = dog.legs[index].segments().into_iter();
        segments.map(|(segment, joint)| (segment, name(joint))).collect()
    };
    assert_eq!(
        parts(0),
        [
            ("scapula", "b_LeftClav"),
            ("shoulder", "b_LeftArm"),
            ("elbow", "b_LeftForeArm"),
            ("wrist", "b_LeftHand"),
            ("paw", "b__LeftFinger"),
        ]
    );
    assert_eq!(
        parts(3),
        [
            ("hip", "b_RightLegUpper"),
            ("stifle", "b_RightLeg"),
            ("hock", "b_RightLeg1"),
            ("paw", "b_RightAnkle"),
        ]
    );
    assert_eq!((name(dog.pelvis), name(dog.withers)), ("b_Hips", "b_Spine3"));
    assert_eq!(dog.head.map(name), Some("b_Head"));
    assert_eq!(dog.tail.len(), 9);
}

/// The dog walks forward. Its travel and its toes show the front without names.
#[test]
fn a_walking_dog_needs_no_names() {
    let mut scene = read("made/dog_walk.bvh");
    let expected = Figure::new(&scene).quadruped(&scene).map(legs);
    for (index, node) in scene.nodes.iter_mut().enumerate() {
        node.name = format!("j{index}");
    }
    for channel in scene
        .animations
        .iter_mut()
        .flat_map(|animation| &mut animation.channels)
    {
        channel.node_name = channel
            .node
            .map_or_else(String::new, |node| format!("j{}", node.index()));
    }
    let figure = Figure::new(&scene);
    assert_eq!(
        figure.humanoid.creature,
        Some(Creature::FourLegged),
        "{}",
        figure.humanoid.reason
    );
    assert_eq!(figure.quadruped(&scene).map(legs), expected);
}

/// The stifles bend forward. The elbows and the hocks bend backward, in the mean of a captured walk.
#[test]
fn joints_of_a_walking_dog_bend_to_their_sides() {
    let scene = read("made/dog_walk.bvh");
    let dog = found(&scene).unwrap();
    let animation = &scene.animations[0];
    let binding = mocap::Binding::new(&scene, animation);
    let mut pose = mocap::Pose::rest(&scene);
    let mut bends = [[0.0; 2]; 4];
    for frame in 0..animation.frame_count() {
        pose.sample(&binding, animation, frame as f64);
        let tops = dog.legs.each_ref().map(|leg| pose.position(leg.upper));
        let forward = (tops[0] + tops[1] - tops[2] - tops[3]).with_y(0.0).normalize();
        for (leg, bends) in dog.legs.iter().zip(&mut bends) {
            let ankle = leg.ankle.unwrap();
            let joints = [[leg.upper, leg.lower, ankle], [leg.lower, ankle, leg.paw]];
            for (nodes, bend) in joints.into_iter().zip(bends) {
                // The distance of a joint in front of the line between its two neighbours.
                let [above, joint, below] = nodes.map(|node| pose.position(node));
                *bend += (joint - above).reject_from(below - above).dot(forward);
            }
        }
    }
    let [left_fore, right_fore, left_hind, right_hind] = bends;
    for [elbow, _] in [left_fore, right_fore] {
        assert!(elbow < 0.0, "{bends:?}");
    }
    for [stifle, hock] in [left_hind, right_hind] {
        assert!(stifle > 0.0 && hock < 0.0, "{bends:?}");
    }
}

/// A straight leg shows no side to which it bends.
#[test]
fn straight_legs_bend_to_the_sides_of_animals() {
    let mut scene = scene(&dog());
    let animal = found(&scene).unwrap();
    let rest = mocap::Pose::rest(&scene);
    for leg in &animal.legs {
        let end = leg.ankle.unwrap_or(leg.paw);
        let [upper, end_at] = [leg.upper, end].map(|node| rest.position(node));
        let middle = upper.midpoint(end_at);
        for (node, offset) in [(leg.lower, middle - upper), (end, end_at - middle)] {
            scene.nodes[node.index()].transform = Mat4::from_translation(offset);
        }
    }
    // The dog faces +X, with its left at -Z.
    let straight = mocap::Pose::rest(&scene);
    for leg in &animal.legs {
        let goal = LegGoal::new(&straight, leg, leg.ankle, -Vec3::Z);
        let mut pose = straight.clone();
        let [hip, paw] = [leg.upper, leg.paw].map(|node| pose.position(node));
        goal.reach(&mut pose, paw.lerp(hip, 0.2));
        let [knee, paw] = [leg.lower, leg.paw].map(|node| pose.position(node));
        let ahead = (knee - hip).reject_from(paw - hip).x;
        let length = hip.distance(paw);
        let bends = if leg.is_fore { -ahead } else { ahead };
        assert!(bends > 0.1 * length, "{}: {ahead} of {length}", leg.as_str());
    }
}
