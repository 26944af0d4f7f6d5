//! The start of the program: the words of its command line, and the words to start it again.

use std::ffi::OsString;
use std::io;
use std::process::Command;
use std::sync::OnceLock;

use crate::Failure;

/// The command line of this program, if it runs inside another program, such as Python, whose own command line is
/// different.
#[derive(Clone, Debug)]
pub struct Invocation {
    /// The command line. The first word is the name of the program.
    pub words: Vec<OsString>,
    /// The words that start the same program in a new process.
    pub starter: Vec<OsString>,
}

static GIVEN: OnceLock<Invocation> = OnceLock::new();

/// Sets the invocation of this process. Only the first call counts.
pub(crate) fn set(invocation: Invocation) {
    GIVEN.get_or_init(|| invocation);
}

/// The words of the command line of this process.
pub(crate) fn words() -> Vec<OsString> {
    GIVEN
        .get()
        .map_or_else(|| std::env::args_os().collect(), |given| given.words.clone())
}

/// The words that start the program again.
pub(crate) fn starter() -> Result<Vec<OsString>, Failure> {
    match GIVEN.get() {
        Some(given) => Ok(given.starter.clone()),
        None => {
            let lost =
                |error: io::Error| format!("cannot find the mocap executable, which is needed to run calls: {error}");
            let program = std::env::current_exe().map_err(|error| Failure::Usage(lost(error)))?;
            Ok(vec![program.into()])
        }
    }
}

/// A command of these words.
pub(crate) fn command(words: &[OsString]) -> Command {
    let (program, arguments) = words
        .split_first()
        .map_or_else(Default::default, |(first, rest)| (first.clone(), rest));
    let mut command = Command::new(program);
    command.args(arguments);
    command
}
