//! `--resume` skips outputs with every written byte, and trusts no other statement of a manifest.

use std::fs;

use serde_json::{Value, json};

use crate::at_root;
use crate::program::{Folder, MANIFEST};

/// A folder with a motion, and a character with a texture.
fn inputs() -> Folder {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    folder.write("in/walk.bvh", &folder.read("cmu_short.bvh"));
    let hero = fs::read_to_string(at_root("fixtures/made/two_bones_textured.gltf")).unwrap();
    let mut hero: Value = serde_json::from_str(&hero).unwrap();
    hero["images"][0]["name"] = "skin".into();
    folder.write("heroes/hero.gltf", hero.to_string().as_bytes());
    folder.write("robot.urdf", &fs::read(at_root("fixtures/robots/h1.urdf")).unwrap());
    folder
}

/// A line of a manifest, with the fields in the order of the program, which writes the input first.
fn line(record: &Value) -> String {
    let mut rest = record.clone();
    let input = rest.as_object_mut().unwrap().remove("input").unwrap();
    format!("{{\"input\":{input},{}\n", &rest.to_string()[1..])
}

#[test]
fn an_output_that_lost_bytes_is_made_again() {
    let cases = [
        ("convert in -o out", "walk.glb"),
        ("convert in -o out --to gltf", "walk.gltf"),
        ("convert in -o out --to gltf", "walk.bin"),
        ("convert in -o out --to bvh --sidecar", "walk.bvh"),
        ("convert in -o out --to bvh --sidecar", "walk.bvh.json"),
        ("convert in -o out --to fbx", "walk.fbx"),
        ("convert in -o out --to mclip", "walk.mclip"),
        ("convert heroes -o out --to usda", "hero.usda"),
        ("convert heroes -o out --to usda", "skin.png"),
        ("edit in -o out/ --step mirror", "walk.glb"),
        ("clean in -o out/ --to bvh", "walk.bvh"),
        ("retarget in --character cmu_short.bvh -o out/", "walk.glb"),
        ("robot in --robot robot.urdf -o out --to csv", "walk.csv"),
    ];
    for (command, name) in cases {
        let folder = inputs();
        folder.succeeds(command);
        let (path, resumed) = (format!("out/{name}"), format!("{command} --resume"));
        let whole = folder.read(&path);
        assert!(folder.succeeds(&resumed).contains("1 done before"), "{command}");
        // A truncated output, and a missing output.
        for bytes in [whole.len() / 2, 0, whole.len() - 1] {
            folder.write(&path, &whole[..bytes]);
            let words = folder.succeeds(&resumed);
            assert!(
                words.contains("0 done before"),
                "{command}, {name} of {bytes} bytes: {words}"
            );
            assert!(folder.read(&path) == whole, "{command}, {name} of {bytes} bytes");
        }
        fs::remove_file(folder.path(&path)).unwrap();
        assert!(folder.succeeds(&resumed).contains("0 done before"), "{command}");
        assert!(folder.read(&path) == whole, "{command}");
    }
}

/// An output that a user has changed, with the same size, is not done, and is not replaced without permission. A later
/// run compares outputs that an earlier run did not compare, without making them again.
#[test]
fn outputs_that_are_done_are_verified() {
    for to in ["glb", "bvh"] {
        let folder = inputs();
        let command = format!("convert in -o out --to {to} --trim 0..0.2");
        folder.succeeds(&command);
        let path = format!("out/walk.{to}");
        let written = || fs::metadata(folder.path(&path)).unwrap().modified().unwrap();
        let before = written();
        assert_eq!(folder.records("out")[0].get("verified"), None);
        let verifying = format!("{command} --verify --resume");
        assert!(folder.succeeds(&verifying).contains("1 done before"), "{to}");
        assert_eq!(folder.records("out").last().unwrap()["verified"], true, "{to}");
        assert_eq!(written(), before, "{to}");
        // If the input changes after it was recorded, the output is made again.
        let mut record = folder.records("out").pop().unwrap();
        record.as_object_mut().unwrap().remove("verified");
        let other = fs::read(at_root("fixtures/dialects/plain.bvh")).unwrap();
        folder.write("other/walk.bvh", &other);
        folder.succeeds(&format!("convert other -o made --to {to}"));
        let made = folder.read(&format!("made/walk.{to}"));
        folder.write(&path, &made);
        record["files"][0]["bytes"] = made.len().into();
        record["files"][0]["sha256"] = folder.records("made")[0]["files"][0]["sha256"].clone();
        folder.write(&format!("out/{MANIFEST}"), line(&record).as_bytes());
        folder.ends_with(1, &verifying);
        assert!(folder.records("out").last().unwrap()["error"].is_string(), "{to}");
        assert!(folder.read(&path) == made, "{to}");
    }
}

