//! The files that outputs may replace: never an input, and no file that may be a source. Unreadable entries are failed
//! rows.

use std::fs;

use crate::at_root;
use crate::program::{Folder, words};

#[test]
fn the_second_file_of_a_wildcard_is_not_an_output() {
    let folder = Folder::with(&["a.bvh", "b.bvh"]);
    folder.refuses("convert a.bvh b.bvh", 1, "error[output-exists]");
    assert!(words(&folder.run("convert a.bvh b.bvh")).contains("a folder, with --output"));
    folder.succeeds("convert a.bvh");
    folder.succeeds("convert b.bvh");
    folder.refuses("convert a.glb b.glb", 1, "error[output-exists]");
    folder.succeeds("convert a.bvh b.bvh --force");
    assert!(folder.run("info b.bvh").status.success());
}

/// A shell opens the file for standard input, whose name is then `-`.
#[cfg(unix)]
#[test]
fn the_file_that_standard_input_reads_is_an_input() {
    let folder = Folder::with(&["w.bvh"]);
    folder.succeeds("convert w.bvh w.glb");
    for copy in ["w.csv", "w.html", "w.gif"] {
        fs::copy(folder.path("w.bvh"), folder.path(copy)).unwrap();
    }
    for (arguments, input) in [
        ("edit - -o w.glb --step in-place", "w.glb"),
        ("convert - w.glb --force", "w.glb"),
        ("convert - w.bvh --trim 0..1 --force", "w.bvh"),
        ("fk - -o w.csv", "w.csv"),
        ("view - -o w.html", "w.html"),
        ("gif - -o w.gif", "w.gif"),
        ("retarget - --character w.glb -o w.bvh --force", "w.bvh"),
    ] {
        let before = folder.read(input);
        let output = folder.run_with_input(arguments, input);
        assert_eq!(output.status.code(), Some(1), "{arguments}: {}", words(&output));
        assert!(
            words(&output).contains("error[output-is-input]"),
            "{arguments}: {}",
            words(&output)
        );
        assert!(folder.read(input) == before, "{arguments}");
    }
    // A pipe is not a file, and its output may be replaced.
    for _ in 0..2 {
        let output = folder.run_with_input("convert - other.glb", "w.bvh");
        assert!(output.status.success(), "{}", words(&output));
    }
}

#[test]
fn an_output_that_is_an_input_is_refused() {
    let folder = Folder::with(&["w.bvh", "in/w.bvh"]);
    let code = "error[output-is-input]";
    for arguments in [
        "convert w.bvh w.bvh --trim 0..1",
        "convert w.bvh w.bvh --force",
        "convert w.bvh in/../w.bvh --force",
    ] {
        folder.refuses(arguments, 1, code);
    }
    fs::copy(folder.path("w.bvh"), folder.path("w.html")).unwrap();
    folder.refuses("view w.html -o w.html", 1, code);
    folder.refuses("view w.bvh w.html -o w.html", 1, code);
    for output in ["w.csv", "w.npz", "w.png", "w.svg", "w.gif"] {
        fs::rename(folder.path("w.html"), folder.path(output)).unwrap();
        let command = match output {
            "w.png" => "sheet w.bvh",
            "w.svg" => "plot --joint Elbow",
            "w.gif" => "gif",
            _ => "fk",
        };
        folder.refuses(&format!("{command} {output} -o {output}"), 1, code);
        fs::rename(folder.path(output), folder.path("w.html")).unwrap();
    }
    folder.succeeds("convert w.bvh pair.gltf");
    folder.refuses("convert pair.gltf pair.gltf --force", 1, code);
    // The buffer of an input is an input.
    fs::rename(folder.path("pair.gltf"), folder.path("other.gltf")).unwrap();
    folder.refuses("convert other.gltf pair.gltf --force", 1, code);

    let before = folder.read("in/w.bvh");
    let output = folder.run("convert in -o in --to bvh --force");
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(folder.read("in/w.bvh"), before);
    let record = &folder.records("in")[0];
    assert!(
        record["error"].as_str().unwrap().contains("replace one of the inputs"),
        "{record}"
    );
    assert!(record["output"].is_null());
}

