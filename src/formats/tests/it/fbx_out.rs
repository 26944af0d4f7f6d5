//! Scenes as FBX: ufbx reads the same motion back.

use std::fs;
use std::path::{Path, PathBuf};

use crate::sample::Sample;
use mocap::fbx::{FbxOptions, FbxRest, FbxRoot, FbxTarget, FbxTextures, FbxVersion};
use mocap::glam::{DVec3, EulerRot, Mat4, Quat, Vec2, Vec3};
use mocap::retarget::{PoseRetargetOptions, PoseRetargeter};
use mocap::scene::{Animation, Channel, Keys, Node, NodeId, NodeKind, RotationOrder, Scene, UpAxis};
use mocap::verify::Verifier;
use mocap::{Code, Conversion, Importer, Pose, SkeletonMesh};

fn read(bytes: &[u8]) -> Scene {
    Importer::new()
        .skeleton_mesh(SkeletonMesh::Own)
        .read(bytes, "written.fbx")
        .unwrap()
}

fn import(path: impl AsRef<Path>) -> mocap::Result<Scene> {
    let mut scene = Importer::new()
        .skeleton_mesh(SkeletonMesh::Own)
        .gltf_meshes(true)
        .import(path)?;
    Conversion::new().apply(&mut scene)?;
    Ok(scene)
}

/// Every third motion of the fixtures that can be read.
pub(crate) fn fixtures() -> Vec<(PathBuf, Scene)> {
    let mut found = Vec::new();
    for folder in ["real", "dialects", "skeletons", "characters", "made"] {
        for entry in fs::read_dir(format!("../../fixtures/{folder}")).unwrap() {
            let path = entry.unwrap().path();
            let extension = path.extension().unwrap_or_default().to_str().unwrap();
            if ["bvh", "amc", "c3d", "fbx", "gltf", "glb", "vrm"].contains(&extension) {
                found.push(path);
            }
        }
    }
    found.sort();
    let chosen = Sample::new().some(found, 3).into_iter();
    let read: Vec<_> = chosen
        .filter_map(|path| import(&path).ok().map(|scene| (path, scene)))
        .collect();
    assert!(read.len() > 40, "{}", read.len());
    read
}

/// The largest distance of a node that both scenes have from its position, over all frames, in metres.
fn distance(scene: &Scene, again: &Scene, name: &str) -> f32 {
    let bones = |scene: &Scene| -> Vec<usize> {
        let is_bone = |index: &usize| scene.nodes[*index].kind != NodeKind::Group;
        (0..scene.nodes.len()).filter(is_bone).collect()
    };
    let (ours, theirs) = (bones(scene), bones(again));
    assert_eq!(ours.len(), theirs.len(), "{name}: bones");
    for (&a, &b) in std::iter::zip(&ours, &theirs) {
        assert_eq!(scene.nodes[a].name, again.nodes[b].name, "{name}");
        assert_eq!(scene.nodes[a].kind, again.nodes[b].kind, "{name}");
    }
    assert_eq!(scene.animations.len(), again.animations.len(), "{name}: clips");
    let mut largest = 0.0_f32;
    let mut compare = |here: &Pose, there: &Pose| {
        for (&a, &b) in std::iter::zip(&ours, &theirs) {
            let places = [here.position(NodeId::new(a)), there.position(NodeId::new(b))];
            // Single precision has fewer decimals for positions far from the origin.
            let far = places[0].abs().max_element().max(10.0) / 10.0;
            largest = largest.max(places[0].distance(places[1]) / far);
        }
    };
    compare(&Pose::rest(scene), &Pose::rest(again));
    for (clip, (ours, theirs)) in std::iter::zip(&scene.animations, &again.animations).enumerate() {
        assert_eq!(ours.frame_count(), theirs.frame_count(), "{name}");
        assert_eq!(ours.ticks_per_second, theirs.ticks_per_second, "{name}");
        let step = (ours.frame_count() / 100).max(1);
        for frame in (0..ours.frame_count()).step_by(step) {
            let pose = |scene: &Scene| Pose::at_tick(scene, clip, frame as f64).unwrap();
            compare(&pose(scene), &pose(again));
        }
    }
    largest
}

