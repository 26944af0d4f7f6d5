//! Compressed clips of a character that is passed through. The test reads them from the bytes of the file, and
//! positions them by its own kinematics, which share nothing with the library.

use std::collections::BTreeMap;
use std::fs;

use mocap::compress::ErrorBound;
use mocap::glam::{DQuat, DVec3, Vec3};
use mocap::gltf::report::Provenance;
use mocap::gltf::{Character, Compression, GltfOptions};
use mocap::retarget::{PoseRetargetOptions, PoseRetargeter};
use mocap::scene::{Animation, Keys};
use mocap::{Code, Conversion, Export, Importer, Result, Scene};
use serde_json::Value;

/// The largest error in metres, without the rounding of single precision.
const BOUND: f64 = 0.002;
const ROUNDING: f64 = 3e-6;

fn compressions() -> Vec<Compression> {
    let mut all = vec![Compression::None, Compression::Int16];
    if cfg!(feature = "meshopt") {
        all.extend([Compression::Meshopt, Compression::MeshoptKhr]);
    }
    all
}

fn options(compression: Compression) -> GltfOptions {
    let mut options = GltfOptions::default();
    (options.compression, options.error_bound) = (compression, Some(BOUND.into()));
    options
}

/// A character with a walk: as text without a buffer, and as a `.glb` with a mesh and its own clip.
fn characters() -> Vec<(Vec<u8>, &'static str)> {
    let text = fs::read("../../fixtures/skeletons/human_vrm1.gltf").unwrap();
    let mut other = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    Conversion::new().apply(&mut other).unwrap();
    vec![
        (text, "a.gltf"),
        (GltfOptions::default().write_glb(&other).unwrap(), "b.glb"),
    ]
}

fn import(bytes: &[u8], name: &str) -> Character {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    Importer::new().import_character(&path).unwrap()
}

fn with_clip(character: &Character, (clip, from): &(Animation, Provenance), options: &GltfOptions) -> Result<Export> {
    let motions = Scene {
        animations: vec![clip.clone()],
        ..character.scene().clone()
    };
    character.with_clips(&motions, std::slice::from_ref(from), false, options)
}

fn walk(character: &Character) -> (Animation, Provenance) {
    let motion = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    let options = PoseRetargetOptions::new().target(character.humanoid().cloned());
    let mut retargeter = PoseRetargeter::new(&motion, character.scene(), &options).unwrap();
    let animation = retargeter.animation(&motion, &motion.animations[0]);
    (animation, Provenance::of_clip(&motion, 0))
}

/// A file: its JSON and its buffers. A buffer that only holds the decoded bytes of streams is empty.
struct File {
    json: Value,
    buffers: Vec<Vec<u8>>,
}

impl File {
    fn new(bytes: &[u8]) -> Self {
        let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        let (json, chunk) = if bytes.starts_with(b"glTF") {
            assert_eq!(number(8), bytes.len());
            let end = 20 + number(12);
            assert_eq!(&bytes[end + 4..end + 8], b"BIN\0");
            (&bytes[20..end], &bytes[end + 8..end + 8 + number(end)])
        } else {
            (bytes, &[][..])
        };
        let json: Value = serde_json::from_slice(json).unwrap();
        let buffers = json["buffers"].as_array().unwrap().iter().enumerate();
        let buffers = buffers.map(|(index, buffer)| match buffer["uri"].as_str() {
            Some(uri) => {
                let text = uri.strip_prefix("data:application/octet-stream;base64,").unwrap();
                base64::Engine::decode(&base64::engine::general_purpose::STANDARD, text).unwrap()
            }
            None if index == 0 => chunk.to_vec(),
            None => Vec::new(),
        });
        Self {
            buffers: buffers.collect(),
            json: json.clone(),
        }
    }

    /// The bytes of a view. The reference decoder decodes the bytes of a stream.
    fn view(&self, index: usize) -> Vec<u8> {
        let view = &self.json["bufferViews"][index];
        let size = |object: &Value, key: &str| object[key].as_u64().unwrap_or(0) as usize;
        let of = |object: &Value| {
            let start = size(object, "byteOffset");
            self.buffers[size(object, "buffer")][start..start + size(object, "byteLength")].to_vec()
        };
        match view["extensions"].as_object().and_then(|all| all.values().next()) {
            Some(stream) => decoded(&of(stream), size(stream, "count"), stream),
            None => of(view),
        }
    }

