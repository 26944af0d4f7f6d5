//! The JSON of a glTF file, as far as motion needs it, and its container.
//!
//! Only the needed parts are parsed. So errors in other parts, such as materials, meshes or their extensions, do not
//! prevent reading the motion.

use mocap_scene::error::pointer;
use serde::Deserialize;
use serde_json::{Map, Value};

use super::humanoid::Extensions;
use super::invalid::{invalid, json_words};
pub(super) use super::{CHUNK_HEADER, HEADER, MAGIC};
use crate::Failure;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Root {
    pub(crate) asset: Asset,
    #[serde(default)]
    pub(crate) extensions_required: Vec<String>,
    pub(crate) scene: Option<usize>,
    #[serde(default)]
    pub(crate) scenes: Vec<Roots>,
    #[serde(default)]
    pub(crate) nodes: Vec<Node>,
    #[serde(default)]
    pub(crate) skins: Vec<Skin>,
    #[serde(default)]
    pub(crate) animations: Vec<Animation>,
    #[serde(default)]
    pub(super) accessors: Vec<Accessor>,
    #[serde(default)]
    pub(super) buffer_views: Vec<BufferView>,
    #[serde(default)]
    pub(super) buffers: Vec<Buffer>,
    #[serde(default)]
    pub(super) extensions: Extensions,
}

#[derive(Deserialize)]
pub(crate) struct Asset {
    version: Option<Value>,
    pub(super) extras: Option<Value>,
}

/// The root nodes of a scene.
#[derive(Deserialize)]
pub(crate) struct Roots {
    #[serde(default)]
    pub(crate) nodes: Vec<usize>,
}

#[derive(Deserialize)]
pub(crate) struct Node {
    pub(super) name: Option<String>,
    #[serde(default)]
    pub(super) children: Vec<usize>,
    pub(super) matrix: Option<[f32; 16]>,
    pub(super) translation: Option<[f32; 3]>,
    pub(super) rotation: Option<[f32; 4]>,
    pub(super) scale: Option<[f32; 3]>,
    pub(super) mesh: Option<usize>,
    pub(super) camera: Option<usize>,
    extras: Option<Value>,
}

impl Node {
    /// An extra of the node that this crate wrote.
    pub(super) fn extra(&self, key: &str) -> Option<&Value> {
        self.extras.as_ref()?.get(key)
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Skin {
    pub(crate) joints: Vec<usize>,
    pub(super) inverse_bind_matrices: Option<usize>,
}

#[derive(Deserialize)]
#[doc(hidden)]
pub struct Animation {
    #[doc(hidden)]
    pub name: Option<String>,
    pub(super) channels: Vec<Channel>,
    pub(super) samplers: Vec<Sampler>,
    pub(super) extras: Option<Value>,
}

#[derive(Deserialize)]
pub(super) struct Channel {
    pub(super) sampler: usize,
    pub(super) target: Target,
}

#[derive(Deserialize)]
pub(super) struct Target {
    pub(super) node: Option<usize>,
    pub(super) path: String,
    #[serde(default)]
    pub(super) extensions: Map<String, Value>,
}

#[derive(Deserialize)]
pub(super) struct Sampler {
    pub(super) input: usize,
    pub(super) output: usize,
    pub(super) interpolation: Option<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<usize>,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) component_type: u32,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) count: usize,
    #[serde(rename = "type")]
    pub(super) shape: String,
    pub(super) sparse: Option<Sparse>,
}

#[derive(Deserialize)]
pub(super) struct Sparse {
    pub(super) count: usize,
    pub(super) indices: SparsePart,
    pub(super) values: SparsePart,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SparsePart {
    pub(super) buffer_view: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    /// The number type of indices. The values have the number type of the accessor.
    pub(super) component_type: Option<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: usize,
    pub(super) byte_length: usize,
    pub(super) byte_stride: Option<usize>,
    #[serde(default)]
    pub(super) extensions: Map<String, Value>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub(super) uri: Option<String>,
    pub(super) byte_length: usize,
    #[serde(default)]
    pub(super) extensions: Map<String, Value>,
}

/// The JSON of a file, without a byte order mark, and the binary chunk of a `.glb`.
pub(super) fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Failure> {
    match bytes.starts_with(MAGIC) {
        true => {
            let chunks = chunks(bytes)?;
            Ok((chunks.json, chunks.bin))
        }
        false => Ok((bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes), None)),
    }
}

