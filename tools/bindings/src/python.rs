//! Writes the Python code in `tools/python/python/mocap` that mirrors jobs and steps.

use mocap::edit::ValueKind;
use mocap::figure::Unit;
use mocap::job::RobotFormat;
use mocap::scene::UpAxis;
use serde_json::Value;

use crate::Generated;
use crate::docs::wrapped;
use crate::model::{Field, Kind, Model, Shape, Step, StepOption, Word};

const NOTE: &str =
    "# Written by `MOCAP_WRITE=1 cargo test -p mocap-bindings`, from the documentation of Rust: do not edit.\n";

/// Options with another name in Python: the name in a job, and the name in Python. An ambiguous name in a job has the
/// path of its records.
const NAMES: &[(&str, &str)] = &[
    ("read/from", "format"),
    ("source/map", "bones"),
    ("write/force", "overwrite"),
    // `convert` already has a parameter `target`.
    ("write/fbx/target", "fbx_target"),
    ("loop", "loop_clip"),
    ("extract-root", "root_motion"),
];

/// Steps with handwritten functions: Python has two functions for a warp, and a trim has two ends.
const BY_HAND: &[&str] = &["warp", "trim"];

/// Options of steps that Python accepts as positional arguments.
const BY_POSITION: &[(&str, &[&str])] = &[
    ("blend", &["weight"]),
    ("layer", &["part"]),
    ("resample", &["rate"]),
    ("rest", &["pose"]),
    ("bone-axis", &["axis"]),
    ("reach", &["to", "limb"]),
    ("pin", &["to", "limb"]),
    ("look-at", &["at"]),
    ("turn", &["by"]),
];

/// Types of a job with another form in Python.
const TYPES: &[(&str, &str)] = &[
    ("Angle", "float"),
    ("BoneMap", "Bones | StrPath"),
    ("Clips", "int | str"),
    ("Length", "float"),
    ("RestPoseSource", "str"),
    ("TimeRange", "TimeRange"),
    ("UnitChoice", "Unit | float"),
    ("UpChoice", "Axis"),
];

/// The largest number of words in an unnamed type; types with more words get a name.
const FEW_WORDS: usize = 8;

/// The width of a line.
const WIDTH: usize = 120;

/// A parameter of a function.
struct Parameter {
    name: String,
    annotation: String,
    default: Option<String>,
    docs: String,
    /// The path of the parameter in a job.
    path: Vec<String>,
}

impl Parameter {
    fn new(name: &str, annotation: &str, default: Option<&str>, docs: &str) -> Self {
        Self {
            name: name.to_owned(),
            annotation: annotation.to_owned(),
            default: default.map(str::to_owned),
            docs: docs.to_owned(),
            path: Vec::new(),
        }
    }

    /// The parameter in the declaration of a function.
    fn declared(&self) -> String {
        let Self {
            name,
            annotation,
            default,
            ..
        } = self;
        match default {
            Some(default) => format!("{name}: {annotation} = {default}"),
            None => format!("{name}: {annotation}"),
        }
    }

    fn documented(&self) -> String {
        let mut lines = self.docs.lines();
        let first = indented(
            &format!("{}: {}", self.name, lines.next().unwrap_or_default()),
            "        ",
            "            ",
        );
        first
            + &lines
                .map(|line| indented(line, "            ", "                "))
                .collect::<String>()
    }
}

pub(crate) fn files(model: &Model) -> Vec<Generated> {
    let python = Python { model };
    let file = |path, text| Generated { path, text };
    vec![
        file("tools/python/python/mocap/_job_options.py", python.options()),
        file("tools/python/python/mocap/_words.py", python.words()),
        file("tools/python/python/mocap/_files.py", python.functions()),
        file("tools/python/python/mocap/_steps.py", python.steps()),
    ]
}

struct Python<'a> {
    model: &'a Model,
}

