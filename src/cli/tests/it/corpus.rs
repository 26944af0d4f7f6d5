//! `mocap survey`: rows, verdicts, and defects with their frames.

use std::path::Path;

use mocap::job::Job;
use mocap::survey::report::{ClipRecord, ClipRow, Quality};
use mocap::survey::{Condition, Corpus, DefectKind, Thresholds};

use crate::program::{Folder, words};
use crate::{ROOT, at_root};

const WALK: &str = "cmu_12_01_walk.bvh";

fn rows_of(file: &str) -> Vec<ClipRecord> {
    let scene = mocap::import(Path::new(ROOT).join("fixtures/real").join(file)).unwrap();
    Thresholds::default().examine(&scene, file)
}

#[test]
fn a_walk_walks_and_is_good() {
    let row = rows_of(WALK).remove(0).row;
    assert_eq!(row.verdict, Quality::Good, "{row:?}");
    assert!(row.walking.unwrap() > 0.8 * row.seconds, "{row:?}");
    assert_eq!((row.jumps, row.turns_over), (Some(0), Some(0)));
    // The length of the root's path in steps of 0.1 s, computed with NumPy: 3.855 m.
    let distance = row.distance.unwrap();
    assert!((3.82..3.89).contains(&distance), "{distance}");
    assert_eq!(row.joints, 31);
}

#[test]
fn what_has_no_body_has_no_measures_of_one() {
    let row = rows_of("lecture_Test.bvh").remove(0).row;
    assert_eq!(row.humanoid, Some(false));
    assert!(row.walking.is_none() && !row.amounts.contains_key(&DefectKind::Skate));
    assert!(row.amounts.contains_key(&DefectKind::Frozen));
}

#[test]
fn a_skeleton_is_known_at_another_scale_and_with_other_names() {
    let text = std::fs::read_to_string(at_root("fixtures/real/cmu_short.bvh")).unwrap();
    let skeleton = |text: &str| {
        let scene = mocap::Importer::new().read(text.as_bytes(), "x.bvh").unwrap();
        Thresholds::default().examine(&scene, "x.bvh").remove(0).row.skeleton
    };
    let (hierarchy, motion) = text.split_once("MOTION").unwrap();
    let scaled = hierarchy.lines().map(|line| match line.trim().strip_prefix("OFFSET") {
        Some(offset) => {
            let numbers = offset
                .split_whitespace()
                .map(|number| number.parse::<f64>().unwrap() * 2.5);
            format!(
                "OFFSET {}\n",
                numbers.map(|number| format!("{number:.5} ")).collect::<String>()
            )
        }
        None => line.replace("JOINT ", "JOINT other_") + "\n",
    });
    let scaled = format!("{}MOTION{motion}", scaled.collect::<String>());
    assert_eq!(skeleton(&text), skeleton(&scaled));
    let other = rows_of("mocopi_jump_six_channels.bvh").remove(0).row.skeleton;
    assert_ne!(skeleton(&text), other);
}

#[test]
fn thresholds_decide_the_verdict() {
    let mut strict = Thresholds::default();
    strict.set("skate=0.1").unwrap();
    let scene = mocap::import(Path::new(ROOT).join("fixtures/real").join(WALK)).unwrap();
    let row = strict.examine(&scene, WALK).remove(0).row;
    assert_eq!((row.verdict, row.reasons.as_str()), (Quality::Bad, "skate"));
    assert!(row.defects.iter().all(|defect| defect.kind == DefectKind::Skate));
    for text in ["skate", "skate=-1", "skate=5..2", "skid=3", "skate=NaN"] {
        assert!(strict.set(text).is_err(), "{text}");
    }
}

