//! Tests that a reader reads every written file and `verify` accepts it. `tools/fuzz` tests the same law with changed
//! files. The files here once broke this law.

use std::path::{Path, PathBuf};

use mocap::glam::{Mat4, Vec3, Vec4};
use mocap::scene::{NodeKind, UpAxis};
use mocap::verify::report::Verification;
use mocap::vrma::VrmaOptions;
use mocap::{Code, Conversion, Exporter, Format, FormatInfo, Importer, Scene, SkeletonMesh, Trs};
use serde_json::{Value, json};

use crate::sample::Sample;

/// The largest error of a correct file, in metres.
const CLOSE: f64 = 1e-5;

/// A file of a scene in metres, which `verify` accepts.
#[track_caller]
fn accepted(source: &Scene, format: Format) -> Vec<u8> {
    let mut scene = source.clone();
    Conversion::new().apply(&mut scene).unwrap();
    let bytes = Exporter::new().write(&scene, format).unwrap().into_bytes().unwrap();
    let verified = Verification::of(source, &bytes).unwrap();
    assert!(verified.is_within(CLOSE), "{format}: {verified:?}");
    bytes
}

/// Tries every readable fixture in every written format: the fixture is refused with a reason, or the file is read and
/// accepted. Tries a sample, unless `MOCAP_ALL` is set.
#[test]
fn every_fixture_is_refused_with_a_reason_or_written_and_accepted() {
    /// The stride between the tried files.
    const PARTS: usize = 12;
    /// The largest number of bytes of a file, and of joints times frames. Larger files take too long here.
    const LARGEST: u64 = 1 << 20;
    const MOST_ROWS: f64 = 8000.0;
    let root = Path::new("../../fixtures");
    let mut files: Vec<PathBuf> = ["characters", "dialects", "made", "real", "skeletons"]
        .into_iter()
        .flat_map(|folder| std::fs::read_dir(root.join(folder)).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| mocap::Importer::new().import(path).is_ok() && path.metadata().unwrap().len() <= LARGEST)
        .collect();
    files.sort();
    let mut tried = 0;
    for path in Sample::new().some(files, PARTS) {
        let source = Importer::new().skeleton_mesh(SkeletonMesh::None).import(&path).unwrap();
        let rows: f64 = source.animations.iter().map(|clip| clip.duration).sum::<f64>() * source.nodes.len() as f64;
        if rows > MOST_ROWS || !source.warnings.is_empty() {
            continue;
        }
        for format in [Format::Gltf, Format::Vrma, Format::Fbx, Format::Bvh, Format::Mclip] {
            tried += usize::from(is_accepted(&source, format, &path));
        }
    }
    assert!(tried > 0, "no file was written");
}

/// Without a motion, a robot is compared like any other file, in each format that accepts it.
#[test]
fn a_robot_that_stands_is_written_and_accepted() {
    for file in ["h1.urdf", "g1_29dof_rev_1_0_nomesh.xml"] {
        let path = Path::new("../../fixtures/robots").join(file);
        let source = Importer::new().import(&path).unwrap();
        assert!(is_accepted(&source, Format::Gltf, &path), "{file}");
        for format in [Format::Fbx, Format::Bvh, Format::Usd] {
            is_accepted(&source, format, &path);
        }
    }
}

