//! Adds animations to an existing glTF file by editing its text: everything else keeps its bytes.

use gltf_json::Index;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::pose::Trs;
use mocap_scene::scene::{self, Animation, Scene};
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use serde_json::{Value, json};

use super::super::face::MorphTrack;
use super::super::json::{self, MAGIC};
use super::animation::{self, Nodes};
use super::buffer::{self as writer, Base, buffer as buffer_of};
use super::container::{bin_name, unwritable, uri_of_buffer};
use super::edits::{Edits, parse, utf8};
pub(in super::super) use super::freed::Replaced;
use super::freed::{FreedSpace, NO_ACCESSOR, NO_VIEW};
use super::glb::Glb;
use super::rest::Rest;
use super::{BufferPlace, GltfOptions, GltfReport, morphs, text};
use crate::ExportFile;
use crate::provenance::Provenance;

/// The sections of a file that may change, as the file states them.
#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Sections<'a> {
    #[serde(borrow)]
    scenes: Option<&'a RawValue>,
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
    #[serde(borrow)]
    extensions_used: Option<&'a RawValue>,
    #[serde(borrow)]
    extensions_required: Option<&'a RawValue>,
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

/// The external files to which the file refers.
pub(in super::super) fn external_files(bytes: &[u8]) -> Result<Vec<String>> {
    let (text, _) = json::split(bytes)?;
    let text = utf8(text)?;
    let sections: Sections<'_> = parse(text)?;
    let mut uris = Vec::new();
    for section in [sections.buffers, sections.images].into_iter().flatten() {
        let items: Vec<Image> = parse(section.get())?;
        uris.extend(items.into_iter().filter_map(|item| item.uri));
    }
    uris.retain(|uri| !uri.starts_with("data:"));
    Ok(uris)
}

/// The root nodes of a scene of the file.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Roots<'a> {
    #[serde(borrow)]
    nodes: Vec<&'a RawValue>,
}

/// The items of an array of the root.
fn list(section: Option<&RawValue>) -> Result<Vec<&RawValue>> {
    section.map_or(Ok(Vec::new()), |section| parse(section.get()))
}

/// The file with a new parent node for one of its roots, and the index of the new node.
pub(in super::super) fn with_root(bytes: &[u8], root: usize, name: &str) -> Result<(Vec<u8>, usize)> {
    let (text, bin) = json::split(bytes)?;
    let text = utf8(text)?;
    let sections: Sections<'_> = parse(text)?;
    let count = list(sections.nodes)?.len();
    let mut edits = Edits::new(text);
    let node = json!({ "name": name, "children": [root] }).to_string();
    edits.append("nodes", sections.nodes, &[node])?;
    for scene in list(sections.scenes)? {
        let roots: Roots<'_> = parse(scene.get())?;
        for number in roots.nodes.iter().filter(|index| index.get().parse() == Ok(root)) {
            edits.replace(number, count.to_string());
        }
    }
    let text = edits.finish();
    if !bytes.starts_with(MAGIC) {
        return Ok((text.into_bytes(), count));
    }
    let glb = Glb::new(text.into_bytes(), bin.map(<[u8]>::len), json::further_chunks(bytes)?)?;
    Ok((glb.around(bin.unwrap_or_default()), count))
}

/// The nodes of a file as a scene, with the file index of each scene node.
pub(in super::super) struct Skeleton<'a> {
    pub(in super::super) scene: &'a Scene,
    pub(in super::super) nodes: &'a [Option<usize>],
}

/// An added animation.
pub(in super::super) struct Clip<'a> {
    pub(in super::super) animation: &'a Animation,
    pub(in super::super) provenance: Option<&'a Provenance>,
    pub(in super::super) morphs: &'a [MorphTrack],
    /// The extras of the source clip.
    pub(in super::super) extras: Option<Value>,
}

