//! The process of a call. It takes one order from the server, executes it, and reports the result.

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

/// The order for a process. The name and the arguments come from `tools/call`.
#[derive(Serialize)]
pub(super) struct Order<'a> {
    pub(super) name: &'static str,
    pub(super) arguments: &'a RawValue,
    pub(super) era: Era,
    /// The files that the session has written.
    pub(super) written: &'a OwnFiles,
    /// The number of the call's report.
    pub(super) number: usize,
}

/// The messages of a process, one line of JSON each.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum OutputLine {
    /// The numbers of finished files and of all files. The first message, with 0 finished files, gives the total.
    Progress(usize, usize),
    /// A file that the session has just written.
    Wrote(OwnFiles),
    /// The result of the call, and its report.
    Done { result: Box<RawValue>, report: String },
}

/// Sends a message to the server. Ignores an error of sending, because this process may be writing a file. If the
/// server has ended, the end of standard input ends this process.
fn say(said: &OutputLine) {
    let mut output = io::stdout().lock();
    let line = serde_json::to_string(said).unwrap_or_default();
    let _ = writeln!(output, "{line}").and_then(|()| output.flush());
}

/// Ends the process between two files, so that each file is complete or absent.
fn end() -> ! {
    stop_writing();
    process::exit(1)
}

/// Executes the order from standard input. The end of standard input ends the process.
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
        return Err(Failure::Usage("the request names no tool".to_owned()));
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
        // The command has already reported its errors, and `told` has them.
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

/// The errors that the command has printed.
fn told() -> String {
    /// The largest number of errors in an answer. More errors would fill the answer.
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

/// Reports the number of finished files, a few times per second.
fn hear(counts: &Counts) {
    const PAUSE: Duration = Duration::from_millis(200);
    static LAST: Mutex<Option<Instant>> = Mutex::new(None);
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    if counts.done == 0 || counts.done == counts.files || last.is_none_or(|last| last.elapsed() >= PAUSE) {
        *last = Some(Instant::now());
        say(&OutputLine::Progress(counts.done, counts.files));
    }
}