#[test]
fn an_output_that_was_changed_is_neither_done_nor_replaced() {
    let folder = inputs();
    let cases = [
        ("convert in -o out --to bvh", "walk.bvh"),
        ("convert heroes -o out --to usda", "skin.png"),
    ];
    for (command, name) in cases {
        folder.succeeds(command);
        let path = format!("out/{name}");
        let whole = folder.read(&path);
        let mut changed = whole.clone();
        *changed.last_mut().unwrap() ^= 1;
        folder.write(&path, &changed);
        let words = folder.ends_with(1, &format!("{command} --resume"));
        assert!(words.contains("was changed after an earlier run wrote it"), "{words}");
        assert!(folder.read(&path) == changed, "{name}");
        folder.succeeds(&format!("{command} --resume --force"));
        assert!(folder.read(&path) == whole, "{name}");
        assert!(
            folder
                .succeeds(&format!("{command} --resume"))
                .contains("1 done before"),
            "{name}"
        );
    }
}

#[test]
fn a_manifest_is_checked_before_it_is_believed() {
    let folder = inputs();
    folder.succeeds("convert in -o out");
    let [record] = folder.records("out").try_into().unwrap();
    let with = |path: &str, value: Value| {
        let mut record: Value = record.clone();
        *record.pointer_mut(path).unwrap() = value;
        line(&record)
    };
    let lines = [
        with("/files/0/bytes", json!(u64::MAX)),
        with("/files/0/bytes", json!(-1)),
        with("/bytes", json!(1.5)),
        with("/seconds", json!("long")),
        with("/files/0/name", json!("../walk.glb")),
        with("/files/0/name", json!("/dev/zero")),
        with("/files/0/name", json!("")),
        with("/files/0/name", json!("other.glb")),
        with("/files/0/sha256", json!("00")),
        with("/files", json!([])),
        with("/sha256", Value::Null),
        line(&record).replacen("\"bytes\":", "\"bytes\":1e999,\"old\":", 1),
        line(&record)[..40].to_owned(),
    ];
    let whole = folder.read("out/walk.glb");
    for line in lines {
        folder.write(&format!("out/{MANIFEST}"), line.as_bytes());
        let words = folder.succeeds("convert in -o out --resume");
        assert!(
            words.contains("1 of 1 files converted, 0 done before"),
            "{line}: {words}"
        );
        assert!(folder.read("out/walk.glb") == whole, "{line}");
    }
    folder.write(&format!("out/{MANIFEST}"), line(&record).as_bytes());
    assert!(folder.succeeds("convert in -o out --resume").contains("1 done before"));
}

#[test]
fn a_file_that_is_no_manifest_is_not_replaced() {
    let folder = inputs();
    folder.write(&format!("out/{MANIFEST}"), b"{\"mine\": 1}\n");
    folder.refuses("convert in -o out", 1, "is not a manifest");
    folder.refuses("edit in -o out/ --step mirror --resume", 1, "is not a manifest");
    folder.refuses("merge-manifest out", 1, "is not a manifest");
    folder.write("shards/mocap-manifest.1-of-2.jsonl", b"notes of mine\n");
    folder.refuses("convert in -o shards --shard 1/2", 1, "is not a manifest");
    folder.refuses("merge-manifest shards", 1, "is not a manifest");
}

/// A file with two clips, of which the record has one.
#[test]
fn a_survey_examines_a_file_again_of_which_a_clip_is_lost() {
    let folder = inputs();
    folder.write("second.bvh", &folder.read("cmu_short.bvh"));
    folder.succeeds("retarget cmu_short.bvh second.bvh --character cmu_short.bvh -o two.glb");
    folder.succeeds("survey two.glb -o rows.jsonl");
    let whole = String::from_utf8(folder.read("rows.jsonl")).unwrap();
    let lines: Vec<&str> = whole.lines().collect();
    assert_eq!(lines.len(), 2);
    for part in [
        lines[0].to_owned(),
        lines[1].to_owned(),
        [lines[0], lines[1], lines[0]].join("\n"),
    ] {
        folder.write("rows.jsonl", (part + "\n").as_bytes());
        folder.succeeds("survey two.glb -o rows.jsonl --resume");
        assert_eq!(String::from_utf8(folder.read("rows.jsonl")).unwrap(), whole);
    }
}

#[test]
fn a_database_that_lost_bytes_is_refused() {
    let folder = inputs();
    folder.succeeds("index cmu_short.bvh -o moves.mdb");
    let whole = folder.read("moves.mdb");
    for bytes in [100, whole.len() - 1] {
        folder.write("moves.mdb", &whole[..bytes]);
        let words = folder.ends_with(1, "index cmu_short.bvh -o moves.mdb --resume --force");
        assert!(words.contains("moves.mdb"), "{words}");
    }
}

