//! Shared by the XML formats: elements with their locations, and numbers in attributes.

use std::collections::HashSet;

use mocap_scene::error::{Code, Diagnostic, Location};
use mocap_scene::limits::{FARTHEST, Limits, is_plausible};
use roxmltree::{Document, Node, ParsingOptions};

use crate::Failure;
use crate::text::{Cursor, Word, decode, decode_name, is_binary, quote};

/// The largest number of elements per node of a scene: a link has a dozen elements.
const ELEMENTS_PER_NODE: usize = 64;

/// The text of a file.
pub(super) fn text(bytes: &[u8]) -> Result<String, Failure> {
    let text = decode(bytes)?;
    if is_binary(&text) {
        let message = "the file is binary, not XML";
        return Err(Box::new(Diagnostic::new(Code::BinaryFile, message).help(
            "check that the extension matches the contents of the file, and that the file is not compressed",
        )));
    }
    Ok(without_undeclared_prefixes(without_late_declaration(decode_name(
        &text,
    ))))
}

/// Replaces an XML declaration after white space with spaces. Other readers accept a declaration after white space.
/// Byte offsets in the text do not change.
fn without_late_declaration(mut text: String) -> String {
    let start = text.len() - text.trim_start().len();
    if start > 0
        && text[start..].starts_with("<?xml ")
        && let Some(length) = text[start..].find("?>")
        && text[start..start + length].is_ascii()
    {
        let blanks = text[start..start + length + 2].replace(|letter: char| letter != '\n', " ");
        text.replace_range(start..start + length + 2, &blanks);
    }
    text
}

/// Replaces `prefix:name` with `prefix_name` if the file does not declare the prefix. The parser refuses undeclared
/// prefixes, but some programs write such elements. Byte offsets in the text do not change.
fn without_undeclared_prefixes(text: String) -> String {
    let declared: HashSet<&str> = (text.match_indices("xmlns:"))
        .map(|(at, mark)| {
            let rest = &text[at + mark.len()..];
            let is_end = |letter: char| letter == '=' || letter.is_ascii_whitespace();
            rest.split(is_end).next().unwrap_or_default()
        })
        .chain(["xml", "xmlns", ""])
        .collect();
    let mut colons = Vec::new();
    let bytes = text.as_bytes();
    let mut at = 0;
    while let Some(start) = memchr::memchr(b'<', &bytes[at..]) {
        at += start;
        let rest = &bytes[at..];
        let passed: Option<&[u8]> = match rest {
            [b'<', b'!', b'-', b'-', ..] => Some(b"-->"),
            [b'<', b'!', b'[', ..] => Some(b"]]>"),
            [b'<', b'!' | b'?', ..] => Some(b">"),
            _ => None,
        };
        if let Some(end) = passed {
            at += memchr::memmem::find(rest, end).map_or(rest.len(), |found| found + end.len());
            continue;
        }
        let mut quote = None;
        // The byte at which the name of the element, or of an attribute, begins.
        let mut name = at + 1;
        let mut offset = at + 1;
        while let Some(&byte) = bytes.get(offset) {
            match (quote, byte) {
                (Some(open), _) if open == byte => quote = None,
                (Some(_), _) => {}
                (None, b'"' | b'\'') => quote = Some(byte),
                (None, b'>') => break,
                (None, b':') if !declared.contains(text.get(name..offset).unwrap_or_default()) => colons.push(offset),
                (None, b' ' | b'\t' | b'\n' | b'\r' | b'/') => name = offset + 1,
                (None, _) => {}
            }
            offset += 1;
        }
        at = offset;
    }
    let mut bytes = text.into_bytes();
    colons.into_iter().for_each(|colon| bytes[colon] = b'_');
    // Only an ASCII character was replaced by another, so the text is still UTF-8.
    String::from_utf8(bytes).unwrap_or_default()
}

