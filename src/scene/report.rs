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
        indented_json(self).unwrap_or_default()
    }
}

impl<R: fmt::Display + Serialize> Report for R {}

/// A count with its noun, in the plural unless the count is 1.
#[doc(hidden)]
pub fn counted(count: usize, noun: &str) -> String {
    let ending = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{ending}")
}

/// A value as JSON with a line for each entry, indented by two spaces. Compact JSON is indented here, because a second
/// serializer would double the compiled code of every type that is written.
#[doc(hidden)]
pub fn indented_json(value: &(impl Serialize + ?Sized)) -> serde_json::Result<String> {
    let json = serde_json::to_string(value)?;
    let mut text = String::with_capacity(2 * json.len());
    let (mut depth, mut is_string, mut is_escaped) = (0, false, false);
    let mut characters = json.chars().peekable();
    while let Some(character) = characters.next() {
        if is_string {
            is_string = is_escaped || character != '"';
            is_escaped = !is_escaped && character == '\\';
            text.push(character);
            continue;
        }
        if matches!(character, '}' | ']') {
            depth -= 1;
            start_line(&mut text, depth);
        }
        text.push(character);
        match character {
            '"' => is_string = true,
            ':' => text.push(' '),
            ',' => start_line(&mut text, depth),
            '{' | '[' => match characters.next_if(|next| matches!(next, '}' | ']')) {
                Some(end) => text.push(end),
                None => {
                    depth += 1;
                    start_line(&mut text, depth);
                }
            },
            _ => {}
        }
    }
    Ok(text)
}

fn start_line(text: &mut String, depth: usize) {
    text.push('\n');
    text.extend(std::iter::repeat_n("  ", depth));
}
