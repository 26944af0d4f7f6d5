//! Where in a JSON text the value stands that could not be read.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde_json::value::RawValue;

/// A key of an object, or a place in an array.
#[derive(Debug, PartialEq, Eq)]
pub enum JsonSegment {
    /// The key.
    Key(String),
    /// The place, from 0.
    Index(usize),
}

/// The path to the innermost value at which reading stopped with `error`. It is empty where that is the whole text, and where
/// the text is no JSON.
///
/// A deserializer that keeps the path while it reads would add half a megabyte to the program.
pub fn json_path(text: &str, error: &serde_json::Error) -> Vec<JsonSegment> {
    let above = text.split_inclusive('\n').take(error.line().saturating_sub(1));
    // A column is how many bytes of its line were read.
    let read = above.map(str::len).sum::<usize>() + error.column();
    let is_stop = |value: &RawValue| {
        let start = value.get().as_ptr() as usize - text.as_ptr() as usize;
        (start..=start + value.get().len()).contains(&read)
    };
    let mut path = Vec::new();
    let mut within = text;
    loop {
        let inner = if within.trim_start().starts_with('[') {
            let values: Vec<&RawValue> = serde_json::from_str(within).unwrap_or_default();
            let mut values = values.into_iter().enumerate();
            values
                .find(|(_, value)| is_stop(value))
                .map(|(index, value)| (JsonSegment::Index(index), value))
        } else {
            let values: BTreeMap<Cow<'_, str>, &RawValue> = serde_json::from_str(within).unwrap_or_default();
            let mut values = values.into_iter();
            values
                .find(|(_, value)| is_stop(value))
                .map(|(key, value)| (JsonSegment::Key(key.into_owned()), value))
        };
        let Some((segment, value)) = inner else {
            return path;
        };
        path.push(segment);
        within = value.get();
    }
}

/// `steps[1].key`; nothing for an empty path.
pub fn json_path_text(path: &[JsonSegment]) -> String {
    let segment = |segment: &JsonSegment| match segment {
        JsonSegment::Index(index) => format!("[{index}]"),
        JsonSegment::Key(key) => format!(".{key}"),
    };
    let text: String = path.iter().map(segment).collect();
    text.trim_start_matches('.').to_owned()
}
