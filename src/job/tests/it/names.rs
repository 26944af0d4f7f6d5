//! Tests of joint names in outputs: `--names vrm|mixamo|...|FILE`. `fixtures/skeletons/truth.json` assigns joints to
//! bones, and the expected names are listed here.

use std::fs;

use mocap::figure::{BoneNames, Humanoid, HumanoidBone, HumanoidMap};
use mocap::job::Job;

use mocap::scene::NodeKind;
use mocap::scene::report::AppliedStep;
use mocap::verify::report::Verification;
use mocap::{Importer, Scene, SkeletonMesh};
use serde_json::{Value, json};

use crate::truth::truth;

/// The names of bones in Mixamo, Unreal, CMU, Godot and Unity, MHR and SOMA.
const SPELLED: [(&str, [&str; 6]); 14] = [
    ("hips", ["mixamorig:Hips", "pelvis", "Hips", "Hips", "root", "Hips"]),
    ("head", ["mixamorig:Head", "head", "Head", "Head", "c_head", "Head"]),
    (
        "leftUpperLeg",
        [
            "mixamorig:LeftUpLeg",
            "thigh_l",
            "LeftUpLeg",
            "LeftUpperLeg",
            "l_upleg",
            "LeftLeg",
        ],
    ),
    (
        "leftLowerLeg",
        [
            "mixamorig:LeftLeg",
            "calf_l",
            "LeftLeg",
            "LeftLowerLeg",
            "l_lowleg",
            "LeftShin",
        ],
    ),
    (
        "leftFoot",
        [
            "mixamorig:LeftFoot",
            "foot_l",
            "LeftFoot",
            "LeftFoot",
            "l_foot",
            "LeftFoot",
        ],
    ),
    (
        "rightUpperLeg",
        [
            "mixamorig:RightUpLeg",
            "thigh_r",
            "RightUpLeg",
            "RightUpperLeg",
            "r_upleg",
            "RightLeg",
        ],
    ),
    (
        "rightLowerLeg",
        [
            "mixamorig:RightLeg",
            "calf_r",
            "RightLeg",
            "RightLowerLeg",
            "r_lowleg",
            "RightShin",
        ],
    ),
    (
        "rightFoot",
        [
            "mixamorig:RightFoot",
            "foot_r",
            "RightFoot",
            "RightFoot",
            "r_foot",
            "RightFoot",
        ],
    ),
    (
        "leftShoulder",
        [
            "mixamorig:LeftShoulder",
            "clavicle_l",
            "LeftShoulder",
            "LeftShoulder",
            "l_clavicle",
            "LeftShoulder",
        ],
    ),
    (
        "leftUpperArm",
        [
            "mixamorig:LeftArm",
            "upperarm_l",
            "LeftArm",
            "LeftUpperArm",
            "l_uparm",
            "LeftArm",
        ],
    ),
    (
        "leftLowerArm",
        [
            "mixamorig:LeftForeArm",
            "lowerarm_l",
            "LeftForeArm",
            "LeftLowerArm",
            "l_lowarm",
            "LeftForeArm",
        ],
    ),
    (
        "leftHand",
        [
            "mixamorig:LeftHand",
            "hand_l",
            "LeftHand",
            "LeftHand",
            "l_wrist",
            "LeftHand",
        ],
    ),
    (
        "rightUpperArm",
        [
            "mixamorig:RightArm",
            "upperarm_r",
            "RightArm",
            "RightUpperArm",
            "r_uparm",
            "RightArm",
        ],
    ),
    (
        "rightHand",
        [
            "mixamorig:RightHand",
            "hand_r",
            "RightHand",
            "RightHand",
            "r_wrist",
            "RightHand",
        ],
    ),
];

/// The expected name of a bone.
fn spelled(names: BoneNames, bone: &str) -> Option<&str> {
    let (bone, others) = SPELLED.iter().find(|(known, _)| *known == bone)?;
    match names {
        BoneNames::Mixamo => Some(others[0]),
        BoneNames::Unreal => Some(others[1]),
        BoneNames::Cmu => Some(others[2]),
        BoneNames::Godot | BoneNames::Unity => Some(others[3]),
        BoneNames::Mhr => Some(others[4]),
        BoneNames::Soma => Some(others[5]),
        _ => Some(bone),
    }
}

/// The joints of a BVH file in order, read without the library.
fn joints_of_bvh(text: &str) -> Vec<&str> {
    let lines = text.lines().map(str::trim);
    let named = lines.filter_map(|line| line.strip_prefix("ROOT ").or_else(|| line.strip_prefix("JOINT ")));
    named.map(str::trim).collect()
}

