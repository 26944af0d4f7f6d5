//! USD: positions that `usd-core` computes from a file that it wrote, written files read by splitting, and refusals. In
//! `tools/usd`, Pixar's library reads written files.

mod animation;
mod archive;
mod composition;
mod meshes;
mod names;

use std::fs;

use glam::Vec3;
use mocap::{Code, Conversion, Exporter, Format, Importer, Pose, Scene, SkeletonMesh};

const ARM: &str = "../../fixtures/made/arm.usda";

fn read(text: &str) -> mocap::Result<Scene> {
    Importer::new().read(text.as_bytes(), "take.usda")
}

/// World positions in metres with +Z up, by `usd-core` 26.11, as `tools/usd/fixture.py` prints them, with the tick of
/// each time code. Code 107 is between two keys.
const EXPECTED: [(f64, [[f32; 3]; 4]); 5] = [
    (
        0.0,
        [
            [0.1140478, 0.2448709, 0.3582174],
            [0.3510063, 0.2490598, 1.1223071],
            [0.3660213, 0.1016041, 0.2808611],
            [1.1998341, 0.0029377, 1.6007581],
        ],
    ),
    (
        6.0,
        [
            [0.1229338, 0.245028, 0.3868707],
            [0.3598923, 0.2492169, 1.1509605],
            [0.4089575, 0.226576, 0.2982706],
            [0.9700335, 0.3329101, 1.9451412],
        ],
    ),
    (
        24.0,
        [
            [0.1495916, 0.2454992, 0.4728308],
            [0.3865501, 0.2496881, 1.2369205],
            [0.4282902, 0.1753325, 0.3867858],
            [1.1297517, 0.2345032, 1.9132495],
        ],
    ),
    (
        39.0,
        [
            [0.1884116, 0.284264, 0.3820547],
            [0.4253701, 0.2884529, 1.1461444],
            [0.4560372, 0.1766264, 0.2996491],
            [1.2375518, 0.1675285, 1.7255735],
        ],
    ),
    (
        48.0,
        [
            [0.2117036, 0.3075228, 0.327589],
            [0.4486621, 0.3117117, 1.0916788],
            [0.3481344, 0.5710985, 0.2838343],
            [0.2525441, -0.258084, 1.8959614],
        ],
    ),
];

#[test]
fn joints_are_where_pixars_library_has_them() {
    let scene = Importer::new().import(ARM).unwrap();
    assert_eq!(scene.metadata.format, Some(Format::Usd));
    assert_eq!(scene.metadata.metres_per_unit, Some(0.01));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let animation = &scene.animations[0];
    assert_eq!((animation.ticks_per_second, animation.duration), (48.0, 48.0));
    assert_eq!(animation.name, "Wave");
    for (tick, joints) in EXPECTED {
        let pose = Pose::at_tick(&scene, 0, tick).unwrap();
        for (name, expected) in ["Base", "Arm", "Tail", "Hand"].into_iter().zip(joints) {
            let node = scene.nodes.iter().position(|node| node.name == name).unwrap();
            let found = 0.01 * pose.node_to_world[node].w_axis.truncate();
            let off = found.distance(Vec3::from_array(expected));
            assert!(off < 2e-6, "{name} at tick {tick}: {found} is {off} m off");
        }
    }
}

/// The text after `name = `, up to the end of its line.
fn line<'a>(text: &'a str, name: &str) -> &'a str {
    let (_, rest) = text
        .split_once(&format!("{name} = "))
        .unwrap_or_else(|| panic!("{name}"));
    rest.lines().next().unwrap()
}

