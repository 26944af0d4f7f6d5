//! The rest pose alone distinguishes animals from people in long clothes. No joint has the name of a bone.

use mocap::figure::{Creature, Humanoid, HumanoidBone};
use mocap::glam::{Quat, Vec3};

use crate::placed_joints::{Joint, scene};
use crate::up::{Posture, bvh, mirrored};

/// The joints of a cat by Quaternius (CC0), without IK controls.
pub(crate) const CAT: [Joint; 26] = [
    ("CatArmature", None, [0.0, 0.0, 0.0]),
    ("Bone", Some(0), [-1.3, 2.22, 0.0]),
    ("Bone.001", Some(1), [-0.4, 1.98, 0.0]),
    ("Bone.002", Some(2), [1.05, 2.0, 0.0]),
    ("Bone.003", Some(3), [2.02, 2.68, 0.0]),
    ("Bone.003_end", Some(4), [3.13, 2.53, 0.0]),
    ("Bone.014", Some(2), [1.11, 1.46, 0.4]),
    ("Bone.015", Some(6), [0.97, 0.56, 0.47]),
    ("Bone.016", Some(7), [0.48, 0.04, 0.48]),
    ("Bone.016_end", Some(8), [0.79, 0.0, 0.49]),
    ("Bone.017", Some(2), [1.12, 1.56, -0.4]),
    ("Bone.018", Some(10), [1.74, 0.92, -0.59]),
    ("Bone.019", Some(11), [1.64, 0.22, -0.47]),
    ("Bone.019_end", Some(12), [1.94, 0.16, -0.48]),
    ("Bone.004", Some(1), [-1.83, 2.4, 0.0]),
    ("Bone.005", Some(14), [-2.03, 2.85, 0.0]),
    ("Bone.006", Some(15), [-2.16, 3.39, 0.0]),
    ("Bone.007_end", Some(16), [-2.23, 4.33, 0.0]),
    ("Bone.008", Some(1), [-1.29, 1.52, -0.53]),
    ("Bone.009", Some(18), [-0.81, 0.78, -0.6]),
    ("Bone.010", Some(19), [-1.39, 0.04, -0.51]),
    ("Bone.010_end", Some(20), [-0.93, 0.02, -0.48]),
    ("Bone.011", Some(1), [-1.32, 1.66, 0.53]),
    ("Bone.012", Some(22), [-1.24, 0.79, 0.56]),
    ("Bone.013", Some(23), [-1.98, 0.22, 0.51]),
    ("Bone.013_end", Some(24), [-1.53, -0.02, 0.52]),
];

/// The positions of the joints of Quaternius' dog (CC0). The dog has the tree of the cat, and stands in a step.
pub(crate) const DOG: [[f32; 3]; 26] = [
    [0.2, 0.0, -0.31],
    [-1.37, 2.69, -0.31],
    [-0.28, 2.41, -0.31],
    [1.63, 2.35, -0.31],
    [2.41, 3.57, -0.31],
    [3.59, 3.47, -0.31],
    [1.54, 1.8, 0.48],
    [2.23, 0.87, 0.63],
    [2.41, 0.15, 0.58],
    [2.79, 0.13, 0.56],
    [1.54, 1.75, -1.19],
    [1.19, 0.65, -1.27],
    [0.66, 0.12, -1.28],
    [1.03, 0.07, -1.3],
    [-1.94, 2.94, -0.31],
    [-2.33, 2.71, -0.31],
    [-2.81, 2.79, -0.31],
    [-3.29, 3.49, -0.31],
    [-1.26, 2.11, -1.04],
    [-0.76, 1.23, -1.27],
    [-1.31, 0.45, -1.17],
    [-0.81, 0.18, -1.17],
    [-1.16, 1.85, 0.28],
    [-0.56, 1.01, 0.33],
    [-0.93, 0.12, 0.31],
    [-0.33, 0.21, 0.32],
];

