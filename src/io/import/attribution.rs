//! The `mocap.toml` of a folder, which says where its motions come from.

use std::io::Read;
use std::path::Path;

use mocap_scene::error::{Error, Result};
use mocap_scene::scene::Scene;
use mocap_scene::scene::report::Attribution;

/// Its name, in the folder of a file or beside that folder.
const NAME: &str = "mocap.toml";
/// A larger file is somebody else's.
const MOST_BYTES: u64 = 1 << 20;

/// Adds to a scene the statements of the files beside `path` that its own file does not have; the nearest wins.
pub(super) fn complete(scene: &mut Scene, path: &Path) -> Result<()> {
    let Ok(path) = std::path::absolute(path) else {
        return Ok(());
    };
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    for folder in path.ancestors().skip(1).take(2) {
        let beside = folder.join(NAME);
        if !std::fs::metadata(&beside).is_ok_and(|found| found.is_file() && found.len() <= MOST_BYTES) {
            continue;
        }
        let mut text = String::new();
        let file = std::fs::File::open(&beside).map_err(|error| Error::io(&beside, error))?;
        file.take(MOST_BYTES)
            .read_to_string(&mut text)
            .map_err(|error| Error::io(&beside, error))?;
        let found = Attribution::from_toml(&text, &name).map_err(|error| Error::from(error).with_path(&beside))?;
        scene.metadata.attribution.complete(found);
    }
    Ok(())
}