#[test]
fn every_fixture_comes_back() {
    for (path, scene) in fixtures() {
        let (bytes, report) = FbxOptions::default().write(&scene).unwrap();
        assert_eq!(report.bytes, bytes.len());
        let again = read(&bytes);
        let name = path.display().to_string();
        let off = distance(&scene, &again, &name);
        assert!(off < 5e-5, "{name}: {off}");
    }
}

/// A joint that rotates about all axes beyond a full turn, in each order, at a frame rate that is not a whole number.
fn spinning() -> Scene {
    let turn = |frame: usize, order: RotationOrder| {
        let order = match order {
            RotationOrder::Xyz => EulerRot::XYZ,
            RotationOrder::Xzy => EulerRot::XZY,
            RotationOrder::Yxz => EulerRot::YXZ,
            RotationOrder::Yzx => EulerRot::YZX,
            RotationOrder::Zxy => EulerRot::ZXY,
            RotationOrder::Zyx => EulerRot::ZYX,
        };
        let angle = |degrees: f32| (frame as f32 * degrees).to_radians();
        Quat::from_euler(order, angle(9.0), 0.5 * angle(7.0).sin(), angle(-5.0))
    };
    let mut scene = Scene::default();
    let mut channels = Vec::new();
    for (index, order) in RotationOrder::ALL.into_iter().enumerate() {
        let rest = Mat4::from_rotation_translation(Quat::from_rotation_z(0.3), Vec3::new(0.1, 0.2, 0.0));
        scene.nodes.push(Node {
            name: format!("{order:?}"),
            parent: index.checked_sub(1).map(NodeId::new),
            transform: rest,
            rotation_order: Some(order),
            ..Node::default()
        });
        channels.push(Channel {
            node_name: format!("{order:?}"),
            rotation_keys: Keys::every_tick((0..200).map(|frame| turn(frame, order)).collect()),
            ..Channel::default()
        });
    }
    scene.animations.push(Animation {
        name: "spin".to_owned(),
        ticks_per_second: 29.97,
        duration: 199.0,
        channels,
    });
    scene.metadata.metres_per_unit = Some(1.0);
    scene.metadata.up = Some(UpAxis::Y);
    scene
}

#[test]
fn curves_have_exact_times_the_order_of_their_joint_and_no_jumps() {
    let scene = spinning();
    for (rest, up) in [
        (FbxRest::Rotation, UpAxis::Y),
        (FbxRest::PreRotation, UpAxis::Y),
        (FbxRest::Rotation, UpAxis::Z),
    ] {
        let options = FbxOptions::new().rest(rest).up(up);
        let (bytes, report) = options.write(&scene).unwrap();
        assert_eq!((report.curves, report.keys), (18, 18 * 200));
        let file = ufbx::load_memory(&bytes, ufbx::LoadOpts::default()).unwrap();
        assert_eq!(file.settings.frames_per_second, 29.97);
        assert_eq!(file.anim_curves.len(), 18);
        for curve in &file.anim_curves {
            for (frame, key) in curve.keyframes.iter().enumerate() {
                let time = (key.time * 46_186_158_000.0).round();
                assert_eq!(time, (frame as f64 * 46_186_158_000.0 / 29.97).round());
            }
            let jump = |pair: &[ufbx::Keyframe]| (pair[1].value - pair[0].value).abs();
            let largest = curve.keyframes.windows(2).map(jump).fold(0.0, f64::max);
            // With a pre-rotation, the angles differ from the given angles.
            let allowed = if rest == FbxRest::Rotation { 9.001 } else { 100.0 };
            assert!(largest < allowed, "{rest:?} {up:?}: {largest}");
        }
        // The tolerance is for angles beyond a thousand degrees in single precision, over six links.
        let off = distance(&scene, &read(&bytes), "spin");
        assert!(off < 1e-5, "{rest:?} {up:?}: {off}");
        if up == UpAxis::Y {
            for (node, again) in std::iter::zip(&scene.nodes, read(&bytes).nodes.iter().skip(2)) {
                assert_eq!(node.rotation_order, again.rotation_order);
            }
        }
    }
}

