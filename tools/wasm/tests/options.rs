//! Every option of a call has the effect of the library's option, and a wrong option is refused with names of the
//! package.
//!
//! The tests call the same functions as the package, with JSON and bytes. The expected results come from the library's
//! own functions.

#![allow(unsafe_code, reason = "inputs and answers of the module are addresses")]

use std::collections::BTreeSet;
use std::path::Path;

use mocap::bvh::{BvhOptions, Channels};
use mocap::convert::{FirstFrame, Moment, RestPoseSource, RootMotion};
use mocap::dump::SceneView;
use mocap::figure::{BoneNames, Humanoid, HumanoidBone, HumanoidMap};
use mocap::gltf::{BufferPlace, Compression};
use mocap::retarget::Scale;
use mocap::retarget::{RetargetOptions, Retargeter, SourceMotion, Target};
use mocap::scene::{Format, RootOffset, RotationOrder, UpAxis};
use mocap::solve::Lengths;
use mocap::{Clips, Conversion, Error, Exporter, Importer, MemoryFile, Scene, SkeletonMesh};
use mocap_wasm::{mocap_call, mocap_call_other, mocap_input, mocap_output, mocap_output_length};
use serde_json::{Value, json};

const FIXTURES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures");

/// The JSON and the bytes of an answer, or its error.
type Answer = Result<(Value, Vec<u8>), Value>;

fn call(request: &Value, files: &[&[u8]]) -> Answer {
    answer(mocap_call, request, files)
}

fn answer(call: extern "C" fn() -> u32, request: &Value, files: &[&[u8]]) -> Answer {
    let request = request.to_string();
    for input in [request.as_bytes()].iter().chain(files) {
        let room = mocap_input(input.len());
        // SAFETY: the module allocated `input.len()` bytes.
        unsafe { room.copy_from_nonoverlapping(input.as_ptr(), input.len()) };
    }
    let is_wrong = call() != 0;
    // SAFETY: the answer is valid until the next call.
    let part = |part| unsafe { std::slice::from_raw_parts(mocap_output(part), mocap_output_length(part)) };
    let json: Value = serde_json::from_slice(part(0)).unwrap();
    match is_wrong {
        true => Err(json["error"].clone()),
        false => Ok((json, part(1).to_vec())),
    }
}

fn fixture(path: &str) -> Vec<u8> {
    std::fs::read(format!("{FIXTURES}/{path}")).unwrap()
}

/// The result of a call or of the library: bytes, or a message.
type Made = Result<Vec<u8>, String>;

fn message(error: &Value) -> String {
    error["message"].as_str().unwrap().to_owned()
}

/// Writes a scene of the module to a file.
fn written(scene: &Value, format: &str, options: &Value) -> Made {
    let request = json!({"call": "write", "scene": scene, "format": format, "options": options});
    let written = call(&request, &[]).map_err(|error| message(&error))?;
    Ok(written.1)
}

fn read(path: &str, name: &str, options: &Value) -> Result<Value, Value> {
    let request = json!({"call": "read", "files": [name], "options": options});
    Ok(call(&request, &[&fixture(path)])?.0["scene"].clone())
}

/// The first difference between two results, with the text around it.
fn difference(made: &Made, expected: &Made) -> String {
    let (Ok(made), Ok(expected)) = (made, expected) else {
        return format!("{made:?}, {expected:?}").chars().take(400).collect();
    };
    let at = std::iter::zip(made, expected).take_while(|(a, b)| a == b).count();
    let around = |bytes: &[u8]| {
        let part = &bytes[at.saturating_sub(100).min(bytes.len())..(at + 100).min(bytes.len())];
        String::from_utf8_lossy(part).into_owned()
    };
    format!("at {at}: {} and {}", around(made), around(expected))
}

fn viewed(scene: Result<Scene, Error>) -> Made {
    let scene = scene.map_err(|error| error.diagnostic().message.clone())?;
    Ok(serde_json::to_vec(&SceneView::new(&scene)).unwrap())
}

