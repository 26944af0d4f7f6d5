//! Converts errors to Python exceptions.

use std::error::Error as _;
use std::io::{self, ErrorKind};

use mocap::{Code, Error};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::de::DeserializeOwned;

/// The Python exception from which an error also derives, by the names of `mocap._errors.error`.
fn kind(error: &Error) -> &'static str {
    let source = error.source().and_then(|source| source.downcast_ref::<io::Error>());
    match (error.code(), source.map(io::Error::kind)) {
        (_, Some(ErrorKind::NotFound)) => "missing",
        (_, Some(ErrorKind::IsADirectory)) => "folder",
        (_, Some(ErrorKind::PermissionDenied)) => "permission",
        (_, Some(ErrorKind::OutOfMemory)) | (Code::LimitExceeded, _) => "limit",
        (_, Some(_)) => "file",
        (_, None) => "",
    }
}

/// A `mocap.OptionError`: an argument is invalid.
pub(crate) fn invalid(message: impl Into<String>) -> PyErr {
    let message = message.into();
    let make = |py: Python<'_>| -> PyResult<PyErr> {
        let made = py.import("mocap._errors")?.getattr("OptionError")?.call1((message,))?;
        Ok(PyErr::from_value(made))
    };
    Python::attach(make).unwrap_or_else(|failure| failure)
}

/// Parses the JSON that Python made of its arguments. An error begins with `of`.
pub(crate) fn from_json<T: DeserializeOwned>(json: &str, of: &str) -> PyResult<T> {
    serde_json::from_str(json).map_err(|error| {
        // Remove the position in the JSON, because a Python user does not see the JSON.
        let message = error.to_string();
        let what = message.rsplit_once(" at line ").map_or(&message[..], |(what, _)| what);
        invalid(format!("{of}{what}"))
    })
}

/// A `mocap.MocapError` with all fields of the diagnostic.
pub(crate) fn to_python(py: Python<'_>, error: &Error) -> PyErr {
    let make = || -> PyResult<PyErr> {
        let diagnostic = error.diagnostic();
        let location = error.location();
        let details = PyDict::new(py);
        details.set_item("code", error.code().as_str())?;
        details.set_item("path", error.path().map(|path| path.display().to_string()))?;
        details.set_item("line", location.map(|location| location.line))?;
        details.set_item("column", location.map(|location| location.column))?;
        details.set_item("joint", error.joint())?;
        details.set_item("expected", diagnostic.expected.as_deref())?;
        details.set_item("found", diagnostic.found.as_deref())?;
        details.set_item("help", diagnostic.help.as_deref())?;
        let make = py.import("mocap._errors")?.getattr("error")?;
        Ok(PyErr::from_value(make.call1((
            kind(error),
            error.to_string(),
            details,
        ))?))
    };
    make().unwrap_or_else(|failure| failure)
}
