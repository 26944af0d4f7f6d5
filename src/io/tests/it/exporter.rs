//! Tests `Exporter` with every written format, driven only by the table of formats.

use std::fs;

use mocap::files::ReplacePolicy;
use mocap::glam::{Mat4, Quat, Vec3};
use mocap::gltf::BufferPlace;
use mocap::gltf::report::Provenance;
use mocap::scene::{Animation, Channel, Keys, Node, NodeId, NodeKind, UpAxis};
use mocap::verify::Verifier;
use mocap::verify::report::Verification;
use mocap::{
    Code, Conversion, Diagnostic, Export, Exporter, Format, FormatInfo, Importer, Scene, SkeletonMesh, WriteOption,
};

use crate::sample::{Sample, is_all};

/// Each written format with each of its extensions.
fn written() -> Vec<(&'static FormatInfo, &'static str)> {
    let rows = FormatInfo::ALL.iter().filter(|row| row.writes());
    let written: Vec<_> = rows
        .flat_map(|row| row.extensions.iter().map(move |extension| (row, *extension)))
        .collect();
    assert!(written.len() >= 6, "{}", written.len());
    written
}

/// A motion in the unit of each format: formats that keep the file's unit get the file's numbers, others get metres
/// with +Y up.
fn read(path: &str, row: &FormatInfo) -> Scene {
    let mesh = match row.has_file_meshes {
        true => SkeletonMesh::Own,
        false => SkeletonMesh::Skinned,
    };
    let mut scene = Importer::new().skeleton_mesh(mesh).import(path).unwrap();
    Conversion::new()
        .keep_units(row.keeps_units())
        .apply(&mut scene)
        .unwrap();
    scene
}

/// The fixtures that every written format must store. The test reads each output back, and `verify` compares it within
/// 0.02 mm with its own kinematics. So a new format needs no separate test.
#[test]
fn every_written_format_holds_the_motion_of_every_small_fixture() {
    const SMALL: u64 = 100_000;
    let folder = tempfile::tempdir().unwrap();
    // Test every second combination of a file and a format.
    let parts = if is_all() { 1 } else { 2 };
    let first = Sample::new().below(parts);
    let (mut count, mut files_tried) = (0, 0);
    let mut files: Vec<_> = fs::read_dir("../../fixtures/real")
        .unwrap()
        .map(|entry| entry.unwrap())
        .collect();
    files.sort_by_key(fs::DirEntry::path);
    for file in files {
        let path = file.path();
        let is_motion = path
            .extension()
            .is_some_and(|extension| extension == "bvh" || extension == "amc");
        let Ok(scene) = Importer::new().import(&path) else {
            continue;
        };
        if !is_motion || file.metadata().unwrap().len() > SMALL || scene.animations.is_empty() {
            continue;
        }
        files_tried += 1;
        for (place, (row, extension)) in written().into_iter().enumerate() {
            if (files_tried + place) % parts != first {
                continue;
            }
            let scene = read(path.to_str().unwrap(), row);
            let output = folder.path().join("take").with_extension(extension);
            let what = format!("{} as .{extension}", path.display());
            let written = match Exporter::new().overwrite(true).export(&scene, &output) {
                Ok(written) => written,
                // A VRM animation needs a humanoid, and a packed clip has no animated scales.
                Err(error) if [Code::NotHumanoid, Code::Unrepresentable].contains(&error.code()) => continue,
                Err(error) => panic!("{what}: {error}"),
            };
            assert!(written.files.iter().all(|file| !file.is_empty()), "{what}");
            let again = Importer::new().import(&output).unwrap();
            assert_eq!(again.metadata.format, Some(row.format), "{what}");
            // BVH has no scales, and warns. Only the motion is compared.
            let is_beside = |warning: &Diagnostic| warning.code == Code::NotCarriedOver;
            if !written.warnings.iter().all(is_beside) {
                continue;
            }
            let verifier = Verifier::new().provenance(Provenance::of(&scene));
            let verified = verifier
                .files(&path, &output)
                .unwrap_or_else(|error| panic!("{what}: {error}"));
            let allowed = written.error.map_or(2e-5, |error| error.max_error + 2e-5);
            assert!(verified.max_error <= allowed, "{what}: {verified:?}");
            count += 1;
        }
    }
    assert!(count > 60 / parts, "{count}");
}

