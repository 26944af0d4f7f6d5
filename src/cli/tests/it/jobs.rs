//! Jobs: `mocap run` gives the same result as the command line.

use std::fs;
use std::path::Path;
use std::process::Output;

use mocap::job::Job;

use crate::program;
use crate::sample::Sample;

/// Command lines with a job; OUT is a folder of the run.
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
    program::run(words)
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

/// The output of `--print-job` for each command of `mocap --help`, with the fewest arguments.
#[test]
fn every_command_prints_its_job_or_says_why_it_has_none() {
    const JOBS: [(&str, &str); 8] = [
        ("convert", "a.bvh a.glb"),
        ("edit", "a.bvh -o a.glb --step mirror"),
        ("clean", "a.bvh -o a.glb"),
        ("solve", "a.npy --joint-set smpl22 -o a.glb"),
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
        // A build without Parquet does not have the command.
        let has_none =
            said.contains("have a job; omit --print-job") || name == "pack" && said.contains("this build cannot");
        assert!(has_none, "{name}: {said}");
    }
}

/// A command line and its printed job write the same bytes. The test tries every third command line, and at least one
/// of each command.
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

/// The printed text parses to the same job.
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
