//! The waiting and running calls of a session. Each call runs in a separate process.
//!
//! The server can end a process at any time, and a crash of the process does not affect the server. A process ends when
//! its call is cancelled, takes too long or runs out of memory. It also ends when its standard input ends, so that it
//! does not outlive the server.

use std::collections::{HashMap, VecDeque};
use std::ffi::OsString;
use std::io::{self, BufRead, BufReader, Write};
use std::process::{self, Child, ChildStdin, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use mocap::files::OwnFiles;
use serde_json::value::RawValue;
use serde_json::{Value, json};

use super::answer::Answer;
use super::protocol::{Era, Fault};
use super::reports::{self, Reports};
use super::work::{Order, OutputLine};
use crate::{Failure, invocation, report};

/// The most calls that run at once. A call with many files uses all cores.
pub(super) const MOST_RUNNING: usize = 4;

/// The most waiting calls, each with a message of at most 1 MiB.
const MOST_WAITING: usize = 128;

/// The time in which a process must end by itself. The process may need this time to finish the file that it is
/// writing.
const GRACE: Duration = Duration::from_secs(5);

/// A call of a tool.
pub(super) struct Call {
    /// The identifier of the request, as JSON.
    pub(super) id: String,
    pub(super) tool: &'static str,
    /// The arguments as text, because parsed values take several times the memory while the call waits.
    pub(super) arguments: Box<RawValue>,
    pub(super) era: Era,
    /// The progress of the call, if the client asks for it.
    pub(super) progress: Option<Progress>,
}

/// The interval of notifications about a waiting or running call.
const BEAT: Duration = Duration::from_secs(1);

/// The progress of a call.
pub(super) struct Progress {
    token: Value,
    /// The number of finished files, and the number of all files. The latter is 0 until the files are counted, and for
    /// a call with one file.
    done: usize,
    files: usize,
    /// The times at which the call came, and the last file was finished.
    start: Instant,
    last: Instant,
}

impl Progress {
    pub(super) fn new(token: Value) -> Self {
        let (start, last) = (Instant::now(), Instant::now());
        Self {
            token,
            done: 0,
            files: 0,
            start,
            last,
        }
    }

    /// Takes a new count of finished files. Returns whether the new count is larger than the last count.
    fn count(&mut self, done: usize, files: usize) -> bool {
        self.files = files;
        let is_farther = done > self.done;
        if is_farther {
            (self.done, self.last) = (done, Instant::now());
        }
        is_farther
    }

    /// The notification that states the count of finished files.
    fn counted(&self) -> String {
        self.notification(self.done.into(), "running")
    }

    /// The notification if no further file is finished for some time. The protocol requires that each number is larger
    /// than the last number. So the number rises with time, from the last count towards the next count.
    fn beat(&self, what: &str) -> String {
        let waited = self.last.elapsed().as_secs_f64();
        self.notification(json!(self.done as f64 + waited / (waited + 10.0)), what)
    }

    fn notification(&self, progress: Value, what: &str) -> String {
        let (done, seconds) = (self.done, self.start.elapsed().as_secs());
        let mut params = json!({"progressToken": self.token, "progress": progress});
        match self.files {
            0 => params["message"] = format!("{what}, {seconds} s").into(),
            files => {
                params["message"] = format!("{what}, {done} of {files} files, {seconds} s").into();
                params["total"] = files.into();
            }
        }
        json!({"jsonrpc": "2.0", "method": "notifications/progress", "params": params}).to_string()
    }
}

pub(super) struct Calls {
    starter: Vec<OsString>,
    time_limit: Duration,
    state: Mutex<State>,
    /// Signals that a call has come, or that no further call will come.
    came: Condvar,
    reports: Mutex<Reports>,
}

#[derive(Default)]
struct State {
    waiting: VecDeque<Call>,
    running: HashMap<String, Sender<Event>>,
    /// The files that the session has written.
    written: OwnFiles,
    /// The time of the last notifications about waiting calls.
    told: Option<Instant>,
    is_closed: bool,
}

/// Events while a call runs.
enum Event {
    Said(OutputLine),
    Ended,
    Cancelled,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Calls {
    pub(super) fn new(time_limit: Duration) -> Result<Self, Failure> {
        Ok(Self {
            starter: invocation::starter()?,
            time_limit,
            state: Mutex::default(),
            came: Condvar::new(),
            reports: Mutex::new(Reports::new()),
        })
    }

    pub(super) fn reports(&self) -> MutexGuard<'_, Reports> {
        lock(&self.reports)
    }

    /// Sends a message to the client. The server ends if the client is gone.
    pub(super) fn send(&self, message: &str) {
        let mut output = io::stdout().lock();
        let sent = writeln!(output, "{}", report::visible_json(message)).and_then(|()| output.flush());
        if let Err(error) = sent {
            process::exit(i32::from(error.kind() != io::ErrorKind::BrokenPipe));
        }
    }

    /// Takes a call. The answer follows when the call ends.
    pub(super) fn begin(&self, call: Call) -> Result<(), Fault> {
        let mut state = lock(&self.state);
        if state.running.contains_key(&call.id) || state.waiting.iter().any(|other| other.id == call.id) {
            return Err(Fault::invalid_request(
                "\"id\" belongs to a call that still runs or waits; use a new \"id\"",
            ));
        }
        if state.waiting.len() == MOST_WAITING {
            let words = format!("{MOST_WAITING} calls are waiting; wait for some answers, then call again");
            return Err(Fault::busy(words));
        }
        state.waiting.push_back(call);
        self.came.notify_one();
        Ok(())
    }

    /// Ends a call without an answer. Ignores an identifier that no running or waiting call has.
    pub(super) fn cancel(&self, id: &Value) {
        let id = id.to_string();
        let mut state = lock(&self.state);
        state.waiting.retain(|call| call.id != id);
        if let Some(events) = state.running.get(&id) {
            let _ = events.send(Event::Cancelled);
        }
    }

    /// Notes that no further call will come. Waiting calls are still run.
    pub(super) fn close(&self) {
        lock(&self.state).is_closed = true;
        self.came.notify_all();
    }

    /// Runs calls one after the other, until no call waits and no further call will come.
    pub(super) fn work(&self) {
        loop {
            let mut state = lock(&self.state);
            let mut call = loop {
                match state.waiting.pop_front() {
                    Some(call) => break call,
                    None if state.is_closed => return,
                    None => state = self.came.wait(state).unwrap_or_else(PoisonError::into_inner),
                }
            };
            let (sender, events) = mpsc::channel();
            state.running.insert(call.id.clone(), sender.clone());
            let written = state.written.clone();
            drop(state);
            let answer = self.run(&mut call, written, sender, &events);
            // Remove the call first, because the client may reuse the identifier once it has the answer.
            lock(&self.state).running.remove(&call.id);
            if let Some(result) = answer {
                self.send(&format!(r#"{{"jsonrpc":"2.0","id":{},"result":{result}}}"#, call.id));
            }
        }
    }

    /// The result of a call as JSON; none for a cancelled call.
    fn run(
        &self,
        call: &mut Call,
        written: OwnFiles,
        sender: Sender<Event>,
        events: &Receiver<Event>,
    ) -> Option<String> {
        let number = self.reports().next_number();
        let order = Order {
            name: call.tool,
            arguments: &call.arguments,
            era: call.era,
            written: &written,
            number,
        };
        let ended = match Process::start(&self.starter, &order, sender) {
            Ok(process) => self.watch(call, process, events)?,
            Err(error) => Err(format!("the call could not be started: {error}")),
        };
        let (result, report) = ended.unwrap_or_else(|problem| {
            let (result, report) = reports::result(number, Answer::failed(Failure::Usage(problem)));
            (call.era.finish(result, "tools/call").to_string(), report)
        });
        self.reports().keep(number, call.tool, report);
        Some(result)
    }

    /// Waits for a process. Returns the result and the report of the call, or the reason why it failed; `None` for a
    /// cancelled call.
    fn watch(
        &self,
        call: &mut Call,
        mut process: Process,
        events: &Receiver<Event>,
    ) -> Option<Result<(String, String), String>> {
        let end = Instant::now() + self.time_limit;
        let (mut done, mut beat) = (None, Instant::now() + BEAT);
        loop {
            match events.recv_timeout(end.min(beat).saturating_duration_since(Instant::now())) {
                Ok(Event::Said(OutputLine::Progress(count, files))) => {
                    if let Some(progress) = &mut call.progress
                        && progress.count(count, files)
                    {
                        self.send(&progress.counted());
                        beat = Instant::now() + BEAT;
                    }
                }
                Ok(Event::Said(OutputLine::Wrote(files))) => lock(&self.state).written.extend(files),
                Ok(Event::Said(OutputLine::Done { result, report })) => done = Some((result.get().to_owned(), report)),
                Ok(Event::Cancelled) => {
                    self.end(process, events);
                    return None;
                }
                Err(RecvTimeoutError::Timeout) if Instant::now() < end => {
                    beat = Instant::now() + BEAT;
                    if let Some(progress) = &call.progress {
                        self.send(&progress.beat("running"));
                    }
                    self.tell_waiting();
                }
                Err(RecvTimeoutError::Timeout) => {
                    self.end(process, events);
                    return Some(Err(format!(
                        "the call was ended because it took longer than {} s; name fewer files, or start mocap mcp with \
                         a larger --time-limit",
                        self.time_limit.as_secs()
                    )));
                }
                Ok(Event::Ended) | Err(RecvTimeoutError::Disconnected) => {
                    let status = process.child.wait();
                    return Some(done.ok_or_else(|| match status {
                        Ok(status) => format!("the call ended without a result: {status}; please report this call"),
                        Err(error) => format!("the call ended without a result: {error}"),
                    }));
                }
            }
        }
    }

    /// Sends notifications about waiting calls. Calls only wait while other calls run.
    fn tell_waiting(&self) {
        let mut state = lock(&self.state);
        if state.told.is_some_and(|told| told.elapsed() < BEAT) {
            return;
        }
        state.told = Some(Instant::now());
        let waiting = state.waiting.iter().filter_map(|call| call.progress.as_ref());
        for progress in waiting.filter(|progress| progress.start.elapsed() >= BEAT) {
            self.send(&progress.beat("waiting"));
        }
    }

    /// Ends a process. It first finishes the file that it is writing.
    fn end(&self, mut process: Process, events: &Receiver<Event>) {
        drop(process.orders);
        let end = Instant::now() + GRACE;
        while let Ok(event) = events.recv_timeout(end.saturating_duration_since(Instant::now())) {
            match event {
                Event::Said(OutputLine::Wrote(files)) => lock(&self.state).written.extend(files),
                Event::Ended => break,
                Event::Said(_) | Event::Cancelled => {}
            }
        }
        // `kill` is harmless if the process has already ended.
        let _ = process.child.kill();
        let _ = process.child.wait();
    }
}

/// A process that runs a call.
struct Process {
    child: Child,
    /// Its standard input. When this input is closed, the process ends.
    orders: Option<ChildStdin>,
}

impl Process {
    fn start(starter: &[OsString], order: &Order<'_>, events: Sender<Event>) -> io::Result<Self> {
        let mut child = invocation::command(starter)
            .args(["mcp", "--root", ".", "--call"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let mut orders = child.stdin.take();
        let said = child.stdout.take();
        thread::spawn(move || {
            let lines = said.into_iter().flat_map(|said| BufReader::new(said).lines());
            for line in lines.map_while(Result::ok) {
                if let Ok(said) = serde_json::from_str(&line) {
                    let _ = events.send(Event::Said(said));
                }
            }
            let _ = events.send(Event::Ended);
        });
        if let Some(orders) = &mut orders {
            // If the process has ended before it read the order, its exit status shows this.
            let _ = writeln!(orders, "{}", serde_json::to_string(order)?);
        }
        Ok(Self { child, orders })
    }
}
