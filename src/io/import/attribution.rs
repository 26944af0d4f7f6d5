//! The file `mocap.toml` of a folder. It states where the motions of the folder come from.

use std::io::Read;
use std::path::Path;

use mocap_scene::error::{Error, Result};
use mocap_scene::scene::Scene;
use mocap_scene::scene::report::Attribution;

/// The file name. The file is in the folder of a motion or in its parent folder.
const NAME: &str = "mocap.toml";
/// The largest size in bytes. A larger file is not an attribution file of mocap.
const MOST_BYTES: u64 = 1 << 20;

/// Adds the statements of the `mocap.toml` files near `path` to a scene, if its own file does not make them. The
/// nearest file wins.
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
