//! Edits a copy of a scene.

use std::ffi::{CStr, c_char};
use std::ptr;
use std::slice;

use mocap::edit::EditStep;
use mocap::retarget::apply_steps;

use crate::border::{Failure, guard};
use crate::handle::Scene;
use crate::{opened, text};

/// Returns a copy of a scene after steps in order, as `mocap edit` does. `steps` is a JSON list. Each step is a string
/// in the form of `mocap edit --step`, or an object with the step's name and options.
///
///     mocap_edit(walk, "[\"mirror\", {\"step\": \"smooth\", \"cut-off\": 8}]", NULL, 0)
///
/// `others` are the second motions of the steps that take one, in order, and `other_count` is their number. Lengths in
/// steps are in metres, for any unit of the scene. The steps change every animation, including a rest pose in its
/// first frame. `mocap_edit_report_text` of the copy returns the changes of each step in each animation.
///
/// Returns NULL if a step is unknown or fails. The original scenes do not change. Free each scene with `mocap_close`.
///
/// # Safety
/// `scene` is an open scene, and `steps` is a string that ends with a zero byte. `others` points to `other_count` open
/// scenes, or is NULL if `other_count` is 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_edit(
    scene: *const Scene,
    steps: *const c_char,
    others: *const *const Scene,
    other_count: usize,
) -> *mut Scene {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller passes an open scene.
        let scene = unsafe { opened(scene) }?;
        // SAFETY: the caller passes a string with a zero byte at its end.
        let steps = read_steps(unsafe { text(steps, "steps") }?)?;
        let others = match other_count {
            0 => &[][..],
            _ if others.is_null() => return Err(Failure::argument("others is NULL")),
            // SAFETY: the caller passes as many pointers.
            count => unsafe { slice::from_raw_parts(others, count) },
        };
        // SAFETY: each of them is an open scene.
        let others = others.iter().map(|other| Ok(unsafe { opened(*other) }?.scene()));
        let others = others.collect::<Result<Vec<_>, Failure>>()?;
        let mut changed = scene.scene().clone();
        let reports = apply_steps(&mut changed, &steps, &others, None)?;
        Ok(scene.edited(changed, &reports).into_raw())
    })
}

fn read_steps(text: &CStr) -> Result<Vec<EditStep>, Failure> {
    let text = text.to_str().map_err(|_| Failure::argument("steps is not UTF-8"))?;
    EditStep::list_from_json(text).map_err(|error| Failure::argument(&error.to_string()))
}

/// The number of reports of `mocap_edit` about a scene: one for each step and each animation that it changed.
/// `mocap_edit_report_text` returns them.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_edit_report_count(scene: *const Scene) -> usize {
    // SAFETY: the caller passes an open scene.
    guard(0, || Ok(unsafe { opened(scene) }?.edit_reports.len()))
}

/// A report, counted from 0: the changes of a step, with units, such as "mirror: 17 pairs of joints exchanged". NULL
/// beyond the last. The text lives as long as the scene.
///
/// # Safety
/// `scene` is an open scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_edit_report_text(scene: *const Scene, report: usize) -> *const c_char {
    guard(ptr::null(), || {
        // SAFETY: the caller passes an open scene.
        let reports = &unsafe { opened(scene) }?.edit_reports;
        let text = reports.get(report);
        let text = text.ok_or_else(|| Failure::absent("report", report as u64, reports.len() as u64))?;
        Ok(text.as_ptr())
    })
}