#[test]
fn names_times_units_and_clips_as_they_are_written() {
    let mut scene = Importer::new().import("../../fixtures/real/lecture_Test.bvh").unwrap();
    Conversion::new().apply(&mut scene).unwrap();
    scene.nodes[0].name = "左 \"hip\"".to_owned();
    scene.nodes[1].name = "mixamorig:Leg".to_owned();
    scene.animations[0].name = "walk 1".to_owned();
    let mut second = scene.animations[0].clone();
    second.name = "Walk".to_owned();
    second.ticks_per_second *= 2.0;
    scene.animations.push(second);
    let written = Exporter::new().write_as(&scene, "take.usda").unwrap();
    let text = String::from_utf8(written.into_bytes().unwrap()).unwrap();
    assert!(text.starts_with("#usda 1.0\n"));
    assert_eq!((line(&text, "metersPerUnit"), line(&text, "upAxis")), ("1", "\"Y\""));
    let rate = scene.animations[0].ticks_per_second.to_string();
    assert_eq!(line(&text, "timeCodesPerSecond"), rate);
    let joints = line(&text, "token[] joints");
    assert!(
        joints.starts_with("[\"___hip_\", \"___hip_/mixamorig_Leg\", "),
        "{joints}"
    );
    assert!(line(&text, "jointNames").starts_with("[\"左 \\\"hip\\\"\", \"mixamorig:Leg\", "));
    // The file has both clips, and the skeleton follows the first.
    assert!(text.contains("def SkelAnimation \"walk_1\" (\n        displayName = \"walk 1\"\n"));
    assert!(text.contains("def SkelAnimation \"Walk\"\n"));
    assert_eq!(line(&text, "skel:animationSource"), "</Character/walk_1>");
    let again = read(&text).unwrap();
    let names = |scene: &Scene| -> Vec<String> { scene.nodes.iter().map(|node| node.name.clone()).collect() };
    assert_eq!(names(&again), names(&scene));
    let clips = |scene: &Scene| -> Vec<_> {
        let clips = scene.animations.iter();
        clips
            .map(|clip| (clip.name.clone(), clip.ticks_per_second, clip.duration))
            .collect()
    };
    assert_eq!(clips(&again), clips(&scene));
}

#[test]
fn a_skin_goes_into_the_archive_with_its_texture_and_weights_that_add_up_to_1() {
    let importer = Importer::new().gltf_meshes(true).skeleton_mesh(SkeletonMesh::Own);
    let scene = importer.import("../../fixtures/made/two_bones_textured.gltf").unwrap();
    let archive = Exporter::new()
        .write_as(&scene, "bar.usdz")
        .unwrap()
        .into_bytes()
        .unwrap();
    let image = &scene.textures[0].bytes;
    let at = archive
        .windows(image.len())
        .position(|window| window == &image[..])
        .unwrap();
    assert_eq!(at % 64, 0);
    let text = String::from_utf8_lossy(&archive);
    let name = line(&text, "asset inputs:file").trim_matches('@');
    assert!(name.starts_with("textures/"), "{name}");
    assert_eq!(
        text.matches(name).count(),
        3,
        "the stage, the file, and the list of files"
    );
    let sizes = line(&text, "elementSize").parse::<usize>().unwrap();
    let weights: Vec<f32> = line(&text, "primvars:skel:jointWeights")
        .trim_matches(['[', ']', ' ', '('])
        .split(", ")
        .map(|weight| weight.parse().unwrap())
        .collect();
    assert!(
        weights
            .chunks(sizes)
            .all(|weights| (weights.iter().sum::<f32>() - 1.0).abs() < 1e-6)
    );
    let again = Importer::new().read(&archive, "bar.usdz").unwrap();
    assert_eq!(again.nodes.len(), scene.nodes.len());
}

