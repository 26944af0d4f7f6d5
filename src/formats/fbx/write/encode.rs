//! Encodes the tree of elements: a header, elements that begin with the offset of their end, and a footer.
//!
//! The crate `fbxcel` also writes such trees, but compresses the times of each curve again. The times are more than
//! half of a file, and equal for all curves.

use std::borrow::Cow;
use std::rc::Rc;

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::files::FBX_HEAD;
use zlib_rs::{DeflateConfig, ReturnCode, compress_bound, compress_slice};

use super::FbxVersion;
use crate::fbx::FOOTER_END;

/// An array of fewer bytes is not compressed.
const COMPRESSED_FROM: usize = 128;

/// The compression level of zlib. For the numbers of keys, higher levels take much longer and save little.
const LEVEL: i32 = 6;

/// The id of a file, its time of creation and the start of its footer must match. All files share these constants, so
/// that equal scenes give equal bytes.
const FILE_ID: [u8; 16] = [
    0x28, 0xb3, 0x2a, 0xeb, 0xb6, 0x24, 0xcc, 0xc2, 0xbf, 0xc8, 0xb0, 0x2a, 0xa9, 0x2b, 0xfc, 0xf1,
];
const CREATION_TIME: &str = "1970-01-01 10:00:00:000";
const FOOTER_ID: [u8; 16] = [
    0xfa, 0xbc, 0xab, 0x09, 0xd0, 0xc8, 0xd4, 0x66, 0xb1, 0x76, 0xfb, 0x83, 0x1c, 0xf7, 0x26, 0x7e,
];
/// An element of the tree.
pub(super) struct Element<'a> {
    name: &'a str,
    values: Vec<Value<'a>>,
    children: Vec<Element<'a>>,
    /// Whether to write the list of children even if it is empty.
    is_block: bool,
}

/// A value of an element.
pub(super) enum Value<'a> {
    Bool(bool),
    /// A choice that is a letter.
    Letter(u8),
    Short(i16),
    Int(i32),
    Long(i64),
    Double(f64),
    Text(Cow<'a, str>),
    Bytes(Cow<'a, [u8]>),
    Array(Array),
    /// Values copied from the original file: their number, and their bytes.
    Read(usize, &'a [u8]),
}

/// Encoded numbers, which elements can share.
#[derive(Clone)]
pub(super) struct Array {
    code: u8,
    count: usize,
    is_compressed: bool,
    bytes: Rc<[u8]>,
}

impl Array {
    pub(super) fn doubles(values: impl IntoIterator<Item = f64>) -> Self {
        Self::new(b'd', values.into_iter().map(f64::to_le_bytes))
    }

    pub(super) fn floats(values: impl IntoIterator<Item = f32>) -> Self {
        Self::new(b'f', values.into_iter().map(f32::to_le_bytes))
    }

    pub(super) fn longs(values: impl IntoIterator<Item = i64>) -> Self {
        Self::new(b'l', values.into_iter().map(i64::to_le_bytes))
    }

    pub(super) fn ints(values: impl IntoIterator<Item = i32>) -> Self {
        Self::new(b'i', values.into_iter().map(i32::to_le_bytes))
    }

    fn new<const SIZE: usize>(code: u8, values: impl Iterator<Item = [u8; SIZE]>) -> Self {
        let plain: Vec<u8> = values.flatten().collect();
        let count = plain.len() / SIZE;
        let compressed = (plain.len() >= COMPRESSED_FROM).then(|| compressed(&plain));
        let compressed = compressed.flatten().filter(|compressed| compressed.len() < plain.len());
        Self {
            code,
            count,
            is_compressed: compressed.is_some(),
            bytes: compressed.unwrap_or(plain).into(),
        }
    }
}

/// A zlib stream; `None` if the input is too large for one call of the encoder.
fn compressed(plain: &[u8]) -> Option<Vec<u8>> {
    let mut stream = vec![0; compress_bound(plain.len())];
    let (written, code) = compress_slice(&mut stream, plain, DeflateConfig::new(LEVEL));
    let length = written.len();
    stream.truncate(length);
    (code == ReturnCode::Ok).then_some(stream)
}

impl From<bool> for Value<'_> {
    fn from(value: bool) -> Self {
        Self::Bool(value)
    }
}

impl From<i32> for Value<'_> {
    fn from(value: i32) -> Self {
        Self::Int(value)
    }
}

