//! The JSON text of a document, without what a reader assumes anyway: all samplers are linear, and whole numbers have
//! no decimals.

use std::io::{self, Write};

use gltf_json::accessor::Accessor;
use gltf_json::{Index, Node, Root};
use serde::Serialize;
use serde_json::Value;
use serde_json::ser::{CompactFormatter, Formatter, Serializer};

/// An animation.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Animation {
    #[serde(skip_serializing_if = "Option::is_none")]
    #[doc(hidden)]
    pub name: Option<String>,
    pub(super) channels: Vec<Channel>,
    pub(super) samplers: Vec<Sampler>,
    /// Where it is from, if the file does not say that of all animations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) extras: Option<Value>,
}

impl Animation {
    /// Without channels.
    pub(super) fn empty() -> Self {
        Self {
            name: None,
            channels: Vec::new(),
            samplers: Vec::new(),
            extras: None,
        }
    }
}

/// Times and values. The interpolation is glTF's default, `LINEAR`.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Sampler {
    pub(super) input: Index<Accessor>,
    pub(super) output: Index<Accessor>,
}

/// What a sampler drives.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Channel {
    /// The index of the sampler.
    pub(super) sampler: usize,
    pub(super) target: Target,
}

/// A property of a node.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Target {
    pub(super) node: Index<Node>,
    /// `translation`, `rotation`, `scale` or `weights`.
    pub(super) path: &'static str,
}

/// All of a document.
#[derive(Serialize)]
struct Whole<'a> {
    #[serde(flatten)]
    root: &'a Root,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    animations: &'a [Animation],
}

/// The text of an item of an array, for a file that is there already.
///
/// # Errors
/// None is known for what this crate makes.
pub(super) fn item(item: &impl Serialize) -> serde_json::Result<String> {
    let mut text = Vec::new();
    item.serialize(&mut Serializer::with_formatter(&mut text, ShortNumbers::default()))?;
    Ok(String::from_utf8(text).expect("JSON is UTF-8"))
}

/// The text of `root`, which has no animations of its own, with `animations`.
///
/// # Errors
/// None is known for a document of this crate.
pub(super) fn write(root: &Root, animations: &[Animation]) -> serde_json::Result<Vec<u8>> {
    let mut text = Vec::new();
    let mut serializer = Serializer::with_formatter(&mut text, ShortNumbers::default());
    Whole { root, animations }.serialize(&mut serializer)?;
    Ok(text)
}

/// JSON without spaces, in which a float that is a whole number is written as one: `0` and not `0.0`.
#[derive(Default)]
struct ShortNumbers {
    /// The number that is written.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_value() {
        let numbers = [
            0.0,
            -0.0,
            1.0,
            -20.0,
            0.5,
            1e-7,
            0.1,
            16_777_216.0,
            1e20,
            f32::MIN_POSITIVE,
            f32::MAX,
        ];
        let mut text = Vec::new();
        let mut serializer = Serializer::with_formatter(&mut text, ShortNumbers::default());
        numbers.serialize(&mut serializer).unwrap();
        let text = String::from_utf8(text).unwrap();
        assert!(text.starts_with("[0,-0,1,-20,0.5,1e-7,0.1,16777216,"), "{text}");
        let read: Vec<f32> = serde_json::from_str(&text).unwrap();
        assert_eq!(
            read.iter().map(|n| n.to_bits()).collect::<Vec<_>>(),
            numbers.map(f32::to_bits)
        );
    }

    #[test]
    fn only_what_differs_from_the_default_is_written() {
        let animation = Animation {
            name: None,
            channels: vec![Channel {
                sampler: 0,
                target: Target {
                    node: Index::new(3),
                    path: "rotation",
                },
            }],
            samplers: vec![Sampler {
                input: Index::new(1),
                output: Index::new(2),
            }],
            extras: None,
        };
        let text = write(&Root::default(), std::slice::from_ref(&animation)).unwrap();
        let text = String::from_utf8(text).unwrap();
        let expected = r#""animations":[{"channels":[{"sampler":0,"target":{"node":3,"path":"rotation"}}],"samplers":[{"input":1,"output":2}]}]}"#;
        assert!(text.ends_with(expected), "{text}");
        let text = String::from_utf8(write(&Root::default(), &[]).unwrap()).unwrap();
        assert!(!text.contains("animations"), "{text}");
    }
}
