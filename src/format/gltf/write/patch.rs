//! Adds animations to a glTF file that is there, as edits of its text: everything else keeps its bytes.

use std::ops::Range;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Deserialize;
use serde_json::value::RawValue;
use serde_json::{Value, json};

use super::super::Provenance;
use super::super::invalid::invalid;
use super::super::json::{self, MAGIC};
use crate::error::{Code, Diagnostic, Result};
use crate::format::Failure;
use crate::pose::Trs;
use crate::scene::{Animation, Keys, Scene};

/// The sections of a file that may change, as they are written there.
#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Sections<'a> {
    #[serde(borrow)]
    nodes: Option<&'a RawValue>,
    #[serde(borrow)]
    animations: Option<&'a RawValue>,
    #[serde(borrow)]
    accessors: Option<&'a RawValue>,
    #[serde(borrow)]
    buffer_views: Option<&'a RawValue>,
    #[serde(borrow)]
    buffers: Option<&'a RawValue>,
    #[serde(borrow)]
    images: Option<&'a RawValue>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Buffer<'a> {
    #[serde(borrow)]
    byte_length: &'a RawValue,
    #[serde(borrow)]
    uri: Option<&'a RawValue>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Image {
    uri: Option<String>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Node<'a> {
    #[serde(borrow)]
    matrix: Option<&'a RawValue>,
}

/// What the file refers to and does not hold.
pub(in super::super) fn external_files(bytes: &[u8]) -> Result<Vec<String>> {
    let (text, _) = json::split(bytes)?;
    let text = utf8(text)?;
    let sections = sections(text)?;
    let mut uris = Vec::new();
    for section in [sections.buffers, sections.images].into_iter().flatten() {
        let items: Vec<Image> = parse(section.get())?;
        uris.extend(items.into_iter().filter_map(|item| item.uri));
    }
    uris.retain(|uri| !uri.starts_with("data:"));
    Ok(uris)
}

/// The file with the animations of the scene's nodes, whose indices in the file are `nodes`; each with its provenance,
/// where that is known.
pub(in super::super) fn with_animations(
    bytes: &[u8],
    scene: &Scene,
    nodes: &[Option<usize>],
    animations: &[(&Animation, Option<&Provenance>)],
    replace: bool,
) -> Result<Vec<u8>> {
    let is_glb = bytes.starts_with(MAGIC);
    let (text, bin) = json::split(bytes)?;
    let text = utf8(text)?;
    let sections = sections(text)?;
    let count = |section: Option<&RawValue>| -> Result<usize> {
        Ok(section
            .map(|section| parse::<Vec<&RawValue>>(section.get()))
            .transpose()?
            .map_or(0, |items| items.len()))
    };
    let buffers: Vec<Buffer<'_>> = sections
        .buffers
        .map_or(Ok(Vec::new()), |section| parse(section.get()))?;
    // The binary chunk of a .glb is its first buffer. Where that is another file, or a placeholder, the keys are a
    // buffer of their own.
    let in_chunk = is_glb && buffers.first().is_none_or(|first| first.uri.is_none() && bin.is_some());
    let (buffer, start) = match in_chunk {
        true => (0, bin.map_or(0, <[u8]>::len).next_multiple_of(4)),
        false => (buffers.len(), 0),
    };
    let mut added = Added {
        buffer,
        start,
        first_view: count(sections.buffer_views)?,
        first_accessor: count(sections.accessors)?,
        ..Added::default()
    };
    let mut driven = Vec::new();
    let mut written = Vec::new();
    for (animation, provenance) in animations {
        let mut json = added.animation(scene, nodes, animation, &mut driven)?;
        if let Some(provenance) = provenance {
            json["extras"] = json!({ "mocap": provenance });
        }
        written.push(json);
    }
    let end = start + added.bytes.len();
    let mut edits = Edits {
        text,
        edits: Vec::new(),
    };
    edits.matrices(sections.nodes, &mut driven)?;
    match sections.animations.filter(|_| replace) {
        Some(section) => edits.replace(section, Value::Array(written).to_string()),
        None => edits.append("animations", sections.animations, &written)?,
    }
    edits.append("accessors", sections.accessors, &added.accessors)?;
    edits.append("bufferViews", sections.buffer_views, &added.views)?;
    match (in_chunk, buffers.first()) {
        (true, Some(first)) => edits.replace(first.byte_length, end.to_string()),
        (true, None) => edits.append("buffers", sections.buffers, &[json!({ "byteLength": end })])?,
        (false, _) => {
            let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&added.bytes));
            let own = json!({ "byteLength": added.bytes.len(), "uri": uri });
            edits.append("buffers", sections.buffers, &[own])?;
        }
    }
    let text = edits.finish();
    if !is_glb {
        let mark = bytes.len() - bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes).len();
        return Ok([&bytes[..mark], text.as_bytes()].concat());
    }
    let mut chunk = bin.map(<[u8]>::to_vec);
    if in_chunk {
        let chunk = chunk.get_or_insert_default();
        chunk.resize(start, 0);
        chunk.extend(added.bytes);
    }
    glb(text.into_bytes(), chunk.as_deref(), json::further_chunks(bytes)?)
}

