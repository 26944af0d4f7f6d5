//! Tests of verdicts that were once wrong: correct files that were rejected, and wrong files that were accepted.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use mocap::glam::{Mat4, Quat, Vec3};

use mocap::bvh::BvhOptions;
use mocap::compress::ErrorBound;
use mocap::fbx::{FbxOptions, FbxTarget};
use mocap::figure::Humanoid;
use mocap::gltf::{Compression, GltfOptions};
use mocap::scene::{Animation, Bone, NodeId, NodeKind, UpAxis};
use mocap::verify::Verifier;
use mocap::verify::report::FindingKind;
use mocap::verify::report::Verification;
use mocap::{Code, Conversion, Exporter, Format, Importer, Scene, SkeletonMesh};
use serde_json::{Value, json};

use super::{as_of_another_program, glb};

/// A `.gltf` file of these nodes. Each clip is a name, frames per second, frames, and the nodes that rotate in it.
fn gltf(nodes: Value, clips: &[(&str, f32, usize, &[usize])]) -> Value {
    let mut file = json!({
        "asset": { "version": "2.0" }, "nodes": nodes,
        "accessors": [], "bufferViews": [], "animations": [],
    });
    let mut bytes: Vec<u8> = Vec::new();
    let mut add = |file: &mut Value, shape: &str, columns: usize, values: Vec<f32>| {
        let view = json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": 4 * values.len() });
        let views = file["bufferViews"].as_array_mut().unwrap();
        views.push(view);
        let count = values.len() / columns;
        let accessor = json!({ "bufferView": views.len() - 1, "componentType": 5126, "count": count, "type": shape });
        bytes.extend(values.into_iter().flat_map(f32::to_le_bytes));
        let accessors = file["accessors"].as_array_mut().unwrap();
        accessors.push(accessor);
        accessors.len() - 1
    };
    for (clip, (name, rate, frames, moving)) in clips.iter().enumerate() {
        let (mut channels, mut samplers) = (Vec::new(), Vec::new());
        for &node in *moving {
            let times: Vec<f32> = (0..*frames).map(|frame| frame as f32 / rate).collect();
            let angle = |time: &f32| 0.7 * (5.0 * time + node as f32 + clip as f32).sin();
            let turn = |time: &f32| Quat::from_axis_angle(Vec3::AXES[(node + clip) % 3], angle(time)).to_array();
            let values = times.iter().flat_map(turn).collect();
            let input = add(&mut file, "SCALAR", 1, times.clone());
            let output = add(&mut file, "VEC4", 4, values);
            channels.push(json!({ "sampler": samplers.len(), "target": { "node": node, "path": "rotation" } }));
            samplers.push(json!({ "input": input, "output": output }));
        }
        let clip = json!({ "name": name, "channels": channels, "samplers": samplers });
        file["animations"].as_array_mut().unwrap().push(clip);
    }
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bytes));
    if !bytes.is_empty() {
        file["buffers"] = json!([{ "byteLength": bytes.len(), "uri": uri }]);
    }
    file
}

fn chain() -> Value {
    json!([
        { "name": "Hips", "children": [1], "translation": [0, 1, 0] },
        { "name": "Spine", "children": [2], "translation": [0, 0.3, 0] },
        { "name": "Head", "translation": [0, 0.3, 0.1] },
    ])
}

/// A source and the files made from it, in one folder.
struct Files(tempfile::TempDir);

impl Files {
    fn new(source: &Value) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("source.gltf"), source.to_string()).unwrap();
        Self(folder)
    }

    fn of_fixture(file: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = format!("../../fixtures/real/{file}");
        let extension = file.rsplit('.').next().unwrap();
        std::fs::copy(path, folder.path().join(format!("source.{extension}"))).unwrap();
        Self(folder)
    }

    fn source(&self) -> std::path::PathBuf {
        let all = ["gltf", "bvh"].map(|extension| self.0.path().join(format!("source.{extension}")));
        all.into_iter().find(|path| path.exists()).unwrap()
    }

    fn scene(&self) -> Scene {
        let mut scene = Importer::new()
            .skeleton_mesh(SkeletonMesh::Skinned)
            .import(self.source())
            .unwrap();
        Conversion::new().apply(&mut scene).unwrap();
        scene
    }

    /// Writes a scene in a format, changes the bytes, and compares.
    fn verify(&self, scene: &Scene, extension: &str, change: &dyn Fn(Vec<u8>) -> Vec<u8>) -> Verification {
        let path = self.0.path().join(format!("out.{extension}"));
        Exporter::new().overwrite(true).export(scene, &path).unwrap();
        let bytes = change(std::fs::read(&path).unwrap());
        std::fs::write(&path, bytes).unwrap();
        Verifier::new().files(self.source(), &path).unwrap()
    }
}

