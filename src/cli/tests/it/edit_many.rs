//! `mocap edit` into a folder, and jobs with many motions.

use std::fs;

use crate::at_root;
use crate::program::Folder;

/// Two motions, a file without motion, and a motion to join.
fn folder() -> Folder {
    let folder = Folder::with(&[]);
    let short = fs::read_to_string(at_root("fixtures/real/cmu_short.bvh")).unwrap();
    folder.write("in/a.bvh", short.as_bytes());
    folder.write("in/below/b.bvh", short.replace(".0083333", ".0166667").as_bytes());
    folder.write("second.bvh", short.as_bytes());
    folder
}

const COMMAND: &str = "edit in -o out/ --step smooth:cut-off=8 --step mirror";

#[test]
fn each_motion_gets_the_output_that_it_has_alone() {
    let folder = folder();
    folder.write("in/broken.bvh", b"HIERARCHY\nROOT");
    let said = folder.ends_with(3, COMMAND);
    assert!(
        said.contains("2 of 3 files converted, 0 done before, 1 failed"),
        "{said}"
    );
    for (input, output) in [("in/a.bvh", "a"), ("in/below/b.bvh", "below/b")] {
        folder.succeeds(&format!(
            "edit {input} -o alone.glb --step smooth:cut-off=8 --step mirror"
        ));
        assert!(
            folder.read(&format!("out/{output}.glb")) == folder.read("alone.glb"),
            "{output}"
        );
    }
    let records = folder.records("out");
    assert_eq!(records[0]["edit"][1]["step"], "mirror");
    assert!(records[2]["error"].is_string() && records[2]["output"].is_null());
    assert!(!folder.path("out/broken.glb").exists());
}

#[test]
fn a_second_motion_is_joined_with_each() {
    let folder = folder();
    folder.succeeds("edit in -o out/ --step concat --with second.bvh --to bvh");
    folder.succeeds("edit in/a.bvh second.bvh -o alone.bvh --step concat");
    assert!(folder.read("out/a.bvh") == folder.read("alone.bvh"));
    // A changed second motion is read again.
    let command = "edit in -o out/ --step concat --with second.bvh --to bvh --resume";
    assert!(folder.succeeds(command).contains("2 done before"));
    folder.write("second.bvh", &fs::read(at_root("fixtures/real/cmu_short.bvh")).unwrap());
    assert!(folder.succeeds(command).contains("2 done before"));
    let text = String::from_utf8(folder.read("second.bvh")).unwrap();
    folder.write("second.bvh", text.replace(".0083333", ".0166667").as_bytes());
    assert!(folder.succeeds(command).contains("0 done before"));
}

#[test]
fn a_second_motion_among_the_inputs_is_an_input_too() {
    let folder = folder();
    let said = folder.succeeds("edit in -o out/ --step concat --with in/a.bvh --to bvh");
    assert!(said.contains("2 of 2 files converted"), "{said}");
    folder.succeeds("edit in/a.bvh second.bvh -o alone.bvh --step concat");
    assert!(folder.read("out/a.bvh") == folder.read("alone.bvh"));
    assert_eq!(folder.records("out").len(), 2);
}

#[test]
fn a_character_among_the_inputs_is_said_to_be_none() {
    let folder = folder();
    folder.write(
        "in/hero.gltf",
        &fs::read(at_root("fixtures/skeletons/human_vrm1.gltf")).unwrap(),
    );
    let said = folder.succeeds("retarget in --character in/hero.gltf -o moved/");
    assert!(
        said.contains("in/hero.gltf: this is the target of the motions, so it cannot be an input"),
        "{said}"
    );
    assert!(said.contains("2 of 2 files converted"), "{said}");
    assert!(folder.path("moved/a.bin").exists());
}

/// Writes a `.gltf` as `mocap convert` does: the buffer in a separate file, or embedded with `--embed`. An earlier
/// output is replaced.
#[test]
fn gltf_has_its_buffer_where_it_is_asked_for() {
    let folder = folder();
    folder.write(
        "hero.gltf",
        &fs::read(at_root("fixtures/skeletons/human_vrm1.gltf")).unwrap(),
    );
    for (command, name) in [
        ("edit in/a.bvh --step mirror", "edited"),
        ("retarget in/a.bvh hero.gltf", "moved"),
    ] {
        for _ in 0..2 {
            folder.succeeds(&format!("{command} -o {name}.gltf"));
        }
        folder.succeeds(&format!("{command} -o {name}_whole.gltf --embed"));
        let (text, bin) = (format!("{name}.gltf"), format!("{name}.bin"));
        assert!(folder.path(&bin).exists() && !folder.path(&format!("{name}_whole.bin")).exists());
        assert!(
            String::from_utf8(folder.read(&text))
                .unwrap()
                .contains(&format!("\"{bin}\""))
        );
        let keys = |file: &str| mocap::import(folder.path(file)).unwrap().animations[0].channels.clone();
        assert!(!keys(&text).is_empty());
        assert_eq!(keys(&text), keys(&format!("{name}_whole.gltf")));
    }
    // A buffer of another program is not replaced.
    folder.write("other.bin", b"numbers");
    let said = folder.ends_with(1, "retarget in/a.bvh hero.gltf -o other.gltf");
    assert!(said.contains("other.bin: error[output-exists]"), "{said}");
    assert_eq!(folder.read("other.bin"), b"numbers");
}