/// The file with animations of a skeleton, each with its provenance if known. Data that only replaced animations need
/// is removed.
pub(in super::super) fn with_animations(
    bytes: &[u8],
    skeleton: &Skeleton<'_>,
    clips: &[Clip<'_>],
    replaced: Replaced,
    options: &GltfOptions,
    name: &str,
) -> Result<(Vec<ExportFile>, GltfReport)> {
    let is_glb = bytes.starts_with(MAGIC);
    let (text, bin) = json::split(bytes)?;
    let text = utf8(text)?;
    let sections: Sections<'_> = parse(text)?;
    let buffers: Vec<Buffer<'_>> = sections
        .buffers
        .map_or(Ok(Vec::new()), |section| parse(section.get()))?;
    // The binary chunk of a .glb is its first buffer. If the first buffer is another file, or a placeholder, the keys
    // get a separate buffer.
    let in_chunk = is_glb && buffers.first().is_none_or(|first| first.uri.is_none() && bin.is_some());
    let freed = FreedSpace::by(text, replaced, bin.filter(|_| in_chunk).map_or(0, <[u8]>::len))?;
    let base = match in_chunk {
        true => Base {
            buffer: 0,
            bytes: freed.chunk_length().next_multiple_of(4),
            placeholder: buffers.len().max(1),
            views: freed.first_view(),
            accessors: freed.first_accessor(),
        },
        false => Base {
            buffer: buffers.len(),
            bytes: 0,
            placeholder: buffers.len() + 1,
            views: freed.first_view(),
            accessors: freed.first_accessor(),
        },
    };
    let mut added = AddedAnimations::new(skeleton, base);
    for clip in clips {
        added.clip(clip, options)?;
    }
    let AddedAnimations {
        animations: written,
        buffer,
        mut driven,
        mut report,
        ..
    } = added;
    let parts = buffer.finish(options.compression)?;
    let mut edits = Edits::new(text);
    edits.matrices(sections.nodes, &mut driven)?;
    replace_animations(&mut edits, sections.animations, replaced, &items(&written)?)?;
    let (accessors, views) = (items(&parts.accessors)?, items(&parts.views)?);
    edits.exchange(
        "accessors",
        sections.accessors,
        &freed.accessors,
        NO_ACCESSOR,
        &accessors,
    )?;
    freed.move_views(&mut edits, sections.buffer_views)?;
    edits.exchange("bufferViews", sections.buffer_views, &freed.views, NO_VIEW, &views)?;
    let is_beside = !is_glb && options.buffer == BufferPlace::Beside && !parts.bytes.is_empty();
    let beside = is_beside.then(|| bin_name(name));
    if let Some(taken) = beside
        .as_ref()
        .filter(|beside| external_files(bytes).is_ok_and(|files| files.contains(beside)))
    {
        let message = format!("the buffer of the clips would be {taken}, which is a file of the character");
        return Err(Diagnostic::new(Code::OutputExists, message)
            .help("name another output, or embed the buffer")
            .into());
    }
    let mut new_buffers = Vec::new();
    match (in_chunk, buffers.first()) {
        (true, Some(first)) => edits.replace(first.byte_length, (base.bytes + parts.bytes.len()).to_string()),
        (true, None) => new_buffers.push(buffer_of(base.bytes + parts.bytes.len(), None)),
        (false, _) => {
            let uri = uri_of_buffer(beside.as_deref(), &parts.bytes);
            new_buffers.push(buffer_of(parts.bytes.len(), Some(uri)));
        }
    }
    if let Some((placeholder, extension)) = parts.streams {
        new_buffers.push(placeholder);
        edits.extension("extensionsUsed", sections.extensions_used, extension)?;
        edits.extension("extensionsRequired", sections.extensions_required, extension)?;
    }
    edits.append("buffers", sections.buffers, &items(&new_buffers)?)?;
    let text = edits.finish();
    let mut keys = parts.bytes;
    let file = if is_glb {
        let mut chunk = bin.map(|bin| if in_chunk { freed.chunk(bin) } else { bin.to_vec() });
        match in_chunk {
            true => chunk.get_or_insert_default().resize(base.bytes, 0),
            false => keys.clear(),
        }
        let length = chunk.as_ref().map(|chunk| chunk.len() + keys.len());
        let Glb { head, tail } = Glb::new(text.into_bytes(), length, json::further_chunks(bytes)?)?;
        vec![head, chunk.unwrap_or_default(), std::mem::take(&mut keys), tail]
    } else {
        let mark = bytes.len() - bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes).len();
        vec![bytes[..mark].to_vec(), text.into_bytes()]
    };
    let beside = beside.map(|beside| ExportFile::new(beside, keys));
    let file = ExportFile::of_parts(name, file);
    let files = Vec::from_iter(beside.into_iter().chain([file]));
    report.bytes = files.iter().map(ExportFile::len).sum();
    Ok((files, report))
}

