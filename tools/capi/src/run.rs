//! Whole jobs.

use std::ffi::{CString, c_char};
use std::ptr;

use mocap::Importer;
use mocap::job::Job;
use mocap::retarget::robot::RobotMotion;
use mocap::retarget::{RetargetOptions, Retargeter};
use mocap::verify::Verifier;

use crate::border::{Failure, guard};
use crate::{path_from, text};

/// Runs a job, as `mocap run` does: reads files, edits motions, retargets them, and writes files. `job` is the JSON of
/// the job, described by `src/job/job.schema.json`.
///
///     mocap_run("{\"source\": {\"inputs\": [\"walk.bvh\"]}, \"write\": {\"output\": \"walk.glb\"}}")
///
/// A job with `survey` writes no motion: the report has a row for each clip, in `survey`. A job with `graph` writes the
/// motion graph of its inputs as JSON. A job with `walk` writes a motion along a walk over a graph.
/// `docs/motion-graphs.md` describes both.
///
/// Returns a report as JSON with `files`, `notes` and `warnings`. If the output is worse than the job allows, it has
/// `problem`. Free the text with `mocap_text_free`. NULL if the job fails; no file is then written.
///
/// # Safety
/// `job` is a string that ends with a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_run(job: *const c_char) -> *mut c_char {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller passes a string with a zero byte at its end.
        let job = unsafe { text(job, "job") }?;
        let job = job.to_str().map_err(|_| Failure::argument("job is not UTF-8"))?;
        let job = Job::from_json(job).map_err(|error| Failure::argument(&error.to_string()))?;
        let report = serde_json::to_string(&job.run()?).unwrap_or_default();
        Ok(CString::new(report).unwrap_or_default().into_raw())
    })
}

/// Compares a written file with its source, as `mocap verify` does. The output records the changes, and the comparison
/// repeats them.
///
/// Returns the differences as JSON with `max_error` in metres and `findings`. Free the text with `mocap_text_free`.
/// NULL if the files cannot be compared.
///
/// # Safety
/// `source` and `output` are strings that end with a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_verify(source: *const c_char, output: *const c_char) -> *mut c_char {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller passes strings with a zero byte at their end.
        let (source, output) = unsafe { (text(source, "source")?, text(output, "output")?) };
        let found = Verifier::new().files(path_from(source)?, path_from(output)?)?;
        let report = serde_json::to_string(&found).unwrap_or_default();
        Ok(CString::new(report).unwrap_or_default().into_raw())
    })
}

/// Scores a motion of a robot against its reference, as `mocap score` does. `motion` has arrays of the robot's joints,
/// from any program. `robot` is the URDF or MJCF file of the robot. `body` is the robot of the reference, or NULL if a
/// person moves in it.
///
/// Returns the report as JSON, with `scores` and `verdict`. Free the text with `mocap_text_free`. NULL if the files
/// cannot be compared.
///
/// # Safety
/// `reference`, `motion` and `robot` are strings that end with a zero byte. `body` is such a string or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_score(
    reference: *const c_char,
    motion: *const c_char,
    robot: *const c_char,
    body: *const c_char,
) -> *mut c_char {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller passes strings with a zero byte at their end.
        let (reference, motion, robot_file) = unsafe {
            (
                text(reference, "reference")?,
                text(motion, "motion")?,
                text(robot, "robot")?,
            )
        };
        let robot_file = path_from(robot_file)?;
        let robot = Importer::new().import_robot(robot_file)?;
        let moved = Importer::new().body(robot_file).import(path_from(motion)?)?;
        let motion = RobotMotion::of_arrays(&robot, &moved)?;
        let mut importer = Importer::new();
        if !body.is_null() {
            // SAFETY: the caller passes a string with a zero byte at its end.
            importer = importer.body(path_from(unsafe { text(body, "body") }?)?);
        }
        let reference = importer.import(path_from(reference)?)?;
        let found = Retargeter::onto(robot, RetargetOptions::new())?.judge(reference, &motion)?;
        let report = serde_json::to_string(&found).unwrap_or_default();
        Ok(CString::new(report).unwrap_or_default().into_raw())
    })
}

