//! Tracks of ARKit's face shapes, from tables of Live Link Face and from JSON of MediaPipe. The tests convert the
//! tracks to VRM animations, characters and morph targets. A formula gives the weights.

use std::fmt::Write;

use mocap::edit::{Mirror, Step, StepInput};
use mocap::fbx::FbxOptions;
use mocap::glam::{Mat4, Vec3};
use mocap::retarget::{RetargetOptions, Retargeter, Target};
use mocap::scene::report::DataKind;
use mocap::scene::{Bone, Face, Mesh, MorphTarget, NodeId, VertexWeight};
use mocap::vrma::VrmaOptions;
use mocap::{Code, Format, FormatInfo, Importer, Scene};
use serde_json::{Value, json};

/// Columns of a table. The full file has 52.
const COLUMNS: [&str; 5] = [
    "EyeBlinkLeft",
    "EyeBlinkRight",
    "JawOpen",
    "MouthSmileLeft",
    "TongueOut",
];

/// The weight of a shape in a frame.
fn weight(shape: usize, frame: usize) -> f32 {
    (shape + 1) as f32 * 0.1 + frame as f32 * 0.001
}

/// 200 frames at 60 fps, beginning at 59.5 seconds, so that they pass a full minute. Frames 20 and 21 are missing.
fn table() -> String {
    let mut text = format!("Timecode,BlendShapeCount,{},HeadYaw,LeftEyeYaw\n", COLUMNS.join(","));
    for frame in (0..200).filter(|frame| ![20, 21].contains(frame)) {
        let (seconds, frames) = ((59 * 60 + frame + 30) / 60, (frame + 30) % 60);
        let (minutes, seconds) = (58 + seconds / 60, seconds % 60);
        write!(text, "12:{minutes}:{seconds:02}:{frames:02}.250,61").unwrap();
        for shape in 0..COLUMNS.len() {
            write!(text, ",{}", weight(shape, frame)).unwrap();
        }
        writeln!(text, ",{},0", 0.01 * frame as f64).unwrap();
    }
    text
}

/// A frame of MediaPipe's JSON.
fn landmarks(frame: usize) -> Value {
    let names = ["_neutral", "eyeBlinkLeft", "eyeBlinkRight", "jawOpen"];
    let categories = names.iter().enumerate();
    let categories = categories.map(|(index, name)| json!({ "categoryName": name, "score": weight(index, frame) }));
    let categories: Vec<Value> = categories.collect();
    json!({ "timestampMs": (frame as f64 * 1000.0 / 30.0).round(), "faceBlendshapes": [{ "categories": categories }] })
}

fn read(bytes: &[u8], name: &str) -> Scene {
    let scene = Importer::new().read(bytes, name).unwrap();
    assert_eq!(scene.validate(), []);
    scene
}

/// The weight of an expression at a tick.
fn at(scene: &Scene, name: &str, tick: f64) -> f32 {
    let is_it = |face: &Face| *face == Face::Custom(name.to_owned());
    let mut nodes = scene.nodes.iter();
    let node = nodes.position(|node| node.face.as_ref().is_some_and(is_it)).unwrap();
    let mut channels = scene.animations[0].channels.iter();
    let channel = channels
        .find(|channel| channel.node == Some(NodeId::new(node)))
        .unwrap();
    channel.position_keys.sample(tick).unwrap().x
}

#[test]
fn a_table_of_live_link_face_has_its_shapes_rate_and_gaps() {
    let text = table();
    let row = FormatInfo::of_contents(text.as_bytes()).unwrap();
    assert_eq!(row.format, Format::Csv);
    let scene = read(text.as_bytes(), "take.csv");
    let clip = &scene.animations[0];
    assert_eq!((clip.ticks_per_second, clip.duration), (60.0, 199.0));
    assert_eq!(scene.nodes.len(), 1 + COLUMNS.len());
    for tick in [0, 19, 22, 150, 199] {
        assert!(
            (at(&scene, "eyeBlinkLeft", tick as f64) - weight(0, tick)).abs() < 1e-6,
            "{tick}"
        );
        assert!(
            (at(&scene, "tongueOut", tick as f64) - weight(4, tick)).abs() < 1e-6,
            "{tick}"
        );
    }
    // In a gap, the weight is interpolated between the frames around it.
    assert!((at(&scene, "jawOpen", 20.5) - (weight(2, 19) + weight(2, 22)) / 2.0).abs() < 1e-6);
    // The head turns, but eyes do not.
    let lost = &scene.metadata.lost;
    assert_eq!(
        (lost.len(), lost[0].kind, lost[0].count),
        (1, DataKind::MovingJoints, 1)
    );
    assert_eq!(scene.warnings[0].code, Code::NotCarriedOver);
}