/// The contents of a file of bones count, not its name.
#[test]
fn a_map_that_has_changed_makes_its_outputs_anew() {
    let folder = folder();
    let map = |toe: &str| format!(r#"{{"bones": {{"leftToes": "{toe}"}}}}"#);
    folder.write("map.json", map("EndSite_LeftToeBase").as_bytes());
    for command in [
        "edit in -o out/ --step foot-lock --map map.json --resume",
        "convert in -o converted --map map.json --resume",
        "retarget in --character second.bvh -o moved/ --map map.json --resume",
    ] {
        folder.write("map.json", map("EndSite_LeftToeBase").as_bytes());
        assert!(folder.succeeds(command).contains("0 done before"), "{command}");
        assert!(folder.succeeds(command).contains("2 done before"), "{command}");
        folder.write("map.json", map("LeftToeBase").as_bytes());
        assert!(folder.succeeds(command).contains("0 done before"), "{command}");
    }
}

#[test]
fn shards_make_what_one_run_makes() {
    let folder = folder();
    folder.succeeds(COMMAND);
    for shard in ["1/2", "2/2"] {
        folder.succeeds(&format!(
            "edit in -o parts/ --step smooth:cut-off=8 --step mirror --threads 1 --shard {shard}"
        ));
    }
    folder.succeeds("merge-manifest parts");
    for output in ["a.glb", "below/b.glb"] {
        assert!(folder.read(&format!("out/{output}")) == folder.read(&format!("parts/{output}")));
    }
}

/// A job with a folder gives the same result as the command that printed the job.
#[test]
fn a_job_with_many_motions_makes_the_same_folder() {
    let folder = folder();
    folder.write("robot.urdf", &fs::read(at_root("fixtures/robots/h1.urdf")).unwrap());
    for command in [
        COMMAND,
        "convert in -o out --max-error 1mm",
        "retarget in --character second.bvh -o out/ --to bvh",
        "robot in --robot robot.urdf -o out --fps 10",
    ] {
        folder.succeeds(command);
        let made = folder.contents();
        let job = folder.run(&format!("{command} --print-job")).stdout;
        fs::remove_dir_all(folder.path("out")).unwrap();
        folder.write("job.json", &job);
        folder.succeeds("run job.json");
        let again = folder.contents();
        fs::remove_file(folder.path("job.json")).unwrap();
        fs::remove_dir_all(folder.path("out")).unwrap();
        for (path, bytes) in made {
            // Ignore the times in a manifest.
            if !path.to_string_lossy().contains("manifest") {
                assert!(again.contains(&(path.clone(), bytes)), "{command}: {}", path.display());
            }
        }
    }
}

#[test]
fn what_cannot_be_done_for_many_is_refused() {
    let folder = folder();
    let one = "edit in/a.bvh -o a.glb --step mirror";
    for (command, reason) in [
        (
            format!("{COMMAND} --contacts-file c.json"),
            "--contacts-file would do nothing: it is for one motion",
        ),
        (
            format!("{COMMAND} --json"),
            "--json would do nothing: it is for one motion",
        ),
        (
            format!("{one} --resume"),
            "--resume would do nothing: one motion is written to one file",
        ),
        (format!("{one} --shard 1/2"), "--shard would do nothing"),
        (
            "edit in -o a.glb --step mirror".to_owned(),
            "name an output folder, -o FOLDER/",
        ),
        (
            format!("{COMMAND} --to fbx --textures beside"),
            "textures of many files",
        ),
    ] {
        folder.refuses(&command, 2, reason);
    }
    let job = r#"{"source": {"inputs": ["in"]}, "write": {"output": "out/"}}"#;
    folder.write("job.json", job.as_bytes());
    folder.refuses(
        "run job.json",
        2,
        "out/: a folder does not name the format of its outputs",
    );
    let error = mocap::job::Job::from_json(job).unwrap().run().unwrap_err();
    assert!(error.to_string().contains("mocap run"), "{error}");
}
