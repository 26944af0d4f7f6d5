//! What the library says of itself, as plain lists that an emitter writes in its language.
//!
//! Names are in kebab case, as in a job, and documentation is in sentences with Rust's marks for code.

use mocap::FormatInfo;
use mocap::edit::{EditStep, ValueKind};
use mocap::job::Job;
use serde_json::{Map, Value, json};

use crate::docs::sentences;

/// The definitions of a job, the steps and the formats.
#[derive(Clone, Debug)]
pub struct Model {
    /// In the order of their names; the kinds of jobs and everything in them.
    pub definitions: Vec<Definition>,
    /// In the order of the help.
    pub steps: Vec<Step>,
    /// In the order of detection.
    pub formats: &'static [FormatInfo],
}

/// A type of a job that has a name.
#[derive(Clone, Debug)]
pub struct Definition {
    /// Its name.
    pub name: String,
    /// Its documentation.
    pub docs: String,
    /// What it is.
    pub shape: Shape,
}

/// What a type is.
#[derive(Clone, Debug)]
pub enum Shape {
    /// An object with these fields and no others.
    Record(Vec<Field>),
    /// One of these words.
    Words(Vec<Word>),
    /// Another name of a type.
    Alias(Kind),
}

/// A word that an option takes.
#[derive(Clone, Debug)]
pub struct Word {
    /// The word itself.
    pub word: String,
    /// Its documentation.
    pub docs: String,
}

/// A field of a record.
#[derive(Clone, Debug)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// Its documentation.
    pub docs: String,
    /// What it takes.
    pub kind: Kind,
    /// Whether it may be `null`, which means that it is not given.
    pub is_nullable: bool,
    /// Whether it must be given.
    pub is_required: bool,
    /// What it has where it is not given, where the schema says it or a word or `false` is it.
    pub default: Option<Value>,
}

/// The type of a value.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// `true` or `false`.
    Flag,
    /// A whole number.
    Integer,
    /// A number.
    Number,
    /// A string, which may be a path.
    Text,
    /// A definition, by its name.
    Named(String),
    /// Any number of values of one type.
    List(Box<Kind>),
    /// So many values of one type.
    Tuple(Box<Kind>, usize),
    /// An object with any names and values of a type, which may be `null`.
    Map(Box<Kind>),
    /// An object with one name, which tells its type.
    Tagged(String, Box<Kind>),
    /// A value of one of these types.
    OneOf(Vec<Kind>),
    /// A step, as text or as an object with its name in `step`.
    Step,
}

/// A step of `mocap edit`.
#[derive(Clone, Debug)]
pub struct Step {
    /// Its name.
    pub name: &'static str,
    /// What it does, in a few words.
    pub help: &'static str,
    /// Its documentation.
    pub docs: String,
    /// Its options.
    pub options: Vec<StepOption>,
    /// Whether it takes a second motion, which is no option here.
    pub takes_other: bool,
    /// Whether it depends on which joints are which bones.
    pub takes_bones: bool,
}

/// An option of a step.
#[derive(Clone, Debug)]
pub struct StepOption {
    /// Its name.
    pub name: String,
    /// Its documentation.
    pub docs: String,
    /// What it takes.
    pub takes: ValueKind,
    /// Whether it must be given.
    pub is_required: bool,
    /// What it has where it is not given.
    pub default: Option<Value>,
}

impl Model {
    /// The model of the library that is linked.
    ///
    /// # Panics
    /// Where the schema of jobs has a form that is not known here.
    pub fn new() -> Self {
        let schema: Value = serde_json::from_str(&Job::schema()).expect("the schema is JSON");
        let definitions = schema["$defs"].as_object().expect("the schema has definitions");
        let definitions = definitions.iter().map(|(name, value)| definition(name, value));
        let mut model = Self {
            definitions: definitions.collect(),
            steps: EditStep::ALL
                .iter()
                .zip(EditStep::DOCS)
                .map(|(step, docs)| self::step(step, docs))
                .collect(),
            formats: FormatInfo::ALL,
        };
        for (kind, job) in [
            ("MotionJob", json!({})),
            ("SurveyJob", json!({"survey": {}})),
            ("GraphJob", json!({"graph": {}})),
            ("WalkJob", json!({"walk": {}})),
        ] {
            model.find_defaults(kind, &job, &[]);
        }
        model
    }

