//! The statements of an FBX file (range, rate, unit and axes), compared with its keys and with the caller's statements.

use mocap::glam::Vec3;
use mocap::scene::{NodeId, UpAxis};
use mocap::{Code, Conversion, Importer, Pose, Scene};

const ZERO: &str = include_str!("../../../../fixtures/made/fbx_stop_zero.fbx");
const Z_UP: &str = include_str!("../../../../fixtures/made/fbx_zup.fbx");

/// FBX's time units in a second.
const SECOND: u64 = 46_186_158_000;

fn read(text: &str) -> Scene {
    Importer::new().read(text.as_bytes(), "walk.fbx").unwrap()
}

/// The file with another range.
fn with_range(start: u64, stop: u64) -> String {
    let lines = ZERO.lines().map(|line| {
        let value = match line {
            _ if line.contains("\"LocalStart\"") || line.contains("\"ReferenceStart\"") => start,
            _ if line.contains("\"LocalStop\"") || line.contains("\"ReferenceStop\"") => stop,
            _ => return line.to_owned() + "\n",
        };
        let (before, _) = line.rsplit_once(',').unwrap();
        format!("{before},{value}\n")
    });
    lines.collect()
}

fn codes(scene: &Scene) -> Vec<Code> {
    scene.warnings.iter().map(|warning| warning.code).collect()
}

fn frames(scene: &Scene) -> usize {
    scene.animations[0].frame_count()
}

/// The position of the hips in the last frame.
fn hips_at_end(scene: &Scene) -> Vec3 {
    let animation = &scene.animations[0];
    let pose = Pose::at_tick(scene, 0, animation.duration).unwrap();
    let hips = scene.nodes.iter().position(|node| node.name == "Hips").unwrap();
    pose.position(NodeId::new(hips))
}

/// Three.js and Assimp read the keys, whatever the range is.
#[test]
fn keys_win_over_a_range_that_contradicts_them() {
    let absent: String = ZERO
        .lines()
        .filter(|line| !["LocalSt", "ReferenceSt"].iter().any(|name| line.contains(name)))
        .map(|line| line.to_owned() + "\n")
        .collect();
    let files = [
        ("zero", ZERO.to_owned()),
        ("absent", absent),
        ("after the keys", with_range(2 * SECOND, 3 * SECOND)),
        ("backwards", with_range(SECOND, 0)),
        ("one tick", with_range(0, 1)),
    ];
    for (name, text) in files {
        let scene = read(&text);
        assert_eq!(codes(&scene), [Code::HeaderCount], "{name}");
        assert_eq!(
            (frames(&scene), scene.animations[0].ticks_per_second),
            (31, 30.0),
            "{name}"
        );
        assert!(
            hips_at_end(&scene).abs_diff_eq(Vec3::new(0.4, 0.9, 0.0), 1e-6),
            "{name}"
        );
    }
}

#[test]
fn a_range_that_holds_keys_stays_and_keys_outside_of_it_are_told() {
    let right = read(&with_range(0, SECOND));
    assert_eq!((codes(&right), frames(&right)), (vec![], 31));
    // A pause after the last key is not a contradiction.
    let longer = read(&with_range(0, 2 * SECOND));
    assert_eq!((codes(&longer), frames(&longer)), (vec![], 61));
    let part = read(&with_range(0, SECOND / 2));
    assert_eq!((codes(&part), frames(&part)), (vec![Code::FrameCount], 16));
    assert!(hips_at_end(&part).abs_diff_eq(Vec3::new(0.2, 0.9, 0.0), 1e-6));
}

/// The file states 30 frames per second, and has 120 keys per second.
#[test]
fn keys_win_over_a_rate_that_would_lose_them() {
    let step = SECOND / 120;
    let times: Vec<String> = (0..5).map(|key| (key * step).to_string()).collect();
    let text = with_range(0, 4 * step).replace("0,11546539500,23093079000,34639618500,46186158000", &times.join(","));
    let scene = read(&text);
    assert_eq!(codes(&scene), [Code::FrameTime]);
    assert_eq!((frames(&scene), scene.animations[0].ticks_per_second), (5, 120.0));
    let given = Importer::new()
        .sampling_rate(60.0)
        .read(text.as_bytes(), "walk.fbx")
        .unwrap();
    assert_eq!((codes(&given), frames(&given)), (vec![], 3));
}