#[test]
fn every_choice_gives_the_same_motion() {
    let scene = import("../../fixtures/real/cmu_short.bvh").unwrap();
    let usual = FbxOptions::default();
    let choices = [
        usual.clone().version(FbxVersion::V7400),
        usual.clone().rest(FbxRest::PreRotation),
        usual.clone().root(FbxRoot::None),
        usual.clone().root(FbxRoot::Null("Reference".to_owned())).up(UpAxis::Z),
        usual.clone().metres_per_unit(1.0).up(UpAxis::NegY),
    ];
    for options in choices {
        let (bytes, _) = options.write(&scene).unwrap();
        assert_eq!(options.write(&scene).unwrap().0, bytes);
        let file = ufbx::load_memory(&bytes, ufbx::LoadOpts::default()).unwrap();
        assert_eq!(file.metadata.version == 7400, options.version == FbxVersion::V7400);
        assert_eq!(file.settings.unit_meters, options.metres_per_unit);
        let up = match options.up {
            UpAxis::Y => ufbx::CoordinateAxis::PositiveY,
            UpAxis::Z => ufbx::CoordinateAxis::PositiveZ,
            UpAxis::NegY => ufbx::CoordinateAxis::NegativeY,
            UpAxis::NegZ => ufbx::CoordinateAxis::NegativeZ,
        };
        assert_eq!(file.settings.axes.up, up);
        let above = &file
            .nodes
            .iter()
            .find(|node| &*node.element.name == "Hips")
            .unwrap()
            .parent;
        let above = above.as_ref().unwrap();
        match &options.root {
            FbxRoot::None => assert!(above.is_root),
            FbxRoot::Null(name) => assert_eq!(&*above.element.name, name),
            root => panic!("{root:?}"),
        }
        assert!(distance(&scene, &read(&bytes), "cmu_short") < 1e-5, "{options:?}");
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("a.fbx");
        fs::write(&output, &bytes).unwrap();
        let verified = Verifier::new()
            .files("../../fixtures/real/cmu_short.bvh", &output)
            .unwrap();
        assert!(verified.is_within(5e-5), "{verified:?}");
        assert_eq!((verified.frames, verified.has_provenance), (75, true));
        // Joints with other axes have other rotations, from the first frame on.
        assert!(verified.rotation_error.is_some());
    }
}

/// ufbx evaluates the curves. Blender, Assimp and three.js interpolate rotations between the keys of a joint instead.
/// The axes that move have their keys at the same frames.
#[test]
fn keys_are_left_out_within_the_largest_error() {
    let scene = import("../../fixtures/real/cmu_short.bvh").unwrap();
    let (whole, of_whole) = FbxOptions::default().write(&scene).unwrap();
    for (options, bound) in [
        (FbxOptions::default(), 1e-3),
        (FbxOptions::default(), 1e-4),
        (FbxOptions::of_target(FbxTarget::Unreal), 1e-3),
        (FbxOptions::of_target(FbxTarget::Maya), 1e-3),
    ] {
        let options = options.error_bound(Some(bound.into())).whole_rate(false);
        let (bytes, report) = options.write(&scene).unwrap();
        assert!(report.achieved.as_ref().unwrap().max_error <= bound, "{report:?}");
        if bound == 1e-3 {
            assert!(
                5 * report.keys < 4 * of_whole.keys,
                "{} of {}",
                report.keys,
                of_whole.keys
            );
            assert!(bytes.len() < whole.len(), "{} of {}", bytes.len(), whole.len());
        }
        let again = read(&bytes);
        let off = distance(&scene, &again, "cmu_short");
        assert!(f64::from(off) <= bound + 1e-6, "{options:?}: {off}");
        let interpolated = with_rotations_at_keys_alone(&again, &bytes);
        let off = distance(&scene, &interpolated, "cmu_short");
        assert!(f64::from(off) <= bound + 1e-6, "{options:?}: {off}");
        // An error exists: the writer does not keep the bound by keeping all keys.
        assert!(f64::from(off) > 0.1 * bound, "{options:?}: {off}");
    }
    assert_eq!(of_whole.achieved, None);
}

