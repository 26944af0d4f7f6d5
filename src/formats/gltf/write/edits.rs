//! Local edits of a glTF file's text, so that everything else keeps its bytes.

use std::ops::Range;

use mocap_scene::error::Result;
use mocap_scene::pose::Trs;
use serde::Deserialize;
use serde_json::json;
use serde_json::value::RawValue;

use super::super::invalid::{invalid, json_words};
use crate::Failure;

/// The members of a node that are examined.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Node<'a> {
    #[serde(borrow)]
    matrix: Option<&'a RawValue>,
}

/// Edits of a JSON document.
pub(super) struct Edits<'a> {
    text: &'a str,
    edits: Vec<(Range<usize>, String)>,
}

impl<'a> Edits<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self {
            text,
            edits: Vec::new(),
        }
    }

    /// The position of a slice of the text.
    fn range(&self, part: &str) -> Range<usize> {
        let start = part.as_ptr() as usize - self.text.as_ptr() as usize;
        start..start + part.len()
    }

    pub(super) fn replace(&mut self, part: &RawValue, with: impl Into<String>) {
        let range = self.range(part.get());
        self.edits.push((range, with.into()));
    }

    /// Inserts a string at the beginning of an object, before its first member.
    pub(super) fn insert_in(&mut self, object: &RawValue, member: String) {
        let at = self.range(object.get()).start + 1;
        self.edits.push((at..at, member));
    }

    /// Adds an extension to a list, unless it is already there.
    pub(super) fn extension(&mut self, name: &str, section: Option<&'a RawValue>, extension: &str) -> Result<()> {
        let known: Vec<String> = section.map_or(Ok(Vec::new()), |section| parse(section.get()))?;
        if known.iter().any(|known| known == extension) {
            return Ok(());
        }
        self.append(name, section, &[json!(extension).to_string()])
    }

    /// Appends items to an array of the root. Adds the array if the file lacks it.
    pub(super) fn append(&mut self, name: &str, section: Option<&'a RawValue>, items: &[String]) -> Result<()> {
        if items.is_empty() {
            return Ok(());
        }
        let items = items.join(",");
        let Some(section) = section else {
            let end = self.text.trim_end().len() - 1;
            self.edits.push((end..end, format!(",\"{name}\":[{items}]")));
            return Ok(());
        };
        let present: Vec<&RawValue> = parse(section.get())?;
        let (at, comma) = match present.last() {
            Some(last) => (self.range(last.get()).end, ","),
            None => (self.range(section.get()).end - 1, ""),
        };
        self.edits.push((at..at, format!("{comma}{items}")));
        Ok(())
    }

    /// Appends items to an array of the root. Present items for which `is_freed` holds are removed from the end of the
    /// array. At other places `stand_in` replaces these items, so that indices do not change.
    pub(super) fn exchange(
        &mut self,
        name: &str,
        section: Option<&'a RawValue>,
        is_freed: &[bool],
        stand_in: &str,
        items: &[String],
    ) -> Result<()> {
        let kept = is_freed
            .iter()
            .rposition(|is_freed| !is_freed)
            .map_or(0, |last| last + 1);
        let (Some(section), true) = (section, is_freed.contains(&true)) else {
            return self.append(name, section, items);
        };
        let present: Vec<&RawValue> = parse(section.get())?;
        for (item, _) in std::iter::zip(&present[..kept], is_freed).filter(|(_, is_freed)| **is_freed) {
            self.replace(item, stand_in);
        }
        let from = match present[..kept].last() {
            Some(last) => self.range(last.get()).end,
            None => self.range(section.get()).start + 1,
        };
        let comma = if kept > 0 && !items.is_empty() { "," } else { "" };
        let end = self.range(section.get()).end - 1;
        self.edits.push((from..end, format!("{comma}{}", items.join(","))));
        Ok(())
    }

    /// Replaces the matrix of an animated node by translation, rotation and scale, as glTF requires.
    pub(super) fn matrices(&mut self, nodes: Option<&'a RawValue>, driven: &mut Vec<(usize, Trs)>) -> Result<()> {
        driven.sort_by_key(|(node, _)| *node);
        driven.dedup_by_key(|(node, _)| *node);
        let nodes: Vec<&RawValue> = nodes.map_or(Ok(Vec::new()), |nodes| parse(nodes.get()))?;
        for (index, trs) in driven {
            let Some(node) = nodes.get(*index) else { continue };
            let Some(matrix) = parse::<Node<'_>>(node.get())?.matrix else {
                continue;
            };
            let value = self.range(matrix.get());
            let Some(key) = self.text[..value.start].rfind("\"matrix\"") else {
                continue;
            };
            let parts = format!(
                "\"translation\":{},\"rotation\":{},\"scale\":{}",
                json!(trs.translation.to_array()),
                json!(trs.rotation.to_array()),
                json!(trs.scale.to_array())
            );
            self.edits.push((key..value.end, parts));
        }
        Ok(())
    }

    pub(super) fn finish(mut self) -> String {
        // A stable sort: edits at one offset keep their order.
        self.edits.sort_by_key(|(range, _)| range.start);
        let mut text = String::with_capacity(self.text.len() + 1024);
        let mut at = 0;
        for (range, with) in &self.edits {
            text.push_str(&self.text[at..range.start]);
            text.push_str(with);
            at = range.end;
        }
        text.push_str(&self.text[at..]);
        text
    }
}

pub(super) fn parse<'a, T: Deserialize<'a>>(text: &'a str) -> Result<T> {
    serde_json::from_str(text)
        .map_err(|error| invalid("", format!("the JSON cannot be read: {}", json_words(&error))).into())
}

pub(super) fn utf8(text: &[u8]) -> Result<&str, Failure> {
    std::str::from_utf8(text).map_err(|error| {
        let message = format!(
            "the JSON is not UTF-8 from byte {} on, so mocap cannot keep the contents of the file",
            error.valid_up_to()
        );
        invalid("", message).into()
    })
}
