//! A second run of a command replaces the outputs of the first run, because the record lists them. The formats of these
//! outputs need not name the program that wrote them. The second run never replaces other files, or outputs that were
//! changed.

use std::fs;
use std::process::Output;

use mocap::FormatInfo;
use serde_json::Value;
use sha2::Digest;

use crate::program::{Folder, command_in, words};
use crate::{at_root, cut};

/// A folder with a short walk and a separate record.
fn folder() -> Folder {
    const FRAMES: usize = 12;
    let folder = Folder::with(&[]);
    folder.write("walk.bvh", cut::first_frames("real/cmu_short.bvh", FRAMES).as_bytes());
    folder
}

/// Runs the program with the record in a subfolder.
fn run(folder: &Folder, arguments: &str) -> Output {
    let mut command = command_in(&folder.path(""), arguments);
    command.env("XDG_STATE_HOME", folder.path("state")).output().unwrap()
}

fn succeeds(folder: &Folder, arguments: &str) -> String {
    let output = run(folder, arguments);
    assert!(output.status.success(), "{arguments}: {}", words(&output));
    words(&output)
}

/// Checks that a command does not replace the file `name`.
fn refuses(folder: &Folder, arguments: &str, name: &str, why: &str) {
    let before = folder.read(name);
    let output = run(folder, arguments);
    let said = words(&output);
    assert_eq!(output.status.code(), Some(1), "{arguments}: {said}");
    assert!(
        said.contains("error[output-exists]") && said.contains(why),
        "{arguments}: {said}"
    );
    assert!(folder.read(name) == before, "{arguments}");
}

/// Runs a command twice with different options. The second run replaces the output and reports it. After a manual
/// change, the output is not replaced.
fn can_be_run_again(folder: &Folder, first: &str, second: &str, name: &str) {
    let said = succeeds(folder, first);
    assert!(!said.contains("replaced an earlier output of mocap"), "{first}: {said}");
    let made = folder.read(name);
    let said = succeeds(folder, second);
    assert!(
        said.contains(&format!("{name}: replaced an earlier output of mocap\n")),
        "{second}: {said}"
    );
    let again = folder.read(name);
    assert!(again != made, "{second}: the other option changes nothing");
    let changed = [again, b"\n".to_vec()].concat();
    folder.write(name, &changed);
    refuses(folder, first, name, "the file has changed since mocap wrote it");
    succeeds(folder, &format!("{first} --force"));
    assert!(folder.read(name) == made, "{first}");
}

#[test]
fn every_format_is_replaced_by_the_command_that_wrote_it() {
    let folder = folder();
    let formats = FormatInfo::ALL.iter().filter(|format| format.writes());
    for extension in formats.flat_map(|format| format.extensions) {
        let name = format!("made.{extension}");
        let convert = format!("convert walk.bvh {name}");
        can_be_run_again(&folder, &convert, &format!("{convert} --trim 0f..3f"), &name);
        let name = format!("edited.{extension}");
        let edit = format!("edit walk.bvh -o {name} --step");
        can_be_run_again(&folder, &format!("{edit} mirror"), &format!("{edit} reverse"), &name);
    }
}

/// Pictures, pages, tables and reports do not name the program that wrote them.
#[test]
fn a_picture_a_page_or_a_report_of_somebody_else_is_not_replaced() {
    let folder = folder();
    let edit = "edit walk.bvh -o edited.bvh --step mirror";
    for (name, command) in [
        ("p.png", "sheet walk.bvh -o p.png --poses 2 --width 480".to_owned()),
        ("p.gif", "gif walk.bvh -o p.gif".to_owned()),
        ("p.svg", "plot walk.bvh -o p.svg --joint Hips".to_owned()),
        ("p.html", "view walk.bvh -o p.html".to_owned()),
        ("s.json", "survey walk.bvh -o s.json".to_owned()),
        ("s.jsonl", "survey walk.bvh -o s.jsonl".to_owned()),
        ("s.csv", "survey walk.bvh -o s.csv".to_owned()),
        ("s.txt", "survey walk.bvh -o s.txt".to_owned()),
        ("card.html", "survey walk.bvh --html card.html".to_owned()),
        ("found.sarif", "survey walk.bvh --sarif found.sarif".to_owned()),
        ("fk.csv", "fk walk.bvh -o fk.csv".to_owned()),
        ("angles.csv", "angles walk.bvh -o angles.csv".to_owned()),
        ("contacts.json", format!("{edit} --contacts-file contacts.json")),
        ("curves.svg", format!("{edit} --curves curves.svg --joint Hips")),
    ] {
        let _ = fs::remove_file(folder.path("edited.bvh"));
        folder.write(name, b"of somebody else");
        refuses(&folder, &command, name, "mocap did not write");
        fs::remove_file(folder.path(name)).unwrap();
        let _ = fs::remove_file(folder.path("edited.bvh"));
        succeeds(&folder, &command);
        // The output is mocap's, so the same command replaces it, and the command with another input too.
        succeeds(&folder, &command);
        folder.write("other.bvh", &folder.read("walk.bvh"));
        let other = command.replace("walk.bvh", "other.bvh");
        let _ = fs::remove_file(folder.path("edited.bvh"));
        succeeds(&folder, &other);
        folder.write(name, b"changed by somebody");
        refuses(&folder, &other, name, "");
    }
}