/// The scene of a file, with its rotations interpolated between the times at which one of their curves has a key.
fn with_rotations_at_keys_alone(scene: &Scene, bytes: &[u8]) -> Scene {
    let file = ufbx::load_memory(bytes, ufbx::LoadOpts::default()).unwrap();
    let mut scene = scene.clone();
    let rate = scene.animations[0].ticks_per_second;
    for value in &file.anim_stacks[0].layers[0].anim_props {
        if &*value.prop_name != "Lcl Rotation" {
            continue;
        }
        let mut ticks: Vec<f64> = vec![0.0];
        for curve in value.anim_value.curves.iter().flatten() {
            ticks.extend(curve.keyframes.iter().map(|key| (key.time * rate).round()));
        }
        ticks.sort_unstable_by(f64::total_cmp);
        ticks.dedup();
        let channels = &mut scene.animations[0].channels;
        let channel = channels
            .iter_mut()
            .find(|channel| channel.node_name == *value.element.name);
        let keys = &mut channel.unwrap().rotation_keys;
        *keys = Keys::at_ticks(ticks.iter().map(|tick| keys.values[*tick as usize]).collect(), ticks);
    }
    scene
}

#[test]
fn a_joint_that_spins_keeps_within_the_largest_error() {
    for bound in [1e-2, 1e-4] {
        let scene = spinning();
        let options = FbxOptions::new().error_bound(Some(bound.into()));
        let (bytes, report) = options.write(&scene).unwrap();
        let off = distance(&scene, &read(&bytes), "spin");
        assert!(f64::from(off) <= bound + 1e-5, "{off}: {report:?}");
    }
}

#[test]
fn a_largest_error_that_cannot_be_kept_is_refused() {
    let mut scene = spinning();
    let of = |bound: f64| FbxOptions::new().error_bound(Some(bound.into()));
    for bound in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = of(bound).write(&scene).unwrap_err();
        assert_eq!(error.code(), Code::InvalidValue, "{bound}");
    }
    let error = of(1e-12).write(&scene).unwrap_err();
    assert_eq!(error.code(), Code::ErrorBound);
    scene.animations[0].channels[0].scaling_keys = Keys::every_tick(vec![Vec3::ONE, Vec3::splat(2.0)]);
    let error = of(1e-3).write(&scene).unwrap_err();
    assert_eq!((error.code(), error.joint()), (Code::Unrepresentable, Some("Xyz")));
}

#[test]
fn verify_finds_a_joint_that_is_elsewhere() {
    let mut scene = import("../../fixtures/real/cmu_short.bvh").unwrap();
    let channel = &mut scene.animations[0].channels[0];
    channel.position_keys.values[40].y += 0.002;
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("a.fbx");
    mocap::Exporter::new().export(&scene, &output).unwrap();
    let verified = Verifier::new()
        .files("../../fixtures/real/cmu_short.bvh", &output)
        .unwrap();
    assert!((verified.max_error - 0.002).abs() < 1e-5, "{verified:?}");
    assert_eq!(verified.worst.unwrap().frame, 40);
}

