//! In a slow command of an unoptimised build, prints a note about optimised builds.

use std::io::{self, IsTerminal};
use std::thread;
use std::time::Duration;

use crate::args::Command;
use crate::report;

/// A command that still runs after this time is slow.
const WAIT: Duration = Duration::from_secs(5);

/// Starts the clock of a command, except in an optimised build.
pub(crate) fn start(command: &Command) {
    let Some(note) = note(
        cfg!(debug_assertions),
        command.ends_by_itself(),
        io::stderr().is_terminal(),
    ) else {
        return;
    };
    // The thread ends with the program. If no thread is available, the user only misses a hint.
    let _ = thread::Builder::new().spawn(move || {
        thread::sleep(WAIT);
        report::say(note);
    });
}

/// The note of a slow command, only for a terminal: programs that read standard error get the same text from every
/// build.
pub fn note(is_unoptimised: bool, ends_by_itself: bool, is_terminal: bool) -> Option<&'static str> {
    (is_unoptimised && ends_by_itself && is_terminal)
        .then_some("note: this build is not optimised; `cargo run --release` runs an optimised one")
}