fn whole(bytes: Vec<u8>) -> Vec<u8> {
    bytes
}

/// The file as another program would write it: without the record of this crate.
fn foreign(bytes: Vec<u8>) -> Vec<u8> {
    let mut changed = bytes;
    let name = b"\"mocap\"";
    let place = changed.windows(name.len()).position(|window| window == name).unwrap();
    changed[place..place + name.len()].copy_from_slice(b"\"other\"");
    changed
}

fn kinds(verified: &Verification) -> Vec<FindingKind> {
    verified.findings.iter().map(|finding| finding.kind).collect()
}

#[track_caller]
fn passes(source: &Value, extensions: &[&str]) {
    let files = Files::new(source);
    for extension in extensions {
        let verified = files.verify(&files.scene(), extension, &whole);
        assert!(verified.is_within(1e-3), "{extension}: {verified:?}");
    }
}

#[test]
fn each_clip_has_its_own_frame_rate() {
    let clips: [(&str, f32, usize, &[usize]); 2] = [("slow", 24.0, 49, &[0, 1]), ("fast", 120.0, 241, &[0, 1, 2])];
    passes(&gltf(chain(), &clips), &["glb", "gltf", "fbx"]);
    let [slow, fast] = clips;
    passes(&gltf(chain(), &[fast, slow]), &["glb", "gltf", "fbx"]);
}

/// Nodes as in the sample files CesiumMan and SimpleSkin: a group with the name of a joint, and joints without names.
#[test]
fn a_group_and_a_joint_of_one_name_are_told_apart() {
    let mut source = gltf(
        json!([
            { "name": "Armature", "children": [1], "translation": [0, 1, 0] },
            { "name": "Armature", "children": [2, 3], "translation": [0, 0.6, 0] },
            { "name": "torso", "translation": [0, 0.4, 0] },
            { "name": "Armature", "translation": [0.2, 0.4, 0] },
        ]),
        &[("walk", 24.0, 49, &[1, 2, 3])],
    );
    source["skins"] = json!([{ "joints": [1, 2, 3] }]);
    passes(&source, &["bvh", "glb", "fbx", "mclip"]);
}

#[test]
fn joints_without_names_are_found_by_their_parents() {
    let nodes = json!([
        { "children": [1, 3], "translation": [0, 1, 0] },
        { "children": [2], "translation": [0.2, 0.1, 0] },
        { "translation": [0.4, 0.1, 0] },
        { "children": [4], "translation": [-0.2, 0.1, 0] },
        { "translation": [-0.5, 0.2, 0] },
    ]);
    passes(
        &gltf(nodes, &[("x", 30.0, 31, &[0, 1, 2, 3, 4])]),
        &["bvh", "glb", "fbx", "mclip"],
    );
    let nodes = json!([
        { "name": "a{b}", "children": [1], "translation": [0, 1, 0] },
        { "name": "tab\there", "translation": [0.2, 0.1, 0] },
    ]);
    passes(
        &gltf(nodes, &[("x", 30.0, 31, &[0, 1])]),
        &["bvh", "glb", "fbx", "mclip"],
    );
}