/// The module's importer without options.
fn importer() -> Importer {
    Importer::new().threads(1).skeleton_mesh(SkeletonMesh::Skinned)
}

fn imported(importer: &Importer, path: &str, name: &str) -> Result<Scene, Error> {
    let bytes = fixture(path);
    let file = MemoryFile { name, bytes: &bytes };
    importer.read_among(file, &[])
}

fn bones(of: &[(HumanoidBone, &str)]) -> HumanoidMap {
    of.iter()
        .map(|(bone, name)| (*bone, Some((*name).to_owned())))
        .collect()
}

const WALK: &str = "real/cmu_short.bvh";

#[test]
fn options_of_reading_are_those_of_the_importer() {
    let points = "real/channels_0_tracked_points.bvh";
    let cases: Vec<(&str, &str, Value, Importer)> = vec![
        (
            "real/additive_root_walk.bvh",
            "a.bvh",
            json!({"rootOffset": "replace"}),
            importer().root_offset(RootOffset::Replace),
        ),
        (WALK, "a.bvh", json!({"retime": 60}), importer().retime(60.0)),
        (
            WALK,
            "a.bvh",
            json!({"collapseKeys": false}),
            importer().collapse_keys(false),
        ),
        (WALK, "a.bvh", json!({"hash": false}), importer().hash(false)),
        (
            WALK,
            "a.bvh",
            json!({"format": "asf-amc"}),
            importer().format(Format::AsfAmc),
        ),
        (WALK, "a.bvh", json!({"clip": 1}), importer().clips(Clips::Index(1))),
        (
            WALK,
            "a.bvh",
            json!({"clip": "1"}),
            importer().clips(Clips::Name("1".to_owned())),
        ),
        (
            WALK,
            "a.bvh",
            json!({"clip": "all"}),
            importer().clips(Clips::Name("all".to_owned())),
        ),
        (
            WALK,
            "a.bvh",
            json!({"skeletonMesh": "segmented"}),
            importer().skeleton_mesh(SkeletonMesh::Segmented),
        ),
        (
            WALK,
            "a.bvh",
            json!({"skeletonMesh": "none"}),
            importer().skeleton_mesh(SkeletonMesh::None),
        ),
        (WALK, "a.bvh", json!({"body": "b.bvh"}), importer().body("b.bvh")),
        (
            points,
            "a.bvh",
            json!({"joints": "coco17"}),
            importer().joints("coco17"),
        ),
        (
            "arrays/points_smpl22.npy",
            "a.npy",
            json!({"joints": "smpl22", "lengths": "moving"}),
            importer().joints("smpl22").lengths(Lengths::Moving),
        ),
        (WALK, "a.bvh", json!({"markers": "auto"}), importer().markers("auto")),
        (
            "markers/cmu_01_01.c3d",
            "a.c3d",
            json!({"markers": "auto", "static": "b.c3d"}),
            importer().markers("auto").static_trial("b.c3d"),
        ),
        (
            "made/two_bones_textured.gltf",
            "a.gltf",
            json!({"gltfMeshes": true}),
            importer().gltf_meshes(true),
        ),
    ];
    for (path, name, options, importer) in cases {
        let made = read(path, name, &options).map_err(|error| message(&error));
        let made = made.and_then(|scene| written(&scene, "json", &json!({})));
        let expected = viewed(imported(&importer, path, name));
        assert!(made == expected, "{options} {}", difference(&made, &expected));
        let plain = viewed(imported(&self::importer(), path, name));
        assert!(plain != expected, "{options} changes nothing");
    }
    let rows = String::from_utf8(fixture("real/lecture_Test.bvh")).unwrap();
    let rows = rows
        .replacen("Frames: 10", "Frames: 5", 1)
        .replacen("Frames:\t10", "Frames:\t5", 1);
    let strict = json!({"call": "read", "files": ["a.bvh"], "options": {"strict": true}});
    let error = call(&strict, &[rows.as_bytes()]).unwrap_err();
    let expected = importer().strict(true).read(rows.as_bytes(), "a.bvh").unwrap_err();
    assert_eq!(message(&error), expected.diagnostic().message);
    for all in [false, true] {
        let request = json!({"call": "read", "files": ["a.bvh"], "options": {"allRows": all}});
        let (scene, _) = call(&request, &[rows.as_bytes()]).unwrap();
        let expected = importer().all_rows(all).read(rows.as_bytes(), "a.bvh").unwrap();
        assert_eq!(expected.animations[0].frame_count(), if all { 10 } else { 5 });
        assert_eq!(written(&scene["scene"], "json", &json!({})), viewed(Ok(expected)));
    }
}