/// Files named by options and the job of `run` are also inputs.
#[test]
fn an_output_that_an_option_names_is_refused() {
    let folder = Folder::of_real(&["cmu_short.bvh", "cmu_02.asf", "cmu_02_01.amc", "hand_take.c3d"]);
    folder.succeeds("index cmu_short.bvh -o moves.mdb");
    let real = |name: &str| folder.read(name);
    let fixture = |name: &str| fs::read(at_root(&format!("fixtures/{name}"))).unwrap();
    let job = br#"{"source": {"inputs": ["cmu_short.bvh"]}, "write": {"output": "own.glb", "force": true}}"#;
    folder.write("p.npy", &fixture("arrays/points_smpl22.npy"));
    folder.write("smplh.npz", &fixture("arrays/shaped_smplh.npz"));
    for (bytes, arguments) in [
        (
            real("cmu_short.bvh"),
            "convert smplh.npz own.glb --body own.glb --force",
        ),
        (
            real("cmu_02.asf"),
            "convert cmu_02_01.amc own.glb --skeleton own.glb --force",
        ),
        (
            real("hand_take.c3d"),
            "solve hand_take.c3d --markers auto --static own.glb -o own.glb --force",
        ),
        (
            b"{}".to_vec(),
            "solve hand_take.c3d --markers own.glb -o own.glb --force",
        ),
        (b"[]".to_vec(), "solve p.npy --joint-set own.glb -o own.glb --force"),
        (
            real("moves.mdb"),
            "match own.glb --path 0/0+0/1 --on cmu_short.bvh -o own.glb --force",
        ),
        (
            fixture("robots/h1.urdf"),
            "robot cmu_short.bvh --robot own.glb -o own.glb --force",
        ),
        (job.to_vec(), "run own.glb"),
    ] {
        folder.write("own.glb", &bytes);
        folder.refuses(arguments, 1, "error[output-is-input]");
        assert!(folder.read("own.glb") == bytes, "{arguments}");
    }
    for (arguments, input) in [
        ("survey own.json -o own.json", "own.json"),
        ("survey cmu_short.bvh own.html -o new.json --html own.html", "own.html"),
        ("clean own.json -o new.glb --report own.json", "own.json"),
        (
            "edit own.json -o new.glb --step mirror --contacts-file own.json",
            "own.json",
        ),
        ("index own.mdb -o own.mdb", "own.mdb"),
    ] {
        folder.write(input, &real("cmu_short.bvh"));
        folder.refuses(&format!("{arguments} --force"), 1, "error[output-is-input]");
        assert!(folder.read(input) == real("cmu_short.bvh"), "{arguments}");
    }
}

#[cfg(unix)]
#[test]
fn an_output_that_is_an_input_through_a_link_is_refused() {
    use std::os::unix::fs::symlink;
    let folder = Folder::with(&["w.bvh", "in/a.bvh"]);
    symlink("w.bvh", folder.path("link.bvh")).unwrap();
    symlink("w.bvh", folder.path("link.png")).unwrap();
    symlink("in", folder.path("out")).unwrap();
    fs::hard_link(folder.path("w.bvh"), folder.path("hard.bvh")).unwrap();
    for arguments in [
        "convert w.bvh link.bvh --force",
        "convert link.bvh w.bvh --force",
        "convert w.bvh hard.bvh --force",
        "sheet w.bvh -o link.png",
    ] {
        folder.refuses(arguments, 1, "error[output-is-input]");
    }
    folder.refuses("sheet in/a.bvh -o link.png", 1, "error[output-exists]");
    let before = folder.read("in/a.bvh");
    assert_eq!(folder.run("convert in -o out --to bvh --force").status.code(), Some(1));
    assert_eq!(folder.read("in/a.bvh"), before);
}