/// Whether a scene is written. If it is written, it must be accepted.
fn is_accepted(source: &Scene, format: Format, path: &Path) -> bool {
    let mut scene = source.clone();
    if Conversion::new().apply(&mut scene).is_err() {
        return false;
    }
    let written = match Exporter::new().max_error(1e-5).write(&scene, format) {
        Ok(written) => written,
        Err(error) => {
            let reasons = [
                Code::Unrepresentable,
                Code::NoMotion,
                Code::NotHumanoid,
                Code::ErrorBound,
            ];
            assert!(reasons.contains(&error.code()), "{}, {format}: {error}", path.display());
            return false;
        }
    };
    // Data that a format cannot hold is reported. Data besides the motion is not compared.
    let is_whole = written
        .warnings
        .iter()
        .all(|warning| warning.code == Code::NotCarriedOver);
    let bytes = written.into_bytes().unwrap();
    let name = format!("written.{}", FormatInfo::of(format).extensions[0]);
    let again = Importer::new().format(format).read(&bytes, name);
    assert!(again.is_ok(), "{}, {format}: {}", path.display(), again.unwrap_err());
    let mut source = source.clone();
    if matches!(format, Format::Bvh | Format::Mclip) {
        // These formats have one clip.
        source.animations.truncate(1);
    }
    let verified = Verification::of(&source, &bytes).unwrap();
    assert!(
        !is_whole || verified.is_within(1e-3),
        "{}, {format}: {verified:?}",
        path.display()
    );
    true
}

/// Markers that are hidden in the first frame are all at one point in this frame, which shows no unit.
#[test]
fn the_unit_is_found_in_later_frames_where_all_joints_start_in_one_point() {
    let text = "HIERARCHY\nROOT Markers\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n\
                JOINT A\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n}\n\
                JOINT B\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n}\n}\n\
                MOTION\nFrames: 4\nFrame Time: 0.01\n\
                0 0 0 5 5 -5 5 5 -5\n0 0 0 10 20 30 40 100 60\n0 0 0 11 20 30 40 101 60\n0 0 0 12 20 30 40 102 60\n";
    let source = Importer::new().read(text.as_bytes(), "markers.bvh").unwrap();
    let mut scene = source.clone();
    scene.convert_units(0.01, UpAxis::Y);
    let bytes = Exporter::new()
        .write(&scene, Format::Bvh)
        .unwrap()
        .into_bytes()
        .unwrap();
    let verified = Verification::of(&source, &bytes).unwrap();
    assert!(verified.is_within(CLOSE), "{verified:?}");
    // A ratio that is no unit is still found.
    scene.convert_units(1.07, UpAxis::Y);
    let bytes = Exporter::new()
        .write(&scene, Format::Bvh)
        .unwrap()
        .into_bytes()
        .unwrap();
    assert!(!Verification::of(&source, &bytes).unwrap().is_within(CLOSE));
}

/// The node of a mesh with a skin is not part of the scene, because its transform has no meaning. The node stays in the
/// file.
#[test]
fn the_node_of_a_mesh_may_stand_beyond_all_positions() {
    let path = "../../fixtures/made/two_bones_textured.gltf".to_owned();
    let mut file: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let nodes = file["nodes"].as_array_mut().unwrap();
    let node = nodes.iter_mut().find(|node| node.get("mesh").is_some()).unwrap();
    for (field, value) in [
        ("translation", json!([3e38, 1, 3e38])),
        ("scale", json!([3e38, 1e-30, 1])),
    ] {
        node[field] = value;
    }
    let bytes = serde_json::to_vec(&file).unwrap();
    let source = Importer::new().gltf_meshes(true).read(&bytes, "a.gltf").unwrap();
    let written = accepted(&source, Format::Gltf);
    assert!(Importer::new().read(&written, "a.glb").is_ok());
}

/// A single marker has no link whose length shows the unit. The distance from the origin shows it.
#[test]
fn the_unit_of_a_single_joint_is_found() {
    let text = "HIERARCHY\nROOT A\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n}\n\
                MOTION\nFrames: 3\nFrame Time: 0.01\n5 5 -5\n10 20 30\n11 20 31\n";
    let source = Importer::new().read(text.as_bytes(), "marker.bvh").unwrap();
    for (unit, is_right) in [(0.01, true), (0.0254, true), (0.37, false)] {
        let mut scene = source.clone();
        scene.convert_units(unit, UpAxis::Y);
        let bytes = Exporter::new()
            .write(&scene, Format::Bvh)
            .unwrap()
            .into_bytes()
            .unwrap();
        assert_eq!(
            Verification::of(&source, &bytes).unwrap().is_within(CLOSE),
            is_right,
            "{unit}"
        );
    }
}

