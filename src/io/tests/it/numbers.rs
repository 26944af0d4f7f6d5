//! Invalid numbers: every reader rejects or replaces them, and no writer writes them.

use std::fs;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use mocap::arrays::{ArrayOptions, Arrays};
use mocap::glam::{Mat4, Quat, Vec3};
use mocap::scene::{Keys, Scene};
use mocap::{Code, Conversion, Importer, Limits, SkeletonMesh, bvh, gltf};
use serde_json::{Value, json};

fn read(bytes: &[u8], name: &str) -> mocap::Result<Scene> {
    Importer::new()
        .skeleton_mesh(SkeletonMesh::None)
        .skeleton("../../fixtures/made/tiny.asf")
        .read(bytes, name)
}

/// A BVH file of one joint with a frame time and a row.
fn bvh_text(frame_time: &str, row: &str) -> String {
    format!(
        "HIERARCHY\nROOT a\n{{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition Xscale Yscale Zscale\n}}\n\
         MOTION\nFrames: 2\nFrame Time: {frame_time}\n0 0 0 1 1 1\n{row}\n"
    )
}

/// A glTF file of one node that moves and grows.
fn gltf_json(end: f32, frame_time: Value) -> String {
    let numbers: [f32; 8] = [0.0, 1.0, 1.0, 1.0, 1.0, end, end, end];
    let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bytes));
    json!({
        "asset": { "version": "2.0", "extras": { "mocap": { "version": "0.1.0", "frame_time": frame_time } } },
        "nodes": [{}],
        "buffers": [{ "byteLength": bytes.len(), "uri": uri }],
        "bufferViews": [{ "buffer": 0, "byteLength": 8 }, { "buffer": 0, "byteOffset": 8, "byteLength": 24 }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 2, "type": "SCALAR" },
            { "bufferView": 1, "componentType": 5126, "count": 2, "type": "VEC3" },
        ],
        "animations": [{
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "scale" } }],
            "samplers": [{ "input": 0, "output": 1 }],
        }],
    })
    .to_string()
}

/// The small FBX file with a custom frame rate, or with a changed number.
fn fbx_text(from: &str, to: &str) -> String {
    let text = fs::read_to_string("../../fixtures/made/tiny.fbx").unwrap();
    assert!(text.contains(from), "{from}");
    text.replacen(from, to, 1)
}

#[test]
fn every_reader_refuses_a_rate_that_no_motion_has() {
    // The numbers of a binary file follow the name, the types and a letter, `I` or `D`.
    let fbx = |rate: f64| {
        let mut bytes = fs::read("../../fixtures/real/huesitos.fbx").unwrap();
        let mut put = |name: &[u8], letter: &[u8], number: &[u8]| {
            let name = bytes.windows(name.len()).position(|part| part == name).unwrap() + name.len();
            let place = bytes[name..]
                .windows(letter.len())
                .position(|part| part == letter)
                .unwrap()
                + letter.len();
            bytes[name + place..][..number.len()].copy_from_slice(number);
        };
        put(b"CustomFrameRate", b"S\0\0\0\0D", &rate.to_le_bytes());
        put(b"TimeMode", b"S\0\0\0\0I", &14_i32.to_le_bytes());
        bytes
    };
    {
        // The keys are 1/25 s apart. A lower rate would lose every other key.
        for (stated, rate) in [(50.0, 50.0), (12.5, 25.0)] {
            let scene = read(&fbx(stated), "a.fbx").unwrap();
            assert_eq!(scene.animations[0].ticks_per_second, rate);
        }
    }
    for (time, rate) in [("1e6", 1e-6), ("1e-41", 1e41), ("1e40", 2e-41), ("9e-7", 1.2e6)] {
        let error = read(bvh_text(time, "0 0 0 1 1 1").as_bytes(), "a.bvh").unwrap_err();
        assert_eq!(error.code(), Code::FrameTime, "{error}");
        assert_eq!(error.location().unwrap().line, 9, "{error}");
        {
            let error = read(&fbx(rate), "a.fbx").unwrap_err();
            assert_eq!(error.code(), Code::FrameTime, "{error}");
        }
        let time: f64 = time.parse().unwrap();
        let error = read(gltf_json(1.0, json!(time)).as_bytes(), "a.gltf").unwrap_err();
        assert_eq!(error.code(), Code::FrameTime, "{error}");
        assert!(error.to_string().contains("/asset/extras/mocap/frame_time"), "{error}");
    }
    // Frame times of hours, and of the fastest camera, are valid.
    for time in ["9999", "0.000001"] {
        assert!(
            read(bvh_text(time, "0 0 0 1 1 1").as_bytes(), "a.bvh").is_ok(),
            "{time}"
        );
    }
    // The same limits apply to a rate that the caller states, in every format.
    let files = [
        "made/tiny.amc",
        "real/hand_take.c3d",
        "real/lecture_Test.bvh",
        "made/tiny.asf",
    ];
    for name in files {
        for rate in [2e-41, 1e7, f64::INFINITY, f64::NAN, 0.0] {
            let error = Importer::new()
                .retime(rate)
                .import(format!("../../fixtures/{name}"))
                .unwrap_err();
            assert_eq!(error.code(), Code::InvalidValue, "{name}: {error}");
        }
    }
}