    /// The elements of an accessor.
    fn numbers(&self, index: usize) -> Vec<Vec<f64>> {
        let accessor = &self.json["accessors"][index];
        let width = match accessor["type"].as_str().unwrap() {
            "SCALAR" => 1,
            "VEC3" => 3,
            _ => 4,
        };
        let bytes = self.view(accessor["bufferView"].as_u64().unwrap() as usize);
        let start = accessor["byteOffset"].as_u64().unwrap_or(0) as usize;
        let count = accessor["count"].as_u64().unwrap() as usize * width;
        let numbers: Vec<f64> = match accessor["componentType"].as_u64().unwrap() {
            5126 => bytes[start..][..4 * count]
                .chunks_exact(4)
                .map(|four| f32::from_le_bytes(four.try_into().unwrap()).into())
                .collect(),
            5122 => bytes[start..][..2 * count]
                .chunks_exact(2)
                .map(|two| (f64::from(i16::from_le_bytes(two.try_into().unwrap())) / 32767.0).max(-1.0))
                .collect(),
            other => panic!("component type {other}"),
        };
        numbers.chunks_exact(width).map(<[f64]>::to_vec).collect()
    }

    /// The positions of all nodes by name, at `seconds` of the last animation.
    fn positions(&self, seconds: f64) -> BTreeMap<String, DVec3> {
        let nodes = self.json["nodes"].as_array().unwrap();
        let vector = |value: &[f64]| DVec3::from_slice(value);
        let rotation = |value: &[f64]| DQuat::from_slice(value).normalize();
        let numbers = |node: &Value, key: &str| -> Option<Vec<f64>> {
            Some(
                node[key]
                    .as_array()?
                    .iter()
                    .map(|number| number.as_f64().unwrap())
                    .collect(),
            )
        };
        let mut local: Vec<(DVec3, DQuat, DVec3)> = nodes
            .iter()
            .map(|node| {
                assert!(node.get("matrix").is_none());
                (
                    numbers(node, "translation").map_or(DVec3::ZERO, |value| vector(&value)),
                    numbers(node, "rotation").map_or(DQuat::IDENTITY, |value| rotation(&value)),
                    numbers(node, "scale").map_or(DVec3::ONE, |value| vector(&value)),
                )
            })
            .collect();
        let animation = self.json["animations"].as_array().unwrap().last().unwrap();
        for channel in animation["channels"].as_array().unwrap() {
            let sampler = &animation["samplers"][channel["sampler"].as_u64().unwrap() as usize];
            assert!(sampler.get("interpolation").is_none_or(|kind| kind == "LINEAR"));
            let accessor = |key: &str| self.numbers(sampler[key].as_u64().unwrap() as usize);
            let (times, values) = (accessor("input"), accessor("output"));
            assert_eq!(times.len(), values.len());
            let next = times.partition_point(|time| time[0] <= seconds);
            let (a, b) = (next.saturating_sub(1), next.min(times.len() - 1));
            let fraction = if a == b {
                0.0
            } else {
                (seconds - times[a][0]) / (times[b][0] - times[a][0])
            };
            let node = &mut local[channel["target"]["node"].as_u64().unwrap() as usize];
            match channel["target"]["path"].as_str().unwrap() {
                "translation" => node.0 = vector(&values[a]).lerp(vector(&values[b]), fraction),
                "rotation" => node.1 = rotation(&values[a]).slerp(rotation(&values[b]), fraction),
                _ => node.2 = vector(&values[a]).lerp(vector(&values[b]), fraction),
            }
        }
        let mut found = BTreeMap::new();
        let roots = self.json["scenes"][0]["nodes"].as_array().unwrap().iter();
        let whole = (DVec3::ZERO, DQuat::IDENTITY, 1.0);
        let mut open: Vec<_> = roots.map(|node| (node.as_u64().unwrap() as usize, whole)).collect();
        while let Some((index, (position, above, scale))) = open.pop() {
            let (translation, rotation, own_scale) = local[index];
            let world = (
                position + above * translation * scale,
                above * rotation,
                scale * own_scale.x,
            );
            if let Some(name) = nodes[index]["name"].as_str() {
                found.insert(name.to_owned(), world.0);
            }
            for child in nodes[index]["children"].as_array().into_iter().flatten() {
                open.push((child.as_u64().unwrap() as usize, world));
            }
        }
        found
    }
}