/// In BVH, joints have no rotation at rest. If the up axis of a file differs, its joints have other axes.
#[test]
fn another_up_axis_in_bvh_is_no_error() {
    for file in ["z_up_dab", "makehuman_zombie_walk"] {
        accepted(
            &mocap::import(format!("../../fixtures/real/{file}.bvh")).unwrap(),
            Format::Bvh,
        );
    }
}

/// A node with a flat transform still has the rotation of its other axes.
#[test]
fn a_flat_transform_has_a_rotation() {
    // The columns are -X without a length, Y doubled and rotated to +Z, and one axis alone.
    for (matrix, point) in [
        (
            [
                0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0,
            ],
            Vec3::new(1.0, -3.0, 4.0),
        ),
        (
            [
                0.0, 0.0, 0.0, 0.0, 0.0, -2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0,
            ],
            Vec3::new(0.0, -3.0, 0.0),
        ),
        (
            [0.0; 12]
                .into_iter()
                .chain([0.0, 0.0, 5.0, 1.0])
                .collect::<Vec<_>>()
                .try_into()
                .unwrap(),
            Vec3::Z * 5.0,
        ),
    ] {
        let matrix = Mat4::from_cols_array(&matrix);
        let trs = Trs::from_matrix(matrix);
        assert!(trs.rotation.is_normalized(), "{trs:?}");
        assert!(
            trs.matrix().transform_point3(Vec3::new(1.0, 2.0, 3.0)).distance(point) < 1e-5,
            "{trs:?}"
        );
        assert!(trs.matrix().abs_diff_eq(matrix, 1e-5), "{trs:?}");
    }
    let mut source = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    let end = source
        .nodes
        .iter_mut()
        .rfind(|node| node.kind == NodeKind::EndSite)
        .unwrap();
    end.transform.x_axis = Vec4::ZERO;
    accepted(&source, Format::Bvh);
}

#[test]
fn clips_of_several_rates_keep_theirs() {
    let mut source = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    Conversion::new().apply(&mut source).unwrap();
    source.metadata.steps.clear();
    source.metadata.origin = None;
    let mut slow = source.animations[0].clone();
    (slow.name, slow.ticks_per_second) = ("slow".to_owned(), 7.0);
    source.animations.push(slow);
    for format in [Format::Gltf, Format::Fbx] {
        let bytes = Exporter::new().write(&source, format).unwrap().into_bytes().unwrap();
        let verified = Verification::of(&source, &bytes).unwrap();
        assert!(verified.is_within(CLOSE), "{format}: {verified:?}");
        let again = Importer::new().read(&bytes, "again").unwrap();
        if format == Format::Gltf {
            let frames = |scene: &Scene| -> Vec<_> { scene.animations.iter().map(|clip| clip.duration).collect() };
            assert_eq!(frames(&again), frames(&source));
            assert!((again.animations[1].ticks_per_second - 7.0).abs() < 1e-6);
        }
    }
}

#[test]
fn a_scene_without_a_node_is_no_packed_clip() {
    let scene = Scene {
        animations: vec![mocap::scene::Animation {
            ticks_per_second: 30.0,
            ..Default::default()
        }],
        ..Scene::default()
    };
    let error = Exporter::new().write(&scene, Format::Mclip).unwrap_err();
    assert_eq!(error.code(), Code::Unrepresentable, "{error}");
}

/// The rest pose of a VRM animation is its T-pose, even if its legs do not point down.
#[test]
fn a_vrm_animation_is_written_with_the_t_pose_that_it_has() {
    let mut scene = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    Conversion::new().apply(&mut scene).unwrap();
    let (bytes, _) = VrmaOptions::default().write(&scene).unwrap();
    let mut glb = gltf::Glb::from_slice(&bytes).unwrap();
    let mut file: Value = serde_json::from_slice(&glb.json).unwrap();
    for node in file["nodes"].as_array_mut().unwrap() {
        match node["name"].as_str() {
            Some("LeftLeg") => node["translation"] = json!([0.1, -0.3, -0.1]),
            Some("RightForeArm") => node["translation"] = json!([-0.2, -0.05, 0.03]),
            _ => (),
        }
    }
    glb.json = serde_json::to_vec(&file).unwrap().into();
    let source = Importer::new().read(&glb.to_vec().unwrap(), "a.vrma").unwrap();
    accepted(&source, Format::Vrma);
}

