//! Reads and prints steps as text, `NAME:key=value,...`, and as JSON. The code works on JSON values, so that the code
//! is the same for all steps.

use mocap_scene::error::{Code, Diagnostic, Result, nearest};
use serde_json::{Map, Value};

use super::step::WITH;
use super::value::{parsed, print, scalar};
use super::{EditStep, StepInfo, StepKey, ValueKind};

/// Prints a step with these options as text.
pub(super) fn of(step: StepInfo, keys: &Map<String, Value>) -> String {
    let mut names: Vec<&String> = keys.keys().collect();
    names.sort_unstable();
    let parts: Vec<String> = names
        .into_iter()
        .filter_map(|name| {
            let key = step.keys.iter().find(|key| key.name() == *name)?;
            let text = print(key.takes, &keys[name])?;
            Some(match key.takes {
                ValueKind::Moments => text,
                _ => format!("{name}={text}"),
            })
        })
        .collect();
    match parts.is_empty() {
        true => step.name.to_owned(),
        false => format!("{}:{}", step.name, parts.join(",")),
    }
}

/// Parses the text of a step.
pub(super) fn parse(text: &str) -> Result<EditStep> {
    let (name, rest) = text.split_once(':').unwrap_or((text, ""));
    let step = named(name)?;
    let moments = step.keys.iter().find(|key| key.takes == ValueKind::Moments);
    let mut keys = Map::new();
    for part in rest.split(',').map(str::trim).filter(|part| !part.is_empty()) {
        let Some((key, value)) = part.split_once('=') else {
            let message = format!("{part:?} in the step {text:?} is not key=value");
            return Err(Diagnostic::new(Code::InvalidValue, message)
                .help(takes(step, step.keys.first()))
                .into());
        };
        if let (Some(moments), Value::Number(from)) = (moments, scalar(key)) {
            let pair = Value::Array(vec![Value::Number(from), scalar(value)]);
            let pairs = keys.entry(moments.name()).or_insert(Value::Array(Vec::new()));
            pairs
                .as_array_mut()
                .into_iter()
                .for_each(|pairs| pairs.push(pair.clone()));
            continue;
        }
        let key = known(step, key)?;
        keys.insert(key.name(), parsed(key.takes, value));
    }
    with_keys(step, keys, text)
}

/// Reads a step from a JSON object.
pub(super) fn from_object(value: &Value) -> Result<EditStep> {
    let Some((object, name)) = value
        .as_object()
        .and_then(|map| Some((map, map.get("step")?.as_str()?)))
    else {
        return refuse(format!(
            "a step is an object with its name in \"step\", or a string such as \"smooth:cut-off=8\", got {value}"
        ));
    };
    let step = named(name)?;
    let mut keys = Map::new();
    for (key, value) in object.iter().filter(|(key, _)| *key != "step") {
        keys.insert(known(step, key)?.name(), value.clone());
    }
    with_keys(step, keys, &value.to_string())
}

fn with_keys(step: StepInfo, keys: Map<String, Value>, stated: &str) -> Result<EditStep> {
    if let Some(given) = keys.get(WITH).filter(|given| !given.is_null())
        && given.as_u64().is_none_or(|given| given < 2)
    {
        return refuse(not_taken(WITH, ValueKind::Input, stated, given));
    }
    let step_of = EditStep::with_keys(step.name, keys, stated);
    step_of.unwrap_or_else(|| refuse(format!("there is no step {:?}", step.name)))
}

fn named(name: &str) -> Result<StepInfo> {
    if let Some(step) = EditStep::ALL.iter().find(|step| step.name == name) {
        return Ok(*step);
    }
    let names: Vec<&str> = EditStep::ALL.iter().map(|step| step.name).collect();
    let near = nearest(name, names.iter().copied());
    let unknown = Diagnostic::new(Code::UnknownOption, format!("there is no step {name:?}"));
    let all = format!("the steps are {}; such as smooth:cut-off=8", names.join(", "));
    Err(unknown.help(after_nearest(near, &all)).into())
}

/// Suggests the nearest name, if there is one, followed by `all`.
fn after_nearest(near: Option<&str>, all: &str) -> String {
    match near {
        Some(near) => format!("did you mean {near}? {all}"),
        None => all.to_owned(),
    }
}

/// A text for messages: the options of a step, and an example. The example has the option `key`, if the step accepts
/// this option alone.
fn takes(step: StepInfo, key: Option<&StepKey>) -> String {
    let all = step.keys_with_values();
    let with = |key: &StepKey| format!("{}:{}", step.name, key.example());
    let mut examples = key.into_iter().chain(step.keys).map(with);
    match examples.find(|example| parse(example).is_ok()) {
        Some(example) => format!("{} takes {all}; such as {example}", step.name),
        None => format!("{} takes no options", step.name),
    }
}

/// The option with this name. In the name, `_` may replace `-`.
fn known(step: StepInfo, name: &str) -> Result<&'static StepKey> {
    let field = name.replace('-', "_");
    if let Some(key) = step.keys.iter().find(|key| key.field == field) {
        return Ok(key);
    }
    let names: Vec<String> = step.keys.iter().map(StepKey::name).collect();
    let message = format!("the step {} has no key {name:?}", step.name);
    let unknown = Diagnostic::new(Code::UnknownOption, message);
    let near = nearest(name, names.iter().map(String::as_str));
    let meant = step.keys.iter().find(|key| near == Some(key.name().as_str()));
    let all = takes(step, meant.or(step.keys.first()));
    Err(unknown.help(after_nearest(near, &all)).into())
}

/// The beginnings of errors about a single value. Any other error is about the whole step.
const OF_VALUES: [&str; 4] = ["invalid ", "unknown variant ", "data did not match ", "\""];

/// Reads a step from its options. `stated` is the step as the user wrote it, for messages.
pub(super) fn read<S: super::Step>(keys: Map<String, Value>, stated: &str) -> Result<S> {
    let value = Value::Object(keys);
    S::deserialize(&value).or_else(|error| {
        // Reads each option without the other options, to find the option whose value is wrong.
        let alone = |key: &StepKey| {
            let name = key.name();
            let found = value.get(&name)?;
            let refusal = S::deserialize(serde_json::json!({ &name: found })).err()?;
            let refusal = refusal.to_string();
            let is_of_value = OF_VALUES.iter().any(|start| refusal.starts_with(start));
            (is_of_value && refusal == error.to_string()).then(|| not_taken(&name, key.takes, stated, found))
        };
        match S::KEYS.iter().find_map(alone) {
            Some(message) => refuse(message),
            // Each value is right, but the step refuses their combination.
            None => refuse(format!("the step {stated:?}: {error}")),
        }
    })
}

fn not_taken(key: &str, takes: ValueKind, stated: &str, value: &Value) -> String {
    let found = print(takes, value).unwrap_or_else(|| value.to_string());
    format!("{key} takes {takes}, got {found:?} in the step {stated:?}")
}

fn refuse<T>(message: String) -> Result<T> {
    Err(Diagnostic::new(Code::InvalidValue, message).into())
}
