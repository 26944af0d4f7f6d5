//! The bones of many skeletons, assigned by hand: `fixtures/skeletons/truth.json`.

use std::fs;

use serde_json::Value;

/// The files of the truth, each with its true values.
pub(crate) fn truth() -> serde_json::Map<String, Value> {
    let text = fs::read_to_string("../../fixtures/skeletons/truth.json").unwrap();
    let mut truth: Value = serde_json::from_str(&text).unwrap();
    match truth["files"].take() {
        Value::Object(files) => files,
        other => panic!("{other}"),
    }
}
