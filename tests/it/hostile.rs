//! Damaged files give an error or a valid scene. A panic or an endless loop fails these tests.

use std::fs;
use std::path::PathBuf;

use crate::sample::Sample;
use crate::source::rust_files;
use mocap::process::SkeletonMesh;
use mocap::{Code, Importer, Limits, Pose};

/// Small files that together contain every construct of the format.
const CHANGED: &[&str] = &[
    "dialects/plain",
    "dialects/channels_0_to_6",
    "dialects/decimal_comma",
    "dialects/end_site_named_in_comment",
    "dialects/exponents",
    "dialects/hierarchy_on_one_line",
    "dialects/line_ends_mixed",
    "dialects/name_latin_1",
    "dialects/nan_in_motion",
    "dialects/numbers_without_a_blank",
    "dialects/repeated_channels",
    "dialects/two_roots",
    "dialects/utf_16_little_endian",
    "dialects/wrapped_rows",
];

fn small_fixtures() -> Vec<(PathBuf, Vec<u8>)> {
    let folders = ["fixtures/dialects", "fixtures/broken"];
    let mut paths: Vec<PathBuf> = folders
        .iter()
        .flat_map(|folder| fs::read_dir(folder).unwrap())
        .map(|entry| entry.unwrap().path())
        .collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "bvh"));
    paths.sort();
    paths
        .into_iter()
        .map(|path| (path.clone(), fs::read(path).unwrap()))
        .collect()
}

/// Imports `bytes`. If this gives a scene, the scene must be valid, and give a pose at some ticks.
fn survive(bytes: &[u8], what: &dyn Fn() -> String) {
    let importer = Importer::new()
        .format(mocap::Format::Bvh)
        .skeleton_mesh(SkeletonMesh::Segmented);
    let Ok(scene) = importer.read(bytes, "hostile.bvh") else {
        return;
    };
    let violations = scene.validate();
    assert!(violations.is_empty(), "{}: {violations:?}", what());
    for tick in [0.0, 0.5, f64::MAX] {
        if let Some(pose) = Pose::at_tick(&scene, 0, tick) {
            assert_eq!(pose.node_to_world.len(), scene.nodes.len(), "{}", what());
        }
    }
}

#[test]
fn every_prefix_is_an_error_or_a_valid_scene() {
    for (path, bytes) in small_fixtures() {
        for length in 0..=bytes.len() {
            survive(&bytes[..length], &|| {
                format!("the first {length} bytes of {}", path.display())
            });
        }
    }
}

/// Tries meaningful bytes and some random bytes at every fourth position; `tools/fuzz` tries all 256.
#[test]
fn every_changed_byte_is_an_error_or_a_valid_scene() {
    let mut random = Sample::new();
    for name in CHANGED {
        let original = fs::read(format!("fixtures/{name}.bvh")).unwrap();
        for position in random.some(0..original.len(), 4) {
            let mut bytes = original.clone();
            let meaningful = *b"\0\n\r .,-+0e{}#\xff";
            for byte in meaningful.into_iter().chain((0..8).map(|_| random.below(256) as u8)) {
                bytes[position] = byte;
                survive(&bytes, &|| format!("{name} with byte {position} = {byte:#04x}"));
            }
        }
    }
}

#[test]
fn every_missing_or_doubled_byte_is_an_error_or_a_valid_scene() {
    for name in CHANGED {
        let original = fs::read(format!("fixtures/{name}.bvh")).unwrap();
        for position in 0..original.len() {
            let mut bytes = original.clone();
            bytes.insert(position, original[position]);
            survive(&bytes, &|| format!("{name} with byte {position} twice"));
            bytes.drain(position..position + 2);
            survive(&bytes, &|| format!("{name} without byte {position}"));
        }
    }
}

#[test]
fn every_missing_line_is_an_error_or_a_valid_scene() {
    for (path, bytes) in small_fixtures() {
        let lines: Vec<&[u8]> = bytes.split_inclusive(|&byte| byte == b'\n').collect();
        for missing in 0..lines.len() {
            let rest = [&lines[..missing], &lines[missing + 1..]].concat().concat();
            survive(&rest, &|| format!("{} without line {}", path.display(), missing + 1));
        }
    }
}

/// A chain of `depth` nested joints.
fn nested(depth: usize) -> String {
    let open = "JOINT a{OFFSET 0 1 0 CHANNELS 0\n".repeat(depth - 1);
    let root = "HIERARCHY\nROOT a{OFFSET 0 1 0 CHANNELS 1 Zrotation\n";
    format!(
        "{root}{open}{}\nMOTION\nFrames: 1\nFrame Time: 1\n90\n",
        "}".repeat(depth)
    )
}

