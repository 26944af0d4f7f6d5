//! The common interface of all reports.

use std::fmt;

use serde::Serialize;

/// A report of actions or measurements: text for people by `Display`, data for programs by `Serialize`. Every report of
/// the library implements this trait.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::report::Report;
/// use mocap::verify::report::Verification;
///
/// fn print(report: &impl Report, is_json: bool) -> String {
///     match is_json {
///         true => report.to_json(),
///         false => report.to_string(),
///     }
/// }
///
/// let report = Verification::default();
/// assert!(print(&report, true).contains("\"max_error\": 0.0"));
/// assert!(print(&report, false).contains("0.0000 mm at most"));
/// ```
pub trait Report: fmt::Display + Serialize {
    /// The report as indented JSON.
    fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default()
    }
}

impl<R: fmt::Display + Serialize> Report for R {}

/// A count with its noun, in the plural unless the count is 1.
#[doc(hidden)]
pub fn counted(count: usize, noun: &str) -> String {
    let ending = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{ending}")
}
