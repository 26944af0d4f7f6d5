//! The properties that must hold for any bytes, in each format. A panic is a finding.

mod inputs;

use std::collections::BTreeSet;

use mocap::arrays::{ArrayOptions, arrays};
use mocap::fbx::{self, FbxOptions, FbxTarget, FbxVersion};
use mocap::process::validate;
use mocap::scene::{Animation, NodeKind};
use mocap::{Code, Diagnostic, Importer, Pose, Scene, SkeletonMesh, bvh, gltf};

use self::inputs::Outputs;
pub use self::inputs::{AMC, ASF, BVH, C3D, FBX, FBX_OUT, FORMATS, GLB, GLTF, Input, MCLIP, fixture};

const MESHES: [SkeletonMesh; 3] = [SkeletonMesh::None, SkeletonMesh::Segmented, SkeletonMesh::Skinned];

impl Input {
    /// An error; or a scene that keeps every rule, with each kind of skeleton mesh, can be posed at any tick, and is
    /// the same once it is written as glTF or BVH; or, of [`FBX_OUT`], is read back from FBX.
    pub fn hold(&self, bytes: &[u8]) {
        for mesh in MESHES {
            let Ok(scene) = self.read(bytes, mesh) else { return };
            let violations = validate(&scene);
            assert!(violations.is_empty(), "{mesh:?}: {violations:?}");
            for tick in [0.0, 0.5, f64::MAX, f64::NAN] {
                // The positions are not specified then; it must only end without a panic.
                let _ = Pose::at_tick(&scene, 0, tick);
            }
            if self.outputs == Outputs::Fbx {
                export_fbx(&scene, bytes);
                continue;
            }
            export_gltf(&scene);
            if mesh == SkeletonMesh::None {
                export_bvh(&scene);
                make_arrays(&scene);
            }
        }
    }

    /// An error; or a scene that keeps every rule and can be posed. The part of [`hold`](Self::hold) that is quick
    /// enough for millions of inputs.
    pub fn survive(&self, bytes: &[u8]) {
        let Ok(scene) = self.read(bytes, SkeletonMesh::Segmented) else {
            return;
        };
        let violations = validate(&scene);
        assert!(violations.is_empty(), "{violations:?}");
        let _ = Pose::at_tick(&scene, 0, 0.5);
    }

    /// The codes of an input's warnings and what its error says, but for names and numbers, by which inputs are
    /// distinguished.
    pub fn outcome(&self, bytes: &[u8]) -> BTreeSet<String> {
        let codes = |warnings: &[Diagnostic]| {
            warnings
                .iter()
                .map(|warning| warning.code.as_str().to_owned())
                .collect()
        };
        match self.read(bytes, SkeletonMesh::None) {
            Ok(scene) => codes(&scene.warnings),
            Err(error) => {
                let mut codes: BTreeSet<_> = codes(error.warnings());
                // A code may be a warning in one file and the error of another.
                let said = error.diagnostic().message.split('"').step_by(2).collect::<String>();
                codes.insert("error".to_owned());
                codes.insert(said.replace(|c: char| !c.is_alphabetic() && c != ' ', ""));
                codes
            }
        }
    }
}

/// An error, or a glTF file that holds the same nodes.
fn export_gltf(scene: &Scene) {
    // Not every scene can be written: links of 1e38 add up to infinity. An error is an answer.
    let Ok(glb) = gltf::write_glb(scene, &gltf::GltfOptions::default()) else {
        return;
    };
    let file = ::gltf::Gltf::from_slice(&glb).expect("what was exported is valid glTF");
    assert!(file.nodes().len() >= scene.nodes.len());
    assert_finite(&file, &glb);
    let written = file.animations().len();
    assert!(written <= scene.animations.len() && (written >= 1 || !moves(scene)));
}

/// JSON has no number that is not finite: `null` stands for it, and for nothing else in what is written.
fn assert_finite(file: &::gltf::Gltf, glb: &[u8]) {
    let length = glb.get(12..16).and_then(|four| four.first_chunk().copied());
    let json = &glb[20..20 + u32::from_le_bytes(length.expect("a chunk has a length")) as usize];
    let json: serde_json::Value = serde_json::from_slice(json).expect("what was exported is JSON");
    assert!(!has_null(&json), "a number of the JSON is not finite");
    let bin = file.blob.as_deref().unwrap_or_default();
    for accessor in file.accessors() {
        let Some(view) = accessor
            .view()
            .filter(|_| accessor.data_type() == ::gltf::accessor::DataType::F32)
        else {
            continue;
        };
        let start = view.offset() + accessor.offset();
        let (numbers, _) = bin[start..start + accessor.count() * accessor.size()].as_chunks::<4>();
        let finite = numbers.iter().all(|number| f32::from_le_bytes(*number).is_finite());
        assert!(finite, "a number of accessor {} is not finite", accessor.index());
    }
}

