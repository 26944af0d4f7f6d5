//! Tests of the descriptions in a published schema.

use serde_json::Value;

/// Descriptions come from the documentation of types. A schema needs the first paragraph of each, without examples.
pub(crate) fn shorten(value: &mut Value) {
    match value {
        Value::Object(entries) => {
            for (name, entry) in entries {
                match entry {
                    Value::String(text) if name == "description" => {
                        *text = text.split("\n\n").next().unwrap_or_default().replace('\n', " ");
                    }
                    entry => shorten(entry),
                }
            }
        }
        Value::Array(values) => values.iter_mut().for_each(shorten),
        _ => {}
    }
}
