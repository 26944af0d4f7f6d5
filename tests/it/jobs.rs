//! Jobs: what a command line means, done by `mocap run`.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use mocap::convert::{FirstFrame, Moment};
use mocap::job::Job;
use mocap::retargeting::{Retargeting, RetargetingOptions};
use mocap::robot::RobotMotion;
use mocap::{Conversion, MemoryFile};

use crate::sample::Sample;

/// Command lines that do a job; OUT is a folder of the run.
const LINES: &[&str] = &[
    "convert fixtures/real/cmu_short.bvh OUT/a.glb",
    "convert fixtures/real/cmu_short.bvh OUT/a.gltf --embed --keep-constant --mesh segmented --force",
    "convert fixtures/real/cmu_short.bvh OUT/a.gltf",
    "convert fixtures/real/cmu_short.bvh OUT/a.bvh --out-unit cm --out-up z --digits 5 --order XYZ",
    "convert fixtures/real/cmu_short.bvh OUT/a.bvh --channels 6",
    "convert fixtures/real/cmu_short.bvh OUT/a.fbx --target maya --max-error 1mm",
    "convert fixtures/real/cmu_short.bvh OUT/a.vrma --verify",
    "convert fixtures/real/cmu_short.bvh OUT/a.mclip --max-error 5mm --shell-distance 3cm",
    "convert fixtures/real/cmu_short.bvh OUT/a.glb --trim 0.2..1.1 --fps 24 --in-place --up y",
    "convert fixtures/real/cmu_short.bvh OUT/a.glb --trim 10f..60f --root-motion --drop-first-frame yes --rest frame:20",
    "convert fixtures/real/cmu_short.bvh OUT/a.glb --max-error 1mm --compress none",
    "edit fixtures/real/cmu_short.bvh -o OUT/a.glb --step smooth:cut-off=8 --step mirror",
    "edit fixtures/real/cmu_short.bvh -o OUT/a.gltf --step mirror",
    "edit fixtures/real/cmu_short.bvh -o OUT/a.gltf --step mirror --embed",
    "edit fixtures/real/cmu_short.bvh -o OUT/a.bvh --step foot-lock --unit cmu",
    "edit fixtures/real/cmu_short.bvh fixtures/real/cmu_short.bvh -o OUT/a.fbx --step concat --step warp:speed=2",
    "retarget fixtures/real/cmu_short.bvh fixtures/skeletons/human_vrm1.gltf -o OUT/a.gltf",
    "retarget fixtures/real/cmu_short.bvh fixtures/skeletons/human_vrm1.gltf -o OUT/a.gltf --embed",
    "retarget fixtures/real/cmu_short.bvh -o OUT/a.bvh --to-skeleton fixtures/skeletons/human_default.gltf --scale 2",
    "retarget fixtures/real/cmu_short.bvh fixtures/skeletons/human_vrm1.gltf -o OUT/a.vrma --feet free",
    "retarget fixtures/real/cmu_short.bvh fixtures/skeletons/human_cmu.gltf -o OUT/a.fbx --max-error 1mm",
    "robot fixtures/real/cmu_short.bvh --robot fixtures/robots/h1.urdf -o OUT/a.npz --trim 0..0.3 --fps 30",
    "robot fixtures/real/cmu_short.bvh --robot fixtures/robots/h1.urdf -o OUT/a.npz --to qpos --trim 0..0.2",
    "robot fixtures/real/cmu_short.bvh --robot fixtures/robots/h1.urdf -o OUT/a.csv --trim 0..0.2 --velocity-limits",
];

fn mocap(words: &[String]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mocap")).args(words).output().unwrap()
}

fn words(line: &str, folder: &Path) -> Vec<String> {
    let folder = folder.to_str().unwrap();
    line.split(' ').map(|word| word.replace("OUT", folder)).collect()
}

/// The names and the bytes of all files of a folder.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = entries
        .map(|path| {
            (
                path.file_name().unwrap().to_string_lossy().into_owned(),
                fs::read(&path).unwrap(),
            )
        })
        .collect();
    files.sort();
    files
}