fn has_null(value: &serde_json::Value) -> bool {
    match value {
        serde_json::Value::Null => true,
        serde_json::Value::Array(values) => values.iter().any(has_null),
        serde_json::Value::Object(values) => values.values().any(has_null),
        _ => false,
    }
}

/// Frames of all joints, beyond which what is written frame by frame takes more memory than an input may.
const MOST_ROWS: usize = 2000;

fn rows(scene: &Scene) -> usize {
    let frames = scene.animations.first().map_or(0, Animation::frame_count);
    frames.saturating_mul(scene.nodes.len())
}

/// Whether two keys may be hours apart, with a row of a BVH file for each frame between them.
fn has_few_keys(scene: &Scene) -> bool {
    let channels = scene.animations.iter().flat_map(|animation| &animation.channels);
    let keys: usize = channels
        .map(|channel| channel.position_keys.len() + channel.rotation_keys.len() + channel.scaling_keys.len())
        .sum();
    rows(scene) > 10 * keys
}

/// An error, or arrays of finite numbers.
fn make_arrays(scene: &Scene) {
    if rows(scene) > MOST_ROWS {
        return;
    }
    let options = ArrayOptions::new().velocities(true);
    let Ok(motion) = arrays(scene, &options) else { return };
    let velocities = motion.velocities.as_deref().unwrap_or_default();
    let all = [motion.positions.as_slice(), &motion.rotations, velocities];
    assert!(
        all.into_iter().flatten().all(|value| value.is_finite()),
        "arrays are not finite"
    );
}

/// An error, or a BVH file that is read back to as many frames, and without a warning but of names, roots and far
/// places.
fn export_bvh(scene: &Scene) {
    if rows(scene) > MOST_ROWS && has_few_keys(scene) {
        return;
    }
    let Ok(text) = bvh::write(scene, &bvh::BvhOptions::default()) else {
        return;
    };
    let motion = text.split(|byte| *byte == b'\n').skip_while(|line| *line != b"MOTION");
    let is_finite = |line: &[u8]| !line.windows(3).any(|word| word == b"NaN" || word == b"inf");
    assert!(
        motion.into_iter().all(is_finite),
        "a value of the BVH file is not finite"
    );
    let importer = Importer::new()
        .format(mocap::Format::Bvh)
        .skeleton_mesh(SkeletonMesh::None);
    let again = match importer.read(&text, "written.bvh") {
        Ok(again) => again,
        // A name becomes longer where it had no letters that text has, and a group is a node of its own.
        Err(error) if error.code() == Code::LimitExceeded => return,
        Err(error) => panic!("what was written is refused: {error}"),
    };
    let said: Vec<_> = (again.warnings.iter())
        .filter(|warning| {
            !matches!(
                warning.code,
                Code::DuplicateName | Code::SeveralRoots | Code::WorldPositions
            )
        })
        .collect();
    assert!(said.is_empty(), "what was written deviates from the format: {said:?}");
    // Durations that were computed from seconds fall a little short of a whole tick.
    let frames = |scene: &Scene| {
        scene
            .animations
            .first()
            .map_or(0.0, |animation| (animation.duration + 1e-6).floor())
    };
    assert_eq!(frames(&again), frames(scene), "frames were lost");
}

/// An error, or an FBX file that ufbx reads, with every joint, and as long a motion. The bytes choose the options.
fn export_fbx(scene: &Scene, bytes: &[u8]) {
    let options = match bytes.iter().fold(0u8, |sum, byte| sum.wrapping_add(*byte)) % 6 {
        0 => FbxOptions::of_target(FbxTarget::Unreal),
        1 => FbxOptions::of_target(FbxTarget::Unity),
        2 => FbxOptions::of_target(FbxTarget::Maya),
        3 => FbxOptions::of_target(FbxTarget::MotionBuilder),
        4 => FbxOptions::new().version(FbxVersion::V7400),
        _ => FbxOptions::default(),
    };
    let Ok((file, report)) = fbx::write(scene, &options) else {
        return;
    };
    assert_eq!(report.bytes, file.len());
    let importer = Importer::new()
        .format(mocap::Format::Fbx)
        .skeleton_mesh(SkeletonMesh::None);
    let again = match importer.read(&file, "written.fbx") {
        Ok(again) => again,
        // Names become longer, groups are nodes of their own, and few keys may be far apart.
        Err(error) if error.code() == Code::LimitExceeded => return,
        Err(error) => panic!("what was written is refused: {error}"),
    };
    let joints = |scene: &Scene| scene.nodes.iter().filter(|node| node.kind != NodeKind::Group).count();
    assert!(joints(&again) >= joints(scene), "joints were lost");
    assert_eq!(again.animations.len(), scene.animations.len(), "clips were lost");
}

/// Whether any track has more than one key: glTF stores the others in their nodes.
fn moves(scene: &Scene) -> bool {
    scene
        .animations
        .iter()
        .flat_map(|animation| &animation.channels)
        .any(|channel| {
            channel.position_keys.len() > 1 || channel.rotation_keys.len() > 1 || channel.scaling_keys.len() > 1
        })
}
