//! Files that get further animations. Everything else keeps its bytes.

use std::collections::BTreeMap;
use std::fs;

use crate::sample::Sample;
use mocap::figure::HumanoidBone as Bone;
use mocap::glam::{Quat, Vec3};
use mocap::gltf::Character;
use mocap::scene::{Animation, Channel, Keys, NodeId};
use mocap::{Code, Importer};
use serde_json::Value;
use serde_json::value::RawValue;

/// The text of a character as no writer makes it: blanks, all spellings of numbers, sections and extensions of its own.
const TEXT: &str = r#"{ "asset" : {"version":"2.0","extras":{"a" : 1.0e0}},
  "extensionsUsed":["MY_own"],   "extensions": { "MY_own": [1.50, -0, 1E3] },
  "scene":0, "scenes":[ { "nodes":[0] } ],
  "nodes":[
    {"name":"root", "children":[1], "translation":[0,1,0.0]},
    {"name":"tip", "matrix":[1,0,0,0, 0,0,1,0, 0,-1,0,0, 0,2.50,0,1], "extras":{"keep":"me", "\u00e9":"\u00e9"}}
  ],
  "meshes": [ { "primitives":[{"attributes":{"POSITION":0}, "targets":[{"POSITION":0}]}], "name":"a mesh" } ],
  "accessors":[ {"bufferView":0,"componentType":5126,"count":1,"type":"VEC3","min":[1,2,3],"max":[1.0,2.0,3.0]} ],
  "bufferViews" : [{"buffer":0,"byteLength":12} ],
  "buffers":[ { "byteLength" : 13 , "name":"data" } ],
  "animations":[{"name":"old","channels":[{"sampler":0,"target":{"node":0,"path":"translation"}}],
    "samplers":[{"input":1,"output":2}]}]
}  "#;

fn glb(text: &str, bin: &[u8], further: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let mut chunks = vec![(b"JSON", text.as_bytes().to_vec())];
    chunks.push((b"BIN\0", bin.to_vec()));
    chunks.extend(further.iter().map(|(kind, bytes)| (*kind, bytes.to_vec())));
    let mut body = Vec::new();
    for (kind, mut bytes) in chunks {
        bytes.resize(bytes.len().next_multiple_of(4), if kind == b"JSON" { b' ' } else { 0 });
        body.extend((bytes.len() as u32).to_le_bytes());
        body.extend_from_slice(kind);
        body.extend(bytes);
    }
    let mut file = b"glTF".to_vec();
    file.extend(2_u32.to_le_bytes());
    file.extend((body.len() as u32 + 12).to_le_bytes());
    file.extend(body);
    file
}

/// The chunks of a file, each with its kind.
fn chunks(file: &[u8]) -> Vec<(Vec<u8>, Vec<u8>)> {
    let number = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!(number(8), file.len());
    let (mut at, mut chunks) = (12, Vec::new());
    while at < file.len() {
        let length = number(at);
        assert_eq!(length % 4, 0);
        chunks.push((file[at + 4..at + 8].to_vec(), file[at + 8..at + 8 + length].to_vec()));
        at += 8 + length;
    }
    chunks
}

fn sections(text: &[u8]) -> BTreeMap<String, Box<RawValue>> {
    serde_json::from_slice(text).unwrap()
}

fn character(bytes: &[u8], name: &str) -> Character {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    Importer::new().import_character(&path).unwrap()
}

/// An animation of half a second in which the last node of a scene nods.
fn nod(node: usize, name: &str) -> Animation {
    Animation {
        name: "nod".to_owned(),
        ticks_per_second: 10.0,
        duration: 5.0,
        channels: vec![Channel {
            node_name: name.to_owned(),
            node: Some(NodeId::new(node)),
            position_keys: Keys::default(),
            rotation_keys: Keys::every_tick(
                (0_u8..6)
                    .map(|key| Quat::from_rotation_x(f32::from(key) / 10.0))
                    .collect(),
            ),
            scaling_keys: Keys::default(),
        }],
    }
}

