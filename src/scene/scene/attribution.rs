//! The origin and licence of a motion, and the file `mocap.toml` that states both for a folder.

use serde::{Deserialize, Serialize};

use crate::error::{Code, Diagnostic, Location, nearest};

/// The origin and licence of a motion, as the file or a `mocap.toml` in its folder states them.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Attribution {
    /// The licence, preferably its SPDX identifier, such as `CC-BY-4.0`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub licence: Option<String>,
    /// The dataset, or the address of the source.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// The person who moves. Any name works if all clips of the person share it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub person: Option<String>,
    /// Whether a program generated the motion.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub synthetic: Option<bool>,
}

impl Attribution {
    /// Whether no field is set.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Copies the fields that are not set here from `other`.
    pub fn complete(&mut self, other: Self) {
        self.licence = self.licence.take().or(other.licence);
        self.source = self.source.take().or(other.source);
        self.person = self.person.take().or(other.person);
        self.synthetic = self.synthetic.or(other.synthetic);
    }

    /// The values that the text of a `mocap.toml` states for a file with this name. Keys at the beginning apply to all
    /// files. Keys of a table `[files."walk_*"]` apply to files whose names match the pattern. The last table that
    /// matches wins.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] with the line, for an unknown key, and for a value of the wrong type. `synthetic` is a
    /// boolean, and other keys are text.
    #[doc(hidden)]
    #[allow(
        clippy::result_large_err,
        reason = "the caller turns the diagnostic into an `Error`, which boxes it"
    )]
    pub fn from_toml(text: &str, name: &str) -> Result<Self, Diagnostic> {
        let mut found = Self::default();
        let mut matches = true;
        for (index, content) in text.lines().enumerate() {
            let refused = |expected: &str, found: &str| {
                Diagnostic::new(Code::InvalidValue, "this is no line of a mocap.toml")
                    .at(in_line(index, found))
                    .expected_found(expected, format!("\"{found}\""))
            };
            let content = content.trim();
            if content.is_empty() || content.starts_with('#') {
                continue;
            }
            if content.starts_with('[') {
                let pattern = pattern_of(content).ok_or_else(|| refused("[files.\"PATTERN\"]", content))?;
                matches = is_match(&pattern, name);
                continue;
            }
            let expected = "licence, source or person = \"TEXT\", or synthetic = true or false";
            let (key, after) = content.split_once('=').ok_or_else(|| refused(expected, content))?;
            let stated = value(after.trim_start()).filter(|(_, rest)| is_end(Some(*rest)));
            let (stated, _) = stated.ok_or_else(|| refused(expected, content))?;
            let mut own = Self::default();
            match (key.trim(), stated) {
                ("licence", Value::Text(text)) => own.licence = Some(text),
                ("source", Value::Text(text)) => own.source = Some(text),
                ("person", Value::Text(text)) => own.person = Some(text),
                ("synthetic", Value::Flag(flag)) => own.synthetic = Some(flag),
                (key, _) => {
                    let known = nearest(key, ["licence", "source", "person", "synthetic"].into_iter());
                    let help = known.map(|known| format!("did you mean {known}?"));
                    let error = refused(expected, content);
                    return Err(match help.filter(|_| known != Some(key)) {
                        Some(help) => error.help(help),
                        None => error,
                    });
                }
            }
            if matches {
                own.complete(std::mem::take(&mut found));
                found = own;
            }
        }
        Ok(found)
    }

    /// A warning for each pattern of the text of a `mocap.toml` that matches none of these file names.
    #[doc(hidden)]
    pub fn unmatched_patterns(text: &str, names: &[String]) -> Vec<Diagnostic> {
        let patterns = text.lines().enumerate().filter_map(|(index, content)| {
            let content = content.trim();
            let pattern = pattern_of(content).filter(|pattern| !names.iter().any(|name| is_match(pattern, name)))?;
            let message = format!("no file has a name that matches \"{pattern}\"");
            let warning = Diagnostic::new(Code::InvalidValue, message).at(in_line(index, content));
            // The beginning of a name is compared with a pattern that ends in a star.
            let beginning = |name: &String| match pattern.strip_suffix('*') {
                Some(start) => name.chars().take(start.chars().count()).collect(),
                None => name.clone(),
            };
            let beginnings: Vec<String> = names.iter().map(beginning).collect();
            let near = nearest(pattern.trim_end_matches('*'), beginnings.iter().map(String::as_str));
            let name = near.and_then(|near| names.iter().find(|name| name.starts_with(near)));
            Some(match name {
                Some(name) => warning.help(format!("the nearest name is {name}")),
                None => warning.help("patterns match the names of files, with extension and without folders"),
            })
        });
        patterns.collect()
    }
}

/// The place of a line of a `mocap.toml`, by its index.
fn in_line(index: usize, text: &str) -> Location {
    Location {
        line: index + 1,
        column: 1,
        length: text.chars().count().max(1),
        text: text.to_owned(),
        text_column: 1,
    }
}

/// The pattern of a line `[files."PATTERN"]`.
fn pattern_of(content: &str) -> Option<String> {
    let (value, rest) = value(content.strip_prefix("[files.")?)?;
    is_end(rest.strip_prefix(']')).then(|| value.text())?
}

/// A TOML value of a supported type.
enum Value {
    Text(String),
    Flag(bool),
}

impl Value {
    fn text(self) -> Option<String> {
        match self {
            Self::Text(text) => Some(text),
            Self::Flag(_) => None,
        }
    }
}

/// The value at the beginning of a string, and the remaining text.
fn value(text: &str) -> Option<(Value, &str)> {
    for (word, flag) in [("true", true), ("false", false)] {
        if let Some(rest) = text.strip_prefix(word) {
            return Some((Value::Flag(flag), rest));
        }
    }
    if let Some(rest) = text.strip_prefix('\'') {
        let (text, rest) = rest.split_once('\'')?;
        return Some((Value::Text(text.to_owned()), rest));
    }
    // A basic string has the escapes of JSON.
    let mut stream = serde_json::Deserializer::from_str(text.starts_with('"').then_some(text)?).into_iter::<String>();
    let found = stream.next()?.ok()?;
    Some((Value::Text(found), &text[stream.byte_offset()..]))
}

/// Whether the rest of a line is empty or a comment.
fn is_end(rest: Option<&str>) -> bool {
    rest.map(str::trim_start)
        .is_some_and(|rest| rest.is_empty() || rest.starts_with('#'))
}

/// Whether a name matches a pattern, in which `*` stands for any text.
fn is_match(pattern: &str, name: &str) -> bool {
    let mut parts = pattern.split('*');
    let Some(mut rest) = parts.next().and_then(|first| name.strip_prefix(first)) else {
        return false;
    };
    let mut parts: Vec<&str> = parts.collect();
    let Some(last) = parts.pop() else {
        return rest.is_empty();
    };
    for part in parts {
        let Some((_, after)) = rest.split_once(part) else {
            return false;
        };
        rest = after;
    }
    rest.ends_with(last)
}
