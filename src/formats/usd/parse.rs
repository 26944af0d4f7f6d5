//! Parses the text form of USD: nested prims with attributes, relationships and metadata.
//!
//! ```text
//! layer     := "#usda 1.0" metadata? prim*
//! prim      := ("def" | "over" | "class") type? "name" metadata? "{" (prim | property | variants)* "}"
//! property  := qualifier* type "[]"? name (".timeSamples" | ".connect")? ("=" value)? metadata?
//! metadata  := "(" (name "=" value)* ")"
//! ```
//!
//! A value is kept as its numbers, or as its strings, in the order of the file. The attribute determines whether the
//! numbers or strings are a list or a tuple. The parser does not recurse, so that no nesting is too deep for it.

mod tokens;
mod variants;

use std::collections::HashMap;

use mocap_scene::error::{Code, Diagnostic, Location};
use mocap_scene::limits::{Limits, limit_exceeded};

use self::tokens::{Tokens, is_word, text_of};
use self::variants::Open;
use crate::Failure;
use crate::text::Word;

/// Values by name.
pub(super) type Metadata = HashMap<String, Value>;

/// The value of an attribute.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Value {
    pub(super) numbers: Vec<f64>,
    /// Strings, tokens, paths and file names.
    pub(super) texts: Vec<String>,
    /// The offset in the text. The offset of a time sample is the offset of its time.
    pub(super) offset: usize,
}

#[derive(Debug, Default)]
pub(super) struct Attribute {
    pub(super) value: Option<Value>,
    /// The time samples, sorted by time.
    pub(super) samples: Vec<(f64, Value)>,
    /// Whether the type of the attribute is texture coordinates.
    pub(super) is_of_texture: bool,
    /// The metadata. Only prims of meshes keep it.
    pub(super) metadata: Metadata,
}

impl Attribute {
    /// The constant value, or else the first sample.
    pub(super) fn first(&self) -> Option<&Value> {
        let sampled = || self.samples.first().map(|(_, value)| value);
        self.value.as_ref().or_else(sampled)
    }

    /// The interpolation of a mesh attribute, if it is stated.
    pub(super) fn interpolation(&self) -> Option<&str> {
        self.metadata.get("interpolation")?.texts.first().map(String::as_str)
    }
}

#[derive(Debug, Default)]
pub(super) struct Prim {
    pub(super) kind: String,
    pub(super) name: String,
    pub(super) parent: Option<usize>,
    pub(super) attributes: HashMap<String, Attribute>,
    pub(super) metadata: Metadata,
}

impl Prim {
    /// The strings of an attribute; empty if the prim lacks it.
    pub(super) fn texts(&self, name: &str) -> &[String] {
        let value = self.attributes.get(name).and_then(|attribute| attribute.value.as_ref());
        value.map_or(&[], |value| &value.texts)
    }

    /// The numbers of an attribute. If the attribute is animated, the numbers of its first sample.
    pub(super) fn numbers(&self, name: &str) -> &[f64] {
        let value = self.attributes.get(name).and_then(Attribute::first);
        value.map_or(&[], |value| &value.numbers)
    }

    /// The display name.
    pub(super) fn display_name(&self) -> Option<&String> {
        self.metadata.get("displayName")?.texts.first()
    }
}

/// The prims of a layer, parents before children.
#[derive(Debug, Default)]
pub(super) struct Layer<'a> {
    pub(super) text: &'a [u8],
    pub(super) metadata: Metadata,
    pub(super) prims: Vec<Prim>,
    /// The variant sets without a selection, each as the index of its prim and its name.
    pub(super) unselected: Vec<(usize, String)>,
}

impl Layer<'_> {
    /// The location of a value.
    pub(super) fn locate(&self, value: &Value) -> Location {
        Tokens::locate(self.text, value.offset)
    }

    /// The path of a prim.
    pub(super) fn path(&self, mut prim: usize) -> String {
        let mut names = vec![self.prims[prim].name.as_str()];
        while let Some(parent) = self.prims[prim].parent {
            names.push(&self.prims[parent].name);
            prim = parent;
        }
        names.reverse();
        format!("/{}", names.join("/"))
    }
}

