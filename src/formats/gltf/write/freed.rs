//! Frees the data of a glTF file that only replaced animations need: accessors, buffer views, bytes.
//!
//! Indices of accessors and views do not change, because extensions may refer to them. Freed items at the end of a list
//! are removed. At other places, the smallest valid item replaces a freed item.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use mocap_scene::error::Result;
use serde::Deserialize;
use serde_json::Value;
use serde_json::value::RawValue;

use super::edits::{Edits, parse};

/// The stand-in for a freed accessor: one zero, without bytes.
pub(super) const NO_ACCESSOR: &str = r#"{"componentType":5126,"count":1,"type":"SCALAR"}"#;
/// The stand-in for a freed view.
pub(super) const NO_VIEW: &str = r#"{"buffer":0,"byteLength":1}"#;

/// The unit in bytes by which remaining data is moved, so that every number keeps its alignment.
const ALIGNMENT: usize = 4;

/// The prefixes of extensions whose numbers are known not to be accessors.
const WITHOUT_ACCESSORS: [&str; 5] = ["VRM", "KHR_materials", "KHR_texture", "KHR_lights", "EXT_texture"];

/// The extensions of views with streams.
const STREAMS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// The animations of a file that added animations replace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Replaced {
    None,
    All,
    /// The animation with this index.
    One(usize),
}

impl Replaced {
    /// Whether the animation with this index is replaced.
    fn takes(self, animation: usize) -> bool {
        match self {
            Self::None => false,
            Self::All => true,
            Self::One(index) => index == animation,
        }
    }
}

/// The accessors, views and bytes that are freed.
pub(super) struct FreedSpace {
    pub(super) accessors: Vec<bool>,
    pub(super) views: Vec<bool>,
    /// The remaining ranges of the binary chunk, and their new positions.
    parts: Vec<(Range<usize>, usize)>,
}

impl FreedSpace {
    /// The data that is freed if the `replaced` animations are removed from the file with this text. `chunk` is the
    /// length of the binary chunk, which is its first buffer.
    pub(super) fn by(text: &str, replaced: Replaced, chunk: usize) -> Result<Self> {
        let file: Value = parse(text)?;
        let list = |name: &str| file[name].as_array().map_or(&[][..], Vec::as_slice);
        let (accessors, views) = (list("accessors"), list("bufferViews"));
        let mut freed = Self {
            accessors: vec![false; accessors.len()],
            views: vec![false; views.len()],
            parts: vec![(0..chunk, 0)],
        };
        let (mut gone, mut used) = (BTreeSet::new(), BTreeSet::new());
        for (index, animation) in list("animations").iter().enumerate() {
            match replaced.takes(index) {
                true => of_samplers(animation, &mut gone),
                false => of_samplers(animation, &mut used),
            }
        }
        if gone.is_empty() {
            return Ok(freed);
        }
        of_meshes_and_skins(&file, &mut used);
        of_extensions(&file, &mut used);
        for index in gone.difference(&used).filter(|&&index| index < accessors.len()) {
            freed.accessors[*index] = true;
        }
        let mut live = BTreeSet::new();
        for (name, section) in file.as_object().into_iter().flatten() {
            if name != "accessors" {
                views_in(section, &mut live);
            }
        }
        let mut dead = BTreeSet::new();
        for (accessor, is_freed) in std::iter::zip(accessors, &freed.accessors) {
            views_in(accessor, if *is_freed { &mut dead } else { &mut live });
        }
        for index in dead.difference(&live).filter(|&&index| index < views.len()) {
            freed.views[*index] = true;
        }
        freed.parts = freed.parts_that_stay(views, chunk);
        Ok(freed)
    }

    /// The ranges of the chunk that stay: all except the ranges that only freed views use.
    fn parts_that_stay(&self, views: &[Value], chunk: usize) -> Vec<(Range<usize>, usize)> {
        // The changes in the number of freed views, and of other views, at each byte.
        let mut changes: BTreeMap<usize, [i64; 2]> = BTreeMap::from([(0, [0; 2]), (chunk, [0; 2])]);
        for (view, is_freed) in std::iter::zip(views, &self.views) {
            for range in ranges_of(view).filter(|range| range.end <= chunk) {
                changes.entry(range.start).or_default()[usize::from(!is_freed)] += 1;
                changes.entry(range.end).or_default()[usize::from(!is_freed)] -= 1;
            }
        }
        let mut parts: Vec<(Range<usize>, usize)> = Vec::new();
        let ends = changes.keys().skip(1);
        let (mut freed, mut others) = (0, 0);
        for ((&start, change), &end) in std::iter::zip(&changes, ends) {
            freed += change[0];
            others += change[1];
            if freed > 0 && others == 0 {
                continue;
            }
            match parts.last_mut().filter(|(last, _)| last.end == start) {
                Some((last, _)) => last.end = end,
                None => {
                    let free = parts.last().map_or(0, |(last, begin)| begin + last.len());
                    let begin = free + (ALIGNMENT + start % ALIGNMENT - free % ALIGNMENT) % ALIGNMENT;
                    parts.push((start..end, begin));
                }
            }
        }
        parts
    }

    /// The number of remaining accessors, which precede the added accessors.
    pub(super) fn first_accessor(&self) -> usize {
        kept(&self.accessors)
    }

    /// The number of remaining views, which precede the added views.
    pub(super) fn first_view(&self) -> usize {
        kept(&self.views)
    }

    /// The length of [`Self::chunk`].
    pub(super) fn chunk_length(&self) -> usize {
        self.parts.last().map_or(0, |(range, begin)| begin + range.len())
    }

