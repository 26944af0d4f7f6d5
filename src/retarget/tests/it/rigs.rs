//! Rigs in which joints of the skin follow other joints than their parents. Only the skin shows whether the result is
//! right.

use glam::{Mat4, Vec3};
use mocap::figure::HumanoidMap;
use mocap::retarget::report::{RetargetReport, Verdict};
use mocap::retarget::{PoseRetargetOptions, PoseRetargeter, RetargetOptions, Retargeter};
use mocap::scene::{Animation, Channel, Keys, NodeId};
use mocap::{Binding, Importer, Pose, Scene};
use serde_json::{Value, json};

use crate::characters::{character, motion};

/// A GLB of the fixtures whose nodes a test changes.
struct Glb {
    json: Value,
    binary: Vec<u8>,
}

impl Glb {
    fn read(name: &str) -> Self {
        let bytes = std::fs::read(format!("../../fixtures/characters/{name}")).unwrap();
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        Self {
            json: serde_json::from_slice(&bytes[20..20 + length]).unwrap(),
            binary: bytes[20 + length..].to_vec(),
        }
    }

    fn scene(&self) -> Scene {
        let mut text = serde_json::to_vec(&self.json).unwrap();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend((20 + text.len() as u32 + self.binary.len() as u32).to_le_bytes());
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(b"JSON");
        bytes.extend(text);
        bytes.extend(&self.binary);
        Importer::new().gltf_meshes(true).read(&bytes, "rig.glb").unwrap()
    }

    fn nodes(&mut self) -> &mut Vec<Value> {
        self.json["nodes"].as_array_mut().unwrap()
    }

    fn find(&mut self, name: &str) -> usize {
        self.nodes().iter().position(|node| node["name"] == name).unwrap()
    }

    fn parent(&mut self, node: usize) -> Option<usize> {
        let has = |other: &Value| {
            other["children"]
                .as_array()
                .is_some_and(|all| all.contains(&json!(node)))
        };
        self.nodes().iter().position(has)
    }

    fn world(&mut self, node: usize) -> Mat4 {
        let above = self.parent(node).map_or(Mat4::IDENTITY, |parent| self.world(parent));
        let numbers = |key: &str, or: &[f32]| -> Vec<f32> {
            let values = self.json["nodes"][node][key].as_array();
            values.map_or(or.to_vec(), |all| {
                all.iter().map(|value| value.as_f64().unwrap() as f32).collect()
            })
        };
        let matrix = numbers("matrix", &[]);
        if let Ok(matrix) = <[f32; 16]>::try_from(matrix) {
            return above * Mat4::from_cols_array(&matrix);
        }
        let [x, y, z, w] = numbers("rotation", &[0.0, 0.0, 0.0, 1.0]).try_into().unwrap();
        above
            * Mat4::from_scale_rotation_translation(
                Vec3::from_slice(&numbers("scale", &[1.0; 3])),
                glam::Quat::from_xyzw(x, y, z, w),
                Vec3::from_slice(&numbers("translation", &[0.0; 3])),
            )
    }

    /// Gives a node another parent. The node keeps its position in the world.
    fn hang(&mut self, name: &str, parent: &str) {
        let (node, parent) = (self.find(name), self.find(parent));
        let local = self.world(parent).inverse() * self.world(node);
        if let Some(old) = self.parent(node) {
            let children = self.nodes()[old]["children"].as_array_mut().unwrap();
            children.retain(|child| *child != json!(node));
        }
        let nodes = self.nodes();
        let own = nodes[node].as_object_mut().unwrap();
        for key in ["translation", "rotation", "scale"] {
            own.remove(key);
        }
        own.insert("matrix".to_owned(), json!(local.to_cols_array()));
        match nodes[parent]["children"].as_array_mut() {
            Some(children) => children.push(json!(node)),
            None => nodes[parent]["children"] = json!([node]),
        }
    }