#[cfg(feature = "meshopt")]
fn decoded(stream: &[u8], count: usize, settings: &Value) -> Vec<u8> {
    let stride = settings["byteStride"].as_u64().unwrap();
    match (stride, settings["filter"].as_str()) {
        (4, None) => meshopt::decode_vertex_buffer::<[u8; 4]>(stream, count)
            .unwrap()
            .concat(),
        (8, Some("QUATERNION")) => {
            let mut values: Vec<[i16; 4]> = meshopt::decode_vertex_buffer(stream, count).unwrap();
            meshopt::decode_filter_quat(&mut values);
            values.iter().flatten().flat_map(|value| value.to_le_bytes()).collect()
        }
        (12, Some("EXPONENTIAL")) => {
            let mut values: Vec<[u32; 3]> = meshopt::decode_vertex_buffer(stream, count).unwrap();
            meshopt::decode_filter_exp(&mut values);
            values.iter().flatten().flat_map(|value| value.to_le_bytes()).collect()
        }
        other => panic!("{other:?}"),
    }
}

#[cfg(not(feature = "meshopt"))]
fn decoded(_: &[u8], _: usize, settings: &Value) -> Vec<u8> {
    panic!("a stream in a build without meshopt: {settings}");
}

/// The positions of the nodes of a character in a frame of an animation with keys at all frames.
fn expected(character: &Character, animation: &Animation, frame: usize) -> BTreeMap<String, DVec3> {
    fn at<T: Copy>(keys: &Keys<T>, frame: usize) -> Option<T> {
        assert!(keys.ticks.is_none());
        keys.values.get(frame.min(keys.len().checked_sub(1)?)).copied()
    }
    let scene = character.scene();
    let mut world: Vec<(DVec3, DQuat, f64)> = Vec::new();
    let mut found = BTreeMap::new();
    for (index, node) in scene.nodes.iter().enumerate() {
        let (scale, mut rotation, mut translation) = node.transform.as_dmat4().to_scale_rotation_translation();
        let is_of_node = |node: Option<mocap::scene::NodeId>| node.is_some_and(|node| node.index() == index);
        if let Some(channel) = animation.channels.iter().find(|channel| is_of_node(channel.node)) {
            translation = at(&channel.position_keys, frame).map_or(translation, Vec3::as_dvec3);
            rotation = at(&channel.rotation_keys, frame).map_or(rotation, |value| value.as_dquat().normalize());
        }
        let parent = node.parent.map(|parent| world[parent.index()]);
        let (position, above, unit) = parent.unwrap_or((DVec3::ZERO, DQuat::IDENTITY, 1.0));
        world.push((position + above * translation * unit, above * rotation, unit * scale.x));
        found.insert(node.name.clone(), world[index].0);
    }
    found
}

/// The largest error of a node of the character, in metres.
fn largest_error(character: &Character, animation: &Animation, file: &File) -> (f64, String) {
    let mut largest = (0.0, String::new());
    for frame in 0..animation.frame_count() {
        let found = file.positions(frame as f64 / animation.ticks_per_second);
        for (name, position) in expected(character, animation, frame) {
            let error = found.get(&name).map_or(0.0, |found| found.distance(position));
            if error > largest.0 {
                largest = (error, name);
            }
        }
    }
    largest
}

