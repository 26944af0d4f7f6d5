//! The file `mocap.toml` of a folder. It states where the motions of the folder come from.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use mocap_scene::error::{Diagnostic, Error, Result};
use mocap_scene::scene::Scene;
use mocap_scene::scene::report::Attribution;

/// The file name. The file is in the folder of a motion or in its parent folder.
const NAME: &str = "mocap.toml";
/// The largest size in bytes. A larger file is not an attribution file of mocap.
const MOST_BYTES: u64 = 1 << 20;

/// Completes the attribution of a scene from the `mocap.toml` files near `path`. A statement of the motion's own file
/// takes precedence, and then the statement of the nearest `mocap.toml`.
pub(super) fn complete(scene: &mut Scene, path: &Path) -> Result<()> {
    let Ok(path) = std::path::absolute(path) else {
        return Ok(());
    };
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    for folder in path.ancestors().skip(1).take(2) {
        let beside = folder.join(NAME);
        let Some(text) = text_of(&beside)? else { continue };
        let found = Attribution::from_toml(&text, &name).map_err(|error| Error::from(error).with_path(&beside))?;
        scene.metadata.attribution.complete(found);
    }
    Ok(())
}

/// The text of a `mocap.toml`, if there is one.
fn text_of(path: &Path) -> Result<Option<String>> {
    if !std::fs::metadata(path).is_ok_and(|found| found.is_file() && found.len() <= MOST_BYTES) {
        return Ok(None);
    }
    let mut text = String::new();
    let read = File::open(path).and_then(|file| file.take(MOST_BYTES).read_to_string(&mut text));
    read.map_err(|error| Error::io(path, error))?;
    Ok(Some(text))
}

/// The `mocap.toml` files near `paths`, each with its warnings. A warning names a pattern that matches no file in the
/// folder of the `mocap.toml` or in its subfolders. These folders are read only if a pattern matches none of `paths`.
#[doc(hidden)]
pub fn unmatched_patterns<'a>(paths: impl IntoIterator<Item = &'a Path>) -> Vec<(PathBuf, Vec<Diagnostic>)> {
    let absolute = paths.into_iter().filter_map(|path| std::path::absolute(path).ok());
    let paths: Vec<PathBuf> = absolute.collect();
    let mut near = BTreeMap::<&Path, Vec<&Path>>::new();
    for path in &paths {
        for folder in path.ancestors().skip(1).take(2) {
            near.entry(folder).or_default().push(path);
        }
    }
    let here = std::env::current_dir().ok();
    let warnings = near.into_iter().filter_map(|(folder, paths)| {
        let path = folder.join(NAME);
        // The import of a motion reports a `mocap.toml` that cannot be read.
        let text = text_of(&path).ok()??;
        let mut names: Vec<String> = paths.into_iter().filter_map(name_of).collect();
        if Attribution::unmatched_patterns(&text, &names).is_empty() {
            return None;
        }
        for entry in files_of(folder) {
            match entry.is_dir() {
                true => names.extend(
                    files_of(&entry)
                        .filter(|path| !path.is_dir())
                        .filter_map(|path| name_of(&path)),
                ),
                false => names.extend(name_of(&entry)),
            }
        }
        let shown = here.as_deref().and_then(|here| path.strip_prefix(here).ok());
        let shown = shown.map_or_else(|| path.clone(), Path::to_owned);
        Some((shown, Attribution::unmatched_patterns(&text, &names)))
    });
    warnings.filter(|(_, warnings)| !warnings.is_empty()).collect()
}

fn files_of(folder: &Path) -> impl Iterator<Item = PathBuf> + use<> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.path())
}

fn name_of(path: &Path) -> Option<String> {
    let name = path.file_name()?.to_string_lossy().into_owned();
    (name != NAME).then_some(name)
}
