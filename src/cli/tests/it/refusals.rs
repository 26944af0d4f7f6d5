//! Extreme option values and invalid text give an error, and no signal ends the program.

use std::fs::OpenOptions;
use std::process::Stdio;

use crate::program::{Folder, command, words};

#[test]
fn sizes_of_pictures_are_looked_at_before_memory_is_asked_for() {
    let folder = Folder::with(&["w.bvh"]);
    for (arguments, status) in [
        ("gif w.bvh -o w.gif --width 0", 2),
        ("gif w.bvh -o w.gif --width 100000", 2),
        ("gif w.bvh -o w.gif --width 16384 --height 16384", 2),
        ("sheet w.bvh -o w.png --width 4000000000", 2),
        ("plot w.bvh --joint Wrist -o w.svg --width 4000000000", 2),
        ("plot w.bvh --joint Wrist -o w.png --width 0", 2),
    ] {
        folder.ends_with(status, arguments);
    }
}

/// A plot has a row for each joint. A message lists a readable number of names.
#[test]
fn a_plot_of_thousands_of_joints_is_refused() {
    const JOINTS: usize = 3000;
    let joint = |index| format!("JOINT j{index} {{ OFFSET 0 1 0 CHANNELS 1 Xrotation End Site {{ OFFSET 0 1 0 }} }}\n");
    let joints: String = (0..JOINTS).map(joint).collect();
    let root = "HIERARCHY ROOT r { OFFSET 0 0 0 CHANNELS 1 Yrotation\n";
    let row = "7 ".repeat(JOINTS + 1);
    let folder = Folder::with(&[]);
    let text = format!("{root}{joints}}}\nMOTION\nFrames: 2\nFrame Time: 0.1\n{row}\n{row}\n");
    folder.write("many.bvh", text.as_bytes());
    let all: String = (0..JOINTS).map(|index| format!(" --joint j{index}")).collect();
    let said = folder.ends_with(1, &format!("plot many.bvh -o a.png{all}"));
    assert!(said.contains("the size of the picture is not valid"), "{said}");
    let said = folder.ends_with(2, "plot many.bvh -o a.png --joint nobody");
    assert!(
        said.contains("`mocap dump FILE` prints every node") && said.len() < 1500,
        "{said}"
    );
}

#[test]
fn more_threads_than_a_system_has_are_fewer() {
    let folder = Folder::with(&["a.bvh", "b.bvh"]);
    folder.succeeds("convert a.bvh b.bvh -o out --threads 99999999999");
    folder.succeeds("convert a.bvh a.glb --threads 99999999999");
}

#[test]
fn two_outputs_of_one_name_are_refused_before_the_first_is_written() {
    let folder = Folder::with(&["w.bvh"]);
    for arguments in [
        "survey w.bvh -o s.csv --html s.csv",
        "survey w.bvh -o s.csv --sarif ./s.csv",
        "survey w.bvh --sarif s.csv --html s.csv",
        "clean w.bvh -o out.glb --report ./out.glb",
        "clean w.bvh -o out.bvh --report out.bvh.json",
        "edit w.bvh -o out.npz --step mirror --contacts-file out.npz",
        "edit w.bvh -o out.bvh --step mirror --contacts-file out.bvh.json",
    ] {
        folder.ends_with(2, arguments);
        assert_eq!(folder.contents().len(), 1, "{arguments}");
    }
}

#[test]
fn a_file_where_a_folder_is_needed_is_said_to_be_one() {
    let folder = Folder::with(&["w.bvh", "a.bvh"]);
    folder.write("notes", b"mine");
    for arguments in [
        "convert w.bvh a.bvh -o notes",
        "edit w.bvh a.bvh --step mirror -o w.bvh/",
    ] {
        let said = folder.ends_with(2, arguments);
        assert!(said.contains(": this is a file"), "{arguments}: {said}");
    }
    let said = folder.ends_with(2, "convert w.bvh a.bvh -o w.bvh");
    assert!(said.contains("w.bvh: several inputs need an output folder"), "{said}");
}

#[cfg(target_os = "linux")]
#[test]
fn help_for_a_full_disk_is_a_failure() {
    for arguments in [&["--help"][..], &["--version"], &["convert", "--help"]] {
        let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
        let status = command(arguments).stdout(full).stderr(Stdio::null()).status().unwrap();
        assert_eq!(status.code(), Some(1), "{arguments:?}");
        assert!(command(arguments).output().unwrap().status.success(), "{arguments:?}");
    }
}

#[test]
fn control_characters_of_arguments_reach_no_terminal() {
    for arguments in [
        &["convert", "a.bvh", "b.glb", "--unit", "\u{1b}]0;T\u{7}\r\u{8}"][..],
        &["convert", "a.bvh", "b.glb", "--\u{1b}[2J\u{8}"],
        &["conv\u{8}ert"],
        &["info", "\u{1b}]0;T\u{7}.bvh"],
        &[
            "plot",
            "fixtures/real/lecture_Test.bvh",
            "-o",
            "a.svg",
            "--joint",
            "\u{1b}[2J",
        ],
    ] {
        let output = command(arguments).output().unwrap();
        let said = words(&output);
        assert!(!output.status.success(), "{arguments:?}");
        assert!(said.chars().all(|c| c == '\n' || !c.is_control()), "{said:?}");
    }
}
