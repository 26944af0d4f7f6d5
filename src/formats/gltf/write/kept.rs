//! Writes a scene into the file from which it was read, if that file has meshes. Everything but the animations is kept.

use std::collections::HashSet;
use std::path::Path;

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::{MorphCurves, Original, Scene};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::super::json::{self, MAGIC};
use super::container::{bin_name, data_uri, uri_of_buffer};
use super::edits::{Edits, parse, utf8};
use super::glb::Glb;
use super::patch::{self, Clip, Replaced, Skeleton};
use super::{BufferPlace, GltfOptions, morphs};
use crate::gltf;
use crate::provenance::Provenance;
use crate::{Export, ExportFile, WriteOptions};

/// The lists of items that may be in separate files.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Lists<'a> {
    #[serde(borrow)]
    buffers: Vec<&'a RawValue>,
    #[serde(borrow)]
    images: Vec<&'a RawValue>,
}

/// A buffer or an image.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Item<'a> {
    #[serde(borrow)]
    uri: Option<&'a RawValue>,
    mime_type: Option<String>,
}

/// The channels of animations, with their targets.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Animations {
    animations: Vec<Channels>,
}

#[derive(Deserialize)]
struct Channels {
    channels: Vec<Channel>,
}

#[derive(Deserialize)]
struct Channel {
    target: Target,
}

#[derive(Deserialize)]
struct Target {
    path: String,
    node: Option<usize>,
}

/// Writes a scene into its original file. The result is a `.gltf` if the name has that extension, otherwise a `.glb`.
pub(super) fn files(scene: &Scene, original: &Original, options: &WriteOptions, gltf: &GltfOptions) -> Result<Export> {
    original.check(scene)?;
    let file = &*original.file;
    // Clips refer to the transforms of the file's nodes. A scene with a bind pose has other transforms.
    let in_file = Scene {
        nodes: file.in_file.clone(),
        ..Scene::default()
    };
    let provenances: Vec<Provenance> = (0..scene.animations.len())
        .map(|index| Provenance::of_kept(scene, index, const { &gltf::FORMAT.without_functions() }))
        .collect();
    let morphs: Vec<_> = (0..scene.animations.len())
        .map(|index| morphs::tracks(original, index))
        .collect();
    let clips: Vec<_> = (scene.animations.iter().zip(&provenances).zip(&morphs).enumerate())
        .map(|(index, ((animation, provenance), morphs))| Clip {
            animation,
            provenance: Some(provenance),
            morphs,
            extras: scene.clip_extras(index),
        })
        .collect();
    let skeleton = Skeleton {
        scene: &in_file,
        nodes: &file.indices,
    };
    let replaced = original.replaced.map_or(Replaced::All, Replaced::One);
    let bytes = with_files_beside(&file.bytes, &file.beside)?;
    let (name, is_text, was_text) = (&options.name, options.has_extension("gltf"), !bytes.starts_with(MAGIC));
    let mut embedded = gltf.clone();
    if !is_text {
        embedded.buffer = BufferPlace::Embedded;
    }
    let (mut files, report) = patch::with_animations(&bytes, &skeleton, &clips, replaced, &embedded, name)?;
    if is_text != was_text {
        let bytes = files.pop().map(ExportFile::into_bytes).unwrap_or_default();
        files = match is_text {
            true => text_and_bin(name, &bytes, gltf.buffer)?,
            false => vec![ExportFile::new(name, glb_of_text(&bytes)?)],
        };
    }
    let mut written = Export {
        files,
        nodes: scene.nodes.len(),
        ..report.written()
    };
    written.warnings.extend(left_out(original)?);
    Ok(written)
}

/// Warns about channels that are lost with the replaced animations. A scene has no channels for pointers, and none for
/// morph targets that the file lacks.
fn left_out(original: &Original) -> Result<Option<Diagnostic>> {
    let Animations { animations } = parse(utf8(json::split(&original.file.bytes)?.0)?)?;
    let gone = animations.iter().enumerate();
    let gone = gone.filter(|(index, _)| original.replaced.is_none_or(|replaced| replaced == *index));
    let has_curves = |curves: &&MorphCurves| curves.targets.iter().any(|animations| !animations.is_empty());
    let morphs: HashSet<usize> = original
        .morphs
        .iter()
        .filter(has_curves)
        .map(|curves| curves.node)
        .collect();
    let is_kept = |Target { path, node }: &Target| match path.as_str() {
        "translation" | "rotation" | "scale" => true,
        "weights" => node.is_some_and(|node| morphs.contains(&node)),
        _ => false,
    };
    let channels = gone.flat_map(|(_, animation)| &animation.channels);
    let count = channels.filter(|channel| !is_kept(&channel.target)).count();
    let message =
        format!("channels of morph targets and pointers in the replaced animation, which are dropped: {count}");
    let diagnostic =
        || Diagnostic::new(Code::IgnoredChannel, message).help("mocap retarget adds a clip and keeps these channels");
    Ok((count > 0).then(diagnostic))
}

/// The file with its companion files embedded as data URIs, because an output in another folder would not find them.
fn with_files_beside(bytes: &[u8], beside: &[(String, Vec<u8>)]) -> Result<Vec<u8>> {
    if beside.is_empty() || bytes.starts_with(MAGIC) {
        return Ok(bytes.to_vec());
    }
    let text = utf8(json::split(bytes)?.0)?;
    let mut edits = Edits::new(text);
    let Lists { buffers, images } = parse(text)?;
    for item in buffers.into_iter().chain(images) {
        let item: Item<'_> = parse(item.get())?;
        let Some(uri) = item.uri else { continue };
        let named: String = parse(uri.get())?;
        let Some((_, contents)) = beside.iter().find(|(name, _)| *name == named) else {
            continue;
        };
        let kind = item.mime_type.unwrap_or_else(|| kind_of(&named).to_owned());
        edits.replace(uri, format!("\"{}\"", data_uri(&kind, contents)));
    }
    Ok(edits.finish().into_bytes())
}

/// The media type of a file from its name.
fn kind_of(name: &str) -> &'static str {
    let extension = Path::new(name).extension().unwrap_or_default().to_ascii_lowercase();
    match extension.to_str() {
        Some("png") => "image/png",
        Some("jpg" | "jpeg") => "image/jpeg",
        Some("webp") => "image/webp",
        Some("ktx2") => "image/ktx2",
        _ => "application/octet-stream",
    }
}

/// A `.glb` as its JSON document and its buffer.
fn text_and_bin(name: &str, glb: &[u8], embedded: BufferPlace) -> Result<Vec<ExportFile>> {
    let (text, bin) = json::split(glb)?;
    let text = utf8(text)?.trim_end();
    let mut edits = Edits::new(text);
    let Lists { buffers, .. } = parse(text)?;
    let (Some(bin), Some(buffer)) = (bin, buffers.first()) else {
        return Ok(vec![ExportFile::new(name, text.as_bytes().to_vec())]);
    };
    let beside = (embedded == BufferPlace::Beside).then(|| bin_name(name));
    let uri = uri_of_buffer(beside.as_deref(), bin);
    edits.insert_in(buffer, format!("\"uri\":\"{uri}\","));
    let text = ExportFile::new(name, edits.finish().into_bytes());
    let beside = beside.map(|beside| ExportFile::new(beside, bin.to_vec()));
    Ok(beside.into_iter().chain([text]).collect())
}

/// A `.glb` from a JSON document whose buffers are data URIs.
fn glb_of_text(text: &[u8]) -> Result<Vec<u8>> {
    let (text, _) = json::split(text)?;
    Ok(Glb::new(text.to_vec(), None, &[])?.around(&[]))
}
