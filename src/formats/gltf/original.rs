//! Keeps a file with meshes together with its scene, so that a glTF output loses nothing.

use std::sync::Arc;

use mocap_scene::error::{Diagnostic, Result};
use mocap_scene::files::percent_decoded;
use mocap_scene::scene::{Node, NodeId, Original, OriginalFile, SKELETON_MATERIAL, Scene};
use serde::Deserialize;

use super::json::{self, MAGIC};
use super::write::{dangling, patch};
use crate::Source;
use crate::named_file::below;

/// The members that show whether a file has contents to lose.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Contents {
    asset: Asset,
    meshes: Vec<Whatever>,
    materials: Vec<Material>,
    extensions: Extensions,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Asset {
    extras: Option<serde_json::Value>,
}

#[derive(Deserialize)]
struct Whatever {}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Material {
    name: String,
}

#[derive(Default, Deserialize)]
struct Extensions {
    #[serde(rename = "VRMC_vrm")]
    vrm1: Option<Whatever>,
    #[serde(rename = "VRM")]
    vrm0: Option<Whatever>,
}

impl Contents {
    /// Whether there are meshes, except skeleton meshes of this crate.
    fn has_meshes(&self) -> bool {
        let is_ours = self
            .asset
            .extras
            .as_ref()
            .is_some_and(|extras| extras.get("mocap").is_some());
        let is_drawn = is_ours && self.materials.iter().all(|material| material.name == SKELETON_MATERIAL);
        !self.meshes.is_empty() && !is_drawn
    }
}

/// The file of a source, if it has meshes. `nodes` are the file indices of the scene's nodes, and `in_file` has their
/// transforms in the file. Invalid indices are removed, each with a warning.
pub(super) fn of(
    source: &Source<'_>,
    scene: &Scene,
    nodes: &[(usize, NodeId)],
    in_file: Vec<Node>,
) -> Result<Option<(Original, Vec<Diagnostic>)>> {
    let (text, _) = json::split(source.bytes)?;
    // A file that cannot be passed through is still read.
    let Ok(contents) = serde_json::from_str::<Contents>(&String::from_utf8_lossy(text)) else {
        return Ok(None);
    };
    if !contents.has_meshes() {
        return Ok(None);
    }
    let (bytes, warnings) = dangling::without(source.bytes)?;
    let mut beside = Vec::new();
    if !bytes.starts_with(MAGIC) {
        for uri in patch::external_files(&bytes).unwrap_or_default() {
            // A missing file is also missing in the output.
            let path = below(percent_decoded(&uri)).map(|path| source.name.with_file_name(path));
            if let Some(Ok(bytes)) = path.map(|path| (source.open)(&path)) {
                beside.push((uri, bytes));
            }
        }
    }
    let mut indices = vec![None; scene.nodes.len()];
    for (index, id) in nodes {
        indices[id.index()] = Some(*index);
    }
    let file = OriginalFile {
        bytes: bytes.into_owned(),
        beside,
        is_vrm: contents.extensions.vrm1.is_some() || contents.extensions.vrm0.is_some(),
        indices,
        in_file,
        as_read: scene.nodes.clone(),
    };
    let original = Original {
        file: Arc::new(file),
        replaced: None,
        morphs: Vec::new(),
    };
    Ok(Some((original, warnings)))
}
