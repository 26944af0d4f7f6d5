//! Changes of the text of a glTF file, each of a part of it, so that all else keeps its bytes.

use std::ops::Range;

use mocap_scene::error::Result;
use mocap_scene::pose::Trs;
use serde::Deserialize;
use serde_json::json;
use serde_json::value::RawValue;

use super::super::invalid::invalid;
use crate::Failure;

/// What is looked at of a node.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Node<'a> {
    #[serde(borrow)]
    matrix: Option<&'a RawValue>,
}

/// Changes of a text, each of a part of it.
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

    /// Where a part of the text is.
    fn range(&self, part: &str) -> Range<usize> {
        let start = part.as_ptr() as usize - self.text.as_ptr() as usize;
        start..start + part.len()
    }

    pub(super) fn replace(&mut self, part: &RawValue, with: impl Into<String>) {
        let range = self.range(part.get());
        self.edits.push((range, with.into()));
    }

    /// Inserts a text at the beginning of an object, before its first member.
    pub(super) fn insert_in(&mut self, object: &RawValue, member: String) {
        let at = self.range(object.get()).start + 1;
        self.edits.push((at..at, member));
    }

    /// Names an extension in a list, unless it stands there already.
    pub(super) fn extension(&mut self, name: &str, section: Option<&'a RawValue>, extension: &str) -> Result<()> {
        let known: Vec<String> = section.map_or(Ok(Vec::new()), |section| parse(section.get()))?;
        if known.iter().any(|known| known == extension) {
            return Ok(());
        }
        self.append(name, section, &[json!(extension).to_string()])
    }

    /// Appends items to an array of the root, which is added where the file lacks it.
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

    /// Puts items behind those of an array of the root. Of those that are there, the ones that `is_freed` names are
    /// gone at the end of the array; elsewhere `stand_in` keeps their number.
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

    /// Writes the matrix of a node that is animated as its three parts: glTF demands it.
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
        // Those at one offset stay in their order.
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
    serde_json::from_str(text).map_err(|error| invalid("", format!("the JSON cannot be read: {error}")).into())
}

pub(super) fn utf8(text: &[u8]) -> Result<&str, Failure> {
    std::str::from_utf8(text).map_err(|error| {
        let message = format!(
            "the JSON is not UTF-8 from byte {} on, so it cannot be passed through",
            error.valid_up_to()
        );
        invalid("", message).into()
    })
}
