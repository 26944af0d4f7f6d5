//! Resources: the reports of the last calls, and what does not change.

use std::collections::VecDeque;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use mocap::FormatInfo;
use mocap::edit::EditStep;
use mocap::job::Job;
use serde_json::{Value, json};

use super::answer::Answer;
use super::protocol::Fault;

/// The longest report in characters that stands in an answer; a longer one is read as a resource.
const LONGEST: usize = 24_000;

/// How many characters of reports are kept; the oldest go first.
const MOST_KEPT: usize = 64 << 20;

/// What every session has: the name, what it is, its type.
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

    /// What can be read.
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

    /// The text of a resource.
    pub(super) fn read(&self, params: &Value) -> Result<Value, Fault> {
        let Some(uri) = params["uri"].as_str() else {
            return Err(Fault::invalid_params("\"uri\" must be a text"));
        };
        let kept = self.kept.iter().find(|report| report.uri == uri);
        let text = match (uri, kept) {
            (_, Some(report)) => report.text.clone(),
            ("mocap://job.schema.json", _) => Job::SCHEMA.to_owned(),
            ("mocap://formats", _) => formats().to_string(),
            ("mocap://steps", _) => steps().to_string(),
            _ => {
                let shown: String = uri.chars().take(80).collect();
                let words = format!("there is no resource {shown:?}; resources/list has those that are there");
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

/// The result of a call, and its report, which has this number.
pub(super) fn result(number: usize, answer: Answer) -> (Value, String) {
    let text = answer.report.to_string();
    let mut shown = match answer.brief {
        None if text.len() <= LONGEST => answer.report,
        Some(brief) if brief.to_string().len() <= LONGEST => brief,
        _ => json!({"note": "the report is long; read it as a resource"}),
    };
    if text.len() > LONGEST || shown.get("report").is_none() {
        shown["report"] = uri_of(number).into();
    }
    let mut content = vec![json!({"type": "text", "text": shown.to_string()})];
    if let Some(picture) = answer.picture {
        content.push(json!({"type": "image", "data": STANDARD.encode(picture), "mimeType": "image/png"}));
    }
    let result = json!({"content": content, "structuredContent": shown, "isError": answer.is_error});
    (result, text)
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