/// Converts the scene, and returns the position of the hips in the first frame.
fn hips(mut scene: Scene, conversion: &Conversion) -> (Vec3, Vec<Code>) {
    conversion.apply(&mut scene).unwrap();
    let hips = scene.nodes.iter().position(|node| node.name == "Hips").unwrap();
    let place = Pose::at_tick(&scene, 0, 0.0).unwrap().position(NodeId::new(hips));
    (place, codes(&scene))
}

#[test]
fn a_true_statement_changes_nothing_and_a_false_one_is_asked_about() {
    let y_up = read(&with_range(0, SECOND));
    let z_up = read(Z_UP);
    let new = Conversion::new;
    let told = vec![Code::StatedOtherwise];
    let standing = Vec3::new(0.0, 0.9, 0.0);
    let cases = [
        (&y_up, new(), standing, vec![]),
        (&y_up, new().metres_per_unit(0.01), standing, vec![]),
        (&y_up, new().up(UpAxis::Y), standing, vec![]),
        (&z_up, new().metres_per_unit(0.01).up(UpAxis::Z), standing, vec![]),
        // The file states a hip height of 90, along +Y or along +Z.
        (
            &y_up,
            new().metres_per_unit(1.0),
            Vec3::new(0.0, 90.0, 0.0),
            told.clone(),
        ),
        (&y_up, new().up(UpAxis::Z), Vec3::new(0.0, 0.0, -0.9), told.clone()),
        (&z_up, new().up(UpAxis::Y), Vec3::new(0.0, 0.0, 0.9), told.clone()),
        (&z_up, new().up(UpAxis::NegZ), Vec3::new(0.0, -0.9, 0.0), told),
    ];
    for (index, (scene, conversion, expected, warnings)) in cases.into_iter().enumerate() {
        let (found, codes) = hips(scene.clone(), &conversion);
        assert!(found.abs_diff_eq(expected, 1e-4), "case {index}: {found}, {expected}");
        assert_eq!(codes, warnings, "case {index}");
    }
}

/// Another format that states both values: centimetres and +Z up.
#[test]
fn usd_takes_statements_likewise() {
    let plain = |conversion: Conversion| {
        let mut scene = mocap::import("../../fixtures/made/arm.usda").unwrap();
        conversion.apply(&mut scene).unwrap();
        let last = NodeId::new(scene.nodes.len() - 1);
        (
            Pose::rest(&scene).position(last),
            codes(&scene).contains(&Code::StatedOtherwise),
        )
    };
    let (place, told) = plain(Conversion::new());
    assert!(!told);
    assert_eq!(
        plain(Conversion::new().metres_per_unit(0.01).up(UpAxis::Z)),
        (place, false)
    );
    let (farther, told) = plain(Conversion::new().metres_per_unit(1.0));
    assert!(told && farther.abs_diff_eq(100.0 * place, 1e-3 * farther.length()));
}

#[test]
fn a_giant_and_a_doll_are_told_in_every_format() {
    for (metres, is_told) in [(5.6444, true), (0.056_444, false), (0.000_564_44, true)] {
        let mut scene = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
        Conversion::new().metres_per_unit(metres).apply(&mut scene).unwrap();
        assert_eq!(codes(&scene).contains(&Code::ImplausibleSize), is_told, "{metres}");
        for format in [mocap::Format::Fbx, mocap::Format::Gltf, mocap::Format::Usd] {
            let bytes = mocap::Exporter::new()
                .write(&scene, format)
                .unwrap()
                .into_bytes()
                .unwrap();
            let mut again = Importer::new()
                .read(&bytes, format!("a.{}", format.extensions()[0]))
                .unwrap();
            Conversion::new().apply(&mut again).unwrap();
            assert_eq!(
                codes(&again).contains(&Code::ImplausibleSize),
                is_told,
                "{format}, {metres}"
            );
        }
    }
}