/// The chunks of a `.glb` that only extensions use, with their headers.
pub(super) fn further_chunks(bytes: &[u8]) -> Result<&[u8], Failure> {
    Ok(chunks(bytes)?.further)
}

/// The chunks of a `.glb`.
struct Chunks<'a> {
    json: &'a [u8],
    bin: Option<&'a [u8]>,
    /// The bytes after the JSON chunk and the binary chunk.
    further: &'a [u8],
}

/// Splits a file into its JSON and the binary chunk of a `.glb`.
pub(super) fn parse(bytes: &[u8]) -> Result<(Root, Option<&[u8]>), Failure> {
    let (json, bin) = split(bytes)?;
    // Names in another encoding are no reason to refuse the motion.
    let text = String::from_utf8_lossy(json);
    let root: Root = serde_json::from_str(&text).map_err(|error| {
        let message = format!("the JSON cannot be read: {}", json_words(&error));
        invalid(pointer(&text, &error), message)
    })?;
    let version = match &root.asset.version {
        Some(Value::String(version)) => version.clone(),
        Some(other) => other.to_string(),
        None => "none".to_owned(),
    };
    if !version.starts_with("2.") && version != "2" {
        return Err(invalid("/asset/version", "only glTF 2 is read")
            .expected_found("2.0", format!("\"{version}\""))
            .help("convert the file to glTF 2.0")
            .into());
    }
    Ok((root, bin))
}

fn chunks(bytes: &[u8]) -> Result<Chunks<'_>, Failure> {
    let number = |at: usize| -> Option<usize> {
        let bytes = bytes.get(at..at + 4)?.try_into().ok()?;
        Some(u32::from_le_bytes(bytes) as usize)
    };
    let cut_off = || invalid("", "the file ends within its header");
    let version = number(4).ok_or_else(cut_off)?;
    if version != 2 {
        return Err(invalid("", "only version 2 of the container is read")
            .expected_found("version 2", format!("version {version}"))
            .help("convert the file to glTF 2.0")
            .into());
    }
    let length = number(8).ok_or_else(cut_off)?;
    if length < HEADER + CHUNK_HEADER || length > bytes.len() {
        return Err(invalid("", "the length in the header differs from the file's length")
            .expected_found(format!("{} bytes", bytes.len()), format!("{length} bytes"))
            .help("the file is cut off: export or download it again")
            .into());
    }
    let (mut json, mut bin) = (None, None);
    let mut known = HEADER;
    let mut at = HEADER;
    while at + CHUNK_HEADER <= length {
        let (size, kind) = (number(at).ok_or_else(cut_off)?, &bytes[at + 4..at + 8]);
        let end = (at + CHUNK_HEADER).checked_add(size).filter(|&end| end <= length);
        let end = end.ok_or_else(|| {
            invalid("", "a chunk is longer than the file").expected_found(
                format!("at most {} bytes", length - at - CHUNK_HEADER),
                format!("{size} bytes"),
            )
        })?;
        let chunk = &bytes[at + CHUNK_HEADER..end];
        match kind {
            b"JSON" if json.is_none() => (json, known) = (Some(chunk), end),
            b"BIN\0" if bin.is_none() => (bin, known) = (Some(chunk), end),
            // Further chunks belong to extensions.
            _ => {}
        }
        at = end;
    }
    let json = json.ok_or_else(|| invalid("", "the file has no JSON chunk"))?;
    let further = &bytes[known..length];
    Ok(Chunks { json, bin, further })
}
