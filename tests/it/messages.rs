//! The messages of the library, which users read in a terminal, in Python, in a browser and in other programs.

use std::fs;

use super::source::rust_files;

#[test]
fn messages_of_the_library_name_no_flag_of_the_command_line() {
    // The program is an interface, so its messages may name flags.
    let files = rust_files(|folder| !folder.ends_with("tests") && !folder.ends_with("cli"));
    assert!(files.len() > 500, "the source is somewhere else");
    let mut found = Vec::new();
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        let code = text
            .lines()
            .enumerate()
            .filter(|(_, line)| !line.trim_start().starts_with("//"));
        let flags = code.filter(|(_, line)| has_flag(line));
        found.extend(flags.map(|(line, text)| format!("{}:{}: {}", file.display(), line + 1, text.trim())));
    }
    assert!(
        found.is_empty(),
        "a message has an option in braces, with its key in a job, as {{max-error}}:\n{}",
        found.join("\n")
    );
}

/// Whether a line has a flag: two dashes before a small letter and after no sign or letter. `--flag` is one, `a--b` is
/// not.
fn has_flag(line: &str) -> bool {
    let bytes = line.as_bytes();
    (0..bytes.len().saturating_sub(2)).any(|at| {
        let before = at.checked_sub(1).map_or(b' ', |before| bytes[before]);
        bytes[at..].starts_with(b"--")
            && bytes[at + 2].is_ascii_lowercase()
            && (before.is_ascii_whitespace() || b"\"`(".contains(&before))
    })
}

#[test]
fn flags_are_recognised() {
    for line in ["\"--force\"", "see `--force`", "a --to b"] {
        assert!(has_flag(line), "{line}");
    }
    for line in ["a--b", "-- a", "x -- y", "---", "--A"] {
        assert!(!has_flag(line), "{line}");
    }
}
