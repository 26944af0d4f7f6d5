//! Prints diagnostics as compilers do, on standard error; with colours on a terminal.

use std::io::{self, IsTerminal, Write};
use std::path::Path;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use mocap::{Diagnostic, Error};
use serde::Serialize;

/// Whether a diagnostic stopped the import.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Severity {
    Error,
    Warning,
}

/// Prints the warnings before an error, and the error.
pub(crate) fn error(error: &Error) {
    warnings(error.path(), error.warnings());
    print(&render(Severity::Error, error.path(), error.diagnostic()));
}

/// Prints warnings about a file.
pub(crate) fn warnings(path: Option<&Path>, warnings: &[Diagnostic]) {
    for warning in warnings {
        print(&render(Severity::Warning, path, warning));
    }
}

/// Prints an error that is not about the contents of a file.
pub(crate) fn complain(message: &str) {
    print(&renderer().render(&[Group::with_title(Level::ERROR.primary_title(message))]));
}

/// Says which animation of several a command uses that needs one: the first that was imported.
pub(crate) fn clip_taken(scene: &mocap::Scene) {
    if let [first, _, ..] = scene.animations.as_slice() {
        let count = scene.animations.len();
        say(&format!("clip: 0 \"{}\" of {count}; --clip takes another", first.name));
    }
}

/// Prints a line of progress or summary.
pub(crate) fn say(message: &str) {
    print(message);
}

fn print(text: &str) {
    // Nothing can be reported if standard error is closed.
    let _ = writeln!(io::stderr().lock(), "{text}");
}

fn renderer() -> Renderer {
    let wants_colour = io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    if wants_colour {
        Renderer::styled()
    } else {
        Renderer::plain()
    }
}

/// `walk.bvh:5:14: error[unknown-channel]: ...`, the line with a marker, then joint, expected, found and help.
pub(crate) fn render(severity: Severity, path: Option<&Path>, diagnostic: &Diagnostic) -> String {
    let (severity, level) = match severity {
        Severity::Error => ("error", Level::ERROR),
        Severity::Warning => ("warning", Level::WARNING),
    };
    let mut place = path.map(|path| format!("{}:", path.display())).unwrap_or_default();
    if let Some(location) = &diagnostic.location {
        place += &format!("{}:{}:", location.line, location.column);
    }
    let name = if place.is_empty() {
        severity.to_owned()
    } else {
        format!("{place} {severity}")
    };
    let message = match diagnostic.count {
        1 => diagnostic.message.clone(),
        count => format!("{} ({count} times)", diagnostic.message),
    };
    let title = level
        .with_name(name)
        .primary_title(message)
        .id(diagnostic.code.as_str());
    let mut group = Group::with_title(title);
    if let Some(location) = &diagnostic.location {
        let bytes_to = |column: usize| {
            let characters = column.saturating_sub(location.text_column);
            location
                .text
                .char_indices()
                .nth(characters)
                .map_or(location.text.len(), |(byte, _)| byte)
        };
        let span = bytes_to(location.column)..bytes_to(location.column + location.length);
        group = group.element(
            Snippet::source(&location.text)
                .line_start(location.line)
                .annotation(AnnotationKind::Primary.span(span)),
        );
    }
    let details = [
        ("at", &diagnostic.pointer),
        ("joint", &diagnostic.joint),
        ("expected", &diagnostic.expected),
        ("found", &diagnostic.found),
        ("help", &diagnostic.help),
    ];
    for (label, text) in details {
        if let Some(text) = text {
            group = group.element(Level::NOTE.with_name(label).message(text));
        }
    }
    renderer().render(&[group])
}