#[test]
fn a_value_beyond_any_place_is_replaced_or_refused_in_every_format() {
    // BVH and AMC use the previous value, with a warning at the location.
    for number in ["3e38", "-1.1e18", "inf", "nan"] {
        let text = bvh_text("0.1", &format!("0 {number} 0 1 1 1"));
        let scene = read(text.as_bytes(), "a.bvh").unwrap();
        let [warning] = scene.warnings.as_slice() else {
            panic!("{:?}", scene.warnings)
        };
        assert_eq!(warning.code, Code::NonFiniteValue, "{number}");
        assert_eq!(warning.location.as_ref().unwrap().line, 11, "{number}");
        let amc = format!(":DEGREES\n1\nroot 1 2 3 0 0 90\narm 90 0\n2\nroot 1 {number} 3 0 0 0\narm 0 90\n");
        let scene = read(amc.as_bytes(), "a.amc").unwrap();
        let [warning] = scene.warnings.as_slice() else {
            panic!("{:?}", scene.warnings)
        };
        assert_eq!(
            (warning.code, warning.location.as_ref().unwrap().line),
            (Code::NonFiniteValue, 6)
        );
        assert_eq!(
            scene.animations[0].channels[0].position_keys.values,
            [Vec3::new(1.0, 2.0, 3.0)]
        );
    }
    let asf = fs::read_to_string("../../fixtures/made/tiny.asf").unwrap();
    for (from, to) in [
        ("length 2", "length 3e38"),
        ("direction 0 1 0", "direction 0 1e19 0"),
        ("position 0 0 0", "position 0 0 -inf"),
    ] {
        let error = read(asf.replacen(from, to, 1).as_bytes(), "a.asf").unwrap_err();
        assert_eq!(error.code(), Code::NonFiniteOffset, "{error}");
        assert!(error.location().is_some());
    }
    // A scale without an inverse. BVH rejects it, because its rows store only one scale.
    let error = read(bvh_text("0.1", "0 0 0 1 1e-13 1").as_bytes(), "a.bvh").unwrap_err();
    assert_eq!((error.code(), error.joint()), (Code::NumberRange, Some("a")), "{error}");
    for number in [3e38, 1e-13, f32::NAN, f32::INFINITY] {
        let error = read(gltf_json(number, json!(0.1)).as_bytes(), "a.gltf").unwrap_err();
        assert_eq!(error.code(), Code::InvalidGltf, "{error}");
        assert!(error.to_string().contains("/animations/0/samplers/0/output"), "{error}");
    }
    {
        let place = "\"Lcl Translation\", \"Lcl Translation\", \"\", \"A\",10,0,0";
        for number in ["3e38", "1e300", "-2e20"] {
            let scene = read(fbx_text(place, &place.replace("10", number)).as_bytes(), "a.fbx").unwrap();
            assert!(
                scene
                    .warnings
                    .iter()
                    .any(|warning| warning.code == Code::NonFiniteValue),
                "{number}"
            );
            let far = scene.nodes.iter().map(|node| node.transform.w_axis.abs().max_element());
            assert!(far.fold(0.0, f32::max) < 1e18);
        }
    }
}

#[test]
fn another_frame_rate_takes_memory_in_proportion() {
    let scene = mocap::import("../../fixtures/real/cmu_01_01.bvh").unwrap();
    for rate in [2e-41, 1e7, f64::INFINITY] {
        let error = Conversion::new()
            .frame_rate(rate)
            .apply(&mut scene.clone())
            .unwrap_err();
        assert_eq!(error.code(), Code::InvalidValue, "{error}");
        let options = ArrayOptions::new().frames_per_second(rate);
        assert_eq!(Arrays::of(&scene, &options).unwrap_err().code(), Code::InvalidValue);
        assert_eq!(
            scene.clone().resample(rate, &Limits::default()).unwrap_err().code(),
            Code::InvalidValue
        );
    }
    let mut changed = scene.clone();
    let error = Conversion::new().frame_rate(1e6).apply(&mut changed).unwrap_err();
    assert_eq!(error.code(), Code::LimitExceeded, "{error}");
    assert_eq!(changed.animations, scene.animations);
    let options = ArrayOptions::new().frames_per_second(1e6);
    assert_eq!(Arrays::of(&scene, &options).unwrap_err().code(), Code::LimitExceeded);
    // Two distant keys represent many frames.
    let mut scene = mocap::import("../../fixtures/real/lecture_Test.bvh").unwrap();
    let clip = &mut scene.animations[0];
    clip.channels.truncate(1);
    clip.channels[0].position_keys = Keys::at_ticks(vec![Vec3::ZERO, Vec3::ONE], vec![0.0, 1e15]);
    clip.channels[0].rotation_keys = Keys::constant(Quat::IDENTITY);
    clip.duration = 1e15;
    let error = scene.resample(30.0, &Limits::default()).unwrap_err();
    assert_eq!(error.code(), Code::LimitExceeded, "{error}");
    // The caller's limits apply to every motion.
    let mut scene = mocap::import("../../fixtures/real/lecture_Test.bvh").unwrap();
    let tight = Limits::new().max_values(100);
    let error = Conversion::new()
        .frame_rate(60.0)
        .limits(tight)
        .apply(&mut scene)
        .unwrap_err();
    assert_eq!(error.code(), Code::LimitExceeded, "{error}");
    assert!(Conversion::new().frame_rate(60.0).apply(&mut scene).is_ok());
}