/// A character with two keys of an animation after its vertex.
fn odd_character() -> (String, Vec<u8>) {
    let accessors = concat!(
        r#","count":1,"type":"VEC3","min":[1,2,3],"max":[1.0,2.0,3.0]},"#,
        r#"{"bufferView":1,"componentType":5126,"count":2,"type":"SCALAR","min":[0],"max":[1]},"#,
        r#"{"bufferView":2,"componentType":5126,"count":2,"type":"VEC3"} ]"#
    );
    let text = TEXT
        .replace(r#","count":1,"type":"VEC3","min":[1,2,3],"max":[1.0,2.0,3.0]} ]"#, accessors)
        .replace(
            r#"{"buffer":0,"byteLength":12} ]"#,
            r#"{"buffer":0,"byteLength":12},{"buffer":0,"byteOffset":12,"byteLength":8},{"buffer":0,"byteOffset":20,"byteLength":24} ]"#,
        )
        .replace(r#""byteLength" : 13"#, r#""byteLength" : 45"#);
    let numbers = [1.0, 2.0, 3.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0_f32];
    let mut bin: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    bin.push(7);
    (text, bin)
}

#[test]
fn a_glb_keeps_every_byte_and_gets_animations() {
    let (text, bin) = odd_character();
    let file = glb(&text, &bin, &[(b"MINE", b"words")]);
    let character = character(&file, "odd.glb");
    let scene = character.scene();
    assert_eq!((scene.nodes.len(), scene.animations.len()), (2, 1));
    let written = character
        .with_animations(&[nod(1, "tip"), nod(1, "tip")], false)
        .unwrap();

    let (before, after) = (chunks(&file), chunks(&written));
    assert_eq!(before.len(), after.len());
    assert_eq!(before[2], after[2]);
    assert!(
        after[1].1.starts_with(&before[1].1),
        "the binary chunk begins as it did"
    );
    let (was, is) = (sections(&before[0].1), sections(&after[0].1));
    assert_eq!(was.keys().collect::<Vec<_>>(), is.keys().collect::<Vec<_>>());
    for (name, section) in &was {
        let (was, is) = (section.get(), is[name].get());
        match name.as_str() {
            "animations" | "accessors" | "bufferViews" => {
                let kept = was.trim_end_matches(']').trim_end();
                assert!(is.starts_with(kept), "{name}: {is}");
            }
            "buffers" => {
                let bytes = after[1].1.len();
                assert_eq!(is, was.replace("45", &bytes.to_string()));
            }
            // A node with a matrix cannot be animated.
            "nodes" => {
                let start = was.find("\"matrix\"").unwrap();
                let end = was.find(", \"extras\"").unwrap();
                assert!(is.starts_with(&was[..start]) && is.ends_with(&was[end..]), "{is}");
            }
            _ => assert_eq!(is, was, "{name}"),
        }
    }

    // The nodes, as another reader and our reader see them.
    let document = gltf::Gltf::from_slice(&written).unwrap();
    let names: Vec<_> = document
        .animations()
        .map(|animation| animation.name().unwrap().to_owned())
        .collect();
    assert_eq!(names, ["old", "nod", "nod"]);
    let animation = document.animations().nth(2).unwrap();
    let blob = document.blob.as_deref().unwrap();
    let channel = animation.channels().next().unwrap();
    let reader = channel.reader(|_| Some(blob));
    let times: Vec<f32> = reader.read_inputs().unwrap().collect();
    assert_eq!(times, [0.0, 0.1, 0.2, 0.3, 0.4, 0.5]);
    let Some(gltf::animation::util::ReadOutputs::Rotations(rotations)) = reader.read_outputs() else {
        panic!("no rotations");
    };
    let rotations: Vec<_> = rotations.into_f32().map(Quat::from_array).collect();
    assert!(rotations[5].angle_between(Quat::from_rotation_x(0.5)) < 1e-4);
    let tip = document.nodes().nth(1).unwrap();
    let (translation, rotation, scale) = tip.transform().decomposed();
    assert_eq!((translation, scale), ([0.0, 2.5, 0.0], [1.0; 3]));
    assert!(Quat::from_array(rotation).angle_between(Quat::from_rotation_x(std::f32::consts::FRAC_PI_2)) < 1e-3);
    let read = Importer::new().read(&written, "odd.glb").unwrap();
    assert_eq!(read.animations[1].channels[0].rotation_keys.len(), 6);
    assert_eq!(
        read.animations[0].channels[0].position_keys.values[1],
        Vec3::new(0.0, 2.0, 0.0)
    );
}

#[test]
fn old_animations_go_where_that_is_asked() {
    let (text, bin) = odd_character();
    let character = character(&glb(&text, &bin, &[]), "odd.glb");
    let written = character.with_animations(&[nod(1, "tip")], true).unwrap();
    let document = gltf::Gltf::from_slice(&written).unwrap();
    let names: Vec<_> = document
        .animations()
        .map(|animation| animation.name().unwrap().to_owned())
        .collect();
    assert_eq!(names, ["nod"]);
}

#[test]
fn a_gltf_without_buffers_gets_one_of_its_own() {
    let bytes = fs::read("../../fixtures/skeletons/human_cmu.gltf").unwrap();
    let character = Importer::new()
        .import_character("../../fixtures/skeletons/human_cmu.gltf")
        .unwrap();
    let last = character.scene().nodes.len() - 1;
    let name = character.scene().nodes[last].name.clone();
    let written = character.with_animations(&[nod(last, &name)], false).unwrap();
    let (was, is) = (sections(&bytes), sections(&written));
    for (name, section) in &was {
        assert_eq!(is[name].get(), section.get());
    }
    let read = Importer::new().read(&written, "a.gltf").unwrap();
    assert_eq!(read.animations[0].channels[0].node_name, name);
    assert_eq!(read.animations[0].ticks_per_second.round(), 10.0);
    assert_eq!(character.external_files().unwrap(), [""; 0]);
}

#[test]
fn files_beside_it_are_named() {
    let text = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"name":"a"}],
        "images":[{"uri":"skin%20a.png"},{"uri":"data:image/png;base64,AA=="}],"buffers":[{"uri":"b.bin","byteLength":4}]}"#;
    let character = character(text.as_bytes(), "a.gltf");
    assert_eq!(character.external_files().unwrap(), ["b.bin", "skin%20a.png"]);
    let written = character.with_animations(&[nod(0, "a")], false).unwrap();
    let value: Value = serde_json::from_slice(&written).unwrap();
    assert_eq!(value["buffers"][0]["uri"], "b.bin");
    assert_eq!(value["bufferViews"][0]["buffer"], 1);
}

