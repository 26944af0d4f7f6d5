//! One tiny file for each dialect: nodes, world positions, frames and warnings, compared with values computed by hand.

use std::fs;
use std::path::{Path, PathBuf};

use crate::kinematics::{Vector, distance};
use mocap::process::SkeletonMesh;
use mocap::scene::{NodeId, RootOffset, Scene};
use mocap::{Code, Diagnostic, Importer, Pose};

/// The largest distance of a node from its expected position. The skeletons are a few units tall.
const TOLERANCE: f64 = 1e-5;

/// The contents of a file `NAME.expected`, in the form that `fixtures/README.md` describes.
#[derive(Debug, Default)]
struct Expected {
    frames: usize,
    rate: Option<f64>,
    root: Option<String>,
    warnings: Vec<String>,
    nodes: Vec<(usize, String, Vector)>,
}

impl Expected {
    fn parse(text: &str) -> Self {
        let (facts, nodes) = text.split_once("\n\n").unwrap();
        let mut expected = Self::default();
        for line in facts.lines() {
            let (key, value) = line.split_once(' ').unwrap();
            let value = value.trim();
            match key {
                "frames" => expected.frames = value.parse().unwrap(),
                "rate" => expected.rate = Some(value.parse().unwrap()),
                "root" => expected.root = Some(value.to_owned()),
                "warning" => expected.warnings.push(value.to_owned()),
                _ => panic!("unknown fact: {line}"),
            }
        }
        expected.nodes = nodes.lines().map(node).collect();
        expected
    }
}

/// A node's depth, name and position from a line such as `    Hand.L 1   1 2 3`.
fn node(line: &str) -> (usize, String, Vector) {
    let depth = (line.len() - line.trim_start().len()) / 2;
    let mut words = line.trim().rsplitn(4, ' ');
    let [z, y, x] = std::array::from_fn(|_| words.next().unwrap().parse().unwrap());
    (depth, words.next().unwrap().trim_end().to_owned(), [x, y, z])
}

fn importer() -> Importer {
    Importer::new().skeleton_mesh(SkeletonMesh::None)
}

fn fixtures() -> Vec<(PathBuf, Expected)> {
    let mut paths: Vec<PathBuf> = fs::read_dir("../../fixtures/dialects")
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "bvh"));
    paths.sort();
    let expected = |path: &Path| Expected::parse(&fs::read_to_string(path.with_extension("expected")).unwrap());
    paths.into_iter().map(|path| (path.clone(), expected(&path))).collect()
}

fn frames(scene: &Scene) -> usize {
    scene
        .animations
        .first()
        .map_or(0, |animation| animation.duration as usize + 1)
}

fn depth(scene: &Scene, index: usize) -> usize {
    scene.nodes[index]
        .parent
        .map_or(0, |parent| 1 + depth(scene, parent.index()))
}

/// A warning in the words of `NAME.expected`, as far as this file states it.
fn describe(warning: &Diagnostic, like: &str) -> String {
    let mut text = warning.code.to_string();
    if let Some(location) = warning.location.as_ref().filter(|_| like.contains(" at ")) {
        text += &format!(" at {}:{}", location.line, location.column);
    }
    if like.ends_with(" times)") {
        text += &format!(" ({} times)", warning.count);
    }
    text
}