/// Puts a number somewhere in a scene.
type Poison = fn(&mut Scene, f32);

fn poisons() -> Vec<(&'static str, Poison)> {
    vec![
        ("a rest pose", |scene, number| {
            scene.nodes[1].transform = Mat4::from_translation(Vec3::new(0.0, number, 0.0));
        }),
        ("a rest scale", |scene, number| {
            scene.nodes[1].transform = Mat4::from_scale(Vec3::new(1.0, number, 1.0));
        }),
        ("a position", |scene, number| {
            scene.animations[0].channels[0].position_keys.values[1].x = number;
        }),
        ("a constant position", |scene, number| {
            scene.animations[0].channels[1].position_keys = Keys::constant(Vec3::splat(number));
        }),
        ("a rotation", |scene, number| {
            scene.animations[0].channels[0].rotation_keys.values[1].x = number;
        }),
        ("a scale", |scene, number| {
            scene.animations[0].channels[1].scaling_keys = Keys::every_tick(vec![Vec3::ONE, Vec3::splat(number)]);
        }),
        ("a tick", |scene, number| {
            let keys = &mut scene.animations[0].channels[0].position_keys;
            let last = keys.len() - 1;
            let mut ticks: Vec<f64> = (0..keys.len()).map(|key| key as f64).collect();
            ticks[last] = number.into();
            *keys = Keys::at_ticks(keys.values.clone(), ticks);
        }),
        ("a rate", |scene, number| {
            scene.animations[0].ticks_per_second = number.into();
        }),
        ("a vertex", |scene, number| {
            for mesh in &mut scene.meshes {
                mesh.vertices[0].y = number;
            }
        }),
        ("a normal", |scene, number| {
            for mesh in &mut scene.meshes {
                mesh.normals.iter_mut().for_each(|normal| normal.y = number);
            }
        }),
        ("a bind pose", |scene, number| {
            for bone in scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.bones) {
                bone.offset_matrix = Mat4::from_translation(Vec3::splat(number));
            }
        }),
    ]
}

#[test]
fn nothing_that_is_not_finite_is_written() {
    for mesh in [SkeletonMesh::Segmented, SkeletonMesh::Skinned] {
        let importer = Importer::new().skeleton_mesh(mesh).collapse_keys(false);
        let sound = importer.import("../../fixtures/real/lecture_Test.bvh").unwrap();
        let mut refused = 0;
        for (what, poison) in poisons() {
            for number in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 1e-45] {
                let place = format!("{what}, {number:e}, {mesh:?}");
                let mut scene = sound.clone();
                poison(&mut scene, number);
                for options in [
                    gltf::GltfOptions::default(),
                    gltf::GltfOptions::new().keep_constant(true),
                ] {
                    match options.write_glb(&scene) {
                        Ok(glb) => assert_is_finite_glb(&glb, &place),
                        Err(_) => refused += 1,
                    }
                }
                match bvh::BvhOptions::default().write(&scene) {
                    Ok(text) => {
                        let text = String::from_utf8(text).unwrap();
                        assert!(!text.contains("NaN") && !text.contains("inf"), "{place}: {text}");
                    }
                    Err(_) => refused += 1,
                }
                let options = ArrayOptions::new().velocities(true);
                match Arrays::of(&scene, &options) {
                    Ok(motion) => {
                        let all = [
                            &motion.positions,
                            &motion.rotations,
                            motion.velocities.as_ref().unwrap(),
                        ];
                        assert!(all.into_iter().flatten().all(|value| value.is_finite()), "{place}");
                        assert!(motion.frame_rate().is_finite(), "{place}");
                    }
                    Err(_) => refused += 1,
                }
            }
        }
        assert!(refused > 60, "{refused}");
    }
}

/// JSON has no infinite numbers. They are written as `null`, which has no other use in such a file.
fn assert_is_finite_glb(glb: &[u8], place: &str) {
    let file = ::gltf::Gltf::from_slice_without_validation(glb).unwrap();
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let json = std::str::from_utf8(&glb[20..20 + length]).unwrap();
    assert!(!json.contains("null"), "{place}: {json}");
    let bin = file.blob.as_deref().unwrap_or_default();
    for accessor in file
        .accessors()
        .filter(|accessor| accessor.data_type() == ::gltf::accessor::DataType::F32)
    {
        let view = accessor.view().unwrap();
        let start = view.offset() + accessor.offset();
        let numbers = bin[start..start + accessor.count() * accessor.size()].chunks_exact(4);
        for number in numbers {
            let number = f32::from_le_bytes(number.try_into().unwrap());
            assert!(number.is_finite(), "{place}: accessor {}", accessor.index());
        }
    }
}
