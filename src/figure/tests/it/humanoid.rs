//! The bones of joints, compared with `fixtures/skeletons/truth.json`, which was made by hand.

use std::collections::BTreeMap;
use std::fs;

use mocap::figure::report::TPoseSource;
use mocap::figure::report::{RestPose, Sides};
use mocap::figure::{Confidence, Figure, Humanoid, HumanoidBone};
use mocap::glam::Vec3;
use mocap::scene::{Animation, Keys, Node, NodeId, NodeKind, RootOffset};
use mocap::{Importer, Pose, Scene};
use serde_json::Value;

use crate::truth::truth;

/// Reads a file of the truth. If its motion is refused, reads only the skeleton.
pub(crate) fn import(file: &str) -> Scene {
    let path = format!("../../fixtures/{file}");
    match mocap::import(&path) {
        Ok(scene) => scene,
        Err(_) => {
            let bytes = fs::read(&path).unwrap();
            let end = bytes.windows(6).position(|word| word == b"MOTION").unwrap();
            Importer::new().read(&bytes[..end], &path).unwrap()
        }
    }
}

/// The found bones, by the names of the joints.
fn names(scene: &Scene, found: &Humanoid) -> BTreeMap<HumanoidBone, String> {
    let name = |node: NodeId| scene.nodes[node.index()].name.clone();
    found
        .bones
        .iter()
        .map(|(bone, joint)| (*bone, name(joint.joint)))
        .collect()
}

/// The number of right bones, the number of all bones, and the wrong bones as text.
#[derive(Default)]
struct Score {
    right: usize,
    all: usize,
    wrong: Vec<(HumanoidBone, String)>,
}

/// Compares the found bones with the truth about a file. `accept` lists joints that are as right as the joints of
/// `map`.
fn compare(truth: &Value, found: &BTreeMap<HumanoidBone, String>) -> Score {
    let mut score = Score::default();
    for &bone in HumanoidBone::ALL {
        let mapped = truth["map"].get(bone.as_str());
        let accepted = truth["accept"].get(bone.as_str()).and_then(Value::as_array);
        let found = found.get(&bone);
        if mapped.is_none() && found.is_none() {
            continue;
        }
        let is = |value: &Value| value.as_str() == found.map(String::as_str);
        score.all += 1;
        if mapped.is_some_and(is) || accepted.is_some_and(|accepted| accepted.iter().any(is)) {
            score.right += 1;
        } else {
            score.wrong.push((bone, format!("{bone:?}: {found:?}, not {mapped:?}")));
        }
    }
    score
}

#[test]
fn the_bones_of_real_files_are_those_that_people_see() {
    let mut sum = Score::default();
    for (file, truth) in truth() {
        let scene = import(&file);
        let found = Humanoid::of(&scene);
        if truth["humanoid"] == false {
            assert!(!found.found && found.bones.is_empty(), "{file}: {}", found.reason);
            continue;
        }
        assert!(found.found, "{file}: {}", found.reason);
        let score = compare(&truth, &names(&scene, &found));
        for (bone, words) in &score.wrong {
            println!("{file}: {words}");
            let confidence = found.bones.get(bone).map(|joint| joint.confidence);
            assert_ne!(confidence, Some(Confidence::Sure), "{file}: {words}");
        }
        sum.right += score.right;
        sum.all += score.all;
    }
    assert!(sum.all > 1200, "{}", sum.all);
    assert!(
        sum.right * 100 >= sum.all * 98,
        "{} of {} are right",
        sum.right,
        sum.all
    );
}

/// The explanation of an assignment has the scores that chose the assignment. The rows sum to their part, the parts sum
/// to the whole, and the second assignment scores less.
#[test]
fn an_explanation_adds_up() {
    let is_near = |a: f32, b: f32| (a - b).abs() < 1e-3;
    let mut explained = 0;
    for (file, truth) in truth() {
        if truth["humanoid"] == false {
            continue;
        }
        let scene = import(&file);
        let Some(explanation) = Humanoid::explain(&scene) else {
            assert!(scene.nodes.iter().any(|node| node.humanoid_bone.is_some()), "{file}");
            continue;
        };
        for part in &explanation.parts {
            let sum: f32 = part.evidence.iter().map(|row| row.log_likelihood).sum();
            assert!(
                is_near(sum, part.log_likelihood),
                "{file}: {}: {sum}, not {}",
                part.part,
                part.log_likelihood
            );
            if let Some((joints, second)) = &part.second {
                assert!(
                    joints != &part.joints && *second <= part.log_likelihood,
                    "{file}: {}",
                    part.part
                );
            }
        }
        let sum: f32 = explanation.parts.iter().map(|part| part.log_likelihood).sum();
        assert!(
            is_near(sum, explanation.log_likelihood),
            "{file}: {sum}, not {}",
            explanation.log_likelihood
        );
        explained += 1;
    }
    assert!(explained > 20, "{explained}");
}

