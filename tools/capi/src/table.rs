//! Tables over time and reports for laboratories.

use std::ffi::{CStr, CString, c_char};
use std::ptr;

use mocap::biomechanics::{BodyGait, JointAngles, TimeSeries};
use mocap::dump::report::Summary;
use mocap::figure::Humanoid;

use crate::border::{Failure, c_text, guard};
use crate::handle::Scene;
use crate::{opened, text};

/// A table of columns over time. Programs only hold pointers to this type.
pub struct Table {
    series: TimeSeries,
    names: Vec<CString>,
    units: Vec<CString>,
}

/// Makes a table of a scene. `what` is the name of the table:
///
/// - "angles": the joint angles of a humanoid in degrees, and the position of its pelvis in metres, with the names and
///   signs of `docs/biomechanics.md`;
/// - "forces": of each force plate of a C3D file, with +Y up: the ground force in newtons, the centre of pressure in
///   metres, the free moment in newton metres;
/// - "analog": the analog channels of a C3D file, in its units.
///
/// Returns NULL if the scene lacks the data; `mocap_error_text` has the reason. Free the table with `mocap_table_free`.
/// You may close the scene after this call.
///
/// # Safety
/// `scene` is an open scene, and `what` is a string that ends with a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_table_new(scene: *const Scene, what: *const c_char) -> *mut Table {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller passes an open scene.
        let scene = unsafe { opened(scene) }?.scene();
        // SAFETY: the caller passes a string with a zero byte at its end.
        let what = unsafe { text(what, "what") }?;
        let series = match what.to_bytes() {
            b"angles" => JointAngles::of(scene)?.into(),
            b"forces" => TimeSeries::ground_forces(scene)?,
            b"analog" => TimeSeries::analog(scene)?,
            _ => return Err(unknown(what, "angles, forces or analog")),
        };
        let texts = |texts: &[String]| texts.iter().map(|text| c_text(text)).collect();
        Ok(Box::into_raw(Box::new(Table {
            names: texts(&series.columns),
            units: texts(&series.units),
            series,
        })))
    })
}

/// Frees a table, its strings and its values. NULL is allowed.
///
/// # Safety
/// `table` comes from `mocap_table_new`, was not freed before, and is used by no other thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_table_free(table: *mut Table) {
    guard((), || {
        if !table.is_null() {
            // SAFETY: the pointer comes from `Box::into_raw`, and the caller gives it up.
            drop(unsafe { Box::from_raw(table) });
        }
        Ok(())
    });
}

/// The number of columns of a table; 0 for NULL. Time is not a column: the time of row `i` is `i` / `mocap_table_rate`
/// seconds.
///
/// # Safety
/// `table` is NULL or comes from `mocap_table_new`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_table_column_count(table: *const Table) -> usize {
    // SAFETY: the caller passes NULL or a table that lives.
    guard(0, || Ok(unsafe { made(table) }?.names.len()))
}

/// The number of rows of a table; 0 for NULL.
///
/// # Safety
/// `table` is NULL or comes from `mocap_table_new`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_table_row_count(table: *const Table) -> usize {
    // SAFETY: the caller passes NULL or a table that lives.
    guard(0, || Ok(unsafe { made(table) }?.series.frames()))
}

/// Rows per second; 0 for NULL.
///
/// # Safety
/// `table` is NULL or comes from `mocap_table_new`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_table_rate(table: *const Table) -> f64 {
    // SAFETY: the caller passes NULL or a table that lives.
    guard(0.0, || Ok(unsafe { made(table) }?.series.frame_rate))
}

/// The name of a column, from 0, such as "knee_angle_r" or "ground_force_1_vy"; NULL beyond the last. The text lives as
/// long as the table.
///
/// # Safety
/// `table` is NULL or comes from `mocap_table_new`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_table_name(table: *const Table, column: usize) -> *const c_char {
    // SAFETY: the caller passes NULL or a table that lives.
    guard(ptr::null(), || at(&unsafe { made(table) }?.names, column))
}

/// The unit of a column, such as "deg", "m" or "N". The unit of an analog channel is the file's, or empty if the file
/// states none. NULL beyond the last. The text lives as long as the table.
///
/// # Safety
/// `table` is NULL or comes from `mocap_table_new`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_table_unit(table: *const Table, column: usize) -> *const c_char {
    // SAFETY: the caller passes NULL or a table that lives.
    guard(ptr::null(), || at(&unsafe { made(table) }?.units, column))
}

/// The values of a table, row by row, with one value for each column; NULL for NULL. The values live as long as the
/// table.
///
/// # Safety
/// `table` is NULL or comes from `mocap_table_new`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_table_values(table: *const Table) -> *const f64 {
    // SAFETY: the caller passes NULL or a table that lives.
    guard(ptr::null(), || Ok(unsafe { made(table) }?.series.values.as_ptr()))
}

/// A report on a scene as JSON, by its name:
///
/// - "solved": the fit of a skeleton to the markers from which it was solved: `markers`, `rms_of_seconds`, `joints`
///   with their lengths and deviations, `swaps`, `filled` and `frames`; `null` for other scenes;
/// - "recorded": the data of a C3D file besides markers: `events`, `channels` and `plates`; `null` if there are none;
/// - "inspect": the output of `mocap info --json`: counts, clips, assumptions, warnings;
/// - "bones": the node of each humanoid bone, with confidence and reason;
/// - "gait": heel strikes, toe offs and strides of a walk, and the means of a gait laboratory; for an animal on four
///   legs, the names of its gaits.
///
/// Free the text with `mocap_text_free`. NULL if there is no such report; `mocap_error_text` has the reason.
///
/// # Safety
/// `scene` is an open scene, and `what` is a string that ends with a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn mocap_report(scene: *const Scene, what: *const c_char) -> *mut c_char {
    guard(ptr::null_mut(), || {
        // SAFETY: the caller passes an open scene.
        let scene = unsafe { opened(scene) }?.scene();
        // SAFETY: the caller passes a string with a zero byte at its end.
        let what = unsafe { text(what, "what") }?;
        let report = match what.to_bytes() {
            b"solved" => serde_json::to_string(&scene.metadata.solved.as_deref()),
            b"recorded" => serde_json::to_string(&scene.metadata.recorded.as_deref()),
            b"inspect" => serde_json::to_string(&Summary::of(scene)),
            b"bones" => serde_json::to_string(&Humanoid::of(scene)),
            b"gait" => serde_json::to_string(&BodyGait::of(scene)?),
            _ => return Err(unknown(what, "inspect, bones, solved, recorded or gait")),
        };
        let report = report.map_err(|error| Failure::argument(&error.to_string()))?;
        Ok(c_text(&report).into_raw())
    })
}

fn unknown(what: &CStr, known: &str) -> Failure {
    Failure::argument(&format!("what must be {known}, got \"{}\"", what.to_string_lossy()))
}

fn at(texts: &[CString], column: usize) -> Result<*const c_char, Failure> {
    let text = texts.get(column);
    let text = text.ok_or_else(|| Failure::absent("column", column as u64, texts.len() as u64))?;
    Ok(text.as_ptr())
}

/// The table at a pointer.
///
/// # Safety
/// `table` is NULL or comes from `mocap_table_new`.
unsafe fn made<'a>(table: *const Table) -> Result<&'a Table, Failure> {
    // SAFETY: the caller passes NULL or a table that lives.
    unsafe { table.as_ref() }.ok_or_else(|| Failure::argument("the table is NULL"))
}