#[test]
fn options_of_conversions_are_those_of_a_conversion() {
    let (new, frame) = (Conversion::new, Moment::Frame);
    let hips = bones(&[(HumanoidBone::Head, "Neck")]);
    let cases = [
        (json!({"unit": "mm"}), new().metres_per_unit(0.001)),
        (json!({"unit": 0.02}), new().metres_per_unit(0.02)),
        (json!({"up": "z"}), new().up(UpAxis::Z)),
        (json!({"up": "-y"}), new().up(UpAxis::NegY)),
        (json!({"outUnit": "cm"}), new().out_metres_per_unit(0.01)),
        (json!({"outUp": "-z"}), new().out_up(UpAxis::NegZ)),
        (json!({"keepUnits": true}), new().keep_units(true)),
        (
            json!({"bones": {"head": "Neck"}, "tPoseFirst": true}),
            new().bones(hips).t_pose_first(true),
        ),
        (json!({"first": {"frame": 2}}), new().trim(frame(2), None)),
        (
            json!({"last": {"seconds": 0.05}}),
            new().trim(None, Moment::Seconds(0.05)),
        ),
        (json!({"frameRate": 30}), new().frame_rate(30.0)),
        (json!({"firstFrame": "drop"}), new().first_frame(FirstFrame::Drop)),
        (
            json!({"firstFrame": "auto"}),
            new().first_frame(FirstFrame::DropRestPose),
        ),
        (json!({"firstFrame": "keep", "unit": "m"}), new().metres_per_unit(1.0)),
        (json!({"rest": "t-pose"}), new().rest(RestPoseSource::TPose)),
        (json!({"rest": "frame:3"}), new().rest("frame:3".parse().unwrap())),
        (json!({"tPoseFirst": true}), new().t_pose_first(true)),
        (json!({"root": "inPlace"}), new().root(RootMotion::InPlace)),
        (json!({"root": "extract"}), new().root(RootMotion::Extract)),
    ];
    let path = "real/cmu_12_01_walk.bvh";
    let scene = read(path, "a.bvh", &json!({})).unwrap();
    let converted = |conversion: Conversion| {
        let mut scene = imported(&importer(), path, "a.bvh").unwrap();
        conversion.apply(&mut scene).map(|_| scene)
    };
    for (options, conversion) in cases {
        let request = json!({"call": "convert", "scene": scene, "options": options});
        let made = call(&request, &[]).unwrap_or_else(|error| panic!("{options}: {error}"));
        let expected = viewed(converted(conversion));
        assert!(written(&made.0["scene"], "json", &json!({})) == expected, "{options}");
        assert!(viewed(converted(new())) != expected, "{options} changes nothing");
    }
    let named = |names: Value| {
        let request = json!({"call": "convert", "scene": scene, "options": {"names": names}});
        let (made, _) = call(&request, &[])?;
        Ok(made["nodes"][0]["name"].clone())
    };
    assert_eq!(
        named(json!("unreal")),
        Ok(json!(BoneNames::Unreal.names()[&HumanoidBone::Hips]))
    );
    assert_eq!(named(json!({"hips": "Base"})), Ok(json!("Base")));
    let error: Value = named(json!("names.json")).unwrap_err();
    assert!(
        message(&error).starts_with("names must be vrm, mixamo, unreal, cmu, godot, unity, mhr, soma or"),
        "{error}"
    );
}

