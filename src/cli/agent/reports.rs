//! Resources: the reports of the last calls, and fixed resources.

use std::collections::VecDeque;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use mocap::FormatInfo;
use mocap::edit::EditStep;
use mocap::job::Job;
use serde_json::{Map, Value, json};

use super::answer::Answer;
use super::protocol::Fault;
use super::schema::check_names;
use super::tools::Tool;
use crate::Failure;

/// The longest report in an answer, in characters. A client reads a longer report as a resource.
const LONGEST: usize = 24_000;

/// The longest part of a resource in an answer of the tool `read`. The schema of a job is shorter.
const LONGEST_READ: usize = 64_000;

/// The most characters of kept reports. The oldest reports are dropped first.
const MOST_KEPT: usize = 64 << 20;

/// The resources of every session: name, description, type.
const FIXED: [(&str, &str, &str); 3] = [
    (
        "mocap://job.schema.json",
        "the JSON Schema of a job, for run",
        "application/schema+json",
    ),
    (
        "mocap://formats",
        "the formats that are read and written",
        "application/json",
    ),
    (
        "mocap://steps",
        "the steps of edit, with their options",
        "application/json",
    ),
];

/// The reports of a session.
pub(super) struct Reports {
    kept: VecDeque<Report>,
    characters: usize,
    count: usize,
}

struct Report {
    uri: String,
    title: String,
    text: String,
}

impl Reports {
    pub(super) fn new() -> Self {
        Self {
            kept: VecDeque::new(),
            characters: 0,
            count: 0,
        }
    }

    /// The number of the next report.
    pub(super) fn next_number(&mut self) -> usize {
        self.count += 1;
        self.count
    }

    /// Keeps the report of a call.
    pub(super) fn keep(&mut self, number: usize, tool: &str, text: String) {
        self.characters += text.len();
        self.kept.push_back(Report {
            uri: uri_of(number),
            title: format!("the report of call {number}, {tool}"),
            text,
        });
        while self.characters > MOST_KEPT && self.kept.len() > 1 {
            self.characters -= self.kept.pop_front().map_or(0, |report| report.text.len());
        }
    }

    /// The resources that can be read.
    pub(super) fn list(&self) -> Vec<Value> {
        let fixed = FIXED.iter().map(|(uri, about, kind)| {
            json!({"uri": uri, "name": uri.trim_start_matches("mocap://"), "description": about, "mimeType": kind})
        });
        let kept = self.kept.iter().map(|report| {
            let name = report.uri.trim_start_matches("mocap://");
            let (uri, title, size) = (&report.uri, &report.title, report.text.len());
            json!({"uri": uri, "name": name, "description": title, "mimeType": "application/json", "size": size})
        });
        fixed.chain(kept).collect()
    }

    /// The result of a call of the tool that reads a resource.
    pub(super) fn answer(&self, tool: &Tool, arguments: &Map<String, Value>) -> Value {
        let (text, shown) = match self.part(tool, arguments) {
            Ok(shown) => (shown.to_string(), Some(shown)),
            Err(problem) => (json!({"error": problem}).to_string(), None),
        };
        let mut result = json!({"content": [{"type": "text", "text": text}], "isError": shown.is_none()});
        if let Some(shown) = shown {
            result["structuredContent"] = shown;
        }
        result
    }

    /// The requested part of a resource, or the error of the call.
    fn part(&self, tool: &Tool, arguments: &Map<String, Value>) -> Result<Value, String> {
        check_names(tool, arguments).map_err(Failure::into_words)?;
        let pointer = match arguments.get("pointer") {
            None | Some(Value::Null) => "",
            Some(Value::String(pointer)) => pointer,
            Some(_) => return Err("\"pointer\" must be a string".to_owned()),
        };
        let uri = arguments.get("uri").cloned().unwrap_or_default();
        let resource = self.read(&json!({"uri": uri})).map_err(Fault::into_words)?;
        let whole: Value = serde_json::from_str(resource["text"].as_str().unwrap_or_default()).unwrap_or_default();
        let Some(part) = whole.pointer(pointer) else {
            let shown: String = pointer.chars().take(80).collect();
            let keys = whole.as_object().into_iter().flat_map(Map::keys);
            let keys: Vec<String> = keys.take(50).map(|key| format!("/{key}")).collect();
            let keys = if keys.is_empty() {
                "/0".to_owned()
            } else {
                keys.join(", ")
            };
            return Err(format!(
                "{} has no part {shown:?}; a JSON Pointer is a path of keys, such as {keys}",
                uri.as_str().unwrap_or_default()
            ));
        };
        Ok(shortened(json!({"uri": uri, "value": part}), LONGEST_READ))
    }