impl Python<'_> {
    /// The classes with the options of reading and writing.
    fn options(&self) -> String {
        let words = self.model.words(&Kind::Named("Format".to_owned())).unwrap_or_default();
        let format = format!("Format = {}\n", literal(words, "\n    "));
        let mut read = self.parameters("InputOptions", "read");
        read.push(hash());
        let read = class("ReadOptions", "How to read a file.", &read, &[("hash", "bool")], "read");
        let write = self.writing();
        let write = class("WriteOptions", "How to write a file.", &write, &[], "write");
        format!(
            r#"{NOTE}"""How files are read and written, as a job has it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from ._options import Axis, Bones, StrPath, Unit, as_json, part

{format}

{read}

{write}"#
        )
    }

    /// The words of handwritten options, and the names with a dash, which may occur in messages of the library.
    fn words(&self) -> String {
        let of_jobs = self
            .model
            .definitions
            .iter()
            .filter_map(|definition| match &definition.shape {
                Shape::Record(fields) => Some(fields.iter().map(|field| &field.name)),
                _ => None,
            });
        let of_steps = self
            .model
            .steps
            .iter()
            .flat_map(|step| &step.options)
            .map(|option| &option.name);
        let mut names: Vec<&String> = of_jobs
            .flatten()
            .chain(of_steps)
            .filter(|name| name.contains('-'))
            .collect();
        names.sort();
        names.dedup();
        let names: String = names.iter().map(|name| format!("    \"{name}\",\n")).collect();
        let of_schema = |name: &str| self.annotation(&Kind::Named(name.to_owned()));
        let listed = |words: &[&str]| {
            let words: Vec<String> = words.iter().map(|word| format!("    \"{word}\",\n")).collect();
            format!("Literal[\n{}]", words.concat())
        };
        let axes = UpAxis::ALL.map(UpAxis::as_str);
        format!(
            r#"{NOTE}"""Words that options take."""

from typing import Literal

Unit = {}
Axis = {}
Feet = {}
Hands = {}
Floor = {}
RobotFormat = {}

# Options of jobs and steps that Python spells with an underscore.
DASHED = (
{names})
"#,
            listed(&Unit::ALL.map(Unit::as_str)),
            listed(&axes),
            of_schema("Feet"),
            of_schema("Hands"),
            of_schema("Floor"),
            listed(&RobotFormat::ALL.map(RobotFormat::name)),
        )
    }

    /// The functions that read and write files.
    fn functions(&self) -> String {
        let reading = self.parameters("InputOptions", "read");
        let writing = self.writing();
        let source = self.source();
        let known = source.len();
        let mut hashed = self.parameters("InputOptions", "read");
        hashed.push(hash());
        let raises = "    Raises:\n        MocapError: Where the file is of no known format, or breaks the rules of its own.\n        FileNotFoundError, IsADirectoryError, PermissionError, OSError: Where it cannot be opened.\n        MemoryError: Where it would need more memory than the limits allow.\n        TypeError: Where there is no such option, or a value has another type.\n";
        let path = Parameter::new("path", "StrPath", None, "The motion file.");
        let data = Parameter::new("data", "bytes", None, "The bytes of a motion file.");
        let name = "Stands for the file in errors; its extension helps to tell the format.";
        let name = Parameter::new("name", "str", None, name);
        let read = function(
            ("read", "Scene"),
            "Reads a motion file.\n\n>>> scene = mocap.read(\"walk.bvh\", root_offset=\"add\", strict=True)  # doctest: +SKIP",
            &[&path],
            &hashed,
            raises,
            &format!(
                "    return Scene(_mocap.read(path, {}))\n",
                made("ReadOptions", &hashed)
            ),
        );
        let read_bytes = function(
            ("read_bytes", "Scene"),
            "Reads the bytes of a motion file.",
            &[&data, &name],
            &hashed,
            "    Raises:\n        MocapError: As :func:`read`.\n",
            &format!(
                "    return Scene(_mocap.read_bytes(data, name, {}))\n",
                made("ReadOptions", &hashed)
            ),
        );
        let from = "The motion file, or a scene; options of reading are for files alone.";
        let from = Parameter::new("source", "SceneLike", None, from);
        let to = "The file to write; it is whole or absent. A file that may be somebody's source is not replaced.";
        let to = Parameter::new("target", "StrPath", None, to);
        let raises = "    Raises:\n        MocapError: Where the source cannot be read or the target cannot be written.\n        ValueError: Where no written format has the extension, or an option has no effect on it.\n";
        let mut all: Vec<Parameter> = source.into_iter().chain(self.writing()).chain(reading).collect();
        let weights = "The weights of solvers that differ from their defaults, as `{\"markers\": {\"slide\": 0.02}}`; docs/weights.md lists them.";
        let weights = Parameter::new("weights", "Weights | None", Some("None"), &python_docs(weights));
        all.push(weights);
        let paths = part_of(&all[..known], 8);
        let convert = function(
            ("convert", "int"),
            "Writes a motion in the format of the target's extension, as ``mocap formats`` lists them; returns the bytes\nwritten. glTF, VRM animations and packed clips are in metres with +Y up, FBX says what it is in, and BVH keeps the\nunit and the axes of its source.",
            &[&from, &to],
            &all,
            raises,
            &format!(
                "    read = {}\n    write = {}\n    job = {{\n        \"read\": read.to_job(),\n        \"source\": {paths},\n        \"write\": write.to_job(),\n        \"weights\": weights_of(weights),\n    }}\n    return converted(source, target, job)\n",
                made("ReadOptions", &self.parameters("InputOptions", "read")),
                made("WriteOptions", &writing)
            ),
        );
        let scene = Parameter::new("scene", "SceneLike", None, "The scene, or a motion file.");
        let write = function(
            ("write", "None"),
            "Writes a scene in the format of the target's extension, as ``mocap formats`` lists them; the file is whole or\nabsent. A file that may be somebody's source is not replaced.\n\nglTF and FBX record the steps; BVH and ``.mclip`` have no field for them.",
            &[&scene, &to],
            &writing,
            "    Raises:\n        MocapError: Where the target cannot be written.\n        ValueError: Where no written format has the extension, or an option has no effect on it.\n",
            &format!(
                "    options = {}\n    written(scene, target, options)\n",
                made("WriteOptions", &writing)
            ),
        );
        format!(
            r#"{NOTE}"""Functions that read and write files."""

from __future__ import annotations

from typing import Literal

from . import _mocap
from ._call import public
from ._convert import converted, written
from ._job_options import Format, ReadOptions, WriteOptions
from ._options import Axis, Bones, StrPath, TimeRange, Unit, Weights, part, time_range, weights_of
from ._scene import Scene, SceneLike


{read}

{read_bytes}

{convert}

{write}"#
        )
    }

    /// The functions of all steps.
    fn steps(&self) -> String {
        let steps = self.model.steps.iter().filter(|step| !BY_HAND.contains(&step.name));
        let (names, functions): (Vec<String>, Vec<String>) =
            steps.map(|step| (named(step.name, step.name), self.step(step))).unzip();
        let mut names: Vec<String> = names.iter().map(|name| format!("    \"{name}\",\n")).collect();
        names.sort();
        let limbs = self.model.steps.iter().flat_map(|step| &step.options);
        let limbs = limbs
            .filter(|option| option.name == "limb")
            .find_map(|option| words_of(option.takes));
        let limbs = limbs.unwrap_or_default();
        format!(
            r#"{NOTE}"""A function for each step of ``mocap edit``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

from ._options import Bones, TimeRange, time_range
from ._scene import SceneLike
from ._step import Point, Step, path_points, step_function, step_of, target_of

__all__ = [
{}]

Limb = {limbs}


{}"#,
            names.concat(),
            functions.join("\n\n")
        )
    }

    fn step(&self, step: &Step) -> String {
        let by_position = BY_POSITION
            .iter()
            .find(|(name, _)| *name == step.name)
            .map_or(&[][..], |row| row.1);
        let mut first = Vec::new();
        if step.takes_other {
            let docs = "The second motion; one with another skeleton is retargeted.";
            first.push(Parameter::new("other", "SceneLike", None, docs));
        }
        let mut others = Vec::new();
        let options: Vec<&StepOption> = step.options.iter().collect();
        let is_first = |option: &StepOption| by_position.contains(&&*option.name);
        let mut positional: Vec<&StepOption> = options.iter().copied().filter(|option| is_first(option)).collect();
        positional.sort_by_key(|option| by_position.iter().position(|name| *name == option.name));
        first.extend(positional.into_iter().map(parameter_of_step));
        others.extend(
            options
                .into_iter()
                .filter(|option| !is_first(option))
                .map(parameter_of_step),
        );
        if step.takes_bones {
            let docs = "The names of joints for bones, where the guess is wrong: ``{\"leftFoot\": \"ankle_L\"}``.";
            others.push(Parameter::new("bones", "Bones | None", Some("None"), docs));
        }
        let mut given: Vec<String> = vec![format!("\"{}\"", step.name)];
        if step.takes_other {
            given.push("other=other".to_owned());
        }
        if step.takes_bones {
            given.push("bones=bones".to_owned());
        }
        for option in &step.options {
            let name = named(&option.name, &option.name);
            given.push(match option.takes {
                ValueKind::TimeRange => format!("{name}=time_range({name})"),
                ValueKind::Target | ValueKind::Point => format!("{name}=target_of({name})"),
                ValueKind::Path => format!("{name}=path_points({name})"),
                _ => format!("{name}={name}"),
            });
        }
        let made = given
            .iter()
            .map(|given| format!("        {given},\n"))
            .collect::<String>();
        let made = match given.join(", ") {
            short if short.len() < 90 => format!("    return step_of({short})\n"),
            _ => format!("    return step_of(\n{made}    )\n"),
        };
        let first: Vec<&Parameter> = first.iter().collect();
        let text = function(
            (&named(step.name, step.name), "Step"),
            &step.docs,
            &first,
            &others,
            "",
            &made,
        );
        text.replace("@public\n", "@step_function\n")
    }

    /// The options of writing, without the path of the output.
    fn writing(&self) -> Vec<Parameter> {
        let mut writing = self.parameters("OutputOptions", "write");
        writing.retain(|parameter| parameter.name != "output");
        writing
    }

    /// The known properties of a source, and the chosen frames.
    fn source(&self) -> Vec<Parameter> {
        let mut source = self.parameters("Sources", "source");
        source.retain(|parameter| !["inputs", "with"].contains(&&*parameter.name));
        source
    }

    /// The parameters for the fields of a record and of the records in it.
    fn parameters(&self, record: &str, place: &str) -> Vec<Parameter> {
        let mut parameters = Vec::new();
        self.add(record, place, &[], &mut parameters);
        let mut names: Vec<&str> = parameters
            .iter()
            .map(|parameter: &Parameter| &*parameter.name)
            .collect();
        names.sort_unstable();
        let twice = names.windows(2).find(|pair| pair[0] == pair[1]);
        assert!(
            twice.is_none(),
            "two options of {record} have one name: {twice:?}; NAMES in python.rs tells them apart"
        );
        parameters
    }

    fn add(&self, record: &str, place: &str, path: &[String], parameters: &mut Vec<Parameter>) {
        for field in self.model.fields(record) {
            let (place, path) = (
                format!("{place}/{}", field.name),
                [path, std::slice::from_ref(&field.name)].concat(),
            );
            match &field.kind {
                Kind::Named(name) if matches!(self.model.definition(name).shape, Shape::Record(_)) => {
                    self.add(name, &place, &path, parameters);
                }
                _ => parameters.push(self.parameter(field, &place, path)),
            }
        }
    }

    fn parameter(&self, field: &Field, place: &str, path: Vec<String>) -> Parameter {
        let annotation = self.annotation(&field.kind);
        let (annotation, default) = match &field.default {
            Some(Value::Bool(is_set)) => (annotation, if *is_set { "True" } else { "False" }.to_owned()),
            Some(Value::String(word)) if self.model.words(&field.kind).is_some() => (annotation, format!("\"{word}\"")),
            Some(Value::Number(number)) => (annotation, number.to_string()),
            _ => (format!("{annotation} | None"), "None".to_owned()),
        };
        let words = self.model.words(&field.kind).unwrap_or_default();
        let docs = match &field.kind {
            Kind::Named(name) if name == "Length" => field.docs.replacen(", such as 1mm", ", in metres", 1),
            _ => field.docs.clone(),
        };
        let named = named(place, &field.name);
        Parameter {
            docs: python_docs(&with_words(&docs, words)),
            name: named,
            annotation,
            default: Some(default),
            path,
        }
    }

    fn annotation(&self, kind: &Kind) -> String {
        match kind {
            Kind::Flag => "bool".to_owned(),
            Kind::Integer => "int".to_owned(),
            Kind::Number => "float".to_owned(),
            Kind::Text => "StrPath".to_owned(),
            Kind::List(item) => format!("Sequence[{}]", self.annotation(item)),
            Kind::Tuple(item, count) => format!("tuple[{}]", vec![self.annotation(item); *count].join(", ")),
            Kind::Map(_) => "Bones".to_owned(),
            Kind::OneOf(kinds) => kinds
                .iter()
                .map(|kind| self.annotation(kind))
                .collect::<Vec<_>>()
                .join(" | "),
            Kind::Tagged(..) | Kind::Step => panic!("{kind:?} is no option of Python"),
            Kind::Named(name) => match TYPES.iter().find(|(own, _)| own == name) {
                Some((_, python)) => (*python).to_owned(),
                None => match &self.model.definition(name).shape {
                    Shape::Words(words) if words.len() > FEW_WORDS => name.clone(),
                    Shape::Words(words) => literal(words, ""),
                    Shape::Alias(kind) => self.annotation(kind),
                    Shape::Record(_) => panic!("{name} is no option of Python"),
                },
            },
        }
    }
}

