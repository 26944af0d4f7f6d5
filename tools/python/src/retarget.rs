//! Motions on other skeletons, and in the files of characters.

use std::path::PathBuf;

use mocap::Importer;
use mocap::convert::leave_out_rest_pose;
use mocap::figure::Humanoid;
use mocap::files::{ReplacePolicy, write_file};
use mocap::gltf::Provenance;
use mocap::retarget::{RetargetOptions, RetargetReport, Retargeter, Scale};
use mocap::scene::Animation;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::errors::to_python;
use crate::scene::Scene;

/// The motions of `source` on the skeleton of `target`, and the reports as JSON.
#[pyfunction]
pub(crate) fn retarget(
    py: Python<'_>,
    source: &Scene,
    target: &Scene,
    scale: Option<f64>,
    lock_feet: bool,
) -> PyResult<(Scene, String)> {
    let mut changed = target.scene().clone();
    let done = py.detach(|| {
        let retargeter = retargeter(source.scene(), target.scene(), None, scale)?;
        let mut source = source.scene().clone();
        leave_out_rest_pose(&mut source)?;
        retargeter.record(&source, &mut changed, lock_feet);
        moved(retargeter, &source, target.scene(), lock_feet)
    });
    let (animations, reports) = done.map_err(|error| to_python(py, &error))?;
    changed.animations = animations;
    Ok((Scene::new(changed), json(&reports)?))
}

/// Writes the file of a character with further motions, each with its name; returns the reports as JSON.
#[pyfunction]
pub(crate) fn add_motions(
    py: Python<'_>,
    motions: Vec<(String, Py<Scene>)>,
    character: PathBuf,
    target: PathBuf,
    scale: Option<f64>,
    lock_feet: bool,
    replace: bool,
) -> PyResult<String> {
    let done = py.detach(|| {
        ReplacePolicy::new([&character]).check_inputs(&target)?;
        // The skin shows the soles of the feet.
        let character = Importer::new().gltf_meshes(true).import_character(&character)?;
        let (mut added, mut reports) = (Vec::new(), Vec::new());
        for (name, motion) in &motions {
            let mut motion = motion.get().scene().clone();
            let retargeter = retargeter(&motion, character.scene(), character.humanoid(), scale)?;
            leave_out_rest_pose(&mut motion)?;
            let step = retargeter.step(character.scene(), lock_feet);
            let (mut clips, mut found) = moved(retargeter, &motion, character.scene(), lock_feet)?;
            for (number, (clip, report)) in clips.iter_mut().zip(&mut found).enumerate() {
                clip.name = match number {
                    0 => name.clone(),
                    _ => format!("{name}_{}", number + 1),
                };
                report.clip.clone_from(&clip.name);
            }
            for (index, clip) in clips.into_iter().enumerate() {
                let mut provenance = Provenance::of_clip(&motion, index);
                provenance.steps.push(step.clone());
                added.push((clip, provenance));
            }
            reports.append(&mut found);
        }
        write_file(&target, &character.with_clips(&added, replace)?)?;
        Ok(reports)
    });
    json(&done.map_err(|error| to_python(py, &error))?)
}

fn retargeter(
    source: &mocap::Scene,
    target: &mocap::Scene,
    bones: Option<&Humanoid>,
    scale: Option<f64>,
) -> mocap::Result<Retargeter> {
    let options = RetargetOptions {
        scale: scale.map_or(Scale::Auto, Scale::Factor),
        target: bones.cloned(),
        ..RetargetOptions::default()
    };
    Retargeter::new(source, target, &options)
}

/// All animations of `source` on `target`, each with its report.
fn moved(
    mut retargeter: Retargeter,
    source: &mocap::Scene,
    target: &mocap::Scene,
    lock_feet: bool,
) -> mocap::Result<(Vec<Animation>, Vec<RetargetReport>)> {
    let clips = (0..source.animations.len()).map(|clip| retargeter.clip(source, clip, target, lock_feet));
    Ok(clips.collect::<mocap::Result<Vec<_>>>()?.into_iter().unzip())
}

fn json(value: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(value).map_err(|error| PyValueError::new_err(error.to_string()))
}
