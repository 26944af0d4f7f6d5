//! Shows on a terminal that a command is working: its name and its elapsed time.

use std::io::{self, IsTerminal};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::args::{ArgumentSources, Command};
use crate::invocation;
use crate::report::{self, PATIENCE};

/// The interval of checks for a progress bar.
const LOOK: Duration = Duration::from_millis(50);

/// Shows that a command is working, until this value is dropped. The progress bar of a command on many files is shown
/// instead.
pub(crate) struct WaitIndicator {
    is_over: Arc<Mutex<bool>>,
}

impl WaitIndicator {
    /// Starts the clock of a command. Commands that run until Ctrl-C print their own messages.
    pub(crate) fn start(command: &Command, given: &ArgumentSources) -> Option<Self> {
        let is_wanted = command.ends_by_itself() && !report::is_quiet() && !given.has("progress");
        if !is_wanted || !io::stderr().is_terminal() {
            return None;
        }
        let is_over = Arc::new(Mutex::new(false));
        let of_thread = Arc::clone(&is_over);
        let mut words = invocation::words()
            .into_iter()
            .skip(1)
            .filter_map(|word| word.into_string().ok());
        let name = words.find(|word| !word.starts_with('-'));
        let wait = move || wait(&of_thread, name.as_deref().unwrap_or_default());
        // If no thread is available, the user does not see the progress.
        thread::Builder::new().spawn(wait).ok()?;
        Some(Self { is_over })
    }
}

impl Drop for WaitIndicator {
    fn drop(&mut self) {
        *self.is_over.lock().unwrap_or_else(PoisonError::into_inner) = true;
        report::set_bar(None);
    }
}

fn wait(is_over: &Mutex<bool>, name: &str) {
    let start = Instant::now();
    let mut free_since = start;
    loop {
        thread::sleep(LOOK);
        // The lock is held until the bar exists, so that no bar appears after the command has ended.
        let is_over = is_over.lock().unwrap_or_else(PoisonError::into_inner);
        if *is_over {
            return;
        }
        if report::has_bar() {
            free_since = Instant::now();
        } else if free_since.elapsed() >= PATIENCE {
            let bar = ProgressBar::new_spinner()
                .with_style(
                    ProgressStyle::with_template("{spinner} {msg} {elapsed}")
                        .unwrap_or_else(|_| ProgressStyle::default_spinner()),
                )
                .with_message(name.to_owned())
                .with_elapsed(start.elapsed());
            report::set_bar(Some(bar.clone()));
            bar.enable_steady_tick(Duration::from_millis(200));
        }
    }
}
