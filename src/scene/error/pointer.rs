//! Finds the invalid value in a JSON text.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde_json::value::RawValue;

/// The JSON Pointer (RFC 6901) of the innermost value at which reading stopped with `error`. It is empty if that value
/// is the whole text, or if the text is not JSON.
///
/// The alternative, a deserializer that tracks its path, would compile every type twice and add 0.6 MB to the program.
pub fn pointer(text: &str, error: &serde_json::Error) -> String {
    let above = text.split_inclusive('\n').take(error.line().saturating_sub(1));
    // A column is the number of bytes read from its line.
    let read = above.map(str::len).sum::<usize>() + error.column();
    let is_stop = |value: &RawValue| {
        let start = value.get().as_ptr() as usize - text.as_ptr() as usize;
        (start..=start + value.get().len()).contains(&read)
    };
    let mut pointer = String::new();
    let mut within = text;
    loop {
        let inner = if within.trim_start().starts_with('[') {
            let values: Vec<&RawValue> = serde_json::from_str(within).unwrap_or_default();
            let place = values.iter().position(|value| is_stop(value));
            place.map(|place| (place.to_string(), values[place]))
        } else {
            let values: BTreeMap<Cow<'_, str>, &RawValue> = serde_json::from_str(within).unwrap_or_default();
            let mut values = values.into_iter();
            let found = values.find(|(_, value)| is_stop(value));
            found.map(|(key, value)| (key.replace('~', "~0").replace('/', "~1"), value))
        };
        let Some((segment, value)) = inner else {
            return pointer;
        };
        pointer.push('/');
        pointer += &segment;
        within = value.get();
    }
}