#[test]
fn hands_of_one_name_stay_on_their_arms() {
    let nodes = json!([
        { "name": "Hips", "children": [1, 3], "translation": [0, 1, 0] },
        { "name": "L", "children": [2], "translation": [0.2, 0.1, 0] },
        { "name": "hand", "translation": [0.4, 0.1, 0] },
        { "name": "R", "children": [4], "translation": [-0.2, 0.1, 0] },
        { "name": "hand", "translation": [-0.5, 0.2, 0] },
    ]);
    let source = gltf(nodes, &[("x", 30.0, 31, &[0, 1, 3])]);
    let files = Files::new(&source);
    // Another program lists the arms in another order.
    let mut other = source.clone();
    other["nodes"][0]["children"] = json!([3, 1]);
    let path = files.0.path().join("other.gltf");
    std::fs::write(&path, other.to_string()).unwrap();
    let verified = Verifier::new().files(files.source(), &path).unwrap();
    assert!(verified.is_within(1e-6), "{verified:?}");
}

#[test]
fn a_character_without_motion_is_its_pose_in_every_format() {
    passes(&gltf(chain(), &[]), &["bvh", "glb", "fbx"]);
    let files = Files::new(&gltf(chain(), &[]));
    let moving = Files::new(&gltf(chain(), &[("x", 30.0, 31, &[1])]));
    let path = files.0.path().join("moving.bvh");
    Exporter::new().export(&moving.scene(), &path).unwrap();
    let verified = Verifier::new().files(files.source(), &path).unwrap();
    assert_eq!(kinds(&verified), [FindingKind::ExtraClip]);
}

#[test]
fn clips_that_exchanged_names_are_found_and_another_order_is_none() {
    let source = gltf(chain(), &[("Run", 30.0, 31, &[0, 1]), ("Walk", 30.0, 31, &[0, 1])]);
    let files = Files::new(&source);
    for (change, extension) in [
        (whole as fn(Vec<u8>) -> Vec<u8>, "glb"),
        (foreign, "glb"),
        (whole, "fbx"),
    ] {
        let mut scene = files.scene();
        scene.animations.swap(0, 1);
        assert!(
            files.verify(&scene, extension, &change).is_within(1e-3),
            "{extension}: another order"
        );
        let (first, second) = scene.animations.split_at_mut(1);
        std::mem::swap(&mut first[0].name, &mut second[0].name);
        let verified = files.verify(&scene, extension, &change);
        assert!(verified.max_error > 0.01, "{extension}: {verified:?}");
    }
    let mut scene = files.scene();
    scene.animations[1].name = "Jump".to_owned();
    assert_eq!(kinds(&files.verify(&scene, "glb", &whole)), [FindingKind::RenamedClip]);
}

#[test]
fn a_factor_that_is_no_unit_is_found() {
    let files = Files::of_fixture("cmu_short.bvh");
    for (factor, is_unit) in [
        (1.0, true),
        (0.01, true),
        (2.54, true),
        (0.0254 / 0.45, true),
        (1.001, false),
        (1.1, false),
        (0.9, false),
        (3.0, false),
    ] {
        for extension in ["bvh", "glb"] {
            let mut scene = Importer::new().import(files.source()).unwrap();
            scene.convert_units(factor, UpAxis::Y);
            let change: &dyn Fn(Vec<u8>) -> Vec<u8> = if extension == "bvh" { &whole } else { &foreign };
            let verified = files.verify(&scene, extension, change);
            assert_eq!(verified.is_within(1e-3), is_unit, "{factor} {extension}: {verified:?}");
        }
    }
}