impl From<i64> for Value<'_> {
    fn from(value: i64) -> Self {
        Self::Long(value)
    }
}

impl From<f64> for Value<'_> {
    fn from(value: f64) -> Self {
        Self::Double(value)
    }
}

impl<'a> From<&'a str> for Value<'a> {
    fn from(value: &'a str) -> Self {
        Self::Text(value.into())
    }
}

impl From<String> for Value<'_> {
    fn from(value: String) -> Self {
        Self::Text(value.into())
    }
}

impl<'a> From<&'a [u8]> for Value<'a> {
    fn from(value: &'a [u8]) -> Self {
        Self::Bytes(value.into())
    }
}

impl From<Array> for Value<'_> {
    fn from(value: Array) -> Self {
        Self::Array(value)
    }
}

impl<'a> Element<'a> {
    pub(super) fn new(name: &'a str) -> Self {
        Self {
            name,
            values: Vec::new(),
            children: Vec::new(),
            is_block: false,
        }
    }

    pub(super) fn name(&self) -> &'a str {
        self.name
    }

    /// An element of the original file, with the number and the bytes of its values.
    pub(super) fn of_bytes(
        name: &'a str,
        (count, values): (usize, &'a [u8]),
        children: Vec<Element<'a>>,
        is_block: bool,
    ) -> Self {
        Self {
            name,
            values: vec![Value::Read(count, values)],
            children,
            is_block,
        }
    }

    /// An element with one value.
    pub(super) fn of(name: &'static str, value: impl Into<Value<'a>>) -> Self {
        Self::new(name).with(value)
    }

    pub(super) fn with(mut self, value: impl Into<Value<'a>>) -> Self {
        self.values.push(value.into());
        self
    }

    pub(super) fn child(mut self, child: Element<'a>) -> Self {
        self.children.push(child);
        self
    }

    pub(super) fn children(mut self, children: impl IntoIterator<Item = Element<'a>>) -> Self {
        self.children.extend(children);
        self
    }

    /// Writes the list of children even if it is empty.
    pub(super) fn block(mut self) -> Self {
        self.is_block = true;
        self
    }
}

/// The original file with these sections. Keeps the version and the start of the footer.
///
/// # Errors
/// [`Code::LimitExceeded`] if the file is too large for its version.
pub(super) fn kept(sections: Vec<Element<'_>>, version: u32, footer: &[u8]) -> Result<Vec<u8>> {
    let mut writer = Writer::new(version);
    sections.iter().try_for_each(|section| writer.element(section))?;
    Ok(writer.finish(version, footer))
}

/// The file with these sections, the first of which is the header extension.
///
/// # Errors
/// [`Code::LimitExceeded`] if the file is too large for its version.
pub(super) fn file(sections: Vec<Element<'_>>, version: FbxVersion, creator: &str) -> Result<Vec<u8>> {
    let mut sections = sections.into_iter();
    let first = sections.next().into_iter();
    let about = [
        Element::of("FileId", &FILE_ID[..]),
        Element::of("CreationTime", CREATION_TIME),
        Element::of("Creator", creator),
    ];
    let mut writer = Writer::new(version.number());
    for element in first.chain(about).chain(sections) {
        writer.element(&element)?;
    }
    Ok(writer.finish(version.number(), &FOOTER_ID))
}

struct Writer {
    bytes: Vec<u8>,
    /// Whether offsets have 8 bytes instead of 4.
    is_wide: bool,
}

impl Writer {
    fn new(version: u32) -> Self {
        let mut bytes = [FBX_HEAD, b"  \0\x1a\0"].concat();
        bytes.extend_from_slice(&version.to_le_bytes());
        Self {
            bytes,
            is_wide: version >= FbxVersion::V7500.number(),
        }
    }