    /// Adds a joint without a skin at the position of another joint, as its parent. The children of the other joint
    /// become children of the new joint.
    fn add_control(&mut self, name: &str) {
        let node = self.find(name);
        let (parent, control) = (self.parent(node).unwrap(), self.nodes().len());
        let mut new = self.nodes()[node].clone();
        new["name"] = json!(format!("ctrl_{name}"));
        self.nodes()[node].as_object_mut().unwrap().remove("children");
        self.nodes().push(new);
        let children = self.nodes()[parent]["children"].as_array_mut().unwrap();
        children.push(json!(control));
    }
}

/// The increase in length of the most stretched edge over its length at rest, as a fraction of the skin's height.
fn stretch(scene: &Scene, animation: &Animation) -> f32 {
    let rest = Pose::rest(scene);
    let meshes: Vec<_> = scene.meshes.iter().filter(|mesh| !mesh.name.is_empty()).collect();
    let skins = |pose: &Pose| -> Vec<Vec<Vec3>> { meshes.iter().map(|mesh| pose.skin(mesh)).collect() };
    let at_rest = skins(&rest);
    let heights = || at_rest.iter().flatten().map(|vertex| vertex.y);
    let height = heights().fold(f32::MIN, f32::max) - heights().fold(f32::MAX, f32::min);
    let binding = Binding::new(scene, animation);
    let (mut pose, mut worst) = (rest, 0.0_f32);
    for tick in animation.whole_ticks().step_by(20) {
        pose.sample(&binding, animation, tick);
        for ((mesh, was), is) in meshes.iter().zip(&at_rest).zip(skins(&pose)) {
            for face in mesh.faces() {
                for (one, other) in [(face[0], face[1]), (face[1], face[2]), (face[2], face[0])] {
                    let (one, other) = (one as usize, other as usize);
                    worst = worst.max((is[one].distance(is[other]) - was[one].distance(was[other])) / height);
                }
            }
        }
    }
    worst
}

/// A walk on a character. Returns the stretch of its skin and the report. The poses come from a clip, and from single
/// calls as in a game.
fn walk(target: &Scene) -> (f32, RetargetReport) {
    let source = motion("real/cmu_12_01_walk.bvh");
    let mut retargeter = PoseRetargeter::new(&source, target, &PoseRetargetOptions::default()).unwrap();
    let (locked, report) = retargeter.clip(&source, 0, target, true).unwrap();
    let free = retargeter.animation(&source, &source.animations[0]);
    let (from, to) = (
        Binding::new(&source, &source.animations[0]),
        Binding::new(target, &free),
    );
    let (mut pose, mut live, mut clip) = (Pose::rest(&source), Pose::rest(target), Pose::rest(target));
    for tick in [1.0, 100.0, 333.0] {
        pose.sample(&from, &source.animations[0], tick);
        retargeter.pose(&pose, &mut live);
        clip.sample(&to, &free, tick);
        for (live, clip) in live.node_to_world.iter().zip(&clip.node_to_world) {
            assert!(live.abs_diff_eq(*clip, 1e-4), "{live} {clip}");
        }
    }
    (stretch(target, &locked), report)
}

#[track_caller]
fn check(target: &Scene, followers: &[(&str, &str)]) {
    let (stretch, report) = walk(target);
    let expected = followers
        .iter()
        .map(|(joint, other)| ((*joint).to_owned(), (*other).to_owned()));
    assert_eq!(report.followers, expected.collect());
    assert_eq!(report.verdict, Verdict::Good, "{report}");
    assert!(stretch < 0.03, "{stretch}");
    let skin = report.skin.unwrap();
    assert!(
        (skin.largest_stretch - f64::from(stretch)).abs() < 0.005,
        "{skin} {stretch}"
    );
    assert!(skin.below_floor < 0.01, "{skin}");
    assert!(skin.hands_inside < 0.02, "{skin}");
    assert_eq!(skin.uneven_joint, None);
}

#[test]
fn an_intact_rig_is_as_it_was() {
    check(&Glb::read("human_game_engine.glb").scene(), &[]);
}

