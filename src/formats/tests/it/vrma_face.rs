//! The face of a VRM animation: expressions and the gaze, in files, through steps, and on characters.

use mocap::edit::{EditStep, Mirror};
use mocap::glam::{EulerRot, Quat, Vec3};
use mocap::gltf::GltfOptions;
use mocap::job::{Maker, MotionJob};
use mocap::retarget::{RetargetOptions, Retargeter, apply_steps};
use mocap::scene::report::{DataKind, DataLoss};
use mocap::scene::{Face, HumanoidBone, NodeId, NodeKind};
use mocap::verify::report::FindingKind;
use mocap::verify::report::Verification;
use mocap::vrma::VrmaOptions;
use mocap::{Code, Importer, Scene};
use serde_json::{Value, json};

/// The time of the motion's last key in seconds. The motion has 75 frames at 120 frames per second.
const END: f64 = 74.0 / 120.0;

/// Weights at the start, at a quarter, at half and at the end, as the script that made the file wrote them.
const WEIGHTS: [(&str, [f32; 4]); 6] = [
    ("blink", [0.0, 1.0, 0.0, 0.0]),
    ("happy", [0.0, 0.25, 0.5, 1.0]),
    ("aa", [1.0, 0.0, 1.0, 0.5]),
    ("blinkLeft", [0.0, 0.0, 0.0, 1.0]),
    ("wink", [0.125, 0.5, 0.75, 0.0]),
    ("sad", [0.5; 4]),
];

/// Yaw and pitch of the gaze in degrees, at the times of [`WEIGHTS`].
const GAZE: [[f32; 2]; 4] = [[0.0, 0.0], [20.0, 0.0], [-30.0, 10.0], [0.0, -10.0]];

fn fixture() -> Scene {
    mocap::import("../../fixtures/made/face.vrma").unwrap()
}

fn written(scene: &Scene) -> Vec<u8> {
    VrmaOptions::default().write(scene).unwrap().0
}

fn read(bytes: &[u8]) -> Scene {
    Importer::new().read(bytes, "a.vrma").unwrap()
}

fn node(scene: &Scene, name: &str) -> usize {
    let is_it = |face: &Face| face.name() == name;
    let found = scene
        .nodes
        .iter()
        .position(|node| node.face.as_ref().is_some_and(is_it));
    found.unwrap_or_else(|| panic!("no node is {name}"))
}

/// The translation and the rotation of a part of the face, at the fraction `share` of the first motion's duration.
fn at(scene: &Scene, name: &str, share: f64) -> (Vec3, Quat) {
    let index = node(scene, name);
    let motion = &scene.animations[0];
    let rest = mocap::Trs::from_matrix(scene.nodes[index].transform);
    let channel = motion
        .channels
        .iter()
        .find(|channel| channel.node == Some(NodeId::new(index)));
    let now = channel.map_or(rest, |channel| channel.sample(share * motion.duration, rest));
    (now.translation, now.rotation)
}

fn expect_whole(scene: &Scene) {
    for (name, weights) in WEIGHTS {
        for (share, weight) in [0.0, 0.25, 0.5, 1.0].into_iter().zip(weights) {
            assert!((at(scene, name, share).0.x - weight).abs() < 1e-5, "{name} at {share}");
        }
    }
    for (share, [yaw, pitch]) in [0.0, 0.25, 0.5, 1.0].into_iter().zip(GAZE) {
        let expected = Quat::from_euler(EulerRot::YXZ, yaw.to_radians(), pitch.to_radians(), 0.0);
        assert!(
            at(scene, "lookAt", share).1.angle_between(expected) < 1e-3,
            "gaze at {share}"
        );
    }
}

#[test]
fn a_face_is_read_and_written_again() {
    let scene = fixture();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert!((scene.animations[0].duration / scene.animations[0].ticks_per_second - END).abs() < 1e-4);
    expect_whole(&scene);
    assert!(
        scene
            .nodes
            .iter()
            .all(|node| node.face.is_none() || node.kind == NodeKind::Group)
    );
    let bytes = written(&scene);
    let again = read(&bytes);
    expect_whole(&again);
    assert_eq!(again.validate(), []);
    let faces = |scene: &Scene| -> Vec<Face> { scene.nodes.iter().filter_map(|node| node.face.clone()).collect() };
    assert_eq!(faces(&scene), faces(&again));
    assert!(faces(&again).contains(&Face::LookAt {
        offset_from_head: Some(Vec3::new(0.0, 0.0625, 0.0))
    }));
    assert!(faces(&again).contains(&Face::Custom("wink".to_owned())));
    // A node of the face is a root beside the body.
    let file: Value = serde_json::from_slice(&gltf::Glb::from_slice(&bytes).unwrap().json).unwrap();
    let extension = &file["extensions"]["VRMC_vrm_animation"];
    assert_eq!(extension["expressions"]["preset"].as_object().unwrap().len(), 5);
    let happy = &extension["expressions"]["preset"]["happy"]["node"];
    assert!(file["scenes"][0]["nodes"].as_array().unwrap().contains(happy));
}

