//! Every step of `mocap edit` writes the same bytes from the command line, from a job and from the library. The tests
//! of C, Python and JavaScript read the same list of steps, `tests/steps.json`.

use mocap::MemoryFile;
use mocap::edit::EditStep;
use mocap::job::Job;
use serde_json::json;

use crate::program::Folder;
use crate::sample::Sample;

const MOTION: &str = "cmu_short.bvh";
const OTHER: &str = "cmu_12_01_walk.bvh";

/// The steps, and whether each takes a second motion.
fn steps() -> Vec<(String, bool)> {
    let texts: Vec<String> = serde_json::from_str(include_str!("../../../../tests/steps.json")).unwrap();
    let known = |text: &String| {
        EditStep::ALL
            .iter()
            .find(|step| text.split(':').next() == Some(step.name))
    };
    let steps = texts.into_iter().map(|text| {
        let step = known(&text).unwrap_or_else(|| panic!("no step is called {text}"));
        (text, step.takes_other)
    });
    steps.collect()
}

#[test]
fn every_step_is_tried() {
    let tried = steps();
    for step in EditStep::ALL {
        let is_it = |(text, _): &(String, bool)| text.split(':').next() == Some(step.name);
        assert!(tried.iter().any(is_it), "tests/steps.json lacks {}", step.name);
    }
}

#[test]
fn every_step_is_the_same_on_the_command_line_in_a_job_and_in_the_library() {
    let folder = Folder::of_real(&[MOTION, OTHER]);
    for (step, takes_other) in Sample::new().some(steps(), 2) {
        let others = if takes_other { &[OTHER][..] } else { &[] };
        let inputs = [&[MOTION], others].concat();
        folder.succeeds(&format!(
            "edit {} -o line.bvh --force --quiet --step {step}",
            inputs.join(" ")
        ));
        // By default, the command line drops a rest pose in the first frame. A job has to state it.
        let source = json!({"inputs": [MOTION], "with": others, "frames": {"drop-first-frame": "auto"}});
        let job = json!({"source": source, "steps": [step], "write": {"output": "job.bvh", "force": true}});
        folder.write("job.json", job.to_string().as_bytes());
        folder.succeeds("run job.json --quiet");
        let done = folder.read("job.bvh");
        assert!(
            folder.read("line.bvh") == done,
            "{step}: the command line and the job differ"
        );

        let files: Vec<_> = inputs.iter().map(|name| (name, folder.read(name))).collect();
        let files: Vec<_> = files.iter().map(|(name, bytes)| MemoryFile { name, bytes }).collect();
        let (made, report) = Job::from_json(&job.to_string()).unwrap().run_in_memory(&files).unwrap();
        assert_eq!(report.steps.len(), 1, "{step}");
        assert!(
            made.into_bytes().unwrap() == done,
            "{step}: the program and the library differ"
        );
    }
}
