//! Retargets motions to other skeletons, and adds them to character files.

use std::path::PathBuf;

use mocap::Importer;
use mocap::figure::HumanoidMap;
use mocap::files::ReplacePolicy;
use mocap::retarget::Scale;
use mocap::retarget::report::ClipReport;
use mocap::retarget::{RetargetOptions, Retargeter, Target};
use pyo3::prelude::*;

use crate::edit::bones_of;
use crate::errors::{invalid, to_python};
use crate::scene::Scene;
use crate::weights_of;

/// Retargets the motions of `source` to the skeleton of `target`. Returns the scene, and the reports as JSON.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "Python hands them over by name")]
pub(crate) fn retarget(
    py: Python<'_>,
    source: &Scene,
    target: &Scene,
    scale: Option<f64>,
    lock_feet: bool,
    keep_hands: bool,
    bones: Option<&str>,
    target_bones: Option<&str>,
    weights: &str,
) -> PyResult<(Scene, String)> {
    let options = options(scale, lock_feet, keep_hands, bones, target_bones, weights)?;
    let done = py.detach(|| {
        let (source, target) = (source.scene().clone(), target.scene().clone());
        Retargeter::new(source, target, options)
    });
    let retargeting = done.map_err(|error| to_python(py, &error))?;
    Ok((Scene::new(retargeting.scene()), reports(&retargeting)?))
}

/// Writes the file of a character with added motions and their names. Returns the reports as JSON, and a sentence for
/// each part of a face that the character cannot show.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "Python hands them over by name")]
pub(crate) fn add_motions(
    py: Python<'_>,
    motions: Vec<(String, Py<Scene>)>,
    character: PathBuf,
    target: PathBuf,
    scale: Option<f64>,
    lock_feet: bool,
    keep_hands: bool,
    replace: bool,
    overwrite: bool,
    bones: Option<&str>,
    target_bones: Option<&str>,
    weights: &str,
) -> PyResult<(String, Vec<String>)> {
    let options = options(scale, lock_feet, keep_hands, bones, target_bones, weights)?.replace_animations(replace);
    let done = py.detach(|| {
        let origins = motions
            .iter()
            .filter_map(|(_, motion)| motion.get().scene().metadata.origin.as_ref());
        let policy = origins.fold(ReplacePolicy::new([&character]), |policy, origin| {
            policy.source_name(&origin.name)
        });
        let policy = policy.force(overwrite);
        policy.check_ahead(&target)?;
        // The skin shows the soles of the feet.
        let character = Importer::new().gltf_meshes(true).import_character(&character)?;
        let mut retargeting = Retargeter::onto(Target::from(character), options)?;
        for (name, motion) in &motions {
            let source = retargeting.prepare(motion.get().scene().clone())?;
            retargeting.add(source.named(name))?;
        }
        let mut written = retargeting.character_file()?.unwrap_or_default();
        let notes = std::mem::take(&mut written.notes);
        written.save(&target, &policy)?;
        Ok((retargeting, notes))
    });
    let (retargeting, notes) = done.map_err(|error| to_python(py, &error))?;
    Ok((reports(&retargeting)?, notes))
}

/// `bones` and `target_bones` are the joints of bones, and `weights` the weights of a job, all as JSON.
fn options(
    scale: Option<f64>,
    lock_feet: bool,
    keep_hands: bool,
    bones: Option<&str>,
    target_bones: Option<&str>,
    weights: &str,
) -> PyResult<RetargetOptions> {
    let map =
        |bones: Option<&str>| -> PyResult<HumanoidMap> { Ok(bones.map(bones_of).transpose()?.unwrap_or_default()) };
    Ok(RetargetOptions::new()
        .scale(scale.map_or(Scale::Auto, Scale::Factor))
        .lock_feet(lock_feet)
        .keep_hands(keep_hands)
        .source_bones(map(bones)?)
        .target_bones(map(target_bones)?)
        .foot_lock_weights(weights_of(weights)?.foot_lock))
}

fn reports(retargeting: &Retargeter) -> PyResult<String> {
    let reports: Vec<&ClipReport> = retargeting.clips().iter().map(|clip| &clip.report).collect();
    serde_json::to_string(&reports).map_err(|error| invalid(error.to_string()))
}