/// Long repetitions of one element. Work that grows with the square of their length would take minutes here instead of
/// seconds.
#[test]
fn long_runs_of_one_thing_are_an_error_or_a_valid_scene() {
    let names = |name: &str| format!(" {name}").repeat(500_000);
    let channels = format!("CHANNELS 1000000{}{}", names("Zrotation"), names("Xrotation"));
    for text in [
        format!("HIERARCHY\nROOT a\n{{\nOFFSET 0 1 0\n{channels}\n}}\nMOTION\nFrames: 0\nFrame Time: 1\n"),
        format!("HIERARCHY\nROOT a\n{{\n{}", "OFFSET 0 1 0\n".repeat(500_000)),
        format!("HIERARCHY\nROOT a\n{{\n{}", "CHANNELS 1 Zrotation\n".repeat(500_000)),
        format!("HIERARCHY\nROOT a\n{{\n}}{}", "}\n".repeat(1_000_000)),
        format!(
            "HIERARCHY\nROOT a\n{{\n{}}}\n",
            "JOINT b{OFFSET 0 1 0}\n".repeat(60_000)
        ),
        format!("HIERARCHY\n{}", "ROOT b{OFFSET 0 1 0}\n".repeat(60_000)),
        "#\n".repeat(1_000_000),
        "\n".repeat(2_000_000),
    ] {
        survive(text.as_bytes(), &|| text[..40].to_owned());
    }
}

#[test]
fn nesting_above_the_limit_is_refused() {
    let limit = Limits::default().max_depth;
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::None);
    assert_eq!(
        importer.read(nested(limit).as_bytes(), "deep.bvh").unwrap().nodes.len(),
        limit
    );
    for depth in [limit + 1, 100_000] {
        let error = importer.read(nested(depth).as_bytes(), "deep.bvh").unwrap_err();
        assert_eq!(error.code(), Code::LimitExceeded, "{depth}");
    }
}

#[test]
fn nesting_needs_no_stack() {
    let depth = 100_000;
    let limits = Limits::new().max_depth(depth).max_nodes(depth);
    for mesh in [SkeletonMesh::None, SkeletonMesh::Segmented] {
        let scene = Importer::new()
            .limits(limits)
            .skeleton_mesh(mesh)
            .read(nested(depth).as_bytes(), "deep.bvh")
            .unwrap();
        assert_eq!(scene.nodes.len(), depth);
        assert_eq!(scene.validate(), []);
        let tip = Pose::at_tick(&scene, 0, 0.0).unwrap().node_to_world[depth - 1].w_axis;
        // A quarter turn about z moves every link to -x, except the OFFSET of the root.
        let far = tip.x + (depth as f32 - 1.0);
        assert!(far.abs() < 1.0, "{tip}");
    }
}

#[test]
fn as_many_nodes_as_the_limit_and_no_more() {
    let limits = Limits::new().max_nodes(4);
    let wide = |joints: usize| {
        let joints = "JOINT a { OFFSET 1 0 0 }\n".repeat(joints);
        format!("HIERARCHY\nROOT r\n{{\nOFFSET 0 0 0\nCHANNELS 0\n{joints}}}\n")
    };
    let importer = Importer::new().limits(limits);
    assert_eq!(importer.read(wide(3).as_bytes(), "wide.bvh").unwrap().nodes.len(), 4);
    assert_eq!(
        importer.read(wide(4).as_bytes(), "wide.bvh").unwrap_err().code(),
        Code::LimitExceeded
    );
}

#[test]
fn more_bytes_than_the_limit_are_refused() {
    let bytes = fs::read("fixtures/dialects/plain.bvh").unwrap();
    let importer = |max_bytes| Importer::new().limits(Limits::new().max_bytes(max_bytes));
    assert!(importer(bytes.len() as u64).read(&bytes, "plain.bvh").is_ok());
    let error = importer(bytes.len() as u64 - 1).read(&bytes, "plain.bvh").unwrap_err();
    assert_eq!(error.code(), Code::LimitExceeded);
    let error = importer(1).import("fixtures/dialects/plain.bvh").unwrap_err();
    assert_eq!(error.code(), Code::LimitExceeded);
}

/// A fuzzer found this case: the place of the error is after the last line.
#[test]
fn xml_that_ends_with_a_line_is_refused() {
    for text in [
        "<robot name=\"a\">\n  <link name=\"b\">\r\n",
        "<mujoco>\n <worldbody>\n\n",
    ] {
        assert!(mocap::Importer::new().read_robot(text.as_bytes(), "robot.xml").is_err());
    }
}

#[test]
fn security_names_tests_that_exist() {
    let page = fs::read_to_string("SECURITY.md").unwrap();
    let table = page.split("## Which test holds which promise").nth(1).unwrap();
    let quoted = table.split('`').skip(1).step_by(2);
    let names: Vec<&str> = quoted.filter(|text| text.matches('_').count() > 2).collect();
    assert!(names.len() > 10, "{names:?}");
    let files = rust_files(|_| true);
    let code: String = files.iter().map(|path| fs::read_to_string(path).unwrap()).collect();
    for name in names {
        assert!(
            code.contains(&format!("#[test]\nfn {name}()")) || code.contains(&format!("#[test]\n    fn {name}()")),
            "{name}"
        );
    }
}
