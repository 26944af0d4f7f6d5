//! Tests that control characters of a file are escaped in reports.

use std::io::Write;

use mocap::{Diagnostic, visible, visible_json};
use mocap_cli::internals::report::{EscapeWriter, PrintableText, Severity, render, visible_lines};

#[test]
fn a_terminal_gets_no_control_characters() {
    let name = "Hips\u{1b}]0;title\u{7}\u{9b}2J\u{202e}\u{7f}";
    let escaped = "Hips\\u{1b}]0;title\\u{7}\\u{9b}2J\\u{202e}\\u{7f}";
    assert_eq!(visible(name), escaped);
    assert_eq!(visible("a\nb\tc"), "a\\u{a}b\\u{9}c");
    assert_eq!(visible_lines("a\nb\tc\r"), "a\nb\tc\\u{d}");
    assert_eq!(visible("Hüfte 腰"), "Hüfte 腰");
    let json = "Hips\\u001b]0;title\\u0007\\u009b2J\\u202e\\u007f";
    for (shown, expected) in [
        (PrintableText::Words, escaped),
        (PrintableText::Json, json),
        (PrintableText::Data, name),
    ] {
        let mut out = Vec::new();
        let mut lines = EscapeWriter::new(&mut out, shown);
        for byte in format!("{name}\n腰{name}").bytes() {
            lines.write_all(&[byte]).unwrap();
        }
        drop(lines);
        assert_eq!(String::from_utf8(out).unwrap(), format!("{expected}\n腰{expected}"));
    }
}

/// JSON with escaped control characters has the same value as without escapes.
#[test]
fn json_keeps_its_value() {
    let steering: String = ('\u{0}'..='\u{2100}').chain(['\u{feff}', '😀']).collect();
    let value = serde_json::json!({(steering.as_str()): [steering.as_str(), 1.5], "a": {}});
    for text in [value.to_string(), serde_json::to_string_pretty(&value).unwrap()] {
        let shown = visible_json(&text);
        assert_eq!(serde_json::from_str::<serde_json::Value>(&shown).unwrap(), value);
        assert!(shown.lines().all(|line| visible(line) == line));
        assert!(shown.contains("\\u009b") && shown.contains("\\u202e") && shown.contains('😀'));
    }
}

#[test]
fn a_diagnostic_with_control_characters_is_visible_and_marks_its_column() {
    let location = mocap::Location {
        line: 1,
        column: 4,
        length: 2,
        text: "\u{1b}[2Jxy".to_owned(),
        text_column: 1,
    };
    let found = Diagnostic::new(mocap::Code::InvalidNumber, "\u{1b}[31m is not a number")
        .at(location)
        .in_joint("\u{202e}spiH");
    let text = render(Severity::Error, Some("a\u{1b}.bvh".as_ref()), &found);
    assert!(!text.contains(['\u{1b}', '\u{202e}']), "{text}");
}