/// Renames each joint to a number, in channels too.
fn number_the_joints(scene: &mut Scene) {
    for (index, node) in scene.nodes.iter_mut().enumerate() {
        node.name = format!("J{index}");
    }
}

#[test]
fn the_bones_of_characters_are_found_without_names() {
    let mut sum = Score::default();
    for (file, truth) in truth() {
        if !file.contains("/human_") {
            continue;
        }
        let scene = import(&file);
        let mut numbered = scene.clone();
        number_the_joints(&mut numbered);
        let score = compare(&truth, &names(&scene, &Humanoid::of(&numbered)));
        assert!(score.right * 100 >= score.all * 90, "{file}: {:?}", score.wrong);
        sum.right += score.right;
        sum.all += score.all;
    }
    assert!(sum.all > 250, "{}", sum.all);
}

/// The left and right of joint names agree with the left and right of the body and its motion, or the result says so.
#[test]
fn the_sides_are_those_of_the_body() {
    for (file, truth) in truth() {
        if truth["humanoid"] == false {
            continue;
        }
        let expected = match truth["sides"]["names"].as_str() {
            Some("agree") | None => Sides::Agree,
            Some("opposite") => Sides::Opposite,
            _ => Sides::Unknown,
        };
        let found = Humanoid::of(&import(&file));
        assert_eq!(found.sides, expected, "{file}: {}", found.sides_reason);
    }
}

/// The positions of the bones agree with the statements of the characters' maker.
#[test]
fn the_characters_stand_where_their_maker_put_them() {
    let mut compared = 0;
    for (file, truth) in truth() {
        let Some(places) = truth["rest_world_positions_m"].as_object() else {
            continue;
        };
        let scene = import(&file);
        let rest = Pose::rest(&scene);
        for (bone, place) in places {
            let name = truth["map"][bone].as_str().unwrap();
            let node = scene.nodes.iter().position(|node| node.name == name).unwrap();
            let place: Vec3 = serde_json::from_value(place.clone()).unwrap();
            let found = rest.position(NodeId::new(node));
            assert!(found.distance(place) < 2e-5, "{file}: {bone} at {found}, not {place}");
            compared += 1;
        }
    }
    assert!(compared > 100);
}

/// A skeleton of nodes, each given as depth, name and offset.
fn skeleton(nodes: &[(usize, &str, [f32; 3])]) -> Scene {
    let mut scene = Scene::default();
    let mut open: Vec<NodeId> = Vec::new();
    for &(depth, name, offset) in nodes {
        open.truncate(depth);
        scene.nodes.push(Node {
            name: name.to_owned(),
            kind: NodeKind::Joint,
            parent: open.last().copied(),
            transform: mocap::glam::Mat4::from_translation(offset.into()),
            ..Node::default()
        });
        open.push(NodeId::new(scene.nodes.len() - 1));
    }
    scene
}

/// A dog with the names of a human body, as the dogs of a well-known dataset have.
#[test]
fn a_dog_is_refused_although_its_joints_have_human_names() {
    let mut nodes = vec![(0, "Hips", [0.0, 0.5, 0.0])];
    for (name, x) in [("Left", 0.08), ("Right", -0.08)] {
        let names = [
            format!("{name}UpLeg"),
            format!("{name}Leg"),
            format!("{name}Foot"),
            format!("{name}Toe"),
        ];
        let offsets = [
            [x, -0.02, 0.0],
            [0.0, -0.2, 0.02],
            [0.0, -0.2, -0.03],
            [0.0, -0.06, 0.04],
        ];
        for (depth, (name, offset)) in names.into_iter().zip(offsets).enumerate() {
            nodes.push((depth + 1, String::leak(name), offset));
        }
    }
    nodes.extend([(1, "Spine", [0.0, 0.02, 0.2]), (2, "Spine1", [0.0, 0.0, 0.2])]);
    for (name, x) in [("Left", 0.08), ("Right", -0.08)] {
        let names = [
            format!("{name}Shoulder"),
            format!("{name}Arm"),
            format!("{name}ForeArm"),
            format!("{name}Hand"),
        ];
        let offsets = [[x, 0.0, 0.1], [0.0, -0.1, 0.02], [0.0, -0.19, 0.0], [0.0, -0.18, 0.0]];
        for (depth, (name, offset)) in names.into_iter().zip(offsets).enumerate() {
            nodes.push((depth + 3, String::leak(name), offset));
        }
    }
    nodes.extend([
        (3, "Neck", [0.0, 0.08, 0.15]),
        (4, "Head", [0.0, 0.1, 0.1]),
        (1, "Tail", [0.0, 0.0, -0.1]),
    ]);
    let found = Humanoid::of(&skeleton(&nodes));
    assert!(!found.found);
    assert!(found.reason.contains("four legs"), "{}", found.reason);
}

