//! Maps of bones: joints that follow other joints, and figures that are refused without a map.

use mocap::Scene;
use mocap::figure::{Creature, Humanoid, HumanoidBone as Bone, HumanoidMap};
use mocap::scene::NodeId;

use crate::placed_joints::{Joint, scene};

/// Joints with their parents and positions: a person with a tail, whose joint names have no meaning.
const FIGURE: [Joint; 23] = [
    ("J00", None, [0.0, 0.0, 0.0]),
    ("J01", Some(0), [0.0, 0.50, 0.0]),
    ("J02", Some(1), [0.0, 0.70, 0.0]),
    ("J03", Some(2), [0.0, 1.10, 0.0]),
    ("J04", Some(3), [0.0, 1.30, 0.0]),
    ("J05", Some(4), [0.0, 1.50, 0.0]),
    ("J06", Some(1), [0.1, 0.50, 0.0]),
    ("J07", Some(6), [0.1, 0.27, 0.0]),
    ("J08", Some(7), [0.1, 0.05, 0.0]),
    ("J09", Some(8), [0.1, 0.00, 0.1]),
    ("J10", Some(1), [-0.1, 0.50, 0.0]),
    ("J11", Some(10), [-0.1, 0.27, 0.0]),
    ("J12", Some(11), [-0.1, 0.05, 0.0]),
    ("J13", Some(12), [-0.1, 0.00, 0.1]),
    ("J14", Some(3), [0.2, 1.10, 0.0]),
    ("J15", Some(14), [0.36, 1.10, 0.0]),
    ("J16", Some(15), [0.48, 1.10, 0.0]),
    ("J17", Some(3), [-0.2, 1.10, 0.0]),
    ("J18", Some(17), [-0.36, 1.10, 0.0]),
    ("J19", Some(18), [-0.48, 1.10, 0.0]),
    ("Tail1", Some(1), [0.0, 0.50, -0.1]),
    ("Tail2", Some(20), [0.0, 0.50, -0.2]),
    ("Tail3", Some(21), [0.0, 0.50, -0.3]),
];

fn map(json: &str) -> HumanoidMap {
    serde_json::from_str(json).unwrap()
}

#[track_caller]
fn refusal(scene: &Scene, json: &str) -> (String, Option<String>) {
    let error = Humanoid::of(scene).with_map(scene, map(json)).unwrap_err();
    let diagnostic = error.diagnostic();
    (diagnostic.message.clone(), diagnostic.help.clone())
}

#[test]
fn a_partial_map_finds_the_other_bones_of_a_figure_that_is_refused() {
    let scene = scene(&FIGURE);
    let found = Humanoid::of(&scene);
    assert_eq!(found.creature, Some(Creature::Tailed), "{}", found.reason);
    let partial = map(r#"{"hips": "J01", "leftUpperLeg": "J06", "rightUpperLeg": "J10", "head": "J05"}"#);
    let found = found.with_map(&scene, partial).unwrap();
    assert!(found.found, "{}", found.reason);
    assert_eq!(found.missing(), [], "{:?}", found.bones);
    let joint = |bone| scene.nodes[found.joint(bone).unwrap().index()].name.as_str();
    assert_eq!(joint(Bone::LeftLowerLeg), "J07");
    assert_eq!(joint(Bone::RightFoot), "J12");
    assert_eq!(joint(Bone::LeftHand), "J16");
}

#[test]
fn a_map_that_is_not_enough_says_what_it_leaves_out() {
    let mut scene = scene(&FIGURE);
    scene.nodes.truncate(14);
    let found = Humanoid::of(&scene)
        .with_map(&scene, map(r#"{"leftUpperArm": "J05"}"#))
        .unwrap();
    assert!(!found.found);
    assert!(found.reason.contains("the map leaves out"), "{}", found.reason);
    assert!(found.reason.contains("leftHand"), "{}", found.reason);
}

#[test]
fn joints_follow_what_a_map_says() {
    let mut joints = FIGURE;
    // The feet are children of the root, far from every other joint, so nothing shows which joints they follow.
    for (foot, toes, x) in [(8, 9, 0.1), (12, 13, -0.1)] {
        joints[foot] = (joints[foot].0, Some(0), [x, 0.02, 0.3]);
        joints[toes].2 = [x, 0.0, 0.4];
    }
    let scene = scene(&joints);
    let json = r#"{"leftUpperLeg": "J06", "rightUpperLeg": "J10", "head": "J05",
        "follow": {"J08": "leftLowerLeg", "J12": "J11"}, "leftLowerLeg": "J07"}"#;
    let found = Humanoid::of(&scene).with_map(&scene, map(json)).unwrap();
    let follow = [(8, 7), (12, 11)].map(|(joint, other)| (NodeId::new(joint), NodeId::new(other)));
    assert_eq!(found.follow, follow.into());
    assert_eq!(found.joint(Bone::LeftFoot), Some(NodeId::new(8)));
    assert_eq!(found.joint(Bone::RightFoot), Some(NodeId::new(12)));
}

#[test]
fn a_map_that_cannot_be_followed_is_refused() {
    let scene = scene(&FIGURE);
    let hangs = |what: &str| (format!("the map lets {what}"), None);
    assert_eq!(
        refusal(&scene, r#"{"follow": {"J01": "J05"}}"#),
        hangs(r#""J01" follow "J05", which is "J01" or below it"#)
    );
    assert_eq!(
        refusal(&scene, r#"{"follow": {"J14": "J17", "J17": "J15"}}"#),
        hangs(r#""J17" follow "J15", which is "J17" or below it"#)
    );
    assert_eq!(
        refusal(&scene, r#"{"follow": {"J5": "J16"}}"#).0,
        r#"no joint is called "J5", which the map lets follow "J16""#
    );
    assert_eq!(
        refusal(&scene, r#"{"follow": {"J14": "leftHand"}}"#).0,
        r#"no joint is called "leftHand", which "J14" follows in the map"#
    );
}

#[test]
fn a_name_that_no_joint_has_is_answered_with_the_nearest() {
    let mut scene = scene(&FIGURE);
    "rig|mixamorig:LeftFoot".clone_into(&mut scene.nodes[8].name);
    let help = |name: &str| refusal(&scene, &format!(r#"{{"leftFoot": "{name}"}}"#)).1;
    let near = Some(r#"did you mean "rig|mixamorig:LeftFoot"?"#.to_owned());
    assert_eq!(help("leftfoot"), near);
    assert_eq!(help("Armature|LeftFoot"), near);
    assert_eq!(help("Hat"), None);
}