/// Attributes that show that a mesh has a skin. The mesh may inherit these attributes from an ancestor.
const INHERITED: [&str; 4] = [
    "skel:animationSource",
    "skel:skeleton",
    "skel:joints",
    "material:binding",
];

/// Parses a layer. The layer keeps only the attributes that this crate reads, and attributes of meshes only on request.
pub(super) fn parse<'a>(text: &'a [u8], limits: &'a Limits, with_meshes: bool) -> Result<Layer<'a>, Failure> {
    let mut parser = Parser::new(text, limits);
    parser.with_meshes = with_meshes;
    parser.layer(text)
}

/// Only the metadata of a layer.
pub(super) fn metadata(text: &[u8], limits: &Limits) -> Result<Metadata, Failure> {
    Parser::new(text, limits).metadata_of_layer()
}

struct Parser<'a> {
    tokens: Tokens<'a>,
    with_meshes: bool,
    limits: &'a Limits,
    /// The remaining number of values that may be kept.
    values: u64,
}

impl<'a> Parser<'a> {
    fn new(text: &'a [u8], limits: &'a Limits) -> Self {
        Self {
            tokens: Tokens::new(text),
            with_meshes: false,
            limits,
            values: limits.max_values,
        }
    }

    /// Whether an attribute is read: attributes of skeletons and their animations, and transforms of any prim. The
    /// points of meshes need not be kept.
    fn is_read(&self, kind: &str, name: &str) -> bool {
        matches!(kind, "Skeleton" | "SkelAnimation")
            || name.starts_with("xformOp")
            || INHERITED.contains(&name)
            || self.is_of_mesh(kind)
    }

    /// Whether a prim belongs to a mesh, and meshes are read.
    fn is_of_mesh(&self, kind: &str) -> bool {
        self.with_meshes && matches!(kind, "Mesh" | "GeomSubset" | "BlendShape" | "Material" | "Shader")
    }

    fn metadata_of_layer(&mut self) -> Result<Metadata, Failure> {
        match self.tokens.peek() {
            Some(b'(') => self.metadata(),
            _ => Ok(Metadata::default()),
        }
    }

