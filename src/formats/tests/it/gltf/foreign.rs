//! Files as other programs write them, built here number by number.

use std::fmt::Write as _;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use mocap::glam::{Quat, Vec3};
use mocap::scene::{NodeId, NodeKind, Scene};
use mocap::{Clips, Code, Importer, Limits, Pose, SkeletonMesh};
use serde_json::{Value, json};

/// A file under construction: JSON, and the bytes of its only buffer.
struct GltfDraft {
    json: Value,
    bytes: Vec<u8>,
}

impl GltfDraft {
    fn new(nodes: Value) -> Self {
        let json = json!({
            "asset": { "version": "2.0" },
            "nodes": nodes,
            "accessors": [], "bufferViews": [], "animations": [],
        });
        Self {
            json,
            bytes: Vec::new(),
        }
    }

    fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        let view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        self.bytes.extend_from_slice(bytes);
        self.push("bufferViews", view)
    }

    fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values
            .as_flattened()
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        let view = self.view(&bytes);
        let shape = ["", "SCALAR", "", "VEC3", "VEC4"][N];
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": 5126, "count": values.len(), "type": shape }),
        )
    }

    /// Adds an animation with one channel.
    fn clip<const N: usize>(&mut self, name: &str, target: Value, times: &[f32], values: &[[f32; N]], way: &str) {
        let times: Vec<_> = times.iter().map(|time| [*time]).collect();
        let (input, output) = (self.floats(&times), self.floats(values));
        self.push(
            "animations",
            json!({
                "name": name,
                "channels": [{ "sampler": 0, "target": target }],
                "samplers": [{ "input": input, "output": output, "interpolation": way }],
            }),
        );
    }

    fn text(&self) -> String {
        let mut json = self.json.clone();
        let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&self.bytes));
        if json.get("buffers").is_none() {
            json["buffers"] = json!([{ "byteLength": self.bytes.len(), "uri": uri }]);
        }
        json.to_string()
    }

    #[track_caller]
    fn read(&self) -> Scene {
        let scene = read(self.text().as_bytes()).unwrap();
        assert_eq!(scene.validate(), []);
        scene
    }

    #[track_caller]
    fn fails(&self, code: Code, pointer: &str) -> String {
        let error = read(self.text().as_bytes()).unwrap_err();
        assert_eq!(error.code(), code, "{error}");
        assert_eq!(error.diagnostic().pointer.as_deref(), Some(pointer), "{error}");
        error.to_string()
    }
}

fn read(bytes: &[u8]) -> mocap::Result<Scene> {
    Importer::new().skeleton_mesh(SkeletonMesh::None).read(bytes, "a.gltf")
}

/// The position of a node at `seconds` of an animation.
fn place(scene: &Scene, animation: usize, node: u32, seconds: f64) -> Vec3 {
    let rate = scene.animations[animation].ticks_per_second;
    Pose::at_tick(scene, animation, seconds * rate)
        .unwrap()
        .position(NodeId(node))
}

fn quarter() -> [f32; 4] {
    Quat::from_rotation_z(std::f32::consts::FRAC_PI_2).to_array()
}

const STILL: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

#[test]
fn nodes_of_one_name_and_of_none_are_driven_by_their_index() {
    for name in [json!(null), json!("bone")] {
        let node = |children: Value| {
            let mut node = json!({ "translation": [0.0, 1.0, 0.0], "children": children });
            if name != Value::Null {
                node["name"] = name.clone();
            }
            node
        };
        let mut tip = json!({ "translation": [0.0, 1.0, 0.0] });
        if name != Value::Null {
            tip["name"] = name.clone();
        }
        // The moving node is not the first with its name.
        let mut file = GltfDraft::new(json!([node(json!([1])), node(json!([2])), tip]));
        file.clip(
            "bend",
            json!({ "node": 1, "path": "rotation" }),
            &[0.0, 1.0],
            &[STILL, quarter()],
            "LINEAR",
        );
        let scene = file.read();
        assert_eq!(scene.animations[0].channels[0].node, Some(NodeId(1)));
        let tip = place(&scene, 0, 2, 1.0);
        assert!(tip.abs_diff_eq(Vec3::new(-1.0, 2.0, 0.0), 1e-6), "{name}: {tip}");
    }
}

