//! The program `mocap`, for the command of the wheel.

use std::ffi::OsString;

use mocap_cli::Invocation;
use pyo3::prelude::*;

/// Does what a command line says, and ends the process with the exit code of the program. `starter` has the words that
/// start the program once more.
#[pyfunction]
pub(crate) fn main(py: Python<'_>, words: Vec<OsString>, starter: Vec<OsString>) {
    let status = py.detach(|| mocap_cli::run_with(Invocation { words, starter }));
    // Writes what the standard output of Rust still holds, which the end of the interpreter does not.
    std::process::exit(status.into())
}