/// What `--print-job` gives for a command of `mocap --help`, by the least arguments that it takes.
#[test]
fn every_command_prints_its_job_or_says_why_it_has_none() {
    const JOBS: [(&str, &str); 8] = [
        ("convert", "a.bvh a.glb"),
        ("edit", "a.bvh -o a.glb --step mirror"),
        ("clean", "a.bvh -o a.glb"),
        ("solve", "a.npy --joints smpl22 -o a.glb"),
        ("retarget", "a.bvh hero.gltf -o b.gltf"),
        ("robot", "a.bvh --robot h1.urdf -o a.csv"),
        ("survey", "a.bvh -o rows.csv"),
        ("graph", "a.bvh -o graph.json"),
    ];
    let help = mocap(&["--help".to_owned()]).stdout;
    let help = String::from_utf8(help).unwrap();
    let listed = help.lines().take_while(|line| *line != "Options:").filter_map(|line| {
        let (name, about) = line.strip_prefix("  ")?.split_once("  ")?;
        (!name.is_empty() && !about.is_empty()).then_some(name)
    });
    let listed: Vec<&str> = listed.collect();
    assert!(listed.len() >= 19, "{listed:?}");
    assert!(JOBS.iter().all(|(name, _)| listed.contains(name)));
    for name in listed {
        let arguments = JOBS
            .iter()
            .find(|(job, _)| *job == name)
            .map(|(_, arguments)| *arguments);
        let line = [name, arguments.unwrap_or_default(), "--print-job"].join(" ");
        let line: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
        let printed = mocap(&line);
        let said = String::from_utf8(printed.stderr).unwrap();
        if arguments.is_some() {
            assert!(printed.status.success(), "{name}: {said}");
            Job::from_json(&String::from_utf8(printed.stdout).unwrap()).unwrap();
            continue;
        }
        assert_eq!(printed.status.code(), Some(2), "{name}: {said}");
        assert!(printed.stdout.is_empty() && said.lines().count() == 1, "{name}: {said}");
        // A build without Parquet has no such command.
        let has_none = said.contains("are jobs; leave it out") || name == "pack" && said.contains("this build cannot");
        assert!(has_none, "{name}: {said}");
    }
}

/// A command line and the job that it prints write the same files, byte for byte. Every third is tried, of each command
/// one at least.
#[test]
fn a_command_and_its_job_write_the_same() {
    let lines = Sample::new().some(LINES, 3);
    for command in ["convert", "edit", "retarget", "robot"] {
        assert!(lines.iter().any(|line| line.starts_with(command)), "{command}");
    }
    for line in lines {
        let (plain, of_job) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let done = mocap(&words(line, plain.path()));
        assert!(
            done.status.success(),
            "{line}: {}",
            String::from_utf8_lossy(&done.stderr)
        );
        let mut print = words(line, of_job.path());
        print.push("--print-job".to_owned());
        let printed = mocap(&print);
        assert!(
            printed.status.success(),
            "{line}: {}",
            String::from_utf8_lossy(&printed.stderr)
        );
        assert!(files(of_job.path()).is_empty(), "{line}: --print-job writes nothing");
        let job = of_job.path().join("job.json");
        fs::write(&job, &printed.stdout).unwrap();
        let ran = mocap(&["run".to_owned(), job.to_str().unwrap().to_owned()]);
        assert!(ran.status.success(), "{line}: {}", String::from_utf8_lossy(&ran.stderr));
        fs::remove_file(job).unwrap();
        let (expected, found) = (files(plain.path()), files(of_job.path()));
        let names = |files: &[(String, Vec<u8>)]| files.iter().map(|file| file.0.clone()).collect::<Vec<_>>();
        assert_eq!(names(&found), names(&expected), "{line}");
        assert!(
            found == expected,
            "{line}: {}",
            String::from_utf8_lossy(&printed.stdout)
        );
    }
}

/// What is printed is read as the job that was printed.
#[test]
fn a_job_survives_its_json() {
    for line in LINES {
        let folder = tempfile::tempdir().unwrap();
        let mut print = words(line, folder.path());
        print.push("--print-job".to_owned());
        let text = String::from_utf8(mocap(&print).stdout).unwrap();
        let job = Job::from_json(&text).unwrap();
        assert_eq!(job.to_json(), text.trim_end(), "{line}");
    }
}

