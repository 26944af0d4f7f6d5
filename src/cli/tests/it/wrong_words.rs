//! The messages about a misspelled word, and about a file for another command.

use std::fs;

use crate::at_root;
use crate::program::{Folder, words};

fn said(folder: &Folder, arguments: &str) -> String {
    let output = folder.run(arguments);
    assert!(!output.status.success(), "{arguments}");
    words(&output)
}

#[test]
fn a_near_command_option_or_value_is_named_and_no_other() {
    let folder = Folder::with(&["walk.bvh"]);
    for (arguments, tip) in [
        ("conver", "a similar subcommand exists: 'convert'"),
        ("retraget walk.bvh", "a similar subcommand exists: 'retarget'"),
        ("skel walk.bvh", "a similar subcommand exists: 'skeleton'"),
        ("help vreify", "a similar subcommand exists: 'verify'"),
        ("walk.bvh", "mocap info walk.bvh"),
        (
            "convert walk.bvh a.glb --max-eror 1mm",
            "a similar argument exists: '--max-error'",
        ),
        (
            "convert walk.bvh a.glb --max-e 1mm",
            "a similar argument exists: '--max-error'",
        ),
        ("convert walk.bvh -o a --to gltff", "a similar value exists: 'gltf'"),
    ] {
        let said = said(&folder, arguments);
        assert!(said.contains(tip), "{arguments}: {said}");
    }
    for arguments in ["xyz", "mask", "convert walk.bvh a.glb --texel 1mm"] {
        let said = said(&folder, arguments);
        assert!(!said.contains("similar"), "{arguments}: {said}");
    }
}

#[test]
fn a_near_file_joint_clip_or_extension_is_named() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    folder.write("takes/walk_slow.bvh", &folder.read("cmu_short.bvh"));
    folder.succeeds("convert cmu_short.bvh two.glb");
    for (arguments, meant) in [
        ("info cmu_shrot.bvh", "did you mean cmu_short.bvh?"),
        ("convert takes/walk-slow.bvh a.glb", "did you mean takes/walk_slow.bvh?"),
        ("retarget cmu_short.bvh tow.glb -o a.glb", "did you mean two.glb?"),
        ("plot cmu_short.bvh --joint LeftFoto -o a.svg", "did you mean LeftFoot?"),
        ("info two.glb --clip cmu_shotr", "did you mean \"cmu_short\"?"),
        ("convert cmu_short.bvh a.gltff", "did you mean a.gltf?"),
        ("clean cmu_short.bvh -o a.fbxx", "did you mean a.fbx?"),
        ("fk cmu_short.bvh -o a.nzp", "did you mean a.npz?"),
    ] {
        let said = said(&folder, arguments);
        assert!(said.contains(meant), "{arguments}: {said}");
    }
    for arguments in [
        "info other.bvh",
        "plot cmu_short.bvh --joint Tail -o a.svg",
        "convert cmu_short.bvh a.docx",
    ] {
        let said = said(&folder, arguments);
        assert!(!said.contains("did you mean"), "{arguments}: {said}");
    }
    folder.write("map.json", br#"{"bones": {"leftFoot": "LetfFoot"}}"#);
    let said = said(&folder, "skeleton cmu_short.bvh --map map.json");
    assert!(said.contains("LeftFoot"), "{said}");
}

/// A file of each kind in one folder.
fn folder_of_kinds() -> Folder {
    let folder = Folder::of_real(&[]);
    for (name, file) in [
        ("walk.bvh", "fixtures/real/cmu_12_01_walk.bvh"),
        ("takes/walk.bvh", "fixtures/real/cmu_short.bvh"),
        ("hero.glb", "fixtures/characters/human_default.glb"),
        ("h1.urdf", "fixtures/robots/h1.urdf"),
        ("h1.xml", "fixtures/robots/h1_nomesh.xml"),
    ] {
        folder.write(name, &fs::read(at_root(file)).unwrap());
    }
    folder.succeeds("index walk.bvh -o moves.mdb");
    folder.succeeds("graph walk.bvh -o graph.json");
    folder.succeeds("convert takes -o made");
    for (name, arguments) in [
        ("job.json", "convert walk.bvh w.glb --print-job"),
        ("map.json", "skeleton walk.bvh --json"),
        ("dump.json", "dump takes/walk.bvh --json"),
    ] {
        folder.write(name, &folder.run(arguments).stdout);
    }
    folder
}

