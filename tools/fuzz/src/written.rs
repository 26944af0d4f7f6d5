//! The rule of every writer. It returns an error that its format explains, or a file that can be read back and that
//! `verify` accepts as the scene.

use std::borrow::Cow;
use std::collections::BTreeSet;

use mocap::arrays::{ArrayOptions, Arrays};
use mocap::fbx::{FbxOptions, FbxTarget, FbxVersion};
use mocap::scene::{Animation, Node, NodeKind};
use mocap::verify::report::Verification;
use mocap::{Code, Conversion, Error, Exporter, Format, FormatInfo, Importer, Pose, Scene, SkeletonMesh};

use crate::inputs::Outputs;

/// Writes a scene with such a mesh in every way. `choice` selects the work that is too slow for each scene. The scene
/// is written in metres, as the program does.
pub(crate) fn hold(read: &Scene, mesh: SkeletonMesh, outputs: Outputs, choice: u8) {
    let mut converted = read.clone();
    let Ok(_) = Conversion::new().apply(&mut converted) else {
        return;
    };
    let scenes = Scenes {
        read,
        converted: &converted,
        is_bare: mesh == SkeletonMesh::None,
    };
    if outputs == Outputs::Fbx {
        let options = FBX_OPTIONS[usize::from(choice) % FBX_OPTIONS.len()]();
        return round_trip(&scenes, Format::Fbx, &Exporter::new().fbx(options));
    }
    round_trip(&scenes, Format::Gltf, &Exporter::new());
    if mesh == SkeletonMesh::None {
        round_trip(&scenes, Format::Bvh, &Exporter::new());
        round_trip(&scenes, Format::Mclip, &Exporter::new().max_error(CLOSE));
        round_trip(&scenes, Format::Vrma, &Exporter::new());
        if choice.is_multiple_of(8) {
            round_trip(&scenes, Format::Fbx, &Exporter::new());
        }
        if choice % 8 == 2 {
            round_trip(&scenes, Format::Vmd, &Exporter::new());
        }
        if choice % 8 == 1 {
            round_trip(&scenes, Format::Usd, &Exporter::new());
        }
        make_arrays(&converted);
    }
}

/// The scene that was read, and the scene that is written.
struct Scenes<'a> {
    read: &'a Scene,
    converted: &'a Scene,
    /// Whether it has no mesh: `verify` takes the mesh of a skin from the source file, which does not exist here.
    is_bare: bool,
}

/// Checks for an error that the format explains, or for a file that can be read back and that `verify` accepts as the
/// scene.
fn round_trip(scenes: &Scenes<'_>, format: Format, exporter: &Exporter) {
    let scene = scenes.converted;
    // Two keys may be hours apart, with a row for each frame between them.
    if rows(scene) > MOST_ROWS && (format != Format::Gltf) {
        return;
    }
    let written = match exporter.write(scene, format) {
        Ok(written) => written,
        Err(error) => return assert_reason(format, &error),
    };
    // Data that a format cannot store, such as scales in BVH, is omitted with a warning.
    let is_whole = scenes.is_bare && written.warnings.is_empty();
    let bytes = written.into_bytes().expect("the usual files stand alone");
    match format {
        Format::Gltf => check_gltf(scene, &bytes),
        Format::Bvh => check_text(&bytes),
        _ => (),
    }
    let importer = Importer::new().format(format).skeleton_mesh(SkeletonMesh::None);
    let extension = FormatInfo::of(format).extensions[0];
    let again = match importer.read(&bytes, format!("written.{extension}")) {
        Ok(again) => again,
        // A name without letters for text becomes longer, and a group becomes a node.
        Err(error) if error.code() == Code::LimitExceeded => return,
        Err(error) => panic!("{format}: what was written is refused: {error}"),
    };
    if format == Format::Bvh {
        check_bvh(scene, &again);
    }
    check_counts(scene, &again, format);
    if is_whole {
        check_verdict(scenes, &bytes, format);
    }
}

