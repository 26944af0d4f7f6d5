//! How far a run is: a bar on a terminal, lines of JSON for programs, or nothing. Always on standard error.

use std::io::{self, IsTerminal, Write};
use std::time::{Duration, Instant};

use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;

use super::inputs::Input;
use crate::Failure;

/// How to tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProgressArg {
    /// A bar where standard error is a terminal, else nothing
    Auto,
    /// A line of JSON a second, and one at the end
    Json,
    /// Nothing
    None,
}

/// What is known at a moment.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct Counts {
    /// Files of the run.
    pub(crate) files: usize,
    /// Files that are done: converted, skipped or failed.
    pub(crate) done: usize,
    pub(crate) skipped: usize,
    pub(crate) failed: usize,
    /// Input bytes of all files, and of those that are done.
    pub(crate) bytes: u64,
    pub(crate) bytes_done: u64,
    pub(crate) seconds: f64,
    pub(crate) megabytes_per_second: f64,
    /// Seconds until the end if it goes on like this; absent before the first file is done.
    pub(crate) eta_seconds: Option<f64>,
}

impl Counts {
    /// How the run ended: well, with some files failed, or with all of them.
    pub(crate) fn verdict(&self) -> Result<(), Failure> {
        match self.failed {
            0 => Ok(()),
            failed if failed == self.files => Err(Failure::Told),
            _ => Err(Failure::Some),
        }
    }
}

/// How one file ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    Done,
    Skipped,
    Failed,
}

pub(crate) struct Progress {
    counts: Counts,
    start: Instant,
    display: Display,
}

enum Display {
    Bar(ProgressBar),
    Json { last: Instant },
    None,
}

impl Progress {
    pub(crate) fn new(arg: ProgressArg, inputs: &[Input]) -> Self {
        let start = Instant::now();
        let counts = Counts {
            files: inputs.len(),
            bytes: inputs.iter().map(|input| input.bytes).sum(),
            ..Counts::default()
        };
        let display = match arg {
            ProgressArg::Auto if io::stderr().is_terminal() => Display::Bar(bar(counts.bytes)),
            ProgressArg::Json => Display::Json { last: start },
            ProgressArg::Auto | ProgressArg::None => Display::None,
        };
        Self { counts, start, display }
    }

    /// Counts a file that has ended.
    pub(crate) fn add(&mut self, input: &Input, outcome: Outcome) {
        self.counts.done += 1;
        self.counts.bytes_done += input.bytes;
        match outcome {
            Outcome::Done => {}
            Outcome::Skipped => self.counts.skipped += 1,
            Outcome::Failed => self.counts.failed += 1,
        }
        match &mut self.display {
            Display::Bar(bar) => {
                let Counts {
                    files, done, failed, ..
                } = self.counts;
                bar.set_message(format!("{done}/{files} files, {failed} failed"));
                bar.set_position(self.counts.bytes_done);
            }
            Display::Json { last } if last.elapsed() >= Duration::from_secs(1) => {
                *last = Instant::now();
                print_line(&self.now());
            }
            Display::Json { .. } | Display::None => {}
        }
    }

    /// Ends the display, and gives the last counts.
    pub(crate) fn finish(self) -> Counts {
        let counts = self.now();
        match &self.display {
            Display::Bar(bar) => bar.finish_and_clear(),
            Display::Json { .. } => print_line(&counts),
            Display::None => {}
        }
        counts
    }

    fn now(&self) -> Counts {
        let seconds = self.start.elapsed().as_secs_f64();
        let bytes_per_second = self.counts.bytes_done as f64 / seconds;
        let bytes_left = self.counts.bytes - self.counts.bytes_done;
        Counts {
            seconds,
            megabytes_per_second: bytes_per_second / 1e6,
            eta_seconds: (bytes_per_second > 0.0).then(|| bytes_left as f64 / bytes_per_second),
            ..self.counts
        }
    }
}

fn bar(bytes: u64) -> ProgressBar {
    let template = "{wide_bar} {percent}%  {msg}  {decimal_bytes_per_sec}  {eta} left";
    let style = ProgressStyle::with_template(template).expect("the template is a constant");
    // Five times a second is enough for an eye, and costs nothing beside the files.
    let bar = ProgressBar::with_draw_target(Some(bytes), ProgressDrawTarget::stderr_with_hz(5));
    bar.with_style(style)
}

fn print_line(counts: &Counts) {
    // Nobody is left to tell if standard error is closed.
    if let Ok(line) = serde_json::to_string(counts) {
        let _ = writeln!(io::stderr().lock(), "{line}");
    }
}
