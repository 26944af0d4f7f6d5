//! The library's jobs, steps and formats as plain lists, from which each emitter writes its language.
//!
//! Names are in kebab case, as in a job. Documentation consists of sentences, with code between backquotes.

use mocap::FormatInfo;
use mocap::edit::{EditStep, ValueKind};
use mocap::job::Job;
use serde_json::{Map, Value, json};

use crate::docs::sentences;

/// The definitions of a job, the steps and the formats.
#[derive(Clone, Debug)]
pub struct Model {
    /// The types of jobs and of all their parts, in the order of their names.
    pub definitions: Vec<Definition>,
    /// The steps in the order of the help.
    pub steps: Vec<Step>,
    /// The formats in the order of detection.
    pub formats: &'static [FormatInfo],
}

/// A named type of a job.
#[derive(Clone, Debug)]
pub struct Definition {
    /// The name of the type.
    pub name: String,
    /// The documentation of the type.
    pub docs: String,
    /// The form of the type.
    pub shape: Shape,
}

/// The form of a type.
#[derive(Clone, Debug)]
pub enum Shape {
    /// An object with only these fields.
    Record(Vec<Field>),
    /// One of these words.
    Words(Vec<Word>),
    /// Another name for a type.
    Alias(Kind),
}

/// A word that an option accepts.
#[derive(Clone, Debug)]
pub struct Word {
    /// The text of the word.
    pub word: String,
    /// The meaning of the word.
    pub docs: String,
}

/// A field of a record.
#[derive(Clone, Debug)]
pub struct Field {
    /// The name of the field.
    pub name: String,
    /// The documentation of the field.
    pub docs: String,
    /// The type of the value.
    pub kind: Kind,
    /// Whether `null` is allowed, and means that the field is absent.
    pub is_nullable: bool,
    /// Whether the field is required.
    pub is_required: bool,
    /// The default, if the schema states it, or if it is a word or a boolean.
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
    /// A string, for example a path.
    Text,
    /// A definition with this name.
    Named(String),
    /// A list of values of one type.
    List(Box<Kind>),
    /// A list with this number of values of one type.
    Tuple(Box<Kind>, usize),
    /// An object with any names, and values of a type or `null`.
    Map(Box<Kind>),
    /// An object with a single name, which determines the type of its value.
    Tagged(String, Box<Kind>),
    /// A value of one of these types.
    OneOf(Vec<Kind>),
    /// A step: text, or an object with the step's name in `step`.
    Step,
}

/// A step of `mocap edit`.
#[derive(Clone, Debug)]
pub struct Step {
    /// The name of the step.
    pub name: &'static str,
    /// A few words about the step for the help.
    pub help: &'static str,
    /// The documentation of the step.
    pub docs: String,
    /// The options of the step.
    pub options: Vec<StepOption>,
    /// Whether the step takes a second motion, which is not in `options`.
    pub takes_other: bool,
    /// Whether the step depends on the map from joints to bones.
    pub takes_bones: bool,
}

/// An option of a step.
#[derive(Clone, Debug)]
pub struct StepOption {
    /// The name of the option.
    pub name: String,
    /// The documentation of the option.
    pub docs: String,
    /// The kind of value.
    pub takes: ValueKind,
    /// Whether the option is required.
    pub is_required: bool,
    /// The default of the option, if there is one.
    pub default: Option<Value>,
}

impl Model {
    /// The model of the linked library.
    ///
    /// # Panics
    /// Panics if the schema of jobs has an unknown form.
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

    /// The definition with this name.
    ///
    /// # Panics
    /// Panics if there is none.
    pub fn definition(&self, name: &str) -> &Definition {
        let found = self.definitions.iter().find(|definition| definition.name == name);
        found.unwrap_or_else(|| panic!("no definition is called {name}"))
    }

    /// The fields of a record.
    ///
    /// # Panics
    /// Panics if the definition is not a record.
    pub fn fields(&self, name: &str) -> &[Field] {
        match &self.definition(name).shape {
            Shape::Record(fields) => fields,
            shape => panic!("{name} is no record but {shape:?}"),
        }
    }

    /// The words of a type; `None` if it is not a type of words, directly or by an alias.
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

    /// Sets the defaults of the record `name` at `path` of a job, and of the records in it. The default of a field is
    /// the value that the library omits when it writes the job.
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

/// Whether the library omits a value at a path when it writes the job.
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

/// The words of a type, if its schema only allows words.
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

/// The type of a schema, and whether the schema allows `null`.
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
    // A warp has no defaults, because its options exclude each other.
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