#[test]
fn feet_that_hang_from_the_root_follow_the_shins() {
    let mut rig = Glb::read("human_game_engine.glb");
    for foot in ["foot_l", "foot_r"] {
        rig.hang(foot, "Root");
    }
    check(&rig.scene(), &[("foot_l", "calf_l"), ("foot_r", "calf_r")]);
    // Toes are separate too, and share vertices only with the feet.
    for toes in ["ball_l", "ball_r"] {
        rig.hang(toes, "Root");
    }
    let followers = [
        ("ball_l", "foot_l"),
        ("ball_r", "foot_r"),
        ("foot_l", "calf_l"),
        ("foot_r", "calf_r"),
    ];
    check(&rig.scene(), &followers);
}

#[test]
fn hands_and_a_head_that_hang_from_the_root_follow_their_limbs() {
    let mut rig = Glb::read("human_game_engine.glb");
    for part in ["hand_l", "hand_r", "head"] {
        rig.hang(part, "Root");
    }
    check(
        &rig.scene(),
        &[("hand_l", "lowerarm_l"), ("hand_r", "lowerarm_r"), ("head", "neck_01")],
    );
}

#[test]
fn a_spine_beside_the_controls_follows_them() {
    let mut rig = Glb::read("human_game_engine.glb");
    let spine = ["spine_01", "spine_02", "spine_03"];
    for joint in spine {
        rig.add_control(joint);
    }
    rig.hang("spine_02", "spine_01");
    rig.hang("spine_03", "spine_02");
    rig.hang("spine_01", "Root");
    let followers = spine.map(|joint| (joint, format!("ctrl_{joint}")));
    check(
        &rig.scene(),
        &followers.each_ref().map(|(joint, control)| (*joint, control.as_str())),
    );
}

#[test]
fn a_joint_that_stays_behind_is_not_good() {
    let mut rig = Glb::read("human_game_engine.glb");
    // Nothing shows that a hand follows another joint than its parent, so it keeps its weights and does not move.
    let source = motion("real/cmu_12_01_walk.bvh");
    rig.hang("hand_l", "Root");
    let target = rig.scene();
    let mut retargeter = PoseRetargeter::new(&source, &target, &PoseRetargetOptions::default()).unwrap();
    let (mut moved, report) = retargeter.clip(&source, 0, &target, false).unwrap();
    assert_eq!(report.verdict, Verdict::Good, "{report}");
    moved.channels.retain(|channel| channel.node_name != "hand_l");
    let report = retargeter.measure(&source, &source.animations[0], &target, &moved);
    assert!(stretch(&target, &moved) > 0.1);
    assert_eq!(report.verdict, Verdict::Poor, "{report}");
}

