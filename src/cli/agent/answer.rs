//! What a tool answers.

use serde_json::{Value, json};

use crate::Failure;

/// The result of a call.
pub(super) struct Answer {
    /// What was found or done.
    pub(super) report: Value,
    /// A shorter report, where `report` is too long for an answer.
    pub(super) brief: Option<Value>,
    /// A picture, as PNG.
    pub(super) picture: Option<Vec<u8>>,
    /// Whether the call could not be done, or its result is worse than its arguments allow.
    pub(super) is_error: bool,
    /// Whether there is nothing but an error: the report is not what the tool's schema says.
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

    /// Says why a call that was done is an error nevertheless.
    pub(super) fn add_problem(&mut self, problem: &str) {
        self.is_error = true;
        for report in [Some(&mut self.report), self.brief.as_mut()].into_iter().flatten() {
            report["problem"] = problem.into();
        }
    }

    /// Whether an error says why it is one.
    pub(super) fn is_explained(&self) -> bool {
        ["error", "problem"].iter().any(|key| self.report[key].is_string())
    }

    /// A call that failed: the fault, its place, and the remedy.
    pub(super) fn failed(failure: Failure) -> Self {
        let report = match failure {
            Failure::File(error) => {
                // The text has all that there is: file, line, what is wrong, and the help.
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