fn utf8(text: &[u8]) -> Result<&str, Failure> {
    std::str::from_utf8(text).map_err(|error| {
        let message = format!(
            "the JSON is not UTF-8 from byte {} on, so it cannot be passed through",
            error.valid_up_to()
        );
        invalid("", message).into()
    })
}

fn sections(text: &str) -> Result<Sections<'_>> {
    parse(text)
}

fn parse<'a, T: Deserialize<'a>>(text: &'a str) -> Result<T> {
    serde_json::from_str(text).map_err(|error| invalid("", format!("the JSON cannot be read: {error}")).into())
}

/// A `.glb` of these chunks.
fn glb(mut text: Vec<u8>, bin: Option<&[u8]>, further: &[u8]) -> Result<Vec<u8>> {
    text.resize(text.len().next_multiple_of(4), b' ');
    let padded = bin.map(|bin| bin.len().next_multiple_of(4));
    let length = 12 + 8 + text.len() + padded.map_or(0, |padded| 8 + padded) + further.len();
    if u32::try_from(length).is_err() {
        let message = "the file would be larger than the 4 GiB that a .glb can hold";
        return Err(Diagnostic::new(Code::LimitExceeded, message)
            .help("write fewer frames")
            .into());
    }
    let number = |length: usize| (length as u32).to_le_bytes();
    let mut bytes = Vec::with_capacity(length);
    bytes.extend_from_slice(MAGIC);
    bytes.extend(2_u32.to_le_bytes());
    bytes.extend(number(length));
    bytes.extend(number(text.len()));
    bytes.extend_from_slice(b"JSON");
    bytes.extend(text);
    if let (Some(bin), Some(padded)) = (bin, padded) {
        bytes.extend(number(padded));
        bytes.extend_from_slice(b"BIN\0");
        bytes.extend_from_slice(bin);
        bytes.resize(length - further.len(), 0);
    }
    bytes.extend_from_slice(further);
    Ok(bytes)
}

/// Changes of a text, each of a part of it.
struct Edits<'a> {
    text: &'a str,
    edits: Vec<(Range<usize>, String)>,
}

impl<'a> Edits<'a> {
    /// Where a part of the text is.
    fn range(&self, part: &str) -> Range<usize> {
        let start = part.as_ptr() as usize - self.text.as_ptr() as usize;
        start..start + part.len()
    }

    fn replace(&mut self, part: &RawValue, with: String) {
        let range = self.range(part.get());
        self.edits.push((range, with));
    }