/// No reader needs the bytes after the last element, but a failed copy lacks them.
#[test]
fn verify_refuses_a_file_without_its_last_bytes() {
    let scene = import("../../fixtures/real/cmu_short.bvh").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("a.fbx");
    for version in [FbxVersion::V7400, FbxVersion::V7500] {
        let options = FbxOptions::new().version(version);
        let (bytes, _) = options.write(&scene).unwrap();
        for cut in [0, 1, 15, 16, 100] {
            fs::write(&output, &bytes[..bytes.len() - cut]).unwrap();
            let verified = Verifier::new().files("../../fixtures/real/cmu_short.bvh", &output);
            match cut {
                0 => assert!(verified.unwrap().is_within(5e-5)),
                _ => assert_eq!(verified.unwrap_err().code(), Code::UnexpectedEnd, "{cut}"),
            }
        }
    }
}

/// A clip is kept, even if it has no tracks, or only the rest rotation of one joint.
#[test]
fn a_clip_in_which_nothing_moves_comes_back() {
    let mut scene = import("../../fixtures/real/cmu_short.bvh").unwrap();
    let rest = Pose::rest(&scene);
    // The node is in the middle of the chain, where rotations and positions differ.
    let node = NodeId::new(4);
    let turned = rest.node_to_parent[node.index()].to_scale_rotation_translation().1;
    let animation = &mut scene.animations[0];
    let mut channel = animation.channels[4].clone();
    channel.node = Some(node);
    channel.node_name.clone_from(&scene.nodes[node.index()].name);
    (channel.position_keys, channel.scaling_keys) = (Keys::default(), Keys::default());
    channel.rotation_keys = Keys::constant(turned);
    animation.duration = 0.0;
    for channels in [Vec::new(), vec![channel]] {
        scene.animations[0].channels = channels;
        let (bytes, _) = FbxOptions::default().write(&scene).unwrap();
        let again = Importer::new().read(&bytes, "a.fbx").unwrap();
        assert_eq!(again.animations.len(), 1);
        let pose = Pose::at_tick(&again, 0, 0.0).unwrap();
        let still = Pose::rest(&again);
        for index in 0..again.nodes.len() {
            let node = NodeId::new(index);
            let off = pose.position(node).distance(still.position(node));
            assert!(off < 1e-4, "{}: {off}", again.nodes[index].name);
        }
    }
}

#[test]
fn names_are_unique_in_the_file_and_come_back() {
    let mut scene = import("../../fixtures/dialects/names_equal.bvh").unwrap();
    let names: Vec<_> = scene.nodes.iter().map(|node| node.name.clone()).collect();
    let last = scene.nodes.len() - 1;
    scene.nodes[last].name = "a\0\u{1}b".to_owned();
    let (bytes, report) = FbxOptions::default().write(&scene).unwrap();
    let file = ufbx::load_memory(&bytes, ufbx::LoadOpts::default()).unwrap();
    let mut found: Vec<_> = file.nodes.iter().map(|node| node.element.name.to_string()).collect();
    let count = found.len();
    found.sort();
    found.dedup();
    assert_eq!(found.len(), count);
    assert!(found.contains(&"a__b".to_owned()), "{found:?}");
    assert!(report.renamed.len() >= 2);
    let again = read(&bytes);
    for (index, name) in names[..last].iter().enumerate() {
        assert_eq!(again.nodes[index + 2].name, *name);
    }
}

#[test]
fn what_cannot_be_written_is_refused() {
    let refusal = |scene: &Scene| FbxOptions::default().write(scene).unwrap_err();
    assert_eq!(refusal(&Scene::default()).code(), Code::Unrepresentable);
    let mut scene = spinning();
    scene.animations[0].channels[2].rotation_keys.values[7] = Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0);
    assert_eq!(
        refusal(&scene).diagnostic().message,
        "the quaternion at tick 7 is not a rotation"
    );
    let mut scene = spinning();
    scene.animations[0].ticks_per_second = 0.0;
    assert_eq!(refusal(&scene).code(), Code::FrameTime);
    let mut scene = spinning();
    scene.nodes[3].transform.w_axis.y = f32::INFINITY;
    assert_eq!(refusal(&scene).code(), Code::Unrepresentable);
    let options = FbxOptions::new().metres_per_unit(0.0);
    let error = options.write(&spinning()).unwrap_err();
    assert_eq!(
        error.diagnostic().message,
        "metres per unit must be finite and above 0, got 0"
    );
}