/// Quaternius' llama (CC0). Its hind legs have the names of legs: the feet are children of the shins that end at them.
pub(crate) const LLAMA: [Joint; 27] = [
    ("Armature", None, [0.0, 0.0, 0.0]),
    ("root", Some(0), [0.0, 0.0, 0.0]),
    ("FrontFoot.R", Some(1), [-0.62, 0.08, 0.98]),
    ("Body", Some(1), [0.0, 1.79, -0.01]),
    ("FrontLeg.R", Some(3), [-0.22, 2.44, 0.93]),
    ("FrontUpLeg.R", Some(4), [-0.63, 2.44, 0.93]),
    ("FrontLowLeg.R", Some(5), [-0.63, 1.31, 1.11]),
    ("FrontLowLeg.R_end", Some(6), [-0.62, 0.08, 0.98]),
    ("BackLeg.R", Some(3), [-0.25, 2.44, -1.17]),
    ("BackUpLeg.R", Some(8), [-0.61, 2.44, -1.17]),
    ("BackLowLeg.R", Some(9), [-0.63, 1.37, -1.55]),
    ("BackLowLeg.R_end", Some(10), [-0.65, 0.08, -1.39]),
    ("FrontLeg.L", Some(3), [0.18, 2.44, 0.93]),
    ("FrontUpLeg.L", Some(12), [0.59, 2.44, 0.93]),
    ("FrontLowLeg.L", Some(13), [0.59, 1.31, 1.11]),
    ("FrontLowLeg.L_end", Some(14), [0.58, 0.08, 0.98]),
    ("BackLeg.L", Some(3), [0.21, 2.44, -1.17]),
    ("BackUpLeg.L", Some(16), [0.57, 2.44, -1.17]),
    ("BackLowLeg.L", Some(17), [0.59, 1.37, -1.55]),
    ("BackLowLeg.L_end", Some(18), [0.61, 0.08, -1.39]),
    ("Shoulders", Some(3), [-0.05, 3.2, 1.43]),
    ("Neck", Some(20), [-0.02, 4.1, 1.63]),
    ("Head", Some(21), [-0.02, 5.35, 1.89]),
    ("Head_end", Some(22), [-0.07, 4.83, 2.95]),
    ("BackFoot.R", Some(1), [-0.65, 0.08, -1.39]),
    ("FrontFoot.L", Some(1), [0.58, 0.08, 0.98]),
    ("BackFoot.L", Some(1), [0.61, 0.08, -1.39]),
];

/// A person in an I-pose, without names. The person wears a skirt and a cape that reach the ground.
pub(crate) const PERSON: [Joint; 28] = [
    ("J00", None, [0.0, 0.95, 0.0]),
    ("J01", Some(0), [0.0, 1.10, 0.0]),
    ("J02", Some(1), [0.0, 1.40, 0.0]),
    ("J03", Some(2), [0.0, 1.50, 0.0]),
    ("J04", Some(3), [0.0, 1.70, 0.0]),
    ("J05", Some(0), [0.1, 0.90, 0.0]),
    ("J06", Some(5), [0.1, 0.48, 0.01]),
    ("J07", Some(6), [0.1, 0.08, 0.0]),
    ("J08", Some(7), [0.1, 0.0, 0.14]),
    ("J09", Some(0), [-0.1, 0.90, 0.0]),
    ("J10", Some(9), [-0.1, 0.48, 0.01]),
    ("J11", Some(10), [-0.1, 0.08, 0.0]),
    ("J12", Some(11), [-0.1, 0.0, 0.14]),
    ("J13", Some(2), [0.17, 1.38, 0.0]),
    ("J14", Some(13), [0.2, 1.09, 0.0]),
    ("J15", Some(14), [0.21, 0.84, 0.02]),
    ("J16", Some(2), [-0.17, 1.38, 0.0]),
    ("J17", Some(16), [-0.2, 1.09, 0.0]),
    ("J18", Some(17), [-0.21, 0.84, 0.02]),
    ("Skirt0", Some(0), [0.15, 0.9, 0.1]),
    ("Skirt1", Some(19), [0.2, 0.5, 0.15]),
    ("Skirt2", Some(20), [0.2, 0.05, 0.15]),
    ("Skirt3", Some(0), [-0.15, 0.9, 0.1]),
    ("Skirt4", Some(22), [-0.2, 0.5, 0.15]),
    ("Skirt5", Some(23), [-0.2, 0.05, 0.15]),
    ("Cape0", Some(2), [0.1, 1.4, -0.1]),
    ("Cape1", Some(25), [0.1, 0.8, -0.2]),
    ("Cape2", Some(26), [0.1, 0.1, -0.2]),
];

#[test]
fn a_cat_and_a_dog_without_names_stand_on_four_legs() {
    let mut dog = CAT;
    for (joint, at) in dog.iter_mut().zip(DOG) {
        joint.2 = at;
    }
    for animal in [CAT, dog] {
        let found = Humanoid::of(&scene(&animal));
        assert_eq!(found.creature, Some(Creature::FourLegged), "{}", found.reason);
    }
}

