//! A glTF file in memory, and its animation tracks. The `gltf` crate reads the structure; the numbers are read here,
//! because every count and offset must be checked against the bytes of the file.

use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{Quat, Vec3};
use gltf::accessor::DataType;
use gltf::animation::{Channel, Interpolation, Property};
use gltf::json::mesh::Semantic;
use gltf::json::validation::Checked;
use gltf::{Accessor, Document, Gltf, buffer};

use super::{Provenance, streams};
use crate::error::{Code, Diagnostic, Error, Result};
use crate::export::percent_decoded;

/// Bytes of the header of a `.glb` file, and of the header of its first chunk.
const GLB_HEADERS: u32 = 12 + 8;

/// A glTF file with its buffers.
pub(crate) struct File {
    pub(crate) document: Document,
    buffers: Vec<Vec<u8>>,
    /// The decompressed bytes of compressed views.
    views: HashMap<usize, Vec<u8>>,
}

/// The keys of one property of one node.
pub(crate) struct Track {
    /// Index of the node in the file.
    pub(crate) node: usize,
    /// In seconds, strictly increasing.
    pub(crate) times: Vec<f32>,
    pub(crate) values: Values,
    /// Whether the interpolation is not linear.
    pub(crate) is_bent: bool,
}

pub(crate) enum Values {
    Translations(Vec<Vec3>),
    Rotations(Vec<Quat>),
    Scales(Vec<Vec3>),
}

impl Values {
    /// Numbers in one key.
    pub(crate) fn components(&self) -> u64 {
        match self {
            Self::Translations(_) | Self::Scales(_) => 3,
            Self::Rotations(_) => 4,
        }
    }
}

impl File {
    /// A `.glb` begins with its magic number, a `.gltf` is a JSON object that names an `asset`.
    pub(crate) fn sniff(bytes: &[u8]) -> bool {
        let is_json = bytes.trim_ascii_start().starts_with(b"{");
        bytes.starts_with(b"glTF") || (is_json && memchr::memmem::find(bytes, b"\"asset\"").is_some())
    }

    /// Reads `.glb` or `.gltf`; `open` reads a buffer in a separate file.
    pub(crate) fn read(bytes: &[u8], open: &dyn Fn(&Path) -> Result<Vec<u8>>) -> Result<Self> {
        check_length(bytes)?;
        let Gltf { document, mut blob } =
            Gltf::from_slice_without_validation(bytes).map_err(|error| invalid(error.to_string()))?;
        let json = document.into_json();
        check_meshes(&json)?;
        let document = streams::known(json)?;
        check_words(&document)?;
        let mut buffers = Vec::new();
        for buffer in document.buffers() {
            if streams::is_placeholder(&document, &buffer) {
                buffers.push(Vec::new());
                continue;
            }
            let data = match buffer.source() {
                buffer::Source::Bin => blob.take().ok_or_else(|| invalid("the binary chunk is missing"))?,
                buffer::Source::Uri(uri) => match uri.split_once(";base64,") {
                    Some((start, data)) if start.starts_with("data:") => STANDARD
                        .decode(data)
                        .map_err(|error| invalid(format!("in a data URI: {error}")))?,
                    _ => open(&beside(uri)?)?,
                },
            };
            if data.len() < buffer.length() {
                let message = "a buffer is shorter than the file says";
                let (claimed, found) = (format!("{} bytes", buffer.length()), format!("{} bytes", data.len()));
                return Err(Diagnostic::new(Code::InvalidGltf, message)
                    .expected_found(claimed, found)
                    .into());
            }
            buffers.push(data);
        }
        let views = streams::decode(&document, &buffers)?;
        Ok(Self {
            document,
            buffers,
            views,
        })
    }

    /// The provenance that this crate wrote; absent in files of other programs.
    pub(crate) fn provenance(&self) -> Option<Provenance> {
        let extras = self.document.as_json().asset.extras.as_ref()?;
        let mut extras: HashMap<String, serde_json::Value> = serde_json::from_str(extras.get()).ok()?;
        serde_json::from_value(extras.remove("mocap")?).ok()
    }

    /// The name of a node in the scene from which the file was written; in files of other programs, its name.
    pub(crate) fn source_name(&self, node: &gltf::Node) -> String {
        let extras = node
            .extras()
            .as_ref()
            .and_then(|extras| serde_json::from_str::<serde_json::Value>(extras.get()).ok());
        let source_name = extras.as_ref().and_then(|extras| extras.get("source_name")?.as_str());
        source_name.or(node.name()).unwrap_or_default().to_owned()
    }