/// The last option of reading, which a job does not have.
fn hash() -> Parameter {
    let docs = "Compute the SHA-256 of the file, for the provenance; without, it is empty.";
    Parameter::new("hash", "bool", Some("True"), docs)
}

fn parameter_of_step(option: &StepOption) -> Parameter {
    let annotation = match option.takes {
        ValueKind::Seconds
        | ValueKind::Metres
        | ValueKind::MetresPerSecond
        | ValueKind::Hertz
        | ValueKind::Degrees
        | ValueKind::Factor
        | ValueKind::Fraction => "float".to_owned(),
        ValueKind::Count | ValueKind::Input => "int".to_owned(),
        ValueKind::Flag => "bool".to_owned(),
        ValueKind::OneOf(_) if option.name == "limb" => "Limb".to_owned(),
        ValueKind::OneOf(_) => words_of(option.takes).unwrap_or_default(),
        ValueKind::FrameRange => "tuple[int, int]".to_owned(),
        ValueKind::TimeRange => "TimeRange".to_owned(),
        ValueKind::Frames => "Sequence[int]".to_owned(),
        ValueKind::Weights => "float | Sequence[tuple[float, float]]".to_owned(),
        ValueKind::Moments => "Sequence[tuple[float, float]]".to_owned(),
        ValueKind::Numbers => "Mapping[str, float]".to_owned(),
        ValueKind::Path => "Sequence[tuple[float, float] | tuple[float, float, float]]".to_owned(),
        ValueKind::Target => "str | Point".to_owned(),
        ValueKind::Point => "Point".to_owned(),
        ValueKind::Names => "Sequence[str]".to_owned(),
        _ => "str".to_owned(),
    };
    let (annotation, default) = match option.is_required {
        true => (annotation, None),
        false => (format!("{annotation} | None"), Some("None".to_owned())),
    };
    let docs = option.docs.replace(" It must be given.", "");
    Parameter {
        name: named(&option.name, &option.name),
        annotation,
        default,
        docs: python_docs(&docs),
        path: Vec::new(),
    }
}