#[test]
fn a_curve_is_looked_at_between_its_keys() {
    let mut source = gltf(chain(), &[("x", 30.0, 31, &[0, 1])]);
    let files = Files::new(&source);
    // The same keys, with tangents of 40 units per second, as a cubic curve: in-tangent, value, out-tangent.
    let count = 31;
    let accessor = source["animations"][0]["samplers"][1]["output"].as_u64().unwrap() as usize;
    let keys = (0..count).flat_map(|frame| {
        let angle = 0.7 * (5.0 * frame as f32 / 30.0 + 1.0).sin();
        let key = Quat::from_axis_angle(Vec3::Y, angle).to_array();
        [[40.0, 0.0, 0.0, 0.0], key, [40.0, 0.0, 0.0, 0.0]].concat()
    });
    let bytes: Vec<u8> = keys.flat_map(f32::to_le_bytes).collect();
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bytes));
    source["buffers"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "byteLength": bytes.len(), "uri": uri }));
    let views = source["bufferViews"].as_array_mut().unwrap();
    views.push(json!({ "buffer": 1, "byteLength": bytes.len() }));
    let view = views.len() - 1;
    source["accessors"][accessor]["bufferView"] = json!(view);
    source["accessors"][accessor]["count"] = json!(3 * count);
    source["animations"][0]["samplers"][1]["interpolation"] = json!("CUBICSPLINE");
    let path = files.0.path().join("curve.gltf");
    std::fs::write(&path, source.to_string()).unwrap();
    let verified = Verifier::new().files(files.source(), &path).unwrap();
    assert!(verified.max_error > 0.01, "{verified:?}");
    // A file with curves equals itself.
    assert!(Verifier::new().files(&path, &path).unwrap().is_within(1e-6));
}

#[test]
fn a_joint_without_children_that_turns_is_looked_at() {
    let nodes = json!([
        { "name": "Hips", "children": [1], "translation": [0, 1, 0] },
        { "name": "lookAt", "translation": [0, 0.2, 0] },
    ]);
    let source = gltf(nodes, &[("x", 30.0, 31, &[0, 1])]);
    let files = Files::new(&source);
    for (extension, change) in [
        ("glb", &whole as &dyn Fn(Vec<u8>) -> Vec<u8>),
        ("glb", &foreign),
        ("bvh", &whole),
        ("mclip", &whole),
    ] {
        assert!(
            files.verify(&files.scene(), extension, change).is_within(1e-3),
            "{extension}"
        );
        let mut scene = files.scene();
        let channel = scene.animations[0]
            .channels
            .iter_mut()
            .find(|channel| channel.node_name == "lookAt")
            .unwrap();
        let keys = &mut channel.rotation_keys.values;
        let first = keys[0];
        keys.fill(first);
        let verified = files.verify(&scene, extension, change);
        assert!(
            verified.max_error < 1e-3 && !verified.is_within(1e-3),
            "{extension}: {verified:?}"
        );
    }
    // The verdict is the same for files that are written within a largest error.
    for extension in ["glb", "fbx", "mclip"] {
        let path = files.0.path().join(format!("smaller.{extension}"));
        Exporter::new().max_error(0.001).export(&files.scene(), &path).unwrap();
        let verified = Verifier::new().files(files.source(), &path).unwrap();
        assert!(verified.is_within(1e-3), "{extension}: {verified:?}");
    }
}

/// The unit and the up axis are found from clips of one name, whatever their order in the file.
#[test]
fn clips_in_another_order_are_those_of_their_names() {
    let files = Files::of_fixture("cmu_short.bvh");
    let mut scene = files.scene();
    let standing = scene.animations[0].clone();
    // A lying person: in this clip alone, another up axis would fit.
    let mut lying = standing.clone();
    let aside = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let root = &mut lying.channels[0];
    root.position_keys.values.iter_mut().for_each(|key| *key = aside * *key);
    root.rotation_keys.values.iter_mut().for_each(|key| *key = aside * *key);
    let mut still = standing.clone();
    still.channels.truncate(1);
    scene.animations.clear();
    for (name, clip) in [("standing", standing), ("lying", lying), ("still", still)] {
        scene.animations.push(Animation {
            name: name.to_owned(),
            ..clip
        });
    }
    let source = scene.clone();
    let glb = |scene: &Scene| foreign(GltfOptions::new().write_glb(scene).unwrap());
    for order in [[1, 0, 2], [2, 1, 0], [1, 2, 0]] {
        scene.animations = order.map(|clip| source.animations[clip].clone()).into();
        let verified = Verification::of(&source, &glb(&scene)).unwrap();
        assert!(verified.is_within(1e-5), "{order:?}: {verified:?}");
    }
    // `verify` finds the difference if the names of two clips are exchanged.
    scene.animations[0].name = "still".to_owned();
    scene.animations[1].name = "lying".to_owned();
    let verified = Verification::of(&source, &glb(&scene)).unwrap();
    assert!(!verified.is_within(1e-3), "{verified:?}");
}