    /// Whether a node is marked as an end site.
    pub(crate) fn is_end_site(&self, node: &gltf::Node) -> bool {
        let extras = node
            .extras()
            .as_ref()
            .and_then(|extras| serde_json::from_str::<serde_json::Value>(extras.get()).ok());
        extras.is_some_and(|extras| extras.get("end_site") == Some(&serde_json::Value::Bool(true)))
    }

    /// The nodes of the default scene, parents before children, each with its parent's place in this list.
    ///
    /// # Errors
    /// Where a node has two parents, or is its own ancestor.
    pub(crate) fn nodes(&self) -> Result<Vec<(gltf::Node<'_>, Option<usize>)>> {
        let scene = self.document.default_scene().or_else(|| self.document.scenes().next());
        let mut is_listed = vec![false; self.document.nodes().len()];
        let mut listed: Vec<(gltf::Node<'_>, Option<usize>)> = Vec::with_capacity(is_listed.len());
        // A list instead of recursion, so that no file can overflow the call stack. The last comes first, so children
        // are pushed in reverse.
        let mut open: Vec<_> = scene
            .iter()
            .flat_map(gltf::Scene::nodes)
            .map(|node| (node, None))
            .collect();
        open.reverse();
        while let Some((node, parent)) = open.pop() {
            if std::mem::replace(&mut is_listed[node.index()], true) {
                return Err(invalid(format!("node {} has more than one parent", node.index())));
            }
            let place = listed.len();
            let first = open.len();
            open.extend(node.children().map(|child| (child, Some(place))));
            open[first..].reverse();
            listed.push((node, parent));
        }
        Ok(listed)
    }

    /// The tracks of an animation that animate nodes.
    pub(crate) fn tracks(&self, animation: &gltf::Animation) -> Result<Vec<Track>> {
        let moves_nodes = |channel: &Channel| channel.target().property() != Property::MorphTargetWeights;
        animation
            .channels()
            .filter(moves_nodes)
            .map(|channel| self.track(&channel))
            .collect()
    }

    fn track(&self, channel: &Channel) -> Result<Track> {
        let sampler = channel.sampler();
        let times = self.numbers(&sampler.input(), 1)?;
        let is_cubic = sampler.interpolation() == Interpolation::CubicSpline;
        let columns = if channel.target().property() == Property::Rotation {
            4
        } else {
            3
        };
        let mut numbers = self.numbers(&sampler.output(), columns)?;
        if is_cubic {
            // Each key is an in-tangent, a value and an out-tangent.
            let keys = numbers.chunks_exact(3 * columns);
            numbers = keys.flat_map(|key| &key[columns..2 * columns]).copied().collect();
        }
        let increases = times.is_sorted_by(|a, b| a < b) && times.iter().all(|time| time.is_finite() && *time >= 0.0);
        let is_finite = numbers.iter().all(|number| number.is_finite());
        if times.is_empty() || !increases || !is_finite || numbers.len() != times.len() * columns {
            return Err(invalid(
                "an animation sampler needs increasing times and one finite value for each",
            ));
        }
        let vectors = |numbers: &[f32]| numbers.chunks_exact(3).map(Vec3::from_slice).collect();
        let values = match channel.target().property() {
            Property::Rotation => Values::Rotations(numbers.chunks_exact(4).map(Quat::from_slice).collect()),
            Property::Scale => Values::Scales(vectors(&numbers)),
            Property::Translation | Property::MorphTargetWeights => Values::Translations(vectors(&numbers)),
        };
        let is_bent = sampler.interpolation() != Interpolation::Linear && times.len() > 1 && !values.is_constant();
        Ok(Track {
            node: channel.target().node().index(),
            times,
            values,
            is_bent,
        })
    }

    /// The numbers of an accessor with `columns` components; normalised integers are converted to floats.
    fn numbers(&self, accessor: &Accessor, columns: usize) -> Result<Vec<f32>> {
        let outside = || invalid(format!("accessor {} reaches beyond its buffer", accessor.index()));
        if accessor.sparse().is_some() || accessor.dimensions().multiplicity() != columns {
            return Err(invalid(format!(
                "accessor {} is sparse, or does not have {columns} components",
                accessor.index()
            )));
        }
        let view = accessor.view().ok_or_else(outside)?;
        let size = accessor.size();
        let stride = view.stride().unwrap_or(size);
        let length = accessor
            .count()
            .checked_sub(1)
            .and_then(|rows| rows.checked_mul(stride)?.checked_add(size));
        let (buffer, start) = match self.views.get(&view.index()) {
            Some(decoded) => (decoded, 0),
            None => (&self.buffers[view.buffer().index()], view.offset()),
        };
        let start = start.checked_add(accessor.offset()).ok_or_else(outside)?;
        let end = start.checked_add(length.unwrap_or(0)).ok_or_else(outside)?;
        let bytes = buffer.get(start..end).ok_or_else(outside)?;
        let rows = bytes.chunks(stride.max(1)).map(|row| &row[..size]);
        let number: fn(&[u8]) -> f32 = match accessor.data_type() {
            DataType::F32 => |b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
            // The specification's equations for normalised integers.
            DataType::I8 => |b| (f32::from(b[0] as i8) / 127.0).max(-1.0),
            DataType::U8 => |b| f32::from(b[0]) / 255.0,
            DataType::I16 => |b| (f32::from(i16::from_le_bytes([b[0], b[1]])) / 32767.0).max(-1.0),
            DataType::U16 => |b| f32::from(u16::from_le_bytes([b[0], b[1]])) / 65535.0,
            DataType::U32 => return Err(invalid(format!("accessor {} holds 32-bit integers", accessor.index()))),
        };
        Ok(rows
            .flat_map(|row| row.chunks_exact(accessor.data_type().size()).map(number))
            .collect())
    }
}

impl Values {
    fn is_constant(&self) -> bool {
        match self {
            Self::Translations(values) | Self::Scales(values) => values.windows(2).all(|pair| pair[0] == pair[1]),
            Self::Rotations(values) => values.windows(2).all(|pair| pair[0] == pair[1]),
        }
    }
}

/// Checks the length in a `.glb` header, which the `gltf` crate does not.
fn check_length(bytes: &[u8]) -> Result<()> {
    let length = bytes
        .get(8..12)
        .and_then(|length| length.try_into().ok())
        .map(u32::from_le_bytes);
    match length {
        Some(length) if bytes.starts_with(b"glTF") && length < GLB_HEADERS => Err(invalid(
            "its header says that the file is shorter than the header itself",
        )),
        None => Err(invalid("the file ends within its header")),
        _ => Ok(()),
    }
}

/// Checks the accessors of positions, which the validation of the `gltf` crate indexes without a check.
fn check_meshes(json: &gltf::json::Root) -> Result<()> {
    for primitive in json.meshes.iter().flat_map(|mesh| &mesh.primitives) {
        let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
        if let Some(index) = positions
            .map(gltf::json::Index::value)
            .filter(|&index| index >= json.accessors.len())
        {
            return Err(invalid(format!(
                "a mesh refers to accessor {index}, which does not exist"
            )));
        }
    }
    Ok(())
}

/// The `gltf` crate does not check some words of animations, and panics later on unknown ones.
fn check_words(document: &Document) -> Result<()> {
    for animation in &document.as_json().animations {
        let targets = animation
            .channels
            .iter()
            .all(|channel| channel.target.path.as_ref() != Checked::Invalid);
        let ways = animation
            .samplers
            .iter()
            .all(|sampler| sampler.interpolation.as_ref() != Checked::Invalid);
        let nodes = animation
            .channels
            .iter()
            .all(|channel| channel.target.node.value() < document.nodes().len());
        if !(targets && ways && nodes) {
            return Err(invalid(
                "an animation has a target or an interpolation that glTF does not define",
            ));
        }
    }
    Ok(())
}

pub(crate) fn invalid(message: impl Into<String>) -> Error {
    Diagnostic::new(Code::InvalidGltf, message).into()
}

/// The file of a relative URI, in the same folder or below. Other paths are refused, so that an input cannot read other
/// files.
fn beside(uri: &str) -> Result<PathBuf> {
    let path = PathBuf::from(percent_decoded(uri));
    if path.components().all(|part| matches!(part, Component::Normal(_))) && path.file_name().is_some() {
        Ok(path)
    } else {
        Err(invalid(format!(
            "a buffer is not in the folder of the file, but at \"{uri}\""
        )))
    }
}
