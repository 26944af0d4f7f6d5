//! Tests whether the report of palms is right. The reference is the plane of a hand in the world, relative to the hips,
//! and shares no code with the program.

use mocap::glam::{Mat3, Vec3};
use mocap::retarget::report::Aspect;
use mocap::retarget::{RetargetOptions, Retargeter};
use mocap::scene::NodeId;
use mocap::{Importer, Pose, Scene};

/// The names of a skeleton's joints: thighs, hands, and the first joints of index, middle and little finger, left and
/// right.
struct Names {
    thighs: [&'static str; 2],
    hands: [[&'static str; 4]; 2],
}

const ROKOKO: Names = Names {
    thighs: ["LeftUpLeg", "RightUpLeg"],
    hands: [
        ["LeftHand", "LeftHandIndex1", "LeftHandMiddle1", "LeftHandPinky1"],
        ["RightHand", "RightHandIndex1", "RightHandMiddle1", "RightHandPinky1"],
    ],
};

const MAKEHUMAN: Names = Names {
    thighs: ["upperleg01.L", "upperleg01.R"],
    hands: [
        ["wrist.L", "finger2-1.L", "finger3-1.L", "finger5-1.L"],
        ["wrist.R", "finger2-1.R", "finger3-1.R", "finger5-1.R"],
    ],
};

const JAPANESE: Names = Names {
    thighs: ["左足", "右足"],
    hands: [
        ["左手首", "左人指１", "左中指１", "左小指１"],
        ["右手首", "右人指１", "右中指１", "右小指１"],
    ],
};

/// The direction of the back of a hand, in right, up and back of the hips. Two lines determine it: along the hand, and
/// from the little finger to the index finger.
fn back_of_hand(scene: &Scene, pose: &Pose, names: &Names, side: usize) -> Vec3 {
    let at = |name: &str| {
        let node = scene.nodes.iter().position(|node| node.name == name).unwrap();
        pose.position(NodeId::new(node))
    };
    let [left, right] = names.thighs.map(at);
    let across = Vec3::new(right.x - left.x, 0.0, right.z - left.z).normalize();
    let axes = Mat3::from_cols(across, Vec3::Y, across.cross(Vec3::Y));
    let [hand, index, middle, little] = names.hands[side].map(at);
    let way = (middle - hand).cross(index - little).normalize();
    let sign = if side == 0 { -1.0 } else { 1.0 };
    axes.transpose() * (sign * way)
}

/// The mean angle between the backs of the hands on two bodies, in degrees, left and right.
fn apart(source: (&Scene, &Names), target: (&Scene, &Names)) -> [f32; 2] {
    let frames = source.0.animations[0].frame_count();
    [0, 1].map(|side| {
        let angles = (0..frames).map(|frame| {
            let see = |(scene, names): (&Scene, &Names)| {
                let pose = Pose::at_tick(scene, 0, frame as f64).unwrap();
                back_of_hand(scene, &pose, names, side)
            };
            see(source).angle_between(see(target)).to_degrees()
        });
        angles.sum::<f32>() / frames as f32
    })
}

/// A character's palms have the directions of the source's palms. This includes `human_vrm0.vrm`, whose palms face up
/// at rest, with twisted forearms. The report agrees within 5 degrees.
#[test]
fn palms_are_as_far_off_as_the_report_says() {
    for (file, names) in [("human_default.glb", &MAKEHUMAN), ("human_vrm0.vrm", &JAPANESE)] {
        let importer = Importer::new().gltf_meshes(true);
        let character = importer
            .import_character(format!("../../fixtures/characters/{file}"))
            .unwrap();
        let source = mocap::import("../../fixtures/real/rokoko_dance.bvh").unwrap();
        let done = Retargeter::new(source, character, RetargetOptions::new()).unwrap();
        let (from, to) = (done.sources().next().unwrap().scene(), done.scene());
        let angles = apart((from, &ROKOKO), (&to, names));
        let report = done.clips()[0].report.body().unwrap();
        for (side, bone) in ["leftHand", "rightHand"].into_iter().enumerate() {
            let palm = |seen: &&mocap::retarget::report::AspectError| {
                seen.aspect == Aspect::Palm && seen.bone.as_str() == bone
            };
            let said = report.seen.iter().find(palm).unwrap().mean_degrees as f32;
            assert!(
                (said - angles[side]).abs() < 5.0,
                "{file} {bone}: {said}, and {}",
                angles[side]
            );
        }
        let rests_on_its_palms = |side: usize| back_of_hand(&to, &Pose::rest(&to), names, side).y > 0.0;
        for side in [0, 1] {
            assert_eq!(rests_on_its_palms(side), file == "human_default.glb", "{file}");
            assert!(angles[side] < 20.0, "{file}: {angles:?}");
        }
    }
}

/// If the joints of a finger are numbered from 1 to 4, the first is the knuckle, in long and in short hands. Joints 1,
/// 2 and 3 are its bones, and joint 4 is the tip, as in Mixamo.
#[test]
fn numbered_joints_of_fingers_begin_at_the_knuckle_in_hands_of_every_length() {
    use mocap::figure::{Humanoid, HumanoidBone as Bone};
    let text = std::fs::read_to_string("../../fixtures/skeletons/snu_character1_boxes.bvh").unwrap();
    for length in [0.65_f32, 0.75, 0.85, 1.0, 1.2] {
        let mut lines: Vec<String> = text.lines().map(ToOwned::to_owned).collect();
        for at in 0..lines.len() {
            let is_knuckle = lines[at].contains("JOINT") && lines[at].contains("Hand") && lines[at].ends_with('1');
            let offset = &lines[(at + 2).min(text.lines().count() - 1)];
            if is_knuckle && !lines[at].contains("Thumb") {
                let numbers = offset.split_whitespace().skip(1);
                let numbers = numbers.map(|number| (length * number.parse::<f32>().unwrap()).to_string());
                lines[at + 2] = format!("OFFSET {}", Vec::from_iter(numbers).join(" "));
            }
        }
        let scene = mocap::Importer::new()
            .read(lines.join("\n").as_bytes(), "a.bvh")
            .unwrap();
        let found = Humanoid::of(&scene);
        for (bone, name) in [
            (Bone::LeftIndexProximal, "LeftHandIndex1"),
            (Bone::LeftMiddleIntermediate, "LeftHandMiddle2"),
            (Bone::LeftRingProximal, "LeftHandRing1"),
            (Bone::RightRingDistal, "RightHandRing3"),
            (Bone::RightLittleProximal, "RightHandPinky1"),
            (Bone::LeftLittleDistal, "LeftHandPinky3"),
        ] {
            let joint = found.joint(bone).map(|joint| scene.nodes[joint.index()].name.as_str());
            let joint = joint.unwrap_or_default();
            assert!(joint.ends_with(name), "hands of {length}: {bone:?} is {joint}");
        }
    }
}
