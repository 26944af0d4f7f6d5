//! Writes the TypeScript types in `tools/wasm/package` that mirror jobs, steps and formats. Also writes the list of
//! formats that the drop page opens.

use mocap::Contents;
use mocap::edit::ValueKind;
use mocap::figure::Unit;
use mocap::job::RobotFormat;
use mocap::scene::UpAxis;

use crate::Generated;
use crate::docs::wrapped;
use crate::model::{Field, Kind, Model, Shape, Step, StepOption};
use crate::names;

const NOTE: &str =
    "// Written by `MOCAP_WRITE=1 cargo test -p mocap-bindings`, from the documentation of Rust: do not edit.\n";

/// Records whose fields are also options of calls, in camel case and in a flat list.
const OPTIONS: &[&str] = &[
    "InputOptions",
    "SourceSpace",
    "SourceFrames",
    "SizeOptions",
    "BvhOutputOptions",
    "CharacterTarget",
    "RobotTarget",
];

/// The kinds of jobs. No other kind has the parts that are specific to one kind.
const JOBS: [&str; 4] = ["MotionJob", "SurveyJob", "GraphJob", "WalkJob"];

/// Options of calls with a type of their own. A file is passed with its bytes.
const OWN_TYPES: &[(&str, &str, &str)] = &[
    ("InputOptions", "body", "File"),
    ("InputOptions", "static", "File"),
    ("RobotTarget", "passes", "1 | 2"),
];

/// The accepted strings of types for which the schema only states `string`.
const TEXTS: &[(&str, &str)] = &[
    ("Angle", "number | `${number}`"),
    (
        "Length",
        "number | `${number}` | `${number}${\"m\" | \"cm\" | \"mm\" | \"um\"}`",
    ),
    (
        "RestPoseSource",
        "\"zero\" | \"t-pose\" | \"a-pose\" | `frame:${number}`",
    ),
    ("Scale", "number | \"auto\" | \"none\" | `${number}`"),
    ("TimeRange", "`${string}..${string}`"),
    ("TimeScale", "number | \"auto\" | `${number}`"),
];

/// Definitions with another name in TypeScript.
const RENAMED: &[(&str, &str)] = &[("UnitChoice", "Unit"), ("UpChoice", "Axis")];

/// The name of the interface with a record's options of calls.
fn call_options(record: &str) -> String {
    match record.strip_suffix("Options") {
        Some(of) => format!("{of}CallOptions"),
        None => format!("{record}Options"),
    }
}

/// The schema's name for a list of steps; TypeScript has no name for it.
const STEPS: &str = "Steps";

/// Formats that the drop page only reads together with other files.
const BESIDE: &[&str] = &["asf"];

/// Further extensions of characters and of robots.
const MORE_EXTENSIONS: &[&str] = &["vrm", "xml"];

/// The width of a line.
const WIDTH: usize = 130;

pub(crate) fn files(model: &Model) -> Vec<Generated> {
    vec![
        Generated {
            path: "tools/wasm/package/options.d.ts",
            text: TypeScript { model }.types(),
        },
        Generated {
            path: "tools/wasm/page/formats.js",
            text: page(model),
        },
    ]
}

/// The extensions of files that the drop page opens.
fn page(model: &Model) -> String {
    let opened = model
        .formats
        .iter()
        .filter(|row| row.reads && row.contents != Contents::Arrays);
    let extensions = opened.flat_map(|row| row.extensions.iter().copied());
    let extensions = extensions.filter(|extension| !BESIDE.contains(extension));
    let extensions: Vec<&str> = extensions.chain(MORE_EXTENSIONS.iter().copied()).collect();
    format!(
        "{NOTE}\n/** Files that are read for themselves. */\nexport const MOTION = /\\.({})$/i;\n",
        extensions.join("|")
    )
}

struct TypeScript<'a> {
    model: &'a Model,
}

