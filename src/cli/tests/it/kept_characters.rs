//! A character written as glTF by `convert` and `edit`: everything except the animations is unchanged.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::at_root;
use crate::program::{Folder, run, words};
use mocap::{Exporter, Format, Importer, MemoryFile, Pose};
use serde_json::Value;

/// An accessor, and the bytes of its views.
type Accessor = (Value, Vec<Vec<u8>>);

/// A file read by the test's own reader: the JSON and the bytes of each buffer.
struct File {
    json: Value,
    buffers: Vec<Vec<u8>>,
}

impl File {
    fn read(path: &Path) -> Self {
        let bytes = fs::read(path).unwrap();
        let length = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        let (text, chunk) = match bytes.starts_with(b"glTF") {
            true => {
                let end = 20 + length(12);
                let chunk = (end < bytes.len()).then(|| bytes[end + 8..end + 8 + length(end)].to_vec());
                (bytes[20..end].to_vec(), chunk)
            }
            false => (bytes, None),
        };
        let json: Value = serde_json::from_slice(&text).unwrap();
        let buffers = json["buffers"]
            .as_array()
            .unwrap()
            .iter()
            .map(|buffer| match buffer["uri"].as_str() {
                Some(uri) => contents(uri, path),
                None => chunk.clone().unwrap_or_default(),
            });
        let buffers = buffers.collect();
        Self { json, buffers }
    }

    fn view(&self, index: &Value) -> &[u8] {
        let view = &self.json["bufferViews"][index.as_u64().unwrap() as usize];
        let number = |name: &str| view[name].as_u64().unwrap_or_default() as usize;
        let start = number("byteOffset");
        &self.buffers[number("buffer")][start..start + number("byteLength")]
    }

    /// An accessor without the indices of its buffer views, and the bytes of these views.
    fn accessor(&self, index: &Value) -> Accessor {
        let mut accessor = self.json["accessors"][index.as_u64().unwrap() as usize].clone();
        let views = ["/bufferView", "/sparse/indices/bufferView", "/sparse/values/bufferView"];
        let mut bytes = Vec::new();
        for view in views {
            if let Some(number) = accessor.pointer_mut(view) {
                bytes.push(self.view(&number.take()).to_vec());
            }
        }
        (accessor, bytes)
    }

    /// Everything except animations, with the contents of accessors and images.
    fn rest(&self, path: &Path) -> (Value, Vec<Accessor>, Vec<Vec<u8>>) {
        let mut json = self.json.clone();
        let mut accessors = Vec::new();
        for part in [
            "animations",
            "accessors",
            "bufferViews",
            "buffers",
            "images",
            "extensionsUsed",
            "extensionsRequired",
        ] {
            json.as_object_mut().unwrap().remove(part);
        }
        let items = |value: &Value| value.as_array().cloned().unwrap_or_default();
        for primitive in items(&self.json["meshes"])
            .iter()
            .flat_map(|mesh| items(&mesh["primitives"]))
        {
            let targets = items(&primitive["targets"]);
            let named = [&primitive["attributes"]].into_iter().chain(&targets);
            let named: BTreeMap<String, Value> = named
                .enumerate()
                .flat_map(|(index, names)| {
                    let names = names.as_object().unwrap().iter();
                    names.map(move |(name, accessor)| (format!("{index} {name}"), accessor.clone()))
                })
                .collect();
            accessors.extend(
                named
                    .values()
                    .chain([&primitive["indices"]])
                    .map(|index| self.accessor(index)),
            );
        }
        for skin in items(&self.json["skins"]) {
            accessors.push(self.accessor(&skin["inverseBindMatrices"]));
        }
        let images = items(&self.json["images"])
            .into_iter()
            .map(|image| match image["uri"].as_str() {
                Some(uri) => contents(uri, path),
                None => self.view(&image["bufferView"]).to_vec(),
            });
        let images = images.collect();
        (json, accessors, images)
    }
}

