//! The progress of a run, on standard error: a bar on a terminal, lines of JSON for programs, or nothing.

use std::io::{self, IsTerminal, Write};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;

use super::inputs::Input;
use crate::report::PATIENCE;
use crate::{Failure, report};

/// How to show progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProgressArg {
    /// A bar if standard error is a terminal, otherwise nothing
    Auto,
    /// One line of JSON per second, and one at the end
    Json,
    /// Nothing
    None,
}

/// The progress at one time.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct Counts {
    /// The number of files.
    pub(crate) files: usize,
    /// The number of files converted, skipped or failed.
    pub(crate) done: usize,
    pub(crate) skipped: usize,
    pub(crate) failed: usize,
    /// Input bytes of all files, and of finished files.
    pub(crate) bytes: u64,
    pub(crate) bytes_done: u64,
    pub(crate) seconds: f64,
    pub(crate) megabytes_per_second: f64,
    /// Estimated seconds until the end; absent before the first file is finished.
    pub(crate) eta_seconds: Option<f64>,
}

impl Counts {
    /// The outcome of the run, which decides the exit code.
    pub(crate) fn verdict(&self) -> Result<(), Failure> {
        match self.failed {
            0 => Ok(()),
            failed if failed == self.files => Err(Failure::Told),
            _ => Err(Failure::Some),
        }
    }
}

/// The result of one file.
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

/// A further receiver, for the client of a server. It is called with the number of files at the start, and after every
/// file.
static LISTENER: OnceLock<fn(&Counts)> = OnceLock::new();

pub(crate) fn listen(listener: fn(&Counts)) {
    let _ = LISTENER.set(listener);
}

fn tell(counts: &Counts) {
    if let Some(listener) = LISTENER.get() {
        listener(counts);
    }
}

enum Display {
    /// A bar on the terminal; `None` in the first second.
    Bar(Option<ProgressBar>),
    Json {
        last: Instant,
    },
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
            ProgressArg::Auto if io::stderr().is_terminal() && !report::is_quiet() => Display::Bar(None),
            ProgressArg::Json => Display::Json { last: start },
            ProgressArg::Auto | ProgressArg::None => Display::None,
        };
        // The number of files is known before the first is finished.
        tell(&counts);
        Self { counts, start, display }
    }

    /// Counts a finished file.
    pub(crate) fn add(&mut self, input: &Input, outcome: Outcome) {
        self.counts.done += 1;
        self.counts.bytes_done += input.bytes;
        match outcome {
            Outcome::Done => {}
            Outcome::Skipped => self.counts.skipped += 1,
            Outcome::Failed => self.counts.failed += 1,
        }
        tell(&self.counts);
        match &mut self.display {
            Display::Bar(bar) => {
                let Counts {
                    files, done, failed, ..
                } = self.counts;
                if bar.is_none() && self.start.elapsed() < PATIENCE {
                    return;
                }
                let bar = bar.get_or_insert_with(|| new_bar(self.counts.bytes, self.start));
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

    /// Reports a failed file and the reason, up to a limit.
    pub(crate) fn tell_failure(&self, input: &Input, error: &str) {
        /// The most failures that are reported one by one. The manifest has all failures.
        const MOST: usize = 20;
        match self.counts.failed {
            0..=MOST => report::fail(&match error.contains(&*input.path.to_string_lossy()) {
                true => error.to_owned(),
                false => format!("{}: {error}", input.path.display()),
            }),
            failed if failed == MOST + 1 => report::say("more files failed; the manifest lists all of them"),
            _ => {}
        }
    }

    pub(crate) fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Ends the display, and returns the final counts.
    pub(crate) fn finish(self) -> Counts {
        let counts = self.now();
        match &self.display {
            Display::Json { .. } => print_line(&counts),
            Display::Bar(_) | Display::None => {}
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

/// Removes the bar, however the run ended.
impl Drop for Progress {
    fn drop(&mut self) {
        report::set_bar(None);
    }
}

fn new_bar(bytes: u64, start: Instant) -> ProgressBar {
    // A line that is wider than the terminal would leave parts behind when it is cleared.
    const WIDE: u16 = 80;
    let size = terminal_size::terminal_size_of(io::stderr());
    let template = match size.is_some_and(|(terminal_size::Width(width), _)| width < WIDE) {
        true => "{wide_msg}",
        false => "{wide_bar} {percent}%  {msg}  {decimal_bytes_per_sec}  {eta} left",
    };
    let style = ProgressStyle::with_template(template).expect("the template is a constant");
    // Five updates per second look smooth enough, and cost little.
    let bar = ProgressBar::with_draw_target(Some(bytes), ProgressDrawTarget::stderr_with_hz(5));
    let bar = bar.with_style(style).with_elapsed(start.elapsed());
    report::set_bar(Some(bar.clone()));
    // The remaining time must count down during a long file.
    bar.enable_steady_tick(PATIENCE);
    bar
}

fn print_line(counts: &Counts) {
    // Nothing can be reported if standard error is closed.
    if let Ok(line) = serde_json::to_string(counts) {
        let _ = writeln!(io::stderr().lock(), "{line}");
    }
}
