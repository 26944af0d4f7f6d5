//! All files of an output are checked before the first is written, and all are written or none: the named file, its
//! buffer, textures, sidecar, reports and pictures.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::at_root;
use crate::program::Folder;

/// A character whose material has a texture with each of these names.
fn character(names: &[&str]) -> Value {
    let text = fs::read_to_string(at_root("fixtures/made/two_bones_textured.gltf")).unwrap();
    let mut file: Value = serde_json::from_str(&text).unwrap();
    let (image, mesh) = (file["images"][0].clone(), file["meshes"][0]["primitives"][0].clone());
    let (material, texture) = (file["materials"][0].clone(), file["textures"][0].clone());
    let all = |one: &dyn Fn(usize) -> Value| Value::from((0..names.len()).map(one).collect::<Vec<_>>());
    let with = |value: &Value, field: &str, new: Value| {
        let mut value = value.clone();
        value[field] = new;
        value
    };
    file["images"] = all(&|index| with(&image, "name", names[index].into()));
    file["textures"] = all(&|index| with(&texture, "source", index.into()));
    file["materials"] = all(&|index| {
        let mut material = material.clone();
        material["pbrMetallicRoughness"]["baseColorTexture"]["index"] = index.into();
        material
    });
    file["meshes"][0]["primitives"] = all(&|index| with(&mesh, "material", index.into()));
    file
}

fn write(folder: &Folder, name: &str, file: &Value) {
    folder.write(name, file.to_string().as_bytes());
}

#[test]
fn a_command_writes_all_of_its_outputs_or_none() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    folder.write("mine.npz", b"somebody's work");
    folder.succeeds("index cmu_short.bvh -o moves.mdb");
    let edit = "edit cmu_short.bvh -o out.glb --step mirror";
    let cases = [
        (format!("{edit} --contacts-file none/out.json"), 1, "none"),
        (format!("{edit} --contacts-file mine.npz"), 1, "output-exists"),
        (
            format!("{edit} --contacts-file out.json --curves none/out.png --joint Hips"),
            1,
            "none",
        ),
        (
            "clean cmu_short.bvh -o out.glb --report none/out.json".to_owned(),
            1,
            "none",
        ),
        (
            "survey cmu_short.bvh -o out.json --html none/out.html".to_owned(),
            1,
            "none",
        ),
        (
            "survey cmu_short.bvh -o none/out.json --html out.html --sarif out.sarif".to_owned(),
            1,
            "none",
        ),
        (
            "survey cmu_short.bvh -o out.json --html OUT.json".to_owned(),
            2,
            "one file",
        ),
        (
            "graph cmu_short.bvh --threshold 2m --window 0.07 -o out.json --matrix none/out.png".to_owned(),
            1,
            "none",
        ),
        (
            "find moves.mdb --like cmu_short.bvh@0..0.2 --sheet out.png --page none/out.html".to_owned(),
            1,
            "none",
        ),
        (
            "find moves.mdb --like cmu_short.bvh@0..0.2 --sheet none/out.png --page out.html".to_owned(),
            1,
            "none",
        ),
    ];
    for (arguments, status, reason) in cases {
        folder.refuses(&arguments, status, reason);
    }
    folder.write("features.bin", b"somebody's work");
    folder.refuses("match moves.mdb --on cmu_short.bvh -o bones.bin", 1, "output-exists");
}

#[test]
fn textures_stay_in_the_folder_and_have_names_of_their_own() {
    let long = "x".repeat(300);
    let names = [
        "..",
        "../up",
        "/etc/passwd",
        "C:\\up",
        "",
        "con",
        "con.png",
        "COM1",
        &long,
        "skin",
        "skin",
        "Skin",
        "SKIN.PNG",
        "hero",
        "hero.usda",
        "hero.fbx",
        ".hero.fbx.unfinished-abc",
        "a\nb",
        "a\u{202e}b",
        "mocap-manifest.jsonl",
    ];
    for format in ["fbx", "usda"] {
        let folder = Folder::of_real(&[]);
        write(&folder, "in/hero.gltf", &character(&names));
        fs::create_dir(folder.path("out")).unwrap();
        let beside = if format == "fbx" { " --textures beside" } else { "" };
        folder.succeeds(&format!("convert in/hero.gltf out/hero.{format}{beside}"));
        let paths = folder.contents().into_iter().map(|(path, _)| path);
        let all: Vec<_> = paths
            .map(|path| path.strip_prefix(folder.path("")).unwrap().to_owned())
            .collect();
        let made: Vec<_> = all.iter().filter(|path| path.starts_with("out")).collect();
        assert_eq!(
            (all.len(), made.len()),
            (names.len() + 2, names.len() + 1),
            "{format}: {all:?}"
        );
        let name = |path: &Path| path.file_name().unwrap().to_str().unwrap().to_lowercase();
        let distinct: BTreeSet<String> = made.iter().map(|path| name(path)).collect();
        assert_eq!(distinct.len(), made.len(), "{format}: {made:?}");
        for name in distinct {
            let stem = name.split('.').next().unwrap();
            assert!(
                !["con", "com1", ""].contains(&stem) && name.len() < 220,
                "{format}: {name}"
            );
        }
    }
}