fn words_of(takes: ValueKind) -> Option<String> {
    match takes {
        ValueKind::OneOf(words) => {
            let words: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
            Some(format!("Literal[{}]", words.join(", ")))
        }
        _ => None,
    }
}

fn literal(words: &[Word], line: &str) -> String {
    let words: Vec<String> = words.iter().map(|word| format!("{line}\"{}\"", word.word)).collect();
    let (separator, end) = if line.is_empty() { (", ", "") } else { (",", ",\n") };
    format!("Literal[{}{end}]", words.join(separator))
}

/// The Python name of an option at a path of a job.
fn named(place: &str, name: &str) -> String {
    let row = NAMES.iter().find(|(own, _)| *own == place);
    row.map_or_else(|| name.replace('-', "_"), |(_, name)| (*name).to_owned())
}

/// Documentation with one line for each documented word.
fn with_words(docs: &str, words: &[Word]) -> String {
    let documented = words
        .iter()
        .filter(|word| !word.docs.is_empty() && words.len() <= FEW_WORDS);
    let lines = documented.map(|word| format!("\n`\"{}\"`: {}", word.word, word.docs));
    docs.to_owned() + &lines.collect::<String>()
}

/// Converts documentation to Python's conventions: names of options, double backquotes around code, `None` and `True`.
fn python_docs(docs: &str) -> String {
    let parts = docs.split('`').enumerate().map(|(at, part)| match (at % 2, part) {
        (0, text) => options_named(text),
        (_, "true") => "``True``".to_owned(),
        (_, "false") => "``False``".to_owned(),
        (_, "null") => "``None``".to_owned(),
        (_, code) => format!("``{code}``"),
    });
    parts.collect::<String>().replace('\\', "\\\\")
}

