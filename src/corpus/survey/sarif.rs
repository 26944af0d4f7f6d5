//! Writes the findings as SARIF 2.1.0, which code hosts show beside the files.

use mocap_scene::visible_json;
use serde_json::{Value, json};

use super::corpus::Corpus;
use super::row::{ClipRow, Defect, Quality};
use super::thresholds::{DefectKind, Thresholds};

impl Corpus {
    /// The findings as SARIF 2.1.0. A finding is an error at or above the bad threshold of its kind, and a warning
    /// below this threshold. A property is a note. An unreadable file is an error.
    pub fn to_sarif(&self, thresholds: &Thresholds) -> String {
        let rule = |kind: &DefectKind| json!({"id": kind.as_str(), "shortDescription": {"text": kind.help()}});
        let mut rules: Vec<Value> = DefectKind::ALL.iter().map(rule).collect();
        rules.push(json!({"id": "unreadable", "shortDescription": {"text": "the file cannot be read"}}));
        let results: Vec<Value> = self.rows().flat_map(|row| results(row, thresholds)).collect();
        let driver = json!({"name": "mocap survey", "version": env!("CARGO_PKG_VERSION"), "rules": rules});
        let log = json!({
            "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
            "version": "2.1.0",
            "runs": [{"tool": {"driver": driver}, "results": results}],
        });
        visible_json(&log.to_string()).into_owned()
    }
}

fn results(row: &ClipRow, thresholds: &Thresholds) -> Vec<Value> {
    let result = |id: &str, level: &str, text: String| {
        let location = json!({"physicalLocation": {"artifactLocation": {"uri": uri(&row.file)}}});
        json!({"ruleId": id, "level": level, "message": {"text": text}, "locations": [location]})
    };
    if row.verdict == Quality::Unreadable {
        return vec![result("unreadable", "error", row.error.clone().unwrap_or_default())];
    }
    let of = |defect: &Defect| {
        let level = match defect.kind.is_property() {
            true => "note",
            false if defect.amount >= thresholds.of(defect.kind)[1] => "error",
            false => "warning",
        };
        let [from, to] = defect.frames;
        let joint = defect
            .joint
            .as_ref()
            .map(|joint| format!(", {joint}"))
            .unwrap_or_default();
        let (kind, amount, unit) = (defect.kind, defect.amount, defect.kind.unit());
        let text = format!(
            "clip {}, frames {from}..{to}{joint}: {} ({amount} {unit})",
            row.clip,
            kind.help()
        );
        result(kind.as_str(), level, text)
    };
    row.defects.iter().map(of).collect()
}

/// A path as a URI: letters, digits, `-._~` and slashes are kept, all other bytes are escaped.
fn uri(path: &str) -> String {
    let escaped = |byte: u8| match byte {
        b'\\' => "/".to_owned(),
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => char::from(byte).to_string(),
        byte => format!("%{byte:02X}"),
    };
    path.bytes().map(escaped).collect()
}