/// The differences of `scene` from the expected values, one sentence each.
fn differences(scene: &Scene, expected: &Expected) -> Vec<String> {
    let mut differences = Vec::new();
    let mut check = |what: &str, is: String, should: String| {
        if is != should {
            differences.push(format!("{what} {is} and not {should}"));
        }
    };
    check("frames", frames(scene).to_string(), expected.frames.to_string());
    if let Some(rate) = expected.rate {
        let ticks = scene.animations[0].ticks_per_second;
        check("rate", format!("{ticks:.6}"), format!("{rate:.6}"));
    }
    if let Some(root) = &expected.root {
        let policy = scene.metadata.root_offset.as_ref().map(|used| match used.policy {
            RootOffset::Replace => "replace",
            RootOffset::Add => "add",
            _ => "undecided",
        });
        check("root", format!("{policy:?}"), format!("{:?}", Some(root)));
    }
    let likes = expected
        .warnings
        .iter()
        .map(String::as_str)
        .chain(std::iter::repeat(""));
    let warnings: Vec<String> = scene
        .warnings
        .iter()
        .zip(likes)
        .map(|(warning, like)| describe(warning, like))
        .collect();
    check("warnings", format!("{warnings:?}"), format!("{:?}", expected.warnings));

    let graph: Vec<_> = (0..scene.nodes.len())
        .map(|index| (depth(scene, index), &*scene.nodes[index].name))
        .collect();
    let should: Vec<_> = expected
        .nodes
        .iter()
        .map(|(depth, name, _)| (*depth, &**name))
        .collect();
    check("nodes", format!("{graph:?}"), format!("{should:?}"));
    if graph != should {
        return differences;
    }

    let last = expected.frames.saturating_sub(1) as f64;
    let pose = Pose::at_tick(scene, 0, last).unwrap_or_else(|| Pose::rest(scene));
    for (index, (_, name, position)) in expected.nodes.iter().enumerate() {
        let stands = pose.position(NodeId::new(index)).to_array().map(f64::from);
        // NaN is not near any number.
        let off = distance(stands, *position);
        if off > TOLERANCE || off.is_nan() {
            differences.push(format!("{name} stands at {stands:?} and not at {position:?}"));
        }
    }
    differences
}

#[test]
fn every_dialect_means_what_was_worked_out_by_hand() {
    let mut failures = String::new();
    for (path, expected) in fixtures() {
        let differences = match importer().import(&path) {
            Ok(scene) => differences(&scene, &expected),
            Err(error) => vec![error.to_string()],
        };
        for difference in differences {
            failures += &format!("{}: {difference}\n", path.display());
        }
    }
    assert!(failures.is_empty(), "\n{failures}");
}

/// A scene without the name of its file and the line numbers.
fn import_nameless(path: impl AsRef<Path>) -> Scene {
    let mut scene = importer().import(path).unwrap();
    let origin = scene.metadata.origin.as_mut().unwrap();
    origin.name.clear();
    origin.sha256.clear();
    for node in &mut scene.nodes {
        node.source = None;
    }
    scene
}

/// Files that differ only in spelling, and have no warning, give equal scenes.
#[test]
fn a_dialect_of_spelling_alone_gives_the_identical_scene() {
    let plain = Expected::parse(&fs::read_to_string("../../fixtures/dialects/plain.expected").unwrap());
    let scene = import_nameless("../../fixtures/dialects/plain.bvh");
    let mut same = 0;
    for (path, expected) in fixtures() {
        // If the root's position replaces its OFFSET, the OFFSET is still the rest pose.
        let spelling_alone = expected.warnings.is_empty() && expected.root.is_none();
        if spelling_alone && expected.frames == plain.frames && expected.nodes == plain.nodes {
            assert_eq!(import_nameless(&path), scene, "{}", path.display());
            same += 1;
        }
    }
    assert!(same >= 25, "only {same} fixtures are of spelling alone");
}

#[test]
fn all_rows_are_read_on_request() {
    for (name, rows) in [("one_row_more", 3), ("many_rows_more", 6)] {
        let scene = importer()
            .all_rows(true)
            .import(format!("../../fixtures/dialects/{name}.bvh"))
            .unwrap();
        assert_eq!(frames(&scene), rows, "{name}");
        let hip = Pose::at_tick(&scene, 0, rows as f64 - 1.0).unwrap().position(NodeId(0));
        assert_eq!(hip.to_array(), [9.0; 3], "{name}");
    }
}