/// A pelvis with two legs, as solved from the markers of a gait laboratory.
#[test]
fn a_lower_body_that_names_its_bones_is_found() {
    let legs = |names: [&'static str; 4]| {
        let mut nodes = vec![(0, "hips", [0.0, 0.95, 0.0])];
        for (side, x) in [("left", 0.09), ("right", -0.09)] {
            let offsets = [[x, 0.0, 0.0], [0.0, -0.42, 0.0], [0.0, -0.42, 0.0], [0.0, -0.06, 0.13]];
            for (depth, (name, offset)) in std::iter::zip(names, offsets).enumerate() {
                nodes.push((depth + 1, &*String::leak(format!("{side}{name}")), offset));
            }
        }
        nodes
    };
    let named = legs(["UpperLeg", "LowerLeg", "Foot", "Toes"]);
    let found = Humanoid::of(&skeleton(&named));
    assert!(found.found, "{}", found.reason);
    assert!(found.reason.contains("no joints above the pelvis"), "{}", found.reason);
    assert_eq!(found.bones.len(), 9);
    assert_eq!(found.sides, Sides::Agree);
    let is_sure = |joint: &mocap::figure::report::HumanoidJoint| joint.confidence == Confidence::Sure;
    assert!(found.bones.values().all(is_sure), "{:?}", found.bones);
    // Names without a meaning may be the legs of a table.
    assert!(!Humanoid::of(&skeleton(&legs(["A", "B", "C", "D"]))).found);
    // Without feet, and with other joints above the pelvis, the skeleton lacks a part.
    let footless: Vec<_> = named.iter().copied().filter(|(depth, ..)| *depth < 3).collect();
    assert!(!Humanoid::of(&skeleton(&footless)).found);
    let mut more = named;
    more.extend([(1, "column", [0.0, 0.3, 0.0]), (2, "plate", [0.0, 0.3, 0.0])]);
    assert!(!Humanoid::of(&skeleton(&more)).found);
}

#[test]
fn what_is_no_body_is_refused_with_the_reason() {
    let nothing = Humanoid::of(&Scene::default());
    assert_eq!((nothing.found, nothing.reason.as_str()), (false, "there are no joints"));
    assert_eq!(nothing.missing().len(), HumanoidBone::REQUIRED.len());

    let markers = Humanoid::of(&import("real/optotrak.c3d"));
    assert!(markers.reason.contains("markers"), "{}", markers.reason);

    // Hundreds of chains on one joint, such as hair, a rope or a cloth.
    let mut nodes = vec![(0, "root", [0.0; 3])];
    for _ in 0..300 {
        nodes.extend([
            (1, "a", [1.0, 0.0, 0.0]),
            (2, "b", [1.0, 0.0, 0.0]),
            (3, "c", [1.0, 0.0, 0.0]),
        ]);
    }
    assert!(!Humanoid::of(&skeleton(&nodes)).found);
}

/// Positions that are not finite, and nodes at one position, do not stop the search.
#[test]
fn broken_lengths_are_survived() {
    let scene = import("real/cmu_short.bvh");
    for broken in [f32::NAN, f32::INFINITY, 0.0, 1e30, -1e-30] {
        let mut scene = scene.clone();
        for node in &mut scene.nodes {
            node.transform.w_axis.x = broken;
        }
        scene.animations.push(Animation::default());
        for channel in scene
            .animations
            .iter_mut()
            .flat_map(|animation| &mut animation.channels)
        {
            channel.position_keys = Keys::constant(Vec3::splat(broken));
        }
        let _ = Humanoid::of(&scene);
    }
}

