//! A guess about a value that a file does not state.

use serde::Serialize;

use super::Confidence;

/// A guess and its reason.
///
/// `figure::Survey` has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Guess<T> {
    /// The guessed value.
    pub value: T,
    /// The confidence.
    pub confidence: Confidence,
    /// The reason, as one phrase.
    pub reason: String,
}

impl<T> Guess<T> {
    /// Another value with the same confidence and reason.
    #[doc(hidden)]
    pub fn map<U>(self, value: U) -> Guess<U> {
        Guess {
            value,
            confidence: self.confidence,
            reason: self.reason,
        }
    }
}
