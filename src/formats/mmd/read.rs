//! Reads a motion or a model into a scene.

use std::path::{Path, PathBuf};

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::Scene;

use super::generic;
use super::model::{self as models, Model};
use super::motion::{self as motions, Motion};
use super::scene::{self, Skeleton};
use crate::warnings::Warnings;
use crate::{ReadOptions, Source};

/// A model without a motion.
pub(super) fn model(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    let mut warnings = Warnings::default();
    let read = models::read(source.bytes, &options.limits).map(|model| {
        warnings.push(Code::NoMotion, || {
            let message = "a model has no motion: the scene has a skeleton and no animation";
            Diagnostic::new(Code::NoMotion, message).help(
                "mocap retarget INPUT MODEL.pmx -o OUTPUT.vmd retargets a motion \
                to the model",
            )
        });
        scene::of_model(&model)
    });
    warnings.attach_to(read)
}

/// A motion on the skeleton of a model.
pub(super) fn motion(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    let mut warnings = Warnings::default();
    let motion = motions::read(source.bytes, &mut warnings);
    let (motion, kept) = warnings.with(motion)?;
    let (skeleton, size) = skeleton(source, &motion, options)?;
    let mut warnings = Warnings::default();
    kept.into_iter().for_each(|warning| warnings.distinct(warning));
    let bytes = (source.bytes.len() + size) as u64;
    let read = scene::of_motion(&motion, &skeleton, bytes, options, &mut warnings);
    warnings.attach_to(read)
}

/// The model of a motion, with the size of its file. The model that the caller named has priority. The next choice is a
/// model in the folder of the motion, whose file name or model name matches, or which is the only model. Without such a
/// model, returns the generic model.
fn skeleton(source: &Source<'_>, motion: &Motion, options: &ReadOptions) -> Result<(Skeleton, usize)> {
    let candidates = (source.list)("pmx");
    let read = |path: &Path| -> Result<(Model, usize)> {
        let read = || -> Result<(Model, usize)> {
            let bytes = (source.open)(path)?;
            let model = models::read(&bytes, &options.limits)?;
            Ok((model, bytes.len()))
        };
        read().map_err(|error| error.with_path(path))
    };
    let found = match candidates.as_slice() {
        [] => None,
        [only] => {
            let (model, size) = read(only)?;
            let why = match model.name == motion.model {
                true => "the motion names this model".to_owned(),
                false => format!(
                    "this model was named, or is the only model in the folder; the motion is for \"{}\"",
                    motion.model
                ),
            };
            Some((model, size, only, why))
        }
        several => named(source.name, motion, several, &read)?,
    };
    Ok(match found {
        Some((model, size, path, why)) => {
            let file = path.file_name().unwrap_or_default().to_string_lossy();
            (Skeleton::of(model, format!("the model of {file}"), why), size)
        }
        None => {
            let why = match candidates.len() {
                0 => format!(
                    "the motion's folder has no .pmx, and the motion is for \"{}\"; name a .pmx as the skeleton",
                    motion.model
                ),
                count => format!(
                    "none of the {count} .pmx files in the motion's folder has the motion's file name or the model \
                     name \"{}\"; name one of the files as the skeleton",
                    motion.model
                ),
            };
            let choice = "generic proportions".to_owned();
            (Skeleton::of(generic::model(), choice, why), 0)
        }
    })
}

type Named<'p> = Option<(Model, usize, &'p PathBuf, String)>;

/// The model whose file name, apart from the extension, equals the file name of the motion. Otherwise the model whose
/// name the motion states.
fn named<'p>(
    motion_file: &Path,
    motion: &Motion,
    several: &'p [PathBuf],
    read: &dyn Fn(&Path) -> Result<(Model, usize)>,
) -> Result<Named<'p>> {
    let same_stem = several.iter().find(|path| path.file_stem() == motion_file.file_stem());
    if let Some(path) = same_stem {
        let (model, size) = read(path)?;
        return Ok(Some((
            model,
            size,
            path,
            "its file name matches the motion's".to_owned(),
        )));
    }
    // A broken file next to the motion is no reason to read nothing.
    let of_name = several.iter().find_map(|path| {
        let (model, size) = read(path).ok()?;
        (!motion.model.is_empty() && model.name == motion.model).then_some((model, size, path))
    });
    Ok(of_name.map(|(model, size, path)| (model, size, path, "the motion names this model".to_owned())))
}