impl TypeScript<'_> {
    fn types(&self) -> String {
        let options: String = OPTIONS.iter().map(|record| self.options(record)).collect();
        let jobs: String = self
            .model
            .definitions
            .iter()
            .filter(|definition| definition.name != STEPS)
            .map(|definition| {
                let name = renamed(&definition.name);
                match &definition.shape {
                    Shape::Record(fields) => {
                        let members = self.fields(fields) + &self.never(&name);
                        interface(&name, &definition.docs, &members)
                    }
                    Shape::Words(words) => {
                        let meanings = words.iter().filter(|word| !word.docs.is_empty());
                        let meanings = meanings.map(|word| format!("\n`\"{}\"`: {}", word.word, word.docs));
                        let docs = definition.docs.clone() + &meanings.collect::<String>();
                        let words = words.iter().map(|word| word.word.as_str());
                        alias(&name, &docs, &union(words))
                    }
                    Shape::Alias(kind) => alias(&name, &definition.docs, &self.alias(&definition.name, kind)),
                }
            })
            .collect();
        let written = self.model.formats.iter().filter(|row| row.writes());
        let written = written.flat_map(|row| row.extensions.iter().copied());
        let robots = RobotFormat::ALL.into_iter().map(RobotFormat::name);
        let steps: String = self.model.steps.iter().map(|step| self.step(step)).collect();
        let of_step = self.model.steps.iter().map(|step| step_type(step.name));
        let of_step: Vec<String> = of_step.collect();
        [
            NOTE.to_owned(),
            "\nimport type { File } from \"./index.js\";\n".to_owned(),
            options,
            alias(
                "WrittenExtension",
                "The extensions of the formats that are written.",
                &union(written),
            ),
            alias(
                "RobotFormatName",
                "The layouts of the numbers of a motion on a robot.",
                &union(robots),
            ),
            alias(
                "Job",
                "One piece of work, as `mocap run` takes it. Its kind has only the options that do something in it.",
                &JOBS.join(" | "),
            ),
            jobs,
            alias(
                "StepName",
                "The names of the steps of `mocap edit`.",
                &union(self.model.steps.iter().map(|step| step.name)),
            ),
            alias(
                "EditStep",
                "A step as text, `\"smooth:cut-off=8\"`, or its name with its options.",
                &format!("StepName | `${{StepName}}:${{string}}` | {}", of_step.join(" | ")),
            ),
            steps,
        ]
        .concat()
    }

    /// The options of a record, as they appear in a call.
    fn options(&self, record: &str) -> String {
        let definition = self.model.definition(record);
        let fields = self.model.fields(record).iter().filter_map(|field| {
            let name = names::option(record, &field.name)?;
            let own_type = OWN_TYPES.iter().find(|row| row.0 == record && row.1 == field.name);
            let words = self.model.words(&field.kind).unwrap_or_default();
            let own: Vec<_> = words
                .iter()
                .map(|word| names::word(record, &field.name, &word.word))
                .collect();
            let is_same = words.iter().zip(&own).all(|(word, own)| *own == Some(&*word.word));
            let kind = match own_type {
                Some((.., kind)) => (*kind).to_owned(),
                None if !is_same => union(own.into_iter().flatten()),
                None => self.kind(&field.kind),
            };
            let default = field.default.as_ref().and_then(|default| {
                let word = default.as_str()?;
                names::word(record, &field.name, word).map(|word| format!("\"{word}\""))
            });
            Some(member(&name, false, &kind, &documented(&field.docs, default)))
        });
        interface(&call_options(record), &definition.docs, &fields.collect::<String>())
    }

    fn fields(&self, fields: &[Field]) -> String {
        let field = |field: &Field| {
            let null = if field.is_nullable { " | null" } else { "" };
            let kind = self.kind(&field.kind) + null;
            let default = field
                .default
                .as_ref()
                .filter(|default| !default.is_object() && !default.is_array());
            let docs = documented(&field.docs, default.map(ToString::to_string));
            member(&quoted(&field.name), field.is_required, &kind, &docs)
        };
        fields.iter().map(field).collect()
    }

    /// Members of type `never` for the parts that a kind of job does not have. Without them, a union of jobs would
    /// accept parts of another kind.
    fn never(&self, name: &str) -> String {
        if !JOBS.contains(&name) {
            return String::new();
        }
        let own = self.model.fields(name);
        let others = JOBS.iter().flat_map(|job| self.model.fields(job));
        let mut others: Vec<&str> = others.map(|field| field.name.as_str()).collect();
        others.retain(|other| own.iter().all(|field| field.name != *other));
        others.sort_unstable();
        others.dedup();
        others
            .into_iter()
            .map(|other| member(other, false, "never", ""))
            .collect()
    }

    fn alias(&self, name: &str, kind: &Kind) -> String {
        if let Some((_, texts)) = TEXTS.iter().find(|row| row.0 == name) {
            return (*texts).to_owned();
        }
        match name {
            "UnitChoice" => format!("number | \"auto\" | {}", union(Unit::ALL.map(Unit::as_str))),
            "UpChoice" => format!("\"auto\" | {}", union(UpAxis::ALL.map(UpAxis::as_str))),
            _ => self.kind(kind),
        }
    }

    fn kind(&self, kind: &Kind) -> String {
        match kind {
            Kind::Flag => "boolean".to_owned(),
            Kind::Integer | Kind::Number => "number".to_owned(),
            Kind::Text => "string".to_owned(),
            Kind::Named(name) if name == STEPS => "EditStep[]".to_owned(),
            Kind::Named(name) => renamed(name),
            Kind::List(item) => format!("{}[]", self.kind(item)),
            Kind::Tuple(item, count) => format!("[{}]", vec![self.kind(item); *count].join(", ")),
            // A map of bones may also contain joints that follow other joints.
            Kind::Map(of) if matches!(**of, Kind::OneOf(_)) => {
                "Record<string, string | null | Record<string, string>>".to_owned()
            }
            Kind::Map(_) => "Record<string, string | null>".to_owned(),
            Kind::Tagged(tag, kind) => format!("{{ {}: {} }}", quoted(tag), self.kind(kind)),
            Kind::OneOf(kinds) => kinds.iter().map(|kind| self.kind(kind)).collect::<Vec<_>>().join(" | "),
            Kind::Step => "EditStep".to_owned(),
        }
    }

    fn step(&self, step: &Step) -> String {
        let mut members = member("step", true, &format!("\"{}\"", step.name), "");
        if step.takes_other {
            let docs = "The second motion among the motions of a job, counted from 2. Default: the next.";
            members += &member("with", false, "number", docs);
        }
        let options = step.options.iter();
        let options = options.map(|option| {
            member(
                &quoted(&option.name),
                option.is_required,
                &of_step(option),
                &option.docs,
            )
        });
        members.extend(options);
        interface(&step_type(step.name), &step.docs, &members)
    }
}

