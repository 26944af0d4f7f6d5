//! Motion files as assets.

use std::error::Error;
use std::sync::Arc;

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::prelude::*;
use mocap::{FormatInfo, Importer, MemoryFile, Scene};

/// The contents of a motion file: a skeleton and its motions.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct Motion {
    /// The imported scene, in the file's unit and axes.
    pub scene: Arc<Scene>,
}

/// Reads every format of [`FormatInfo::ALL`]. The contents determine the format, otherwise the extension.
///
/// `asset_server.load::<Motion>(path)` reads any format, also `.glb` and `.gltf`. These two are not in
/// [extensions](AssetLoader::extensions), so bevy_gltf handles a load without a type or with a label.
#[derive(TypePath, Debug)]
pub struct MotionLoader {
    extensions: Vec<&'static str>,
}

impl Default for MotionLoader {
    fn default() -> Self {
        let all = FormatInfo::ALL.iter().flat_map(|row| row.extensions).copied();
        let of_others = ["glb", "gltf"];
        Self {
            extensions: all.filter(|extension| !of_others.contains(extension)).collect(),
        }
    }
}

/// Any error. Bevy prints the error with the path.
type Failure = Box<dyn Error + Send + Sync>;

impl AssetLoader for MotionLoader {
    type Asset = Motion;
    type Settings = ();
    type Error = Failure;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<Motion, Failure> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        let name = context.path().path().display().to_string();
        let mut beside = Vec::new();
        for other in files_beside(&name, &bytes) {
            let path = context.path().resolve_embed_str(&other)?;
            // If the file is missing, the reader reports it.
            if let Ok(bytes) = context.read_asset_bytes(path).await {
                beside.push((other, bytes));
            }
        }
        let others: Vec<_> = beside.iter().map(|(name, bytes)| MemoryFile { name, bytes }).collect();
        let file = MemoryFile {
            name: &name,
            bytes: &bytes,
        };
        let scene = Importer::new().read_among(file, &others)?;
        Ok(Motion { scene: Arc::new(scene) })
    }

    fn extensions(&self) -> &[&str] {
        &self.extensions
    }
}

/// The files that a file refers to: the skeleton of an Acclaim motion, the buffers of a glTF file.
fn files_beside(name: &str, bytes: &[u8]) -> Vec<String> {
    let Some((stem, extension)) = name.rsplit_once('.') else {
        return Vec::new();
    };
    match extension.to_ascii_lowercase().as_str() {
        "amc" => {
            // `01.asf` is the skeleton of `01_05.amc`.
            let stem = stem.rsplit(['/', '\\']).next().unwrap_or(stem);
            let ends = stem.match_indices('_').map(|(end, _)| end).chain([stem.len()]);
            ends.map(|end| format!("{}.asf", &stem[..end])).collect()
        }
        "gltf" => {
            let json: serde_json::Value = serde_json::from_slice(bytes).unwrap_or_default();
            let buffers = json["buffers"].as_array().cloned().unwrap_or_default();
            let uris = buffers.iter().filter_map(|buffer| buffer["uri"].as_str());
            uris.filter(|uri| !uri.starts_with("data:"))
                .map(str::to_owned)
                .collect()
        }
        _ => Vec::new(),
    }
}
