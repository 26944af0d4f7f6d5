//! Edits the sections of a file with new clips: all values that depend on the clips.

use std::collections::{BTreeMap, HashSet};

use mocap_scene::files::PROVENANCE;

use super::super::document::{Document, take};
use super::super::encode::Element;
use super::super::properties::Properties;
use super::super::time::Rate;
use super::tree::{RawElement, RawFile, RawValue};

/// The kinds of objects that belong to animations.
pub(super) const OF_ANIMATIONS: [&str; 4] = [
    "AnimationStack",
    "AnimationLayer",
    "AnimationCurveNode",
    "AnimationCurve",
];

/// The values that change with the clips.
pub(super) struct Edits<'c> {
    pub(super) provenance: String,
    /// The name of the clip that programs show first.
    pub(super) active: Option<String>,
    /// The frame rate, if it changes.
    pub(super) rate: Option<Rate>,
    pub(super) removed: HashSet<i64>,
    pub(super) clips: &'c [(String, i64)],
}

impl Edits<'_> {
    pub(super) fn sections<'a>(&self, file: &RawFile<'a>, document: Document<'a>) -> Vec<Element<'a>> {
        let (objects, connections, counts) = document.into_parts();
        let (mut objects, mut connections) = (Some(objects), Some(connections));
        let sections = file.sections.iter().map(|section| match section.name {
            "FBXHeaderExtension" => section.edited(&|below| self.header(below)),
            "GlobalSettings" => section.edited(&|below| self.settings(below)),
            "Documents" => section.edited(&|below| self.active(below)),
            "Definitions" => self.definitions(section, &counts),
            "Objects" => {
                let own = section
                    .children
                    .iter()
                    .filter(|object| !object.id().is_some_and(|id| self.removed.contains(&id)));
                // New clips come first.
                let mut all = objects.take().unwrap_or_default();
                all.extend(own.map(RawElement::unchanged));
                section.with_children(all)
            }
            "Connections" => {
                let is_gone = |connection: &RawElement<'_>| {
                    let ends = [1, 2].map(|end| connection.value(end));
                    ends.iter()
                        .any(|end| matches!(end, Some(RawValue::Number(id)) if self.removed.contains(id)))
                };
                let own = section.children.iter().filter(|connection| !is_gone(connection));
                let mut all: Vec<Element<'a>> = own.map(RawElement::unchanged).collect();
                all.extend(connections.take().unwrap_or_default());
                section.with_children(all)
            }
            "Takes" => self.takes(section),
            _ => section.unchanged(),
        });
        sections.collect()
    }

    /// The properties of the scene, with mocap's provenance.
    fn header<'a>(&self, below: &RawElement<'a>) -> Option<Element<'a>> {
        if below.name != "Properties70" {
            return None;
        }
        let own = below
            .children
            .iter()
            .filter(|property| !property.is_text(0, PROVENANCE));
        let mut all: Vec<Element<'a>> = own.map(RawElement::unchanged).collect();
        all.extend(
            Properties::new()
                .user_text(PROVENANCE, self.provenance.clone())
                .into_elements(),
        );
        Some(below.with_children(all))
    }

    /// The frame rate of the new clips.
    fn settings<'a>(&self, below: &RawElement<'a>) -> Option<Element<'a>> {
        if below.name != "Properties70" {
            return None;
        }
        let of_rate = ["TimeMode", "CustomFrameRate"];
        let is_own = |property: &&RawElement<'_>| !of_rate.iter().any(|name| property.is_text(0, name));
        let mut all: Vec<Element<'a>> = below
            .children
            .iter()
            .filter(is_own)
            .map(RawElement::unchanged)
            .collect();
        let rate = self.rate?;
        let rate = Properties::new()
            .choice("TimeMode", rate.mode())
            .double("CustomFrameRate", rate.frames_per_second());
        all.extend(rate.into_elements());
        Some(below.with_children(all))
    }

    fn active<'a>(&self, below: &RawElement<'a>) -> Option<Element<'a>> {
        let active = self
            .active
            .as_ref()
            .filter(|_| below.name == "P" && below.is_text(0, "ActiveAnimStackName"))?;
        Properties::new()
            .text("ActiveAnimStackName", active.clone())
            .into_elements()
            .pop()
    }

    /// The number of objects of each kind.
    fn definitions<'a>(&self, section: &RawElement<'a>, counts: &BTreeMap<&'static str, i32>) -> Element<'a> {
        let mut left = counts.clone();
        let mut total = 0;
        let mut all: Vec<Element<'a>> = Vec::new();
        for child in section.children.iter().filter(|child| child.name != "Count") {
            let kind = counts
                .keys()
                .copied()
                .find(|kind| child.name == "ObjectType" && child.is_text(0, kind));
            let own = child
                .children
                .iter()
                .find(|below| below.name == "Count")
                .and_then(RawElement::id)
                .unwrap_or_default();
            let own = own as i32;
            let gone = kind.is_some_and(|kind| OF_ANIMATIONS.contains(&kind)) && !self.removed.is_empty();
            let count = if gone { 0 } else { own } + kind.and_then(|kind| left.remove(kind)).unwrap_or_default();
            total += if child.name == "ObjectType" { count } else { 0 };
            all.push(match kind {
                Some(_) => child.edited(&|below| (below.name == "Count").then(|| Element::of("Count", count))),
                None => child.unchanged(),
            });
        }
        for (kind, count) in left {
            total += count;
            all.push(Element::of("ObjectType", kind).child(Element::of("Count", count)));
        }
        let at = all.len().min(1);
        all.insert(at, Element::of("Count", total));
        section.with_children(all)
    }

    /// The list of clips in the form of versions before 7.
    fn takes<'a>(&self, section: &RawElement<'a>) -> Element<'a> {
        let keeps_clips = self.removed.is_empty();
        let own = section
            .children
            .iter()
            .filter(|child| child.name != "Current" && (keeps_clips || child.name != "Take"));
        let mut all = vec![Element::of("Current", self.active.clone().unwrap_or_default())];
        all.extend(self.clips.iter().map(|(name, end)| take(name, *end)));
        all.extend(own.map(RawElement::unchanged));
        section.with_children(all)
    }
}