#[test]
fn expressions_say_where_they_are_wrong() {
    let row = ClipRow::default();
    for (text, expected) in [
        ("skate <", "ends too early"),
        ("skate < abc", "a number"),
        ("(twin", "ends too early"),
        ("twin twin", "column 6"),
        ("file = 'x", "has no end"),
        ("", "ends too early"),
        ("skate ~ 1", "column 7"),
        ("<", "is not a column"),
        (
            "verdict == good and !twin",
            "did you mean \"verdict = good and not twin\"?",
        ),
        (
            "twin && skate<1 || verdict != bad",
            "did you mean \"twin and skate<1 or verdict != bad\"?",
        ),
    ] {
        let error = text.parse::<Condition>().unwrap_err().to_string();
        assert!(error.contains(expected), "{text}: {error}");
    }
    let deep = "not ".repeat(10_000) + "twin";
    assert!(deep.parse::<Condition>().is_err());
    for (text, holds) in [
        ("not twin", true),
        ("twin or frames = 0 and verdict = good", true),
        ("(twin or frames = 0) and verdict != good", false),
        // A missing measure is neither below nor above a threshold.
        ("skate < 1", false),
        ("not skate < 1", true),
    ] {
        assert_eq!(text.parse::<Condition>().unwrap().holds(&row), holds, "{text}");
    }
}

#[test]
fn a_record_is_read_again() {
    let thresholds = Thresholds::default();
    let mut clips = rows_of(WALK);
    clips.extend(rows_of("lecture_Test.bvh"));
    clips.push(ClipRow::unreadable("broken.bvh", "it is").into());
    let corpus = Corpus::new(clips, &thresholds);
    let again = Corpus::new(ClipRecord::from_lines(&corpus.to_record()).unwrap(), &thresholds);
    assert_eq!(corpus, again);
    assert!(
        ClipRecord::from_lines("{}\nnonsense")
            .unwrap_err()
            .to_string()
            .contains("line 1")
    );
}

#[test]
fn the_command_writes_tables_and_says_what_failed() {
    let folder = Folder::of_real(&[WALK, "lecture_Test.bvh", "brackets_in_numbers.bvh"]);
    let some = folder.run("survey . -o rows.csv");
    assert_eq!(some.status.code(), Some(3));
    assert!(words(&some).contains("array"), "{}", words(&some));
    let csv = String::from_utf8(folder.read("rows.csv")).unwrap();
    assert_eq!(csv.lines().count(), 4, "{csv}");
    let columns = csv.lines().next().unwrap().split(',').count();
    assert_eq!(columns, ClipRow::column_names().len());
    let walk = folder.run(&format!("survey {WALK} lecture_Test.bvh --fail-on bad"));
    assert_eq!(walk.status.code(), Some(0), "{}", words(&walk));
    folder.refuses(&format!("survey {WALK} --threshold skate=0.1 --fail-on bad"), 1, "");
    // A file that cannot be read does not hide a bad clip.
    folder.refuses("survey . --threshold skate=0.1 --fail-on bad", 1, "bad or worse");
    let sliding = folder.run(&format!("survey {WALK} --threshold skate=0.1"));
    let listed = String::from_utf8(sliding.stdout).unwrap();
    assert!(
        listed
            .lines()
            .any(|line| line.contains("skate ") && line.contains(" cm")),
        "{listed}"
    );
    let split = folder.run(&format!("survey {WALK} --split 0.8,0.1,0.1"));
    assert!(words(&split).contains("puts no clip into"), "{}", words(&split));
    folder.refuses(&format!("survey {WALK} --threshold skid=1"), 2, "skid");
    for command in [format!("survey {WALK}"), format!("find {WALK} --like {WALK}")] {
        let said = r#"error[invalid-value]: --where: "skat" is not a column"#;
        folder.refuses(&format!("{command} --where skat<1"), 2, said);
    }
    // An input is never replaced, and a table needs a format.
    folder.refuses(&format!("survey {WALK} -o {WALK} --force"), 2, "");
    folder.refuses(&format!("survey {WALK} -o rows.xyz"), 2, ".parquet");
    folder.succeeds(&format!("survey {WALK} -o rows.jsonl"));
    folder.succeeds("survey rows.jsonl -o again.jsonl");
    assert_eq!(folder.read("rows.jsonl"), folder.read("again.jsonl"));
    folder.refuses("survey rows.jsonl -o rows.jsonl", 1, "input");
    // An unchanged file is not read again, so a manual mark in its row stays.
    let marked = String::from_utf8(folder.read("rows.jsonl"))
        .unwrap()
        .replace("\"joints\":31", "\"joints\":77");
    folder.write("rows.jsonl", marked.as_bytes());
    folder.succeeds(&format!("survey {WALK} -o rows.jsonl --resume"));
    assert!(
        String::from_utf8(folder.read("rows.jsonl"))
            .unwrap()
            .contains("\"joints\":77")
    );
    folder.succeeds(&format!("survey {WALK} -o rows.jsonl"));
    assert!(
        String::from_utf8(folder.read("rows.jsonl"))
            .unwrap()
            .contains("\"joints\":31")
    );
    folder.refuses(&format!("survey {WALK} -o rows.csv --resume"), 2, "jsonl");
    folder.refuses(&format!("survey {WALK} --html {WALK}"), 1, "input");
}

