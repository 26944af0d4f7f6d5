//! Reads a pair of files. `skeleton` reads the `.asf` file, `motion` the `.amc` file, and `scene` combines them.

mod line;
mod motion;
mod scene;
mod skeleton;

use std::path::{Path, PathBuf};

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::Scene;

use self::skeleton::Skeleton;
use super::{begins_motion, begins_skeleton};
use crate::text::{decode, is_binary};
use crate::warnings::Warnings;
use crate::{ReadOptions, Source};

pub(super) fn read(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    let text = decode(source.bytes)?;
    let has_motion_name = has_extension(source.name, "amc");
    if begins_motion(&text) || (has_motion_name && !begins_skeleton(&text)) {
        read_pair(source, &text, options)
    } else {
        let mut warnings = Warnings::default();
        let result = skeleton::read(&text, &options.limits).map(|skeleton| {
            warnings.push(Code::NoMotion, || {
                Diagnostic::new(
                    Code::NoMotion,
                    "an .asf file holds no motion: the scene has a skeleton and no animation",
                )
                .help("import the .amc file; mocap finds its .asf file in the same folder")
            });
            scene::build(&skeleton, None, options)
        });
        warnings.attach_to(result)
    }
}

fn read_pair(source: &Source<'_>, text: &[u8], options: &ReadOptions) -> Result<Scene> {
    if is_binary(text) {
        return Err(
            Diagnostic::new(Code::BinaryFile, "the file is binary, not an .amc file")
                .help("check that the extension matches the contents of the file, and that the file is not compressed")
                .into(),
        );
    }
    let path = find_skeleton(source)?;
    let skeleton = read_skeleton(source, &path, options).map_err(|error| error.with_path(&path))?;
    let mut warnings = Warnings::default();
    let skeleton_file = path.file_name().unwrap_or_default().to_string_lossy();
    let result = motion::read(text, &skeleton, &skeleton_file, options, &mut warnings)
        .map(|motion| scene::build(&skeleton, Some(motion), options));
    warnings.attach_to(result)
}

fn read_skeleton(source: &Source<'_>, path: &Path, options: &ReadOptions) -> Result<Skeleton> {
    let bytes = (source.open)(path)?;
    let text = decode(&bytes)?;
    Ok(skeleton::read(&text, &options.limits)?)
}

/// The skeleton file of a motion: the candidate whose name is a prefix of the motion's name (`01.asf` for `01_02.amc`),
/// or else the only candidate.
fn find_skeleton(source: &Source<'_>) -> Result<PathBuf> {
    let mut candidates = (source.list)("asf");
    let stem = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().to_lowercase();
    let motion = stem(source.name);
    let begins_motion = |path: &&PathBuf| {
        let rest = motion.strip_prefix(&stem(path));
        rest.is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
    };
    let same_prefix = candidates.iter().filter(begins_motion);
    if let Some(skeleton) = same_prefix.max_by_key(|path| stem(path).len()) {
        return Ok(skeleton.clone());
    }
    if candidates.len() == 1 {
        return Ok(candidates.remove(0));
    }
    let help = match candidates.first() {
        Some(first) => format!("name it: {{skeleton}} {}", first.display()),
        None => "put the .asf file into the folder of the motion, or name it: {skeleton} FILE".to_owned(),
    };
    let name = source.name.file_name().unwrap_or_default();
    Err(
        Diagnostic::new(Code::MissingFile, "the motion needs a skeleton, an .asf file")
            .expected_found(
                format!(
                    "an .asf file in the same folder: one whose name is a prefix of {}, or the only one",
                    name.display()
                ),
                list(&candidates),
            )
            .help(help)
            .into(),
    )
}

fn list(files: &[PathBuf]) -> String {
    /// The largest number of files in an error.
    const MOST: usize = 8;
    let names = files.iter().take(MOST).filter_map(|file| file.file_name());
    let mut names: Vec<_> = names.map(|name| name.to_string_lossy().into_owned()).collect();
    if files.len() > MOST {
        names.push(format!("{} more", files.len() - MOST));
    }
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension()
        .is_some_and(|found| found.eq_ignore_ascii_case(extension))
}
