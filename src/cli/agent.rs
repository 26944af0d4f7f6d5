//! `mocap mcp`: a server of the Model Context Protocol over standard input and output, for agents.
//!
//! Each tool runs a command. The tool has the options of the command line ([`schema`]), and calls the functions of the
//! command ([`tools`]), within one folder ([`root`]). [`protocol`] has the messages, [`line`] bounds their length, and
//! [`reports`] keeps the reports of a session. The server itself immediately answers requests that need no files. Each
//! call of a tool runs in a separate process ([`work`]), which the server can end at any time. [`calls`] has the
//! waiting and running calls.

#[doc(hidden)]
pub(crate) mod about;
mod answer;
mod answers;
mod brief;
mod call;
mod calls;
#[doc(hidden)]
pub(crate) mod line;
mod listing;
mod paths;
mod protocol;
mod reports;
mod root;
#[doc(hidden)]
pub(crate) mod schema;
pub(crate) mod tools;
mod work;

use std::io;
use std::thread;
use std::time::Duration;

use serde_json::value::to_raw_value;
use serde_json::{Value, json};

use self::calls::{Call, Calls, MOST_RUNNING, Progress};
use self::line::Line;
use self::protocol::{Era, Fault, Message};
use self::root::Root;
use self::schema::Commands;
use crate::args::McpArgs;
use crate::{Failure, report, streams};

/// The instructions of the server for the model of a client. A test makes the calls that they name, in this order.
const INSTRUCTIONS: &str = r#"Motion capture files in one folder. Survey takes, clean and edit motions, and retarget them to
characters and robots. Write GLB, VRM, FBX, BVH and more, verify the result and look at it. Paths are relative to the root
folder. With takes/walk.bvh and hero.vrm in it, this is a usual order of calls:

list {}
survey {"inputs": ["takes"]}
edit {"inputs": ["takes/walk.bvh"], "step": ["foot-lock"], "output": "locked.bvh"}
retarget {"inputs": ["locked.bvh"], "character": "hero.vrm", "output": "walk.vrm", "max-error": "1mm"}
sheet {"inputs": ["walk.vrm"]}

A folder of outputs ends with /, and convert compares what it wrote with its source:

retarget {"inputs": ["takes"], "character": "hero.vrm", "output": "retargeted/"}
convert {"inputs": ["takes/walk.bvh"], "output": "walk.glb", "verify": true}

retarget and robot judge each motion: good, fair (look at it first) or poor. An answer with isError has "error" (nothing
was made) or "problem" (it was made, and is worse than the arguments allow). The steps of edit, and the schema of a job,
which has every option:

read {"uri": "mocap://steps"}
read {"uri": "mocap://job.schema.json"}"#;

/// Answers the messages of standard input, until standard input ends.
pub(crate) fn serve(args: &McpArgs) -> Result<(), Failure> {
    let root = Root::enter(&args.root)?;
    // Perhaps nobody reads standard error, so notices are in the answers.
    report::set_quiet(true);
    streams::take();
    if args.call {
        return work::serve(root);
    }
    let calls = Calls::new(Duration::from_secs(args.time_limit))?;
    let mut server = Server {
        calls: &calls,
        commands: Commands::default(),
        is_initialized: false,
    };
    let mut input = io::BufReader::new(io::stdin());
    thread::scope(|scope| {
        for _ in 0..MOST_RUNNING {
            scope.spawn(|| calls.work());
        }
        let read = server.read(&mut input);
        calls.close();
        read
    })
}

struct Server<'a> {
    calls: &'a Calls,
    commands: Commands,
    /// Whether the client has sent `initialize`, as earlier revisions of the protocol require.
    is_initialized: bool,
}

impl Server<'_> {
    fn read(&mut self, input: &mut impl io::BufRead) -> Result<(), Failure> {
        loop {
            let answer = match line::read(input)? {
                Line::End => return Ok(()),
                Line::Text(text) => self.answer(&text),
                Line::TooLong => Some(protocol::failed(&Value::Null, &line::too_long())),
            };
            if let Some(answer) = answer {
                self.calls.send(&answer.to_string());
            }
        }
    }

    /// The answer to a message. `None` for a message that needs no answer, and for a call that has begun: its answer
    /// follows later.
    fn answer(&mut self, text: &[u8]) -> Option<Value> {
        if text.iter().all(u8::is_ascii_whitespace) {
            return None;
        }
        match protocol::parse(text) {
            Err((id, fault)) => Some(protocol::failed(&id, &fault)),
            Ok(Message::Silent) => None,
            Ok(Message::Cancelled(id)) => {
                self.calls.cancel(&id);
                None
            }
            Ok(Message::Request { id, method, params }) => match self.request(&id, &method, params) {
                Ok(result) => result.map(|result| json!({"jsonrpc": "2.0", "id": id, "result": result})),
                Err(fault) => Some(protocol::failed(&id, &fault)),
            },
        }
    }

    fn request(&mut self, id: &Value, method: &str, params: Value) -> Result<Option<Value>, Fault> {
        if method == "initialize" {
            self.is_initialized = true;
            return Ok(Some(protocol::initialized(&params, INSTRUCTIONS)));
        }
        let era = Era::of(&params, self.is_initialized)?;
        let result = match method {
            "server/discover" if era == Era::Current => protocol::discovered(INSTRUCTIONS),
            "ping" => json!({}),
            "tools/list" => json!({"tools": schema::list(&self.commands)}),
            "tools/call" => {
                let (tool, arguments) = tools::named(&params)?;
                if tool.name == tools::READ {
                    let result = self.calls.reports().answer(tool, &arguments);
                    return Ok(Some(era.finish(result, method)));
                }
                let arguments = to_raw_value(&arguments).map_err(|error| Fault::invalid_params(error.to_string()))?;
                let progress = protocol::progress_token(&params)?.map(Progress::new);
                self.calls.begin(Call {
                    id: id.to_string(),
                    tool: tool.tool_name(),
                    arguments,
                    era,
                    progress,
                })?;
                return Ok(None);
            }
            "resources/list" => json!({"resources": self.calls.reports().list()}),
            "resources/templates/list" => json!({"resourceTemplates": []}),
            "resources/read" => json!({"contents": [self.calls.reports().read(&params)?]}),
            _ => return Err(Fault::unknown_method(method)),
        };
        Ok(Some(era.finish(result, method)))
    }
}