/// The command lines of the README, with a GLB and a VRM character.
#[test]
fn heroes_are_replaced_by_the_commands_that_wrote_them() {
    let folder = folder();
    for hero in ["human_default.glb", "human_vrm0.vrm"] {
        folder.write(
            hero,
            &fs::read(at_root(&format!("fixtures/characters/{hero}"))).unwrap(),
        );
        let extension = hero.rsplit('.').next().unwrap();
        let [walk, soft, small] = ["walk", "soft", "small"].map(|name| format!("hero_{name}.{extension}"));
        let retarget = format!("retarget walk.bvh {hero} -o {walk}");
        can_be_run_again(&folder, &retarget, &format!("{retarget} --scale 1.5"), &walk);
        let edit = format!("edit {walk} -o {soft} --step");
        can_be_run_again(
            &folder,
            &format!("{edit} smooth"),
            &format!("{edit} smooth:cut-off=2"),
            &soft,
        );
        let convert = format!("convert {walk} {small} --max-error");
        can_be_run_again(&folder, &format!("{convert} 1mm"), &format!("{convert} 20mm"), &small);
        // Another motion would replace this motion.
        folder.write("other.bvh", &folder.read("walk.bvh"));
        refuses(&folder, &format!("retarget other.bvh {hero} -o {walk}"), &walk, "");
    }
}

/// A command records the new file, and may be killed before the rename. The earlier file came from another computer, so
/// this computer has no record of the file. Only the note inside the file names mocap as its writer.
#[test]
fn an_earlier_output_stays_known_where_a_command_is_killed() {
    let elsewhere = folder();
    succeeds(&elsewhere, "convert walk.bvh walk.gltf");
    let folder = folder();
    let restore = || {
        for name in ["walk.gltf", "walk.bin"] {
            folder.write(name, &elsewhere.read(name));
        }
    };
    restore();
    let trimmed = "convert walk.bvh walk.gltf --trim 0f..3f";
    succeeds(&folder, trimmed);
    let made = folder.read("walk.bin");
    restore();
    succeeds(&folder, trimmed);
    assert!(folder.read("walk.bin") == made);
    // A file that names its writer is not recorded, whatever the options are.
    for trim in ["", " --trim 0f..3f", " --trim 0f..4f", ""] {
        succeeds(&folder, &format!("fk walk.bvh -o walk.npz{trim}"));
    }
}

/// The broken motion of the input is not reported, because nothing was read.
#[test]
fn what_is_not_replaced_is_refused_before_the_work() {
    let folder = folder();
    folder.write("broken.bvh", b"HIERARCHY\nnothing");
    folder.write("body.bvh", &folder.read("walk.bvh"));
    folder.write("mine.npz", b"somebody's work");
    for name in [
        "mine.bvh",
        "mine.trc",
        "mine.vmd",
        "mine.mclip",
        "mine.glb",
        "mine.usda",
    ] {
        folder.write(name, b"somebody's work");
        for command in [
            format!("convert broken.bvh {name}"),
            format!("edit broken.bvh -o {name} --step mirror"),
            format!("retarget broken.bvh --to-skeleton body.bvh -o {name}"),
        ] {
            refuses(&folder, &command, name, "");
        }
    }
    folder.write("in/broken.bvh", b"HIERARCHY\nnothing");
    folder.write("out/broken.bvh", b"somebody's work");
    let said = words(&run(&folder, "convert in -o out --to bvh"));
    assert!(said.contains("did not write from these inputs"), "{said}");
    refuses(
        &folder,
        "edit broken.bvh -o new.bvh --step mirror --contacts mine.npz",
        "mine.npz",
        "",
    );
}