/// An output with an unusual extension can have the same name as its texture or its buffer.
#[test]
fn an_output_is_not_its_own_texture_or_buffer() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    write(&folder, "hero.gltf", &character(&["skin"]));
    let job = |input: &str, output: &str, to: &str| {
        let fbx = json!({"textures": if to == "fbx" { "beside" } else { "embedded" }});
        let write = json!({"output": output, "to": to, "fbx": fbx, "force": true});
        json!({"source": {"inputs": [input]}, "write": write})
    };
    for (input, output, to) in [
        ("hero.gltf", "skin.png", "fbx"),
        ("hero.gltf", "SKIN.png", "fbx"),
        ("hero.gltf", "skin.png", "usda"),
        ("cmu_short.bvh", "walk.bin", "gltf"),
    ] {
        write(&folder, "job.json", &job(input, output, to));
        folder.refuses("run job.json", 2, "give each its own name");
    }
}

/// A character with its texture in a separate file, whose name differs from the texture's name.
fn character_with_image(folder: &Folder, name: &str, image: &str, bytes: &[u8]) {
    let mut file = character(&["skin"]);
    file["images"][0] = json!({"uri": Path::new(image).file_name().unwrap().to_str(), "name": "skin"});
    write(folder, name, &file);
    folder.write(image, bytes);
}

#[test]
fn an_image_of_an_input_is_never_replaced() {
    let folder = Folder::of_real(&[]);
    character_with_image(&folder, "hero.gltf", "skin.png", b"\x89PNG of the hero");
    let modified = || fs::metadata(folder.path("skin.png")).unwrap().modified().unwrap();
    let before = modified();
    // The texture's file keeps the name and the bytes of the image, and the output refers to it.
    folder.succeeds("convert hero.gltf hero.fbx --textures beside");
    folder.succeeds("convert hero.gltf hero.usda --force");
    assert_eq!(
        (modified(), folder.read("skin.png")),
        (before, b"\x89PNG of the hero".to_vec())
    );
    // Another character has a different image with the same name.
    character_with_image(&folder, "second.gltf", "second.png", b"\x89PNG of the second");
    folder.refuses("convert second.gltf out.fbx --textures beside", 1, "output-exists");
    let job = json!({
        "source": {"inputs": ["second.gltf"], "with": ["hero.gltf"]},
        "steps": ["concat:with=2"],
        "write": {"output": "out.fbx", "force": true, "fbx": {"textures": "beside"}},
    });
    write(&folder, "job.json", &job);
    let words = folder.ends_with(1, "run job.json");
    assert_eq!(folder.read("skin.png"), b"\x89PNG of the hero", "{words}");
}

/// The second character would replace the image of the first, even if files may be replaced.
#[test]
fn outputs_of_a_folder_share_only_the_same_bytes() {
    let folder = Folder::of_real(&[]);
    character_with_image(&folder, "in/a.gltf", "in/a.png", b"\x89PNG one");
    character_with_image(&folder, "in/b.gltf", "in/b.png", b"\x89PNG one");
    folder.succeeds("convert in -o same --to usda --force");
    folder.write("in/b.png", b"\x89PNG two");
    let words = folder.ends_with(3, "convert in -o out --to usda --force --threads 1");
    assert!(words.contains("another output of this run"), "{words}");
    assert!(folder.path("out/a.usda").exists() && !folder.path("out/b.usda").exists());
    assert_eq!(folder.read("out/skin.png"), b"\x89PNG one");
}