#[test]
fn a_stated_frame_rate_takes_the_place_of_a_useless_frame_time() {
    for name in [
        "frame_time_0",
        "frame_time_negative",
        "frame_time_not_a_number",
        "frame_time_nan",
        "no_frame_time",
    ] {
        let scene = importer()
            .retime(25.0)
            .import(format!("../../fixtures/broken/{name}.bvh"));
        let scene = scene.unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scene.animations[0].ticks_per_second, 25.0, "{name}");
        assert_eq!(frames(&scene), 2, "{name}");
        let tip = Pose::at_tick(&scene, 0, 1.0)
            .unwrap()
            .position(NodeId(2))
            .to_array()
            .map(f64::from);
        assert!(distance(tip, [1.0, 2.0, 6.0]) <= TOLERANCE, "{name}: {tip:?}");
    }
}

#[test]
fn a_stated_frame_rate_overrides_a_good_frame_time() {
    let scene = importer()
        .retime(60.0)
        .import("../../fixtures/dialects/plain.bvh")
        .unwrap();
    assert_eq!(scene.animations[0].ticks_per_second, 60.0);
}

#[test]
fn a_warning_of_values_that_are_not_finite_names_the_joint_and_the_channel() {
    let scene = importer().import("../../fixtures/dialects/nan_in_motion.bvh").unwrap();
    let [warning] = &*scene.warnings else {
        panic!("{:?}", scene.warnings)
    };
    assert_eq!(
        (warning.code, warning.joint.as_deref()),
        (Code::NonFiniteValue, Some("hip"))
    );
    assert!(warning.to_string().contains("Yposition"), "{warning}");
}

#[test]
fn a_scale_channel_becomes_scaling_keys() {
    let scene = importer().import("../../fixtures/dialects/scale_channels.bvh").unwrap();
    let keys = &scene.animations[0].channels[1].scaling_keys;
    assert_eq!(
        keys.values.iter().map(mocap::glam::Vec3::to_array).collect::<Vec<_>>(),
        [[1.0; 3], [2.0, 3.0, 4.0]]
    );
}

/// A pose generator writes a rotation after each offset.
#[test]
fn what_stands_behind_three_numbers_of_an_offset_is_a_warning() {
    let plain = std::fs::read_to_string("../../fixtures/dialects/plain.bvh").unwrap();
    let longer = plain.replace("OFFSET 0 2 0", "OFFSET 0 2 0 0.5 -1 7");
    assert_ne!(longer, plain);
    let scene = importer().read(longer.as_bytes(), "a.bvh").unwrap();
    let whole = importer().read(plain.as_bytes(), "a.bvh").unwrap();
    assert_eq!(scene.nodes, whole.nodes);
    let codes: Vec<Code> = scene.warnings.iter().map(|warning| warning.code).collect();
    assert_eq!(codes, [Code::LongOffset]);
    let error = importer().read(plain.replace("OFFSET 0 2 0", "OFFSET 0 2 0 x").as_bytes(), "a.bvh");
    assert_eq!(error.unwrap_err().code(), Code::UnexpectedToken);
}

/// Two takes in one file. The first declares more rows than it has.
#[test]
fn a_second_hierarchy_ends_the_first_motion() {
    let plain = std::fs::read_to_string("../../fixtures/dialects/plain.bvh").unwrap();
    let whole = importer().read(plain.as_bytes(), "a.bvh").unwrap();
    for declared in ["Frames: 2", "Frames: 5"] {
        let two = plain.replace("Frames: 2", declared) + &plain;
        let scene = importer().read(two.as_bytes(), "a.bvh").unwrap();
        assert_eq!(scene.animations, whole.animations, "{declared}");
        let codes: Vec<Code> = scene.warnings.iter().map(|warning| warning.code).collect();
        let expected: &[Code] = match declared {
            "Frames: 2" => &[Code::TrailingText],
            _ => &[Code::MissingFrames, Code::TrailingText],
        };
        assert_eq!(codes, expected, "{declared}");
    }
}