#[test]
fn options_of_writing_are_those_of_the_exporter() {
    let path = "real/cmu_12_01_walk.bvh";
    let new = || {
        let exporter = Exporter::new().buffer(BufferPlace::Embedded);
        exporter.compression(Compression::None)
    };
    let bvh = |options: BvhOptions| new().bvh(options);
    let cases = [
        ("glb", json!({"keepConstant": true}), new().keep_constant(true)),
        (
            "glb",
            json!({"compress": "int16"}),
            new().compression(Compression::Int16),
        ),
        ("glb", json!({"maxError": 0.002}), new().max_error(0.002)),
        ("glb", json!({"maxError": "2mm"}), new().max_error(0.002)),
        (
            "glb",
            json!({"maxError": 0.002, "shellDistance": 0.1}),
            new().max_error(0.002).shell_distance(0.1),
        ),
        ("gltf", json!({"maxError": 0.01}), new().max_error(0.01)),
        ("mclip", json!({"maxError": 0.01}), new().max_error(0.01)),
        ("fbx", json!({"maxError": 0.01}), new().max_error(0.01)),
        (
            "bvh",
            json!({"order": "XYZ"}),
            bvh(BvhOptions::new().order(RotationOrder::Xyz)),
        ),
        ("bvh", json!({"digits": 2}), bvh(BvhOptions::new().digits(2))),
        (
            "bvh",
            json!({"channels": "6"}),
            bvh(BvhOptions::new().channels(Channels::Six)),
        ),
    ];
    let scene = read(path, "a.bvh", &json!({})).unwrap();
    let request = json!({"call": "convert", "scene": scene, "options": {}});
    let scene = call(&request, &[]).unwrap().0["scene"].clone();
    let mut expected = imported(&importer(), path, "a.bvh").unwrap();
    Conversion::new().apply(&mut expected).unwrap();
    for (format, options, exporter) in cases {
        let written = |exporter: &Exporter, scene: &Scene| {
            let written = exporter.write_as(scene, format!("scene.{format}"));
            written.unwrap().into_bytes().unwrap()
        };
        let bytes = written(&exporter.clone(), &expected);
        let (made, bytes) = (self::written(&scene, format, &options), Ok(bytes));
        assert!(made == bytes, "{format} {options} {}", difference(&made, &bytes));
        assert!(Ok(written(&new(), &expected)) != bytes, "{options} changes nothing");
    }
    let mut bare = expected.clone();
    bare.leave_out_meshes();
    let bare = new().write_as(&bare, "scene.glb").unwrap().into_bytes().unwrap();
    assert!(written(&scene, "glb", &json!({"skeletonOnly": true})) == Ok(bare));
    // The picture shows the name.
    let picture = |name| written(&scene, "png", &json!({"name": name})).unwrap();
    assert!(picture("one") != picture("another"));
}

#[test]
fn options_of_the_clip_of_a_character_are_those_of_gltf() {
    let hero = fixture("characters/human_default.glb");
    let request = json!({"call": "readCharacter", "files": ["hero.glb"], "options": {}});
    let character = call(&request, &[&hero]).unwrap().0["scene"].clone();
    let motion = read(WALK, "a.bvh", &json!({})).unwrap();
    let request = json!({"call": "retarget", "scene": motion, "character": character, "options": {}});
    let moved = call(&request, &[]).unwrap().0["scene"].clone();
    let size = |options: Value| written(&moved, "glb", &options).unwrap().len();
    let plain = size(json!({}));
    // The four numbers of a rotation have 32 or 16 bits.
    assert!(size(json!({"compress": "int16"})) < plain);
    assert!(size(json!({"maxError": 0.01})) < plain);
    assert!(size(json!({"keepConstant": true})) >= plain);
    assert!(size(json!({"skeletonOnly": true})) < plain / 2);
    // A file that is passed through records its source, and equals the library's file.
    let file = MemoryFile {
        name: "hero.glb",
        bytes: &hero,
    };
    let target = Target::Character(std::sync::Arc::new(importer().read_character(file, &[]).unwrap()));
    let mut scene = imported(&importer(), WALK, "a.bvh").unwrap();
    Conversion::new().apply(&mut scene).unwrap();
    let mut retargeting = Retargeter::onto(target, RetargetOptions::new()).unwrap();
    retargeting.add(SourceMotion::converted(scene)).unwrap();
    let expected = retargeting.character_file().unwrap().unwrap();
    assert!(written(&moved, "glb", &json!({})).unwrap() == expected.into_bytes().unwrap());
}