#[cfg(feature = "parquet")]
#[test]
fn pack_keeps_whole_parts_and_numbers_them_with_care() {
    let folder = inputs();
    folder.write("in/second.bvh", &folder.read("cmu_short.bvh"));
    folder.succeeds("pack in -o out");
    let whole = folder.read("out/part-00000.parquet");
    assert!(folder.succeeds("pack in -o out --resume").contains("2 done before"));
    let records = folder.records("out");
    let manifest = |change: &dyn Fn(&mut Value)| {
        let mut records = records.clone();
        records.iter_mut().for_each(change);
        let lines: String = records.iter().map(line).collect();
        folder.write(&format!("out/{MANIFEST}"), lines.as_bytes());
    };
    // An output that is cut off.
    folder.write("out/part-00000.parquet", &whole[..100]);
    let words = folder.succeeds("pack in -o out --resume --force");
    assert!(words.contains("2 of 2 files packed, 0 done before"), "{words}");
    let parts = || {
        let names = folder
            .contents()
            .into_iter()
            .map(|(path, _)| path.file_name().unwrap().to_owned());
        let names = names.filter_map(|name| name.into_string().ok());
        Vec::from_iter(names.filter(|name| name.ends_with(".parquet")))
    };
    assert_eq!(parts().len(), 1);
    // A number without a successor.
    for number in [
        "18446744073709551615",
        "4294967296",
        "99999999999999999999",
        "-1",
        "+5",
        "1e3",
        "",
    ] {
        let [part] = parts().try_into().unwrap();
        fs::remove_file(folder.path("out").join(part)).unwrap();
        folder.write("out/part-00000.parquet", &whole);
        folder.write("in/third.bvh", &folder.read("cmu_short.bvh"));
        manifest(&|record| {
            if record["input"] == "second.bvh" {
                record["output"] = format!("part-{number}.parquet").into();
            }
        });
        folder.succeeds("pack in -o out --resume");
        let packed: Vec<Value> = folder.records("out");
        assert_eq!(packed.len(), 3, "{number}");
        for record in packed {
            let output = record["output"].as_str().unwrap();
            assert!(
                folder.path("out").join(output).exists() && output.len() == "part-00000.parquet".len(),
                "{number}: {record}"
            );
        }
        fs::remove_file(folder.path("in/third.bvh")).unwrap();
        parts()
            .iter()
            .skip(1)
            .for_each(|part| fs::remove_file(folder.path("out").join(part)).unwrap());
    }
}

/// A killed survey leaves the rows of the examined files in `rows.jsonl.part`, the last of them cut off.
#[test]
fn a_killed_survey_continues_with_the_rows_of_its_part() {
    let names = ["in/a.bvh", "in/b.bvh", "in/c.bvh", "in/d.bvh"];
    let folder = Folder::with(&names);
    folder.succeeds("survey in -o rows.jsonl");
    let whole = String::from_utf8(folder.read("rows.jsonl")).unwrap();
    assert!(!folder.path("rows.jsonl.part").exists());
    // A mark shows which rows come from the part.
    let marked = whole.replace("\"joints\":31", "\"joints\":77");
    let marks = whole.matches("\"joints\":31").count();
    assert_eq!(marks, 2);
    for bytes in [0, 5, marked.len() / 3, 2 * marked.len() / 3, marked.len()] {
        let part = &marked[..bytes];
        fs::remove_file(folder.path("rows.jsonl")).unwrap();
        folder.write("rows.jsonl.part", part.as_bytes());
        folder.succeeds("survey in -o rows.jsonl --resume");
        let found = String::from_utf8(folder.read("rows.jsonl")).unwrap();
        let kept = part.lines().filter(|line| marked.lines().any(|row| row == *line));
        let expected: usize = kept.map(|line| line.matches("\"joints\":77").count()).sum();
        assert_eq!(found.matches("\"joints\":77").count(), expected, "{bytes} bytes");
        assert_eq!(found.replace("\"joints\":77", "\"joints\":31"), whole);
        assert!(!folder.path("rows.jsonl.part").exists());
    }
    // Without --resume, no row comes from the part.
    folder.write("rows.jsonl.part", marked.as_bytes());
    folder.succeeds("survey in -o rows.jsonl");
    assert_eq!(folder.read("rows.jsonl"), whole.as_bytes());
    // A file of the user with this name stays.
    folder.write("rows.jsonl.part", b"notes of mine\n");
    let words = folder.ends_with(1, "survey in -o rows.jsonl --resume");
    assert!(words.contains("rows.jsonl.part"), "{words}");
    assert_eq!(folder.read("rows.jsonl.part"), b"notes of mine\n");
}
