//! Converts the options of a command to a JSON Schema, and JSON to the words of a command line.

use std::any::TypeId;
use std::collections::BTreeSet;
use std::ffi::OsString;

use clap::{Arg, ArgAction, Command, CommandFactory};
use mocap::job::Job;
use serde_json::{Map, Value, json};

use super::about;
use super::tools::{FileArgument, Slot, TOOLS, Tool};
use crate::Failure;
use crate::args::parse::own_error;
use crate::args::{Args, ArgumentSources};

/// The commands of the program.
pub struct Commands(Command);

impl Default for Commands {
    fn default() -> Self {
        let mut command = Args::command();
        command.build();
        Self(command)
    }
}

impl Commands {
    /// The schema of an option; `None` if the command of the tool has no option of this name.
    pub fn schema(&self, tool: &'static Tool, option: &str) -> Option<Value> {
        self.option(tool, option).map(schema)
    }

    pub fn command(&self, tool: &'static Tool) -> Option<&Command> {
        let words = tool.command();
        words
            .iter()
            .try_fold(&self.0, |command, word| command.find_subcommand(word))
    }

    fn option(&self, tool: &'static Tool, option: &str) -> Option<&Arg> {
        let mut all = self.command(tool)?.get_arguments();
        all.find(|arg| {
            let others = arg.get_all_aliases().unwrap_or_default();
            arg.get_long() == Some(option) || others.contains(&option)
        })
    }

    /// The command line arguments equivalent to the arguments of a call.
    pub(super) fn parse(
        &self,
        tool: &'static Tool,
        arguments: &Map<String, Value>,
    ) -> Result<(Args, ArgumentSources), Failure> {
        self.parse_words(self.words(tool, arguments)?)
    }

    /// Parses the words of a command line.
    pub(super) fn parse_words(
        &self,
        words: impl IntoIterator<Item = OsString>,
    ) -> Result<(Args, ArgumentSources), Failure> {
        Args::parse_from(&self.0, words).map_err(|error| {
            if let Some(error) = own_error(&error) {
                return Failure::Usage(error.diagnostic().to_string());
            }
            let text = error.render().to_string();
            let text = text.split("\n\nUsage:").next().unwrap_or_default();
            let text = text.split("\n\nFor more information").next().unwrap_or_default();
            Failure::Usage(text.trim_start_matches("error: ").trim_end().to_owned())
        })
    }

    fn words(&self, tool: &'static Tool, arguments: &Map<String, Value>) -> Result<Vec<OsString>, Failure> {
        let mut words: Vec<String> = ["mocap"]
            .iter()
            .chain(tool.command())
            .map(ToString::to_string)
            .collect();
        let mut positions = Vec::new();
        check_names(tool, arguments)?;
        for file in tool.files {
            match arguments.get(file.name) {
                None | Some(Value::Null) if file.is_required => {
                    return Err(Failure::Usage(format!("{} needs {:?}", tool.tool_name(), file.name)));
                }
                None | Some(Value::Null) => {}
                Some(value) => add_files(file, texts(file.name, value)?, &mut words, &mut positions),
            }
        }
        for name in tool.options {
            match (arguments.get(*name), self.option(tool, name)) {
                (None | Some(Value::Null | Value::Bool(false)), _) | (_, None) => {}
                (Some(Value::Bool(true)), Some(_)) => words.push(format!("--{name}")),
                (Some(value), Some(option)) => {
                    let texts = texts(name, value)?;
                    let takes_several = option.get_num_args().is_some_and(|count| count.min_values() > 1);
                    match option.get_value_delimiter() {
                        Some(delimiter) => words.push(format!("--{name}={}", texts.join(&delimiter.to_string()))),
                        None if takes_several => add_several(name, texts, &mut words)?,
                        None => words.extend(texts.iter().map(|text| format!("--{name}={text}"))),
                    }
                }
            }
        }
        words.push("--".to_owned());
        words.append(&mut positions);
        Ok(words.into_iter().map(OsString::from).collect())
    }
}

/// The tools as a client lists them.
pub(super) fn list(commands: &Commands) -> Vec<Value> {
    TOOLS.iter().map(|tool| listed(tool, commands)).collect()
}

fn listed(tool: &'static Tool, commands: &Commands) -> Value {
    json!({
        "name": tool.tool_name(),
        "description": tool.about,
        "inputSchema": arguments_of(tool, commands),
        "outputSchema": (tool.answer)(),
        "annotations": match tool.writes() {
            true => json!({"destructiveHint": false, "openWorldHint": false}),
            // A tool that only reads needs no hint about destructive writes.
            false => json!({"readOnlyHint": true, "openWorldHint": false}),
        },
    })
}

/// The schema of a tool's arguments. It does not forbid other arguments, to keep the list of tools short. A call with
/// an unknown argument is refused with a list of the arguments.
fn arguments_of(tool: &'static Tool, commands: &Commands) -> Value {
    let dry_run = json!({"type": "boolean", "description": "Write nothing"});
    if tool.name == "run" {
        let job = brief_schema_of_job();
        return json!({
            "type": "object",
            "properties": {"job": job, "dry-run": dry_run},
            "required": ["job"],
        });
    }
    let mut properties = Map::new();
    for file in tool.files {
        let one = json!({"type": "string"});
        let mut schema = match file.is_list {
            true => json!({"type": "array", "items": one}),
            false => one,
        };
        schema["description"] = file.about.into();
        properties.insert(file.name.to_owned(), schema);
    }
    for option in tool.options {
        if let Some(mut schema) = commands.schema(tool, option) {
            if let Some(about) = about::option(tool.name, option) {
                schema["description"] = about.into();
            }
            properties.insert((*option).to_owned(), schema);
        }
    }
    if tool.writes() {
        properties.insert("dry-run".to_owned(), dry_run);
    }
    let required = tool.files.iter().filter(|file| file.is_required);
    let required: Vec<&str> = required.map(|file| file.name).collect();
    let mut schema = json!({"type": "object", "properties": properties});
    if !required.is_empty() {
        schema["required"] = required.into();
    }
    schema
}