#[test]
fn options_of_retargeting_are_those_of_the_library() {
    let (walk, body) = ("real/cmu_12_01_walk.bvh", "real/rokoko_dance.bvh");
    let (scene, character) = (
        read(walk, "a.bvh", &json!({})).unwrap(),
        read(body, "b.bvh", &json!({})).unwrap(),
    );
    let new = RetargetOptions::new;
    let neck = bones(&[(HumanoidBone::Head, "Neck1")]);
    let body_scene = imported(&importer(), body, "b.bvh").unwrap();
    let shoulder = Humanoid::of(&body_scene).joint(HumanoidBone::LeftShoulder).unwrap();
    let shoulder = &body_scene.nodes[shoulder.index()].name;
    let moved = bones(&[(HumanoidBone::LeftUpperArm, shoulder)]);
    let cases = [
        (json!({"scale": "none"}), new().scale(Scale::None)),
        (json!({"scale": 2}), new().scale(Scale::Factor(2.0))),
        (json!({"feet": "free"}), new().lock_feet(false)),
        (json!({"bones": {"head": "Neck1"}}), new().source_bones(neck)),
        (
            json!({"characterBones": {"leftUpperArm": shoulder}}),
            new().target_bones(moved),
        ),
    ];
    let expected = |options: RetargetOptions| {
        let mut source = imported(&importer(), walk, "a.bvh").unwrap();
        Conversion::new().apply(&mut source).unwrap();
        let target = Target::from(imported(&importer(), body, "b.bvh").unwrap());
        let mut retargeting = Retargeter::onto(target, options).unwrap();
        retargeting.add(SourceMotion::converted(source)).unwrap();
        let reports = retargeting.clips().iter().map(|clip| clip.report.clone());
        // Parse the text like the answer, so that numbers are rounded in the same way.
        let text = serde_json::to_string(&reports.collect::<Vec<_>>()).unwrap();
        serde_json::from_str::<Value>(&text).unwrap()
    };
    let made = |options: &Value| {
        let request = json!({"call": "retarget", "scene": scene, "character": character, "options": options});
        call(&request, &[])
            .unwrap_or_else(|error| panic!("{options}: {error}"))
            .0
    };
    let plain = expected(new());
    assert_eq!(made(&json!({}))["reports"], plain);
    for (options, library) in cases {
        let expected = expected(library);
        assert_eq!(made(&options)["reports"], expected, "{options}");
        assert_ne!(plain, expected, "{options} changes nothing");
    }
    assert_eq!(made(&json!({"name": "stroll"}))["animations"][0]["name"], "stroll");
    let view = |options| {
        let scene = &made(&options)["scene"];
        call(&json!({"call": "view", "scene": scene, "name": "a"}), &[])
            .unwrap()
            .0
            .to_string()
    };
    assert!(view(json!({"limbAngles": true})).len() > view(json!({})).len());
}