#[test]
fn a_command_can_be_run_again() {
    let folder = Folder::with(&["w.bvh", "in/a.bvh", "in/b.bvh"]);
    for arguments in [
        "convert w.bvh w.glb",
        "convert w.bvh w.glb --trim 0f..3f",
        "convert w.bvh pair.gltf",
        "convert w.bvh pair.gltf --trim 0f..3f",
        "convert in/a.bvh pair.gltf",
        "convert w.bvh inside.gltf --embed",
        "convert w.glb again.glb",
        "convert w.bvh again.bvh",
        "convert in -o out",
        "convert in -o in",
        "convert in -o bvh --to bvh",
        "convert in -o bvh --to bvh --digits 3",
        "convert in -o in",
        "convert . -o out",
        "fk w.bvh -o w.csv",
        "view w.bvh -o w.html",
        "view in -o list.html",
        "sheet w.bvh -o w.png",
    ] {
        folder.succeeds(arguments);
        folder.succeeds(arguments);
    }
    // A BVH file cannot name its writer. The record has its path, but not the paths of copies.
    folder.succeeds("convert w.bvh again.bvh --digits 3");
    fs::copy(folder.path("again.bvh"), folder.path("copy.bvh")).unwrap();
    folder.refuses("convert w.bvh copy.bvh --digits 4", 1, "error[output-exists]");
    folder.succeeds("convert w.bvh copy.bvh --digits 4 --force");
    fs::write(folder.path("empty.bvh"), "").unwrap();
    folder.succeeds("convert w.bvh empty.bvh");
    // A manually changed output is not replaced, and other files continue.
    fs::write(folder.path("bvh/a.bvh"), "changed").unwrap();
    let output = folder.run("convert in -o bvh --to bvh --digits 5");
    assert_eq!(output.status.code(), Some(3), "{}", words(&output));
    assert_eq!(folder.read("bvh/a.bvh"), b"changed");
}

#[test]
fn a_file_of_another_program_is_replaced_by_force_alone() {
    let folder = Folder::with(&["w.bvh"]);
    for name in ["a.glb", "a.gltf", "a.GLB", "a.bin"] {
        folder.write(name, br#"{"asset": {"version": "2.0", "extras": {"title": "mocap"}}}"#);
        let output = name.replace("bin", "gltf");
        folder.refuses(&format!("convert w.bvh {output}"), 1, "error[output-exists]");
        folder.succeeds(&format!("convert w.bvh {output} --force"));
        folder.succeeds(&format!("convert w.bvh {output}"));
        for name in ["a.glb", "a.gltf", "a.GLB", "a.bin"] {
            let _ = fs::remove_file(folder.path(name));
        }
    }
}

#[test]
fn inputs_that_claim_one_output_are_refused() {
    let folder = Folder::with(&["a/w.bvh", "b/w.bvh", "c/w.bvh", "c/w.bvh.bvh"]);
    fs::write(folder.path("c/w.asf"), "").unwrap();
    for arguments in [
        "convert a/w.bvh b/w.bvh -o out",
        "convert c/w.bvh c/w.asf c/w.bvh.bvh -o out",
    ] {
        let output = folder.run(arguments);
        assert_eq!(output.status.code(), Some(2), "{}", words(&output));
        assert!(words(&output).contains("name"), "{}", words(&output));
        assert!(!folder.path("out").exists());
    }
}

#[cfg(unix)]
#[test]
fn links_without_a_target_and_loops_are_rows_of_the_manifest() {
    use std::os::unix::fs::symlink;
    let folder = Folder::with(&["in/a.bvh", "in/sub/b.bvh"]);
    symlink("nowhere.bvh", folder.path("in/gone.bvh")).unwrap();
    symlink("nowhere.txt", folder.path("in/notes.txt")).unwrap();
    symlink("..", folder.path("in/sub/up")).unwrap();
    let output = folder.run("convert in -o out");
    assert_eq!(output.status.code(), Some(3), "{}", words(&output));
    let rows = folder.records("out");
    let errors: Vec<_> = rows
        .iter()
        .map(|row| (row["input"].as_str().unwrap(), row["error"].as_str().unwrap_or("")))
        .collect();
    assert_eq!(errors.len(), 4, "{errors:?}");
    assert_eq!(errors[0], ("a.bvh", ""));
    assert!(
        errors[1].0 == "gone.bvh" && errors[1].1.contains("does not exist"),
        "{errors:?}"
    );
    assert_eq!(errors[2], ("sub/b.bvh", ""));
    assert!(
        errors[3].0 == "sub/up" && errors[3].1.contains("which contains it"),
        "{errors:?}"
    );
    for arguments in ["check in", "check in --json", "view in -o list.html"] {
        let output = folder.run(arguments);
        assert_eq!(output.status.code(), Some(3), "{arguments}: {}", words(&output));
    }
}

#[test]
fn an_empty_folder_is_an_error_unless_it_is_allowed() {
    let folder = Folder::with(&["w.bvh"]);
    folder.write("in/notes.txt", b"no motion");
    for arguments in [
        "convert in -o out",
        "convert w.bvh in -o out",
        "convert in/*.bvh -o out",
        "check in",
        "view in -o list.html",
    ] {
        let output = folder.run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments}: {}", words(&output));
        assert!(words(&output).contains("--allow-empty"), "{}", words(&output));
        folder.succeeds(&format!("{arguments} --allow-empty"));
    }
}