#[test]
fn an_inverse_bind_matrix_that_is_wrong_is_found() {
    let files = Files::of_fixture("cmu_short.bvh");
    for extension in ["glb", "gltf", "fbx"] {
        let scene = files.scene();
        assert!(files.verify(&scene, extension, &whole).is_within(1e-3), "{extension}");
        let mut edited = scene.clone();
        let bone = &mut edited.meshes[0].bones[7];
        bone.offset_matrix = mocap::glam::Mat4::from_translation(Vec3::X * 0.05) * bone.offset_matrix;
        assert_eq!(
            kinds(&files.verify(&edited, extension, &whole)),
            [FindingKind::Skin],
            "{extension}"
        );
    }
}

/// A character whose joints are not at their bind positions, with an end joint that no vertex follows.
#[test]
fn a_joint_without_a_bone_is_bound_as_it_rests_below_the_bone_above_it() {
    let files = Files::new(&gltf(chain(), &[("walk", 30.0, 10, &[0, 1, 2])]));
    let mut scene = files.scene();
    let [hips, spine] = [0, 1].map(|node| scene.nodes[node].name.clone());
    let bones = &mut scene.meshes[0].bones;
    bones.retain(|bone| [&hips, &spine].contains(&&bone.name));
    assert_eq!(bones.len(), 2);
    bones[0].offset_matrix *= Mat4::from_translation(Vec3::Y * 0.01);
    bones[1].offset_matrix = Mat4::from_rotation_x(0.5) * bones[1].offset_matrix;
    let source = files.0.path().join("character.fbx");
    Exporter::new().export(&scene, &source).unwrap();
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::Own);
    let mut scene = importer.import(&source).unwrap();
    Conversion::new().apply(&mut scene).unwrap();
    let path = files.0.path().join("character.glb");
    let exporter = Exporter::new().overwrite(true);
    exporter.export(&scene, &path).unwrap();
    let verified = Verifier::new().files(&source, &path).unwrap();
    assert!(verified.is_within(1e-3), "{verified:?}");
    // The rest position of the end joint is not its bind position.
    let end = scene.nodes.iter().position(|node| node.name == "Head").unwrap();
    let rest = mocap::Pose::rest(&scene).node_to_world[end];
    scene.meshes[0].bones.push(Bone {
        name: "Head".into(),
        node: NodeId::new(end),
        offset_matrix: rest.inverse(),
        weights: Vec::new(),
    });
    exporter.export(&scene, &path).unwrap();
    assert_eq!(
        kinds(&Verifier::new().files(&source, &path).unwrap()),
        [FindingKind::Skin]
    );
}

/// The meshes of one node keep their order in USD, whose reader attaches each mesh to the node of its first bone.
#[test]
fn meshes_are_compared_in_the_order_of_the_file() {
    let files = Files::new(&gltf(chain(), &[("walk", 30.0, 10, &[0, 1, 2])]));
    let mut scene = files.scene();
    let whole = scene.meshes[0].clone();
    let part = |bone: &str, faces: usize| {
        let mut part = whole.clone();
        part.indices.truncate(3 * faces);
        part.bones
            .rotate_left(whole.bones.iter().position(|other| other.name == bone).unwrap());
        part
    };
    let node = scene.nodes.iter().position(|node| !node.meshes.is_empty()).unwrap();
    let last = whole.bones.last().unwrap().name.clone();
    scene.meshes = vec![part(&last, 4), part(&whole.bones[0].name, 2)];
    scene.nodes[node].meshes = vec![0, 1];
    scene.materials[whole.material_index].name = "cloth".into();
    let source = files.0.path().join("character.fbx");
    Exporter::new().export(&scene, &source).unwrap();
    let mut scene = Importer::new()
        .skeleton_mesh(SkeletonMesh::Own)
        .import(&source)
        .unwrap();
    Conversion::new().apply(&mut scene).unwrap();
    for extension in ["usda", "glb", "fbx"] {
        let path = files.0.path().join("out").with_extension(extension);
        Exporter::new().export(&scene, &path).unwrap();
        let verified = Verifier::new().files(&source, &path).unwrap();
        assert!(verified.is_within(1e-3), "{extension}: {verified:?}");
    }
}