#[test]
fn wrong_options_are_refused_in_the_words_of_the_package() {
    let scene = read(WALK, "a.bvh", &json!({})).unwrap();
    let with = |call: &str, options: Value| match call {
        "read" => json!({"call": call, "files": ["a.bvh"], "options": options}),
        "write" => json!({"call": call, "scene": scene, "format": "glb", "options": options}),
        "retarget" => json!({"call": call, "scene": scene, "character": scene, "options": options}),
        _ => json!({"call": call, "scene": scene, "options": options}),
    };
    let walk = fixture(WALK);
    for (call, options, expected) in [
        ("read", json!({"colour": 1}), "colour is not an option of read"),
        // The package does not accept names of a job.
        ("read", json!({"from": "bvh"}), "from is not an option of read"),
        (
            "read",
            json!({"root-offset": "add"}),
            "root-offset is not an option of read",
        ),
        (
            "read",
            json!({"skeleton": "a.asf"}),
            "skeleton is not an option of read",
        ),
        (
            "read",
            json!({"rootOffset": "ad"}),
            "rootOffset of read must be one of auto, replace, add, not ad",
        ),
        (
            "read",
            json!({"skeletonMesh": "bones"}),
            "skeletonMesh of read must be one of segmented, skinned, none, not bones",
        ),
        (
            "read",
            json!({"lengths": "long"}),
            "lengths of read must be one of median, moving, not long",
        ),
        (
            "read",
            json!({"retime": "fast"}),
            "retime of read: invalid type: string \"fast\", expected a number",
        ),
        (
            "read",
            json!({"strict": 1}),
            "strict of read: invalid type: integer `1`, expected a boolean",
        ),
        (
            "read",
            json!({"clip": {}}),
            "clip of read: the name of a clip, or its number from 0",
        ),
        ("convert", json!({"fps": 30}), "fps is not an option of convert"),
        ("convert", json!({"trim": "0..1"}), "trim is not an option of convert"),
        ("convert", json!({"map": {}}), "map is not an option of convert"),
        (
            "convert",
            json!({"firstFrame": "no"}),
            "firstFrame of convert must be one of auto, drop, keep, not no",
        ),
        (
            "convert",
            json!({"root": "in-place"}),
            "root of convert must be one of keep, inPlace, extract, not in-place",
        ),
        (
            "convert",
            json!({"unit": "mile"}),
            "unit of convert: \"mile\": expected a unit: m, dm, cm, mm, inch, cmu or a number above 0, or auto",
        ),
        (
            "convert",
            json!({"up": "x"}),
            "up of convert: \"x\": expected auto, y, z, -y or -z",
        ),
        (
            "convert",
            json!({"bones": {"hips": 3}}),
            "bones.hips of convert: invalid type: integer `3`, expected a string",
        ),
        (
            "write",
            json!({"compress": "meshopt"}),
            "compress of write must be one of none, int16, not meshopt",
        ),
        (
            "write",
            json!({"maxError": -1}),
            "maxError of write: \"-1\": not a length, such as 1mm, 0.5cm or 0.001, which is in metres",
        ),
        (
            "write",
            json!({"digits": -1}),
            "digits of write: invalid value: integer `-1`, expected a whole number",
        ),
        (
            "write",
            json!({"shellDistance": 0.1}),
            "shellDistance has no effect without maxError or compress: set one of them, or omit shellDistance",
        ),
        (
            "write",
            json!({"digits": 3}),
            "digits has no effect on glTF: it applies to BVH; write .bvh, or omit it",
        ),
        (
            "retarget",
            json!({"feet": "off"}),
            "feet of retarget must be one of lock, free, not off",
        ),
        ("retarget", json!({"file": "a"}), "file is not an option of retarget"),
    ] {
        let request = with(call, options.clone());
        let files: &[&[u8]] = if call == "read" { &[&walk] } else { &[] };
        let error = self::call(&request, files).unwrap_err();
        assert_eq!(message(&error).trim(), expected, "{options}: {error}");
    }
    let error = call(&with("convert", json!([1])), &[]).unwrap_err();
    assert_eq!(message(&error), "the options of convert are not an object");
    let error = call(&with("retarget", json!({"scale": -1})), &[]).unwrap_err();
    assert!(message(&error).starts_with("scale of retarget: "), "{error}");
    let bone = call(&with("convert", json!({"bones": {"hipz": "Hips"}})), &[]).unwrap_err();
    assert!(
        message(&bone).starts_with("bones.hipz of convert must be one of hips, "),
        "{bone}"
    );
    // `null` means an absent option.
    call(&with("convert", json!({"unit": null, "keepUnits": null})), &[]).unwrap();
    let robot = json!({"call": "robotStream", "scene": scene, "robot": scene, "options": {}});
    assert!(message(&answer(mocap_call_other, &robot, &[]).unwrap_err()).contains("readCharacter"));
}

