//! `mocap robot` with many motions: repeated work, and the table of reports.

use std::fs;

use crate::at_root;
use crate::program::Folder;

/// Two motions, and a robot.
fn folder() -> Folder {
    let folder = Folder::with(&[]);
    let short = fs::read(at_root("fixtures/real/cmu_short.bvh")).unwrap();
    folder.write("in/a.bvh", &short);
    folder.write("in/below/b.bvh", &short);
    folder.write("robot.urdf", &fs::read(at_root("fixtures/robots/h1.urdf")).unwrap());
    folder
}

#[test]
fn outputs_of_another_format_are_not_taken_for_done() {
    let folder = folder();
    let command = "robot in --robot robot.urdf -o out --fps 10 --resume";
    folder.succeeds(command);
    let npz = folder.read("out/a.npz");
    assert!(
        folder
            .succeeds(command)
            .contains("0 of 2 files converted, 2 done before")
    );
    // Both formats have the same extension.
    folder.succeeds(&format!("{command} --to qpos"));
    assert!(folder.read("out/a.npz") != npz);
}

/// Without shapes, the soles of the robot are estimated, and no verdict is better than fair.
fn without_shapes(folder: &Folder) {
    let urdf = String::from_utf8(folder.read("robot.urdf")).unwrap();
    let urdf = urdf.replace("collision", "ignored").replace("visual", "ignored");
    folder.write("robot.urdf", urdf.as_bytes());
}

#[test]
fn a_verdict_counts_also_for_motions_that_were_done_before() {
    let folder = folder();
    without_shapes(&folder);
    let command = "robot in --robot robot.urdf -o out --fps 10 --resume";
    folder.succeeds(command);
    let records = folder.records("out");
    assert!(
        records.iter().all(|record| record["robot"]["verdict"] == "fair"),
        "{records:?}"
    );
    let said = folder.ends_with(1, &format!("{command} --require good"));
    assert!(
        said.contains("2 done before") && said.contains("0 good, 2 fair, 0 poor"),
        "{said}"
    );
    assert!(
        said.contains("error: 2 of 2 motions are worse than --require allows"),
        "{said}"
    );
    folder.succeeds(&format!("{command} --require fair"));
}

/// The report omits velocity limits that the file does not state, and explains exit code 1.
#[test]
fn what_is_said_of_one_motion_is_what_was_found() {
    let folder = folder();
    let command = "robot in/a.bvh --robot robot.urdf -o a.npz --fps 60 --require good --passes 1";
    let said = folder.ends_with(1, command);
    assert!(
        said.contains("a: poor, not feasible in ")
            && said.contains("error: a: --require refuses the motion: its verdict is poor"),
        "{said}"
    );
    assert!(
        said.contains("joints are faster than the file of the robot allows in ")
            && said.contains("a: poor because fraction too fast is "),
        "{said}"
    );
    let urdf = String::from_utf8(folder.read("robot.urdf")).unwrap();
    folder.write("robot.urdf", urdf.replace(" velocity=", " speed=").as_bytes());
    // One pass leaves jitter, which needs forces that a floor cannot exert.
    let said = folder.succeeds(&command.replace("good", "fair"));
    assert!(
        said.contains("the fastest joint is ") && !said.contains("allows"),
        "{said}"
    );
    assert!(said.contains("a: fair because fraction infeasible is "), "{said}");
    let said = folder.ends_with(1, &format!("{} --force", command.replace("good", "feasible")));
    assert!(
        said.contains("error: a: --require refuses the motion: not feasible in "),
        "{said}"
    );
    without_shapes(&folder);
    let said = folder.ends_with(1, command);
    assert!(
        said.contains("a: fair because guessed parts is 2.000, above 0")
            && said.contains("a: guessed: the sole of left_ankle_link, which has no shape"),
        "{said}"
    );
}