/// BVH has no name for an end site, so it is named after its parent.
#[test]
fn end_sites_lose_their_names_in_bvh_and_no_other_joint_does() {
    let mut source = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    let is_end = |node: &&mut mocap::scene::Node| node.kind == NodeKind::EndSite;
    for node in source.nodes.iter_mut().filter(is_end) {
        node.name = node.name.to_uppercase();
    }
    let bytes = accepted(&source, Format::Bvh);
    let text = String::from_utf8(bytes).unwrap();
    let renamed = text.replace("JOINT LeftForeArm", "JOINT leftforearm");
    let verified = Verification::of(&source, renamed.as_bytes()).unwrap();
    assert!(!verified.is_within(CLOSE), "{verified:?}");
}

/// The key times of a file were changed after its frame time was stated. The motion is still complete.
#[test]
fn a_frame_time_longer_than_the_motion_is_not_believed() {
    let mut scene = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    Conversion::new().apply(&mut scene).unwrap();
    let bytes = Exporter::new()
        .write(&scene, Format::Gltf)
        .unwrap()
        .into_bytes()
        .unwrap();
    let mut glb = gltf::Glb::from_slice(&bytes).unwrap();
    let mut file: Value = serde_json::from_slice(&glb.json).unwrap();
    file["asset"]["extras"]["mocap"]["frame_time"] = json!(1.0);
    glb.json = serde_json::to_vec(&file).unwrap().into();
    let source = Importer::new().read(&glb.to_vec().unwrap(), "a.glb").unwrap();
    assert_eq!(source.animations[0].frame_count(), 75);
    accepted(&source, Format::Bvh);
}

/// A VRM animation has a hand although its source has none. A joint with this name, or nearly this name, is no bone if
/// the source states its bones without this joint.
#[test]
fn a_joint_that_is_no_bone_of_a_vrm_animation_is_not_compared() {
    let mut scene = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    Conversion::new().apply(&mut scene).unwrap();
    let (bytes, _) = VrmaOptions::default().write(&scene).unwrap();
    for name in ["RightHand", "rightHand"] {
        let mut glb = gltf::Glb::from_slice(&bytes).unwrap();
        let mut file: Value = serde_json::from_slice(&glb.json).unwrap();
        let bones = &mut file["extensions"]["VRMC_vrm_animation"]["humanoid"]["humanBones"];
        let hand = bones.as_object_mut().unwrap().remove("rightHand").unwrap();
        let hand = hand["node"].as_u64().unwrap() as usize;
        file["nodes"][hand]["name"] = json!(name);
        glb.json = serde_json::to_vec(&file).unwrap().into();
        let source = Importer::new().read(&glb.to_vec().unwrap(), "a.vrma").unwrap();
        let written = accepted(&source, Format::Vrma);
        // A missing bone of the file is still found.
        let mut glb = gltf::Glb::from_slice(&written).unwrap();
        let mut file: Value = serde_json::from_slice(&glb.json).unwrap();
        let hand = file["nodes"]
            .as_array()
            .unwrap()
            .iter()
            .position(|node| node["name"] == "LeftHand");
        let channels = file["animations"][0]["channels"].as_array_mut().unwrap();
        let before = channels.len();
        channels.retain(|channel| channel["target"]["node"] != json!(hand.unwrap()));
        assert_eq!(channels.len(), before - 1);
        glb.json = serde_json::to_vec(&file).unwrap().into();
        let verified = Verification::of(&source, &glb.to_vec().unwrap()).unwrap();
        assert!(!verified.is_within(CLOSE), "{verified:?}");
    }
}

