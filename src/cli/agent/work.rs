//! The process of a call: it takes one order from the server, does it, and says what it made.

use std::io::{self, BufRead, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process;
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use mocap::files::{OwnFiles, go_on, stop_writing};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use serde_json::value::{RawValue, to_raw_value};

use super::answer::Answer;
use super::call::Call;
use super::protocol::Era;
use super::root::Root;
use super::schema::Commands;
use super::{reports, tools};
use crate::batch::progress::{self, Counts};
use crate::{Failure, batch, report};

/// What a process is to do. The name and the arguments are those of `tools/call`.
#[derive(Serialize)]
pub(super) struct Order<'a> {
    pub(super) name: &'static str,
    pub(super) arguments: &'a RawValue,
    pub(super) era: Era,
    /// What the session has written.
    pub(super) written: &'a OwnFiles,
    /// The number of the call's report.
    pub(super) number: usize,
}

/// What a process says, each as a line of JSON.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum OutputLine {
    /// So many files of so many are done: none, when their number is known.
    Progress(usize, usize),
    /// A file that the session has written now.
    Wrote(OwnFiles),
    /// The result of the call, and its report.
    Done { result: Box<RawValue>, report: String },
}

/// Says something to the server. Where that has ended, the end of standard input ends this process too: here it may be
/// writing a file.
fn say(said: &OutputLine) {
    let mut output = io::stdout().lock();
    let line = serde_json::to_string(said).unwrap_or_default();
    let _ = writeln!(output, "{line}").and_then(|()| output.flush());
}

/// Ends the process between two files, so that each is whole or absent.
fn end() -> ! {
    stop_writing();
    process::exit(1)
}

/// Does the order of standard input, whose end ends the process.
pub(super) fn serve(root: Root) -> Result<(), Failure> {
    let mut input = io::BufReader::new(io::stdin());
    let mut order = String::new();
    input.read_line(&mut order)?;
    thread::spawn(move || {
        let _ = io::copy(&mut input, &mut io::sink());
        end()
    });
    let order: Value = serde_json::from_str(&order).map_err(io::Error::from)?;
    let took = |name: &str| order[name].clone();
    let written = serde_json::from_value(took("written")).map_err(io::Error::from)?;
    go_on(written, |files| say(&OutputLine::Wrote(files)));
    let era: Era = serde_json::from_value(took("era")).map_err(io::Error::from)?;
    let number: usize = serde_json::from_value(took("number")).map_err(io::Error::from)?;
    let Ok((tool, arguments)) = tools::named(&order) else {
        return Err(Failure::Usage("the order names no tool".to_owned()));
    };
    progress::listen(hear);
    report::keep();
    let mut call = Call {
        root,
        commands: &Commands::default(),
        tool,
        arguments: &arguments,
    };
    let mut answer = match catch_unwind(AssertUnwindSafe(|| call.answer())) {
        Ok(Ok(answer)) => answer,
        // Notices go to standard error.
        Ok(Err(Failure::Told | Failure::Some)) => Answer::failed(Failure::Usage(told())),
        Ok(Err(failure)) => Answer::failed(failure),
        Err(_) => Answer::failed(Failure::Usage(batch::PANICKED.to_owned())),
    };
    if answer.is_error && !answer.is_explained() {
        answer.add_problem(&told());
    }
    let (result, report) = reports::result(number, answer);
    let result = to_raw_value(&era.finish(result, "tools/call")).map_err(io::Error::from)?;
    say(&OutputLine::Done { result, report });
    Ok(())
}

/// What the command has printed as errors.
fn told() -> String {
    /// Errors that are told one by one: more fill the answer of a call.
    const MOST: usize = 3;
    let kept = report::kept();
    let mut words = kept.iter().take(MOST).cloned().collect::<Vec<_>>().join("; ");
    if kept.len() > MOST {
        words += &format!("; and {} more", kept.len() - MOST);
    }
    match words.is_empty() {
        true => "some files failed; their errors are in the report".to_owned(),
        false => words,
    }
}

/// Says how many files are done, some times in a second.
fn hear(counts: &Counts) {
    const PAUSE: Duration = Duration::from_millis(200);
    static LAST: Mutex<Option<Instant>> = Mutex::new(None);
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    if counts.done == 0 || counts.done == counts.files || last.is_none_or(|last| last.elapsed() >= PAUSE) {
        *last = Some(Instant::now());
        say(&OutputLine::Progress(counts.done, counts.files));
    }
}