/// The JSON type of a step's option.
fn of_step(option: &StepOption) -> String {
    let point = "[number, number, number]";
    match option.takes {
        ValueKind::Flag => "boolean".to_owned(),
        ValueKind::OneOf(words) => union(words.iter().copied()),
        ValueKind::FrameRange => "[number, number]".to_owned(),
        ValueKind::Frames => "number[]".to_owned(),
        ValueKind::Weights => "number | [number, number][]".to_owned(),
        ValueKind::Moments => "[number, number][]".to_owned(),
        ValueKind::Numbers => "{ [name: string]: number }".to_owned(),
        ValueKind::Path => "{ seconds?: number | null; at: [number, number] }[]".to_owned(),
        ValueKind::Target => format!("string | {point}"),
        ValueKind::Point => point.to_owned(),
        ValueKind::Names => "string[]".to_owned(),
        ValueKind::TimeRange | ValueKind::Name => "string".to_owned(),
        _ => "number".to_owned(),
    }
}

/// Converts `foot-lock` to `FootLockStep`.
fn step_type(name: &str) -> String {
    let words = name.split('-').map(|word| word[..1].to_uppercase() + &word[1..]);
    words.collect::<String>() + "Step"
}

fn renamed(name: &str) -> String {
    let row = RENAMED.iter().find(|(own, _)| *own == name);
    row.map_or(name, |row| row.1).to_owned()
}

fn union<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
    let words = words.into_iter().map(|word| format!("\"{word}\""));
    words.collect::<Vec<_>>().join(" | ")
}

/// A name, with quotes if it needs them.
fn quoted(name: &str) -> String {
    match name.contains('-') {
        true => format!("\"{name}\""),
        false => name.to_owned(),
    }
}

/// Documentation with the default, unless the documentation already states it.
fn documented(docs: &str, default: Option<String>) -> String {
    match default.filter(|default| default != "false" && !docs.contains("Default: ")) {
        Some(default) => format!("{docs} Default: `{default}`."),
        None => docs.to_owned(),
    }
}

fn member(name: &str, is_required: bool, kind: &str, docs: &str) -> String {
    let mark = if is_required { "" } else { "?" };
    format!("{}  {name}{mark}: {kind};\n", comment(docs, "  "))
}

fn interface(name: &str, docs: &str, members: &str) -> String {
    match members {
        "" => format!("\n{}export interface {name} {{}}\n", comment(docs, "")),
        _ => format!("\n{}export interface {name} {{\n{members}}}\n", comment(docs, "")),
    }
}

fn alias(name: &str, docs: &str, kind: &str) -> String {
    let line = format!("export type {name} = {kind};\n");
    let line = match line.len() <= WIDTH {
        true => line,
        false => format!("export type {name} =\n  | {};\n", kind.replace(" | ", "\n  | ")),
    };
    format!("\n{}{line}", comment(docs, ""))
}

/// Documentation as a comment before a declaration. Each line of the documentation is a paragraph.
fn comment(docs: &str, indent: &str) -> String {
    let docs = docs.replace("*/", "* /").replace("`None`", "none");
    let lines = docs.lines().flat_map(|line| wrapped(line, WIDTH - indent.len() - 7));
    let lines: Vec<String> = lines.collect();
    match lines.as_slice() {
        [] => String::new(),
        [line] if line.is_empty() => String::new(),
        [line] => format!("{indent}/** {line} */\n"),
        lines => {
            let lines: String = lines.iter().map(|line| format!("{indent} * {line}\n")).collect();
            format!("{indent}/**\n{lines}{indent} */\n")
        }
    }
}