#[test]
fn a_joint_follows_what_a_map_says_before_what_the_skin_shows() {
    let mut rig = Glb::read("human_game_engine.glb");
    rig.hang("foot_l", "Root");
    let map: HumanoidMap = serde_json::from_str(r#"{"follow": {"foot_l": "rightLowerLeg"}}"#).unwrap();
    let options = RetargetOptions::new().target_bones(map);
    let retargeter = Retargeter::new(motion("real/cmu_short.bvh"), rig.scene(), options).unwrap();
    let report = retargeter.clips()[0].report.body().unwrap();
    assert_eq!(report.followers, [("foot_l".to_owned(), "calf_r".to_owned())].into());
    assert_eq!(report.verdict, Verdict::Poor, "{report}");
}

#[test]
fn a_hand_in_the_trunk_is_seen() {
    let mut rig = Glb::read("human_game_engine.glb");
    let target = rig.scene();
    let (hand, forearm, trunk) = (rig.find("hand_l"), rig.find("lowerarm_l"), rig.find("spine_02"));
    let in_trunk = rig.world(forearm).inverse() * rig.world(trunk);
    let at_rest = rig.world(forearm).inverse() * rig.world(hand);
    let node = target.nodes.iter().position(|node| node.name == "hand_l").unwrap();
    let moved = Animation {
        duration: 3.0,
        channels: vec![Channel {
            node_name: "hand_l".to_owned(),
            node: Some(NodeId::new(node)),
            rotation_keys: Keys::constant(glam::Quat::from_mat4(&at_rest)),
            scaling_keys: Keys::constant(Vec3::ONE),
            position_keys: Keys::every_tick(
                [at_rest, at_rest, in_trunk, in_trunk]
                    .map(|at| at.w_axis.truncate())
                    .to_vec(),
            ),
        }],
        ..Animation::default()
    };
    let source = motion("real/cmu_short.bvh");
    let mut short = source.animations[0].clone();
    short.duration = 3.0;
    let retargeter = PoseRetargeter::new(&source, &target, &PoseRetargetOptions::default()).unwrap();
    let skin = retargeter.measure(&source, &short, &target, &moved).skin.unwrap();
    assert_eq!((skin.hands_inside, skin.hands_tick), (0.5, Some(2.0)), "{skin}");
}

#[test]
fn an_uneven_scale_is_named_as_the_cause() {
    let source = motion("real/cmu_12_01_walk.bvh");
    for (joint, scale) in [("upperarm_l", [-1.0, 1.0, 1.0]), ("thigh_r", [1.0, 1.5, 1.0])] {
        let mut rig = Glb::read("human_game_engine.glb");
        let node = rig.find(joint);
        rig.nodes()[node]["scale"] = json!(scale);
        let target = rig.scene();
        let mut retargeter = PoseRetargeter::new(&source, &target, &PoseRetargetOptions::default()).unwrap();
        let (_, report) = retargeter.clip(&source, 0, &target, true).unwrap();
        assert_eq!(report.skin.as_ref().unwrap().uneven_joint.as_deref(), Some(joint));
        assert_ne!(report.verdict, Verdict::Good, "{report}");
        let cause = format!("the scale of {joint} at rest is mirrored or uneven");
        assert!(report.to_string().contains(&cause), "{report}");
    }
}

/// A figure of 5 m gets the same verdict as a figure of 1.6 m.
#[test]
fn feet_below_the_floor_are_judged_by_the_size_of_the_figure() {
    let small = Importer::new()
        .gltf_meshes(true)
        .import("../../fixtures/characters/human_game_engine.glb")
        .unwrap();
    let mut large = small.clone();
    large.nodes[0].transform = Mat4::from_scale(Vec3::splat(3.0)) * large.nodes[0].transform;
    let [small, large] = [small, large].map(|target| {
        let options = RetargetOptions::new().lock_feet(false);
        let retargeting = Retargeter::new(motion("real/cmu_12_01_walk.bvh"), target, options).unwrap();
        retargeting.clips()[0].report.body().unwrap().clone()
    });
    let (small_feet, large_feet) = (small.feet.unwrap().target, large.feet.unwrap().target);
    assert!(
        (large_feet.deepest / small_feet.deepest - 3.0).abs() < 0.01,
        "{large_feet:?}"
    );
    let [one, other] = [small_feet, large_feet].map(|feet| feet.fraction_below_floor);
    assert!((one - other).abs() < 0.01 && one < 0.9, "{one} and {other}");
    assert_eq!(small.verdict, large.verdict);
}

/// Legs that are lifted out of the floor have other directions. This is no reason to leave the feet in the floor if
/// both verdicts are poor.
#[test]
fn locked_feet_are_better_than_feet_in_the_floor() {
    let options = RetargetOptions::new().lock_feet(false);
    let source = motion("real/cmu_12_01_walk.bvh");
    let retargeting = Retargeter::new(source, character("human_default"), options).unwrap();
    let free = retargeting.clips()[0].report.body().unwrap();
    let feet = free.feet.unwrap();
    let below = |fraction_below_floor: f64, verdict: Verdict| {
        let mut report = free.clone();
        let mut feet = feet;
        feet.target.fraction_below_floor = fraction_below_floor;
        (report.feet, report.verdict) = (Some(feet), verdict);
        report
    };
    let locked = below(0.0, Verdict::Poor);
    assert!(locked.is_better_locked_than(&below(1.0, Verdict::Poor)));
    assert!(!locked.is_better_locked_than(&below(1.0, Verdict::Fair)));
    assert!(!below(1.0, Verdict::Poor).is_better_locked_than(&below(0.0, Verdict::Poor)));
}