#[test]
fn broken_tables_of_live_link_face_are_refused_with_their_line() {
    let refused = |text: &str| {
        Importer::new()
            .read(text.as_bytes(), "take.csv")
            .unwrap_err()
            .to_string()
    };
    let table = table();
    let wrong = table.replacen(",61,0.1,", ",61,open,", 1);
    assert!(
        refused(&wrong).contains("line 2, column 3: a weight is not a number"),
        "{}",
        refused(&wrong)
    );
    let wrong = table.replacen("12:58:59:31.250", "noon", 1);
    assert!(
        refused(&wrong).contains("line 3: the first cell is not a timecode"),
        "{}",
        refused(&wrong)
    );
    let wrong = table.replacen(",61,0.1,", ",61,", 1);
    assert!(
        refused(&wrong).contains("line 2: the row is too short"),
        "{}",
        refused(&wrong)
    );
    let wrong = "Timecode,BlendShapeCount,Smile\n00:00:00:00,1,0.5\n";
    assert!(
        refused(wrong).contains("no column is a blend shape"),
        "{}",
        refused(wrong)
    );
    // The table is truncated in its last frame.
    let cut = &table[..table.len() - 12];
    let scene = Importer::new().read(cut.as_bytes(), "take.csv").unwrap();
    assert_eq!(scene.animations[0].duration, 198.0);
}

#[test]
fn json_of_mediapipe_is_read_in_its_shapes() {
    let frames: Vec<Value> = (0..30).map(landmarks).collect();
    let plain = |frame: &Value| {
        let list = frame["faceBlendshapes"][0]["categories"].as_array().unwrap();
        let pairs = list
            .iter()
            .map(|each| (each["categoryName"].as_str().unwrap().to_owned(), each["score"].clone()));
        Value::Object(pairs.collect())
    };
    let snake = |frame: &Value| {
        let list = frame["faceBlendshapes"][0]["categories"].as_array().unwrap();
        let list = list
            .iter()
            .map(|each| json!({ "category_name": each["categoryName"], "score": each["score"] }));
        json!([list.collect::<Vec<Value>>()])
    };
    for (what, text) in [
        ("objects", json!(frames)),
        ("in an object", json!({ "version": 1, "frames": frames })),
        ("names and weights", json!(frames.iter().map(plain).collect::<Vec<_>>())),
        ("lists", json!(frames.iter().map(snake).collect::<Vec<_>>())),
    ] {
        let scene = read(text.to_string().as_bytes(), "face.json");
        let clip = &scene.animations[0];
        assert_eq!((clip.ticks_per_second, clip.duration), (30.0, 29.0), "{what}");
        assert_eq!(scene.nodes.len(), 1 + 3, "{what}");
        for frame in [0, 11, 29] {
            assert!(
                (at(&scene, "jawOpen", frame as f64) - weight(3, frame)).abs() < 1e-6,
                "{what}"
            );
        }
    }
    // A frame without a face is a gap.
    let mut gap = frames.clone();
    gap[7]["faceBlendshapes"] = json!([]);
    let scene = read(json!(gap).to_string().as_bytes(), "face.json");
    assert_eq!(scene.warnings[0].code, Code::Gap);
    assert!((at(&scene, "jawOpen", 7.0) - weight(3, 7)).abs() < 1e-6);
}

#[test]
fn a_face_without_a_body_is_a_vrm_animation_and_is_mirrored() {
    let mut scene = read(table().as_bytes(), "take.csv");
    let bytes = VrmaOptions::default().write(&scene).unwrap().0;
    let file: Value = serde_json::from_slice(&gltf::Glb::from_slice(&bytes).unwrap().json).unwrap();
    let extension = &file["extensions"]["VRMC_vrm_animation"];
    assert_eq!(
        extension["expressions"]["custom"].as_object().unwrap().len(),
        COLUMNS.len()
    );
    assert!(extension.get("humanoid").is_none());
    let again = read(&bytes, "a.vrma");
    let seconds = again.animations[0].ticks_per_second;
    assert!((at(&again, "jawOpen", 150.0 / 60.0 * seconds) - weight(2, 150)).abs() < 1e-5);

    Mirror::new().apply(&mut scene, &StepInput::new()).unwrap();
    assert!((at(&scene, "eyeBlinkLeft", 9.0) - weight(1, 9)).abs() < 1e-6);
    assert!((at(&scene, "eyeBlinkRight", 9.0) - weight(0, 9)).abs() < 1e-6);
    assert!((at(&scene, "mouthSmileRight", 9.0) - weight(3, 9)).abs() < 1e-6);
    assert!((at(&scene, "jawOpen", 9.0) - weight(2, 9)).abs() < 1e-6);
}