#[test]
fn twins_are_found_and_one_of_them_is_kept() {
    let text = std::fs::read_to_string(Path::new(ROOT).join("fixtures/real").join(WALK)).unwrap();
    let folder = Folder::of_real(&[WALK, "rokoko_dance.bvh", "mocopi_jump_six_channels.bvh"]);
    folder.write("copy.bvh", text.as_bytes());
    folder.write("retimed.bvh", text.replace(".0083333", ".0078").as_bytes());
    for (output, options) in [
        ("mirrored.bvh", "edit IN -o OUT --step mirror"),
        ("rate.bvh", "convert IN OUT --fps 30"),
        ("piece.bvh", "convert IN OUT --trim 1..3.5"),
    ] {
        folder.succeeds(&options.replace("IN", WALK).replace("OUT", output));
    }
    folder.succeeds("survey . -o rows.json");
    let rows: Vec<serde_json::Value> = serde_json::from_slice(&folder.read("rows.json")).unwrap();
    let reason = |file: &str| {
        let row = rows
            .iter()
            .find(|row| row["file"].as_str().unwrap().ends_with(file))
            .unwrap();
        (
            row["twin"].as_bool().unwrap(),
            row["twin_reason"].as_str().unwrap_or("").to_owned(),
        )
    };
    for (file, expected) in [
        ("copy.bvh", "bytes"),
        ("mirrored.bvh", "mirrored"),
        ("rate.bvh", "rate"),
        ("retimed.bvh", "retimed"),
        ("piece.bvh", "piece"),
    ] {
        // The names decide which of two equal clips is kept.
        let found = reason(file);
        let of_walk = reason(WALK);
        assert!(
            found == (true, expected.to_owned()) || of_walk.1 == expected,
            "{file}: {found:?} {of_walk:?}"
        );
    }
    assert!(!reason("rokoko_dance.bvh").0 && !reason("mocopi_jump_six_channels.bvh").0);
    folder.succeeds("survey . --select 3 -o chosen.txt");
    let chosen = String::from_utf8(folder.read("chosen.txt")).unwrap();
    assert!(chosen.lines().count() <= 3 && !chosen.is_empty(), "{chosen}");
    // The list is an input of the commands for many files.
    folder.succeeds("convert chosen.txt -o listed/ --to bvh");
    let listed = std::fs::read_dir(folder.path("listed")).unwrap().flatten();
    let listed = listed.filter(|entry| entry.path().extension().is_some_and(|extension| extension == "bvh"));
    assert_eq!(listed.count(), chosen.lines().count());
    // Editors and shells of Windows write a byte order mark.
    let marked = format!("\u{feff}{chosen}");
    let units = || marked.encode_utf16();
    for (name, bytes) in [
        ("utf8", marked.clone().into_bytes()),
        ("utf16le", units().flat_map(u16::to_le_bytes).collect()),
        ("utf16be", units().flat_map(u16::to_be_bytes).collect()),
    ] {
        folder.write(&format!("{name}.txt"), &bytes);
        folder.succeeds(&format!("survey {name}.txt -o {name}.jsonl"));
        let rows = String::from_utf8(folder.read(&format!("{name}.jsonl"))).unwrap();
        assert_eq!(rows.lines().count(), chosen.lines().count(), "{name}: {rows}");
    }
    folder.write("broken.txt", &[chosen.as_bytes(), b"\xff.bvh\n"].concat());
    let said = folder.ends_with(1, "survey broken.txt -o broken.jsonl");
    assert!(said.contains("broken.txt") && said.contains("not UTF-8"), "{said}");
    for nothing in ["0", "0%"] {
        let said = folder.ends_with(2, &format!("survey . --select {nothing} -o none.txt"));
        assert!(said.contains("above 0") && !folder.path("none.txt").exists(), "{said}");
    }
}