#[test]
fn refusals_say_what_to_do() {
    let refused = |bytes: &[u8], code: Code, said: &str| {
        let error = Importer::new().read(bytes, "take.usda").unwrap_err();
        assert_eq!(error.code(), code, "{error}");
        assert!(
            format!("{error}{:?}", error.diagnostic().help).contains(said),
            "{error}"
        );
    };
    refused(
        b"PXR-USDC\0\x08\0\0\0\0\0\0",
        Code::UnreadableFormat,
        "usdcat FILE -o FILE.usda",
    );
    refused(
        b"#usda 1.0\ndef Xform \"a\" {\n}\n",
        Code::InvalidUsd,
        "there is no Skeleton",
    );
    refused(
        b"#usda 1.0\ndef Skeleton \"a\" {\n",
        Code::UnexpectedEnd,
        "within the prim",
    );
    refused(b"#usda 1.0\n}", Code::UnexpectedToken, "cannot stand here");
    let arm = fs::read_to_string(ARM).unwrap();
    let with = |from: &str, to: &str| {
        assert!(arm.contains(from), "{from}");
        arm.replacen(from, to, 1).into_bytes()
    };
    refused(
        &with("metersPerUnit = 0.01", "metersPerUnit = 0"),
        Code::InvalidUsd,
        "metersPerUnit",
    );
    refused(
        &with("upAxis = \"Z\"", "upAxis = \"X\""),
        Code::InvalidUsd,
        "upAxis must be Y or Z",
    );
    refused(
        &with("timeCodesPerSecond = 48", "timeCodesPerSecond = 0"),
        Code::FrameTime,
        "frame rate",
    );
    refused(&with("\"Base/Tail\"", "\"Base\""), Code::InvalidUsd, "occurs twice");
    refused(&with("(7, 2, 3)", "(7, 2, inf)"), Code::NumberRange, "translations");
    refused(&with("(7, 2, 3)", "(7, 2)"), Code::InvalidUsd, "9 numbers");
    refused(&with("(0, 0, 40, 1)", "(0, 0, 40, 2)"), Code::InvalidUsd, "0 0 0 1");
    refused(&with("(0, 0, 40, 1)", "(0, 0, 40)"), Code::InvalidUsd, "64 numbers");
    let deep = format!("#usda 1.0\n{}", "def \"a\" {\n".repeat(5000));
    refused(deep.as_bytes(), Code::LimitExceeded, "prims within each other");
}

/// The numbers come from a fuzzer: a time code of 1e20 made a BVH without end.
#[test]
fn a_time_that_makes_a_take_too_long_is_refused_where_it_stands() {
    let arm = fs::read_to_string(ARM).unwrap();
    let last_key = "149: [(0.8660254";
    let first_key = "101: [(0.8660254";
    let cases = [
        (last_key, "1e20: [(0.8660254", "1e20"),
        (last_key, "1e9: [(0.8660254", "1e9"),
        (last_key, "1e7: [(0.8660254", "1e7"),
        (first_key, "-1e12: [(0.8660254", "-1e12"),
        (last_key, "1e308: [(0.8660254", "1e308"),
        (last_key, "nan: [(0.8660254", "nan"),
        ("startTimeCode = 101", "startTimeCode = -1e12", "-1e12"),
    ];
    for (from, to, word) in cases {
        assert!(arm.contains(from), "{from}");
        let text = arm.replacen(from, to, 1);
        let error = read(&text).unwrap_err();
        let place = error.diagnostic().location.as_ref().unwrap();
        let line = 1 + text[..text.find(to).unwrap()].matches('\n').count();
        assert_eq!(place.line, line, "{to}: {error}");
        let found: String = place
            .text
            .chars()
            .skip(place.column - place.text_column)
            .take(place.length)
            .collect();
        assert_eq!(found, word, "{error}");
        let is_number = word != "nan";
        assert_eq!(error.code() == Code::LimitExceeded, is_number, "{error}");
        assert_eq!(error.diagnostic().help.is_some(), is_number, "{error}");
    }
    // Five hours are long, but allowed.
    assert!(read(&arm.replacen(last_key, "900000: [(0.8660254", 1)).is_ok());
    // A motion of this program states its duration.
    let scene = read(&arm).unwrap();
    let written = Exporter::new()
        .write(&scene, Format::Usd)
        .unwrap()
        .into_bytes()
        .unwrap();
    let text = String::from_utf8(written).unwrap();
    let (before, after) = text.split_once("mocap:duration = ").unwrap();
    let (_, after) = after.split_once('\n').unwrap();
    let error = read(&format!("{before}mocap:duration = 1e15\n{after}")).unwrap_err();
    assert_eq!(error.code(), Code::LimitExceeded);
    assert_eq!(
        error.diagnostic().location.as_ref().unwrap().line,
        1 + before.matches('\n').count()
    );
}