#[test]
fn a_compressed_clip_of_a_character_keeps_the_bound_and_the_rest_of_the_file() {
    for (bytes, name) in characters() {
        let character = import(&bytes, name);
        let clip = walk(&character);
        let write = |options: &GltfOptions| {
            let written = with_clip(&character, &clip, options).unwrap();
            (written.error.clone(), written.into_bytes().unwrap())
        };
        let (error, plain) = write(&GltfOptions::default());
        let before: Option<File> = name.ends_with(".glb").then(|| File::new(&bytes));
        assert_eq!(error, None);
        let (error, joint) = largest_error(&character, &clip.0, &File::new(&plain));
        assert!(error < ROUNDING, "{name}, {joint}: {error}");
        for compression in compressions() {
            let what = format!("{name}, {compression:?}");
            let (error, written) = write(&options(compression));
            let achieved = error.unwrap();
            let [of_plain, of_written] = [plain.len(), written.len()].map(|length| length - bytes.len());
            // Floats have fewer keys, and each track has its own times.
            let most = of_plain * if compression == Compression::None { 9 } else { 7 } / 10;
            assert!(of_written < most, "{what}: {of_written} of {of_plain} bytes");
            let file = File::new(&written);
            let (error, joint) = largest_error(&character, &clip.0, &file);
            assert!(
                error <= BOUND + ROUNDING && error <= achieved.max_error + ROUNDING,
                "{what}, {joint}: {error}"
            );
            assert!(error > 0.1 * BOUND, "{what}: nothing is left out");
            // Everything else is unchanged.
            let original: Value = before
                .as_ref()
                .map_or_else(|| serde_json::from_slice(&bytes).unwrap(), |f| f.json.clone());
            for (key, section) in original.as_object().unwrap() {
                let now = &file.json[key];
                match key.as_str() {
                    "buffers" | "extensionsUsed" | "extensionsRequired" => {}
                    "accessors" | "bufferViews" | "animations" => {
                        let kept = section.as_array().unwrap();
                        assert_eq!(&now.as_array().unwrap()[..kept.len()], kept, "{what}, {key}");
                    }
                    _ => assert_eq!(now, section, "{what}, {key}"),
                }
            }
            if let Some(before) = &before {
                assert!(file.buffers[0].starts_with(&before.buffers[0]), "{what}");
            }
        }
    }
}

#[test]
fn a_joint_of_a_character_has_a_bound_of_its_own() {
    let (bytes, name) = characters().swap_remove(0);
    let character = import(&bytes, name);
    let clip = walk(&character);
    let joint = "wrist.L";
    let error = |bound: ErrorBound| {
        let mut options = GltfOptions::default();
        (options.compression, options.error_bound) = (Compression::Int16, Some(bound));
        let file = File::new(&with_clip(&character, &clip, &options).unwrap().into_bytes().unwrap());
        let error = |frame| {
            let found = file.positions(frame as f64 / clip.0.ticks_per_second);
            found[joint].distance(expected(&character, &clip.0, frame)[joint])
        };
        (0..clip.0.frame_count()).map(error).fold(0.0, f64::max)
    };
    let (without, with) = (
        error(ErrorBound::new(0.02)),
        error(ErrorBound::new(0.02).joint(joint, 0.001)),
    );
    assert!(
        without > 0.0015 && with <= 0.001 + ROUNDING,
        "{joint}: {without}, {with}"
    );
}

#[test]
fn what_cannot_be_compressed_is_said() {
    let (bytes, name) = characters().swap_remove(0);
    let character = import(&bytes, name);
    let clip = walk(&character);
    let mut too_fine = options(Compression::Int16);
    too_fine.error_bound = Some(1e-7.into());
    let error = with_clip(&character, &clip, &too_fine).unwrap_err();
    assert_eq!(error.code(), Code::ErrorBound);
    if cfg!(not(feature = "meshopt")) {
        let error = with_clip(&character, &clip, &options(Compression::Meshopt)).unwrap_err();
        assert_eq!(error.code(), Code::MissingFeature);
    }
}

/// A file that already has streams gets further streams.
#[cfg(feature = "meshopt")]
#[test]
fn clips_are_added_to_a_file_with_streams() {
    for (bytes, name) in characters() {
        let first = import(&bytes, name);
        let clip = walk(&first);
        let add = |onto: &Character| with_clip(onto, &clip, &options(Compression::Meshopt)).unwrap();
        let once = add(&first).into_bytes().unwrap();
        let second = import(&once, name);
        let twice = add(&second).into_bytes().unwrap();
        let file = File::new(&twice);
        for list in ["extensionsUsed", "extensionsRequired"] {
            assert_eq!(
                file.json[list],
                serde_json::json!(["EXT_meshopt_compression"]),
                "{name}"
            );
        }
        let (error, joint) = largest_error(&second, &clip.0, &file);
        assert!(error <= BOUND + ROUNDING, "{name}, {joint}: {error}");
        let read = Importer::new().read(&twice, name).unwrap();
        assert_eq!(read.animations.len(), second.scene().animations.len() + 1, "{name}");
    }
}