/// The bind poses of a compressed file are decoded: the correct pose is accepted, and a changed pose is found.
#[test]
fn an_inverse_bind_matrix_in_a_stream_of_meshopt_is_read() {
    let files = Files::of_fixture("cmu_short.bvh");
    for kind in [Compression::Meshopt, Compression::MeshoptKhr] {
        let options = GltfOptions::new()
            .compression(kind)
            .error_bound(Some(ErrorBound::new(1e-3)));
        let mut scene = files.scene();
        let whole = match options.write_glb(&scene) {
            Ok(whole) => whole,
            Err(error) => {
                assert_eq!(error.code(), Code::MissingFeature);
                return;
            }
        };
        let source = mocap::import(files.source()).unwrap();
        let verified = Verification::of(&source, &whole).unwrap();
        assert!(verified.is_within(1e-3), "{kind:?}: {verified:?}");
        let bone = &mut scene.meshes[0].bones[7];
        bone.offset_matrix = mocap::glam::Mat4::from_rotation_x(0.3) * bone.offset_matrix;
        let moved = options.write_glb(&scene).unwrap();
        assert_eq!(
            kinds(&Verification::of(&source, &moved).unwrap()),
            [FindingKind::Skin],
            "{kind:?}"
        );
    }
}

/// A copy records the same steps as its source, so no step lies between the two files. Another motion with the same
/// steps is not its source.
#[test]
fn a_copy_of_a_written_file_is_what_its_source_is() {
    let files = Files::of_fixture("cmu_short.bvh");
    let mut scene = files.scene();
    scene.trim(5.0, 40.0);
    scene.put_in_place();
    let path = |name: &str| files.0.path().join(name);
    for extension in ["glb", "gltf", "fbx", "usda", "usdz", "bvh", "vrma"] {
        let output = path(&format!("out.{extension}"));
        let exporter = Exporter::new().bvh(BvhOptions::new().sidecar(true));
        exporter.export(&scene, &output).unwrap();
        let verified = Verifier::new().files(&output, &output).unwrap();
        assert!(verified.is_within(1e-9), "{extension}: {verified:?}");
        let mut other = scene.clone();
        let channels = &mut other.animations[0].channels;
        channels[3].rotation_keys.values.reverse();
        channels[8].rotation_keys.values.reverse();
        let another = path(&format!("another.{extension}"));
        exporter.export(&other, &another).unwrap();
        let verified = Verifier::new().files(&output, &another).unwrap();
        assert!(!verified.is_within(1e-3), "{extension}: {verified:?}");
    }
}

/// Makes the keys of a track four times as long: forwards and back, twice.
fn extended<T: Copy>(keys: &mut Vec<T>) {
    let times = if keys.len() > 1 { 2 } else { 0 };
    for _ in 0..times {
        let again: Vec<T> = keys.iter().rev().copied().collect();
        keys.extend(again);
    }
}

/// Some programs only accept whole frame rates. Each frame is then a little earlier than in the source, and this
/// difference grows from frame to frame.
#[test]
fn a_long_motion_at_a_whole_frame_rate_is_compared_frame_by_frame() {
    let files = Files::of_fixture("cmu_01_01.bvh");
    let mut source = mocap::import(files.source()).unwrap();
    for clip in &mut source.animations {
        for channel in &mut clip.channels {
            extended(&mut channel.position_keys.values);
            extended(&mut channel.rotation_keys.values);
        }
        clip.duration = 4.0 * (clip.duration + 1.0) - 1.0;
    }
    source.metadata.origin = None;
    let mut scene = source.clone();
    Conversion::new().apply(&mut scene).unwrap();
    let path = files.0.path().join("out.fbx");
    for target in [FbxTarget::Unreal, FbxTarget::MotionBuilder] {
        let exporter = Exporter::new().overwrite(true).fbx(FbxOptions::of_target(target));
        exporter.export(&scene, &path).unwrap();
        let verified = Verification::of(&source, &std::fs::read(&path).unwrap()).unwrap();
        assert!(verified.is_within(2e-5), "{target:?}: {verified:?}");
    }
    // Another rate gives another motion.
    scene.animations[0].ticks_per_second *= 0.999;
    Exporter::new().overwrite(true).export(&scene, &path).unwrap();
    let verified = Verification::of(&source, &std::fs::read(&path).unwrap()).unwrap();
    assert!(!verified.is_within(1e-3), "{verified:?}");
}

