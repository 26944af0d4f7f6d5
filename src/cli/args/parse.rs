//! Reads the command line.

use std::ffi::{OsStr, OsString};
use std::io::{self, Write};
use std::path::Path;

use clap::error::{ContextKind, ErrorKind};
use clap::parser::ValueSource;
use clap::{Args as _, CommandFactory, FromArgMatches};

use super::suggest::suggest;
use super::{Args, ArgumentSources, BatchArgs, ForceArgs, help};
use crate::batch::hash::sha256;
use crate::{invocation, report};

/// Prints the help, or an error of the arguments, and ends the program. Control characters of an argument reach no
/// terminal. If the help cannot be written, for example to a full disk, the exit code is an error.
fn tell(error: &clap::Error) -> ! {
    let is_plain = invocation::words()
        .iter()
        .all(|argument| !argument.to_string_lossy().chars().any(char::is_control));
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
    /// The arguments, and their sources.
    pub(crate) fn parse_with_given() -> (Self, ArgumentSources) {
        let parse = |command| Self::parse_from(&command, invocation::words());
        // Arranging the help takes longer than converting a small file, so it only happens if help is requested.
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
                    "--print-job: only convert, edit, clean, retarget, robot, survey and graph have a job; omit --print-job",
                );
                std::process::exit(2);
            }
            if let Some(error) = own_error(&error) {
                report::error(error);
                std::process::exit(2);
            }
            suggest(&mut error, &Self::command());
            tell(&error)
        })
    }

    /// Parses a list of words. The first word is the name of the program.
    pub(crate) fn parse_from(
        command: &clap::Command,
        words: impl IntoIterator<Item = OsString>,
    ) -> Result<(Self, ArgumentSources), clap::Error> {
        let matches = command.clone().try_get_matches_from(words)?;
        let args = Self::from_arg_matches(&matches)?;
        let mut given = ArgumentSources::default();
        let mut options = Vec::new();
        if let Some((name, matches)) = matches.subcommand()
            && let Some(subcommand) = command.find_subcommand(name)
        {
            // A subcommand, if present, has the options.
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

/// The error about a value that the library has parsed. clap quotes its code and its help within a sentence.
pub(crate) fn own_error(error: &clap::Error) -> Option<&mocap::Error> {
    std::error::Error::source(error)?.downcast_ref()
}

/// Whether the arguments ask for the job of a command without jobs.
fn asks_for_job(error: &clap::Error) -> bool {
    let unknown = error.get(ContextKind::InvalidArg);
    error.kind() == ErrorKind::UnknownArgument
        && unknown.is_some_and(|argument| argument.to_string().starts_with("--print-job"))
}

/// A value as text. If the output depends on the contents of the file that the value names, the text is the SHA-256 of
/// the file.
fn text(id: &str, value: &OsStr) -> String {
    let is_file = ["map", "skeleton"].contains(&id);
    let hash = is_file.then(|| sha256(Path::new(value)).ok()).flatten();
    hash.map_or_else(|| value.to_string_lossy().into_owned(), |hash| format!("sha256:{hash}"))
}