#[test]
fn steps_hold_until_the_next_key() {
    let mut file = GltfDraft::new(json!([{ "name": "a" }]));
    let values = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [5.0, 0.0, 0.0]];
    file.clip(
        "s",
        json!({ "node": 0, "path": "translation" }),
        &[0.0, 1.0, 2.5],
        &values,
        "STEP",
    );
    let scene = file.read();
    for (seconds, x) in [
        (0.0, 0.0),
        (0.5, 0.0),
        (0.9999, 0.0),
        (1.0, 2.0),
        (2.4999, 2.0),
        (2.5, 5.0),
    ] {
        assert_eq!(place(&scene, 0, 0, seconds).x, x, "{seconds}");
    }
    // Steps are written as steps again.
    let glb = mocap::gltf::GltfOptions::default().write_glb(&scene).unwrap();
    let again = Importer::new().read(&glb, "again.glb").unwrap();
    for (seconds, x) in [(0.9999, 0.0), (1.0001, 2.0), (2.4999, 2.0), (2.5, 5.0)] {
        assert_eq!(place(&again, 0, 0, seconds).x, x, "{seconds}");
    }
}

#[test]
fn a_motion_shorter_than_any_frame_is_a_pose_and_is_said_to_be() {
    let mut file = GltfDraft::new(json!([{ "name": "a" }]));
    let values = [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
    let target = json!({ "node": 0, "path": "translation" });
    file.clip("s", target, &[0.0, f32::from_bits(1)], &values, "LINEAR");
    let scene = file.read();
    assert_eq!(scene.animations[0].channels[0].position_keys.values, [Vec3::X]);
    assert_eq!(scene.warnings[0].code, Code::FrameTime);
    // The output has the motion that was read.
    let bvh = mocap::Exporter::new().write(&scene, mocap::scene::Format::Bvh).unwrap();
    let again = Importer::new().read(&bvh.files[0].bytes(), "again.bvh").unwrap();
    assert_eq!(again.animations[0].frame_count(), 1);
}

/// glTF's equation for one component.
fn hermite(t: f64, seconds: f64, [start, out, into, end]: [f64; 4]) -> f64 {
    (2.0 * t.powi(3) - 3.0 * t.powi(2) + 1.0) * start
        + seconds * (t.powi(3) - 2.0 * t.powi(2) + t) * out
        + (-2.0 * t.powi(3) + 3.0 * t.powi(2)) * end
        + seconds * (t.powi(3) - t.powi(2)) * into
}

#[test]
fn cubic_curves_are_followed_between_their_keys() {
    let mut file = GltfDraft::new(json!([{ "name": "a", "children": [1] }, { "name": "b", "translation": [1, 0, 0] }]));
    let x = |x: f32| [x, 0.0, 0.0];
    let values = [x(0.0), x(1.0), x(8.0), x(-6.0), x(3.0), x(0.0)];
    file.clip(
        "c",
        json!({ "node": 0, "path": "translation" }),
        &[0.0, 2.0],
        &values,
        "CUBICSPLINE",
    );
    let turn = |z: f32, w: f32| [0.0, 0.0, z, w];
    let values = [
        turn(0.0, 0.0),
        turn(0.0, 1.0),
        turn(1.5, 0.0),
        turn(0.0, 1.0),
        turn(1.0, 0.0),
        turn(0.0, 0.0),
    ];
    file.clip(
        "r",
        json!({ "node": 0, "path": "rotation" }),
        &[0.0, 2.0],
        &values,
        "CUBICSPLINE",
    );
    let scene = file.read();
    for step in 0..=97 {
        let t = f64::from(step) / 97.0;
        let expected = hermite(t, 2.0, [1.0, 8.0, -6.0, 3.0]);
        let found = f64::from(place(&scene, 0, 0, 2.0 * t).x);
        // The times of samples are also 32-bit numbers.
        assert!((found - expected).abs() < 2e-5, "{t}: {found}, not {expected}");
        let (z, w) = (
            hermite(t, 2.0, [0.0, 1.5, 0.0, 1.0]),
            hermite(t, 2.0, [1.0, 0.0, 1.0, 0.0]),
        );
        let (sin, cos) = (2.0 * z.atan2(w)).sin_cos();
        let found = place(&scene, 1, 1, 2.0 * t);
        let expected = Vec3::new(cos as f32, sin as f32, 0.0);
        assert!(found.abs_diff_eq(expected, 2e-5), "{t}: {found}, not {expected}");
    }
}

#[test]
fn each_clip_keeps_its_own_pose_when_it_is_written() {
    let mut file = GltfDraft::new(json!([{ "name": "a", "translation": [0, 9, 0] }, { "name": "b" }]));
    let still = |x: f32| [[x, 0.0, 0.0]; 2];
    file.clip(
        "one",
        json!({ "node": 0, "path": "translation" }),
        &[0.0, 1.0],
        &still(2.0),
        "LINEAR",
    );
    file.clip(
        "two",
        json!({ "node": 0, "path": "translation" }),
        &[0.0, 1.0],
        &still(-2.0),
        "LINEAR",
    );
    file.clip(
        "none",
        json!({ "node": 1, "path": "rotation" }),
        &[0.0, 1.0],
        &[STILL, quarter()],
        "LINEAR",
    );
    let scene = file.read();
    let a = NodeId(1).0;
    let places = |scene: &Scene| [0, 1, 2].map(|clip| place(scene, clip, a, 0.5));
    let expected = [Vec3::X * 2.0, Vec3::X * -2.0, Vec3::Y * 9.0];
    assert_eq!(places(&scene), expected);
    for options in [
        mocap::gltf::GltfOptions::default(),
        mocap::gltf::GltfOptions::new().keep_constant(true),
        mocap::gltf::GltfOptions::new().error_bound(Some(0.001.into())),
    ] {
        let glb = options.write_glb(&scene).unwrap();
        let again = Importer::new().read(&glb, "again.glb").unwrap();
        let names: Vec<_> = again.animations.iter().map(|clip| clip.name.as_str()).collect();
        assert_eq!(names, ["one", "two", "none"]);
        assert_eq!(places(&again), expected, "{options:?}");
        assert_eq!(
            again.nodes[1].transform, scene.nodes[1].transform,
            "the rest pose is nobody's clip"
        );
    }
}

#[test]
fn sparse_accessors_replace_values_and_begin_with_zeros() {
    let mut file = GltfDraft::new(json!([{ "name": "a" }]));
    file.clip(
        "s",
        json!({ "node": 0, "path": "translation" }),
        &[0.0, 1.0, 2.0],
        &[[1.0; 3]; 3],
        "LINEAR",
    );
    let indices = file.view(&[1, 0]);
    let values = file.view(&[0, 0, 0x80, 0x40, 0, 0, 0, 0, 0, 0, 0, 0]);
    file.json["accessors"][1]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": indices, "componentType": 5121 },
        "values": { "bufferView": values },
    });
    let rest = |scene: &Scene| [0.0, 1.0, 2.0].map(|seconds| place(scene, 0, 0, seconds));
    assert_eq!(rest(&file.read()), [Vec3::ONE, Vec3::X * 4.0, Vec3::ONE]);
    file.json["accessors"][1].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(rest(&file.read()), [Vec3::ZERO, Vec3::X * 4.0, Vec3::ZERO]);
    file.json["accessors"][1]["sparse"]["count"] = json!(4);
    file.fails(Code::InvalidGltf, "/accessors/1/sparse/count");
}

