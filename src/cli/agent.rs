//! `mocap mcp`: a server of the Model Context Protocol over standard input and output, for agents.
//!
//! A tool is a command: its arguments are those of the command line ([`schema`]), and it calls the functions that the
//! command calls ([`tools`]), within one folder ([`root`]). [`protocol`] has the messages, [`line`] bounds them, and
//! [`reports`] keeps the reports of a session.

mod answer;
mod call;
#[doc(hidden)]
pub(crate) mod line;
mod protocol;
mod reports;
mod root;
#[doc(hidden)]
pub(crate) mod schema;
pub(crate) mod tools;

use std::io::{self, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use serde_json::{Value, json};

use self::answer::Answer;
use self::call::Call;
use self::line::Line;
use self::protocol::{Era, Fault, Message};
use self::reports::Reports;
use self::root::Root;
use self::schema::Commands;
use crate::{Failure, report, streams};

/// What a client may tell its model of the server.
const INSTRUCTIONS: &str = "Motion capture files: survey a folder of takes, clean and change motions, put them on \
    characters and robots, write GLB, VRMA, FBX, BVH and more, verify and look at the result. Paths are relative to the \
    root folder. A usual order: survey, clean or edit, retarget with max-error and verify, sheet. dry-run does \
    everything but write. mocap://steps lists the steps of edit, mocap://formats the formats.";

/// Answers the messages of standard input, until it ends.
pub(crate) fn serve(folder: &Path) -> Result<(), Failure> {
    let root = Root::enter(folder)?;
    // Standard error is a log that nobody may read; what is said is in the answers.
    report::set_quiet(true);
    streams::take();
    let mut session = Session {
        root,
        commands: Commands::default(),
        reports: Reports::new(),
        is_initialized: false,
    };
    let mut input = io::BufReader::new(io::stdin());
    let mut output = io::stdout();
    loop {
        let answer = match line::read(&mut input)? {
            Line::End => return Ok(()),
            Line::Text(text) => session.answer(&text),
            Line::TooLong => Some(protocol::failed(&Value::Null, &line::too_long())),
        };
        if let Some(answer) = answer {
            let mut text = report::visible_json(&answer.to_string()).into_owned();
            text.push('\n');
            output.write_all(text.as_bytes())?;
            output.flush()?;
        }
    }
}

/// What the server knows of its client's calls.
struct Session {
    root: Root,
    commands: Commands,
    reports: Reports,
    /// Whether the client has shaken hands, as those of earlier revisions do.
    is_initialized: bool,
}

impl Session {
    /// The answer to a message; none to what asks for none.
    fn answer(&mut self, text: &[u8]) -> Option<Value> {
        if text.iter().all(u8::is_ascii_whitespace) {
            return None;
        }
        match protocol::parse(text) {
            Err((id, fault)) => Some(protocol::failed(&id, &fault)),
            Ok(Message::Silent) => None,
            Ok(Message::Request { id, method, params }) => Some(match self.request(&method, &params) {
                Ok(result) => json!({"jsonrpc": "2.0", "id": id, "result": result}),
                Err(fault) => protocol::failed(&id, &fault),
            }),
        }
    }

    fn request(&mut self, method: &str, params: &Value) -> Result<Value, Fault> {
        if method == "initialize" {
            self.is_initialized = true;
            return Ok(protocol::initialized(params, INSTRUCTIONS));
        }
        let era = Era::of(params, self.is_initialized)?;
        let result = match method {
            "server/discover" if era == Era::Current => protocol::discovered(INSTRUCTIONS),
            "ping" => json!({}),
            "tools/list" => json!({"tools": schema::list(&self.commands)}),
            "tools/call" => self.call(params)?,
            "resources/list" => json!({"resources": self.reports.list()}),
            "resources/templates/list" => json!({"resourceTemplates": []}),
            "resources/read" => json!({"contents": [self.reports.read(params)?]}),
            _ => return Err(Fault::unknown_method(method)),
        };
        Ok(era.finish(result, method))
    }

    /// Calls a tool. What goes wrong in it is a result, which the model of the client sees.
    fn call(&mut self, params: &Value) -> Result<Value, Fault> {
        let (tool, arguments) = tools::named(params)?;
        let mut call = Call {
            root: self.root,
            commands: &self.commands,
            tool,
            arguments: &arguments,
        };
        let answered = catch_unwind(AssertUnwindSafe(|| call.answer()));
        let answer = match answered {
            Ok(Ok(answer)) => answer,
            Ok(Err(failure)) => Answer::failed(failure),
            Err(_) => Answer::failed(Failure::Usage(crate::batch::PANICKED.to_owned())),
        };
        Ok(self.reports.keep(tool.name, answer))
    }
}