#[test]
fn several_motions_do_not_go_into_what_has_the_name_of_a_file() {
    let folder = folder();
    for output in ["new.npz", "robot.csv"] {
        let reason = format!("{output}: several motions need an output folder");
        folder.refuses(&format!("robot in --robot robot.urdf -o {output}"), 2, &reason);
    }
}

#[test]
fn several_robots_have_a_folder_each() {
    let folder = folder();
    folder.write("h1.2.urdf", &folder.read("robot.urdf"));
    let command = "robot in/a.bvh --robot robot.urdf --robot h1.2.urdf --fps 10 -o out";
    folder.succeeds(command);
    assert_eq!(folder.read("out/robot/a.npz"), folder.read("out/h1.2/a.npz"));
    let said = folder.succeeds(&format!("{command} --resume"));
    assert_eq!(
        said.matches("0 of 1 files converted, 1 done before").count(),
        2,
        "{said}"
    );
    folder.refuses(&format!("{command} --print-job"), 2, "a job has one robot");
    folder.refuses(
        "robot in --robot robot.urdf --robot ./robot.urdf -o out",
        2,
        "rename one of the files",
    );
}

#[cfg(not(feature = "parquet"))]
#[test]
fn a_build_without_parquet_says_so_before_the_work() {
    let command = "robot in --robot robot.urdf -o out --report reports.parquet";
    folder().refuses(command, 2, "build it with `--features parquet`");
}

#[cfg(feature = "parquet")]
mod reports {
    use std::fs::File;
    use std::process::Stdio;

    use mocap::arrays::table::arrow_array::cast::AsArray;
    use mocap::arrays::table::arrow_array::types::Float64Type;
    use mocap::arrays::table::arrow_array::{Array, RecordBatch};
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
    use serde_json::Value;

    use super::*;
    use crate::program::{MANIFEST, command_in};

    fn table(folder: &Folder, name: &str) -> RecordBatch {
        let file = File::open(folder.path(name)).unwrap();
        let reader = ParquetRecordBatchReaderBuilder::try_new(file).unwrap().build().unwrap();
        let mut batches: Vec<RecordBatch> = reader.map(Result::unwrap).collect();
        assert_eq!(batches.len(), 1);
        batches.remove(0)
    }

    fn texts(table: &RecordBatch, column: &str) -> Vec<Option<String>> {
        let column = table.column_by_name(column).unwrap().as_string::<i32>();
        column.iter().map(|text| text.map(str::to_owned)).collect()
    }

    /// Adds a third motion that is cut off.
    fn folder_with_broken() -> Folder {
        let folder = folder();
        let short = folder.read("in/a.bvh");
        folder.write("in/broken.bvh", &short[..2000]);
        folder
    }