#[test]
fn channels_without_a_node_are_left_alone_and_pointers_to_nodes_are_channels() {
    let mut file = GltfDraft::new(json!([{ "name": "a" }]));
    let values = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
    file.clip("none", json!({ "path": "translation" }), &[0.0, 1.0], &values, "LINEAR");
    let target =
        |pointer: &str| json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": pointer } } });
    file.clip("node", target("/nodes/0/translation"), &[0.0, 1.0], &values, "LINEAR");
    file.clip(
        "colour",
        target("/materials/0/emissiveFactor"),
        &[0.0, 1.0],
        &values,
        "LINEAR",
    );
    file.json["extensionsRequired"] = json!(["KHR_animation_pointer"]);
    let scene = file.read();
    let channels: Vec<_> = scene.animations.iter().map(|clip| clip.channels.len()).collect();
    assert_eq!(channels, [0, 1, 0]);
    assert_eq!(place(&scene, 1, 0, 1.0), Vec3::X * 2.0);
}

#[test]
fn scales_of_every_kind_place_what_is_below_them() {
    for (scale, tip) in [
        ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
        ([-1.0, 1.0, 1.0], [-2.0, 0.0, 0.0]),
        ([0.5, 3.0, 1.0], [1.0, 0.0, 0.0]),
    ] {
        let file = GltfDraft::new(json!([{ "scale": scale, "children": [1] }, { "translation": [2, 0, 0] }]));
        let scene = file.read();
        assert_eq!(Pose::rest(&scene).position(NodeId(1)), Vec3::from(tip));
    }
    let mut file = GltfDraft::new(json!([{ "children": [1] }, { "translation": [2, 0, 0] }]));
    file.clip(
        "grow",
        json!({ "node": 0, "path": "scale" }),
        &[0.0, 1.0],
        &[[0.0; 3], [4.0, 1.0, 1.0]],
        "LINEAR",
    );
    assert_eq!(place(&file.read(), 0, 1, 0.5), Vec3::X * 4.0);
}