/// A posture on straight legs and arms, with a level trunk.
fn on_four_legs(seconds: f32) -> Posture {
    let step = 0.2 * (4.0 * seconds).sin();
    let down = Vec3::new(0.0, -1.0, step);
    Posture {
        left: Vec3::X,
        trunk: Vec3::Z,
        head: Vec3::new(0.0, 0.5, 1.0),
        limbs: [
            mirrored(down),
            mirrored(down),
            mirrored(down),
            mirrored(down),
            mirrored(Vec3::new(0.0, -0.5, 1.0)),
        ],
        travel: 0.5 * seconds * Vec3::Z,
    }
}

/// A dog of Tencent's lifelike-agility-and-play (MIT). Its front legs have 0.78 of the length of its hind legs, its
/// bones lie along one axis at rest, and its joints have no names. If the ratio were 0.65, the front legs could be the
/// arms of a person.
#[test]
fn who_walks_on_four_legs_without_names_is_an_animal() {
    let body = bvh(on_four_legs, Quat::IDENTITY, 0.0);
    let mut text = String::new();
    for (number, line) in body.lines().enumerate() {
        match line.split_once(' ') {
            Some((kind @ ("ROOT" | "JOINT"), _)) => text += &format!("{kind} Bone.{number:03}\n"),
            _ => text += &format!("{line}\n"),
        }
    }
    let read = |text: &str| Humanoid::of(&mocap::Importer::new().read(text.as_bytes(), "dog.bvh").unwrap());
    let person = read(&text);
    assert_eq!(person.creature, None, "{}", person.reason);
    let dog = text
        .replace("OFFSET 0.43 0 0", "OFFSET 0.36 0 0")
        .replace("OFFSET 0.42 0 0", "OFFSET 0.36 0 0");
    let dog = read(&dog);
    assert_eq!(dog.creature, Some(Creature::FourLegged), "{}", dog.reason);
}

#[test]
fn a_llama_with_the_names_of_legs_stands_on_four_legs() {
    let found = Humanoid::of(&scene(&LLAMA));
    assert_eq!(found.creature, Some(Creature::FourLegged), "{}", found.reason);
}

#[test]
fn a_person_in_long_clothes_is_no_animal() {
    let found = Humanoid::of(&scene(&PERSON));
    assert!(found.found, "{}", found.reason);
    assert_eq!(found.missing(), []);
}

/// KayKit's mannequin (Kay Lousberg, CC0) in a T-pose. It has a large head, short legs and long feet.
#[test]
fn a_mannequin_with_short_legs_is_no_bird() {
    let side = |x: f32, first: usize| {
        let sign = x.signum();
        let names = match sign > 0.0 {
            true => [
                "upperarm.l",
                "lowerarm.l",
                "wrist.l",
                "hand.l",
                "upperleg.l",
                "lowerleg.l",
                "foot.l",
                "toes.l",
            ],
            false => [
                "upperarm.r",
                "lowerarm.r",
                "wrist.r",
                "hand.r",
                "upperleg.r",
                "lowerleg.r",
                "foot.r",
                "toes.r",
            ],
        };
        let at = [
            [0.21, 1.11, 0.0],
            [0.45, 1.11, -0.01],
            [0.71, 1.11, 0.0],
            [0.79, 1.11, 0.0],
            [0.17, 0.52, 0.0],
            [0.17, 0.29, 0.01],
            [0.17, 0.15, -0.02],
            [0.17, 0.03, 0.1],
        ];
        let parents = [3, first, first + 1, first + 2, 1, first + 4, first + 5, first + 6];
        let joints = names.into_iter().zip(parents).zip(at);
        joints.map(move |((name, parent), [x, y, z])| (name, Some(parent), [sign * x, y, z]))
    };
    let mut joints: Vec<Joint> = vec![
        ("root", None, [0.0; 3]),
        ("hips", Some(0), [0.0, 0.41, 0.0]),
        ("spine", Some(1), [0.0, 0.6, 0.0]),
        ("chest", Some(2), [0.0, 0.97, 0.0]),
        ("head", Some(3), [0.0, 1.24, 0.0]),
    ];
    joints.extend(side(1.0, 5));
    joints.extend(side(-1.0, 13));
    let scene = scene(&joints);
    let found = Humanoid::of(&scene);
    assert!(found.found, "{}", found.reason);
    let name = |bone: HumanoidBone| found.joint(bone).map(|joint| scene.nodes[joint.index()].name.as_str());
    assert_eq!(name(HumanoidBone::Chest), Some("chest"));
    assert_eq!(name(HumanoidBone::Head), Some("head"));
    assert_eq!(name(HumanoidBone::LeftHand), Some("wrist.l"));
    assert_eq!(name(HumanoidBone::RightToes), Some("toes.r"));
}
