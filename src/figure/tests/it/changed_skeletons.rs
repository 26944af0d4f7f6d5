//! Bones of skeletons to which other programs have added joints: joints without names, halves of bones, twist joints.
//! The skeletons and their bones come from `fixtures/skeletons/truth.json`.

use std::collections::BTreeMap;

use mocap::Scene;
use mocap::figure::{Confidence, Humanoid, HumanoidBone};
use mocap::glam::{Mat4, Vec3};
use mocap::scene::{Node, NodeId, NodeKind};
use serde_json::Value;

use crate::humanoid::import;
use crate::sample::Sample;
use crate::truth::truth;

/// A joint to insert between a node and its parent: its name, and its position as a fraction of the path from the
/// parent.
type InsertedJoint = (String, f32);

/// A copy of the scene's skeleton without the motion. Each node for which `insert` gives a joint has this joint as its
/// parent.
fn with_joints(scene: &Scene, insert: impl Fn(&Scene, usize) -> Option<InsertedJoint>) -> Scene {
    let mut made = Scene {
        metadata: scene.metadata.clone(),
        ..Scene::default()
    };
    let mut places = Vec::new();
    for (index, node) in scene.nodes.iter().enumerate() {
        let mut node = node.clone();
        node.parent = node.parent.map(|parent: NodeId| places[parent.index()]);
        if let Some((name, share)) = insert(scene, index) {
            let offset = node.transform.w_axis.truncate();
            made.nodes.push(Node {
                name,
                kind: NodeKind::Joint,
                parent: node.parent,
                transform: Mat4::from_translation(share * offset),
                ..Node::default()
            });
            node.parent = Some(NodeId::new(made.nodes.len() - 1));
            node.transform.w_axis = ((1.0 - share) * offset).extend(1.0);
        }
        places.push(NodeId::new(made.nodes.len()));
        made.nodes.push(node);
    }
    made
}

/// Rigify's rig has a joint `face` at the position of the head's joint, `spine.006`. It only holds the joints of the
/// face.
#[test]
fn a_joint_that_holds_the_face_is_not_the_head() {
    let scene = import("skeletons/blender_rigify_names.bvh");
    let scene = with_joints(&scene, |scene, index| {
        (scene.nodes[index].name == "face").then(|| ("spine.006".to_owned(), 1.0))
    });
    let head = Humanoid::of(&scene).joint(HumanoidBone::Head).unwrap();
    assert_eq!(scene.nodes[head.index()].name, "spine.006");
}

/// The number of right bones, the number of all bones, and the wrong bones with the confidence `Sure`.
fn compare(truth: &Value, scene: &Scene, renamed: &BTreeMap<String, String>) -> (usize, usize, Vec<String>) {
    let found = Humanoid::of(scene);
    let (mut right, mut all, mut sure) = (0, 0, Vec::new());
    for bone in HumanoidBone::ALL {
        let mapped = truth["map"].get(bone.as_str());
        let accepted = truth["accept"].get(bone.as_str()).and_then(Value::as_array);
        let joint = found.bones.get(bone);
        let name = joint.map(|joint| scene.nodes[joint.joint.index()].name.as_str());
        let name = name.map(|name| renamed.get(name).map_or(name, String::as_str));
        if mapped.is_none() && name.is_none() {
            continue;
        }
        all += 1;
        let is = |value: &Value| value.as_str() == name;
        if mapped.is_some_and(is) || accepted.is_some_and(|accepted| accepted.iter().any(is)) {
            right += 1;
        } else if joint.is_some_and(|joint| joint.confidence == Confidence::Sure) {
            sure.push(format!("{bone:?}: {name:?}, not {mapped:?}"));
        }
    }
    (right, all, sure)
}

/// Applies `change` to all humanoids. At least 99 of 100 bones must be right, and at most one bone may be sure and
/// wrong.
fn bones_stay(what: &str, change: impl Fn(&Value, Scene, &mut BTreeMap<String, String>) -> Scene) {
    let (mut right, mut all, mut sure) = (0, 0, Vec::new());
    for (file, truth) in truth() {
        if truth["humanoid"] == false {
            continue;
        }
        let mut scene = import(&file);
        // Stated bones are not searched for.
        scene.nodes.iter_mut().for_each(|node| node.humanoid_bone = None);
        scene.animations.clear();
        let mut renamed = BTreeMap::new();
        let changed = change(&truth, scene, &mut renamed);
        let (of_file, of_all, wrong) = compare(&truth, &changed, &renamed);
        right += of_file;
        all += of_all;
        sure.extend(wrong.into_iter().map(|words| format!("{file}: {words}")));
    }
    assert!(all > 1200, "{what}: {all}");
    assert!(right * 100 >= all * 99, "{what}: {right} of {all}");
    assert!(sure.len() <= 1, "{what}: {sure:?}");
}