#[test]
fn options_of_a_stream_are_checked() {
    let robots = Path::new(FIXTURES).join("robots");
    let urdf = std::fs::read_dir(robots)
        .unwrap()
        .filter_map(|entry| Some(entry.ok()?.path()));
    let mut urdf: Vec<_> = urdf
        .filter(|path| path.extension().is_some_and(|extension| extension == "urdf"))
        .collect();
    urdf.sort();
    let bytes = std::fs::read(&urdf[0]).unwrap();
    let request = json!({"call": "readCharacter", "files": ["robot.urdf"], "options": {}});
    let robot = call(&request, &[&bytes]).unwrap().0["scene"].clone();
    let scene = read(WALK, "a.bvh", &json!({})).unwrap();
    let begun = |options: Value| {
        let request = json!({"call": "robotStream", "scene": scene, "robot": robot, "options": options});
        answer(mocap_call_other, &request, &[]).map(|(begun, _)| begun["delay"].as_f64().unwrap())
    };
    let once = begun(json!({"passes": 1, "fps": 60, "feet": "free", "floor": "keep"})).unwrap();
    assert!(once < begun(json!({})).unwrap());
    for (options, expected) in [
        (json!({"passes": 3}), "passes must be 1 or 2, got 3"),
        (
            json!({"feet": "off"}),
            "feet of robotStream must be one of lock, free, not off",
        ),
        (json!({"frameRate": 60}), "frameRate is not an option of robotStream"),
        (json!({"require": "good"}), "require is not an option of robotStream"),
    ] {
        assert_eq!(message(&begun(options).unwrap_err()), expected);
    }
}

/// The options of a TypeScript interface, including the interfaces that it extends.
fn declared(types: &str, name: &str) -> BTreeSet<String> {
    let (_, rest) = types.split_once(&format!("export interface {name} ")).unwrap();
    let (head, rest) = rest.split_once("{\n").unwrap();
    let (body, _) = rest.split_once("\n}").unwrap();
    let options = body
        .lines()
        .filter_map(|line| line.strip_prefix("  ")?.split_once("?: "));
    let mut options: BTreeSet<String> = options.map(|(name, _)| name.to_owned()).collect();
    let extended = head.trim().strip_prefix("extends ").unwrap_or_default().split(", ");
    for other in extended.filter(|other| !other.is_empty()) {
        // This base omits an option, which the interface declares itself.
        let other = if other == "ErrorOptions" {
            "SizeCallOptions"
        } else {
            other
        };
        options.append(&mut declared(types, other));
    }
    options
}

#[test]
fn the_types_have_the_options_that_calls_take() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/package");
    let types = ["index.d.ts", "options.d.ts"].map(|file| std::fs::read_to_string(format!("{folder}/{file}")).unwrap());
    let types = types.concat();
    let scene = read(WALK, "a.bvh", &json!({})).unwrap();
    let mut writing = declared(&types, "GlbOptions");
    writing.append(&mut declared(&types, "BvhOutputCallOptions"));
    writing.insert("name".to_owned());
    for (request, options) in [
        (
            json!({"call": "read", "files": ["a.bvh"]}),
            declared(&types, "ReadOptions"),
        ),
        (
            json!({"call": "convert", "scene": scene}),
            declared(&types, "ConvertOptions"),
        ),
        (json!({"call": "write", "scene": scene, "format": "glb"}), writing),
        (
            json!({"call": "retarget", "scene": scene, "character": scene}),
            declared(&types, "RetargetOptions"),
        ),
    ] {
        let mut request = request;
        request["options"] = json!({"colour": 1});
        let walk = fixture(WALK);
        let files: &[&[u8]] = if request["call"] == "read" { &[&walk] } else { &[] };
        let error = call(&request, files).unwrap_err();
        let taken = error["help"]
            .as_str()
            .unwrap()
            .strip_prefix("its options are ")
            .unwrap();
        let taken: BTreeSet<String> = taken.split(", ").map(str::to_owned).collect();
        assert_eq!(taken, options, "{request}");
    }
}