/// Tables of points may be a user's capture and are kept. Arrays of this program and lists of clips are replaced.
#[test]
fn tables_of_points_are_not_replaced() {
    let folder = Folder::with(&["w.bvh"]);
    let points = b"frame,joint,x,y,z\n0,hip,0,1,0\n";
    folder.write("mine.csv", points);
    folder.refuses("fk w.bvh -o mine.csv", 1, "error[output-exists]");
    assert_eq!(folder.read("mine.csv"), points);
    folder.succeeds("fk w.bvh -o mine.csv --force");
    folder.succeeds("fk w.bvh -o mine.csv --velocities");
    folder.succeeds("survey w.bvh -o list.csv");
    let list = [folder.read("list.csv"), b"a note\n".to_vec()].concat();
    folder.write("list.csv", &list);
    folder.refuses(
        "survey w.bvh -o list.csv",
        1,
        "the file has changed since mocap wrote it",
    );
    // A list that the record does not know may be a user's.
    folder.write("other.csv", &list);
    folder.refuses("survey w.bvh -o other.csv", 1, "that mocap did not write");
    folder.succeeds("survey w.bvh -o other.csv --force");
    folder.write("mine.parquet", b"PAR1 of another program PAR1");
    let output = folder.run("fk w.bvh -o mine.parquet");
    assert_ne!(output.status.code(), Some(0));
    assert_eq!(folder.read("mine.parquet"), b"PAR1 of another program PAR1");
}

/// Folders of motions often contain tables, which are reported and skipped.
#[test]
fn a_folder_names_the_tables_that_it_leaves_out() {
    let folder = Folder::with(&["in/w.bvh"]);
    folder.succeeds("survey in -o in/list.csv");
    folder.write("in/points.csv", b"frame,joint,x,y,z\n0,hip,0,1,0\n1,hip,0,1,0.1\n");
    folder.write("in/pack.parquet", b"PAR1");
    let output = folder.run("check in");
    let said = words(&output);
    assert!(
        said.contains("tables, not motions") && said.contains("list.csv") && said.contains("pack.parquet"),
        "{said}"
    );
    assert!(!said.contains("points.csv:"), "{said}");
}

