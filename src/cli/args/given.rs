//! Which options stand on the command line, and which of them the outputs depend on.

use mocap::job::Length;

use crate::{Failure, report};

/// What the parsed arguments do not tell.
#[derive(Debug, Default)]
pub(crate) struct ArgumentSources {
    /// The options that the outputs depend on as text, the defaults too.
    pub(crate) options: String,
    /// The long names of the options that the user wrote.
    pub(super) names: Vec<String>,
    /// The largest error that the user wrote.
    pub(super) max_error: Option<Length>,
}

/// The error in metres above which a bound is doubted: 5 cm are seen in any motion of a body.
const LARGE_ERROR: f64 = 0.05;

impl ArgumentSources {
    pub(crate) fn has(&self, name: &str) -> bool {
        self.names.iter().any(|given| given == name)
    }

    /// Whether nothing is to be written.
    pub(crate) fn is_dry_run(&self) -> bool {
        self.has("dry-run")
    }

    /// Warns of a largest error that was meant smaller.
    pub(super) fn question_max_error(&self) {
        if let Some(length) = self.max_error.filter(|length| length.to_metres() > LARGE_ERROR) {
            report::caution(&format!(
                "--max-error {length} accepts joints that are {} cm off; usual is 1mm",
                100.0 * length.to_metres()
            ));
        }
    }

    /// Refuses the options of these names, which would do nothing, because of `why`.
    pub(crate) fn refuse(&self, names: &[&str], why: &str) -> Result<(), Failure> {
        match names.iter().find(|name| self.has(name)) {
            Some(name) => Err(Failure::Usage(format!("--{name} would do nothing: {why}"))),
            None => Ok(()),
        }
    }
}