    #[test]
    fn there_is_a_row_for_each_motion_as_in_the_manifest() {
        let folder = folder_with_broken();
        folder.ends_with(3, "robot in --robot robot.urdf -o out --fps 30 --report out/r.parquet");
        let (table, records) = (table(&folder, "out/r.parquet"), folder.records("out"));
        let some = |text: &str| Some(text.to_owned());
        assert_eq!(
            texts(&table, "clip"),
            [some("a.bvh"), some("below/b.bvh"), some("broken.bvh")]
        );
        assert_eq!(texts(&table, "output"), [some("a.npz"), some("below/b.npz"), None]);
        let broken = &records[2]["error"];
        assert_eq!(texts(&table, "error"), [None, None, broken.as_str().map(str::to_owned)]);
        let limbs = table.column_by_name("limbs").unwrap().as_list::<i32>();
        for (row, record) in records.iter().enumerate() {
            for (name, column) in std::iter::zip(table.schema().fields(), table.columns()) {
                let report = &record["robot"];
                // The fields of dynamics and scores have separate columns.
                let parts = [report, &report["dynamics"], &report["scores"]];
                let found = parts.into_iter().find_map(|part| part.get(name.name()));
                if column.is_null(row) {
                    assert!(found.is_none_or(Value::is_null) || name.name() == "error", "{name}");
                } else if let Some(column) = column.as_primitive_opt::<Float64Type>() {
                    assert_eq!(Some(column.value(row)), found.and_then(Value::as_f64), "{name}");
                }
            }
            let listed = record["robot"]["limbs"].as_array().map_or(0, Vec::len);
            assert_eq!(limbs.is_valid(row), listed > 0);
            if listed == 0 {
                continue;
            }
            let found = limbs.value(row);
            let means = found.as_struct().column_by_name("mean_degrees").unwrap();
            let means = means.as_primitive::<Float64Type>().values().to_vec();
            let bones = found.as_struct().column_by_name("bone").unwrap();
            for (index, limb) in record["robot"]["limbs"].as_array().unwrap().iter().enumerate() {
                assert_eq!(limb["mean_degrees"], means[index]);
                assert_eq!(limb["bone"], bones.as_string::<i32>().value(index));
            }
            assert_eq!(means.len(), listed);
        }
        // Every field of a report is a column.
        let report = &records[0]["robot"];
        let parts = ["dynamics", "scores"];
        let of_parts = parts.iter().flat_map(|part| report[part].as_object().unwrap().keys());
        let fields = report.as_object().unwrap().keys();
        let fields = fields.filter(|name| !parts.contains(&name.as_str()));
        let mut missing: Vec<&String> = fields.chain(of_parts).collect();
        missing.retain(|name| table.column_by_name(name).is_none());
        assert!(missing.is_empty(), "{missing:?}");
    }