#[test]
fn the_armature_that_fbx_adds_above_the_skeleton_is_no_other_joint() {
    let source = Importer::new()
        .skeleton_mesh(SkeletonMesh::None)
        .import("../../fixtures/real/cmu_short.bvh")
        .unwrap();
    let bytes = accepted(&source, Format::Fbx);
    let verified = Verification::of(&source, &bytes).unwrap();
    assert_eq!(verified.findings, []);
    let again = Importer::new().read(&bytes, "written.fbx").unwrap();
    let is_added = |scene: &Scene| scene.nodes.iter().any(|node| node.name == "Armature");
    assert!(is_added(&again) && !is_added(&source));
}

/// A glTF file of two joints. Its clip has keys at the times `seconds`. A frame takes 0.1 s.
fn keyed(name: &str, seconds: &[f32]) -> Scene {
    use base64::Engine;
    let places = seconds.iter().flat_map(|second| [*second, 1.0 + second * second, 0.0]);
    let bytes: Vec<u8> = (seconds.iter().copied().chain(places))
        .flat_map(f32::to_le_bytes)
        .collect();
    let (count, uri) = (seconds.len(), base64::engine::general_purpose::STANDARD.encode(&bytes));
    let file = json!({
        "asset": { "version": "2.0", "extras": { "mocap": { "frame_time": 0.1 } } },
        "nodes": [{ "name": "hip", "children": [1] }, { "name": "knee", "translation": [0, -0.5, 0] }],
        "animations": [{
            "name": name, "samplers": [{ "input": 0, "output": 1 }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
        }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": count, "type": "SCALAR" },
            { "bufferView": 1, "componentType": 5126, "count": count, "type": "VEC3" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 4 * count },
            { "buffer": 0, "byteOffset": 4 * count, "byteLength": 12 * count },
        ],
        "buffers": [{ "byteLength": bytes.len(), "uri": format!("data:application/octet-stream;base64,{uri}") }],
    });
    Importer::new().read(file.to_string().as_bytes(), "a.gltf").unwrap()
}

/// A file with a pose for each frame ends at the frame nearest to the end of its source. The motion of the source
/// between two frames is not in the file.
#[test]
fn a_motion_that_ends_between_two_frames_ends_at_the_nearer_one() {
    for (end, frames) in [(0.33, 4), (0.37, 5), (0.3996, 5)] {
        let source = keyed("walk", &[0.0, 0.1, 0.2, 0.3, end]);
        assert_eq!(source.animations[0].frame_count(), frames, "{end}");
        for format in [Format::Bvh, Format::Fbx, Format::Trc] {
            let bytes = accepted(&source, format);
            let name = format!("again.{}", FormatInfo::of(format).extensions[0]);
            let again = Importer::new().read(&bytes, name).unwrap();
            assert_eq!(again.animations[0].frame_count(), frames, "{format}: {end}");
            // The last pose equals the source's last pose, and is compared.
            let channels = &again.animations[0].channels;
            let hip = channels.iter().find(|channel| channel.node_name == "hip").unwrap();
            let last =
                hip.position_keys.values.last().unwrap().y * again.metadata.metres_per_unit.unwrap_or(1.0) as f32;
            let at_end = if frames == 5 { 1.0 + end * end } else { 1.09 };
            assert!((last - at_end).abs() < 1e-4, "{format}: {end}: {last}");
            let mut other = source.clone();
            other.animations[0].channels[0]
                .position_keys
                .values
                .iter_mut()
                .skip(frames - 1)
                .for_each(|key| key.x += 0.1);
            assert!(
                !Verification::of(&other, &bytes).unwrap().is_within(1e-3),
                "{format}: {end}"
            );
        }
        // These formats keep the times of keys.
        for format in [Format::Gltf, Format::Usd] {
            accepted(&source, format);
        }
    }
}

/// FBX separates names by two control characters, so its names cannot contain them.
#[test]
fn a_clip_keeps_its_name_but_for_control_characters() {
    for (name, is_renamed) in [
        ("a\u{7f}b", false),
        ("a\u{1}b", false),
        ("walk", false),
        ("walked", true),
    ] {
        let source = keyed(name, &[0.0, 0.1, 0.2]);
        let mut bytes = accepted(&source, Format::Fbx);
        if is_renamed {
            while let Some(place) = bytes.windows(name.len()).position(|window| window == name.as_bytes()) {
                bytes[place] = b'b';
            }
        }
        let verified = Verification::of(&source, &bytes).unwrap();
        assert_eq!(!verified.findings.is_empty(), is_renamed, "{name:?}: {verified:?}");
    }
}

/// A rest pose with sheared axes has a rotation by a formula that depends on rounding. In single precision, this
/// rotation is 90 degrees from the result in double precision.
#[test]
fn a_rest_pose_that_shears_has_one_rotation_in_every_format() {
    let path = "../../tools/fuzz/corpus/usda/rest_that_shears_much";
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::None);
    let source = importer.read(&std::fs::read(path).unwrap(), "a.usda").unwrap();
    let written = |source: &Scene, format| {
        let mut scene = source.clone();
        Conversion::new().apply(&mut scene).unwrap();
        Exporter::new().write(&scene, format).unwrap().into_bytes().unwrap()
    };
    let accepted = |source: &Scene, bytes: &[u8]| {
        let verified = Verification::of(source, bytes).unwrap();
        assert!(verified.is_within(1e-3), "{verified:?}");
    };
    accepted(&source, &written(&source, Format::Usd));
    // The glTF file and the FBX file have the same joint matrices.
    let glb = importer.read(&written(&source, Format::Gltf), "a.glb").unwrap();
    let fbx = importer.read(&written(&source, Format::Fbx), "a.fbx").unwrap();
    let of_joints = |scene: &Scene| -> Vec<(String, Mat4)> {
        let world = mocap::Pose::at_tick(scene, 0, 0.0).unwrap().node_to_world;
        let nodes = scene.nodes.iter().zip(world);
        let joints = nodes.filter(|(node, _)| node.kind != NodeKind::Group);
        joints.map(|(node, world)| (node.name.clone(), world)).collect()
    };
    let (glb, fbx) = (of_joints(&glb), of_joints(&fbx));
    assert!(glb.len() > 2 && glb.len() == fbx.len(), "{glb:?}, {fbx:?}");
    for ((name, a), (other, b)) in std::iter::zip(glb, fbx) {
        assert!(name == other && a.abs_diff_eq(b, 1e-3), "{name}: {a}, {other}: {b}");
    }
}

