//! The program `mocap`, for the command of the wheel.

use std::ffi::OsString;

use mocap_cli::Invocation;
use pyo3::prelude::*;

/// Runs a command line, and ends the process with the exit code of the program. `starter` has the words that start the
/// program again.
#[pyfunction]
pub(crate) fn main(py: Python<'_>, words: Vec<OsString>, starter: Vec<OsString>) {
    let status = py.detach(|| mocap_cli::run_with(Invocation { words, starter }));
    // Flush Rust's standard output, because the interpreter does not flush it at exit.
    std::process::exit(status.into())
}
