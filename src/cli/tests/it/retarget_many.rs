//! `mocap retarget` into a folder: every output equals the output of its motion alone, and no motion stops the others.

use std::fs;

use serde_json::Value;

use crate::at_root;
use crate::program::Folder;

/// A character, and two motions. The motions have different skeletons, because motions of one skeleton would share a
/// T-pose.
fn folder() -> Folder {
    let folder = Folder::with(&[]);
    let short = fs::read_to_string(at_root("fixtures/real/cmu_short.bvh")).unwrap();
    folder.write("in/a.bvh", short.as_bytes());
    let other = short.replace(".0083333", ".0166667").replace("LThumb", "LeftThumb");
    folder.write("in/below/b.bvh", other.as_bytes());
    let hero = fs::read(at_root("fixtures/skeletons/human_vrm1.gltf")).unwrap();
    folder.write("in/hero.gltf", &hero);
    folder
}

const COMMAND: &str = "retarget in --character in/hero.gltf -o out/";

#[test]
fn each_motion_gets_the_output_that_it_has_alone() {
    let folder = folder();
    let said = folder.succeeds(COMMAND);
    assert!(
        said.contains("2 of 2 files converted, 0 done before, 0 failed"),
        "{said}"
    );
    for (input, output) in [("in/a.bvh", "a"), ("in/below/b.bvh", "below/b")] {
        let name = output.rsplit('/').next().unwrap();
        folder.succeeds(&format!("retarget {input} in/hero.gltf -o {name}.gltf --force"));
        for extension in ["gltf", "bin"] {
            let made = folder.read(&format!("out/{output}.{extension}"));
            assert!(
                made == folder.read(&format!("{name}.{extension}")),
                "{output}.{extension}"
            );
        }
    }
    let records = folder.records("out");
    let count = |verdict: &str| {
        let has = |record: &&Value| record["retarget"][0]["verdict"] == verdict;
        records.iter().filter(has).count()
    };
    let verdicts = ["good", "fair", "poor"].map(|verdict| format!("{} {verdict}", count(verdict)));
    let expected = format!("clips on the character: {}", verdicts.join(", "));
    assert!(said.contains(&expected), "{said}");
    let outputs: Vec<&Value> = records.iter().map(|record| &record["output"]).collect();
    assert_eq!(outputs, ["a.gltf", "below/b.gltf"]);
    assert_eq!(records[1]["retarget"][0]["clip"], "b");
    assert!(records[0]["warnings"].to_string().contains("a rest pose, is dropped"));
}

#[test]
fn a_folder_says_that_data_is_not_in_its_outputs() {
    let folder = folder();
    folder.write("fbx/run.fbx", &fs::read(at_root("fixtures/real/run.fbx")).unwrap());
    let said = folder.succeeds("convert fbx -o out --to bvh");
    let lost = "data of 1 file is not in the outputs, such as run.fbx: ";
    assert!(said.contains(lost), "{said}");
    let said = folder.succeeds("convert in/below -o out --to glb");
    assert!(!said.contains("not in the output"), "{said}");
}

#[test]
fn a_file_without_a_motion_is_left_out_and_reported() {
    let folder = folder();
    folder.write(
        "in/arm.bvh",
        &fs::read(at_root("fixtures/real/lecture_Test.bvh")).unwrap(),
    );
    folder.write("in/broken.bvh", b"HIERARCHY\nROOT");
    let said = folder.ends_with(3, COMMAND);
    assert!(
        said.contains("2 of 4 files converted, 0 done before, 2 failed"),
        "{said}"
    );
    assert!(
        said.contains("arm.bvh") && said.contains("the source is not a humanoid"),
        "{said}"
    );
    assert!(folder.path("out/a.gltf").exists() && !folder.path("out/arm.gltf").exists());
    let failed: Vec<Value> = folder
        .records("out")
        .into_iter()
        .filter(|record| !record["error"].is_null())
        .collect();
    assert_eq!(failed.len(), 2);
    assert!(failed.iter().all(|record| record["output"].is_null()), "{failed:?}");
}