/// Frees a string that `mocap_run`, `mocap_verify`, `mocap_score`, `mocap_report` or `mocap_robot_stream_report` has
/// returned. NULL is allowed.
///
/// # Safety
/// `text` comes from one of these functions, and was not freed before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_text_free(text: *mut c_char) {
    guard((), || {
        if !text.is_null() {
            // SAFETY: the pointer comes from `CString::into_raw`, and the caller gives it up.
            drop(unsafe { CString::from_raw(text) });
        }
        Ok(())
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs every step of `tests/steps.json` on a short motion, with a second motion for the steps that take one.
    #[test]
    fn every_step_can_be_done_in_a_job() {
        let steps: Vec<String> = serde_json::from_str(include_str!("../../../tests/steps.json")).unwrap();
        let real = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/real/");
        let folder = std::env::temp_dir().join(format!("mocap_run_{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let output = folder.join("out.bvh");
        for step in steps {
            let takes_other = ["concat", "blend", "layer"].iter().any(|name| step.starts_with(name));
            let inputs = ["cmu_short.bvh", "cmu_12_01_walk.bvh"].map(|name| format!("{real}{name}"));
            let job = serde_json::json!({
                "source": {"inputs": [inputs[0]], "with": inputs[1..1 + usize::from(takes_other)]},
                "steps": [step],
                "write": {"output": output, "force": true},
            });
            let text = CString::new(job.to_string()).unwrap();
            // SAFETY: the text ends with a zero byte.
            let report = unsafe { mocap_run(text.as_ptr()) };
            assert!(!report.is_null(), "{step}");
            // SAFETY: the text comes from `mocap_run`.
            unsafe { mocap_text_free(report) };
            let made = Job::from_json(&job.to_string()).unwrap().make(&[]).unwrap().0;
            assert!(made.into_bytes().unwrap() == std::fs::read(&output).unwrap(), "{step}");
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn graphs_and_walks_are_jobs() {
        let clip = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/real/cmu_12_01_walk.bvh");
        let folder = std::env::temp_dir().join(format!("mocap_graph_{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let [graph, walk] = ["graph.json", "walk.bvh"].map(|name| folder.join(name));
        let run = |job: serde_json::Value| {
            let text = CString::new(job.to_string()).unwrap();
            // SAFETY: the text ends with a zero byte.
            let report = unsafe { mocap_run(text.as_ptr()) };
            if report.is_null() {
                return None;
            }
            // SAFETY: the text comes from `mocap_run`.
            let text = unsafe { std::ffi::CStr::from_ptr(report) }.to_str().unwrap().to_owned();
            // SAFETY: the text comes from `mocap_run`, and nothing borrows it.
            unsafe { mocap_text_free(report) };
            Some(serde_json::from_str::<serde_json::Value>(&text).unwrap())
        };
        let compared = run(serde_json::json!({
            "source": {"inputs": [clip]}, "graph": {"threshold": "5cm"}, "write": {"output": graph},
        }));
        let written = std::fs::read_to_string(&graph).unwrap();
        let written = mocap::graph::MotionGraph::from_json(&written).unwrap();
        let transitions = written.transitions.len();
        assert!(transitions > 0);
        assert_eq!(compared.unwrap()["graph"]["transitions"], transitions);
        let walked = |output: &std::path::Path| {
            serde_json::json!({
                "source": {"inputs": [graph]}, "walk": {"seconds": 7}, "write": {"output": output},
            })
        };
        assert_eq!(run(walked(&walk)).unwrap()["walk"]["frames"], 841); // 7 s at 120 Hz
        assert_eq!(mocap::import(&walk).unwrap().animations[0].frame_count(), 841);
        // The graph is an input, so the walk must not replace it.
        assert!(run(walked(&graph)).is_none());
        std::fs::write(&graph, "{").unwrap();
        assert!(run(walked(&folder.join("none.bvh"))).is_none() && !folder.join("none.bvh").exists());
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