#[test]
fn another_unit_and_the_way_back_change_no_weight() {
    let mut scene = fixture();
    scene.convert_units(100.0, mocap::scene::UpAxis::Y);
    assert_eq!(at(&scene, "happy", 1.0).0.x, 1.0);
}

#[test]
fn what_a_face_must_not_have_is_left_out_with_a_warning() {
    let scene = fixture();
    let bytes = written(&scene);
    let mut glb = gltf::Glb::from_slice(&bytes).unwrap();
    let mut file: Value = serde_json::from_slice(&glb.json).unwrap();
    let extension = &mut file["extensions"]["VRMC_vrm_animation"];
    let hips = extension["humanoid"]["humanBones"]["hips"]["node"].clone();
    let happy = extension["expressions"]["preset"]["happy"]["node"].clone();
    extension["expressions"]["preset"]["lookUp"] = json!({ "node": happy });
    extension["expressions"]["custom"]["a grin"] = json!({ "node": hips });
    extension["expressions"]["custom"]["a smile"] = json!({ "node": happy });
    extension["expressions"]["custom"]["nowhere"] = json!({ "node": 999 });
    glb.json = serde_json::to_vec(&file).unwrap().into();
    let found = read(&glb.to_vec().unwrap()).warnings;
    assert!(found.iter().all(|warning| warning.code == Code::IgnoredChannel));
    let messages: Vec<_> = found.iter().map(|warning| warning.message.as_str()).collect();
    let expected = [
        "the expression lookUp was dropped: a VRM animation stores the gaze in lookAt, not in expressions",
        "the expression a grin was dropped: its node is the bone hips",
        "the expression a smile was dropped: its node already belongs to happy",
        "the expression nowhere was dropped: its node is not in the scene",
    ];
    assert_eq!(messages, expected);
}

#[test]
fn steps_take_the_face_along() {
    let mut scene = fixture();
    let trim: EditStep = "trim:range=0..0.25".parse().unwrap();
    apply_steps(&mut scene, &[trim], &[], None).unwrap();
    let share = 0.25 / END;
    assert!((at(&read(&written(&scene)), "happy", 1.0).0.x - share as f32).abs() < 0.01);

    let mut scene = fixture();
    let before = scene.clone();
    apply_steps(&mut scene, &[Mirror::new().into()], &[], None).unwrap();
    // The face has no right eye to exchange.
    assert_eq!(at(&scene, "blinkRight", 1.0).0.x, 1.0);
    assert_eq!(at(&scene, "happy", 0.5).0, at(&before, "happy", 0.5).0);
    let (yaw, pitch, _) = at(&scene, "lookAt", 0.5).1.to_euler(EulerRot::YXZ);
    assert!((yaw.to_degrees() - 30.0).abs() < 0.1 && (pitch.to_degrees() - 10.0).abs() < 0.1);
    apply_steps(&mut scene, &[Mirror::new().into()], &[], None).unwrap();
    expect_whole(&scene);
}

#[test]
fn verify_sees_what_a_face_lacks_and_what_is_another() {
    let source = fixture();
    let check = |bytes: &[u8]| Verification::of(&source, bytes).unwrap();
    let bytes = written(&fixture());
    let good = check(&bytes);
    assert!(good.max_error < 1e-5 && good.findings.is_empty(), "{:?}", good.findings);
    let mut glb = gltf::Glb::from_slice(&bytes).unwrap();
    let whole: Value = serde_json::from_slice(&glb.json).unwrap();
    let mut file = whole.clone();
    let preset = file["extensions"]["VRMC_vrm_animation"]["expressions"]["preset"]
        .as_object_mut()
        .unwrap();
    preset.remove("happy").unwrap();
    glb.json = serde_json::to_vec(&file).unwrap().into();
    let lacks = check(&glb.to_vec().unwrap());
    assert_eq!(lacks.findings[0].kind, FindingKind::Face);
    assert_eq!(
        lacks.findings[0].message,
        "the expression happy of the motion is not in the file"
    );
    let mut file = whole;
    let preset = &mut file["extensions"]["VRMC_vrm_animation"]["expressions"]["preset"];
    let (happy, aa) = (preset["happy"].clone(), preset["aa"].clone());
    (preset["happy"], preset["aa"]) = (aa, happy);
    glb.json = serde_json::to_vec(&file).unwrap().into();
    let exchanged = check(&glb.to_vec().unwrap());
    assert!((exchanged.max_error - 1.0).abs() < 0.01, "{}", exchanged.max_error);
}