    /// The binary chunk without the freed ranges.
    pub(super) fn chunk(&self, bin: &[u8]) -> Vec<u8> {
        let mut chunk = vec![0; self.chunk_length()];
        for (range, begin) in &self.parts {
            chunk[*begin..begin + range.len()].copy_from_slice(&bin[range.clone()]);
        }
        chunk
    }

    /// Writes the new byte positions of the remaining views.
    pub(super) fn move_views<'a>(&self, edits: &mut Edits<'a>, section: Option<&'a RawValue>) -> Result<()> {
        let views: Vec<&RawValue> = section.map_or(Ok(Vec::new()), |section| parse(section.get()))?;
        for (view, _) in std::iter::zip(views, &self.views).filter(|(_, is_freed)| !**is_freed) {
            let view: View<'_> = parse(view.get())?;
            let streams = view
                .extensions
                .iter()
                .flat_map(|all| [all.ext.as_deref(), all.khr.as_deref()]);
            let views_of_buffer = streams.flatten().chain([&view]).filter(|view| view.buffer == 0);
            for offset in views_of_buffer.filter_map(|view| view.byte_offset) {
                let old: usize = parse(offset.get())?;
                let holds = |(range, _): &&(Range<usize>, usize)| range.contains(&old);
                let new = self
                    .parts
                    .iter()
                    .find(holds)
                    .map(|(range, begin)| begin + old - range.start);
                if let Some(new) = new.filter(|new| *new != old) {
                    edits.replace(offset, new.to_string());
                }
            }
        }
        Ok(())
    }
}

/// The members of a buffer view, or of its compressed stream, as the file states them.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct View<'a> {
    buffer: usize,
    #[serde(borrow)]
    byte_offset: Option<&'a RawValue>,
    #[serde(borrow, default)]
    extensions: Option<Extensions<'a>>,
}

/// The streams of a view.
#[derive(Deserialize)]
struct Extensions<'a> {
    #[serde(borrow, rename = "EXT_meshopt_compression")]
    ext: Option<Box<View<'a>>>,
    #[serde(borrow, rename = "KHR_meshopt_compression")]
    khr: Option<Box<View<'a>>>,
}

/// The number of items up to the last item that is not freed.
fn kept(is_freed: &[bool]) -> usize {
    is_freed
        .iter()
        .rposition(|is_freed| !is_freed)
        .map_or(0, |last| last + 1)
}

/// The bytes of the first buffer that a view uses, directly and by its stream.
fn ranges_of(view: &Value) -> impl Iterator<Item = Range<usize>> {
    let streams = STREAMS.into_iter().filter_map(|name| view.get("extensions")?.get(name));
    let ranges = streams
        .chain([view])
        .filter(|view| view["buffer"] == 0)
        .filter_map(|range| {
            let start = range.get("byteOffset").map_or(Some(0), index_of)?;
            Some(start..start.checked_add(index_of(range.get("byteLength")?)?)?)
        });
    ranges.collect::<Vec<_>>().into_iter()
}

fn index_of(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|number| usize::try_from(number).ok())
}

fn of_samplers(animation: &Value, found: &mut BTreeSet<usize>) {
    let samplers = animation["samplers"].as_array().into_iter().flatten();
    found.extend(samplers.flat_map(|sampler| {
        ["input", "output"]
            .into_iter()
            .filter_map(|name| index_of(&sampler[name]))
    }));
}

/// The accessors that are used outside of extensions.
fn of_meshes_and_skins(file: &Value, found: &mut BTreeSet<usize>) {
    let items = |value: &Value| value.as_array().cloned().unwrap_or_default();
    for primitive in items(&file["meshes"])
        .iter()
        .flat_map(|mesh| items(&mesh["primitives"]))
    {
        all_numbers(&primitive["attributes"], found);
        all_numbers(&primitive["indices"], found);
        all_numbers(&primitive["targets"], found);
    }
    for skin in items(&file["skins"]) {
        all_numbers(&skin["inverseBindMatrices"], found);
    }
}

/// All numbers in extensions that may mean accessors.
fn of_extensions(value: &Value, found: &mut BTreeSet<usize>) {
    match value {
        Value::Array(items) => items.iter().for_each(|item| of_extensions(item, found)),
        Value::Object(members) => {
            for (name, member) in members {
                match (name.as_str(), member) {
                    ("extensions", Value::Object(extensions)) => {
                        let may_mean = |name: &str| !WITHOUT_ACCESSORS.iter().any(|known| name.starts_with(known));
                        let extensions = extensions.iter().filter(|(name, _)| may_mean(name));
                        let extensions = extensions.filter(|(name, _)| !STREAMS.contains(&name.as_str()));
                        extensions.for_each(|(_, extension)| all_numbers(extension, found));
                    }
                    _ => of_extensions(member, found),
                }
            }
        }
        _ => {}
    }
}

/// All integers in a value.
fn all_numbers(value: &Value, found: &mut BTreeSet<usize>) {
    match value {
        Value::Array(items) => items.iter().for_each(|item| all_numbers(item, found)),
        Value::Object(members) => members.values().for_each(|member| all_numbers(member, found)),
        value => found.extend(index_of(value)),
    }
}

/// All numbers named `bufferView` in a value.
fn views_in(value: &Value, found: &mut BTreeSet<usize>) {
    match value {
        Value::Array(items) => items.iter().for_each(|item| views_in(item, found)),
        Value::Object(members) => {
            for (name, member) in members {
                match name.as_str() {
                    "bufferView" => found.extend(index_of(member)),
                    _ => views_in(member, found),
                }
            }
        }
        _ => {}
    }
}
