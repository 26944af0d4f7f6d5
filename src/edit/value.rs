//! Converts the value of an option between text and serde values.

use serde_json::{Number, Value, json};

use super::ValueKind;

/// Parses a value. Text that does not have the expected form stays text, and the step refuses it.
pub(super) fn parsed(takes: ValueKind, text: &str) -> Value {
    let list = |separator: &str, item: fn(&str) -> Value| text.split(separator).map(item).collect();
    match takes {
        ValueKind::FrameRange => list("..", frame),
        ValueKind::Frames => list("+", frame),
        ValueKind::Weights if matches!(scalar(text), Value::Number(_)) => scalar(text),
        ValueKind::Weights => list("+", |part| match part.split_once(':') {
            Some((time, weight)) => Value::Array(vec![scalar(time), scalar(weight)]),
            None => Value::from(part),
        }),
        ValueKind::Numbers => {
            let pairs = text.split('+').map(|part| part.split_once(':').unwrap_or((part, "")));
            Value::Object(pairs.map(|(name, number)| (name.to_owned(), scalar(number))).collect())
        }
        ValueKind::Path => list("+", point),
        ValueKind::Target if text.split('/').count() == 3 => list("/", scalar),
        ValueKind::Point => list("/", scalar),
        ValueKind::Name | ValueKind::Target => Value::from(text),
        ValueKind::Names => text.split('+').map(|name| Value::from(name.trim())).collect(),
        ValueKind::Metres => {
            let number = metres(text).and_then(Number::from_f64);
            number.map_or_else(|| scalar(text), Value::Number)
        }
        _ => scalar(text),
    }
}

/// Parses the number of a frame. An `f` after the number, which a time range needs, is accepted.
fn frame(text: &str) -> Value {
    let text = text.trim();
    scalar(
        text.strip_suffix('f')
            .filter(|number| number.parse::<f64>().is_ok())
            .unwrap_or(text),
    )
}

/// Parses a point of a path: `M/M` or `SECONDS:M/M`.
fn point(text: &str) -> Value {
    let (seconds, at) = match text.split_once(':') {
        Some((seconds, at)) => (scalar(seconds), at),
        None => (Value::Null, text),
    };
    let at: Vec<Value> = at.split('/').map(scalar).collect();
    json!({"seconds": seconds, "at": at})
}

/// Parses a length in metres, or with the unit m, cm, mm or um.
#[doc(hidden)]
pub fn metres(text: &str) -> Option<f64> {
    let units = [("mm", 1e3), ("cm", 1e2), ("um", 1e6), ("m", 1.0)];
    let (number, in_a_metre) = units
        .into_iter()
        .find_map(|(unit, count)| Some((text.trim().strip_suffix(unit)?, count)))
        .unwrap_or((text, 1.0));
    // A division by 100 is exact for `7cm`: it gives the same number as the text `0.07`. A multiplication by 0.01 does
    // not.
    number.trim().parse().ok().map(|number: f64| number / in_a_metre)
}

/// Parses a number, `true`, `false`, or a word.
pub(super) fn scalar(text: &str) -> Value {
    let text = text.trim();
    let number = || {
        let whole = text.parse::<u64>().ok().map(Number::from);
        whole.or_else(|| Number::from_f64(text.parse().ok()?))
    };
    match text {
        "true" => Value::Bool(true),
        "false" => Value::Bool(false),
        _ => number().map_or_else(|| Value::from(text), Value::Number),
    }
}

/// Prints a value as text; `None` for an empty list. A value that does not have the form of `takes` is printed
/// unchanged.
pub(super) fn print(takes: ValueKind, value: &Value) -> Option<String> {
    let joined = |separator: &str, item: fn(&Value) -> String| match value {
        Value::Array(items) => (!items.is_empty()).then(|| items.iter().map(item).collect::<Vec<_>>().join(separator)),
        other => Some(word(other)),
    };
    match takes {
        ValueKind::FrameRange => joined("..", word),
        ValueKind::Frames | ValueKind::Names => joined("+", word),
        ValueKind::Weights => joined("+", |pair| joined_pair(pair, ":")),
        ValueKind::Numbers => {
            let pairs = value.as_object()?.iter();
            let pairs: Vec<String> = pairs.map(|(name, number)| format!("{name}:{}", word(number))).collect();
            (!pairs.is_empty()).then(|| pairs.join("+"))
        }
        ValueKind::Moments => joined(",", |pair| joined_pair(pair, "=")),
        ValueKind::Path => joined("+", |point| {
            let at = joined_pair(&point["at"], "/");
            match &point["seconds"] {
                Value::Null => at,
                seconds => format!("{}:{at}", short(seconds)),
            }
        }),
        ValueKind::Target | ValueKind::Point => Some(joined_pair(value, "/")),
        // The command line requires a unit for lengths.
        ValueKind::Metres if value.is_number() => Some(format!("{}m", word(value))),
        _ => Some(word(value)),
    }
}

fn joined_pair(pair: &Value, separator: &str) -> String {
    match pair {
        Value::Array(items) => items.iter().map(short).collect::<Vec<_>>().join(separator),
        other => word(other),
    }
}

/// Prints a number of a point, without the `.0` of a whole number.
fn short(value: &Value) -> String {
    value.as_f64().map_or_else(|| word(value), |number| number.to_string())
}

fn word(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}