    /// The table exists before the last motion is done.
    #[test]
    fn a_run_that_is_killed_leaves_its_table() {
        let folder = folder();
        let short = folder.read("in/a.bvh");
        (0..12).for_each(|index| folder.write(&format!("in/{index}.bvh"), &short));
        let arguments = "robot in --robot robot.urdf --fps 10 -o out --report r.parquet --threads 1";
        let mut command = command_in(&folder.path(""), arguments);
        let mut run = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        while !folder.path("r.parquet").exists() && run.try_wait().unwrap().is_none() {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        run.kill().unwrap();
        run.wait().unwrap();
        let rows = table(&folder, "r.parquet").num_rows();
        assert!((1..14).contains(&rows), "{rows} of 14 rows");
    }

    #[test]
    fn a_run_that_goes_on_and_shards_have_the_rows_of_one_run() {
        let folder = folder_with_broken();
        let run = |more: &str| {
            let command = format!("robot in --robot robot.urdf --fps 10 {more}");
            folder.ends_with(3, &command)
        };
        run("-o out --report whole.parquet");
        let whole = folder.read("whole.parquet");
        // A run that was killed: the last line of its manifest is cut short, and an output is missing.
        let manifest = folder.read(&format!("out/{MANIFEST}"));
        let lines: Vec<&[u8]> = manifest.split_inclusive(|byte| *byte == b'\n').collect();
        folder.write(&format!("out/{MANIFEST}"), &[lines[0], &lines[1][..100]].concat());
        fs::remove_file(folder.path("out/below/b.npz")).unwrap();
        let said = run("-o out --report resumed.parquet --resume");
        assert!(
            said.contains("1 of 3 files converted, 1 done before, 1 failed"),
            "{said}"
        );
        assert!(folder.read("resumed.parquet") == whole);
        let mut rows = Vec::new();
        for shard in 1..=2 {
            let name = format!("shards.{shard}-of-2.parquet");
            let command =
                format!("robot in --robot robot.urdf --fps 10 -o shards --report shards.parquet --shard {shard}/2");
            folder.run(&command);
            let table = table(&folder, &name);
            rows.extend(std::iter::zip(texts(&table, "clip"), texts(&table, "verdict")));
        }
        rows.sort();
        let whole = table(&folder, "whole.parquet");
        assert_eq!(
            rows,
            std::iter::zip(texts(&whole, "clip"), texts(&whole, "verdict")).collect::<Vec<_>>()
        );
    }

    #[test]
    fn a_table_that_cannot_be_written_is_refused_before_the_work() {
        let folder = folder();
        folder.write("other.parquet", b"PAR1 of another program PAR1");
        let run = |report: &str| format!("robot in --robot robot.urdf -o out --report {report}");
        folder.refuses(&run("r.csv"), 2, "r.csv: the name of the output must end in .parquet");
        folder.refuses(&run("no/r.parquet"), 2, "no/r.parquet: folder not found: no");
        folder.refuses(&run("other.parquet"), 2, "other.parquet: mocap did not write this file");
        let one = "robot in/a.bvh --robot robot.urdf -o a.npz --report r.parquet";
        folder.refuses(one, 2, "--report would do nothing: ");
        folder.succeeds(&format!("{} --force --fps 10", run("other.parquet")));
        assert_eq!(table(&folder, "other.parquet").num_rows(), 2);
    }
}

/// The command printed by a run with a folder shows the motion. It reads arrays with the same body.
#[test]
fn the_printed_command_repeats_the_body() {
    let folder = folder();
    without_shapes(&folder);
    folder.succeeds("robot in/a.bvh --robot robot.urdf -o arrays --fps 10 --passes 1");
    let said = folder.succeeds("robot arrays/a.npz --body robot.urdf --robot robot.urdf -o again/ --passes 1");
    let command = "view arrays/a.npz --robot robot.urdf --body robot.urdf";
    assert!(said.contains(&format!("mocap {command}")), "{said}");
    folder.succeeds(&format!("{command} -o page.html"));
}

/// The order and the limits of the joints in the file.
#[test]
fn info_lists_the_joints_of_a_robot() {
    let folder = folder();
    let done = folder.run("info robot.urdf --json");
    let joints: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    let knee = &joints["robot_joints"][3];
    assert_eq!(
        (&knee["joint"], &knee["link"]),
        (&"left_knee_joint".into(), &"left_knee_link".into())
    );
    let limits = ["lower", "upper", "velocity", "effort"].map(|limit| knee[limit].as_f64().unwrap());
    assert_eq!(limits, [-0.26, 2.05, 14.0, 300.0]);
    let text = String::from_utf8(folder.run("info robot.urdf").stdout).unwrap();
    let row = text.lines().find(|line| line.contains("left_knee_joint ")).unwrap();
    let words: Vec<&str> = row.split_whitespace().collect();
    let expected = "3 left_knee_joint -0.260 to 2.050 rad 14 rad/s 300 Nm";
    assert_eq!(words.join(" "), expected);
}

/// The scores of a new motion equal the scores of its file.
#[test]
fn a_file_has_the_scores_of_its_report() {
    let folder = folder();
    let printed = |command: &str| -> serde_json::Value {
        let done = folder.run(command);
        serde_json::from_slice(&done.stdout).unwrap()
    };
    let made = printed("robot in/a.bvh --robot robot.urdf -o a.npz --fps 30 --json");
    let scored = printed("score in/a.bvh a.npz --robot robot.urdf --json");
    let scores = made["scores"].as_object().unwrap();
    assert!(scores.len() > 10 && scores["mpbpe_local"].as_f64().unwrap() > 0.001);
    for (name, value) in scores {
        let (made, scored) = (value.as_f64(), scored["scores"][name].as_f64());
        let is_alike = made
            .zip(scored)
            .is_none_or(|(made, scored)| (made - scored).abs() < 1e-4 * made.max(1.0));
        assert!(
            is_alike && made.is_some() == scored.is_some(),
            "{name}: {made:?} {scored:?}"
        );
    }
    let done = folder.run("score a.npz a.npz --body robot.urdf --robot robot.urdf");
    let said = String::from_utf8(done.stdout).unwrap();
    assert!(
        said.contains("a: MPBPE 0.0 mm global, 0.0 mm local, of 20 bodies"),
        "{said}"
    );
}