/// Names from files of other programs, with characters that separate lines, columns or blocks in some format.
const NAMES: [&str; 24] = [
    "",
    "",
    "\t",
    " ",
    "a\tb",
    "a\nb",
    "a\r\nb",
    "say \"hi\"",
    "#tip",
    "#",
    "Hips",
    "Hips",
    "Hips",
    "{x}",
    "}",
    "a,b",
    "'q'",
    "a\u{2028}b",
    "back\\slash",
    "<y>&amp;",
    "JOINT",
    "End Site",
    "X1",
    "\u{5de6}\u{8155}",
];

/// A root with a swinging joint or end site for each name.
fn with_hostile_names() -> Scene {
    let node = |name: &str, parent, transform, kind| Node {
        name: name.to_owned(),
        parent,
        transform,
        kind,
        ..Node::default()
    };
    let mut scene = Scene::default();
    scene.nodes.push(node("root", None, Mat4::IDENTITY, NodeKind::Joint));
    for (index, name) in NAMES.into_iter().enumerate() {
        let offset = Vec3::new(0.1 * index as f32 - 1.0, 0.3 + 0.01 * index as f32, 0.2);
        let kind = if index % 3 == 2 {
            NodeKind::EndSite
        } else {
            NodeKind::Joint
        };
        scene
            .nodes
            .push(node(name, Some(NodeId::new(0)), Mat4::from_translation(offset), kind));
    }
    let turn = |frame: u8| Quat::from_rotation_z(0.2 * f32::from(frame));
    scene.animations.push(Animation {
        ticks_per_second: 30.0,
        duration: 4.0,
        channels: vec![Channel {
            node_name: "root".to_owned(),
            node: Some(NodeId::new(0)),
            position_keys: Keys::constant(Vec3::ZERO),
            rotation_keys: Keys::every_tick((0..5).map(turn).collect()),
            scaling_keys: Keys::constant(Vec3::ONE),
        }],
        ..Animation::default()
    });
    scene.metadata.metres_per_unit = Some(1.0);
    scene.metadata.up = Some(UpAxis::Y);
    scene
}

/// Every format can store any node name. After reading the file again, each joint has its position, and the report
/// lists each changed name.
#[test]
fn names_that_a_format_cannot_hold_are_replaced_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("hostile.glb");
    let scene = with_hostile_names();
    Exporter::new().export(&scene, &source).unwrap();
    let read = Importer::new().import(&source).unwrap();
    let names = |scene: &Scene| scene.nodes.iter().map(|node| node.name.clone()).collect::<Vec<_>>();
    assert_eq!(
        names(&read),
        names(&scene),
        "glTF keeps the names beside those of the file"
    );
    let mut written_as = Vec::new();
    for (row, extension) in written() {
        let path = folder.path().join("take").with_extension(extension);
        let exported = match Exporter::new().export(&scene, &path) {
            Ok(exported) => exported,
            Err(error) if error.code() == Code::NotHumanoid => continue,
            Err(error) => panic!(".{extension}: {error}"),
        };
        let again = Importer::new()
            .import(&path)
            .unwrap_or_else(|error| panic!(".{extension}: {error}"));
        assert_eq!(again.metadata.format, Some(row.format));
        let verified = Verifier::new().provenance(Provenance::of(&scene)).files(&source, &path);
        let verified = verified.unwrap_or_else(|error| panic!(".{extension}: {error}"));
        let allowed = exported.error.as_ref().map_or(2e-5, |error| error.max_error + 2e-5);
        assert!(verified.is_within(allowed), ".{extension}: {verified:?}");
        let texts = String::from_utf8_lossy(&exported.files.last().unwrap().bytes()).into_owned();
        for renamed in &exported.renamed {
            assert_eq!(renamed.from, scene.nodes[renamed.node].name, ".{extension}");
        }
        match row.format {
            Format::Trc => {
                let columns: Vec<&str> = texts.lines().nth(3).unwrap().split('\t').collect();
                let markers: Vec<&str> = columns[2..].iter().copied().step_by(3).collect();
                check_names(&markers, &exported);
                assert_eq!(texts.lines().count(), 6 + 5, "a line for each of 5 frames");
            }
            Format::Bvh => {
                let heads = texts.lines().map(str::trim);
                let head = |line: &'_ str| {
                    ["ROOT ", "JOINT ", "End Site "]
                        .iter()
                        .any(|word| line.starts_with(word))
                };
                let names: Vec<&str> = heads
                    .filter(|line| head(line))
                    .map(|line| line.trim_start_matches("ROOT ").trim_start_matches("End Site "))
                    .map(|line| line.strip_prefix("JOINT ").unwrap_or(line))
                    .collect();
                check_names(&names, &exported);
                assert_eq!(texts.matches('{').count(), 1 + NAMES.len());
            }
            _ => {}
        }
        written_as.push(extension);
    }
    assert_eq!(
        written_as,
        ["bvh", "glb", "gltf", "trc", "fbx", "usda", "usdz", "mclip"]
    );
}