/// The values of a channel of the last animation of a `.glb`, as 32-bit floats.
fn values(bytes: &[u8], node: &str, path: &str) -> Vec<f32> {
    let glb = gltf::Glb::from_slice(bytes).unwrap();
    let file: Value = serde_json::from_slice(&glb.json).unwrap();
    let animation = file["animations"].as_array().unwrap().last().unwrap();
    let is_it = |channel: &&Value| {
        let target = &channel["target"];
        target["path"] == path && file["nodes"][target["node"].as_u64().unwrap() as usize]["name"] == node
    };
    let channel = animation["channels"].as_array().unwrap().iter().find(is_it);
    let sampler = &animation["samplers"][channel.unwrap()["sampler"].as_u64().unwrap() as usize];
    let accessor = &file["accessors"][sampler["output"].as_u64().unwrap() as usize];
    let view = &file["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    let number = |value: &Value| value.as_u64().unwrap_or(0) as usize;
    let start = number(&view["byteOffset"]) + number(&accessor["byteOffset"]);
    let components = if accessor["type"] == "VEC4" { 4 } else { 1 };
    let bin = glb.bin.unwrap();
    let floats = bin[start..start + 4 * components * number(&accessor["count"])].chunks_exact(4);
    floats
        .map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap()))
        .collect()
}

fn retargeted(output: &str) -> mocap::Export {
    let job = json!({
        "source": { "inputs": ["../../fixtures/made/face.vrma"] },
        "target": { "character": { "file": "../../fixtures/characters/human_vrm0.vrm" } },
        "write": { "output": output },
    });
    let job: MotionJob = serde_json::from_value(job).unwrap();
    let maker = Maker::new(&job, &[], &mut |_| {}).unwrap();
    maker
        .make(&job.source.inputs, &job.write.output, &mut |_| {})
        .unwrap()
        .written
}

/// The character has one morph target for `aa` and one for `blink`.
#[test]
fn a_character_moves_the_morph_targets_of_its_expressions() {
    let written = retargeted("hero.vrm");
    let notes = written.notes.join("\n");
    assert!(
        notes.contains("expressions that the character lacks, dropped: happy, "),
        "{notes}"
    );
    // Each expression that the character lacks is a lost curve.
    assert_eq!(written.losses, [DataLoss::new(DataKind::FaceCurves, 4)]);
    let bytes = written.into_bytes().unwrap();
    let weights = values(&bytes, "Body", "weights");
    // The first frame is a rest pose and is dropped, so all events are one frame earlier.
    let (first, last) = (1.0 / (0.25 * 74.0), [0.0, 1.0, 1.0, 0.0, 0.5, 0.0]);
    assert!(
        (weights[0] - (1.0 - first)).abs() < 1e-3 && (weights[1] - first).abs() < 1e-3,
        "{weights:?}"
    );
    assert_eq!(weights[2..], last);
}

#[test]
fn a_format_without_expressions_says_so_and_a_vrm_animation_keeps_them() {
    let notes = retargeted("hero.bvh").notes.join("\n");
    assert!(
        notes.contains("face: blink, happy, aa, blinkLeft, wink, sad, lookAt left out, because "),
        "{notes}"
    );
    let scene = read(&retargeted("hero.vrma").into_bytes().unwrap());
    assert_eq!(at(&scene, "happy", 1.0).0.x, 1.0);
}

