//! Control characters of a file.

use std::io::Write;

use mocap::{Diagnostic, visible};
use mocap_cli::internals::report::{Lines, Severity, render, visible_lines};

#[test]
fn a_terminal_gets_no_control_characters() {
    let name = "Hips\u{1b}]0;title\u{7}\u{9b}2J\u{202e}\u{7f}";
    let escaped = "Hips\\u{1b}]0;title\\u{7}\\u{9b}2J\\u{202e}\\u{7f}";
    assert_eq!(visible(name), escaped);
    assert_eq!(visible("a\nb\tc"), "a\\u{a}b\\u{9}c");
    assert_eq!(visible_lines("a\nb\tc\r"), "a\nb\tc\\u{d}");
    assert_eq!(visible("Hüfte 腰"), "Hüfte 腰");
    for is_terminal in [true, false] {
        let mut out = Vec::new();
        let mut lines = Lines {
            out: &mut out,
            is_terminal,
            pending: Vec::new(),
        };
        for byte in format!("{name}\n{name}").bytes() {
            lines.write_all(&[byte]).unwrap();
        }
        drop(lines);
        let expected = if is_terminal { escaped } else { name };
        assert_eq!(String::from_utf8(out).unwrap(), format!("{expected}\n{expected}"));
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