/// Each name in the file is unique, and is either the scene's name or a name in the report.
fn check_names(names: &[&str], exported: &Export) {
    assert_eq!(names.len(), 1 + NAMES.len(), "{names:?}");
    let once: std::collections::BTreeSet<_> = names.iter().collect();
    assert_eq!(once.len(), names.len(), "{names:?}");
    for (index, name) in names.iter().enumerate().skip(1) {
        assert!(
            !name.trim().is_empty() && !name.contains(|c: char| c.is_control()),
            "{name:?}"
        );
        let renamed = exported.renamed.iter().find(|renamed| renamed.node == index);
        let told = renamed.map_or(NAMES[index - 1], |renamed| &renamed.to);
        assert_eq!(*name, told);
    }
}

/// The bytes and names of an export in memory equal the bytes and names of an export to a disk.
#[test]
fn what_is_written_in_memory_is_what_is_exported() {
    let folder = tempfile::tempdir().unwrap();
    for (row, extension) in written() {
        let scene = read("../../fixtures/real/cmu_short.bvh", row);
        let path = folder.path().join("take").with_extension(extension);
        let exporter = Exporter::new().max_error(0.001);
        let exported = exporter.export(&scene, &path).unwrap();
        assert_eq!(exporter.write_as(&scene, &path).unwrap(), exported, ".{extension}");
        for file in &exported.files {
            let found = fs::read(folder.path().join(file.name())).unwrap();
            assert_eq!((found.len(), &found[..]), (file.len(), &*file.bytes()), ".{extension}");
            assert_eq!(file.parts().collect::<Vec<_>>().concat(), found);
        }
        assert_eq!(exported.files.last().unwrap().name(), format!("take.{extension}"));
        let again = Importer::new().import(&path).unwrap();
        let bones = again.nodes.iter().filter(|node| node.kind != NodeKind::Group);
        // A VMD has no skeleton, so the test reads it with a model.
        if row.format != Format::Vmd {
            assert_eq!(exported.nodes, bones.count(), ".{extension}");
        }
        let bound = exported.error.as_ref().map(|error| error.max_error);
        assert_eq!(bound.is_some(), row.takes(WriteOption::MaxError), ".{extension}");
        assert!(
            bound.is_none_or(|error| error > 0.0 && error <= 0.001),
            ".{extension}: {bound:?}"
        );
        // An output of two files cannot be a stream.
        let count = exported.files.len();
        assert_eq!(exported.into_bytes().is_ok(), count == 1, ".{extension}");
    }
    let scene = read("../../fixtures/real/cmu_short.bvh", FormatInfo::of(Format::Gltf));
    let embedded = Exporter::new().buffer(BufferPlace::Embedded);
    let text = embedded.write_as(&scene, "take.gltf").unwrap().into_bytes().unwrap();
    assert_eq!(
        Importer::new().read(&text, "take.gltf").unwrap().nodes.len(),
        scene.nodes.len()
    );
}

#[test]
fn an_output_in_no_written_format_is_an_error() {
    let scene = read("../../fixtures/real/lecture_Test.bvh", FormatInfo::of(Format::Bvh));
    let folder = tempfile::tempdir().unwrap();
    for name in ["take.amc", "take.c3d", "take.xyz", "take"] {
        let path = folder.path().join(name);
        let error = Exporter::new().export(&scene, &path).unwrap_err();
        assert_eq!(error.code(), Code::UnknownFormat, "{name}");
        let expected = error.diagnostic().expected.as_deref().unwrap();
        assert_eq!(expected, FormatInfo::written_extensions(), "{name}");
        assert!(!path.exists(), "{name}");
    }
    let unwritten = FormatInfo::ALL.iter().filter(|row| !row.writes());
    for row in unwritten {
        let error = Exporter::new().write(&scene, row.format).unwrap_err();
        assert_eq!(error.code(), Code::UnknownFormat, "{}", row.format);
    }
}