#[cfg(feature = "parquet")]
#[test]
fn pack_removes_no_file_of_another_program() {
    let folder = Folder::with(&["in/a.bvh"]);
    folder.succeeds("pack in -o out");
    folder.succeeds("pack in -o out");
    folder.write("out/part-00007.parquet", b"PAR1 of another program PAR1");
    let before = folder.contents();
    let output = folder.run("pack in -o out");
    assert_eq!(output.status.code(), Some(1), "{}", words(&output));
    assert!(folder.contents() == before);
}

#[test]
fn merging_manifests_removes_no_other_file() {
    let folder = Folder::with(&["in/a.bvh", "in/b.bvh"]);
    folder.succeeds("convert in -o out --shard 1/2");
    folder.succeeds("convert in -o out --shard 2/2");
    folder.write("out/mocap-manifest.old.jsonl", b"notes of mine");
    folder.succeeds("merge-manifest out");
    assert_eq!(folder.read("out/mocap-manifest.old.jsonl"), b"notes of mine");
    assert_eq!(folder.records("out").len(), 2);
    assert_eq!(folder.run("merge-manifest in").status.code(), Some(1));
}

/// The option `-o` works as in other commands: it does not make a folder with the name of the file.
#[test]
fn the_output_of_one_file_may_follow_o() {
    let folder = Folder::with(&["in/a.bvh", "in/b.bvh"]);
    folder.succeeds("convert in/a.bvh -o one.glb");
    assert!(folder.read("one.glb").starts_with(b"glTF"));
    let piped = folder.run("convert in/a.bvh -o - --to bvh");
    assert!(piped.stdout.starts_with(b"HIERARCHY"));
    for several in [
        "convert in -o all.glb",
        "convert in/a.bvh in/b.bvh -o all.glb",
        "convert in/*.bvh -o all.glb",
    ] {
        folder.refuses(several, 2, "all.glb: several inputs need an output folder");
    }
    folder.refuses("convert in/a.bvh -o two.glb --resume", 2, "--resume");
    folder.refuses(
        "convert in/a.bvh -o two.c3d",
        2,
        "two.c3d: files of this format are read, not written",
    );
    assert!(!folder.path("two.c3d").exists());
    folder.refuses("convert in/none.bvh -o two.glb", 1, "none.bvh");
    folder.refuses("convert in/a.bvh -o in/a.bvh", 1, "input");
    folder.succeeds("convert in/a.bvh in/b.bvh -o all.glb/");
    assert!(folder.path("all.glb/b.glb").is_file());
}

/// A process killed between the two files of an output leaves the first file, and the second with a temporary name.
#[test]
fn the_buffer_of_a_killed_run_is_known() {
    for arguments in ["convert walk.bvh out.gltf", "convert walk.bvh -o . --to gltf"] {
        let folder = Folder::with(&["walk.bvh"]);
        folder.succeeds(arguments);
        let name = if arguments.contains("-o") { "walk" } else { "out" };
        let (text, left) = (format!("{name}.gltf"), format!(".{name}.gltf.unfinished-x7Qz1a"));
        fs::rename(folder.path(&text), folder.path(&left)).unwrap();
        folder.succeeds(arguments);
        assert!(
            folder.path(&text).exists() && !folder.path(&left).exists(),
            "{arguments}"
        );
        // Without the main file, only the record identifies a buffer. A buffer with other bytes may be a user's.
        fs::remove_file(folder.path(&text)).unwrap();
        folder.succeeds(&format!("{arguments} --trim 0f..3f"));
        fs::remove_file(folder.path(&text)).unwrap();
        folder.write(&format!("{name}.bin"), b"numbers");
        let output = folder.run(arguments);
        assert_eq!(output.status.code(), Some(1), "{}", words(&output));
        assert_eq!(folder.read(&format!("{name}.bin")), b"numbers");
        // Replacing a buffer with equal bytes loses nothing.
        folder.succeeds(&format!("{arguments} --force"));
        fs::remove_file(folder.path(&text)).unwrap();
        folder.succeeds(arguments);
    }
}