/// A writer refuses only data that its format cannot store.
fn assert_reason(format: Format, error: &Error) {
    let is_reason = matches!(
        error.code(),
        Code::Unrepresentable
            | Code::FrameTime
            | Code::NoMotion
            | Code::ErrorBound
            | Code::LimitExceeded
            | Code::NotHumanoid
            // A VRM animation is in metres, but the scene states no unit.
            | Code::UnknownUnit
            // If a file is kept whole, the reader reads more than the motion needs.
            | Code::InvalidGltf
    );
    assert!(is_reason, "{format}: no reason to refuse a scene: {error}");
    if std::env::var_os("FUZZ_REASONS").is_some() {
        eprintln!("REFUSED {format}: {error}");
    }
}

/// As many nodes and clips as the scene, where the format has all of them.
fn check_counts(scene: &Scene, again: &Scene, format: Format) {
    let joints = |scene: &Scene| scene.nodes.iter().filter(|node| node.kind != NodeKind::Group).count();
    match format {
        Format::Fbx => {
            assert!(joints(again) >= joints(scene), "{format}: joints were lost");
            assert_eq!(
                again.animations.len(),
                scene.animations.len(),
                "{format}: clips were lost"
            );
        }
        Format::Bvh => assert!(joints(again) >= joints(scene), "{format}: joints were lost"),
        // A node without motion above all joints is a group in this format.
        Format::Mclip | Format::Usd => assert_eq!(again.nodes.len(), scene.nodes.len(), "{format}: nodes were lost"),
        _ => (),
    }
}

/// The largest distance of a joint in a written file from its position in the scene, in metres, and per metre of the
/// scene's size. Single precision has seven digits, of which a chain of joints loses two.
const FARTHEST: f64 = 1e-3;
/// See [`FARTHEST`].
const FARTHEST_OF_SIZE: f64 = 1e-5;
/// The sizes of scenes that `verify` compares, in metres: larger and smaller scenes have another precision than
/// motions.
const SIZES: std::ops::RangeInclusive<f64> = 0.01..=1e4;

/// The largest error of packed clips, in metres: packed clips do not keep smaller motions.
const CLOSE: f64 = 1e-6;

/// `verify` accepts the written file as the scene.
fn check_verdict(scenes: &Scenes<'_>, bytes: &[u8], format: Format) {
    let size = size(scenes.converted);
    if !SIZES.contains(&size) {
        return;
    }
    let mut source = Cow::Borrowed(scenes.read);
    // These formats have only the first of several clips.
    if matches!(format, Format::Bvh | Format::Mclip) && source.animations.len() > 1 {
        source.to_mut().animations.truncate(1);
    }
    match Verification::of(&source, bytes) {
        Ok(verified) => assert!(
            verified.is_within(FARTHEST + FARTHEST_OF_SIZE * size),
            "{format}: what was written is not what was read: {} m, rotations {:?} m, {:?}",
            verified.max_error,
            verified.rotation_error,
            verified.findings
        ),
        Err(error) => panic!("{format}: what was written cannot be verified: {error}"),
    }
}

/// The sum of the lengths of all links, with the farthest position of each joint; or the largest distance of a joint at
/// rest, if scales make it larger.
fn size(scene: &Scene) -> f64 {
    let world = Pose::rest(scene).node_to_world;
    let lengths = world
        .iter()
        .map(|node_to_world| f64::from(node_to_world.w_axis.truncate().length()));
    let scaled = lengths.fold(0.0, f64::max);
    let rest: f64 = (scene.nodes.iter())
        .map(|node| f64::from(node.transform.w_axis.truncate().length()))
        .sum();
    let channels = scene.animations.iter().flat_map(|animation| &animation.channels);
    let farthest = channels.map(|channel| {
        let keys = channel.position_keys.values.iter();
        keys.map(|key| f64::from(key.length())).fold(0.0, f64::max)
    });
    scaled.max(rest + farthest.sum::<f64>())
}

/// A glTF file that another reader accepts, with the nodes of the scene.
fn check_gltf(scene: &Scene, glb: &[u8]) {
    let file = match ::gltf::Gltf::from_slice(glb) {
        // Invalid data in an input with meshes does not change.
        Err(_) if scene.original.is_some() => return,
        file => file.expect("what was exported is valid glTF"),
    };
    // A kept file does not have the group above several roots.
    let is_added = |node: &Node| node.kind == NodeKind::Group && node.parent.is_none() && node.name == "Roots";
    let added = usize::from(scene.original.is_some() && scene.nodes.first().is_some_and(is_added));
    assert!(file.nodes().len() + added >= scene.nodes.len());
    assert_finite(scene, &file, glb);
    let written = file.animations().len();
    assert!(written <= scene.animations.len() && (written >= 1 || !moves(scene)));
}