/// `*.bvh` may expand to two files, and the second may be another program's output.
#[test]
fn an_output_of_other_inputs_is_no_output_of_these() {
    let folder = folder();
    folder.write("other.bvh", &folder.read("walk.bvh"));
    succeeds(&folder, "convert other.bvh b.bvh");
    refuses(
        &folder,
        "convert walk.bvh b.bvh --digits 3",
        "b.bvh",
        "from these inputs",
    );
    // The record does not know the copy, whose name differs from the output's.
    fs::copy(folder.path("b.bvh"), folder.path("copy.bvh")).unwrap();
    refuses(
        &folder,
        "convert other.bvh copy.bvh --digits 3",
        "copy.bvh",
        "from these inputs",
    );
}

#[test]
fn a_folder_says_how_many_files_it_replaced() {
    let folder = folder();
    for name in ["a", "b", "c", "d", "e"] {
        folder.write(&format!("in/{name}.bvh"), &folder.read("walk.bvh"));
    }
    let said = succeeds(&folder, "convert in -o out --to bvh");
    assert!(!said.contains("replaced"), "{said}");
    fs::remove_file(folder.path("out/mocap-manifest.jsonl")).unwrap();
    let said = succeeds(&folder, "convert in -o out --to bvh --digits 3");
    assert!(said.contains("replaced 5 earlier outputs of mocap\n"), "{said}");
    assert!(!succeeds(&folder, "convert in -o out --to bvh -q").contains("replaced"));
    // The command writes a single output file.
    let said = succeeds(&folder, "convert in/a.bvh out/a.bvh --digits 2");
    assert!(said.contains("a.bvh: replaced an earlier output of mocap"), "{said}");
    folder.write("out/b.bvh", b"changed");
    let output = run(&folder, "convert in -o out --to bvh --digits 4");
    assert_eq!(output.status.code(), Some(3), "{}", words(&output));
    assert_eq!(folder.read("out/b.bvh"), b"changed");
}

/// Textures and buffers of an output are outputs.
#[test]
fn files_beside_an_output_are_replaced_with_it() {
    let folder = folder();
    succeeds(&folder, "convert walk.bvh out.gltf");
    let said = succeeds(&folder, "convert walk.bvh out.gltf --trim 0f..3f");
    for name in ["out.gltf", "out.bin"] {
        assert!(
            said.contains(&format!("{name}: replaced an earlier output of mocap\n")),
            "{said}"
        );
    }
    // Without the main file, only the record identifies the writer of a buffer.
    succeeds(&folder, "convert walk.bvh alone.gltf");
    fs::remove_file(folder.path("alone.gltf")).unwrap();
    let said = succeeds(&folder, "convert walk.bvh alone.gltf --trim 0f..3f");
    assert!(
        said.contains("alone.bin: replaced an earlier output of mocap"),
        "{said}"
    );
}