#[test]
fn the_source_that_a_file_names_is_its_source() {
    let files = Files::of_fixture("cmu_short.bvh");
    let scene = files.scene();
    let mut text = std::fs::read(files.source()).unwrap();
    text.push(b'\n');
    for extension in ["glb", "fbx"] {
        let path = files.0.path().join(format!("out.{extension}"));
        Exporter::new().export(&scene, &path).unwrap();
        std::fs::write(files.0.path().join("changed.bvh"), &text).unwrap();
        let verified = Verifier::new()
            .files(files.0.path().join("changed.bvh"), &path)
            .unwrap();
        assert_eq!(kinds(&verified), [FindingKind::Provenance], "{extension}");
    }
}

#[test]
fn in_place_files_of_other_programs_are_not_their_source() {
    let files = Files::of_fixture("cmu_short.bvh");
    let mut scene = files.scene();
    scene.put_in_place();
    assert!(!files.verify(&scene, "glb", &foreign).is_within(1e-3));
}

/// An FBX file in which fuzzing changed the kind of each joint.
#[test]
fn groups_that_move_are_compared_where_there_is_no_joint() {
    let mut scene = Importer::new().import("../../fixtures/real/cmu_short.bvh").unwrap();
    scene.nodes.iter_mut().for_each(|node| node.kind = NodeKind::Group);
    let written = |scene: &Scene| {
        Exporter::new()
            .write(scene, Format::Gltf)
            .unwrap()
            .into_bytes()
            .unwrap()
    };
    assert!(Verification::of(&scene, &written(&scene)).unwrap().is_within(1e-5));
    let mut late = scene.clone();
    late.animations[0].channels[0].position_keys.values.rotate_right(1);
    assert!(!Verification::of(&scene, &written(&late)).unwrap().is_within(1e-3));
}

/// A packed clip whose duration was changed by fuzzing was written with two keys at one time, which no reader accepts.
#[test]
fn a_take_of_no_length_in_32_bits_is_one_pose() {
    let mut scene = Importer::new().import("../../fixtures/dialects/plain.bvh").unwrap();
    scene.trim(0.0, 0.0);
    scene.animations[0].duration = 1e-50;
    let written = Exporter::new().write(&scene, Format::Gltf).unwrap();
    let again = Importer::new()
        .read(&written.into_bytes().unwrap(), "pose.glb")
        .unwrap();
    assert_eq!(again.animations[0].duration, 0.0);
}

/// 32-bit positions 400 km away do not determine the direction of a shin of 40 cm, but its rotation does.
#[test]
fn a_bone_too_short_for_its_distance_has_its_own_rotation_in_a_vrm_animation() {
    let mut source = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    Conversion::new().apply(&mut source).unwrap();
    for (bone, found) in Humanoid::of(&source).bones {
        source.nodes[found.joint.index()].humanoid_bone = Some(bone);
    }
    for (index, node) in source.nodes.iter_mut().enumerate() {
        if !["LeftLeg", "RightLeg"].contains(&node.name.as_str()) {
            continue;
        }
        let offset = 1e6 * node.transform.w_axis.truncate();
        node.transform.w_axis = offset.extend(1.0);
        let own = |channel: &&mut mocap::scene::Channel| channel.node.is_some_and(|node| node.index() == index);
        let channel = source.animations[0].channels.iter_mut().find(own).unwrap();
        channel.position_keys.values = vec![offset];
    }
    let written = Exporter::new()
        .write(&source, Format::Vrma)
        .unwrap()
        .into_bytes()
        .unwrap();
    let verified = Verification::of(&source, &written).unwrap();
    assert!(verified.rotation_error.unwrap() < 1e-4, "{verified:?}");
}