/// The keys of a job of any kind. The whole schema is a resource, because it is longer than the schemas of all tools
/// together.
fn brief_schema_of_job() -> Value {
    let whole: Value = serde_json::from_str(&Job::schema()).unwrap_or_default();
    let kinds = ["oneOf", "anyOf"]
        .iter()
        .flat_map(|key| whole[key].as_array())
        .flatten();
    let kinds = kinds.map(|kind| {
        let pointer = kind["$ref"].as_str().and_then(|reference| reference.strip_prefix('#'));
        pointer.and_then(|pointer| whole.pointer(pointer)).unwrap_or(kind)
    });
    let properties = kinds
        .chain([&whole])
        .flat_map(|schema| schema["properties"].as_object());
    let keys: BTreeSet<&str> = properties.flatten().map(|(name, _)| name.as_str()).collect();
    let keys = keys.into_iter().collect::<Vec<_>>().join(", ");
    json!({"type": "object", "description": format!("{keys}; for their schemas read mocap://job.schema.json")})
}

/// The first sentence of a string, without its full stop.
fn first_sentence(text: &str) -> &str {
    text.split(". ").next().unwrap_or_default().trim_end_matches('.')
}

/// Refuses an argument that the tool does not have.
pub(super) fn check_names(tool: &Tool, arguments: &Map<String, Value>) -> Result<(), Failure> {
    let is_known = |name: &str| {
        let is_file = tool.files.iter().any(|file| file.name == name);
        is_file || tool.options.contains(&name) || name == "dry-run"
    };
    match arguments.keys().find(|name| !is_known(name)) {
        Some(name) => Err(no_argument(tool, name)),
        None => Ok(()),
    }
}

fn add_files(file: &FileArgument, texts: Vec<String>, words: &mut Vec<String>, positions: &mut Vec<String>) {
    for text in texts {
        let is_folder = || text.ends_with('/') || std::path::Path::new(&text).is_dir();
        match file.slot {
            Slot::Option => words.push(format!("--{}={text}", file.name)),
            Slot::OutputOrFolder if is_folder() => words.push(format!("--output={text}")),
            Slot::OutputOrFolder | Slot::Position => positions.push(text),
        }
    }
}

/// Adds an option with its values as separate words. No value may look like an option.
fn add_several(name: &str, texts: Vec<String>, words: &mut Vec<String>) -> Result<(), Failure> {
    if let Some(text) = texts.iter().find(|text| text.starts_with('-')) {
        return Err(Failure::Usage(format!("{name:?} must not begin with -, got {text:?}")));
    }
    words.push(format!("--{name}"));
    words.extend(texts);
    Ok(())
}

fn no_argument(tool: &Tool, name: &str) -> Failure {
    let files = tool.files.iter().map(|file| file.name);
    let known: Vec<&str> = files.chain(tool.options.iter().copied()).chain(["dry-run"]).collect();
    let shown: String = name.chars().take(64).collect();
    Failure::Usage(format!(
        "{} has no argument {shown:?}; its arguments are {}; the tool run accepts every option in a job",
        tool.tool_name(),
        known.join(", ")
    ))
}

/// A value as the strings of a command line.
fn texts(name: &str, value: &Value) -> Result<Vec<String>, Failure> {
    let one = |value: &Value| match value {
        Value::String(text) => Ok(text.clone()),
        Value::Number(number) => Ok(number.to_string()),
        _ => Err(Failure::Usage(format!(
            "{name:?} must be a string, a number, or a list of strings and numbers"
        ))),
    };
    match value {
        Value::Array(values) => values.iter().map(one).collect(),
        value => one(value).map(|text| vec![text]),
    }
}

fn schema(option: &Arg) -> Value {
    let values: Vec<String> = option
        .get_possible_values()
        .iter()
        .map(|value| value.get_name().to_owned())
        .collect();
    let is_list = matches!(option.get_action(), ArgAction::Append) || option.get_value_delimiter().is_some();
    let one = match values.as_slice() {
        [] if is_number(option) => json!({"type": "number"}),
        values if (1..=MOST_VALUES).contains(&values.len()) => json!({"enum": values}),
        _ => json!({"type": "string"}),
    };
    let mut schema = match (option.get_action(), is_list) {
        (ArgAction::SetTrue, _) => json!({"type": "boolean"}),
        (_, true) => json!({"type": "array", "items": one}),
        (_, false) => one,
    };
    let help = option.get_help().map(ToString::to_string).unwrap_or_default();
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    schema["description"] = first_sentence(&help).into();
    schema
}

/// The most values of an option in a schema. An error names all values.
const MOST_VALUES: usize = 8;

/// Whether the value of an option can only be a number. A string with a number is a number too.
fn is_number(option: &Arg) -> bool {
    let value = option.get_value_parser().type_id();
    let numbers = [
        TypeId::of::<f64>(),
        TypeId::of::<f32>(),
        TypeId::of::<u8>(),
        TypeId::of::<u32>(),
        TypeId::of::<u64>(),
        TypeId::of::<usize>(),
    ];
    numbers.iter().any(|number| value == *number)
}
