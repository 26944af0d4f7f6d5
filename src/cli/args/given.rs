//! Which options stand on the command line, and which of them the outputs depend on.

use std::ffi::{OsStr, OsString};
use std::io::{self, Write};
use std::path::Path;

use clap::error::{ContextKind, ErrorKind};
use clap::parser::ValueSource;
use clap::{Args as _, CommandFactory, FromArgMatches};

use mocap::job::Length;

use super::suggest::suggest;
use super::{Args, BatchArgs, ForceArgs, help};
use crate::batch::hash::sha256;
use crate::{Failure, report};

/// What the parsed arguments do not tell.
#[derive(Debug, Default)]
pub(crate) struct Given {
    /// The options that the outputs depend on as text, the defaults too.
    pub(crate) options: String,
    /// The long names of the options that the user wrote.
    names: Vec<String>,
    /// The largest error that the user wrote.
    max_error: Option<Length>,
}

/// A larger error in metres is seen in any motion of a body.
const LARGE_ERROR: f64 = 0.05;

impl Given {
    pub(crate) fn has(&self, name: &str) -> bool {
        self.names.iter().any(|given| given == name)
    }

    /// Whether nothing is to be written.
    pub(crate) fn is_dry_run(&self) -> bool {
        self.has("dry-run")
    }

    /// Warns of a largest error that was meant smaller.
    fn question_max_error(&self) {
        if let Some(length) = self.max_error.filter(|length| length.to_metres() > LARGE_ERROR) {
            report::caution(&format!(
                "--max-error {length} accepts joints that are {} cm off; usual is 1mm",
                100.0 * length.to_metres()
            ));
        }
    }

    /// Refuses the options of these names, which would do nothing, because of `why`.
    pub(crate) fn refuse(&self, names: &[&str], why: &str) -> Result<(), Failure> {
        match names.iter().find(|name| self.has(name)) {
            Some(name) => Err(Failure::Usage(format!("--{name} would do nothing: {why}"))),
            None => Ok(()),
        }
    }
}

/// Prints help, or what is wrong with the arguments, and ends the program. Control characters of an argument reach no
/// terminal. Where help cannot be written, such as to a full disk, the exit code says so.
fn tell(error: &clap::Error) -> ! {
    let is_plain = std::env::args_os().all(|argument| !argument.to_string_lossy().chars().any(char::is_control));
    let printed = match is_plain {
        true => error.print().and_then(|()| io::stdout().flush()),
        false => io::stderr().write_all(report::visible_lines(&error.render().to_string()).as_bytes()),
    };
    let status = match printed {
        Err(failed) if failed.kind() != io::ErrorKind::BrokenPipe => 1,
        _ => error.exit_code(),
    };
    std::process::exit(status)
}

impl Args {
    /// The arguments, and what they do not tell.
    pub(crate) fn parse_with_given() -> (Self, Given) {
        let parse = |command| Self::parse_from(&command, std::env::args_os());
        // To arrange the helps takes longer than to convert a small file, so only those who ask for help wait for it.
        let parsed = parse(Self::command()).or_else(|error| match error.kind() {
            ErrorKind::DisplayHelp | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
                parse(help::arranged(Self::command()))
            }
            _ => Err(error),
        });
        if let Ok((_, given)) = &parsed {
            given.question_max_error();
        }
        parsed.unwrap_or_else(|mut error| {
            if asks_for_job(&error) {
                report::complain(
                    "--print-job: only convert, edit, clean, retarget, robot, survey and graph are jobs; leave it out",
                );
                std::process::exit(2);
            }
            suggest(&mut error, &Self::command());
            tell(&error)
        })
    }

    /// The arguments of a list of words, of which the first is the name of the program.
    pub(crate) fn parse_from(
        command: &clap::Command,
        words: impl IntoIterator<Item = OsString>,
    ) -> Result<(Self, Given), clap::Error> {
        let matches = command.clone().try_get_matches_from(words)?;
        let args = Self::from_arg_matches(&matches)?;
        let mut given = Given::default();
        let mut options = Vec::new();
        if let Some((name, matches)) = matches.subcommand()
            && let Some(subcommand) = command.find_subcommand(name)
        {
            // The command of a command, where there is one, has the options.
            let below = matches.subcommand();
            let below = below.and_then(|(name, matches)| Some((matches, subcommand.find_subcommand(name)?)));
            let (matches, subcommand) = below.unwrap_or((matches, subcommand));
            let batch = ForceArgs::augment_args(BatchArgs::augment_args(clap::Command::default()));
            let is_of_batch = |arg: &clap::Arg| batch.get_arguments().any(|other| other.get_id() == arg.get_id());
            for arg in subcommand.get_arguments().filter(|arg| !arg.is_positional()) {
                let id = arg.get_id().as_str();
                if matches.try_contains_id(id).is_ok()
                    && matches.value_source(id) == Some(ValueSource::CommandLine)
                    && let Some(name) = arg.get_long()
                {
                    given.names.push(name.to_owned());
                    if name == "max-error" {
                        given.max_error = matches.try_get_one(id).ok().flatten().copied();
                    }
                }
                if !is_of_batch(arg)
                    && let Ok(Some(values)) = matches.try_get_raw(id)
                {
                    let values: Vec<_> = values.map(|value| text(id, value)).collect();
                    options.push(format!("{id}={}", values.join(",")));
                }
            }
        }
        given.options = options.join(" ");
        Ok((args, given))
    }
}

/// Whether the arguments ask a command for its job that has none.
fn asks_for_job(error: &clap::Error) -> bool {
    let unknown = error.get(ContextKind::InvalidArg);
    error.kind() == ErrorKind::UnknownArgument
        && unknown.is_some_and(|argument| argument.to_string().starts_with("--print-job"))
}

/// A value as text. A file on whose contents an output depends is its SHA-256.
fn text(id: &str, value: &OsStr) -> String {
    let is_file = ["map", "skeleton"].contains(&id);
    let hash = is_file.then(|| sha256(Path::new(value)).ok()).flatten();
    hash.map_or_else(|| value.to_string_lossy().into_owned(), |hash| format!("sha256:{hash}"))
}