    /// Appends items to an array of the root, which is added where the file lacks it.
    fn append(&mut self, name: &str, section: Option<&'a RawValue>, items: &[Value]) -> Result<()> {
        let items: Vec<String> = items.iter().map(Value::to_string).collect();
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

    /// Writes the matrix of a node that is animated as its three parts: glTF demands it.
    fn matrices(&mut self, nodes: Option<&'a RawValue>, driven: &mut Vec<(usize, Trs)>) -> Result<()> {
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

    fn finish(mut self) -> String {
        // Those at one place stay in their order.
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

/// The keys that are added, and how the file finds them.
#[derive(Default)]
struct Added {
    buffer: usize,
    /// Where the bytes begin in the buffer.
    start: usize,
    first_view: usize,
    first_accessor: usize,
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Added {
    /// A view and an accessor of their own for numbers, `width` in each element.
    fn push(&mut self, numbers: &[f32], width: usize) -> usize {
        let start = self.start + self.bytes.len();
        self.bytes
            .extend(numbers.iter().flat_map(|number| (number + 0.0).to_le_bytes()));
        self.views.push(json!({
            "buffer": self.buffer,
            "byteOffset": start,
            "byteLength": size_of_val(numbers),
        }));
        let mut accessor = json!({
            "bufferView": self.first_view + self.views.len() - 1,
            "componentType": 5126,
            "count": numbers.len() / width,
            "type": match width {
                1 => "SCALAR",
                3 => "VEC3",
                _ => "VEC4",
            },
        });
        if width == 1 {
            // Times ascend, and glTF demands their bounds.
            accessor["min"] = json!([numbers.first().map(|time| f64::from(*time))]);
            accessor["max"] = json!([numbers.last().map(|time| f64::from(*time))]);
        }
        self.accessors.push(accessor);
        self.first_accessor + self.accessors.len() - 1
    }

    /// Adds the keys of an animation, and the nodes that it moves to `driven`.
    fn animation(
        &mut self,
        scene: &Scene,
        nodes: &[Option<usize>],
        animation: &Animation,
        driven: &mut Vec<(usize, Trs)>,
    ) -> Result<Value> {
        let mut clocks: Vec<(Vec<u32>, usize)> = Vec::new();
        let (mut channels, mut samplers) = (Vec::new(), Vec::new());
        for channel in &animation.channels {
            let place = channel.node.and_then(|node| Some((node, (*nodes.get(node.index())?)?)));
            let Some((node, index)) = place else { continue };
            let rest = Trs::from_matrix(scene.nodes[node.index()].transform);
            let unchanged = |keys: &Keys<glam::Vec3>, rest: glam::Vec3| keys.values.iter().all(|value| *value == rest);
            let vectors = |keys: &Keys<glam::Vec3>| keys.values.iter().map(|value| value.to_array().to_vec()).collect();
            let turns: Vec<Vec<f32>> = channel
                .rotation_keys
                .values
                .iter()
                .map(|value| value.normalize().to_array().to_vec())
                .collect();
            let mut tracks: Vec<(&str, Vec<Vec<f32>>, Ticks<'_>)> = Vec::new();
            if !unchanged(&channel.position_keys, rest.translation) {
                tracks.push((
                    "translation",
                    vectors(&channel.position_keys),
                    Ticks::of(&channel.position_keys),
                ));
            }
            tracks.push(("rotation", turns, Ticks::of(&channel.rotation_keys)));
            if !unchanged(&channel.scaling_keys, rest.scale) {
                tracks.push((
                    "scale",
                    vectors(&channel.scaling_keys),
                    Ticks::of(&channel.scaling_keys),
                ));
            }
            for (path, values, ticks) in tracks {
                if values.is_empty() {
                    continue;
                }
                if values.iter().flatten().any(|number| !number.is_finite()) {
                    return Err(
                        Diagnostic::new(Code::Unrepresentable, format!("a {path} is not finite"))
                            .in_joint(&scene.nodes[node.index()].name)
                            .into(),
                    );
                }
                let (times, kept) = ticks.seconds(values.len(), animation.ticks_per_second);
                let width = values[0].len();
                let values: Vec<f32> = kept.iter().flat_map(|key| values[*key].iter().copied()).collect();
                let bits: Vec<u32> = times.iter().map(|time| time.to_bits()).collect();
                let clock = match clocks.iter().find(|(known, _)| *known == bits) {
                    Some((_, clock)) => *clock,
                    None => {
                        let clock = self.push(&times, 1);
                        clocks.push((bits, clock));
                        clock
                    }
                };
                let output = self.push(&values, width);
                channels.push(json!({ "sampler": samplers.len(), "target": { "node": index, "path": path } }));
                samplers.push(json!({ "input": clock, "interpolation": "LINEAR", "output": output }));
                driven.push((index, rest));
            }
        }
        if channels.is_empty() {
            let message = format!("the animation \"{}\" moves no node of the file", animation.name);
            return Err(Diagnostic::new(Code::Unrepresentable, message).into());
        }
        Ok(json!({ "name": animation.name, "channels": channels, "samplers": samplers }))
    }
}

/// The ticks of keys.
struct Ticks<'a>(Option<&'a [f64]>);

impl<'a> Ticks<'a> {
    fn of<T>(keys: &'a Keys<T>) -> Self {
        Self(keys.ticks.as_deref())
    }

    /// The times in seconds, and the keys that 32-bit times can tell apart.
    fn seconds(&self, count: usize, ticks_per_second: f64) -> (Vec<f32>, Vec<usize>) {
        let (mut times, mut kept): (Vec<f32>, Vec<usize>) = (Vec::new(), Vec::new());
        for key in 0..count {
            let tick = self.0.map_or(key as f64, |ticks| ticks[key]);
            let time = (tick / ticks_per_second) as f32;
            if times.last().is_none_or(|last| time > *last) {
                times.push(time);
                kept.push(key);
            }
        }
        (times, kept)
    }
}