#[test]
fn a_wrong_job_says_where() {
    for (json, expected) in [
        ("", "the job: it must be a JSON object"),
        ("{", "the job: EOF while parsing an object"),
        ("[]", "the job: it must be a JSON object"),
        (r#"{} {}"#, "the job: something follows the JSON object"),
        (
            r#"{"wirte": {}}"#,
            "the job: wirte: unknown field `wirte`, expected one of `read`, `source`",
        ),
        (
            r#"{"write": {"smaller": {"max-error": "far"}}}"#,
            "the job: write.smaller.max-error: \"far\": not a length, such as 1mm",
        ),
        (
            r#"{"source": {"frames": {"fps": "fast"}}}"#,
            "the job: source.frames.fps: invalid type: string \"fast\", expected f64",
        ),
        (
            r#"{"onto": {"animal": {}}}"#,
            "the job: onto: unknown variant `animal`, expected one of `character`, `skeleton`, `robot`",
        ),
        (r#"{"steps": ["shake"]}"#, "there is no step \"shake\""),
    ] {
        let error = Job::from_json(json).unwrap_err();
        let message = &error.diagnostic().message;
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn a_job_refuses_what_its_format_does_not_take() {
    let refused = |write: &str| {
        let json = format!(r#"{{"source": {{"inputs": ["fixtures/real/lecture_Test.bvh"]}}, "write": {write}}}"#);
        let error = Job::from_json(&json).unwrap().run().unwrap_err();
        (error.code().as_str(), error.diagnostic().message.clone())
    };
    let (code, message) = refused(r#"{"output": "a.glb", "bvh": {"digits": 3}}"#);
    assert_eq!(code, "invalid-value");
    assert!(message.starts_with("--digits has no effect on"), "{message}");
    assert_eq!(refused(r#"{"output": "a.xyz"}"#).0, "unknown-format");
    assert_eq!(
        refused(r#"{"output": "fixtures/real/lecture_Test.bvh", "force": true}"#).0,
        "output-is-input"
    );
}

/// Options of another format, of another body and of a folder are refused, and so are outputs that are inputs.
#[test]
fn a_job_refuses_what_would_do_nothing() {
    const WALK: &str = r#""source": {"inputs": ["fixtures/real/cmu_short.bvh"]}"#;
    let refused = |rest: &str, expected: &str| {
        let json = format!("{{{WALK}, {rest}}}");
        let error = Job::from_json(&json).unwrap().run().unwrap_err();
        assert!(error.to_string().contains(expected), "{json}: {error}");
    };
    let hero = r#""onto": {"character": {"file": "fixtures/skeletons/human_vrm1.gltf"}}"#;
    let robot = r#""onto": {"robot": {"file": "fixtures/robots/h1.urdf"}}"#;
    for (write, expected) in [
        (
            r#""output": "a.gltf", "bvh": {"digits": 3}"#,
            "--digits has no effect on glTF",
        ),
        (
            r#""output": "a.gltf", "keep-constant": true"#,
            "--keep-constant has no effect on a character, whose file is passed through",
        ),
        (r#""output": "a.glb""#, "must end in .gltf, as that of the character"),
        (
            r#""output": "a.gltf", "smaller": {"shell-distance": "3cm"}"#,
            "--shell-distance would do nothing",
        ),
        (
            r#""output": "a.bvh", "space": {"out-unit": "cm"}, "embed": true"#,
            "--embed has no effect",
        ),
        (
            r#""output": "fixtures/skeletons/human_vrm1.gltf", "force": true"#,
            "output-is-input",
        ),
    ] {
        refused(&format!(r#"{hero}, "write": {{{write}}}"#), expected);
    }
    for (write, expected) in [
        (
            r#""output": "a.npz", "smaller": {"max-error": "1mm"}"#,
            "--max-error has no effect on the numbers of a robot's joints",
        ),
        (r#""output": "a.xyz""#, "must end in .npz, .pkl, .csv, .bvh"),
        (r#""output": "out/", "to": "csv""#, "do it with mocap run"),
        (
            r#""output": "-", "to": "csv""#,
            "standard output, which belongs to the program",
        ),
    ] {
        refused(&format!(r#"{robot}, "write": {{{write}}}"#), expected);
    }
    for (onto, expected) in [
        (
            r#"{"robot": {"file": "fixtures/robots/h1.urdf", "max-angle": 3}}"#,
            "--max-angle would do nothing: it is for a character",
        ),
        (
            r#"{"skeleton": {"file": "fixtures/skeletons/human_default.gltf", "velocity-limits": true}}"#,
            "--velocity-limits would do nothing: it is for a robot",
        ),
        (
            r#"{"skeleton": {"file": "fixtures/skeletons/human_default.gltf", "replace-animations": true}}"#,
            "--replace-animations would do nothing",
        ),
    ] {
        refused(&format!(r#""onto": {onto}, "write": {{"output": "a.glb"}}"#), expected);
    }
    // A second motion is an input too.
    let with = r#"{"source": {"inputs": ["fixtures/real/lecture_Test.bvh"], "with": ["fixtures/real/cmu_short.bvh"]},
        "steps": ["concat"], "write": {"output": "fixtures/real/cmu_short.bvh", "force": true}}"#;
    let error = Job::from_json(with).unwrap().run().unwrap_err();
    assert_eq!(error.code().as_str(), "output-is-input");
    // Numbers of one motion only: none is dropped in silence.
    let two = format!(
        r#"{{"source": {{"inputs": ["fixtures/real/cmu_short.bvh", "fixtures/real/cmu_short.bvh"],
        "frames": {{"trim": "0..0.1"}}}}, {robot}, "write": {{"output": "two.csv"}}}}"#
    );
    let error = Job::from_json(&two).unwrap().run().unwrap_err();
    assert!(error.to_string().contains("has one motion; name one"), "{error}");
}

/// A robot's T-pose is looked for with the rest pose that the motion begins with, whatever part of it is taken.
#[test]
fn a_part_of_a_motion_on_a_robot_is_that_part_of_the_whole() {
    let robot = mocap::Importer::new().import_robot("fixtures/robots/h1.urdf").unwrap();
    let moved = |conversion: Conversion, first: FirstFrame| {
        let mut walk = mocap::import("fixtures/real/cmu_short.bvh").unwrap();
        Conversion::new()
            .keep_units(true)
            .first_frame(first)
            .apply(&mut walk)
            .unwrap();
        // Frame by frame, so that a frame does not depend on those after it.
        let options = RetargetingOptions::new()
            .lock_feet(false)
            .passes(1)
            .conversion(conversion);
        let moved = Retargeting::new(walk, robot.clone(), options).unwrap();
        moved.clips()[0].robot_motion.clone().unwrap()
    };
    let whole = moved(Conversion::new(), FirstFrame::Keep);
    let part = moved(Conversion::new().trim(None, Moment::Frame(30)), FirstFrame::Keep);
    assert_eq!((whole.frames(), part.frames()), (74, 30));
    let apart = |other: &RobotMotion| {
        let pairs = std::iter::zip(whole.dof_of(0), other.dof_of(0));
        pairs.map(|(a, b)| (a - b).abs().to_degrees()).fold(0.0, f64::max)
    };
    assert!(apart(&part) < 0.01, "{} degrees", apart(&part));
    // Without that frame the T-pose is another.
    let without = moved(Conversion::new(), FirstFrame::Drop);
    assert!(apart(&without) > 0.1, "{} degrees", apart(&without));
}

#[test]
fn a_job_runs_in_memory_as_on_a_disk() {
    let motion = fs::read("fixtures/real/cmu_short.bvh").unwrap();
    let hero = fs::read("fixtures/skeletons/human_vrm1.gltf").unwrap();
    let robot = fs::read("fixtures/robots/h1.urdf").unwrap();
    let files = [
        MemoryFile {
            name: "fixtures/real/cmu_short.bvh",
            bytes: &motion,
        },
        MemoryFile {
            name: "fixtures/skeletons/human_vrm1.gltf",
            bytes: &hero,
        },
        MemoryFile {
            name: "fixtures/robots/h1.urdf",
            bytes: &robot,
        },
    ];
    for (onto, output) in [
        ("", "a.glb"),
        ("", "a.gltf"),
        (
            r#""onto": {"character": {"file": "fixtures/skeletons/human_vrm1.gltf"}},"#,
            "a.gltf",
        ),
        (r#""onto": {"robot": {"file": "fixtures/robots/h1.urdf"}},"#, "a.csv"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(output);
        let json = format!(
            r#"{{"source": {{"inputs": ["fixtures/real/cmu_short.bvh"], "frames": {{"trim": "0..0.5"}}}}, {onto} "write": {{"output": {path:?}}}}}"#
        );
        let job = Job::from_json(&json).unwrap();
        job.run().unwrap();
        let (written, report) = job.run_in_memory(&files).unwrap();
        let in_memory = written.files.iter().map(|file| file.bytes().into_owned());
        let on_disk = report
            .files
            .iter()
            .map(|file| fs::read(folder.path().join(&file.name)).unwrap());
        assert!(in_memory.eq(on_disk), "{json}");
    }
    let job = Job::from_json(r#"{"source": {"inputs": ["b.bvh"]}, "write": {"output": "b.glb"}}"#).unwrap();
    assert_eq!(job.run_in_memory(&files).unwrap_err().code().as_str(), "missing-file");
}