/// The positions of the vertices of all meshes in a pose, in metres.
fn skinned(scene: &Scene, pose: &Pose) -> Vec<Vec3> {
    let mut places = Vec::new();
    for mesh in &scene.meshes {
        let mut moved = vec![DVec3::ZERO; mesh.vertices.len()];
        for bone in &mesh.bones {
            let matrix = pose.node_to_world[bone.node.index()].as_dmat4() * bone.offset_matrix.as_dmat4();
            for tie in &bone.weights {
                let vertex = mesh.vertices[tie.vertex_id as usize].as_dvec3();
                moved[tie.vertex_id as usize] += f64::from(tie.weight) * matrix.transform_point3(vertex);
            }
        }
        places.extend(moved.into_iter().map(DVec3::as_vec3));
    }
    places
}

/// The corners of all faces, each with its position, its texture coordinates and its material.
fn corners(scene: &Scene, pose: &Pose) -> Vec<(Vec3, Vec2, String)> {
    let places = skinned(scene, pose);
    let mut corners = Vec::new();
    let mut start = 0;
    for mesh in &scene.meshes {
        let material = &scene.materials[mesh.material_index].name;
        for &vertex in &mesh.indices {
            let coords = mesh.texture_coords.get(vertex as usize).copied();
            corners.push((
                places[start + vertex as usize],
                coords.unwrap_or_default(),
                material.clone(),
            ));
        }
        start += mesh.vertices.len();
    }
    corners
}

/// FBX is read, written and read again, and gives the same scene.
#[test]
fn fbx_files_come_back_whole() {
    for path in [
        "real/run.fbx",
        "real/huesitos.fbx",
        "real/animation_with_skeleton.fbx",
        "characters/arnaud.fbx",
        "made/tiny.fbx",
    ] {
        let scene = import(format!("../../fixtures/{path}")).unwrap();
        let again = read(&FbxOptions::default().write(&scene).unwrap().0);
        assert_eq!(again.nodes.len(), scene.nodes.len(), "{path}");
        for (ours, theirs) in std::iter::zip(&scene.nodes, &again.nodes) {
            assert_eq!(
                (&ours.name, ours.kind, ours.parent),
                (&theirs.name, theirs.kind, theirs.parent),
                "{path}"
            );
            assert_eq!(ours.rotation_order, theirs.rotation_order, "{path}: {}", ours.name);
            assert!(
                ours.transform.abs_diff_eq(theirs.transform, 2e-4),
                "{path}: {}",
                ours.name
            );
        }
        assert_eq!(again.meshes.len(), scene.meshes.len(), "{path}");
        for (ours, theirs) in std::iter::zip(&scene.meshes, &again.meshes) {
            assert_eq!(ours.name, theirs.name, "{path}");
            assert_eq!(ours.indices, theirs.indices, "{path}: {}", ours.name);
            assert_eq!(ours.material_index, theirs.material_index, "{path}: {}", ours.name);
            let far = ours
                .vertices
                .iter()
                .map(|vertex| vertex.abs().max_element())
                .fold(1.0, f32::max);
            for (a, b) in std::iter::zip(&ours.vertices, &theirs.vertices) {
                assert!(a.abs_diff_eq(*b, 2e-6 * far), "{path}: {a} {b}");
            }
            for (a, b) in std::iter::zip(&ours.normals, &theirs.normals) {
                assert!(a.abs_diff_eq(*b, 1e-6), "{path}: {a} {b}");
            }
            for (a, b) in std::iter::zip(&ours.texture_coords, &theirs.texture_coords) {
                assert!(a.abs_diff_eq(*b, 1e-6), "{path}: {a} {b}");
            }
            assert_eq!(ours.texture_coords.len(), theirs.texture_coords.len());
            assert_eq!(ours.bones.len(), theirs.bones.len(), "{path}");
            for (a, b) in std::iter::zip(&ours.bones, &theirs.bones) {
                assert_eq!((&a.name, a.node), (&b.name, b.node), "{path}");
                assert!(
                    a.offset_matrix.abs_diff_eq(b.offset_matrix, 1e-4 * far),
                    "{path}: {}",
                    a.name
                );
                assert_eq!(a.weights.len(), b.weights.len(), "{path}: {}", a.name);
                for (a, b) in std::iter::zip(&a.weights, &b.weights) {
                    assert_eq!(a.vertex_id, b.vertex_id);
                    assert!((a.weight - b.weight).abs() < 1e-6);
                }
            }
        }
        assert_eq!(again.materials.len(), scene.materials.len(), "{path}");
        for (ours, theirs) in std::iter::zip(&scene.materials, &again.materials) {
            assert_eq!((&ours.name, ours.two_sided), (&theirs.name, theirs.two_sided), "{path}");
            assert_eq!(ours.surface.is_some(), theirs.surface.is_some(), "{path}");
            if let (Some(ours), Some(theirs)) = (ours.surface, theirs.surface) {
                assert!(
                    ours.base_color.abs_diff_eq(theirs.base_color, 1e-6),
                    "{path}: {ours:?} {theirs:?}"
                );
                assert_eq!((ours.texture, ours.alpha), (theirs.texture, theirs.alpha), "{path}");
            }
        }
        assert_eq!(again.textures, scene.textures, "{path}");
        assert!(distance(&scene, &again, path) < 1e-5, "{path}");
    }
}