/// Replaces options of the command line with their Python names.
fn options_named(text: &str) -> String {
    let mut parts = text.split("--");
    let mut named = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let is_option = |c: char| c.is_ascii_alphanumeric() || c == '-';
        let (option, rest) = part.split_at(part.find(|c| !is_option(c)).unwrap_or(part.len()));
        named += &format!("``{}``{rest}", option.replace('-', "_"));
    }
    named
}

/// Wraps text. The first line gets `indent`, and further lines get `further`.
fn indented(text: &str, indent: &str, further: &str) -> String {
    let lines = wrapped(text, WIDTH - further.len());
    let lines = lines.iter().enumerate();
    lines
        .map(|(at, line)| format!("{}{line}\n", if at == 0 { indent } else { further }))
        .collect()
}

/// A function with its documentation and its body.
fn function(
    (name, result): (&str, &str),
    docs: &str,
    by_position: &[&Parameter],
    by_name: &[Parameter],
    raises: &str,
    body: &str,
) -> String {
    let mut declared: Vec<String> = by_position.iter().map(|parameter| parameter.declared()).collect();
    if !by_name.is_empty() {
        declared.push("*".to_owned());
    }
    declared.extend(by_name.iter().map(Parameter::declared));
    let one_line = format!("def {name}({}) -> {result}:\n", declared.join(", "));
    let head = match one_line.len() <= WIDTH - 20 {
        true => one_line,
        false => {
            let lines: String = declared.iter().map(|line| format!("    {line},\n")).collect();
            format!("def {name}(\n{lines}) -> {result}:\n")
        }
    };
    let all = by_position.iter().copied().chain(by_name);
    let args: String = all.map(Parameter::documented).collect();
    let args = if args.is_empty() {
        args
    } else {
        format!("    Args:\n{args}")
    };
    let summary = match docs.contains('\n') {
        true => docs.replace('\n', "\n    ").replace("\n    \n", "\n\n"),
        false => wrapped(&python_docs(docs), WIDTH - 8).join("\n    "),
    };
    let parts: Vec<&str> = [&*args, raises].into_iter().filter(|part| !part.is_empty()).collect();
    let docs = match parts.is_empty() {
        true => format!("    \"\"\"{summary}\"\"\"\n"),
        false => format!("    \"\"\"{summary}\n\n{}    \"\"\"\n", parts.join("\n")),
    };
    format!("@public\n{head}{docs}{body}")
}