/// The unit, the up axis, the facing and the rest pose of every file of the truth.
#[test]
fn units_and_axes_are_right() {
    let axis = |value: &Value| {
        value
            .as_str()
            .map_or("unknown".to_owned(), |axis| axis.trim_start_matches('+').to_lowercase())
    };
    for (file, truth) in truth() {
        if truth["humanoid"] == false {
            continue;
        }
        let scene = import(&file);
        let found = Figure::new(&scene);
        assert_eq!(
            found.up.value.as_str(),
            axis(&truth["up"]),
            "{file}: {}",
            found.up.reason
        );
        assert_eq!(
            found.facing.value.as_str(),
            axis(&truth["facing_rest"]),
            "{file}: {}",
            found.facing.reason
        );
        let pose = truth["rest_pose"].as_str().unwrap();
        let expected = match pose {
            _ if pose.starts_with("T-pose") => RestPose::TPose,
            _ if pose.starts_with("A-pose") => RestPose::APose,
            _ if pose.starts_with("I-pose") => RestPose::IPose,
            "collapsed" => RestPose::Collapsed,
            _ => RestPose::Other,
        };
        assert_eq!(found.rest_pose.value, expected, "{file}: {}", found.rest_pose.reason);
        if let (Some(used), Some(words)) = (&scene.metadata.root_offset, truth["root_offset"].as_str()) {
            let is_added = used.policy == RootOffset::Add;
            assert_eq!(is_added, words.starts_with("add"), "{file}: {}", used.reason);
        }
        if scene.metadata.metres_per_unit.is_some() {
            continue;
        }
        let metres = found.survey.unit.value.metres();
        match truth["unit_confidence"].as_str() {
            Some("sure" | "likely") => {
                let expected = truth["unit_m"].as_f64().unwrap();
                assert!(
                    (metres / expected - 1.0).abs() < 1e-6,
                    "{file}: {metres}, not {expected}"
                );
            }
            _ => {
                let range: [f64; 2] = serde_json::from_value(truth["unit_range_m"].clone()).unwrap();
                assert!((range[0]..=range[1]).contains(&metres), "{file}: {metres}");
            }
        }
    }
}

/// The unit depends on the bones, so no kind of pose changes it.
#[test]
fn clips_of_one_skeleton_have_one_unit() {
    for file in [
        "real/cmu_12_01_walk.bvh",
        "real/rokoko_dance.bvh",
        "skeletons/bvhtoolbox_walk01.bvh",
    ] {
        let scene = import(file);
        let unit = Figure::new(&scene).survey.unit;
        for angle in [-2.4_f32, 0.9, 2.0] {
            let mut posed = scene.clone();
            for channel in posed
                .animations
                .iter_mut()
                .flat_map(|animation| &mut animation.channels)
            {
                for rotation in &mut channel.rotation_keys.values {
                    *rotation *= mocap::glam::Quat::from_rotation_x(angle);
                }
            }
            assert_eq!(Figure::new(&posed).survey.unit, unit, "{file}");
        }
        let mut still = scene.clone();
        still.animations.clear();
        assert_eq!(Figure::new(&still).survey.unit, unit, "{file}");
    }
}

/// In the T-pose of every file, arms point sideways, legs point down, and every bone keeps its length.
#[test]
fn the_t_pose_is_one() {
    let mut turned = 0;
    for (file, truth) in truth() {
        let scene = import(&file);
        let figure = Figure::new(&scene);
        let Some(found) = figure.t_pose(&scene) else {
            assert_eq!(truth["humanoid"], false, "{file}");
            continue;
        };
        turned += usize::from(found.largest_rotation() > 15.0);
        let at = |bone| figure.humanoid.joint(bone).map(|joint| found.pose.position(joint));
        let up = figure.up.value.direction().unwrap();
        let way = |from, to| Some((at(to)? - at(from)?).normalize());
        // A trunk keeps the curve of the rest pose, or else the mean curve of the motion.
        let trunk = 0.35;
        let hips = way(HumanoidBone::RightUpperLeg, HumanoidBone::LeftUpperLeg).unwrap();
        // Without arms, only the legs of a figure show its sides.
        let arm = way(HumanoidBone::LeftUpperArm, HumanoidBone::LeftLowerArm);
        let left = arm.map_or(hips, |arm| arm.reject_from_normalized(up).normalize());
        // Both hip joints of animics_all_along_z have one position. The joints between hips and thighs separate the
        // thighs.
        assert!(
            !hips.is_finite() || left.dot(hips) > 0.95,
            "{file}: arms along {left}, hips along {hips}"
        );
        for (from, to, expected, tolerance) in [
            (HumanoidBone::LeftUpperLeg, HumanoidBone::LeftFoot, -up, 1e-3),
            (HumanoidBone::RightUpperLeg, HumanoidBone::RightFoot, -up, 1e-3),
            (HumanoidBone::LeftUpperArm, HumanoidBone::LeftLowerArm, left, 1e-3),
            (HumanoidBone::RightUpperArm, HumanoidBone::RightLowerArm, -left, 1e-3),
            (HumanoidBone::Spine, HumanoidBone::Head, up, trunk),
        ] {
            if let Some(way) = way(from, to) {
                let angle = way.angle_between(expected);
                assert!(
                    angle < tolerance,
                    "{file}: {from:?} is {angle} off ({:?})",
                    found.source
                );
            }
        }
        let rest = Pose::rest(&scene);
        for (index, node) in scene.nodes.iter().enumerate() {
            let Some(parent) = node.parent else { continue };
            let length = |pose: &Pose| pose.position(NodeId::new(index)).distance(pose.position(parent));
            if found.source != TPoseSource::FirstFrame {
                let (was, is) = (length(&rest), length(&found.pose));
                assert!(
                    (was - is).abs() <= 1e-3 * was.max(1e-3),
                    "{file}: {} was {was}, is {is}",
                    node.name
                );
            }
        }
    }
    assert!(turned >= 10, "{turned}");
}

