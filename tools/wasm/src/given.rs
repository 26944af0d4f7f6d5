//! Converts the options of a call to records of the library's jobs.

use mocap::{Code, Diagnostic, Error};
use serde::de::value::Error as Refusal;
use serde::de::{DeserializeOwned, Error as _, Visitor};
use serde::{Deserializer, forward_to_deserialize_any};
use serde_json::{Map, Value};

use crate::failure::Failure;
use crate::names;

/// The options that a function of the package received. Each record takes its options from them.
pub(crate) struct Given {
    function: &'static str,
    values: Map<String, Value>,
    /// The options of all records so far, by their names in the package.
    known: Vec<String>,
}

/// An option that the caller set.
struct Stated {
    /// The name in the package.
    name: String,
    /// The name in the record.
    field: &'static str,
    value: Value,
}

impl Given {
    pub(crate) fn new(function: &'static str, options: Value) -> Result<Self, Failure> {
        let mut values = match options {
            Value::Null => Map::new(),
            Value::Object(values) => values,
            _ => {
                return Err(Failure::argument(format!(
                    "the options of {function} are not an object"
                )));
            }
        };
        values.retain(|_, value| !value.is_null());
        Ok(Self {
            function,
            values,
            known: Vec::new(),
        })
    }

    pub(crate) fn get(&self, name: &str) -> Option<&Value> {
        self.values.get(name)
    }

    /// Whether an option is set to anything but `false`. `name` is the option's name in a job.
    pub(crate) fn states(&self, name: &str) -> bool {
        let value = self.values.get(&names::spelling(name));
        value.is_some_and(|value| *value != Value::Bool(false))
    }

    /// Takes the options of a record. Absent options have their defaults.
    pub(crate) fn take<T: DeserializeOwned>(&mut self) -> Result<T, Failure> {
        let mut record = Record::default();
        // Deserialization lists the fields of the record, and then fails because it finds no values.
        let _ = T::deserialize(&mut record);
        let stated = self.stated(&record);
        let values = stated.iter().map(|stated| (stated.field, record.value(stated)));
        T::deserialize(object(values)).map_err(|error| {
            // Test the values one by one to find the invalid one.
            let refuses = |field: &str, value: Value| T::deserialize(object([(field, value)])).err();
            let wrong = stated.iter().find_map(|stated| {
                let error = refuses(stated.field, record.value(stated))?;
                let inner = stated.value.as_object().into_iter().flatten();
                let mut wrong = inner.filter_map(|(key, value)| {
                    let error = refuses(stated.field, object([(key.as_str(), value.clone())]))?;
                    Some((format!("{}.{key}", stated.name), error))
                });
                let (path, error) = wrong.next().unwrap_or_else(|| (stated.name.clone(), error));
                Some(self.refused(&record, stated, &path, &error.to_string()))
            });
            wrong.unwrap_or_else(|| Failure::argument(error.to_string()))
        })
    }

    /// The options of a record that the caller set.
    fn stated(&mut self, record: &Record) -> Vec<Stated> {
        let mut stated = Vec::new();
        for &field in record.fields {
            if let Some(name) = names::option(record.name, field) {
                self.known.push(name.clone());
                if let Some(value) = self.values.remove(&name) {
                    stated.push(Stated { name, field, value });
                }
            }
        }
        stated
    }

    /// Fails if options remain that no record has.
    pub(crate) fn end(self) -> Result<(), Failure> {
        let Some(name) = self.values.keys().next() else {
            return Ok(());
        };
        let message = format!("{name} is not an option of {}", self.function);
        let help = format!("its options are {}", self.known.join(", "));
        Err(Error::from(Diagnostic::new(Code::UnknownOption, message).help(help)).into())
    }

    /// Rewrites an error of serde about an option in the terms of the package.
    fn refused(&self, record: &Record, stated: &Stated, path: &str, said: &str) -> Failure {
        let function = self.function;
        let listed = said
            .strip_prefix("unknown variant `")
            .and_then(|said| said.rsplit_once("expected "));
        let Some((variant, listed)) = listed else {
            let said = said.replace("f64", "a number").replace("usize", "a whole number");
            return Failure::argument(format!("{path} of {function}: {said}"));
        };
        let words = listed.split('`').skip(1).step_by(2);
        let words = words.filter_map(|word| names::word(record.name, stated.field, word));
        let words = words.collect::<Vec<_>>().join(", ");
        let given = stated.value.as_str().or(variant.split('`').next()).unwrap_or_default();
        Failure::argument(format!("{path} of {function} must be one of {words}, not {given}"))
    }
}

fn object<'a>(values: impl IntoIterator<Item = (&'a str, Value)>) -> Value {
    let values = values.into_iter().map(|(name, value)| (name.to_owned(), value));
    Value::Object(values.collect())
}

/// The name and the fields of a struct. As a deserializer without values, it only records the requested fields.
#[derive(Default)]
struct Record {
    name: &'static str,
    fields: &'static [&'static str],
}

impl Record {
    /// Converts a value to the words of a job. Words that only jobs have are rejected.
    fn value(&self, stated: &Stated) -> Value {
        match &stated.value {
            Value::String(word) => names::word_of_job(self.name, stated.field, word)
                .unwrap_or_default()
                .into(),
            value => value.clone(),
        }
    }
}

impl<'de> Deserializer<'de> for &mut Record {
    type Error = Refusal;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Refusal> {
        Err(Refusal::custom("no value"))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        _: V,
    ) -> Result<V::Value, Refusal> {
        (self.name, self.fields) = (name, fields);
        Err(Refusal::custom("no value"))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct
        newtype_struct seq tuple tuple_struct map enum identifier ignored_any
    }
}