/// Only descendants distinguish a joint from the node of a mesh if both lack a name. The same applies to a joint and a
/// group without names.
#[test]
fn joints_without_names_between_other_nodes_are_paired_by_what_is_below_them() {
    let meshes = "../../fixtures/made/unnamed_joints_between_meshes.gltf";
    for keeps_meshes in [false, true] {
        let source = Importer::new().gltf_meshes(keeps_meshes).import(meshes).unwrap();
        accepted(&source, Format::Gltf);
    }
    let mut source = Scene::default();
    let (group, joint) = (NodeKind::Group, NodeKind::Joint);
    let nodes = [
        (group, None),
        (group, Some(0)),
        (joint, Some(0)),
        (joint, Some(2)),
        (group, Some(0)),
        (joint, Some(0)),
        (joint, Some(5)),
        (joint, Some(6)),
    ];
    for (index, (kind, parent)) in nodes.into_iter().enumerate() {
        source.nodes.push(mocap::scene::Node {
            kind,
            parent: parent.map(mocap::scene::NodeId::new),
            transform: Mat4::from_translation(Vec3::X * index as f32),
            ..mocap::scene::Node::default()
        });
    }
    source.metadata.metres_per_unit = Some(1.0);
    source.metadata.up = Some(UpAxis::Y);
    accepted(&source, Format::Gltf);
}