    /// Ends the list of sections, and adds the footer.
    fn finish(mut self, version: u32, footer: &[u8]) -> Vec<u8> {
        self.end_of_list();
        self.bytes.extend_from_slice(footer);
        self.bytes.extend_from_slice(&[0; 4]);
        // Pad to the next multiple of 16, with 1 to 16 bytes.
        let padding = 16 - self.bytes.len() % 16;
        self.bytes.resize(self.bytes.len() + padding, 0);
        self.bytes.extend_from_slice(&version.to_le_bytes());
        self.bytes.resize(self.bytes.len() + 120, 0);
        self.bytes.extend_from_slice(&FOOTER_END);
        self.bytes
    }

    fn element(&mut self, element: &Element<'_>) -> Result<()> {
        let start = self.bytes.len();
        let size = self.number_size();
        self.bytes.resize(start + 3 * size, 0);
        self.bytes.push(element.name.len() as u8);
        self.bytes.extend_from_slice(element.name.as_bytes());
        let values_start = self.bytes.len();
        for value in &element.values {
            self.value(value)?;
        }
        let values_length = self.bytes.len() - values_start;
        for child in &element.children {
            self.element(child)?;
        }
        let count = |value: &Value<'_>| match value {
            Value::Read(count, _) => *count,
            _ => 1,
        };
        let count: usize = element.values.iter().map(count).sum();
        // Only the end marker distinguishes an empty list of children from no list.
        if !element.children.is_empty() || count == 0 || element.is_block {
            self.end_of_list();
        }
        let end = self.bytes.len();
        self.number(start, end)?;
        self.number(start + size, count)?;
        self.number(start + 2 * size, values_length)
    }

    fn end_of_list(&mut self) {
        let length = 3 * self.number_size() + 1;
        self.bytes.resize(self.bytes.len() + length, 0);
    }

    fn number_size(&self) -> usize {
        if self.is_wide { 8 } else { 4 }
    }

    fn number(&mut self, at: usize, number: usize) -> Result<()> {
        let size = self.number_size();
        if !self.is_wide && u32::try_from(number).is_err() {
            return Err(too_large("FBX 7.4 has files of at most 4 GiB; write FBX 7.5"));
        }
        self.bytes[at..at + size].copy_from_slice(&(number as u64).to_le_bytes()[..size]);
        Ok(())
    }

    fn length(&mut self, length: usize) -> Result<()> {
        let length = u32::try_from(length).map_err(|_| too_large("a string or an image has more than 4 GiB"))?;
        self.bytes.extend_from_slice(&length.to_le_bytes());
        Ok(())
    }

    fn value(&mut self, value: &Value<'_>) -> Result<()> {
        match value {
            Value::Bool(value) => self.bytes.extend_from_slice(&[b'C', u8::from(*value)]),
            Value::Letter(letter) => self.bytes.extend_from_slice(&[b'C', *letter]),
            Value::Short(value) => {
                self.bytes.push(b'Y');
                self.bytes.extend_from_slice(&value.to_le_bytes());
            }
            Value::Int(value) => {
                self.bytes.push(b'I');
                self.bytes.extend_from_slice(&value.to_le_bytes());
            }
            Value::Long(value) => {
                self.bytes.push(b'L');
                self.bytes.extend_from_slice(&value.to_le_bytes());
            }
            Value::Double(value) => {
                self.bytes.push(b'D');
                self.bytes.extend_from_slice(&value.to_le_bytes());
            }
            Value::Text(text) => {
                self.bytes.push(b'S');
                self.length(text.len())?;
                self.bytes.extend_from_slice(text.as_bytes());
            }
            Value::Bytes(bytes) => {
                self.bytes.push(b'R');
                self.length(bytes.len())?;
                self.bytes.extend_from_slice(bytes);
            }
            Value::Array(array) => {
                self.bytes.push(array.code);
                self.length(array.count)?;
                self.bytes
                    .extend_from_slice(&u32::from(array.is_compressed).to_le_bytes());
                self.length(array.bytes.len())?;
                self.bytes.extend_from_slice(&array.bytes);
            }
            Value::Read(_, bytes) => self.bytes.extend_from_slice(bytes),
        }
        Ok(())
    }
}

fn too_large(message: &str) -> mocap_scene::error::Error {
    Diagnostic::new(Code::LimitExceeded, message).into()
}