#[test]
fn a_vrm_file_states_its_bones() {
    let nodes = r#""nodes":[{"name":"a","children":[1]},{"name":"b","children":[2]},{"name":"c"}]"#;
    let file = |extension: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],{nodes},"extensions":{{{extension}}}}}"#
        )
    };
    let read = |extension: &str| character(file(extension).as_bytes(), "a.vrm");
    let one = read(r#""VRMC_vrm":{"humanoid":{"humanBones":{"hips":{"node":0},"leftThumbProximal":{"node":2}}}}"#);
    let joint = |character: &Character, bone| character.humanoid().unwrap().joint(bone);
    assert_eq!(joint(&one, Bone::Hips), Some(NodeId(0)));
    assert_eq!(joint(&one, Bone::LeftThumbProximal), Some(NodeId(2)));
    // VRM 0 names the joints of a thumb like the joints of other fingers.
    let zero = r#""VRM":{"humanoid":{"humanBones":[{"bone":"hips","node":1},{"bone":"leftThumbProximal","node":2}]}}"#;
    let zero = read(zero);
    assert_eq!(joint(&zero, Bone::Hips), Some(NodeId(1)));
    assert_eq!(joint(&zero, Bone::LeftThumbMetacarpal), Some(NodeId(2)));
    assert_eq!(joint(&zero, Bone::LeftThumbProximal), None);
    assert!(
        character(file(r#""other":{}"#).as_bytes(), "a.gltf")
            .humanoid()
            .is_none()
    );

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.vrm");
    fs::write(
        &path,
        file(r#""VRMC_vrm":{"humanoid":{"humanBones":{"hips":{"node":9}}}}"#),
    )
    .unwrap();
    let error = Importer::new().import_character(&path).unwrap_err();
    assert_eq!(error.code(), Code::InvalidGltf);
    assert!(
        error
            .to_string()
            .contains("/extensions/VRMC_vrm/humanoid/humanBones/hips/node"),
        "{error}"
    );
    let error = Importer::new()
        .import_character("../../fixtures/real/cmu_short.bvh")
        .unwrap_err();
    assert_eq!(error.code(), Code::UnknownFormat);
}

/// Any bytes give an error, or a file that reads as the scene with one further animation.
#[test]
fn no_byte_that_is_wrong_or_missing_brings_it_down() {
    let (text, bin) = odd_character();
    let file = glb(&text, &bin, &[(b"MINE", b"words")]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    let mut read = 0;
    let mut examine = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        let Ok(character) = Importer::new().import_character(&path) else {
            return;
        };
        let Some(last) = character.scene().nodes.len().checked_sub(1) else {
            return;
        };
        let name = character.scene().nodes[last].name.clone();
        if let Ok(written) = character.with_animations(&[nod(last, &name)], false) {
            let again = Importer::new().read(&written, "a.glb").unwrap();
            assert_eq!(again.animations.len(), character.scene().animations.len() + 1);
            read += 1;
        }
    };
    for end in (0..file.len()).step_by(7) {
        examine(&file[..end]);
    }
    let positions = Sample::new().some(0..file.len(), 4);
    for &position in &positions {
        for flip in [1, 0x20] {
            let mut bytes = file.clone();
            bytes[position] ^= flip;
            examine(&bytes);
        }
    }
    assert!(read * file.len() / positions.len() > 500, "{read}");
}

#[test]
fn a_first_buffer_without_bytes_stays_as_it_is() {
    let text = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"name":"a"}],
        "buffers":[{"byteLength":4,"extensions":{"EXT_meshopt_compression":{"fallback":true}}}]}"#;
    let mut file = glb(text, b"", &[]);
    // Removes the empty binary chunk.
    file.truncate(file.len() - 8);
    let length = (file.len() as u32).to_le_bytes();
    file[8..12].copy_from_slice(&length);
    let written = character(&file, "a.glb")
        .with_animations(&[nod(0, "a")], false)
        .unwrap();
    let chunks = chunks(&written);
    assert_eq!(chunks.len(), 1);
    let value: Value = serde_json::from_slice(&chunks[0].1).unwrap();
    assert_eq!(value["buffers"][0]["byteLength"], 4);
    assert_eq!(value["bufferViews"][0]["buffer"], 1);
}