    /// The definition of a name.
    ///
    /// # Panics
    /// Where there is none.
    pub fn definition(&self, name: &str) -> &Definition {
        let found = self.definitions.iter().find(|definition| definition.name == name);
        found.unwrap_or_else(|| panic!("no definition is called {name}"))
    }

    /// The fields of a record.
    ///
    /// # Panics
    /// Where the definition is no record.
    pub fn fields(&self, name: &str) -> &[Field] {
        match &self.definition(name).shape {
            Shape::Record(fields) => fields,
            shape => panic!("{name} is no record but {shape:?}"),
        }
    }

    /// The words of a type, where it is one of words, under its own name or another.
    pub fn words(&self, kind: &Kind) -> Option<&[Word]> {
        match kind {
            Kind::Named(name) => match &self.definition(name).shape {
                Shape::Words(words) => Some(words),
                Shape::Alias(kind) => self.words(kind),
                Shape::Record(_) => None,
            },
            _ => None,
        }
    }

    /// Sets the defaults of the record `name`, which stands at `path` of a job, and of those in it. A value that a job
    /// has no longer when it is read and written again is the default.
    fn find_defaults(&mut self, name: &str, job: &Value, path: &[String]) {
        for (at, field) in self.fields(name).to_vec().into_iter().enumerate() {
            let below = [path, std::slice::from_ref(&field.name)].concat();
            if let Kind::Named(kind) = &field.kind {
                match &self.definition(kind).shape {
                    Shape::Record(_) => self.find_defaults(&kind.clone(), job, &below),
                    Shape::Alias(Kind::OneOf(kinds)) => {
                        for kind in kinds.clone() {
                            if let Kind::Tagged(tag, kind) = kind
                                && let Kind::Named(kind) = *kind
                            {
                                self.find_defaults(&kind, job, &[&below[..], &[tag]].concat());
                            }
                        }
                    }
                    _ => {}
                }
            }
            if field.default.is_some() || field.is_nullable {
                continue;
            }
            let candidates: Vec<Value> = match (&field.kind, self.words(&field.kind)) {
                (Kind::Flag, _) => vec![json!(false), json!(true)],
                (_, Some(words)) => words.iter().map(|word| json!(word.word)).collect(),
                _ => continue,
            };
            let default = candidates.into_iter().find(|value| is_default(job, &below, value));
            let definition = self.definitions.iter_mut().find(|definition| definition.name == name);
            if let Some(Shape::Record(fields)) = definition.map(|definition| &mut definition.shape) {
                fields[at].default = default;
            }
        }
    }
}

impl Default for Model {
    fn default() -> Self {
        Self::new()
    }
}

/// Whether a job with a value at a path is written without it.
fn is_default(job: &Value, path: &[String], value: &Value) -> bool {
    let mut given = job.clone();
    let mut here = &mut given;
    for name in path {
        if here.is_null() {
            *here = json!({});
        }
        here = &mut here[name.as_str()];
    }
    *here = value.clone();
    let read = Job::from_json(&given.to_string()).unwrap_or_else(|error| panic!("{given}: {error}"));
    let written = serde_json::to_value(read).expect("a job is JSON");
    written.pointer(&format!("/{}", path.join("/"))).is_none()
}

fn definition(name: &str, value: &Value) -> Definition {
    let shape = match (words(value), value["properties"].as_object()) {
        (Some(words), _) => Shape::Words(words),
        (None, Some(properties)) => {
            let required = value["required"].as_array();
            let is_required = |name: &str| required.is_some_and(|names| names.iter().any(|own| own == name));
            let fields = properties
                .iter()
                .map(|(name, value)| field(name, value, is_required(name)));
            Shape::Record(fields.collect())
        }
        (None, None) if name == "Steps" => Shape::Alias(Kind::List(Box::new(Kind::Step))),
        (None, None) => Shape::Alias(kind(value).0),
    };
    Definition {
        name: name.to_owned(),
        docs: docs_of(value),
        shape,
    }
}