    /// The text of a resource.
    pub(super) fn read(&self, params: &Value) -> Result<Value, Fault> {
        let Some(uri) = params["uri"].as_str() else {
            return Err(Fault::invalid_params("\"uri\" must be a string"));
        };
        let kept = self.kept.iter().find(|report| report.uri == uri);
        let text = match (uri, kept) {
            (_, Some(report)) => report.text.clone(),
            ("mocap://job.schema.json", _) => Job::schema(),
            ("mocap://formats", _) => formats().to_string(),
            ("mocap://steps", _) => steps().to_string(),
            _ => {
                let shown: String = uri.chars().take(80).collect();
                let fixed = FIXED.map(|(uri, ..)| uri).join(", ");
                let kept = [self.kept.front(), self.kept.back()].map(|report| report.map(|report| &*report.uri));
                let kept = match kept {
                    [Some(first), Some(last)] => format!(", and the reports from {first} to {last}"),
                    _ => String::new(),
                };
                let words = format!("there is no resource {shown:?}; there are {fixed}{kept}");
                return Err(Fault::invalid_params(words));
            }
        };
        let fixed = FIXED.iter().find(|(name, ..)| *name == uri);
        let kind = fixed.map_or("application/json", |(.., kind)| *kind);
        Ok(json!({"uri": uri, "mimeType": kind, "text": text}))
    }
}

fn uri_of(number: usize) -> String {
    format!("mocap://reports/{number}")
}

/// The result of a call, and its report with this number.
pub(super) fn result(number: usize, answer: Answer) -> (Value, String) {
    let text = answer.report.to_string();
    let mut shown = shortened(without_nulls(answer.brief.unwrap_or(answer.report)), LONGEST);
    if shown.get("report").is_none() {
        shown["report"] = uri_of(number).into();
    }
    let mut content = vec![json!({"type": "text", "text": shown.to_string()})];
    if let Some(picture) = answer.picture {
        content.push(json!({"type": "image", "data": STANDARD.encode(picture), "mimeType": "image/png"}));
    }
    let mut result = json!({"content": content, "isError": answer.is_error});
    // Clients validate structured content by the output schema of the tool. No error matches this schema.
    if !answer.is_failed {
        result["structuredContent"] = shown;
    }
    (result, text)
}

/// Limits for an answer that is too long: (entries of each list, characters of each text). They are applied one after
/// another until the answer is short enough.
const SHORTER: [(usize, usize); 5] = [(200, 4000), (50, 2000), (20, 500), (5, 200), (1, 80)];

/// Shortens a value to at most `longest` characters, with a note about cut lists or strings.
fn shortened(mut value: Value, longest: usize) -> Value {
    for (entries, characters) in SHORTER {
        if value.to_string().len() <= longest {
            break;
        }
        cut(&mut value, entries, characters);
        let note = format!(
            "the report is too long: each list has only its first {entries} entries; read other parts with a JSON \
             Pointer"
        );
        value["note"] = note.into();
    }
    value
}

/// Keeps only the first entries of lists and the first characters of strings.
fn cut(value: &mut Value, entries: usize, characters: usize) {
    match value {
        Value::Object(fields) => fields.values_mut().for_each(|value| cut(value, entries, characters)),
        Value::Array(values) => {
            values.truncate(entries);
            values.iter_mut().for_each(|value| cut(value, entries, characters));
        }
        Value::String(text) => {
            if let Some((end, _)) = text.char_indices().nth(characters) {
                text.truncate(end);
                text.push_str("...");
            }
        }
        _ => {}
    }
}

/// A value without null keys.
fn without_nulls(mut value: Value) -> Value {
    fn leave_out(value: &mut Value) {
        match value {
            Value::Object(fields) => {
                fields.retain(|_, value| !value.is_null());
                fields.values_mut().for_each(leave_out);
            }
            Value::Array(values) => values.iter_mut().for_each(leave_out),
            _ => {}
        }
    }
    leave_out(&mut value);
    value
}

fn formats() -> Value {
    let row = |row: &mocap::FormatInfo| {
        json!({
            "name": row.format.as_str(),
            "extensions": row.extensions,
            "is_read": row.reads,
            "is_written": row.writes(),
            "description": row.description,
        })
    };
    FormatInfo::ALL.iter().map(row).collect()
}

fn steps() -> Value {
    let steps = EditStep::ALL.iter();
    steps
        .map(|step| json!({"name": step.name, "help": step.to_string()}))
        .collect()
}