/// The table of kinds in the documentation; `MOCAP_WRITE=1` writes it.
#[test]
fn the_documentation_has_every_kind() {
    let path = &at_root("docs/survey-columns.md");
    let text = std::fs::read_to_string(path).unwrap();
    let (before, rest) = text.split_once("<!-- kinds -->\n").unwrap();
    let (_, after) = rest.split_once("<!-- end of kinds -->").unwrap();
    let thresholds = Thresholds::default();
    let row = |kind: &DefectKind| {
        let [suspect, bad] = thresholds.of(*kind);
        format!(
            "| `{}` | {} | {} | {suspect} | {} | {} |\n",
            kind.as_str(),
            if kind.is_property() { "property" } else { "defect" },
            kind.unit(),
            if kind.is_property() {
                "-".to_owned()
            } else {
                bad.to_string()
            },
            kind.help()
        )
    };
    let head = "| kind | class | unit | suspect | bad | what it is |\n|---|---|---|---|---|---|\n";
    let rows = head.to_owned() + &DefectKind::ALL.iter().map(row).collect::<String>();
    let expected = format!("{before}<!-- kinds -->\n{rows}<!-- end of kinds -->{after}");
    if std::env::var_os("MOCAP_WRITE").is_some() {
        std::fs::write(path, &expected).unwrap();
        return;
    }
    assert!(
        text == expected,
        "MOCAP_WRITE=1 cargo test --test it corpus writes {path}"
    );
    for column in ClipRow::column_names() {
        assert!(text.contains(&format!("`{column}`")), "{column}");
    }
}

#[test]
fn the_summary_has_a_command_for_each_of_the_worst() {
    let folder = Folder::of_real(&["kinect_openni.bvh", "nan_tokens.bvh"]);
    let rows = serde_json::from_slice::<Vec<serde_json::Value>>(&folder.run("survey . --json").stdout).unwrap();
    let text = String::from_utf8(folder.run("survey .").stdout).unwrap();
    for row in rows {
        let file = row["file"].as_str().unwrap();
        let command = text
            .lines()
            .find(|line| line.contains("mocap view") && line.contains(file));
        let command = command.unwrap_or_else(|| panic!("{text}")).trim();
        let arguments = command.strip_prefix("mocap ").unwrap();
        folder.succeeds(&format!("{arguments} -o look.html --force"));
    }
}

#[test]
fn the_page_and_the_findings_name_what_is_wrong() {
    let folder = Folder::of_real(&[WALK]);
    folder.write("</script>.bvh", &folder.read(WALK));
    folder.succeeds("survey . --html card.html --sarif found.sarif --threshold skate=0.1");
    let page = String::from_utf8(folder.read("card.html")).unwrap();
    // A file name cannot end an element, and the page fetches nothing.
    assert_eq!(page.matches("</script>").count(), 2);
    assert!(!page.contains("src=") && !page.contains("http:") && !page.contains("https:"));
    // The page has the player of `mocap view` once. A click loads a clip into the player.
    assert_eq!(page.matches("Content-Security-Policy").count(), 1);
    assert_eq!(page.matches("\"played\":{\"blocks\"").count(), 2);
    let sarif: serde_json::Value = serde_json::from_slice(&folder.read("found.sarif")).unwrap();
    let results = sarif["runs"][0]["results"].as_array().unwrap();
    assert!(
        results
            .iter()
            .any(|result| result["ruleId"] == "skate" && result["level"] == "error")
    );
    // RFC 3986 allows neither spaces nor angle brackets in a reference.
    let uri = |result: &serde_json::Value| {
        let place = &result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"];
        place.as_str().unwrap().to_owned()
    };
    assert!(results.iter().any(|result| uri(result).ends_with("%3C/script%3E.bvh")));
    assert!(results.iter().all(|result| !uri(result).contains(['<', '>', ' '])));
}