const SOURCES: [&str; 4] = [
    "real/cmu_12_01_walk.bvh",
    "real/rokoko_dance.bvh",
    "skeletons/xsens_names_tpose.bvh",
    "skeletons/accad_run_turn.bvh",
];

fn job(source: &str, output: &std::path::Path, names: &Value) -> Job {
    let job = json!({
        "source": {"inputs": [source], "frames": {"trim": "0f..20f"}},
        "write": {"output": output, "names": names, "force": true},
        "verify": true,
    });
    Job::from_json(&job.to_string()).unwrap()
}

/// In every format, the joints of bones have their new names, and a reader finds the bones by these names.
#[test]
fn joints_have_their_names_in_every_format_and_are_found_again() {
    let truth = truth();
    let folder = tempfile::tempdir().unwrap();
    for source in SOURCES {
        let path = format!("../../fixtures/{source}");
        let text = fs::read_to_string(&path).unwrap();
        for names in BoneNames::ALL {
            // In this file, SOMA's name of the neck belongs to another joint, so the name is refused.
            if names == BoneNames::Soma && text.contains("JOINT Neck1") {
                continue;
            }
            let formats: &[&str] = match source {
                _ if source == SOURCES[1] => &["bvh", "glb", "fbx", "mclip", "vrma"],
                _ => &["bvh"],
            };
            for extension in formats {
                let output = folder.path().join(format!("out.{extension}"));
                let report = job(&path, &output, &json!(names.as_str())).run().unwrap();
                let context = format!("{source} {names:?} {extension}");
                assert_eq!(report.problem, None, "{context}");
                let asked_for = report.renamed.iter().filter(|renamed| renamed.is_asked_for);
                // Some files already have the names of CMU or SOMA, except for the spine and the thumbs.
                let is_known = matches!(names, BoneNames::Cmu | BoneNames::Soma);
                let least = if is_known { 0 } else { SPELLED.len() };
                assert!(asked_for.count() >= least, "{context}");
                let written = mocap::import(&output).unwrap();
                let found = Humanoid::of(&written);
                if names == BoneNames::Vrm {
                    let was = Humanoid::of(&mocap::import(&path).unwrap());
                    let bones = |of: &Humanoid| of.bones.keys().copied().collect::<Vec<_>>();
                    assert_eq!(bones(&found), bones(&was), "{context}");
                }
                for (bone, joint) in truth[source]["map"].as_object().unwrap() {
                    let Some(wanted) = spelled(names, bone) else { continue };
                    let joint_of = found.joint(HumanoidBone::from_name(bone).unwrap()).unwrap();
                    let name = &written.nodes[joint_of.index()].name;
                    assert_eq!(name, wanted, "{context}: {bone}, {joint} in the source");
                }
                if *extension == "bvh" {
                    let written = fs::read_to_string(&output).unwrap();
                    let pairs = joints_of_bvh(&text).into_iter().zip(joints_of_bvh(&written));
                    let pairs: Vec<_> = pairs.collect();
                    for (bone, joint) in truth[source]["map"].as_object().unwrap() {
                        let Some(wanted) = spelled(names, bone) else { continue };
                        let pair = pairs.iter().find(|(from, _)| Some(*from) == joint.as_str()).unwrap();
                        assert_eq!(pair.1, wanted, "{context}: {bone}");
                    }
                }
            }
        }
    }
}

/// A skeleton with the names of a program keeps all its names. The tables come from real files.
#[test]
fn tables_are_those_of_files() {
    let truth = truth();
    for (file, names, count) in [
        ("skeletons/human_game_engine.gltf", BoneNames::Unreal, 52),
        ("real/cmu_12_01_walk.bvh", BoneNames::Cmu, 22),
        ("real/cmu_short.bvh", BoneNames::Cmu, 22),
    ] {
        let mut same = 0;
        let entry = &truth[file];
        for (bone, joint) in entry["map"].as_object().unwrap() {
            let name = names.name_of(HumanoidBone::from_name(bone).unwrap());
            let accepted = entry["accept"].get(bone).and_then(Value::as_array);
            let is_accepted = accepted.is_some_and(|accepted| accepted.contains(&json!(name)));
            assert!(
                name.as_deref() == joint.as_str() || is_accepted,
                "{file}: {bone} {name:?}"
            );
            same += 1;
        }
        assert!(same >= count, "{file}: {same}");
    }
    for names in BoneNames::ALL {
        for (bone, _) in SPELLED {
            let name = names.name_of(HumanoidBone::from_name(bone).unwrap());
            assert_eq!(name.as_deref(), spelled(names, bone));
        }
    }
}

