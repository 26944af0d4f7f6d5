//! The command line of `mocap`, which uses only the library's public interface. This is a library, so that tests can
//! call its parts. `main.rs` is the program.
//!
//! Data goes to standard output, messages go to standard error. `--help` explains the exit codes (`args::EXIT_CODES`).

#![warn(clippy::unwrap_used)]

mod agent;
mod args;
mod batch;
mod build_info;
mod build_note;
mod commands;
#[doc(hidden)]
pub mod internals;
mod invocation;
#[cfg(feature = "schema")]
mod json_schema;
mod kinds;
mod printed;
#[doc(hidden)]
mod report;
mod streams;
mod waiting;

use std::io;
use std::path::PathBuf;
use std::process::ExitCode;
#[cfg(unix)]
use std::sync::Arc;

use mocap::Code;

use crate::args::{Args, Command};
pub use crate::invocation::Invocation;
use crate::waiting::WaitIndicator;

/// The reason why a command stopped.
pub enum Failure {
    /// A file could not be read or written.
    File(mocap::Error),
    /// Standard output could not be written.
    Output(io::Error),
    /// The arguments are not valid.
    Usage(String),
    /// A folder of outputs or its manifest could not be written.
    Folder(PathBuf, io::Error),
    /// The error has already been printed.
    Told,
    /// Some of many files failed, which has already been printed.
    Some,
}

impl Failure {
    /// The error as text, for one of many files.
    pub fn into_words(self) -> String {
        match self {
            Self::File(error) => error.to_string(),
            Self::Usage(message) => message,
            Self::Output(error) => error.to_string(),
            Self::Folder(folder, error) => format!("{}: {error}", folder.display()),
            Self::Told | Self::Some => {
                "the output could not be written; the printed messages state the reason".to_owned()
            }
        }
    }
}

impl From<mocap::Error> for Failure {
    fn from(error: mocap::Error) -> Self {
        Self::File(error)
    }
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Output(error)
    }
}

/// Makes a write beyond the system's file size limit (`ulimit -f`) fail like a write to a full disk. By default, such a
/// write causes a signal that ends the program. A handler prevents this action of the signal. The flag that the handler
/// sets is not used.
#[cfg(unix)]
fn take_no_signal_for_a_large_file() {
    // Without the handler, only the message is lost.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
}

#[cfg(not(unix))]
fn take_no_signal_for_a_large_file() {}

/// Runs the command of this process's arguments.
pub fn run() -> ExitCode {
    ExitCode::from(run_command())
}

/// Runs a command line inside a process with a different command line, once. Returns the exit code. Help and invalid
/// arguments end the process.
pub fn run_with(invocation: Invocation) -> u8 {
    invocation::set(invocation);
    run_command()
}

fn run_command() -> u8 {
    take_no_signal_for_a_large_file();
    mocap::spell_options(|key| match key {
        // The library option `joints` is `--joint-set` on the command line, because `--joints` already takes joint
        // names.
        "joints" => "--joint-set".to_owned(),
        key => format!("--{key}"),
    });
    let (mut args, given) = Args::parse_with_given();
    match &mut args.command {
        Command::Convert(convert) => convert.settle(),
        Command::Solve(solve) => solve.settle(),
        _ => {}
    }
    if let Command::Mcp(_) = args.command {
        // Agents name options without dashes.
        mocap::spell_options(|key| format!("\"{key}\""));
    }
    report::set_quiet(args.quiet);
    build_note::start(&args.command);
    mocap::job::remember_outputs(report::replaced);
    let waiting = WaitIndicator::start(&args.command, &given);
    let result = match &args.command {
        Command::Convert(args) => commands::convert::run(args, &given),
        Command::Retarget(args) => commands::retarget::run(args, &given),
        Command::Robot(args) => commands::robot::run(args, &given),
        Command::Edit(args) => commands::edit::run(args, &given),
        Command::Clean(args) => commands::clean::run(args, &given),
        Command::Graph(args) => commands::graph::run(args, &given),
        Command::Solve(args) => commands::convert::run(&args.convert, &given),
        Command::Info(args) => commands::info::run(args),
        Command::Fk(args) => commands::fk::run(args, &given),
        Command::Angles(args) => commands::angles::angles(args),
        Command::Gait(args) => commands::angles::gait(args),
        Command::Forces(args) => commands::series::forces(args),
        Command::Analog(args) => commands::series::analog(args),
        #[cfg(feature = "parquet")]
        Command::Pack(args) => commands::pack::run(args, &given),
        #[cfg(not(feature = "parquet"))]
        Command::Pack { .. } => Err(commands::without_parquet()),
        Command::Pose(args) => commands::pose::run(args, &given),
        Command::Chain(args) => commands::chain::run(args),
        Command::Skeleton(args) => commands::skeleton::run(args),
        Command::Check(args) => commands::check::run(args),
        Command::Survey(args) => commands::survey::run(args),
        Command::Index(args) => commands::index::run(args),
        Command::Find(args) => commands::find::run(args),
        Command::Match(args) => commands::matching::run(args, &given),
        Command::Dump(args) => commands::dump::run(args),
        Command::Verify(args) => commands::verify::run(args),
        Command::Score(args) => commands::score::run(args),
        Command::Run(args) => commands::run::run(args, &given),
        Command::Formats(args) => commands::formats::run(args),
        Command::Doctor(args) => commands::doctor::run(args),
        Command::MergeManifest(args) => commands::merge_manifest::run(args),
        Command::Completions(args) => commands::completions::completions(args),
        Command::Man(args) => commands::completions::man(args),
        Command::Mcp(args) => agent::serve(args),
        Command::Record(args) => commands::live::record(args),
        Command::Play(args) => commands::play_robot::play(args),
        Command::Bridge(args) => commands::live::bridge(args),
        Command::View(args) => commands::view::run(args),
        Command::Sheet(args) => commands::sheet::run(args, &given),
        Command::Gif(args) => commands::gif::run(args),
        Command::Plot(args) => commands::plot::run(args),
    };
    drop(waiting);
    report::tell_replaced();
    match result {
        Ok(()) => 0,
        // The reader of the output has closed it.
        Err(Failure::Output(error)) if error.kind() == io::ErrorKind::BrokenPipe => 0,
        Err(Failure::Output(error)) => {
            report::complain(&format!("standard output: {error}"));
            1
        }
        Err(Failure::File(error)) => {
            report::error(&error);
            // The value of an option is invalid, or invalid for this file.
            if error.code() == Code::InvalidValue { 2 } else { 1 }
        }
        Err(Failure::Usage(message)) => {
            report::complain(&message);
            2
        }
        Err(Failure::Folder(folder, error)) => {
            report::error(&mocap::Error::io(&folder, error));
            1
        }
        Err(Failure::Told) => 1,
        Err(Failure::Some) => 3,
    }
}