    fn layer(&mut self, text: &'a [u8]) -> Result<Layer<'a>, Failure> {
        let mut layer = Layer {
            text,
            metadata: self.metadata_of_layer()?,
            ..Layer::default()
        };
        let mut open: Vec<Open> = Vec::new();
        while let Some(next) = self.tokens.peek() {
            if let (Some(Open::Set(prim, selected)), true) = (open.last(), next != b'}') {
                let variant = self.variant(*prim, selected.as_deref())?;
                open.extend(variant);
                continue;
            }
            match next {
                b'}' => {
                    let closed = open.pop();
                    closed.ok_or_else(|| self.tokens.unexpected("a prim, or the end"))?;
                    self.tokens.pass(1);
                }
                b';' => self.tokens.pass(1),
                _ => {
                    let word = self.tokens.word()?;
                    match (word.bytes, open.last()) {
                        (b"def" | b"over" | b"class", parent) => {
                            let prim = self.prim(parent.map(Open::prim))?;
                            open.push(Open::Prim(layer.prims.len()));
                            self.check_size(layer.prims.len(), open.len())?;
                            layer.prims.push(prim);
                        }
                        (b"variantSet", Some(parent)) => {
                            let prim = parent.prim();
                            let set = self.variant_set(prim, &mut layer)?;
                            open.push(set);
                            self.check_size(layer.prims.len(), open.len())?;
                        }
                        (b"reorder", Some(_)) => self.skip_statement()?,
                        (_, Some(&Open::Variant(prim))) => {
                            // Statements of the prim itself are stronger.
                            let mut weaker = Prim {
                                kind: layer.prims[prim].kind.clone(),
                                ..Prim::default()
                            };
                            self.property(word, &mut weaker)?;
                            for (name, attribute) in weaker.attributes {
                                layer.prims[prim].attributes.entry(name).or_insert(attribute);
                            }
                        }
                        (_, Some(parent)) => self.property(word, &mut layer.prims[parent.prim()])?,
                        (_, None) => return Err(self.tokens.unexpected_word(word, "def, over or class")),
                    }
                }
            }
        }
        match open.last() {
            None => Ok(layer),
            Some(unclosed) => {
                let name = &layer.prims[unclosed.prim()].name;
                let message = format!("the file ends within the prim {name:?}");
                Err(Diagnostic::new(Code::UnexpectedEnd, message)
                    .at(self.tokens.end())
                    .into())
            }
        }
    }

    /// Reads a prim up to its brace.
    fn prim(&mut self, parent: Option<usize>) -> Result<Prim, Failure> {
        let mut prim = Prim {
            parent,
            ..Prim::default()
        };
        if self.tokens.peek() != Some(b'"') {
            prim.kind = text_of(self.tokens.word()?);
        }
        prim.name = self.tokens.string()?;
        if prim.name.len() > self.limits.max_name_bytes {
            let most = format!("at most {} bytes in a name", self.limits.max_name_bytes);
            return Err(limit_exceeded(most, prim.name.len().to_string()).into());
        }
        if self.tokens.peek() == Some(b'(') {
            prim.metadata = self.metadata()?;
        }
        self.tokens.expect(b'{')?;
        Ok(prim)
    }

    fn check_size(&self, count: usize, depth: usize) -> Result<(), Failure> {
        let (nodes, deep) = (self.limits.max_nodes, self.limits.max_depth);
        if count >= nodes {
            return Err(limit_exceeded(format!("at most {nodes} prims"), "more".to_owned()).into());
        }
        if depth > deep {
            return Err(limit_exceeded(format!("at most {deep} prims within each other"), "more".to_owned()).into());
        }
        Ok(())
    }

    /// Reads an attribute or a relationship, whose first word was read.
    fn property(&mut self, first: Word<'a>, prim: &mut Prim) -> Result<(), Failure> {
        // Qualifiers and the type precede the name, which is the last word before `=`, `(` or the next statement.
        let mut name = first;
        let mut kind = first;
        loop {
            match self.tokens.peek_on_line() {
                Some(b'[') => {
                    self.tokens.pass(1);
                    self.tokens.expect(b']')?;
                }
                Some(byte) if is_word(byte) => kind = std::mem::replace(&mut name, self.tokens.word()?),
                _ => break,
            }
        }
        let is_of_texture = kind.bytes.starts_with(b"texCoord2");
        let begin = self.tokens.offset();
        let name = text_of(name);
        if self.tokens.peek() != Some(b'=') {
            self.tokens.back_to(begin);
        } else {
            self.tokens.pass(1);
            match name.strip_suffix(".timeSamples") {
                Some(name) => {
                    let samples = self.samples(self.is_read(&prim.kind, name))?;
                    if !samples.is_empty() {
                        prim.attributes.entry(name.to_owned()).or_default().samples = samples;
                    }
                }
                None => {
                    let value = self.value()?;
                    if self.is_read(&prim.kind, &name) {
                        self.count(&value)?;
                        let attribute = prim.attributes.entry(name.clone()).or_default();
                        attribute.value = Some(value);
                        attribute.is_of_texture = is_of_texture;
                    }
                }
            }
        }
        let begin = self.tokens.offset();
        match self.tokens.peek() {
            Some(b'(') => {
                let metadata = self.metadata()?;
                if let Some(attribute) = prim.attributes.get_mut(&name).filter(|_| self.is_of_mesh(&prim.kind)) {
                    attribute.metadata = metadata;
                }
                Ok(())
            }
            _ => {
                self.tokens.back_to(begin);
                Ok(())
            }
        }
    }

    /// Reads `{ 0: value, 1: value, }`.
    fn samples(&mut self, is_read: bool) -> Result<Vec<(f64, Value)>, Failure> {
        let mut samples: Vec<(f64, Value)> = Vec::new();
        self.tokens.expect(b'{')?;
        loop {
            match self.tokens.peek() {
                Some(b'}') => {
                    self.tokens.pass(1);
                    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
                    return Ok(samples);
                }
                Some(b',') => self.tokens.pass(1),
                _ => {
                    let offset = self.tokens.offset();
                    let time = self.tokens.number()?;
                    self.tokens.expect(b':')?;
                    let value = self.value()?;
                    if is_read {
                        self.count(&value)?;
                        samples.push((time, Value { offset, ..value }));
                    }
                }
            }
        }
    }

    /// Counts a kept value against the limit. A value without numbers counts too.
    fn count(&mut self, value: &Value) -> Result<(), Failure> {
        let count = 1 + value.numbers.len() as u64 + value.texts.len() as u64;
        match self.values.checked_sub(count) {
            Some(rest) => {
                self.values = rest;
                Ok(())
            }
            None => {
                let most = format!("at most {} values of skeletons and animations", self.limits.max_values);
                Err(limit_exceeded(most, "more".to_owned()).into())
            }
        }
    }

    /// Reads a value: a number, a string, or a list of numbers or strings, with all nested lists.
    fn value(&mut self) -> Result<Value, Failure> {
        self.tokens.peek();
        let mut value = Value {
            offset: self.tokens.offset(),
            ..Value::default()
        };
        let mut depth = 0_usize;
        loop {
            let Some(next) = self.tokens.peek() else {
                return Err(self.tokens.unexpected("a value"));
            };
            match next {
                b'(' | b'[' | b'{' => {
                    depth += 1;
                    self.tokens.pass(1);
                }
                b')' | b']' | b'}' if depth > 0 => {
                    depth -= 1;
                    self.tokens.pass(1);
                }
                b',' | b':' | b'=' | b';' if depth > 0 => self.tokens.pass(1),
                b'"' | b'\'' => value.texts.push(self.tokens.string()?),
                b'<' => value.texts.push(self.tokens.delimited(b'>')?),
                b'@' => value.texts.push(self.tokens.asset()?),
                b'-' | b'+' | b'.' | b'0'..=b'9' => value.numbers.push(self.tokens.number()?),
                _ => match self.tokens.word()? {
                    word if word.bytes == b"None" => {}
                    word if is_not_finite(word.bytes) => value.numbers.push(f64::NAN),
                    word => value.texts.push(text_of(word)),
                },
            }
            if depth == 0 {
                return Ok(value);
            }
        }
    }

    /// Reads `( name = value ... )`. A single text is a comment.
    fn metadata(&mut self) -> Result<Metadata, Failure> {
        let mut found = Metadata::new();
        self.tokens.expect(b'(')?;
        loop {
            match self.tokens.peek() {
                Some(b')') => {
                    self.tokens.pass(1);
                    return Ok(found);
                }
                Some(b'"' | b'\'') => drop(self.tokens.string()?),
                Some(b';' | b',') => self.tokens.pass(1),
                _ => {
                    let mut name = self.tokens.word()?;
                    // Metadata such as `prepend apiSchemas = [...]`.
                    while self.tokens.peek() != Some(b'=') {
                        name = self.tokens.word()?;
                    }
                    self.tokens.pass(1);
                    let value = self.value()?;
                    found.insert(text_of(name), value);
                    // A reference such as `@file@</Prim> (offset = 1)`.
                    if self.tokens.peek() == Some(b'<') {
                        self.tokens.delimited(b'>')?;
                    }
                    if self.tokens.peek() == Some(b'(') {
                        self.value()?;
                    }
                }
            }
        }
    }

    /// Skips an unused statement, up to the end of its braces.
    fn skip_statement(&mut self) -> Result<(), Failure> {
        let mut depth = 0_usize;
        loop {
            match self.tokens.peek() {
                None => return Err(self.tokens.unexpected("}")),
                Some(b'"' | b'\'') => drop(self.tokens.string()?),
                Some(b'@') => drop(self.tokens.asset()?),
                Some(b'{' | b'(' | b'[') => {
                    depth += 1;
                    self.tokens.pass(1);
                }
                Some(close @ (b'}' | b')' | b']')) => {
                    depth = depth.checked_sub(1).ok_or_else(|| self.tokens.unexpected("a value"))?;
                    self.tokens.pass(1);
                    if depth == 0 && close != b')' {
                        return Ok(());
                    }
                }
                Some(_) => self.tokens.pass(1),
            }
        }
    }
}

fn is_not_finite(word: &[u8]) -> bool {
    matches!(word, b"inf" | b"nan")
}