#[test]
fn only_what_changed_is_retargeted_again() {
    let folder = folder();
    folder.succeeds(COMMAND);
    let again = format!("{COMMAND} --resume");
    assert!(
        folder
            .succeeds(&again)
            .contains("0 of 2 files converted, 2 done before")
    );
    // Another scale, and another character with the same name.
    let said = folder.succeeds(&format!("{again} --scale 1.5"));
    assert!(said.contains("2 of 2 files converted, 0 done before"), "{said}");
    let hero = fs::read(at_root("fixtures/skeletons/human_default.gltf")).unwrap();
    folder.write("in/hero.gltf", &hero);
    let said = folder.succeeds(&format!("{again} --scale 1.5"));
    assert!(said.contains("2 of 2 files converted, 0 done before"), "{said}");
}

#[test]
fn the_largest_angle_counts_also_for_motions_that_were_done_before() {
    let folder = folder();
    folder.succeeds(COMMAND);
    let said = folder.ends_with(1, &format!("{COMMAND} --resume --max-angle 0"));
    assert!(said.contains("2 done before"), "{said}");
    assert!(
        said.contains("2 of 2 clips have larger errors than --max-angle allows"),
        "{said}"
    );
    folder.succeeds(&format!("{COMMAND} --resume --max-angle 179"));
}

#[test]
fn shards_make_what_one_run_makes() {
    let folder = folder();
    folder.succeeds(COMMAND);
    for shard in ["1/2", "2/2"] {
        folder.succeeds(&format!(
            "retarget in --character in/hero.gltf -o parts/ --allow-empty --shard {shard}"
        ));
    }
    folder.succeeds("merge-manifest parts");
    let without_seconds = |name: &str| {
        let mut records = folder.records(name);
        for record in &mut records {
            record.as_object_mut().unwrap().remove("seconds");
        }
        records
    };
    assert_eq!(without_seconds("parts"), without_seconds("out"));
    for output in ["a.gltf", "below/b.gltf"] {
        assert!(folder.read(&format!("out/{output}")) == folder.read(&format!("parts/{output}")));
    }
}

/// A BVH file does not name its writer, but the manifest does.
#[test]
fn a_file_of_another_program_is_replaced_by_force_alone() {
    let folder = folder();
    let command = "retarget in/below --to-skeleton in/a.bvh --to bvh -o out/";
    folder.succeeds(command);
    folder.succeeds(&format!("{command} --scale 1.5"));
    folder.write("out/b.bvh", &folder.read("in/a.bvh"));
    let said = folder.ends_with(1, command);
    assert!(said.contains("--force"), "{said}");
    assert!(folder.read("out/b.bvh") == folder.read("in/a.bvh"));
    folder.succeeds(&format!("{command} --force"));

    // An input is never replaced.
    let before = folder.read("in/below/b.bvh");
    let command = "retarget in/below --to-skeleton in/a.bvh --to bvh -o in/below --force";
    folder.ends_with(1, command);
    assert!(folder.read("in/below/b.bvh") == before);
}

#[test]
fn what_cannot_be_done_for_many_is_refused() {
    let folder = folder();
    let refused = |arguments: &str, reason: &str| folder.refuses(arguments, 2, reason);
    refused(
        "retarget in in/hero.gltf -o out.gltf",
        "name an output folder, -o FOLDER/",
    );
    refused(
        "retarget in/a.bvh in/hero.gltf -o out.gltf --resume",
        "--resume would do nothing",
    );
    refused(
        &format!("{COMMAND} --json"),
        "the manifest in the folder has the reports of many outputs",
    );
    refused(&format!("{COMMAND} --to glb"), "--to: the format must be .gltf");
    refused(
        &format!("{COMMAND} --to fbx --textures beside"),
        "textures of many files",
    );
    assert!(!folder.path("out").exists());
}
