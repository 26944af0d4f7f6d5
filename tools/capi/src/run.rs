//! Whole jobs.

use std::ffi::{CString, c_char};
use std::ptr;

use mocap::job::Job;

use crate::border::{Failure, guard};
use crate::text;

/// Does a job, as `mocap run` does: reads files, changes motions, puts them on another body, writes files. `job` is its
/// JSON; `docs/job.schema.json` says what it may hold.
///
///     mocap_run("{\"source\": {\"inputs\": [\"walk.bvh\"]}, \"write\": {\"output\": \"walk.glb\"}}")
///
/// Returns what was done, as JSON with `files`, `notes` and `warnings`, and with `problem` where the output is worse
/// than the job allows; `mocap_text_free` frees it. NULL where the job cannot be done; no file is then written.
///
/// # Safety
/// `job` is a text that ends with a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_run(job: *const c_char) -> *mut c_char {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller hands over a text with a zero byte at its end.
        let job = unsafe { text(job, "job") }?;
        let job = job.to_str().map_err(|_| Failure::argument("job is not UTF-8"))?;
        let job = Job::from_json(job).map_err(|error| Failure::argument(&error.to_string()))?;
        let report = serde_json::to_string(&job.run()?).unwrap_or_default();
        Ok(CString::new(report).unwrap_or_default().into_raw())
    })
}

/// Frees a text that `mocap_run` has returned. NULL is allowed.
///
/// # Safety
/// `text` comes from `mocap_run`, and was not freed before.
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