fn named(scene: &mut Scene, names: &Value) -> Result<mocap::figure::report::NamingReport, mocap::Error> {
    let names: HumanoidMap = serde_json::from_value(names.clone()).unwrap();
    let bones = Humanoid::of(scene);
    mocap::figure::name_joints(scene, &bones, &names)
}

/// Only names change. Meshes, channels and end sites follow; joints without a name stay unnamed.
#[test]
fn nothing_moves_and_all_that_has_the_name_follows() {
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::Skinned);
    let before = importer.import("../../fixtures/real/cmu_short.bvh").unwrap();
    let mut after = before.clone();
    let naming = named(&mut after, &json!({"head": "Kopf", "leftFoot": null})).unwrap();
    assert!(after.validate().is_empty());
    assert!(naming.unnamed.contains_key(&HumanoidBone::LeftFoot));
    assert!(naming.others.contains(&"LHipJoint".to_owned()));
    let mut renamed = Vec::new();
    for (node, was) in after.nodes.iter().zip(&before.nodes) {
        assert_eq!(node.transform, was.transform);
        if node.name != was.name {
            renamed.push((was.name.as_str(), node.name.as_str(), node.kind));
        }
    }
    let expected = [
        ("Head", "Kopf", NodeKind::Joint),
        ("EndSite_Head", "EndSite_Kopf", NodeKind::EndSite),
    ];
    assert_eq!(renamed, expected);
    assert_eq!(naming.renamed.len(), renamed.len());
    for (channel, was) in after.animations[0].channels.iter().zip(&before.animations[0].channels) {
        assert_eq!(channel.rotation_keys, was.rotation_keys);
        let name = if was.node_name == "Head" {
            "Kopf"
        } else {
            &was.node_name
        };
        assert_eq!(channel.node_name, name);
    }
    let bones = after.meshes.iter().flat_map(|mesh| &mesh.bones);
    assert!(bones.clone().any(|bone| bone.name == "Kopf") && bones.clone().all(|bone| bone.name != "Head"));
    let Some(AppliedStep::NameJoints { joints }) = after.metadata.steps.last() else {
        panic!("the step is not recorded: {:?}", after.metadata.steps);
    };
    assert_eq!(joints.len(), 2);
}

/// An impossible request is refused, and the scene stays unchanged.
#[test]
fn bad_names_are_refused_and_say_which() {
    let before = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    for (names, message) in [
        (
            json!({"hips": "A", "head": "A"}),
            "hips and head have the same name, \"A\"",
        ),
        (json!({"hips": " "}), "the name of hips is empty"),
        (
            json!({"hips": "a\nb"}),
            "the name of hips, \"a\\nb\", has a control character",
        ),
        (
            json!({"hips": "LHipJoint"}),
            "two joints would be called \"LHipJoint\": hips, and a joint that keeps its name",
        ),
        (
            json!({"hips": "Head", "head": null}),
            "two joints would be called \"Head\": hips, and a joint that keeps its name",
        ),
    ] {
        let mut scene = before.clone();
        let error = named(&mut scene, &names).unwrap_err();
        assert_eq!(error.diagnostic().message, message);
        assert!(scene == before);
    }
    let mut arm = mocap::import("../../fixtures/real/lecture_Test.bvh").unwrap();
    let error = named(&mut arm, &json!({"hips": "A"})).unwrap_err();
    assert_eq!(error.code().as_str(), "not-humanoid");
}

/// A joint that shares its name with another joint keeps its motion, and the other joint keeps its name.
#[test]
fn of_two_nodes_of_one_name_the_bone_is_renamed() {
    let mut scene = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    let bones = Humanoid::of(&scene);
    let head = bones.joint(HumanoidBone::Head).unwrap();
    // A helper joint before the head keeps its name.
    let other = scene.nodes.iter().position(|node| node.name == "LHipJoint").unwrap();
    for channel in &mut scene.animations[0].channels {
        if channel.node_name == "LHipJoint" {
            channel.node_name = "Head".to_owned();
        }
    }
    for bone in scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.bones) {
        if bone.node.index() == other {
            bone.name = "Head".to_owned();
        }
    }
    scene.nodes[other].name = "Head".to_owned();
    let source = scene.clone();
    mocap::figure::name_joints(&mut scene, &bones, &BoneNames::Mixamo.names()).unwrap();
    assert_eq!(scene.nodes[other].name, "Head");
    assert_eq!(scene.nodes[head.index()].name, "mixamorig:Head");
    assert!(scene.validate().is_empty());
    let glb = mocap::Exporter::new().write(&scene, mocap::Format::Gltf).unwrap();
    let verified = Verification::of(&source, &glb.into_bytes().unwrap()).unwrap();
    assert!(verified.is_within(1e-5), "{verified:?}");
}