/// The rotations of a T-pose, applied from the hips outwards, bring the rest pose to the T-pose.
#[test]
fn the_rotations_bring_the_rest_pose_into_t_pose() {
    let scene = import("real/rokoko_dance.bvh");
    let figure = Figure::new(&scene);
    let found = figure.t_pose(&scene).unwrap();
    let mut places: Vec<Vec3> = {
        let rest = Pose::rest(&scene);
        (0..scene.nodes.len())
            .map(|node| rest.position(NodeId::new(node)))
            .collect()
    };
    for (bone, turned) in &found.bones {
        let joint = figure.humanoid.joint(*bone).unwrap();
        let about = places[joint.index()];
        for (index, place) in places.iter_mut().enumerate() {
            let parent = |node: &NodeId| scene.nodes[node.index()].parent;
            let mut above = std::iter::successors(Some(NodeId::new(index)), parent);
            if above.any(|node| node == joint) {
                *place = about + turned.rotation * (*place - about);
            }
        }
    }
    for (index, place) in places.iter().enumerate() {
        let expected = found.pose.position(NodeId::new(index));
        assert!(
            place.distance(expected) < 0.01,
            "{}: {place} and {expected}",
            scene.nodes[index].name
        );
    }
}

/// The floor and the sides that follow from the bones.
#[test]
fn feet_are_on_the_floor_and_sides_alike() {
    let scene = import("real/cmu_01_01.bvh");
    let found = Figure::new(&scene);
    // The floor of CMU's laboratory. The ball of a foot is 1 to 8 cm above it, in CMU's units.
    let floor = found.ground(&scene).unwrap();
    assert_eq!(floor.value, 0.0);
    let balls = found.ground_of(&scene).unwrap().balls.unwrap();
    assert!((0.2..1.4).contains(&balls), "{balls}");
    assert!(found.asymmetry.unwrap().value < 0.05);
    let scene = import("real/latin1_name_no_motion.bvh");
    let still = Figure::new(&scene);
    assert!(still.ground(&scene).is_none() && still.asymmetry.is_some());
}

/// A joint that a map names is only this bone. An earlier version gave the joint two bones, and the T-pose panicked.
#[test]
fn a_joint_of_a_map_is_one_bone() {
    let scene = import("real/cmu_12_01_walk.bvh");
    let map = |bones: &[(HumanoidBone, &str)]| {
        let bones = bones.iter().map(|(bone, name)| (*bone, Some((*name).to_owned())));
        Humanoid::of(&scene).with_map(&scene, bones.collect())
    };
    let found = names(&scene, &Humanoid::of(&scene));
    assert_eq!(found[&HumanoidBone::Neck], "Neck");
    let mapped = map(&[(HumanoidBone::Head, "Neck")]).unwrap();
    let bones = names(&scene, &mapped);
    assert_eq!(bones[&HumanoidBone::Head], "Neck");
    assert!(!bones.contains_key(&HumanoidBone::Neck));
    assert!(Figure::with_bones(&scene, mapped).t_pose(&scene).is_some());
    // Both bones may move to other joints. The old joint of a named bone no longer counts as this bone.
    let mapped = map(&[(HumanoidBone::Neck, "Spine1"), (HumanoidBone::Head, "Neck")]).unwrap();
    let bones = names(&scene, &mapped);
    assert_eq!(
        [&bones[&HumanoidBone::Neck], &bones[&HumanoidBone::Head]],
        ["Spine1", "Neck"]
    );
    assert!(Figure::with_bones(&scene, mapped).t_pose(&scene).is_some());
    let error = map(&[(HumanoidBone::Neck, "Neck"), (HumanoidBone::Head, "Neck")]).unwrap_err();
    let message = "the map names \"Neck\" as neck and as head: a joint can be only one bone";
    assert_eq!(error.diagnostic().message, message);
}