/// The tree of a file, whose outermost element must be one of `roots`.
pub(super) fn parse<'a>(text: &'a str, roots: &[&str], limits: &Limits) -> Result<Document<'a>, Failure> {
    check_depth(text, limits)?;
    let most = limits.max_nodes.saturating_mul(ELEMENTS_PER_NODE);
    let options = ParsingOptions {
        nodes_limit: u32::try_from(most).unwrap_or(u32::MAX),
        ..ParsingOptions::default()
    };
    let document = Document::parse_with_options(text, options).map_err(|error| match error {
        roxmltree::Error::NodesLimitReached => {
            let message = format!("the file has more than {most} elements and texts");
            Box::new(Diagnostic::new(Code::LimitExceeded, message))
        }
        error => {
            let fault_at = error.pos();
            let offset = offset_of(text, fault_at.row as usize, fault_at.col as usize);
            // The message ends with the location, which the diagnostic has.
            let message = error.to_string();
            let message = message
                .rsplit_once(" at ")
                .map_or(message.as_str(), |(message, _)| message);
            Box::new(
                Diagnostic::new(Code::InvalidXml, format!("the file is not valid XML: {message}"))
                    .at(locate(text, offset, 1)),
            )
        }
    })?;
    let found = document.root_element().tag_name().name();
    if !roots.contains(&found) {
        let element = Element::root(&document);
        let root = roots.join("> or <");
        return Err(Box::new(
            element
                .diagnostic(Code::MissingKeyword, format!("the outermost element is not <{root}>"))
                .expected_found(format!("<{root}>"), format!("<{}>", quote_name(found))),
        ));
    }
    Ok(document)
}

/// Refuses deep nesting before a parser meets it, by counting opening and closing tags.
fn check_depth(text: &str, limits: &Limits) -> Result<(), Failure> {
    // The deepest element is in a link of the deepest robot.
    let most = limits.max_depth.saturating_add(8);
    let bytes = text.as_bytes();
    let mut depth = 0_usize;
    for at in memchr::memchr_iter(b'<', bytes) {
        match bytes.get(at + 1) {
            Some(b'/') => depth = depth.saturating_sub(1),
            Some(b'!' | b'?') | None => {}
            Some(_) => {
                let end = memchr::memchr(b'>', &bytes[at..]).map_or(bytes.len(), |end| at + end);
                if bytes[..end].last() != Some(&b'/') {
                    depth += 1;
                }
                if depth > most {
                    let message = format!("elements are nested more than {most} deep");
                    return Err(Box::new(
                        Diagnostic::new(Code::LimitExceeded, message).at(locate(text, at, 1)),
                    ));
                }
            }
        }
    }
    Ok(())
}

/// The byte at a line and a column, both from 1.
fn offset_of(text: &str, row: usize, column: usize) -> usize {
    let Some(line) = text.split_inclusive('\n').nth(row.saturating_sub(1)) else {
        return text.len();
    };
    let start = line.as_ptr() as usize - text.as_ptr() as usize;
    let within: usize = line.chars().take(column.saturating_sub(1)).map(char::len_utf8).sum();
    start + within
}

fn locate(text: &str, offset: usize, length: usize) -> Location {
    let offset = offset.min(text.len());
    let bytes = &text.as_bytes()[offset..text.len().min(offset + length)];
    Cursor::new(text.as_bytes()).locate(Word { bytes, offset })
}

fn quote_name(name: &str) -> String {
    quote(name.as_bytes()).trim_matches('"').to_owned()
}

/// A file whose elements replace `<include file="NAME">`.
pub(super) struct IncludedFile<'input> {
    pub(super) name: String,
    pub(super) document: Document<'input>,
}

/// An element of a file.
#[derive(Clone, Copy)]
pub(super) struct Element<'a, 'input> {
    node: Node<'a, 'input>,
    /// The files that may be included.
    included: &'a [IncludedFile<'input>],
    /// The included file of the element; `None` in the main file.
    file: Option<&'a IncludedFile<'input>>,
}