/// A class of options, which converts itself to a part of a job.
fn class(name: &str, docs: &str, fields: &[Parameter], beside: &[(&str, &str)], place: &str) -> String {
    let documented: String = fields.iter().map(Parameter::documented).collect();
    let declared: String = fields
        .iter()
        .map(|field| format!("    {}\n", field.declared()))
        .collect();
    let in_job: Vec<&Parameter> = fields
        .iter()
        .filter(|field| !beside.iter().any(|(name, _)| *name == field.name))
        .collect();
    let pairs: String = in_job.iter().map(|field| pair(field, "self.", 12)).collect();
    format!(
        r#"@dataclass(frozen=True, kw_only=True)
class {name}:
    """{docs}

    Attributes:
{documented}    """

{declared}
    def to_job(self) -> dict[str, Any]:
        """The part ``{place}`` of a job."""
        return part(
{pairs}        )

    @property
    def json(self) -> str:
        """That part as JSON, as the native half reads it."""
        return as_json(self.to_job())
"#
    )
}

/// A call of the constructor of `class` with the parameters of a function.
fn made(class: &str, parameters: &[Parameter]) -> String {
    let given: String = parameters
        .iter()
        .map(|parameter| format!("        {0}={0},\n", parameter.name))
        .collect();
    format!("{class}(\n{given}    )")
}

fn part_of(parameters: &[Parameter], indent: usize) -> String {
    let pairs: String = parameters
        .iter()
        .map(|parameter| pair(parameter, "", indent + 4))
        .collect();
    format!("part(\n{pairs}{})", " ".repeat(indent))
}

/// The path of an option in a job, and the option's value.
fn pair(parameter: &Parameter, of: &str, indent: usize) -> String {
    let name = format!("{of}{}", parameter.name);
    let value = match parameter.annotation.starts_with("TimeRange") {
        true => format!("time_range({name})"),
        false => name,
    };
    format!("{}(\"{}\", {value}),\n", " ".repeat(indent), parameter.path.join("/"))
}