#[test]
fn a_buffer_is_found_beside_the_file_however_its_name_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = GltfDraft::new(json!([{ "name": "a" }]));
    let values = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
    file.clip(
        "t",
        json!({ "node": 0, "path": "translation" }),
        &[0.0, 1.0],
        &values,
        "LINEAR",
    );
    std::fs::write(folder.path().join("a b.bin"), &file.bytes).unwrap();
    let path = folder.path().join("a.gltf");
    for uri in ["a b.bin", "a%20b.bin", "./a%20b.bin"] {
        file.json["buffers"] = json!([{ "byteLength": file.bytes.len(), "uri": uri }]);
        std::fs::write(&path, file.text()).unwrap();
        let scene = Importer::new().import(&path).unwrap();
        assert_eq!(place(&scene, 0, 0, 1.0), Vec3::X * 2.0, "{uri}");
    }
    for uri in [
        "../a b.bin",
        "%2e%2e/a b.bin",
        "b/../a b.bin",
        "/etc/hostname",
        "file:///etc/hostname",
        "",
        "http://example.com/a.bin",
    ] {
        file.json["buffers"][0]["uri"] = json!(uri);
        std::fs::write(&path, file.text()).unwrap();
        let error = Importer::new().import(&path).unwrap_err();
        assert!(matches!(error.code(), Code::InvalidGltf | Code::Io), "{error}");
    }
}

#[test]
fn required_extensions_refuse_a_file_only_where_they_change_motion() {
    let mut file = GltfDraft::new(json!([{ "name": "a" }]));
    for harmless in [
        "KHR_mesh_quantization",
        "KHR_materials_unlit",
        "KHR_technique_webgl",
        "VRM",
        "VRMC_vrm",
        "KHR_lights_punctual",
    ] {
        file.json["extensionsRequired"] = json!([harmless]);
        assert!(
            file.read()
                .warnings
                .iter()
                .all(|warning| warning.code == Code::NoMotion),
            "{harmless}"
        );
    }
    file.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    let warning = &file.read().warnings[0];
    assert_eq!(warning.code, Code::UnreadExtension);
    assert!(warning.message.contains("Draco"), "{warning}");
    file.json["extensionsRequired"] = json!(["EXT_moves_everything"]);
    let error = file.fails(Code::InvalidGltf, "/extensionsRequired/0");
    assert!(error.contains("EXT_moves_everything"), "{error}");
}

