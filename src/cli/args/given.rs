//! The options on the command line, and the options on which the outputs depend.

use mocap::job::Length;

use crate::{Failure, report};

/// Information that the parsed arguments lack.
#[derive(Debug, Default)]
pub(crate) struct ArgumentSources {
    /// The options on which the outputs depend, as text, including defaults.
    pub(crate) options: String,
    /// The long names of the options that the user wrote.
    pub(super) names: Vec<String>,
    /// The largest allowed error, if the user wrote one.
    pub(super) max_error: Option<Length>,
}

/// The error in metres above which the command warns. An error of 5 cm is visible in any motion of a body.
const LARGE_ERROR: f64 = 0.05;

impl ArgumentSources {
    pub(crate) fn has(&self, name: &str) -> bool {
        self.names.iter().any(|given| given == name)
    }

    /// Whether the command must not write files.
    pub(crate) fn is_dry_run(&self) -> bool {
        self.has("dry-run")
    }

    /// Warns of a largest error that is probably a mistake in the unit.
    pub(super) fn question_max_error(&self) {
        if let Some(length) = self.max_error.filter(|length| length.to_metres() > LARGE_ERROR) {
            report::caution(&format!(
                "--max-error {length} allows an error of {} cm for each joint; a usual value is 1mm",
                100.0 * length.to_metres()
            ));
        }
    }

    /// Refuses the options of these names: they have no effect, because of `why`.
    pub(crate) fn refuse(&self, names: &[&str], why: &str) -> Result<(), Failure> {
        match names.iter().find(|name| self.has(name)) {
            Some(name) => Err(Failure::Usage(format!("--{name} would do nothing: {why}"))),
            None => Ok(()),
        }
    }
}
