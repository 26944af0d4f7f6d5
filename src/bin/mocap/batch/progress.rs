//! The progress of a run, on standard error: a bar on a terminal, lines of JSON for programs, or nothing.

use std::io::{self, IsTerminal, Write};
use std::time::{Duration, Instant};

use clap::ValueEnum;
use serde::Serialize;

use super::inputs::Input;
use crate::Failure;

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
    /// Input bytes of all files, and of the finished ones.
    pub(crate) bytes: u64,
    pub(crate) bytes_done: u64,
    pub(crate) seconds: f64,
    pub(crate) megabytes_per_second: f64,
    /// Estimated seconds until the end; absent before the first file is finished.
    pub(crate) eta_seconds: Option<f64>,
}

/// Five updates per second are enough to see, and cost little.
const REDRAWN_AFTER: Duration = Duration::from_millis(200);

impl Counts {
    /// A line of so many columns: a bar, and the counts behind it.
    fn bar(&self, columns: usize) -> String {
        let fraction = (self.bytes_done as f64 / self.bytes.max(1) as f64).min(1.0);
        let left = match self.eta_seconds.map(|seconds| seconds.round() as u64) {
            None => String::new(),
            Some(seconds) if seconds < 60 => format!("  {seconds} s left"),
            Some(seconds) if seconds < 3600 => format!("  {} min {:02} s left", seconds / 60, seconds % 60),
            Some(seconds) => format!("  {} h {:02} min left", seconds / 3600, seconds / 60 % 60),
        };
        let counts = format!(
            " {:3.0}%  {}/{} files, {} failed  {:.1} MB/s{left}",
            100.0 * fraction,
            self.done,
            self.files,
            self.failed,
            self.megabytes_per_second
        );
        let width = columns.saturating_sub(counts.len());
        let full = (fraction * width as f64) as usize;
        let line = format!("{}{}{counts}", "█".repeat(full), "░".repeat(width - full));
        line.chars().take(columns).collect()
    }

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

enum Display {
    Bar { last: Option<Instant> },
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
            ProgressArg::Auto if io::stderr().is_terminal() => Display::Bar { last: None },
            ProgressArg::Json => Display::Json { last: start },
            ProgressArg::Auto | ProgressArg::None => Display::None,
        };
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
        match &mut self.display {
            Display::Bar { last } if last.is_none_or(|last| last.elapsed() >= REDRAWN_AFTER) => {
                *last = Some(Instant::now());
                draw(&self.now().bar(columns()));
            }
            Display::Json { last } if last.elapsed() >= Duration::from_secs(1) => {
                *last = Instant::now();
                print_line(&self.now());
            }
            Display::Bar { .. } | Display::Json { .. } | Display::None => {}
        }
    }

    pub(crate) fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Ends the display, and returns the final counts.
    pub(crate) fn finish(self) -> Counts {
        let counts = self.now();
        match &self.display {
            Display::Bar { last: None } => {}
            // Spaces clear the line on every terminal.
            Display::Bar { .. } => draw(&format!("{:1$}\r", "", columns())),
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

/// Columns of the terminal that the bar may take: the last one would begin a new line on some terminals.
fn columns() -> usize {
    /// Where standard error does not say how wide it is.
    const USUAL: usize = 80;
    let size = terminal_size::terminal_size_of(io::stderr());
    size.map_or(USUAL, |(width, _)| usize::from(width.0)).saturating_sub(1)
}

/// Writes from the start of the line.
fn draw(line: &str) {
    let mut stderr = io::stderr().lock();
    // Nothing can be reported if standard error is closed.
    let _ = write!(stderr, "\r{line}").and_then(|()| stderr.flush());
}

fn print_line(counts: &Counts) {
    // Nothing can be reported if standard error is closed.
    if let Ok(line) = serde_json::to_string(counts) {
        let _ = writeln!(io::stderr().lock(), "{line}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_takes_the_columns_that_there_are() {
        let counts = Counts {
            files: 8,
            done: 2,
            failed: 1,
            bytes: 400,
            bytes_done: 100,
            megabytes_per_second: 12.34,
            eta_seconds: Some(75.0),
            ..Counts::default()
        };
        let line = counts.bar(79);
        assert_eq!(line.chars().count(), 79);
        assert!(
            line.ends_with("░  25%  2/8 files, 1 failed  12.3 MB/s  1 min 15 s left"),
            "{line}"
        );
        let full = line.chars().filter(|c| *c == '█').count();
        let all = full + line.chars().filter(|c| *c == '░').count();
        assert_eq!(full, all / 4, "{line}");
        assert_eq!(counts.bar(20).chars().count(), 20);
        assert_eq!(Counts::default().bar(0), "");
    }
}