/// A file that may be a source is not replaced in any format, unless an option allows it.
#[test]
fn an_export_replaces_only_what_is_known_as_an_output() {
    let folder = tempfile::tempdir().unwrap();
    for (row, extension) in written() {
        let [scene, other] =
            ["lecture_Test", "cmu_short"].map(|name| read(&format!("../../fixtures/real/{name}.bvh"), row));
        let path = folder.path().join("take").with_extension(extension);
        fs::write(&path, "somebody's work").unwrap();
        let refused = |exporter: &Exporter, scene: &Scene| exporter.export(scene, &path).map(drop).unwrap_err().code();
        // The lecture's arm is not a humanoid.
        let is_of_humanoids = row.states_bones || row.format == Format::Vmd;
        let scene = if is_of_humanoids { &other } else { &scene };
        assert_eq!(refused(&Exporter::new(), scene), Code::OutputExists, ".{extension}");
        assert_eq!(fs::read(&path).unwrap(), b"somebody's work", ".{extension}");
        Exporter::new().overwrite(true).export(scene, &path).unwrap();
        // The same export is written again. If the format states its writer, also another file of mocap.
        Exporter::new().export(scene, &path).unwrap();
        let again = Exporter::new().export(&other, &path);
        assert_eq!(again.is_ok(), row.states_origin || is_of_humanoids, ".{extension}");
        // An input is never replaced.
        let inputs = Exporter::new().replace(ReplacePolicy::new([&path])).overwrite(true);
        assert_eq!(refused(&inputs, &other), Code::OutputIsInput, ".{extension}");
    }
    // The policy knows the extensions of all formats that mocap reads.
    for extension in FormatInfo::ALL.iter().flat_map(|row| row.extensions) {
        assert!(
            ReplacePolicy::is_source(format!("a.{extension}").as_ref()),
            "{extension}"
        );
    }
}

/// Every format keeps the shear of a rest pose or reports its loss. `verify` detects the loss, and the skin is not
/// damaged.
#[test]
fn shear_at_rest_is_kept_or_said() {
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::None);
    let mut source = importer.import("../../fixtures/real/cmu_short.bvh").unwrap();
    // A joint that the motion does not animate, with animated children.
    let hip = source.nodes.iter().position(|node| node.name == "LHipJoint").unwrap();
    source.animations[0]
        .channels
        .retain(|channel| channel.node_name != "LHipJoint");
    source.nodes[hip].transform.y_axis.x = 0.5;
    source.add_skeleton_mesh(SkeletonMesh::Skinned);
    let mut scene = source.clone();
    Conversion::new().apply(&mut scene).unwrap();
    for (row, extension) in written() {
        let Ok(written) = Exporter::new().write_as(&scene, format!("a.{extension}")) else {
            assert_eq!(row.format, Format::Mclip, "a bound is kept with uniform scales alone");
            continue;
        };
        let said = written
            .warnings
            .iter()
            .find(|warning| warning.message.contains("shear"));
        let keeps = [Format::Usd, Format::Vrma, Format::Trc, Format::Vmd].contains(&row.format);
        assert_eq!(said.is_none(), keeps, "{extension}: {:?}", written.warnings);
        if let Some(said) = said {
            assert_eq!(
                (said.code, said.joint.as_deref()),
                (Code::Unrepresentable, Some("LHipJoint"))
            );
            // The arc tangent of 0.5.
            assert!(said.message.contains("26.57 degrees"), "{}", said.message);
        }
        if [Format::Gltf, Format::Fbx, Format::Usd].contains(&row.format) {
            // The buffer of a `.gltf` is a separate file.
            let Ok(bytes) = written.into_bytes() else { continue };
            let verified = Verification::of(&source, &bytes).unwrap();
            assert_eq!(verified.max_error < 1e-4, keeps, "{extension}: {verified:?}");
            assert!(verified.findings.is_empty(), "{extension}: {:?}", verified.findings);
        }
    }
}