fn field(name: &str, value: &Value, is_required: bool) -> Field {
    let (kind, is_nullable) = kind(value);
    Field {
        name: name.to_owned(),
        docs: docs_of(value),
        kind,
        is_nullable,
        is_required,
        default: value.get("default").cloned(),
    }
}

fn docs_of(value: &Value) -> String {
    sentences(value["description"].as_str().unwrap_or_default())
}

/// The words of a type that takes nothing else.
fn words(value: &Value) -> Option<Vec<Word>> {
    if let Some(words) = value["enum"].as_array() {
        let word = |word: &Value| {
            Some(Word {
                word: word.as_str()?.to_owned(),
                docs: String::new(),
            })
        };
        return words.iter().map(word).collect();
    }
    let word = |value: &Value| {
        Some(Word {
            word: value["const"].as_str()?.to_owned(),
            docs: docs_of(value),
        })
    };
    value["oneOf"].as_array()?.iter().map(word).collect()
}

/// The type of a schema, and whether it may be `null`.
fn kind(value: &Value) -> (Kind, bool) {
    if let Some(name) = value["$ref"].as_str() {
        let name = name.rsplit('/').next().unwrap_or_default();
        return (Kind::Named(name.to_owned()), false);
    }
    if let Some(of) = value["anyOf"].as_array().or(value["oneOf"].as_array()) {
        let is_null = |value: &&Value| value["type"] == "null";
        let kinds = of.iter().filter(|value| !is_null(value)).map(|value| kind(value).0);
        return (one_of(kinds.collect()), of.iter().any(|value| is_null(&value)));
    }
    match &value["type"] {
        Value::String(name) => (kind_of_type(name, value), false),
        Value::Array(names) => {
            let names: Vec<&str> = names.iter().filter_map(Value::as_str).collect();
            let others = names.iter().filter(|name| **name != "null");
            let kinds = others.map(|name| kind_of_type(name, value)).collect();
            (one_of(kinds), names.contains(&"null"))
        }
        _ => panic!("a schema of an unknown form: {value}"),
    }
}

fn one_of(mut kinds: Vec<Kind>) -> Kind {
    match kinds.len() {
        1 => kinds.remove(0),
        _ => Kind::OneOf(kinds),
    }
}

fn kind_of_type(name: &str, value: &Value) -> Kind {
    match name {
        "boolean" => Kind::Flag,
        "integer" => Kind::Integer,
        "number" => Kind::Number,
        "string" => Kind::Text,
        "array" => {
            let item = Box::new(kind(&value["items"]).0);
            match (value["minItems"].as_u64(), value["maxItems"].as_u64()) {
                (Some(least), Some(most)) if least == most => Kind::Tuple(item, least as usize),
                _ => Kind::List(item),
            }
        }
        "object" => {
            let properties = value["properties"].as_object().into_iter().flat_map(Map::iter);
            match properties.last() {
                Some((tag, value)) => Kind::Tagged(tag.clone(), Box::new(kind(value).0)),
                None => Kind::Map(Box::new(kind(&value["additionalProperties"]).0)),
            }
        }
        _ => panic!("a schema of an unknown type {name}: {value}"),
    }
}

fn step(step: &mocap::edit::StepInfo, docs: &mocap::edit::StepDocs) -> Step {
    // A warp has no default: its options exclude each other.
    let defaults = EditStep::from_value(&json!({"step": step.name}));
    let defaults = defaults.map_or(Value::Null, |step| serde_json::to_value(step).expect("a step is JSON"));
    let options = step
        .keys
        .iter()
        .zip(docs.keys)
        .filter(|(key, _)| key.takes != ValueKind::Input);
    let option = |(key, docs): (&mocap::edit::StepKey, &&str)| StepOption {
        name: key.name(),
        docs: sentences(docs),
        takes: key.takes,
        is_required: docs.contains("It must be given."),
        default: defaults.get(key.name()).cloned(),
    };
    Step {
        name: step.name,
        help: step.help,
        docs: sentences(docs.step),
        options: options.map(option).collect(),
        takes_other: step.takes_other,
        takes_bones: step.takes_bones,
    }
}