/// JSON has only finite numbers: a written file has `null` for other numbers, and for nothing else. In a kept file,
/// only the animations are written; the rest comes from the input, and may contain `null`.
fn assert_finite(scene: &Scene, file: &::gltf::Gltf, glb: &[u8]) {
    let length = glb.get(12..16).and_then(|four| four.first_chunk().copied());
    let json = &glb[20..20 + u32::from_le_bytes(length.expect("a chunk has a length")) as usize];
    let json: serde_json::Value = serde_json::from_slice(json).expect("what was exported is JSON");
    let is_kept = scene.original.is_some();
    assert!(is_kept || !has_null(&json), "a number of the JSON is not finite");
    let bin = file.blob.as_deref().unwrap_or_default();
    let samplers = file.animations().flat_map(|animation| animation.samplers());
    let of_animations = samplers.flat_map(|sampler| [sampler.input().index(), sampler.output().index()]);
    let of_animations: BTreeSet<usize> = of_animations.collect();
    for accessor in file.accessors() {
        let is_float = accessor.data_type() == ::gltf::accessor::DataType::F32;
        let is_written = !is_kept || of_animations.contains(&accessor.index());
        let Some(view) = accessor.view().filter(|_| is_float && is_written) else {
            continue;
        };
        // A file without a binary chunk has its buffer in a data URI.
        if !matches!(view.buffer().source(), ::gltf::buffer::Source::Bin) {
            continue;
        }
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

/// The largest number of frames times joints: more would use too much memory in formats that store every frame.
const MOST_ROWS: usize = 2000;

fn rows(scene: &Scene) -> usize {
    let frames = scene.animations.first().map_or(0, Animation::frame_count);
    frames.saturating_mul(scene.nodes.len())
}

/// Arrays of finite numbers, or an error. A point that was not seen is NaN.
fn make_arrays(scene: &Scene) {
    if rows(scene) > MOST_ROWS {
        return;
    }
    let options = ArrayOptions::new().velocities(true);
    let Ok(motion) = Arrays::of(scene, &options) else {
        return;
    };
    let velocities = motion.velocities.as_deref().unwrap_or_default();
    let all = [motion.positions.as_slice(), &motion.rotations, velocities];
    let is_right = |value: &f32| value.is_finite() || value.is_nan() && scene.has_points();
    assert!(all.into_iter().flatten().all(is_right), "arrays are not finite");
}

/// A motion of finite numbers.
fn check_text(text: &[u8]) {
    let motion = text.split(|byte| *byte == b'\n').skip_while(|line| *line != b"MOTION");
    let is_finite = |line: &[u8]| !line.windows(3).any(|word| word == b"NaN" || word == b"inf");
    assert!(
        motion.into_iter().all(is_finite),
        "a value of the BVH file is not finite"
    );
}

/// Checks the scene that is read from the written BVH. It has as many frames as the written scene. Its warnings are
/// only about duplicate names, several roots and world positions.
fn check_bvh(scene: &Scene, again: &Scene) {
    let said: Vec<_> = (again.warnings.iter())
        .filter(|warning| {
            !matches!(
                warning.code,
                Code::DuplicateName | Code::SeveralRoots | Code::WorldPositions
            )
        })
        .collect();
    assert!(said.is_empty(), "what was written deviates from the format: {said:?}");
    let frames = |scene: &Scene| scene.animations.first().map_or(1, Animation::frame_count);
    assert_eq!(frames(again), frames(scene), "frames were lost");
}

/// FBX for each program.
const FBX_OPTIONS: [fn() -> FbxOptions; 6] = [
    || FbxOptions::of_target(FbxTarget::Unreal),
    || FbxOptions::of_target(FbxTarget::Unity),
    || FbxOptions::of_target(FbxTarget::Maya),
    || FbxOptions::of_target(FbxTarget::MotionBuilder),
    || FbxOptions::new().version(FbxVersion::V7400),
    FbxOptions::default,
];

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
