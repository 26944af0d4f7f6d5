//! Whole jobs.

use mocap::job::Job;
use pyo3::prelude::*;

use crate::errors::{invalid, to_python};

/// Runs a job given as JSON. Returns the report as JSON.
#[pyfunction]
pub(crate) fn run(py: Python<'_>, job: &str) -> PyResult<String> {
    let job = Job::from_json(job).map_err(|error| invalid(error.diagnostic().message.clone()))?;
    let report = py.detach(|| job.run()).map_err(|error| to_python(py, &error))?;
    serde_json::to_string(&report).map_err(|error| invalid(error.to_string()))
}