/// The bone that the truth gives for a joint on either side, without the side.
fn bone_of(truth: &Value, name: &str) -> Option<String> {
    let (bone, _) = truth["map"].as_object()?.iter().find(|(_, joint)| **joint == name)?;
    Some(bone.trim_start_matches("left").trim_start_matches("right").to_owned())
}

/// Whether a node is the next bone of a limb. A joint that is inserted above such a node is within a bone.
fn ends_a_long_bone(truth: &Value, scene: &Scene, index: usize) -> bool {
    let node = &scene.nodes[index];
    let above = node.parent.map(|parent| scene.nodes[parent.index()].name.as_str());
    let Some(above) = above.and_then(|above| bone_of(truth, above)) else {
        return false;
    };
    let pair = (above, bone_of(truth, &node.name).unwrap_or_default());
    let next = [
        ("UpperArm", "LowerArm"),
        ("LowerArm", "Hand"),
        ("UpperLeg", "LowerLeg"),
        ("LowerLeg", "Foot"),
    ];
    next.contains(&(pair.0.as_str(), pair.1.as_str()))
}

/// FBX files of Mixamo as some programs write them: the tips are nodes without names.
#[test]
fn a_nameless_tip_is_no_bone() {
    bones_stay("tips", |_, mut scene, _| {
        for node in &mut scene.nodes {
            if node.kind == NodeKind::EndSite {
                node.kind = NodeKind::Joint;
                node.name.clear();
            }
        }
        scene
    });
}

/// A node without a name carries every joint.
#[test]
fn a_nameless_joint_that_carries_a_bone_is_not_that_bone() {
    bones_stay("carriers", |truth, scene, _| {
        with_joints(&scene, |scene, index| {
            let is_bone = bone_of(truth, &scene.nodes[index].name).is_some_and(|bone| bone != "hips");
            is_bone.then(|| (String::new(), 1.0))
        })
    });
}

/// Halves of bones, and twist joints, near the beginning and near the end of a bone. The test tries every second case.
#[test]
fn a_part_of_a_bone_is_not_the_bone() {
    let parts = [
        ("_split", 0.1),
        ("_split", 0.3),
        ("_split", 0.5),
        ("Twist", 0.5),
        ("Roll", 0.9),
        ("_twist_01", 0.7),
    ];
    for (suffix, share) in Sample::new().some(parts, 2) {
        bones_stay(suffix, |truth, scene, _| {
            with_joints(&scene, |scene, index| {
                let parent = scene.nodes[index].parent?;
                let name = format!("{}{suffix}", scene.nodes[parent.index()].name);
                ends_a_long_bone(truth, scene, index).then_some((name, share))
            })
        });
    }
}

/// Some programs call the ball of the foot a forefoot.
#[test]
fn a_forefoot_is_not_the_foot() {
    bones_stay("forefoot", |truth, mut scene, renamed| {
        for node in &mut scene.nodes {
            if bone_of(truth, &node.name).as_deref() != Some("Toes") {
                continue;
            }
            let side = mocap::figure::HumanoidBone::LeftToes.as_str();
            let is_left = truth["map"][side] == node.name.as_str();
            let name = if is_left { "LeftForeFoot" } else { "RightForeFoot" };
            renamed.insert(name.to_owned(), node.name.clone());
            node.name = name.to_owned();
        }
        scene
    });
}

/// The OFFSET of the hips is the place where a person stood, 4.5 m or more from the origin. In FBX, nodes above the
/// hips also place the figure.
#[test]
fn hips_far_from_the_root_are_those_of_a_body() {
    for above in [&["joint_Root"][..], &["joint_Root", "Armature", "RootNode"]] {
        bones_stay("far", |_, scene, _| {
            let lengths = scene
                .nodes
                .iter()
                .skip(1)
                .map(|node| node.transform.w_axis.truncate().length());
            let size: f32 = lengths.sum();
            let mut made = scene;
            for name in above {
                made = with_joints(&made, |_, index| (index == 0).then(|| ((*name).to_owned(), 0.0)));
            }
            made.nodes[above.len()].transform.w_axis += (Vec3::new(1.0, 2.0, 3.0) * size).extend(0.0);
            made
        });
    }
}
