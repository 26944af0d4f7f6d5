//! Errors as Python's exceptions.

use mocap::Error;
use pyo3::prelude::*;
use pyo3::types::PyDict;

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
        let class = py.import("mocap._errors")?.getattr("MocapError")?;
        Ok(PyErr::from_value(class.call1((error.to_string(), details))?))
    };
    make().unwrap_or_else(|failure| failure)
}
