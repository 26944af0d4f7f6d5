//! Terminal control characters, such as escape sequences and marks of text direction, are escaped in text and in JSON.
//! A file or stream may have them in its name, in the names of its joints, or in its error.

use std::process::Output;

use serde_json::Value;

use crate::program::{Folder, command_in, words};

/// ESC, the C1 control CSI, DEL, a mark of direction, and a line separator.
const STEERING: &str = "\u{1b}[2J\u{9b}2J\u{7f}\u{202e}\u{2066}\u{2028}";

/// A folder with a humanoid's walk and broken files. The names of the file, the folder and some joints have such
/// characters.
fn folder() -> (Folder, String) {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    let text = String::from_utf8(folder.read("cmu_short.bvh")).unwrap();
    let text = text.replace("LeftArm\n", &format!("LeftArm{}\n", STEERING.replace('\u{2028}', "")));
    let name = format!("in{STEERING}/walk{STEERING}.bvh");
    folder.write(&name, text.as_bytes());
    let wrong = text.replacen("Xposition", &format!("X{STEERING}position"), 1);
    folder.write(&format!("in{STEERING}/wrong{STEERING}.bvh"), wrong.as_bytes());
    (folder, name)
}

fn steers(c: char) -> bool {
    c.is_control() && c != '\n' || ('\u{2028}'..='\u{202e}').contains(&c) || ('\u{2066}'..='\u{2069}').contains(&c)
}

fn check(what: &str, bytes: &[u8]) {
    let text = String::from_utf8(bytes.to_vec()).unwrap();
    if let Some(line) = text.lines().find(|line| line.contains(steers)) {
        panic!("{what}: {line:?}");
    }
}

fn run(folder: &Folder, arguments: &[&str]) -> Output {
    let mut command = command_in(&folder.path(""), "--quiet");
    command.args(arguments).output().unwrap()
}

#[test]
fn words_and_json_have_no_character_that_steers_a_terminal() {
    let (folder, walk) = folder();
    let inputs = format!("in{STEERING}");
    let wrong = format!("in{STEERING}/wrong{STEERING}.bvh");
    let database = format!("{STEERING}.mdb");
    let copy = format!("in{STEERING}/copy{STEERING}.glb");
    run(&folder, &["index", &walk, "-o", &database]);
    run(&folder, &["convert", &walk, &copy]);
    let (like, step) = (format!("{walk}@0s..0.3s"), format!("nothing{STEERING}"));
    for arguments in [
        &["info", &walk][..],
        &["info", &walk, "--json"],
        &["info", &wrong],
        &["info", &format!("none{STEERING}")],
        &["skeleton", &walk],
        &["skeleton", &walk, "--json"],
        &["skeleton", &walk, "--explain"],
        &["check", &inputs],
        &["check", &inputs, "--json"],
        &["survey", &inputs],
        &["survey", &walk, "--print-job"],
        &["verify", &walk, &copy],
        &["verify", &walk, &copy, "--json"],
        &["verify", &walk, &wrong],
        &["find", &database, "--like", &like],
        &["find", &database, "--like", &like, "--json"],
        &["pose", &walk, "--tick", "0"],
        &["pose", &walk, "--tick", "0", "--json"],
        &["dump", &walk, "--json"],
        &["gait", &walk],
        &["edit", &walk, "-o", "x.glb", "--step", &step],
        &["convert", &walk, "x.glb", "--clip", STEERING],
        &["convert", &walk, "--print-job"],
        &["convert", &inputs, "-o", &format!("out{STEERING}")],
    ] {
        let output = run(&folder, arguments);
        check(&format!("{arguments:?}, output"), &output.stdout);
        check(&format!("{arguments:?}, words"), &output.stderr);
        if arguments.contains(&"--json") && output.stdout.starts_with(b"{") && arguments[0] != "check" {
            serde_json::from_slice::<Value>(&output.stdout).unwrap();
        }
    }
    // The unescaped text equals the text in the file.
    let output = run(&folder, &["check", &walk, "--json"]);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["file"], walk);
    let manifest = folder.read(&format!("out{STEERING}/mocap-manifest.jsonl"));
    check("the manifest", &manifest);
    let lines = std::str::from_utf8(&manifest).unwrap().lines();
    let inputs = lines.map(|line| serde_json::from_str::<Value>(line).unwrap()["input"].clone());
    let names = ["copy", "walk", "wrong"].into_iter().zip(["glb", "bvh", "bvh"]);
    let expected = Vec::from_iter(names.map(|(name, extension)| format!("{name}{STEERING}.{extension}")));
    assert_eq!(Vec::from_iter(inputs), expected);
}

#[test]
fn json_files_have_no_character_that_steers_a_terminal() {
    let (folder, walk) = folder();
    let inputs = format!("in{STEERING}");
    for arguments in [
        &["survey", &inputs, "-o", "rows.json", "--sarif", "rows.sarif"][..],
        &["survey", &inputs, "-o", "rows.jsonl"],
        &[
            "graph",
            &walk,
            "--window",
            "0.07",
            "--threshold",
            "2m",
            "-o",
            "graph.json",
        ],
        &["convert", &walk, "-o", "copy.bvh", "--sidecar"],
        &["clean", &walk, "-o", "clean.glb", "--report", "clean.json"],
        &[
            "edit",
            &walk,
            "-o",
            "edit.glb",
            "--step",
            "mirror",
            "--contacts",
            "contacts.json",
        ],
    ] {
        let output = run(&folder, arguments);
        assert!(
            matches!(output.status.code(), Some(0 | 3)),
            "{arguments:?}: {}",
            words(&output)
        );
    }
    let has_name = |value: &Value| value.to_string().contains(STEERING.trim_matches('\u{1b}'));
    for (name, names_a_file) in [
        ("rows.json", true),
        ("rows.sarif", true),
        ("rows.jsonl", true),
        ("graph.json", true),
        ("copy.bvh.json", true),
        ("clean.json", false),
        ("contacts.json", false),
    ] {
        let bytes = folder.read(name);
        check(name, &bytes);
        let values = serde_json::Deserializer::from_slice(&bytes).into_iter::<Value>();
        let values = Vec::from_iter(values.map(Result::unwrap));
        assert!(values.iter().any(has_name) || !names_a_file, "{name}");
    }
}
