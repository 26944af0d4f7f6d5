//! The JSON Schema of each tool's answer. A schema has the keys that an agent needs for decisions; an answer has
//! further keys. No value is null. A number that is not finite is absent, so only counts and strings are required.

use serde_json::{Map, Value, json};

/// An object with these properties. The first `required` of them are always present.
fn object<const N: usize>(required: usize, properties: [(&str, Value); N]) -> Value {
    let names: Vec<&str> = properties.iter().take(required).map(|(name, _)| *name).collect();
    let mut shown = Map::new();
    shown.extend(properties.map(|(name, schema)| (name.to_owned(), schema)));
    json!({"type": "object", "properties": shown, "required": names})
}

fn list(items: Value) -> Value {
    json!({"type": "array", "items": items})
}

/// A list of entries without a schema.
fn any_list() -> Value {
    json!({"type": "array"})
}

fn any_object() -> Value {
    json!({"type": "object"})
}

fn text() -> Value {
    json!({"type": "string"})
}

fn number() -> Value {
    json!({"type": "number"})
}

fn count() -> Value {
    json!({"type": "integer"})
}

fn flag() -> Value {
    json!({"type": "boolean"})
}

pub(super) fn listed() -> Value {
    let file = object(3, [("file", text()), ("format", text()), ("bytes", count())]);
    object(3, [("count", count()), ("files", list(file)), ("others", any_list())])
}

pub(super) fn inspected() -> Value {
    let clip = object(2, [("name", text()), ("frames", count()), ("seconds", number())]);
    let properties = [
        ("joints", count()),
        ("frames", count()),
        ("clips", list(clip)),
        ("warnings", any_list()),
        ("format", text()),
        ("duration_seconds", number()),
    ];
    object(4, properties)
}

pub(super) fn skeleton() -> Value {
    let humanoid = object(2, [("found", flag()), ("bones", any_object())]);
    object(
        3,
        [("unit", any_object()), ("up", any_object()), ("humanoid", humanoid)],
    )
}

pub(super) fn checked() -> Value {
    let status = json!({"enum": ["error", "warning", "ok"]});
    let file = object(3, [("file", text()), ("status", status), ("diagnostics", any_list())]);
    object(
        3,
        [("count", count()), ("statuses", any_object()), ("files", list(file))],
    )
}

pub(super) fn surveyed() -> Value {
    let clip = [("file", text()), ("verdict", text()), ("quality", number())];
    let properties = [
        ("count", count()),
        ("verdicts", any_object()),
        ("clips", list(object(2, clip))),
        ("problem", text()),
    ];
    object(3, properties)
}

pub(super) fn indexed() -> Value {
    let properties = [("output", text()), ("count", count()), ("problem", text())];
    object(2, properties)
}

pub(super) fn found() -> Value {
    let part = [
        ("file", text()),
        ("clip", text()),
        ("first", number()),
        ("last", number()),
        ("distance", number()),
    ];
    object(1, [("found", list(object(2, part)))])
}

pub(super) fn matched() -> Value {
    let properties = [
        ("outputs", any_list()),
        ("frames", count()),
        ("mean_distance", number()),
    ];
    object(1, properties)
}

pub(super) fn graphed() -> Value {
    let properties = [("outputs", any_list()), ("clips", count()), ("transitions", count())];
    object(1, properties)
}

pub(super) fn walked() -> Value {
    let properties = [
        ("outputs", any_list()),
        ("seconds", number()),
        ("transitions", any_list()),
    ];
    object(1, properties)
}

/// The schema of written motions. The answer has `files` for one motion, and `motions` for a folder. A dry run of a
/// folder has `inputs`.
pub(super) fn written() -> Value {
    output(object(1, [("input", text()), ("error", text())]))
}

/// Like [`written`], with a verdict on each motion.
pub(super) fn retargeted() -> Value {
    let verdict = || json!({"enum": ["good", "fair", "poor"]});
    let motion = [("input", text()), ("error", text()), ("verdict", verdict())];
    let limb = [("bone", text()), ("mean_degrees", number()), ("max_degrees", number())];
    let clip = [
        ("clip", text()),
        ("verdict", verdict()),
        ("worst_limb", object(1, limb)),
        ("reasons", any_list()),
    ];
    let mut schema = output(object(1, motion));
    schema["properties"]["clips"] = list(object(2, clip));
    schema["properties"]["verdicts"] = any_object();
    schema
}

fn output(motion: Value) -> Value {
    let properties = [
        ("output", text()),
        ("dry_run", flag()),
        ("files", any_list()),
        ("problem", text()),
        ("count", count()),
        ("failed", count()),
        ("motions", list(motion)),
        ("inputs", any_list()),
    ];
    object(2, properties)
}

pub(super) fn drawn() -> Value {
    object(2, [("width", count()), ("height", count())])
}

pub(super) fn verified() -> Value {
    let properties = [
        ("ok", flag()),
        ("max_error", number()),
        ("rms_error", number()),
        ("problem", text()),
    ];
    object(1, properties)
}

pub(super) fn scored() -> Value {
    object(1, [("verdict", text()), ("scores", any_object())])
}

/// The schema of `run`, whose answer is the answer of the tool for the kind of the job.
pub(super) fn run() -> Value {
    object(0, [("output", text()), ("files", any_list()), ("problem", text())])
}

pub(super) fn read() -> Value {
    object(2, [("uri", text()), ("value", json!({}))])
}