#[test]
fn a_wrong_kind_of_file_names_the_right_command() {
    let folder = folder_of_kinds();
    for (arguments, status, meant) in [
        ("convert moves.mdb a.glb", 1, "mocap find and mocap match read it"),
        ("info graph.json", 1, "mocap graph walk reads it"),
        (
            "convert made/mocap-manifest.jsonl a.glb",
            1,
            "it is the manifest of a folder",
        ),
        ("skeleton job.json", 1, "mocap run runs it"),
        ("info dump.json", 1, "it is a printed scene"),
        ("edit map.json -o a.bvh --step mirror", 1, "--map reads such a file"),
        ("retarget walk.bvh moves.mdb -o a.glb", 1, "it is a database of motions"),
        (
            "graph walk moves.mdb --seconds 1 -o a.bvh",
            1,
            "it is a database of motions",
        ),
        (
            "graph walk walk.bvh --seconds 1 -o a.bvh",
            1,
            "mocap graph makes a graph of motions",
        ),
        ("find walk.bvh --pose walk.bvh@0", 1, "mocap index makes a database"),
        (
            "match graph.json --path 0/0+0/1 --on hero.glb -o a.glb",
            1,
            "mocap graph walk reads it",
        ),
        (
            "robot walk.bvh --robot hero.glb -o a.npz",
            1,
            "mocap retarget retargets motions to a character",
        ),
        ("sheet walk.bvh --robot walk.bvh -o a.svg", 1, "a robot is URDF or MJCF"),
        ("run walk.bvh", 2, "take motions; --print-job prints a job"),
        ("run graph.json", 2, "mocap graph walk reads it"),
        (
            "retarget walk.bvh h1.urdf -o a.glb",
            2,
            "mocap robot INPUT --robot h1.urdf -o OUTPUT",
        ),
        (
            "retarget walk.bvh --to-skeleton h1.xml -o a.bvh",
            2,
            "h1.xml is a robot, not a character",
        ),
        (
            "retarget takes --character h1.xml -o many/",
            2,
            "h1.xml is a robot, not a character",
        ),
        ("view walk.bvh --character h1.urdf -o a.html", 2, "h1.urdf is a robot"),
        ("graph walk.bvh --on h1.urdf -o a.json", 2, "h1.urdf is a robot"),
        (
            "graph walk graph.json --seconds 1 --on h1.urdf -o a.glb",
            2,
            "h1.urdf is a robot",
        ),
        (
            "match moves.mdb --path 0/0+0/1 --on h1.urdf -o a.glb",
            2,
            "h1.urdf is a robot",
        ),
        (
            "retarget walk.bvh hero.glb -o a.npz",
            2,
            "mocap convert and mocap fk write arrays",
        ),
        ("clean walk.bvh -o a.gif", 2, "mocap gif draws animations"),
        ("retarget walk.bvh hero.glb -o a.html", 2, "mocap view writes pages"),
        ("fk walk.bvh -o a.glb", 2, "mocap convert writes .glb"),
    ] {
        folder.refuses(arguments, status, meant);
    }
    let checked = String::from_utf8(folder.run("check job.json").stdout).unwrap();
    assert!(checked.contains("mocap run runs it"), "{checked}");
}

/// An invalid file of weights is rejected with its name, the location, the valid names and the nearest name.
#[test]
fn a_wrong_file_of_weights_says_where_and_what_it_may_hold() {
    let folder = Folder::with(&["walk.bvh"]);
    for (weights, parts) in [
        (
            r#"{"robto": {}}"#,
            &[
                "weights.json: robto: there is no robto; known keys: robot, foot-lock",
                "did you mean robot?",
            ][..],
        ),
        (
            r#"{"robot": {"hnad": 1}}"#,
            &[
                "weights.json: robot.hnad: there is no hnad in robot; known keys: twist",
                "did you mean hand?",
            ],
        ),
        (
            r#"{"clean": {"zzz": 1}}"#,
            &[
                "clean.zzz: there is no zzz in clean",
                "docs/weights.md lists the weights",
            ],
        ),
        (
            r#"{"robot": {"hand": "far"}}"#,
            &["robot.hand: expected a number; found string \"far\" at line 1"],
        ),
        (
            r#"{"robot": {"hand": 1e9}}"#,
            &["weights.json: the weight hand of robot must be from 0.0002 to 200"],
        ),
        (
            r#"{"robot": "#,
            &["weights.json: the text is not JSON: EOF while parsing a value at line 1 column 10"],
        ),
        (r#"{} {}"#, &["weights.json: text follows the JSON object"]),
    ] {
        fs::write(folder.path("weights.json"), weights).unwrap();
        for command in ["convert walk.bvh -o a.glb", "verify walk.bvh walk.bvh"] {
            let words = said(&folder, &format!("{command} --weights weights.json"));
            for part in parts {
                assert!(words.contains(part), "{command}: {weights}: {words}");
            }
        }
    }
}

/// A skeleton solved with other weights is compared with a skeleton solved with the same weights.
#[test]
fn an_output_of_markers_is_verified_with_the_weights_of_the_solver() {
    let folder = Folder::with(&["walk.bvh"]);
    let trial = at_root("fixtures/markers/cmu_01_01.c3d");

    fs::write(
        folder.path("weights.json"),
        r#"{"markers": {"on-bone": 0.06, "hold": 0.02}}"#,
    )
    .unwrap();
    let weights = "--weights weights.json";
    assert!(
        folder
            .run(&format!("solve {trial} -o solved.bvh {weights}"))
            .status
            .success()
    );
    let verify = format!("verify {trial} solved.bvh --markers auto");
    let other = folder.run(&verify);
    assert!(!other.status.success(), "{}", words(&other));
    let same = folder.run(&format!("{verify} {weights}"));
    assert!(same.status.success(), "{}", words(&same));
}