/// The job of `--print-job` gives the same table with `mocap run`, which accepts folders, and with the library.
#[test]
fn a_survey_is_a_job() {
    let folder = Folder::of_real(&[WALK, "cmu_short.bvh", "lecture_Test.bvh"]);
    let line = "survey . -o rows.csv --where humanoid --threshold skate=0.1";
    folder.succeeds(line);
    let rows = folder.read("rows.csv");
    let printed = folder.run(&format!("{line} --print-job"));
    folder.write("job.json", &printed.stdout);
    folder.write("rows.csv", b"");
    folder.succeeds("run job.json");
    assert_eq!(folder.read("rows.csv"), rows);
    folder.refuses("run job.json --dry-run", 2, "--dry-run");

    let inputs = [WALK, "cmu_short.bvh"].map(|file| folder.path(file));
    let job = |more: serde_json::Value| {
        let mut job = serde_json::json!({"source": {"inputs": inputs}, "survey": {"threshold": ["skate=0.1"]}});
        job.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        Job::from_json(&job.to_string())
    };
    let report = job(serde_json::json!({})).unwrap().run().unwrap();
    assert!(report.files.is_empty() && report.problem.is_none());
    assert_eq!((report.survey.len(), report.survey[0].verdict), (2, Quality::Bad));
    for (more, expected) in [
        (serde_json::json!({"source": {}}), "no input"),
        (
            serde_json::json!({"source": {"inputs": [folder.path("")]}}),
            "is a folder",
        ),
        (
            serde_json::json!({"survey": {"threshold": ["skid=1"]}}),
            "is not a kind of defect",
        ),
        (
            serde_json::json!({"write": {"output": "rows.xyz"}}),
            "cannot be written in this format",
        ),
    ] {
        let error = job(more).unwrap().run().unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    assert!(job(serde_json::json!({"survey": {"where": "skat < 1"}})).is_err());
    // An input cannot be an output, and two outputs must be different files.
    for write in [folder.path(WALK), folder.path("card.html")] {
        let more = serde_json::json!({"survey": {"html": write}, "write": {"output": folder.path("card.html")}});
        assert!(job(more).unwrap().run().is_err());
    }
    let report = job(serde_json::json!({"survey": {"fail-on": "bad", "threshold": ["skate=0.1"]}}));
    assert!(
        report
            .unwrap()
            .run()
            .unwrap()
            .problem
            .unwrap()
            .contains("2 clips are bad")
    );
}

/// The feet of a person who dances on the spot are at rest. On a treadmill, feet in contact move backwards.
#[test]
fn a_dance_is_no_treadmill_and_a_walk_in_place_is_one() {
    let amount = |clips: Vec<ClipRecord>| clips[0].row.amounts[&DefectKind::Treadmill];
    assert!(amount(rows_of("z_up_dab.bvh")) < 1.5);
    let folder = Folder::of_real(&[WALK]);
    folder.succeeds(&format!("edit {WALK} -o here.bvh --step in-place"));
    let scene = mocap::import(folder.path("here.bvh")).unwrap();
    assert!(amount(Thresholds::default().examine(&scene, "here.bvh")) > 3.0);
}

/// Pointed toes are on the other side of the shin, as if the knee bent forwards.
#[test]
fn pointed_toes_are_no_knee_that_bends_forwards() {
    for file in ["fixtures/arrays/kimodo_soma_01.npz", "fixtures/real/run.fbx"] {
        let scene = mocap::import(at_root(file)).unwrap();
        let row = Thresholds::default().examine(&scene, file).remove(0).row;
        assert!(row.amounts[&DefectKind::BeyondRange] < 20.0, "{file}: {row:?}");
    }
}

/// A clip that begins between two samples of another clip, at ten samples per second, is found as a piece of this clip.
#[test]
fn a_piece_that_begins_anywhere_is_a_twin() {
    let mut scene = mocap::import(Path::new(ROOT).join("fixtures/real").join(WALK)).unwrap();
    // Clips of one file with one name are one clip.
    scene.metadata.origin = None;
    let mut clips = Thresholds::default().examine(&scene, "whole.bvh");
    for first in [101.0, 103.0, 107.0, 110.0] {
        let mut piece = scene.clone();
        piece.trim(first, first + 270.0);
        clips.extend(Thresholds::default().examine(&piece, &format!("{first}.bvh")));
    }
    let corpus = Corpus::new(clips, &Thresholds::default());
    assert_eq!(corpus.rows().filter(|row| row.twin).count(), 4);
}

/// In 1.2 s, a walk has more than one step. So two parts of one walk differ, and two walks differ. In 0.6 s, they may
/// be alike.
#[test]
fn short_clips_are_compared_as_a_whole() {
    let other = "motionbuilder_vicon_walk.bvh";
    let folder = Folder::of_real(&[WALK, other]);
    for command in [
        &format!("convert {WALK} short/walk.bvh --trim 1..2.2"),
        &format!("convert {WALK} short/other_part.bvh --trim 2.6..3.8"),
        &format!("convert {other} short/other_walk.bvh --trim 1..2.2"),
        "edit short/walk.bvh -o short/mirrored.bvh --step mirror",
        "convert short/walk.bvh short/resampled.bvh --fps 25",
        "convert short/walk.bvh short/retimed.bvh --retime 128",
        &format!("convert {WALK} tiny/step.bvh --trim 3..3.6"),
        "convert tiny/step.bvh tiny/resampled.bvh --fps 25",
    ] {
        let path = command
            .split(' ')
            .find(|word| word.starts_with("short/") || word.starts_with("tiny/"));
        std::fs::create_dir_all(folder.path(path.unwrap()).parent().unwrap()).unwrap();
        folder.succeeds(command);
    }
    folder.succeeds("survey short -o rows.json");
    let rows: Vec<serde_json::Value> = serde_json::from_slice(&folder.read("rows.json")).unwrap();
    let groups: Vec<(String, bool)> = rows
        .iter()
        .map(|row| (row["file"].as_str().unwrap().to_owned(), row["twin_group"].is_number()))
        .collect();
    let copies = ["walk", "mirrored", "resampled", "retimed"];
    for (file, is_copy) in groups {
        let expected = copies.iter().any(|copy| file == format!("short/{copy}.bvh"));
        assert_eq!(is_copy, expected, "{file}");
    }
    assert_eq!(rows.iter().filter(|row| row["twin"] == true).count(), 3);
    let said = folder.succeeds("survey short -o rows.csv --split 0.5,0.5 --force");
    assert!(!said.contains("identical files"), "{said}");
    // A shorter clip is not compared, and the survey says so.
    let note =
        "2 clips not longer than 0.9 s: such short clips count as near-duplicates only if their files are identical";
    let summary = String::from_utf8(folder.run("survey tiny").stdout).unwrap();
    assert!(
        summary.contains(&format!("near-duplicates: 0 clips\n  {note}\n")),
        "{summary}"
    );
    let said = folder.succeeds("survey tiny -o rows.csv --split 0.5,0.5 --force");
    assert!(said.contains(note), "{said}");
}

#[test]
fn the_summary_shows_near_duplicates() {
    let folder = Folder::of_real(&[WALK, "rokoko_dance.bvh"]);
    folder.write("copy.bvh", &folder.read(WALK));
    folder.succeeds(&format!("convert {WALK} a_piece.bvh --trim 1..3.5"));
    let summary = |arguments: &str| String::from_utf8(folder.run(arguments).stdout).unwrap();
    let shown = summary("survey .");
    let expected = format!(
        "near-duplicates: 2 clips (bytes 1, piece 1)\n  piece       mocap view a_piece.bvh {WALK}\n  bytes       mocap view \
         copy.bvh {WALK}\n"
    );
    assert!(shown.replace("./", "").contains(&expected), "{shown}");
    let none = summary("survey . --where frames>1000000");
    assert!(none.starts_with("0 clips, 0.0 min\n"), "{none}");
}

#[test]
fn a_pose_file_is_not_selected() {
    let folder = Folder::of_real(&[WALK, "makehuman_fly_one_frame.bvh"]);
    for (options, count) in [
        ("--select 2", 1),
        ("--select 2 --by diversity", 1),
        ("--select 2 --by diversity --threshold pose-file=inf", 2),
    ] {
        folder.succeeds(&format!("survey . {options} -o chosen.txt --force"));
        let chosen = String::from_utf8(folder.read("chosen.txt")).unwrap();
        assert_eq!(chosen.lines().count(), count, "{options}: {chosen}");
        assert!(chosen.contains(WALK), "{options}: {chosen}");
    }
}

#[test]
fn a_missing_file_or_folder_is_named() {
    let folder = Folder::with(&["a.bvh"]);
    for command in ["survey nothing", "run nothing", "plot nothing -o a.svg --joint Head"] {
        folder.refuses(command, 1, "nothing: error[io]: the file or folder does not exist");
    }
    for command in ["run .", "sheet . -o a.png"] {
        folder.refuses(command, 1, ".: error[io]: it is a folder, not a file");
    }
    folder.refuses(
        "info a.bvh/walk.bvh",
        1,
        "a.bvh/walk.bvh: error[io]: a part of the path is a file, not a folder",
    );
}

#[test]
fn the_table_of_a_survey_is_not_a_motion() {
    let folder = Folder::of_real(&[WALK]);
    folder.succeeds(&format!("survey {WALK} -o rows.csv"));
    for command in ["convert rows.csv out.bvh", "survey rows.csv"] {
        folder.refuses(command, 1, "the table of a survey is not a motion");
        folder.refuses(
            command,
            1,
            "mocap survey reads only .jsonl: write the table with --output rows.jsonl",
        );
    }
}

#[test]
fn arms_that_are_held_out_are_a_t_pose() {
    // Computed with NumPy, the arms point sideways, 20 degrees from the horizontal, until frame 486 at 100 frames per
    // second.
    let row = rows_of("hip_knee_ankle_names.bvh").remove(0).row;
    let seconds = row.amounts[&DefectKind::TPoseEnd];
    assert!((3.0..4.9).contains(&seconds), "{:?}", row.defects);
    // A dancer who briefly holds the arms out is not in a T-pose.
    let dance = rows_of("rokoko_dance.bvh").remove(0).row;
    assert_eq!(dance.amounts[&DefectKind::TPose], 0.0, "{dance:?}");
}

#[test]
fn a_copy_of_a_twin_repeats_what_is_kept_as_the_twin_does() {
    let text = std::fs::read_to_string(Path::new(ROOT).join("fixtures/real").join(WALK)).unwrap();
    let slower = text.replace("Frame Time: .0083333", "Frame Time: .0089");
    assert_ne!(text, slower);
    let rows_of_text = |text: &str, file: &str| {
        let scene = mocap::Importer::new().read(text.as_bytes(), file).unwrap();
        Thresholds::default().examine(&scene, file)
    };
    let files = [("a.bvh", &text), ("b.bvh", &text), ("slower.bvh", &slower)];
    let clips = files.into_iter().flat_map(|(file, text)| rows_of_text(text, file));
    let corpus = Corpus::new(clips.collect(), &Thresholds::default());
    let rows: Vec<&ClipRow> = corpus.rows().collect();
    assert_eq!(rows[0].twin_of.as_deref(), Some("slower.bvh"), "{rows:?}");
    for row in &rows[..2] {
        assert_eq!(row.twin_reason.as_deref(), Some("retimed"), "{row:?}");
    }
}