#[test]
fn a_chain_deeper_than_the_limit_is_refused_at_once() {
    let nodes: Vec<_> = (1..=65_000).map(|child| json!({ "children": [child] })).collect();
    let mut nodes = Value::Array(nodes);
    nodes.as_array_mut().unwrap().push(json!({}));
    GltfDraft::new(nodes).fails(Code::LimitExceeded, "/nodes/1024");
}

#[test]
fn accessors_that_are_shared_do_not_multiply_a_file() {
    let mut file = GltfDraft::new(json!([{ "name": "a" }]));
    let frames = 15_000;
    let times: Vec<f32> = (0..frames).map(|frame| frame as f32).collect();
    let values = vec![[0.0, 0.0, 1.0]; frames];
    file.clip(
        "t",
        json!({ "node": 0, "path": "translation" }),
        &times,
        &values,
        "LINEAR",
    );
    let channel = file.json["animations"][0]["channels"][0].clone();
    file.json["animations"][0]["channels"] = vec![channel; 2_000].into();
    file.fails(Code::LimitExceeded, "/accessors/1/count");
    // Zeros without stored bytes.
    let mut file = GltfDraft::new(json!([{ "name": "a" }]));
    file.clip(
        "t",
        json!({ "node": 0, "path": "translation" }),
        &[0.0, 1.0],
        &[[1.0; 3]; 2],
        "LINEAR",
    );
    file.json["accessors"][0] = json!({ "componentType": 5126, "count": 4_000_000_000u64, "type": "SCALAR" });
    file.fails(Code::LimitExceeded, "/accessors/0/count");
}

#[test]
fn what_is_wrong_is_told_with_its_place_and_its_animation() {
    let make = || {
        let mut file = GltfDraft::new(json!([{ "name": "a" }]));
        let values = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        file.clip(
            "Run",
            json!({ "node": 0, "path": "translation" }),
            &[0.0, 1.0],
            &values,
            "LINEAR",
        );
        file
    };
    let changes: &[(&str, Value, &str)] = &[
        ("/accessors/1/type", json!("VEC4"), "/accessors/1/type"),
        ("/accessors/1/componentType", json!(7), "/accessors/1/componentType"),
        ("/accessors/1/count", json!(3), "/accessors/1"),
        ("/accessors/1/count", json!(1), "/animations/0/samplers/0/output"),
        ("/accessors/1/bufferView", json!(9), "/accessors/1/bufferView"),
        ("/bufferViews/1/byteLength", json!(u32::MAX), "/bufferViews/1"),
        ("/animations/0/samplers/0/input", json!(1), "/accessors/1/type"),
        (
            "/animations/0/samplers/0/input",
            json!(9),
            "/animations/0/samplers/0/input",
        ),
        (
            "/animations/0/samplers/0/interpolation",
            json!("EASE"),
            "/animations/0/samplers/0/interpolation",
        ),
        ("/animations/0/channels/0/sampler", json!(4), "/animations/0/samplers/4"),
        (
            "/animations/0/channels/0/target/node",
            json!(4),
            "/animations/0/channels/0/target/node",
        ),
    ];
    for (at, value, pointer) in changes {
        let mut file = make();
        *file.json.pointer_mut(at).unwrap() = value.clone();
        let error = file.fails(Code::InvalidGltf, pointer);
        assert!(error.contains("animation \"Run\""), "{error}");
        assert!(error.contains("help: "), "{error}");
    }
    let mut file = make();
    file.json["bufferViews"][1]["byteStride"] = json!(4);
    file.fails(Code::InvalidGltf, "/bufferViews/1/byteStride");
    let mut file = make();
    file.json["nodes"] = json!([{ "name": "a", "children": [-1] }]);
    file.fails(Code::InvalidGltf, "/nodes/0/children/0");
    let mut file = make();
    file.json["asset"] = json!({ "version": "1.0" });
    file.fails(Code::InvalidGltf, "/asset/version");
    for number in [3e38, 1e19] {
        let mut file = make();
        file.json["nodes"][0]["translation"] = json!([number, 0, 0]);
        file.fails(Code::InvalidGltf, "/nodes/0/translation");
    }
    let mut file = make();
    file.json["nodes"][0]["scale"] = json!([1, 1e-13, 1]);
    file.fails(Code::InvalidGltf, "/nodes/0/scale");
    let mut file = make();
    file.bytes[8..12].copy_from_slice(&1e19f32.to_le_bytes());
    file.fails(Code::InvalidGltf, "/animations/0/samplers/0/output");
}

