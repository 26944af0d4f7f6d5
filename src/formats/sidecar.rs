//! The sidecar of a file whose format cannot state its origin: `walk.bvh.json` next to `walk.bvh`.
//!
//! The sidecar has the contents of `asset.extras` in glTF, and the SHA-256 of its file, so that it applies to no other
//! file.

use std::borrow::Cow;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use mocap_scene::error::Code;
use mocap_scene::limits;
use mocap_scene::report::indented_json;
use mocap_scene::scene::report::AppliedStep;
use mocap_scene::scene::{Format, Scene};
use mocap_scene::visible_json;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::provenance::Provenance;
use super::{ExportFile, FormatInfo, WriteOptions};

/// The contents of a sidecar.
#[derive(Serialize, Deserialize)]
#[doc(hidden)]
pub struct Sidecar {
    /// The provenance of the file.
    #[doc(hidden)]
    pub mocap: Provenance,
    /// The SHA-256 of the file, as `sha256sum` prints it.
    sha256: String,
}

impl Sidecar {
    /// The sidecar of the file that `options` name.
    pub(super) fn of(scene: &Scene, options: &WriteOptions, file: &ExportFile) -> ExportFile {
        let sidecar = Self {
            mocap: Provenance {
                losses: FormatInfo::of(Format::Bvh).losses(scene, options.bvh.ledger()),
                ..Provenance::of(scene)
            },
            sha256: sum(file.parts()),
        };
        let text = indented_json(&sidecar).expect("a provenance has no map without text as keys");
        ExportFile::new(
            format!("{}.json", options.name),
            visible_json(&text).into_owned().into_bytes(),
        )
    }

    /// The sidecar's path for a file at `path`.
    #[doc(hidden)]
    pub fn path(path: &Path) -> PathBuf {
        let mut name = OsString::from(path);
        name.push(".json");
        name.into()
    }

    /// Parses a sidecar; `None` if the bytes are not a sidecar of this crate.
    #[doc(hidden)]
    pub fn read(bytes: &[u8]) -> Option<Self> {
        serde_json::from_str(str::from_utf8(bytes).ok()?).ok()
    }

    /// Whether the sidecar applies to a file with this SHA-256.
    #[doc(hidden)]
    pub fn is_about(&self, sha256: &str) -> bool {
        self.sha256 == sha256
    }

    /// Whether the sidecar applies to a file with these bytes.
    #[doc(hidden)]
    pub fn is_about_bytes(&self, bytes: &[u8]) -> bool {
        self.is_about(&sum([Cow::Borrowed(bytes)]))
    }

    /// Sets the unit, the up axis and the origin of a scene, if its file does not state them.
    #[doc(hidden)]
    pub fn tell(&self, scene: &mut Scene) {
        let steps = self.mocap.steps.iter().rev();
        let space = steps.filter_map(|step| match *step {
            AppliedStep::ConvertUnits {
                out_metres_per_unit,
                out_up,
                ..
            } if limits::positive(Code::InvalidValue, "the unit", out_metres_per_unit).is_ok() => {
                Some((out_metres_per_unit, out_up))
            }
            _ => None,
        });
        if let Some((metres, up)) = space.into_iter().next() {
            scene.metadata.metres_per_unit.get_or_insert(metres);
            scene.metadata.up.get_or_insert(up);
        }
        scene.metadata.attribution.complete(self.mocap.attribution.clone());
    }
}

fn sum<'a>(parts: impl IntoIterator<Item = Cow<'a, [u8]>>) -> String {
    let mut sum = Sha256::new();
    parts.into_iter().for_each(|part| sum.update(part));
    let digits = sum.finalize();
    digits.iter().map(|byte| format!("{byte:02x}")).collect()
}