fn contents(uri: &str, path: &Path) -> Vec<u8> {
    use base64::Engine;
    match uri.split_once(";base64,") {
        Some((_, data)) => base64::engine::general_purpose::STANDARD.decode(data).unwrap(),
        None => fs::read(path.with_file_name(uri)).unwrap(),
    }
}

/// Characters with a mesh, a skin and textures, including a VRM and a `.gltf`, each with two retargeted motions.
fn characters(folder: &Folder) -> Vec<PathBuf> {
    let names = ["human_vrm0.vrm", "human_game_engine.glb"];
    let mut made = Vec::new();
    for name in names {
        let (output, character) = (folder.path(name), format!("fixtures/characters/{name}"));
        let motions = ["fixtures/real/cmu_short.bvh", "fixtures/real/z_up_dab.bvh"];
        done(&[
            "retarget",
            motions[0],
            motions[1],
            &character,
            "-o",
            output.to_str().unwrap(),
        ]);
        made.push(output);
    }
    made.push(at_root("fixtures/made/two_bones_textured.gltf").into());
    made
}

fn done(arguments: &[&str]) -> String {
    let output = run(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", words(&output));
    words(&output)
}

fn names(file: &File) -> Vec<&str> {
    let animations = file.json["animations"].as_array().map_or(&[][..], Vec::as_slice);
    animations
        .iter()
        .map(|animation| animation["name"].as_str().unwrap())
        .collect()
}

/// Weights of a node that has no morph targets.
#[test]
fn channels_of_morph_targets_that_go_are_counted() {
    let folder = Folder::of_real(&[]);
    let mut json: Value =
        serde_json::from_slice(&fs::read(at_root("fixtures/made/two_bones_textured.gltf")).unwrap()).unwrap();
    let channels = json["animations"][0]["channels"].as_array_mut().unwrap();
    let mut weights = channels[0].clone();
    weights["target"]["path"] = "weights".into();
    channels.push(weights);
    let input = folder.path("morph.gltf");
    fs::write(&input, json.to_string()).unwrap();
    let (input, output) = (input.to_str().unwrap(), folder.path("out.glb"));
    let said = done(&["convert", input, output.to_str().unwrap()]);
    assert!(said.contains("which are dropped: 1"), "{said}");
}

/// A skeleton without meshes cannot store morph targets.
#[test]
fn curves_of_morph_targets_that_are_lost_are_counted() {
    let folder = Folder::of_real(&[]);
    let made = ["arm_and_face", "face_alone"].map(|name| at_root(&format!("fixtures/made/{name}.gltf")));
    let output = |name: &str| folder.path(name).to_str().unwrap().to_owned();
    let said = done(&["convert", &made[0], &output("arm.glb"), "--skeleton-only"]);
    assert!(
        said.contains("warning[not-carried-over]: 1 face curve is not in the output"),
        "{said}"
    );
    let refused = run(&["convert", &made[1], &output("face.glb"), "--skeleton-only"]);
    assert_eq!(refused.status.code(), Some(1));
    let said = words(&refused);
    assert!(
        said.contains("the output would have no motion") && said.contains("4 face curves"),
        "{said}"
    );
}

#[test]
fn all_but_the_animations_is_kept() {
    let folder = Folder::of_real(&[]);
    for character in characters(&folder) {
        let before = File::read(&character);
        let clips = names(&before).len();
        let extension = character.extension().unwrap().to_str().unwrap().to_owned();
        let input = character.to_str().unwrap();
        let ways: [(&str, &[&str]); 9] = [
            ("same.glb", &["convert"]),
            ("slower.glb", &["convert", "--fps", "12"]),
            ("part.gltf", &["convert", "--trim", "0..0.5"]),
            ("embedded.gltf", &["convert", "--embed", "--in-place"]),
            ("small.glb", &["convert", "--max-error", "1mm"]),
            ("streams.glb", &["convert", "--compress", "meshopt"]),
            ("smooth", &["edit", "--step", "smooth"]),
            (
                "mirror.glb",
                &[
                    "edit",
                    "--step",
                    "reverse",
                    "--step",
                    "trim:range=0..0.5",
                    "--max-error",
                    "1mm",
                ],
            ),
            ("in-place.glb", &["convert", "--in-place"]),
        ];
        for (name, arguments) in ways {
            let is_humanoid = clips == 2;
            let streams = cfg!(feature = "meshopt") || name != "streams.glb";
            if !streams || (!is_humanoid && name == "embedded.gltf") {
                continue;
            }
            let output = match name {
                "smooth" => folder.path(&format!("smooth.{extension}")),
                name => folder.path(name),
            };
            let mut all = vec![
                arguments[0],
                input,
                "-o",
                output.to_str().unwrap(),
                "--force",
                "--verify",
            ];
            if arguments[0] == "convert" {
                all.remove(2);
            }
            all.extend(&arguments[1..]);
            let output_of = run(&all);
            let told = words(&output_of);
            assert!(output_of.status.success(), "{all:?}: {told}");
            let after = File::read(&output);
            assert!(
                before.rest(&character) == after.rest(&output),
                "{all:?}: something else was changed"
            );
            assert_eq!(names(&after), names(&before), "{all:?}");
            let [had, has] = [&before, &after].map(|file| file.json["extensionsUsed"].as_array().cloned());
            let has = has.unwrap_or_default();
            assert!(had.into_iter().flatten().all(|name| has.contains(&name)), "{all:?}");
        }
    }
}

#[test]
fn a_smaller_file_has_lost_the_keys_that_were_replaced() {
    let folder = Folder::of_real(&[]);
    let character = characters(&folder).remove(0);
    let length = |path: &Path| fs::metadata(path).unwrap().len();
    let original = length(at_root("fixtures/characters/human_vrm0.vrm").as_ref());
    let small = folder.path("small.vrm");
    let small_name = small.to_str().unwrap();
    done(&["convert", character.to_str().unwrap(), small_name, "--max-error", "1mm"]);
    let (keys, left) = (length(&character) - original, length(&small) - original);
    assert!(left < keys / 2, "{left} bytes of {keys}");
    // A second run leaves no file of the first output.
    let again = folder.path("again.vrm");
    done(&["convert", small_name, again.to_str().unwrap()]);
    done(&[
        "convert",
        again.to_str().unwrap(),
        small_name,
        "--max-error",
        "1mm",
        "--force",
    ]);
    assert!(length(&small) - original < left + left / 10);
}

#[test]
fn one_clip_is_changed_and_the_others_stay() {
    let folder = Folder::of_real(&[]);
    let character = characters(&folder).remove(1);
    let output = folder.path("second.glb");
    let arguments = [
        "edit",
        character.to_str().unwrap(),
        "-o",
        output.to_str().unwrap(),
        "--clip",
        "1",
    ];
    done(&[&arguments[..], &["--step", "reverse"]].concat());
    let scenes = [&character, &output].map(|path| mocap::import(path).unwrap());
    let [before, after] = &scenes;
    assert_eq!(before.animations[0].channels, after.animations[0].channels);
    let last = before.animations[1].duration;
    assert_eq!(last, after.animations[1].duration);
    for tick in [0.0, 7.0, last - 3.0, last] {
        let [forwards, backwards] = [(before, last - tick), (after, tick)].map(|(scene, tick)| {
            let pose = Pose::at_tick(scene, 1, tick).unwrap();
            pose.node_to_world
        });
        for (ours, theirs) in std::iter::zip(forwards, backwards) {
            assert!(ours.abs_diff_eq(theirs, 1e-5), "{ours} {theirs}");
        }
    }
}

#[test]
fn what_cannot_be_kept_is_refused_and_dropped_by_choice() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    let character = characters(&folder).remove(0);
    let (input, output) = (character.to_str().unwrap(), folder.path("out.glb"));
    let output_name = output.to_str().unwrap();
    for arguments in [&["--unit", "cm"][..], &["--up", "z"], &["--rest", "t-pose"]] {
        let refused = run(&[&["convert", input, output_name], arguments].concat());
        assert_eq!(refused.status.code(), Some(1), "{arguments:?}");
        assert!(
            words(&refused).contains("the meshes of the file cannot be kept"),
            "{}",
            words(&refused)
        );
        assert!(words(&refused).contains("--skeleton-only"));
        assert!(!output.exists());
        let told = done(
            &[
                &["convert", input, output_name, "--skeleton-only", "--force"],
                arguments,
            ]
            .concat(),
        );
        assert!(
            told.contains("skeleton-only: only the skeleton and its motion are kept"),
            "{told}"
        );
        fs::remove_file(&output).unwrap();
    }
    let told = words(&run(&["convert", input, output_name, "--mesh", "none"]));
    assert!(
        told.contains("--mesh would do nothing: the meshes of the file are kept"),
        "{told}"
    );
    let vrm = folder.path("out.vrm");
    let motion = folder.path("cmu_short.bvh");
    let glb = folder.path("human_game_engine.glb");
    for source in [motion, glb] {
        let refused = run(&["convert", source.to_str().unwrap(), vrm.to_str().unwrap()]);
        assert_eq!(refused.status.code(), Some(1));
        assert!(
            words(&refused).contains("a .vrm output needs the character of a VRM file"),
            "{}",
            words(&refused)
        );
    }
}