#[test]
fn the_default_scene_is_read_and_without_scenes_all_nodes() {
    let mut file = GltfDraft::new(json!([{ "name": "a", "children": [1] }, { "name": "b" }, { "name": "c" }]));
    let names = |scene: &Scene| {
        let mut text = String::new();
        for node in &scene.nodes {
            let _ = write!(text, "{} ", node.name);
        }
        text
    };
    let scene = file.read();
    assert_eq!(names(&scene), "Roots a b c ");
    assert_eq!(scene.nodes[0].kind, NodeKind::Group);
    file.json["scenes"] = json!([{ "nodes": [0] }, { "nodes": [2] }]);
    assert_eq!(names(&file.read()), "a b ");
    file.json["scene"] = json!(1);
    assert_eq!(names(&file.read()), "c ");
    file.json["scene"] = json!(2);
    file.fails(Code::InvalidGltf, "/scene");
}

#[test]
fn a_frame_rate_is_found_for_sparse_and_for_uneven_keys() {
    let frames = |times: &[f32]| {
        let mut file = GltfDraft::new(json!([{ "name": "a" }]));
        let values: Vec<_> = (0..times.len()).map(|key| [key as f32, 0.0, 0.0]).collect();
        file.clip(
            "t",
            json!({ "node": 0, "path": "translation" }),
            times,
            &values,
            "LINEAR",
        );
        file.read().animations[0].ticks_per_second
    };
    // Three cases: keys one second apart, keys on some frames at 24 per second, and a step made of two keys.
    assert!((frames(&[0.0, 1.0, 2.0]) - 30.0).abs() < 1e-6);
    assert!((frames(&[0.0, 1.0 / 24.0, 0.5, 0.75]) - 24.0).abs() < 1e-6);
    assert!((frames(&[0.0, 0.5, 0.500001, 1.0]) - 24.0).abs() < 1e-6);
}

#[test]
fn limits_of_nodes_and_names_hold() {
    let file = GltfDraft::new(json!([{ "name": "abc" }, { "name": "b" }]));
    let read = |limits: Limits| Importer::new().limits(limits).read(file.text().as_bytes(), "a.gltf");
    let few = Limits::new().max_nodes(1);
    let short = Limits::new().max_name_bytes(2);
    for limits in [few, short] {
        assert_eq!(read(limits).unwrap_err().code(), Code::LimitExceeded);
    }
}

