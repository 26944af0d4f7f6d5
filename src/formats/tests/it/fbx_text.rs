//! FBX characters in text. The test prints real binary files as text by its own printer. The output then has the
//! elements and the types of the binary file, as the test's own parser reads them.

use std::collections::BTreeMap;
use std::fmt::Write;

use mocap::edit::{Reverse, Step, StepInput};
use mocap::fbx::FbxOptions;
use mocap::{Code, Importer, Pose, Scene};
use zlib_rs::{InflateConfig, decompress_slice};

/// A value with its type. Lists have the code of their type and their plain bytes.
#[derive(Clone, Debug, PartialEq)]
enum Item {
    Letter(u8),
    Short(i16),
    Int(i32),
    Long(i64),
    Double(f64),
    Text(String),
    Bytes(Vec<u8>),
    List(u8, Vec<u8>),
}

#[derive(Clone, Debug, PartialEq)]
struct Element {
    name: String,
    items: Vec<Item>,
    children: Vec<Element>,
    is_block: bool,
}

fn number<const SIZE: usize>(bytes: &[u8], at: &mut usize) -> [u8; SIZE] {
    *at += SIZE;
    bytes[*at - SIZE..*at].try_into().unwrap()
}

fn item(bytes: &[u8], at: &mut usize) -> Item {
    let [code] = number(bytes, at);
    match code {
        // Blender writes the number 1 in place of a letter.
        b'C' => match number(bytes, at) {
            [1] => Item::Letter(b'T'),
            [letter] => Item::Letter(letter),
        },
        b'Y' => Item::Short(i16::from_le_bytes(number(bytes, at))),
        b'I' => Item::Int(i32::from_le_bytes(number(bytes, at))),
        b'L' => Item::Long(i64::from_le_bytes(number(bytes, at))),
        b'D' => Item::Double(f64::from_le_bytes(number(bytes, at))),
        b'S' | b'R' => {
            let length = u32::from_le_bytes(number(bytes, at)) as usize;
            *at += length;
            let own = bytes[*at - length..*at].to_vec();
            match code {
                b'S' => Item::Text(String::from_utf8(own).unwrap()),
                _ => Item::Bytes(own),
            }
        }
        b'f' | b'd' | b'i' | b'l' => {
            let [count, packed, length] = [(); 3].map(|()| u32::from_le_bytes(number(bytes, at)) as usize);
            *at += length;
            let own = &bytes[*at - length..*at];
            let size = if matches!(code, b'f' | b'i') { 4 } else { 8 };
            let mut plain = vec![0; count * size];
            match packed {
                1 => drop(decompress_slice(&mut plain, own, InflateConfig::default())),
                _ => plain.copy_from_slice(own),
            }
            Item::List(code, plain)
        }
        other => panic!("{}", other as char),
    }
}

fn list(bytes: &[u8], at: &mut usize, end: usize, is_wide: bool) -> Vec<Element> {
    let mut found = Vec::new();
    while *at < end {
        let mut next = || match is_wide {
            true => u64::from_le_bytes(number(bytes, at)) as usize,
            false => u32::from_le_bytes(number(bytes, at)) as usize,
        };
        let (own_end, count, _) = (next(), next(), next());
        let [length] = number(bytes, at);
        *at += usize::from(length);
        if own_end == 0 {
            break;
        }
        let name = String::from_utf8(bytes[*at - usize::from(length)..*at].to_vec()).unwrap();
        let items = (0..count).map(|_| item(bytes, at)).collect();
        let is_block = *at < own_end;
        let children = list(bytes, at, own_end, is_wide);
        *at = own_end;
        found.push(Element {
            name,
            items,
            children,
            is_block,
        });
    }
    found
}

fn sections(bytes: &[u8]) -> Vec<Element> {
    let is_wide = u32::from_le_bytes(bytes[23..27].try_into().unwrap()) >= 7500;
    list(bytes, &mut 27, bytes.len(), is_wide)
}

fn numbers(code: u8, plain: &[u8]) -> String {
    let words: Vec<String> = match code {
        b'f' => plain
            .chunks(4)
            .map(|own| f32::from_le_bytes(own.try_into().unwrap()).to_string())
            .collect(),
        b'i' => plain
            .chunks(4)
            .map(|own| i32::from_le_bytes(own.try_into().unwrap()).to_string())
            .collect(),
        b'd' => plain
            .chunks(8)
            .map(|own| f64::from_le_bytes(own.try_into().unwrap()).to_string())
            .collect(),
        _ => plain
            .chunks(8)
            .map(|own| i64::from_le_bytes(own.try_into().unwrap()).to_string())
            .collect(),
    };
    // Autodesk's SDK breaks long lines after a comma.
    words
        .chunks(40)
        .map(|row| row.join(","))
        .collect::<Vec<_>>()
        .join(",\n")
}