#[test]
fn shapes_that_a_vrm_lacks_move_its_presets() {
    let character = Importer::new()
        .import_character("../../fixtures/characters/human_vrm0.vrm")
        .unwrap();
    let source = read(table().as_bytes(), "take.csv");
    let retargeted = Retargeter::new(source, character, RetargetOptions::new()).unwrap();
    let export = retargeted.character_file().unwrap().unwrap();
    let notes = export.notes.join("\n");
    assert!(
        notes.contains("the character lacks some blend shapes of ARKit; its expressions blink, aa replace them"),
        "{notes}"
    );
    assert!(notes.contains("dropped: mouthSmileLeft, tongueOut"), "{notes}");
    assert_eq!(
        (export.losses[0].kind, export.losses[0].count),
        (DataKind::FaceCurves, 2)
    );

    let bytes = export.files.last().unwrap().bytes();
    let glb = gltf::Glb::from_slice(&bytes).unwrap();
    let file: Value = serde_json::from_slice(&glb.json).unwrap();
    // Only morph targets move, and the body does not change.
    let channels = file["animations"][0]["channels"].as_array().unwrap();
    assert_eq!((channels.len(), &channels[0]["target"]["path"]), (1, &json!("weights")));
    let sampler = &file["animations"][0]["samplers"][channels[0]["sampler"].as_u64().unwrap() as usize];
    let numbers = |accessor: &Value| -> Vec<f32> {
        let accessor = &file["accessors"][accessor.as_u64().unwrap() as usize];
        let view = &file["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let from = view["byteOffset"].as_u64().unwrap_or(0) + accessor["byteOffset"].as_u64().unwrap_or(0);
        let count = accessor["count"].as_u64().unwrap() as usize;
        let bytes = &glb.bin.as_ref().unwrap()[from as usize..][..4 * count];
        bytes
            .as_chunks::<4>()
            .0
            .iter()
            .map(|bytes| f32::from_le_bytes(*bytes))
            .collect()
    };
    let (times, weights) = (numbers(&sampler["input"]), numbers(&sampler["output"]));
    // The file states the targets of `a` and `blink`: its mouth is the first target, its lids are the second.
    for (key, time) in times.iter().enumerate() {
        let frame = (time * 60.0).round() as usize;
        assert!((weights[2 * key] - weight(2, frame)).abs() < 1e-5, "mouth at {time}");
        let blink = (weight(0, frame) + weight(1, frame)) / 2.0;
        assert!((weights[2 * key + 1] - blink).abs() < 1e-5, "lids at {time}");
    }
}

#[test]
fn shapes_move_the_morph_targets_of_a_scene_and_go_into_fbx() {
    let mut target = mocap::import("../../fixtures/skeletons/human_default.gltf").unwrap();
    let shape = |name: &str| MorphTarget {
        name: name.to_owned(),
        vertex_ids: vec![0, 1, 2],
        offsets: vec![Vec3::Y; 3],
        ..MorphTarget::default()
    };
    target.nodes.iter_mut().for_each(|node| node.meshes.clear());
    let weights = (0..3).map(|vertex_id| VertexWeight { vertex_id, weight: 1.0 });
    let head = target.find_node("head").unwrap();
    target.meshes = vec![Mesh {
        bones: vec![Bone {
            name: "head".to_owned(),
            node: head,
            offset_matrix: Mat4::IDENTITY,
            weights: weights.collect(),
        }],
        name: "Head".to_owned(),
        vertices: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        indices: vec![0, 1, 2],
        morph_targets: ["Head.jawOpen", "eyeBlink_R", "frown"].map(shape).into(),
        ..Mesh::default()
    }];
    target.nodes[0].meshes = vec![0];
    let source = read(table().as_bytes(), "take.csv");
    let retargeted = Retargeter::new(source, Target::from(target), RetargetOptions::new()).unwrap();
    let scene = retargeted.scene_in_metres().unwrap();
    let bytes = FbxOptions::default().write(&scene).unwrap().0;
    let read = Importer::new().morph_targets(true).read(&bytes, "a.fbx").unwrap();
    let curve = |name: &str, tick: f64| {
        let targets = read.meshes.iter().flat_map(|mesh| &mesh.morph_targets);
        let target = targets.into_iter().find(|target| target.name == name).unwrap();
        target
            .weight_keys
            .first()
            .and_then(|keys| keys.sample(tick))
            .unwrap_or_default()
    };
    let (rate, tick) = (read.animations[0].ticks_per_second, 150.0);
    assert_eq!(rate, 60.0);
    assert!((curve("Head.jawOpen", tick) - weight(2, 150)).abs() < 1e-4);
    assert!((curve("eyeBlink_R", tick) - weight(1, 150)).abs() < 1e-4);
    assert_eq!(curve("frown", tick), 0.0);
}
