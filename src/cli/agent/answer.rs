//! The answer of a tool.

use serde_json::{Value, json};

use crate::Failure;

/// The result of a call of a tool.
pub(super) struct Answer {
    /// The report of the call.
    pub(super) report: Value,
    /// A shorter report, if `report` is too long for an answer.
    pub(super) brief: Option<Value>,
    /// The picture of the answer, as PNG.
    pub(super) picture: Option<Vec<u8>>,
    /// Whether the call failed, or made a result that is worse than its arguments allow.
    pub(super) is_error: bool,
    /// Whether the report is only an error, which does not match the tool's schema.
    pub(super) is_failed: bool,
}

impl Answer {
    pub(super) fn new(report: Value) -> Self {
        Self {
            report,
            brief: None,
            picture: None,
            is_error: false,
            is_failed: false,
        }
    }

    /// Adds the reason why a finished call is an error.
    pub(super) fn add_problem(&mut self, problem: &str) {
        self.is_error = true;
        for report in [Some(&mut self.report), self.brief.as_mut()].into_iter().flatten() {
            report["problem"] = problem.into();
        }
    }

    /// Whether the answer states the reason of its error.
    pub(super) fn is_explained(&self) -> bool {
        ["error", "problem"].iter().any(|key| self.report[key].is_string())
    }

    /// A failed call: the fault, its place, and the remedy.
    pub(super) fn failed(failure: Failure) -> Self {
        let report = match failure {
            Failure::File(error) => {
                // The text has all information: file, line, fault and help.
                let mut found = json!({"error": error.to_string(), "code": error.code().as_str()});
                if let Some(help) = &error.diagnostic().help {
                    found["help"] = help.as_str().into();
                }
                found
            }
            failure => json!({"error": failure.into_words()}),
        };
        Self {
            is_error: true,
            is_failed: true,
            ..Self::new(report)
        }
    }
}
