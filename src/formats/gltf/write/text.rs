//! The JSON text of a document, without defaults: all samplers are linear, and integers have no decimals.

use std::io::{self, Write};

use gltf_json::accessor::Accessor;
use gltf_json::{Index, Node, Root};
use serde::Serialize;
use serde_json::ser::{CompactFormatter, Formatter, Serializer};
use serde_json::{Value, json};

/// An animation.
#[derive(Clone, Debug, Serialize)]
pub struct Animation {
    #[serde(skip_serializing_if = "Option::is_none")]
    #[doc(hidden)]
    pub name: Option<String>,
    pub channels: Vec<Channel>,
    pub samplers: Vec<Sampler>,
    /// The extras of the clip, and the provenance if the file does not state it for all animations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extras: Option<Value>,
}

impl Animation {
    /// An animation without channels.
    pub(super) fn empty() -> Self {
        Self {
            name: None,
            channels: Vec::new(),
            samplers: Vec::new(),
            extras: None,
        }
    }

    /// Adds the extras of a clip and the provenance. Extras that are not an object get the key `extras`.
    pub(super) fn set_extras(&mut self, own: Option<Value>, provenance: Option<Value>) {
        self.extras = match (own, provenance) {
            (own, None) => own,
            (Some(Value::Object(mut members)), Some(provenance)) => {
                members.insert("mocap".to_owned(), provenance);
                Some(members.into())
            }
            (Some(other), Some(provenance)) => Some(json!({ "extras": other, "mocap": provenance })),
            (None, Some(provenance)) => Some(json!({ "mocap": provenance })),
        };
    }
}

/// Times and values. The interpolation is glTF's default, `LINEAR`.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Sampler {
    pub input: Index<Accessor>,
    pub output: Index<Accessor>,
}

/// Connects a sampler to the property that it animates.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Channel {
    /// The index of the sampler.
    pub sampler: usize,
    pub target: Target,
}

/// A property of a node.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Target {
    pub node: Index<Node>,
    /// `translation`, `rotation`, `scale` or `weights`.
    pub path: &'static str,
}

/// The whole document.
#[derive(Serialize)]
struct DocumentText<'a> {
    #[serde(flatten)]
    root: &'a Root,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    animations: &'a [Animation],
}

/// The text of an array item, for an existing file.
///
/// # Errors
/// No error is known for items of this crate.
pub(super) fn item(item: &impl Serialize) -> serde_json::Result<String> {
    let mut text = Vec::new();
    item.serialize(&mut Serializer::with_formatter(&mut text, ShortNumbers::default()))?;
    Ok(String::from_utf8(text).expect("JSON is UTF-8"))
}

/// The text of `root`, which has no animations, with `animations`.
///
/// # Errors
/// No error is known for a document of this crate.
pub fn write(root: &Root, animations: &[Animation]) -> serde_json::Result<Vec<u8>> {
    let mut text = Vec::new();
    let mut serializer = Serializer::with_formatter(&mut text, ShortNumbers::default());
    DocumentText { root, animations }.serialize(&mut serializer)?;
    Ok(text)
}

/// JSON without spaces. A float that is an integer is written as an integer: `0`, not `0.0`.
#[derive(Default)]
pub struct ShortNumbers {
    /// The text of the current number.
    number: Vec<u8>,
}

impl ShortNumbers {
    fn write_short<W: ?Sized + Write>(&self, writer: &mut W) -> io::Result<()> {
        writer.write_all(self.number.strip_suffix(b".0").unwrap_or(&self.number))
    }
}

impl Formatter for ShortNumbers {
    fn write_f32<W: ?Sized + Write>(&mut self, writer: &mut W, value: f32) -> io::Result<()> {
        self.number.clear();
        CompactFormatter.write_f32(&mut self.number, value)?;
        self.write_short(writer)
    }

    fn write_f64<W: ?Sized + Write>(&mut self, writer: &mut W, value: f64) -> io::Result<()> {
        self.number.clear();
        CompactFormatter.write_f64(&mut self.number, value)?;
        self.write_short(writer)
    }
}