fn print(elements: &[Element], depth: usize, text: &mut String) {
    let indent = "\t".repeat(depth);
    for element in elements {
        let word = |item: &Item| match item {
            Item::Letter(letter) => char::from(*letter).to_string(),
            Item::Short(number) => number.to_string(),
            Item::Int(number) => number.to_string(),
            Item::Long(number) => number.to_string(),
            Item::Double(number) => number.to_string(),
            Item::Text(text) => {
                let text = match text.split_once("\0\u{1}") {
                    Some((name, class)) => format!("{class}::{name}"),
                    None => text.clone(),
                };
                format!("\"{}\"", text.replace('"', "&quot;"))
            }
            Item::Bytes(bytes) => {
                use base64::Engine;
                format!(
                    ",\n{indent}\"{}\"",
                    base64::engine::general_purpose::STANDARD.encode(bytes)
                )
            }
            Item::List(code, plain) => {
                let size = if matches!(code, b'f' | b'i') { 4 } else { 8 };
                let count = plain.len() / size;
                format!("*{count} {{\n{indent}\ta: {}\n{indent}}} ", numbers(*code, plain))
            }
        };
        let words: Vec<String> = element.items.iter().map(word).collect();
        write!(text, "{indent}{}: {}", element.name, words.join(", ")).unwrap();
        if element.is_block && !element.items.iter().any(|item| matches!(item, Item::List(..))) {
            text.push_str(" {\n");
            print(&element.children, depth + 1, text);
            write!(text, "{indent}}}").unwrap();
        }
        text.push('\n');
    }
}

/// The text of a binary file.
fn in_text(bytes: &[u8]) -> String {
    let mut text = "; FBX project file\n; ----\n\n".to_owned();
    let of_binary = ["FileId", "CreationTime", "Creator"];
    let own: Vec<Element> = sections(bytes)
        .into_iter()
        .filter(|section| !of_binary.contains(&section.name.as_str()))
        .collect();
    print(&own, 0, &mut text);
    text
}

fn read(bytes: &[u8]) -> Scene {
    Importer::new().morph_targets(true).read(bytes, "a.fbx").unwrap()
}

/// The objects of a file except its animations, by their numbers.
fn objects(bytes: &[u8]) -> BTreeMap<i64, Element> {
    let all = sections(bytes)
        .into_iter()
        .find(|section| section.name == "Objects")
        .unwrap();
    let own = all
        .children
        .into_iter()
        .filter(|object| !object.name.starts_with("Animation"));
    own.map(|object| match object.items[0] {
        Item::Long(id) => (id, object),
        _ => panic!("{object:?}"),
    })
    .collect()
}

#[test]
fn a_character_in_text_keeps_its_data() {
    for path in [
        "characters/arnaud.fbx",
        "real/animation_with_skeleton.fbx",
        "real/huesitos.fbx",
        "made/six_influences.fbx",
    ] {
        let binary = std::fs::read(format!("../../fixtures/{path}")).unwrap();
        let mut scene = read(in_text(&binary).as_bytes());
        let before = read(&binary);
        Reverse::new().apply(&mut scene, &StepInput::new()).unwrap();
        let (output, report) = FbxOptions::default().write(&scene).unwrap();
        assert!(
            report.is_kept && report.warnings.is_empty(),
            "{path}: {:?}",
            report.warnings
        );
        let (ours, theirs) = (objects(&output), objects(&binary));
        assert_eq!(ours.len(), theirs.len(), "{path}");
        for (id, object) in &theirs {
            assert_eq!(ours.get(id), Some(object), "{path}");
        }
        // The clip is the reversed clip of the binary file.
        let after = read(&output);
        let last = before.animations[0].duration;
        for tick in [0.0, (last / 2.0).floor(), last] {
            let [forwards, backwards] = [(&before, last - tick), (&after, tick)]
                .map(|(scene, tick)| Pose::at_tick(scene, 0, tick).unwrap().node_to_world);
            for (a, b) in std::iter::zip(forwards, backwards) {
                let apart = a.w_axis.truncate().distance(b.w_axis.truncate());
                assert!(apart < 1e-4, "{path}, tick {tick}: {apart}");
            }
        }
    }
}

#[test]
fn a_text_that_cannot_be_kept_says_why() {
    let binary = std::fs::read("../../fixtures/real/huesitos.fbx").unwrap();
    let text = in_text(&binary);
    let scene = read(text.as_bytes());
    for (from, to, reason) in [
        (
            "FBXVersion: 7400",
            "FBXVersion: 6100",
            "it is text of the version 6100, below 7000",
        ),
        ("FBXVersion: 7400", "Version: 7400", "its text states no version"),
        ("Version: 1000", "Version 1000", "its text is not understood in line "),
    ] {
        let mut broken = scene.clone();
        broken.metadata.fbx.as_mut().unwrap().bytes = text.replacen(from, to, 1).into_bytes().into();
        let (_, report) = FbxOptions::default().write(&broken).unwrap();
        let warning = &report.warnings[0];
        assert!(!report.is_kept && warning.code == Code::NotCarriedOver, "{warning:?}");
        assert!(warning.message.contains(reason), "{warning:?}");
    }
    // No change of a few bytes makes the writer panic.
    let mut seed = 7_u32;
    for _ in 0..60 {
        let mut bytes = text.clone().into_bytes();
        for _ in 0..4 {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let at = seed as usize % bytes.len();
            bytes[at] = b"{}*\",:;\n0aT"[(seed >> 24) as usize % 11];
        }
        let mut broken = scene.clone();
        broken.metadata.fbx.as_mut().unwrap().bytes = bytes.into();
        drop(FbxOptions::default().write(&broken));
    }
}