#[test]
fn a_clip_is_chosen_by_name_or_by_place_and_verified_against_its_own_source() {
    let mut file = GltfDraft::new(json!([{ "name": "a" }]));
    for (name, x) in [("one", 1.0), ("two", 2.0)] {
        let values = [[0.0; 3], [x, 0.0, 0.0]];
        file.clip(
            name,
            json!({ "node": 0, "path": "translation" }),
            &[0.0, 1.0],
            &values,
            "LINEAR",
        );
    }
    let folder = tempfile::tempdir().unwrap();
    let (source, output) = (folder.path().join("a.gltf"), folder.path().join("b.glb"));
    std::fs::write(&source, file.text()).unwrap();
    for clips in [Clips::Index(1), Clips::Name("two".to_owned())] {
        let scene = Importer::new().clips(clips).import(&source).unwrap();
        assert_eq!(scene.animations.len(), 1);
        assert_eq!(scene.animations[0].name, "two");
        assert_eq!(place(&scene, 0, 0, 1.0), Vec3::X * 2.0);
        mocap::Exporter::new().overwrite(true).export(&scene, &output).unwrap();
        assert!(
            mocap::verify::Verifier::new()
                .files(&source, &output)
                .unwrap()
                .max_error
                < 1e-6
        );
    }
    for clips in [Clips::Index(2), Clips::Name("three".to_owned())] {
        let error = Importer::new().clips(clips).import(&source).unwrap_err().to_string();
        assert!(error.contains("0 \"one\", 1 \"two\""), "{error}");
    }
}

#[test]
fn a_scale_that_bvh_cannot_hold_is_told_with_the_distance() {
    let nodes =
        |scale: Value| json!([{ "scale": scale, "children": [1] }, { "children": [2] }, { "translation": [1, 0, 0] }]);
    let warning = |scale: Value, channels: mocap::bvh::Channels| {
        let mut file = GltfDraft::new(nodes(scale));
        file.clip(
            "turn",
            json!({ "node": 1, "path": "rotation" }),
            &[0.0, 1.0],
            &[STILL, quarter()],
            "LINEAR",
        );
        let options = mocap::bvh::BvhOptions::default().channels(channels);
        options.scale_warning(&file.read()).unwrap()
    };
    use mocap::bvh::Channels::{Auto, Three};
    // The tip ends at (0, 1, 0). A bone of length 2 moves it to (0, 2, 0).
    let text = warning(json!([2, 1, 1]), Three).unwrap().to_string();
    assert!(
        text.contains("up to 1.000000 m from their positions in the scene, the farthest in frame 30"),
        "{text}"
    );
    // Position channels can store every position, and lengths can store a uniform scale.
    assert_eq!(warning(json!([2, 1, 1]), Auto), None);
    assert_eq!(warning(json!([2, 2, 2]), Three), None);
    assert_eq!(warning(json!([1, 1, 1]), Three), None);
}

#[test]
fn an_end_site_with_a_child_is_a_joint() {
    let file = GltfDraft::new(json!([
        { "name": "hip", "children": [1] },
        { "name": "tip", "translation": [0, 1, 0], "extras": { "end_site": true }, "children": [2] },
        { "name": "toe", "translation": [0, 0, 1] },
    ]));
    let scene = file.read();
    assert_eq!(scene.nodes[1].kind, NodeKind::Joint);
    // An End Site of BVH has no children, whatever built the scene.
    let mut made = scene.clone();
    made.nodes[1].kind = NodeKind::EndSite;
    for scene in [scene, made] {
        let text = mocap::bvh::BvhOptions::default().write(&scene).unwrap();
        let again = Importer::new()
            .skeleton_mesh(SkeletonMesh::None)
            .read(&text, "a.bvh")
            .unwrap();
        assert!(
            again.nodes.iter().any(|node| node.name == "toe"),
            "{}",
            String::from_utf8_lossy(&text)
        );
        assert_eq!(again.warnings, []);
    }
}

#[test]
fn an_end_site_without_a_parent_is_written_as_a_root() {
    let file = GltfDraft::new(json!([{ "name": "tip", "extras": { "end_site": true } }]));
    let text = mocap::bvh::BvhOptions::default().write(&file.read()).unwrap();
    let text = String::from_utf8(text).unwrap();
    assert!(text.contains("ROOT tip"), "{text}");
    let again = Importer::new().read(text.as_bytes(), "a.bvh").unwrap();
    assert_eq!(again.warnings, []);
}