/// A motion on characters: every corner of every face has the position that it has in the GLB.
#[test]
fn characters_move_as_their_glb_does() {
    for (name, textures) in [
        ("human_default.glb", 0),
        ("human_game_engine.glb", 0),
        ("human_vrm0.vrm", 0),
        ("human_vrm1.glb", 0),
    ] {
        let path = format!("../../fixtures/characters/{name}");
        let Ok(mut scene) = import(&path) else { continue };
        assert!(scene.textures.len() >= textures);
        let mut source = import("../../fixtures/real/cmu_short.bvh").unwrap();
        source.animations.truncate(1);
        let mut retargeter = PoseRetargeter::new(&source, &scene, &PoseRetargetOptions::default()).unwrap();
        let (clip, _) = retargeter.clip(&source, 0, &scene, false).unwrap();
        scene.animations = vec![clip];
        let (bytes, report) = FbxOptions::default().write(&scene).unwrap();
        assert!(report.vertices > 1000, "{name}");
        let again = read(&bytes);
        assert_eq!(again.warnings, [], "{name}");
        for frame in [0.0, 37.0, 74.0] {
            let here = corners(&scene, &Pose::at_tick(&scene, 0, frame).unwrap());
            let there = corners(&again, &Pose::at_tick(&again, 0, frame).unwrap());
            assert_eq!(here.len(), there.len(), "{name}");
            let off = std::iter::zip(&here, &there)
                .map(|(a, b)| a.0.distance(b.0))
                .fold(0.0, f32::max);
            assert!(off < 5e-5, "{name}: {off}");
            assert!(
                std::iter::zip(&here, &there).all(|(a, b)| a.1.abs_diff_eq(b.1, 1e-5) && a.2 == b.2),
                "{name}"
            );
        }
    }
}

#[test]
fn textures_are_embedded() {
    let scene = import("../../fixtures/made/two_bones_textured.gltf").unwrap();
    let (bytes, report) = FbxOptions::default().write(&scene).unwrap();
    assert_eq!((report.textures, scene.textures.len()), (1, 1));
    let again = read(&bytes);
    assert_eq!(again.warnings, []);
    assert_eq!(again.textures[0].bytes, scene.textures[0].bytes);
    assert_eq!(again.meshes[0].texture_coords.len(), again.meshes[0].vertices.len());
}