/// FBX and USD have the weights of the character's own file.
#[test]
fn expressions_are_curves_of_morph_targets_in_formats_without_expressions() {
    let hero = retargeted("hero.vrm").into_bytes().unwrap();
    let weights = values(&hero, "Body", "weights");
    // The names of the mesh's targets, in the order of the file.
    let names = ["mouth_open", "blink"];
    let read = |bytes: &[u8], name: &str| Importer::new().morph_targets(true).read(bytes, name).unwrap();
    for name in ["hero.fbx", "hero.usda"] {
        let written = retargeted(name);
        let notes = written.notes.join("\n");
        assert!(
            notes.contains("face: blink, aa, lookAt move morph targets and eyes")
                && notes.contains("face: happy, blinkLeft, wink, sad left out, because "),
            "{notes}"
        );
        assert_eq!(
            written.losses.iter().map(|loss| (loss.kind, loss.count)).next(),
            Some((DataKind::FaceCurves, 4))
        );
        let bytes = written.files.last().unwrap().bytes().into_owned();
        let scene = read(&bytes, name);
        // FBX is sampled at frames. A key between two frames is up to half a frame away, and a weight takes 18.5 frames
        // for 1.
        let beside = if name.ends_with("fbx") { 0.5 / 18.5 + 1e-3 } else { 1e-3 };
        let mut seen = 0;
        for target in scene.meshes.iter().flat_map(|mesh| &mesh.morph_targets) {
            let column = names.iter().position(|name| *name == target.name).unwrap();
            let keys = target.weight_keys[0].values.iter().copied();
            let (low, high) = keys.fold((f32::MAX, f32::MIN), |(low, high), weight| {
                (low.min(weight), high.max(weight))
            });
            let of_file = weights.iter().skip(column).step_by(names.len()).copied();
            let expected = of_file.fold((f32::MAX, f32::MIN), |(low, high), weight| {
                (low.min(weight), high.max(weight))
            });
            assert!(
                (low - expected.0).abs() < beside && (high - expected.1).abs() < beside,
                "{name}: {}",
                target.name
            );
            seen += 1;
        }
        assert_eq!(seen, 2, "{name}");
    }
}

/// The character of VRM 0 faces -Z, so its left is -X. Its eyes rotate by 10 degrees for 90 degrees of the gaze.
#[test]
fn the_eyes_of_a_character_turn_with_the_gaze() {
    let bytes = retargeted("hero.vrm").into_bytes().unwrap();
    let scene = Importer::new().read(&bytes, "hero.vrm").unwrap();
    let eye = scene
        .nodes
        .iter()
        .position(|node| node.humanoid_bone == Some(HumanoidBone::LeftEye))
        .unwrap();
    let rest = mocap::Pose::rest(&scene);
    let parent = scene.nodes[eye].parent.unwrap();
    let above = mocap::Trs::from_matrix(rest.node_to_world[parent.index()]).rotation;
    let own = mocap::Trs::from_matrix(scene.nodes[eye].transform).rotation;
    let keys = values(&bytes, &scene.nodes[eye].name, "rotation");
    let looks = |key: usize| {
        let now = Quat::from_slice(&keys[4 * key..]);
        above * now * own.inverse() * above.inverse() * Vec3::NEG_Z
    };
    let sine = |degrees: f32| degrees.to_radians().sin();
    // The gaze goes to the left by 20 degrees, then to the right by 30 and down by 10.
    let (left, right) = (looks(1), looks(2));
    assert!(
        (left.x + sine(20.0 / 9.0)).abs() < 1e-4 && left.y.abs() < 1e-4,
        "{left}"
    );
    assert!(
        (right.x - sine(30.0 / 9.0)).abs() < 1e-3 && (right.y + sine(10.0 / 9.0)).abs() < 1e-3,
        "{right}"
    );
}

/// As in JavaScript and Python: a scene of the motion on the character is written into the character's file.
#[test]
fn the_scene_of_a_motion_on_a_character_keeps_the_face() {
    let character = Importer::new()
        .import_character("../../fixtures/characters/human_vrm0.vrm")
        .unwrap();
    let retargeting = Retargeter::new(fixture(), character.clone(), RetargetOptions::new()).unwrap();
    let scene = retargeting.scene();
    assert_eq!(scene.validate(), []);
    assert_eq!(at(&scene, "happy", 1.0).0.x, 1.0);
    let provenance: Vec<_> = retargeting.clips().iter().map(|clip| clip.provenance.clone()).collect();
    let options = GltfOptions::default();
    let written = character.with_clips(&scene, &provenance, false, &options).unwrap();
    let of_retargeting = retargeting.character_file().unwrap().unwrap();
    assert_eq!(written.notes, of_retargeting.notes);
    let bytes = written.into_bytes().unwrap();
    assert!(values(&bytes, "Body", "weights").contains(&1.0));
    assert!(bytes == of_retargeting.into_bytes().unwrap());
}
