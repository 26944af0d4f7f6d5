//! The unit of an export: stated by the caller, stated by the file, or inferred.

use mocap::scene::{Node, NodeKind};
use mocap::{Code, Conversion, Exporter, Format, FormatInfo, Importer, Pose, Scene, SkeletonMesh};

const WALK: &str = "../../fixtures/real/cmu_12_01_walk.bvh";

fn warned(written: &mocap::Export) -> Vec<String> {
    let warnings = written.warnings.iter();
    let of_unit = warnings.filter(|warning| warning.code == Code::UnknownUnit);
    of_unit.map(|warning| warning.message.clone()).collect()
}

/// Reads a file back. Returns the height of the head in frame 30, and the scene.
fn height_in(bytes: &[u8], row: &FormatInfo) -> (f32, Scene) {
    let name = format!("walk.{}", row.extensions[0]);
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::None);
    let mut scene = importer.read(bytes, &name).unwrap();
    // The reader of a written file states the unit.
    assert!(
        scene.metadata.metres_per_unit.is_some() || row.keeps_units(),
        "{}",
        row.name
    );
    let read = scene.clone();
    Conversion::new().apply(&mut scene).unwrap();
    let head = scene
        .nodes
        .iter()
        .position(|node| node.name.eq_ignore_ascii_case("head"));
    let pose = Pose::at_tick(&scene, 0, scene.animations[0].ticks_per_second / 4.0).unwrap();
    (pose.node_to_world[head.expect(row.name)].w_axis.y, read)
}

/// Exports a walk from a file without a unit, without a conversion by the caller. In every format with a unit, the head
/// is at the height of a person's head. The bytes equal an export after a conversion by the caller.
#[test]
fn a_walk_that_nobody_converts_has_the_size_of_a_person() {
    let walk = Importer::new().skeleton_mesh(SkeletonMesh::None).import(WALK).unwrap();
    let mut converted = walk.clone();
    Conversion::new().apply(&mut converted).unwrap();
    let mut tried = Vec::new();
    let rows = FormatInfo::ALL.iter().filter(|row| row.writes() && !row.keeps_units());
    for row in rows {
        let Ok(of_converted) = Exporter::new().write(&converted, row.format) else {
            continue;
        };
        assert_eq!(warned(&of_converted), [""; 0], "{}", row.name);
        let written = Exporter::new().write(&walk, row.format).unwrap();
        let [unit, up] = &warned(&written)[..] else {
            panic!("{}: {:?}", row.name, written.warnings)
        };
        assert!(unit.starts_with("inferred unit: cmu, because "), "{unit}");
        assert!(up.starts_with("inferred up: y, because "), "{up}");
        let (bytes, expected) = (written.into_bytes().unwrap(), of_converted.into_bytes().unwrap());
        assert!(
            bytes == expected,
            "{}: other bytes than those of a converted scene",
            row.name
        );
        // Markers and models of MikuMikuDance have no joint with this name.
        if matches!(row.format, Format::Gltf | Format::Fbx | Format::Usd | Format::Mclip) {
            let (height, read) = height_in(&bytes, row);
            assert!((1.3..1.8).contains(&height), "{}: the head is at {height} m", row.name);
            if row.format == Format::Gltf {
                let recorded = std::str::from_utf8(&bytes[20..]).map_or_else(
                    |error| String::from_utf8_lossy(&bytes[20..20 + error.valid_up_to()]).into_owned(),
                    str::to_owned,
                );
                assert!(recorded.contains("\"topic\":\"unit\""), "the guess is not recorded");
                assert_eq!(read.metadata.metres_per_unit, Some(1.0));
            }
        }
        tried.push(row.name);
    }
    assert!(tried.len() >= 3, "{tried:?}");
}

#[test]
fn what_the_caller_or_the_file_states_stays() {
    let exporter = Exporter::new();
    let bytes = |scene: &Scene, format| exporter.write(scene, format).unwrap().into_bytes().unwrap();
    let walk = Importer::new().skeleton_mesh(SkeletonMesh::None).import(WALK).unwrap();
    let mut kept = walk.clone();
    Conversion::new().keep_units(true).apply(&mut kept).unwrap();
    // BVH has no unit: nothing is inferred, and the numbers stay.
    assert_eq!(warned(&exporter.write(&walk, Format::Bvh).unwrap()), [""; 0]);
    assert!(bytes(&walk, Format::Bvh) == bytes(&kept, Format::Bvh));
    // A caller who keeps the unit gets the numbers of the file.
    let raw = exporter.write(&kept, Format::Gltf).unwrap();
    assert_eq!(
        warned(&raw),
        ["glTF is in metres, but the unit of the scene is not stated"]
    );
    let raw = Importer::new().read(&raw.into_bytes().unwrap(), "raw.glb").unwrap();
    let first = |scene: &Scene| scene.animations[0].channels[0].position_keys.values[0];
    assert!(first(&raw).abs_diff_eq(first(&walk), 1e-4));
    // A caller who states that the unit is 1 m also gets the numbers of the file.
    let mut stated = walk.clone();
    stated.metadata.metres_per_unit = Some(1.0);
    let stated = exporter.write(&stated, Format::Gltf).unwrap();
    assert_eq!(warned(&stated), [""; 0]);
    let stated = Importer::new()
        .read(&stated.into_bytes().unwrap(), "stated.glb")
        .unwrap();
    assert!(first(&stated).abs_diff_eq(first(&walk), 1e-4));
    // For a format in metres, the stated unit of the scene is converted. Only the up axis is inferred.
    let mut inches = walk.clone();
    inches.metadata.metres_per_unit = Some(0.0254);
    inches.metadata.up = Some(mocap::scene::UpAxis::Y);
    let inches = exporter.write(&inches, Format::Gltf).unwrap();
    assert_eq!(warned(&inches), [""; 0]);
    let inches = Importer::new()
        .read(&inches.into_bytes().unwrap(), "inches.glb")
        .unwrap();
    assert!(first(&inches).abs_diff_eq(first(&walk) * 0.0254, 1e-4));
    // A scene that was not read from a file is written unchanged, with a warning.
    let bone = |name: &str, parent, y| Node {
        name: name.to_owned(),
        parent,
        kind: NodeKind::Joint,
        transform: mocap::glam::Mat4::from_translation(mocap::glam::Vec3::new(0.0, y, 0.0)),
        ..Node::default()
    };
    let made = Scene {
        nodes: vec![
            bone("a", None, 0.0),
            bone("b", Some(mocap::scene::NodeId::new(0)), 40.0),
        ],
        ..Scene::default()
    };
    let written = exporter.write(&made, Format::Gltf).unwrap();
    assert_eq!(
        warned(&written),
        ["glTF is in metres, but the unit of the scene is not stated"]
    );
    let read = Importer::new()
        .read(&written.into_bytes().unwrap(), "made.glb")
        .unwrap();
    assert_eq!(read.nodes[1].transform.w_axis.y, 40.0);
}