/// Inserts animations at the place of the replaced animations, or after the animations of the file.
fn replace_animations<'a>(
    edits: &mut Edits<'a>,
    section: Option<&'a RawValue>,
    replaced: Replaced,
    written: &[String],
) -> Result<()> {
    let present = list(section)?;
    match (section, replaced, written.is_empty()) {
        (_, _, true) => {}
        (Some(section), Replaced::All, _) => edits.replace(section, format!("[{}]", written.join(","))),
        (_, Replaced::One(index), _) if index < present.len() => edits.replace(present[index], written.join(",")),
        _ => edits.append("animations", section, written)?,
    }
    Ok(())
}

/// The JSON text of each item.
fn items<T: Serialize>(items: &[T]) -> Result<Vec<String>> {
    items
        .iter()
        .map(|item| text::item(item).map_err(|error| unwritable(&error)))
        .collect()
}

/// The added animations, and their keys.
struct AddedAnimations<'a> {
    skeleton: &'a Skeleton<'a>,
    /// The rest transforms of the nodes, which stay unchanged.
    rest: Vec<Rest>,
    animations: Vec<text::Animation>,
    buffer: writer::Buffer,
    /// The animated nodes of the file, with their rest transforms.
    driven: Vec<(usize, Trs)>,
    report: GltfReport,
}

impl<'a> AddedAnimations<'a> {
    fn new(skeleton: &'a Skeleton<'a>, base: Base) -> Self {
        let rest = |node: &scene::Node| {
            let rest = Trs::from_matrix(node.transform);
            Rest {
                translation: rest.translation,
                rotation: rest.rotation,
                scale: rest.scale,
            }
        };
        Self {
            skeleton,
            rest: skeleton.scene.nodes.iter().map(rest).collect(),
            animations: Vec::new(),
            buffer: writer::Buffer::after(base),
            driven: Vec::new(),
            report: GltfReport::default(),
        }
    }

    /// # Errors
    /// The clip moves no node of the file, or a value is not finite, or the error bound cannot be kept.
    fn clip(&mut self, clip: &Clip<'_>, options: &GltfOptions) -> Result<()> {
        let Clip {
            animation,
            provenance,
            morphs: tracks,
            ref extras,
        } = *clip;
        let Skeleton { scene, nodes } = *self.skeleton;
        let (buffer, report) = (&mut self.buffer, &mut self.report);
        let nodes_of_file = Nodes::PassedThrough;
        let written = animation::write(scene, animation, &mut self.rest, nodes_of_file, options, buffer, report)?;
        let mut written = written.unwrap_or_else(text::Animation::empty);
        written.channels.retain_mut(|channel| {
            let node = channel.target.node.value();
            let Some(index) = nodes.get(node).copied().flatten() else {
                return false;
            };
            channel.target.node = Index::new(index as u32);
            self.driven.push((index, Trs::from_matrix(scene.nodes[node].transform)));
            true
        });
        if written.channels.is_empty() && tracks.is_empty() {
            let message = format!("the animation \"{}\" moves no node of the file", animation.name);
            return Err(Diagnostic::new(Code::Unrepresentable, message).into());
        }
        for track in tracks {
            morphs::write(&mut written, track, animation.ticks_per_second, buffer, report);
        }
        written.name = Some(animation.name.clone());
        written.set_extras(extras.clone(), provenance.map(|provenance| json!(provenance)));
        self.animations.push(written);
        Ok(())
    }
}
