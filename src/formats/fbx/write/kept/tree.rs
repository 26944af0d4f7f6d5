//! The elements of a binary file. Their values stay encoded.

use super::super::encode::Element;

/// The deepest nesting of elements.
pub(super) const DEEPEST: usize = 64;

/// The size of the file header, in bytes: the magic and the version.
const HEADER: usize = 27;

/// The size of the id at the end of a file, in bytes. The id depends on the time of creation.
pub(super) const FOOTER_ID: usize = 16;

/// The first version whose offsets have 8 bytes.
const WIDE: u32 = 7500;

/// An element with the bytes of its values.
pub(super) struct RawElement<'a> {
    pub(super) name: &'a str,
    count: usize,
    values: &'a [u8],
    pub(super) children: Vec<RawElement<'a>>,
    is_block: bool,
}

/// The elements of a whole file.
pub(super) struct RawFile<'a> {
    pub(super) version: u32,
    pub(super) sections: Vec<RawElement<'a>>,
    pub(super) footer: &'a [u8],
}

/// A value that identifies an element.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum RawValue<'a> {
    Number(i64),
    Text(&'a [u8]),
    Other,
}

impl<'a> RawFile<'a> {
    /// Returns `None` if the bytes are not a binary file, or end too early.
    pub(super) fn parse(bytes: &'a [u8]) -> Option<Self> {
        let version = u32::from_le_bytes(*bytes.get(HEADER - 4..HEADER)?.first_chunk()?);
        let mut reader = Reader {
            bytes,
            at: HEADER,
            is_wide: version >= WIDE,
        };
        let mut sections = Vec::new();
        while let Some(section) = reader.element(0)? {
            sections.push(section);
        }
        Some(Self {
            version,
            sections,
            footer: bytes.get(reader.at..reader.at + FOOTER_ID)?,
        })
    }

    pub(super) fn section(&self, name: &str) -> Option<&RawElement<'a>> {
        self.sections.iter().find(|section| section.name == name)
    }
}

impl<'a> RawElement<'a> {
    /// The value at an index, if the value is an integer or a string.
    pub(super) fn value(&self, index: usize) -> Option<RawValue<'a>> {
        let mut rest = self.values;
        for place in 0..self.count {
            let (value, after) = value(rest)?;
            if place == index {
                return Some(value);
            }
            rest = after;
        }
        None
    }

    /// The id of the object.
    pub(super) fn id(&self) -> Option<i64> {
        match self.value(0)? {
            RawValue::Number(id) => Some(id),
            RawValue::Text(_) | RawValue::Other => None,
        }
    }

    pub(super) fn is_text(&self, index: usize, text: &str) -> bool {
        self.value(index) == Some(RawValue::Text(text.as_bytes()))
    }

    /// The element for writing, with other children.
    pub(super) fn with_children(&self, children: Vec<Element<'a>>) -> Element<'a> {
        Element::of_bytes(self.name, (self.count, self.values), children, self.is_block)
    }

    /// The element for writing. `edit` returns the replacement of a descendant, or `None` for an unchanged descendant.
    pub(super) fn edited(&self, edit: &dyn Fn(&Self) -> Option<Element<'a>>) -> Element<'a> {
        let children = self.children.iter();
        let children = children.map(|child| edit(child).unwrap_or_else(|| child.edited(edit)));
        self.with_children(children.collect())
    }

    /// The element for writing, unchanged.
    pub(super) fn unchanged(&self) -> Element<'a> {
        self.edited(&|_| None)
    }
}

/// The value at the beginning of the bytes, and the remaining bytes.
fn value(bytes: &[u8]) -> Option<(RawValue<'_>, &[u8])> {
    let (code, rest) = bytes.split_first()?;
    let number = |size: usize| {
        let (number, rest) = rest.split_at_checked(size)?;
        let mut wide = [if number.last()? & 0x80 == 0 { 0 } else { 0xff }; 8];
        wide[..size].copy_from_slice(number);
        Some((RawValue::Number(i64::from_le_bytes(wide)), rest))
    };
    let length = |at: usize| Some(u32::from_le_bytes(*rest.get(at..)?.first_chunk()?) as usize);
    match code {
        b'Y' => number(2),
        b'I' => number(4),
        b'L' => number(8),
        b'B' | b'C' => Some((RawValue::Other, rest.get(1..)?)),
        b'F' => Some((RawValue::Other, rest.get(4..)?)),
        b'D' => Some((RawValue::Other, rest.get(8..)?)),
        b'S' | b'R' => {
            let (text, rest) = rest.get(4..)?.split_at_checked(length(0)?)?;
            Some((RawValue::Text(text), rest))
        }
        b'f' | b'd' | b'i' | b'l' | b'b' | b'c' => Some((RawValue::Other, rest.get(12..)?.get(length(8)?..)?)),
        _ => None,
    }
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    is_wide: bool,
}

impl<'a> Reader<'a> {
    fn number(&mut self) -> Option<usize> {
        let size = if self.is_wide { 8 } else { 4 };
        let mut wide = [0; 8];
        wide[..size].copy_from_slice(self.bytes.get(self.at..self.at + size)?);
        self.at += size;
        usize::try_from(u64::from_le_bytes(wide)).ok()
    }

    /// The next element. The inner `None` is the end of a list.
    #[expect(clippy::option_option, reason = "the outer `None` is a broken file")]
    fn element(&mut self, depth: usize) -> Option<Option<RawElement<'a>>> {
        let [end, count, length] = [self.number()?, self.number()?, self.number()?];
        let name_length = usize::from(*self.bytes.get(self.at)?);
        let name = self.bytes.get(self.at + 1..self.at + 1 + name_length)?;
        self.at += 1 + name_length;
        if end == 0 {
            return Some(None);
        }
        let values = self.bytes.get(self.at..self.at.checked_add(length)?)?;
        self.at += length;
        let is_block = self.at < end;
        let mut children = Vec::new();
        while self.at < end {
            if depth == DEEPEST {
                return None;
            }
            match self.element(depth + 1)? {
                Some(child) => children.push(child),
                None => break,
            }
        }
        // The next element must begin at the end of this element.
        (self.at == end).then_some(())?;
        Some(Some(RawElement {
            name: std::str::from_utf8(name).ok()?,
            count,
            values,
            children,
            is_block,
        }))
    }
}