#[test]
fn names_of_textures_are_names_of_files() {
    let mut scene = import("../../fixtures/made/two_bones_textured.gltf").unwrap();
    for (name, file) in [
        ("skin", "skin.png"),
        ("../../up\\..\\Skin.png", "Skin.png"),
        ("..", "texture.png"),
        ("con", "_con.png"),
        ("a:b?\u{7}", "a_b__.png"),
        (" .x. ", "x.png"),
        ("", "texture.png"),
    ] {
        scene.textures[0].name = name.to_owned();
        let options = FbxOptions::new().textures(FbxTextures::Beside);
        let (_, report) = options.write(&scene).unwrap();
        assert_eq!(report.beside, [(file.to_owned(), 0)], "{name:?}");
    }
}

#[test]
fn targets_have_their_unit_axes_root_and_rate() {
    let scene = import("../../fixtures/real/cmu_short.bvh").unwrap();
    for (target, unit, up, above, rate) in [
        (FbxTarget::Unreal, 0.01, ufbx::CoordinateAxis::PositiveZ, "", 120.0),
        (
            FbxTarget::Unity,
            1.0,
            ufbx::CoordinateAxis::PositiveY,
            "Armature",
            1.0 / 0.008_333_3,
        ),
        (
            FbxTarget::Maya,
            0.01,
            ufbx::CoordinateAxis::PositiveY,
            "Armature",
            1.0 / 0.008_333_3,
        ),
        (
            FbxTarget::MotionBuilder,
            0.01,
            ufbx::CoordinateAxis::PositiveY,
            "Reference",
            120.0,
        ),
    ] {
        let (bytes, _) = FbxOptions::of_target(target).write(&scene).unwrap();
        let file = ufbx::load_memory(&bytes, ufbx::LoadOpts::default()).unwrap();
        assert_eq!(
            (file.settings.unit_meters, file.settings.axes.up),
            (unit, up),
            "{target:?}"
        );
        assert!((file.settings.frames_per_second - rate).abs() < 1e-9, "{target:?}");
        let hips = file.nodes.iter().find(|node| &*node.element.name == "Hips").unwrap();
        assert_eq!(&*hips.parent.as_ref().unwrap().element.name, above, "{target:?}");
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("a.fbx");
        fs::write(&output, &bytes).unwrap();
        let verified = Verifier::new()
            .files("../../fixtures/real/cmu_short.bvh", &output)
            .unwrap();
        assert!(verified.is_within(5e-5), "{target:?}: {verified:?}");
    }
}

/// A scene of a damaged file gives an error, or a file that ufbx reads.
#[test]
fn damaged_files_give_an_error_or_a_valid_file() {
    let mut random = Sample::new();
    let mut written = 0;
    for path in [
        "dialects/all_six_rotation_orders.bvh",
        "dialects/names_equal.bvh",
        "dialects/scale_channels.bvh",
        "made/tiny.fbx",
        "made/two_bones_textured.gltf",
        "real/lecture_Test.bvh",
    ] {
        let whole = fs::read(format!("../../fixtures/{path}")).unwrap();
        for _ in 0..150 {
            let mut bytes = whole.clone();
            for _ in 0..=random.below(3) {
                let place = random.below(bytes.len());
                bytes[place] = b"0123456789.-e {\xff"[random.below(16)];
            }
            let importer = Importer::new().skeleton_mesh(SkeletonMesh::Skinned).gltf_meshes(true);
            let Ok(scene) = importer.read(&bytes, path) else {
                continue;
            };
            for options in [FbxOptions::default(), FbxOptions::of_target(FbxTarget::Unreal)] {
                if let Ok((bytes, _)) = options.write(&scene) {
                    written += 1;
                    let refusal = ufbx::load_memory(&bytes, ufbx::LoadOpts::default()).err();
                    assert!(refusal.is_none(), "{path}: {}", refusal.unwrap().description);
                }
            }
        }
    }
    assert!(written > 100, "{written}");
}
