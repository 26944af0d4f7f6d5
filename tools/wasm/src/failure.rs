//! The error of a call, as JSON.

use mocap::{Code, Diagnostic, Error};
use serde::Serialize;

/// Boxed, so that results are small.
pub(crate) struct Failure(Box<Error>);

impl Failure {
    /// An invalid argument of the caller.
    pub(crate) fn argument(message: impl Into<String>) -> Self {
        Error::from(Diagnostic::new(Code::UnknownOption, message)).into()
    }

    pub(crate) fn to_json(&self) -> Vec<u8> {
        #[derive(Serialize)]
        struct Answer<'a> {
            error: Finding<'a>,
            warnings: &'a [Diagnostic],
        }
        let answer = Answer {
            error: Finding::error(&self.0),
            warnings: self.0.warnings(),
        };
        serde_json::to_vec(&answer).unwrap_or_default()
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self(Box::new(error))
    }
}

/// A diagnostic with its file.
#[derive(Serialize)]
pub(crate) struct Finding<'a> {
    severity: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<String>,
    #[serde(flatten)]
    diagnostic: &'a Diagnostic,
}

impl<'a> Finding<'a> {
    pub(crate) fn error(error: &'a Error) -> Self {
        Self {
            severity: "error",
            file: error.path().map(|path| path.display().to_string()),
            diagnostic: error.diagnostic(),
        }
    }

    pub(crate) fn warning(diagnostic: &'a Diagnostic) -> Self {
        Self {
            severity: "warning",
            file: None,
            diagnostic,
        }
    }
}