/// The children of an element, including children from included files.
struct Children<'a, 'input> {
    open: Vec<(roxmltree::Children<'a, 'input>, Option<&'a IncludedFile<'input>>)>,
    included: &'a [IncludedFile<'input>],
}

impl<'a, 'input> Iterator for Children<'a, 'input> {
    type Item = Element<'a, 'input>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let (nodes, file) = self.open.last_mut()?;
            let file = *file;
            let Some(node) = nodes.next() else {
                self.open.pop();
                continue;
            };
            let element = Element {
                node,
                included: self.included,
                file,
            };
            match element.includes() {
                Some(inner) => self.open.push((inner.document.root_element().children(), Some(inner))),
                None if node.is_element() => return Some(element),
                None => {}
            }
        }
    }
}

impl<'a, 'input> Element<'a, 'input> {
    pub(super) fn root(document: &'a Document<'input>) -> Self {
        Self::root_with(document, &[])
    }

    /// The outermost element of a file that may include other files.
    pub(super) fn root_with(document: &'a Document<'input>, included: &'a [IncludedFile<'input>]) -> Self {
        Self {
            node: document.root_element(),
            included,
            file: None,
        }
    }

    /// The file that an element includes.
    fn includes(&self) -> Option<&'a IncludedFile<'input>> {
        let name = match self.node.is_element() && self.name() == "include" {
            true => self.attribute("file")?,
            false => return None,
        };
        self.included.iter().find(|file| file.name == name)
    }

    /// This element and all its descendants, in the order of the file.
    pub(super) fn descendants(&self) -> impl Iterator<Item = Self> + use<'a, 'input> {
        let this = *self;
        let elements = self.node.descendants().filter(Node::is_element);
        elements.map(move |node| Self { node, ..this })
    }

    pub(super) fn name(&self) -> &'a str {
        self.node.tag_name().name()
    }

    pub(super) fn children(&self) -> impl Iterator<Item = Self> + use<'a, 'input> {
        Children {
            open: vec![(self.node.children(), self.file)],
            included: self.included,
        }
    }

    /// The children with this name.
    pub(super) fn all(&self, name: &'static str) -> impl Iterator<Item = Self> + use<'a, 'input> {
        self.children().filter(move |child| child.name() == name)
    }

    /// The first child in a namespace whose address has this end, or with this prefix if the namespace is not declared.
    pub(super) fn child_of_namespace(&self, end: &str) -> Option<Self> {
        let is_of = |element: &Self| {
            let tag = element.node.tag_name();
            let has_prefix = || tag.name().strip_prefix(end).is_some_and(|rest| rest.starts_with('_'));
            tag.namespace().is_some_and(|name| name.ends_with(end)) || has_prefix()
        };
        self.children().find(is_of)
    }

    pub(super) fn child(&self, name: &'static str) -> Option<Self> {
        self.all(name).next()
    }

    pub(super) fn attribute(&self, name: &str) -> Option<&'a str> {
        self.node.attribute(name)
    }

    pub(super) fn attributes(&self) -> impl Iterator<Item = (&'a str, &'a str)> + use<'a, 'input> {
        self.node
            .attributes()
            .map(|attribute| (attribute.name(), attribute.value()))
    }

    /// The start of the element in the text of the main file; `None` in an included file.
    pub(super) fn offset(&self) -> Option<usize> {
        self.file.is_none().then(|| self.node.range().start)
    }

    /// A diagnostic at the element, with its name.
    pub(super) fn diagnostic(&self, code: Code, message: impl Into<String>) -> Diagnostic {
        let start = self.node.range().start;
        // The diagnostic marks the bracket and the name of the element.
        self.diagnostic_at(start, 1 + self.name().len(), code, message.into())
    }

    /// An error at an attribute of the element.
    pub(super) fn at_attribute(&self, name: &str, code: Code, message: impl Into<String>) -> Diagnostic {
        match self.node.attribute_node(name) {
            Some(attribute) => {
                let range = attribute.range_value();
                self.diagnostic_at(range.start, range.len().max(1), code, message.into())
            }
            None => self.diagnostic(code, message),
        }
    }

    fn diagnostic_at(&self, start: usize, length: usize, code: Code, message: String) -> Diagnostic {
        let location = locate(self.node.document().input_text(), start, length);
        match self.file {
            None => Diagnostic::new(code, message).at(location),
            // Locations refer to the main file only.
            Some(file) => {
                let (name, line) = (quote(file.name.as_bytes()), location.line);
                Diagnostic::new(code, format!("{message}, in {name}, which is included, at line {line}"))
            }
        }
    }

    /// An attribute that must exist.
    pub(super) fn required(&self, name: &str) -> Result<&'a str, Failure> {
        self.attribute(name).ok_or_else(|| {
            let tag = quote_name(self.name());
            Box::new(
                self.diagnostic(Code::MissingKeyword, format!("<{tag}> has no {name}"))
                    .help(format!("add the attribute {name}")),
            )
        })
    }

    /// A name, checked against the limits.
    pub(super) fn checked_name(&self, attribute: &str, name: &str, limits: &Limits) -> Result<String, Failure> {
        if name.len() > limits.max_name_bytes {
            let message = format!(
                "a name has {} bytes, and {} are allowed",
                name.len(),
                limits.max_name_bytes
            );
            return Err(Box::new(self.at_attribute(attribute, Code::LimitExceeded, message)));
        }
        Ok(name.to_owned())
    }

    /// The numbers of an attribute with the value `value`: between `least` and `most` numbers.
    pub(super) fn parse_numbers(
        &self,
        name: &str,
        value: &str,
        least: usize,
        most: usize,
    ) -> Result<Vec<f64>, Failure> {
        let mut numbers = Vec::new();
        let count = || match (least, most) {
            (least, most) if least == most => least.to_string(),
            _ => format!("{least} to {most}"),
        };
        for word in value.split_ascii_whitespace() {
            let number: f64 = word.parse().map_err(|_| {
                Box::new(
                    self.at_attribute(
                        name,
                        Code::InvalidNumber,
                        format!("{name} has a word that is not a number"),
                    )
                    .expected_found("a number", quote(word.as_bytes())),
                )
            })?;
            if !is_plausible(number) {
                return Err(Box::new(
                    self.at_attribute(
                        name,
                        Code::NumberRange,
                        format!("{name} has a number that is not finite, or too large"),
                    )
                    .expected_found(format!("a number of at most {FARTHEST:e}"), quote(word.as_bytes())),
                ));
            }
            if numbers.len() == most {
                numbers.push(number);
                break;
            }
            numbers.push(number);
        }
        if !(least..=most).contains(&numbers.len()) {
            let message = format!("{name} has the wrong number of values");
            let found = value.split_ascii_whitespace().count().to_string();
            return Err(Box::new(
                self.at_attribute(name, Code::InvalidNumber, message)
                    .expected_found(format!("{} numbers", count()), found),
            ));
        }
        Ok(numbers)
    }

    /// One number of an attribute, if it exists.
    pub(super) fn number(&self, name: &str) -> Result<Option<f64>, Failure> {
        let Some(value) = self.attribute(name) else {
            return Ok(None);
        };
        Ok(self.parse_numbers(name, value, 1, 1)?.first().copied())
    }

    /// Three numbers of an attribute, if it exists.
    pub(super) fn vector(&self, name: &str) -> Result<Option<glam::DVec3>, Failure> {
        let Some(value) = self.attribute(name) else {
            return Ok(None);
        };
        let numbers = self.parse_numbers(name, value, 3, 3)?;
        Ok(Some(glam::DVec3::from_slice(&numbers)))
    }
}