#[test]
fn the_library_keeps_it_too() {
    let scene = mocap::import(at_root("fixtures/characters/human_vrm0.vrm")).unwrap();
    let bytes = Exporter::new()
        .write(&scene, Format::Gltf)
        .unwrap()
        .into_bytes()
        .unwrap();
    assert_eq!(bytes, fs::read(at_root("fixtures/characters/human_vrm0.vrm")).unwrap());
    // A skeleton mesh that mocap drew is not kept.
    let mut drawn = mocap::import(at_root("fixtures/real/cmu_short.bvh")).unwrap();
    mocap::Conversion::new().apply(&mut drawn).unwrap();
    let glb = Exporter::new()
        .write(&drawn, Format::Gltf)
        .unwrap()
        .into_bytes()
        .unwrap();
    let file = MemoryFile {
        name: "a.glb",
        bytes: &glb,
    };
    assert!(Importer::new().read_among(file, &[]).unwrap().original.is_none());
}

/// In `face_alone.gltf`, one weight equals the time, and the other falls from 1 to 0.25 at 0.5 s, and to 0 at 1 s.
#[test]
fn a_mirrored_face_shows_each_shape_on_the_other_side() {
    let folder = Folder::of_real(&[]);
    let text = fs::read_to_string(at_root("fixtures/made/face_alone.gltf")).unwrap();
    let text = text
        .replace("\"smile\"", "\"mouthSmile_L\"")
        .replace("\"frown\"", "\"mouthSmile_R\"");
    folder.write("face.gltf", text.as_bytes());
    let said = folder.succeeds("edit face.gltf -o out.gltf --step mirror");
    assert_eq!(said.matches("1 pair of morph targets").count(), 2, "{said}");
    let read = Importer::new().gltf_meshes(true).morph_targets(true);
    let scene = read.import(folder.path("out.gltf")).unwrap();
    let targets = &scene.meshes[0].morph_targets;
    assert_eq!(
        (targets[0].name.as_str(), targets[1].name.as_str()),
        ("mouthSmile_L", "mouthSmile_R")
    );
    let rate = scene.animations[0].ticks_per_second;
    for (seconds, left, right) in [(0.0, 1.0, 0.0), (0.5, 0.25, 0.5), (1.0, 0.0, 1.0)] {
        let at = |target: usize| targets[target].weight_keys[0].sample(seconds * rate).unwrap();
        assert!(
            (at(0) - left).abs() < 1e-4 && (at(1) - right).abs() < 1e-4,
            "{seconds} s: {}, {}",
            at(0),
            at(1)
        );
    }
}