#[cfg(unix)]
#[test]
fn a_record_that_cannot_be_used_stops_nothing() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    let state = folder.path("state");
    let file = "state/mocap/outputs.jsonl";
    let again = |what: &str| {
        let _ = fs::remove_file(folder.path("out.bvh"));
        succeeds(&folder, "convert walk.bvh out.bvh");
        // Replacing an output with equal bytes loses nothing.
        let output = run(&folder, "convert walk.bvh out.bvh");
        assert!(output.status.success(), "{what}: {}", words(&output));
        refuses(&folder, "convert walk.bvh walk_2.bvh --digits 3", "walk_2.bvh", "");
    };
    folder.write("walk_2.bvh", &folder.read("walk.bvh"));
    folder.write(file, b"\xff\xfe{\"path\": 3}\n{\"path\":\"/\n[[[[[[\n\0\n{}");
    again("garbage");
    let text = folder.read(file);
    let text = String::from_utf8_lossy(&text);
    assert!(text.lines().last().unwrap().contains("out.bvh"), "{text}");
    let said = succeeds(&folder, "convert walk.bvh out.bvh --digits 3");
    assert!(said.contains("replaced an earlier output of mocap"), "{said}");

    fs::remove_file(folder.path(file)).unwrap();
    let made = std::process::Command::new("mkfifo").arg(folder.path(file)).status();
    assert!(made.unwrap().success());
    again("a pipe");
    fs::remove_file(folder.path(file)).unwrap();
    fs::create_dir(folder.path(file)).unwrap();
    again("a folder");
    fs::remove_dir_all(&state).unwrap();
    fs::write(&state, "a file").unwrap();
    again("no folder");
    fs::remove_file(&state).unwrap();
    fs::create_dir(&state).unwrap();
    // Root may write to a read-only folder.
    fs::set_permissions(&state, fs::Permissions::from_mode(0o500)).unwrap();
    let _ = fs::remove_file(folder.path("out.bvh"));
    succeeds(&folder, "convert walk.bvh out.bvh");
    succeeds(&folder, "convert walk.bvh out.bvh");
    fs::set_permissions(&state, fs::Permissions::from_mode(0o700)).unwrap();

    for (home, state_home) in [(None, None), (None, Some("relative")), (Some("/dev/null"), None)] {
        let _ = fs::remove_file(folder.path("out.bvh"));
        for _ in 0..2 {
            let mut command = command_in(&folder.path(""), "convert walk.bvh out.bvh");
            command.env_remove("HOME").env_remove("XDG_STATE_HOME");
            for (name, value) in [("HOME", home), ("XDG_STATE_HOME", state_home)] {
                value.map(|value| command.env(name, value));
            }
            let output = command.output().unwrap();
            assert!(output.status.success(), "{home:?} {state_home:?}: {}", words(&output));
        }
        assert!(!folder.path("relative").exists());
    }
}

#[cfg(unix)]
#[test]
fn the_record_is_the_users_alone() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    succeeds(&folder, "convert walk.bvh out.bvh");
    for (name, mode) in [("state/mocap", 0o700), ("state/mocap/outputs.jsonl", 0o600)] {
        let found = fs::metadata(folder.path(name)).unwrap().permissions().mode();
        assert_eq!(found & 0o777, mode, "{name}");
    }
}

/// Pipes, devices, and files that name their writer are not recorded. A line of the record names the input and the
/// output.
#[test]
fn the_record_has_a_line_of_each_output_that_needs_it() {
    let folder = folder();
    succeeds(&folder, "convert walk.bvh - --to bvh");
    succeeds(&folder, "sheet walk.bvh -o walk.png");
    succeeds(&folder, "fk walk.bvh -o walk.npz");
    succeeds(&folder, "convert walk.bvh out.bvh");
    let text = String::from_utf8(folder.read("state/mocap/outputs.jsonl")).unwrap();
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let [picture, line] = lines.as_slice() else {
        panic!("{text}")
    };
    assert!(picture["path"].as_str().unwrap().ends_with("walk.png"), "{text}");
    let path = folder.path("out.bvh").canonicalize().unwrap();
    assert_eq!(line["path"], path.to_str().unwrap());
    assert_eq!(line["from"], serde_json::json!(["walk.bvh"]));
    let bytes = folder.read("out.bvh");
    assert_eq!(line["bytes"], bytes.len());
    assert_eq!(line["sha256"], format!("{:x}", sha2::Sha256::digest(&bytes)));
}

/// Several processes record their outputs at the same time, and no record is lost.
#[test]
fn processes_can_note_outputs_at_once() {
    let folder = folder();
    for name in 0..12 {
        folder.write(&format!("in/{name}.bvh"), &folder.read("walk.bvh"));
    }
    let processes = Vec::from_iter((0..6).map(|number| {
        let arguments = format!("convert in -o out_{number} --to bvh -q");
        let mut command = command_in(&folder.path(""), &arguments);
        command.env("XDG_STATE_HOME", folder.path("state")).spawn().unwrap()
    }));
    for mut process in processes {
        assert!(process.wait().unwrap().success());
    }
    let text = String::from_utf8(folder.read("state/mocap/outputs.jsonl")).unwrap();
    let paths = text.lines().map(|line| {
        let line: Value = serde_json::from_str(line).unwrap();
        line["path"].as_str().unwrap().to_owned()
    });
    let paths: std::collections::BTreeSet<String> = paths.filter(|path| path.ends_with(".bvh")).collect();
    assert_eq!(paths.len(), 6 * 12);
}