/// Every FBX file has a root that is a group, and this root may have the name of a joint of the source.
#[test]
fn a_joint_with_the_name_of_the_root_of_fbx_is_no_other_joint() {
    let nodes = json!([
        { "name": "RootNode", "children": [1], "translation": [0, 1, 0] },
        { "name": "lever", "translation": [0.2, 0, 0] },
    ]);
    let source = Importer::new()
        .read(gltf(nodes, &[]).to_string().as_bytes(), "a.gltf")
        .unwrap();
    let written = Exporter::new()
        .write(&source, Format::Fbx)
        .unwrap()
        .into_bytes()
        .unwrap();
    let verified = Verification::of(&source, &written).unwrap();
    assert!(verified.is_within(1e-6) && verified.joints == 2, "{verified:?}");
}

#[test]
fn a_scene_without_nodes_is_one_in_gltf() {
    let file = json!({ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "name": "empty" }] });
    let source = Importer::new().read(file.to_string().as_bytes(), "a.gltf").unwrap();
    let written = Exporter::new()
        .write(&source, Format::Gltf)
        .unwrap()
        .into_bytes()
        .unwrap();
    let verified = Verification::of(&source, &written).unwrap();
    assert!(verified.is_within(0.0) && verified.joints == 0, "{verified:?}");
    let another = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    assert!(Verification::of(&another, &written).is_err());
}

/// Other readers of USD convert by the unit and axis in the file. Readers of glTF assume metres and +Y up.
#[test]
fn a_unit_or_an_axis_that_a_file_states_otherwise_is_found() {
    let folder = tempfile::tempdir().unwrap();
    // BVH states neither unit nor axis. The other source states centimetres with +Z up.
    for source in ["real/cmu_short.bvh", "made/arm.usda"] {
        let source = format!("../../fixtures/{source}");
        let mut scene = mocap::import(&source).unwrap();
        Conversion::new().apply(&mut scene).unwrap();
        let output = folder.path().join("out.usda");
        Exporter::new().overwrite(true).export(&scene, &output).unwrap();
        let right = std::fs::read_to_string(&output).unwrap();
        let changes = [
            ("metersPerUnit = 1\n", "metersPerUnit = 0.01\n", Some(FindingKind::Unit)),
            ("metersPerUnit = 1\n", "metersPerUnit = 100\n", Some(FindingKind::Unit)),
            ("metersPerUnit = 1\n", "\n", Some(FindingKind::Unit)),
            ("upAxis = \"Y\"", "upAxis = \"Z\"", Some(FindingKind::UpAxis)),
            // A file without the statement has USD's default, +Y.
            ("upAxis = \"Y\"", "", None),
            ("", "", None),
        ];
        for (from, to, kind) in changes {
            std::fs::write(&output, right.replacen(from, to, 1)).unwrap();
            let found = Verifier::new().files(&source, &output).unwrap();
            let kinds: Vec<FindingKind> = found.findings.iter().map(|found| found.kind).collect();
            assert_eq!(kinds, Vec::from_iter(kind), "{source}: {from:?}, {to:?}: {found:?}");
            assert_eq!(
                found.is_within(1e-3),
                kind.is_none(),
                "{source}: {from:?}, {to:?}: {found:?}"
            );
        }
    }
    // A file of another program has no record, but glTF is in metres, and this source states its unit.
    let source = "../../fixtures/made/arm.usda";
    for (factor, kind) in [(1.0, None), (100.0, Some(FindingKind::Unit))] {
        let mut scene = mocap::import(source).unwrap();
        Conversion::new().apply(&mut scene).unwrap();
        scene.convert_units(factor, UpAxis::Y);
        let output = folder.path().join("out.glb");
        std::fs::write(&output, as_of_another_program(&glb(&scene))).unwrap();
        let found = Verifier::new().files(source, &output).unwrap();
        let kinds: Vec<FindingKind> = found.findings.iter().map(|found| found.kind).collect();
        assert_eq!(kinds, Vec::from_iter(kind), "{factor}: {found:?}");
    }
}