#[test]
fn prefixes_and_changed_bytes_give_an_error_or_a_valid_scene() {
    let arm = fs::read(ARM).unwrap();
    let survive = |bytes: &[u8]| {
        if let Ok(scene) = Importer::new().format(Format::Usd).read(bytes, "hostile.usda") {
            let violations = scene.validate();
            assert!(
                violations.is_empty(),
                "{violations:?}: {}",
                String::from_utf8_lossy(bytes)
            );
        }
    };
    for length in (0..arm.len()).step_by(7) {
        survive(&arm[..length]);
    }
    for at in (0..arm.len()).step_by(3) {
        let mut changed = arm.clone();
        changed[at] = b"\"(9{]"[at % 5];
        survive(&changed);
    }
}

/// Pixar's library writes `\\x` and two hexadecimal digits.
#[test]
fn control_characters_of_names_are_kept() {
    let name = "a\u{8}bc\u{1}7\"\\\n";
    let mut scene = mocap::import("../../fixtures/real/lecture_Test.bvh").unwrap();
    scene.nodes[0].name = name.to_owned();
    for animation in &mut scene.animations {
        animation.channels[0].node_name = name.to_owned();
    }
    let bytes = Exporter::new()
        .write_as(&scene, "a.usda")
        .unwrap()
        .into_bytes()
        .unwrap();
    let text = String::from_utf8(bytes.clone()).unwrap();
    assert!(text.contains(r#""a\x08bc\x017\"\\\n""#), "{text}");
    assert_eq!(Importer::new().read(&bytes, "a.usda").unwrap().nodes[0].name, name);
}

/// A moving joint that the file marks as an end site was lost in formats without channels of end sites, such as FBX.
#[test]
fn what_moves_or_carries_a_joint_is_no_end_site() {
    let scene = mocap::import("../../fixtures/real/lecture_Test.bvh").unwrap();
    let bytes = Exporter::new()
        .write_as(&scene, "a.usda")
        .unwrap()
        .into_bytes()
        .unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let marked = text.replace("\"joint\"", "\"end_site\"");
    assert_ne!(text, marked);
    let kinds = |scene: &mocap::Scene| scene.nodes.iter().map(|node| node.kind).collect::<Vec<_>>();
    assert_eq!(kinds(&read(&marked).unwrap()), kinds(&scene));
}

/// A step has a key just before the next frame. This key does not belong to that frame.
#[test]
fn a_key_just_before_a_frame_stays_there() {
    let mut scene = mocap::import("../../fixtures/real/lecture_Test.bvh").unwrap();
    let (before, step) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(4.0, 5.0, 6.0));
    let keys = &mut scene.animations[0].channels[0].position_keys;
    keys.ticks = Some(vec![0.0, 0.999_999_925_494_194, 1.0]);
    keys.values = vec![before, before, step];
    let bytes = Exporter::new()
        .write_as(&scene, "a.usda")
        .unwrap()
        .into_bytes()
        .unwrap();
    let read = Importer::new().read(&bytes, "a.usda").unwrap();
    let root = read.animations[0]
        .channels
        .iter()
        .find(|channel| channel.node == scene.animations[0].channels[0].node);
    let values = &root.unwrap().position_keys.values;
    assert!(
        values.last().unwrap().normalize().distance(step.normalize()) < 1e-6,
        "{values:?}"
    );
}
