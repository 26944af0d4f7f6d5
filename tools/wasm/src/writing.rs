//! Writes scenes to files.

use mocap::arrays::{ArrayOptions, Arrays};
use mocap::dump::SceneView;
use mocap::gltf;
use mocap::job::RobotFormat;
use mocap::render::{Clip, Drawing, SheetOptions};
use mocap::scene::{Assumption, UpAxis};
use mocap::{Conversion, Error, Export, FormatInfo, Scene, WriteOption};
use serde::Serialize;

use crate::failure::Failure;
use crate::options::WriteOptions;
use crate::request::{Answer, json};
use crate::scenes::Entry;

/// The scene in metres with +Y up.
pub(crate) fn in_metres(entry: &Entry) -> Result<(Scene, Vec<Assumption>), Error> {
    let mut scene = entry.scene.clone();
    let is_in_metres = scene.metadata.metres_per_unit == Some(1.0) && scene.metadata.up == Some(UpAxis::Y);
    if entry.is_converted && is_in_metres {
        return Ok((scene, Vec::new()));
    }
    let assumptions = Conversion::new().apply(&mut scene)?;
    Ok((scene, assumptions))
}

/// The scene in metres with +Y up, with the provenance of the motion retargeted to its skeleton.
fn on_skeleton(entry: &Entry) -> Result<(Scene, Vec<Assumption>), Error> {
    let (mut scene, assumptions) = in_metres(entry)?;
    if let Some(provenance) = entry.provenance.first() {
        provenance.record(&mut scene);
    }
    Ok((scene, assumptions))
}

/// The description of a written file.
#[derive(Default, Serialize)]
struct Said {
    assumptions: Vec<Assumption>,
    warnings: Vec<mocap::Diagnostic>,
    #[serde(skip_serializing_if = "Option::is_none")]
    report: Option<WriterReport>,
}

/// The report of a writer.
#[derive(Serialize)]
struct WriterReport {
    nodes: usize,
    notes: Vec<String>,
    renamed: Vec<gltf::report::NodeRename>,
    achieved: Option<gltf::report::Deviation>,
}

pub(crate) fn write(entry: &Entry, format: &str, options: &WriteOptions) -> Result<Answer, Failure> {
    let scene = &entry.scene;
    if let (Some(retargeting), Some(format)) = (&entry.on_robot, RobotFormat::named(format)) {
        return file(format.write(retargeting)?, Vec::new());
    }
    match format {
        "csv" => {
            let motion = Arrays::of(scene, &ArrayOptions::default())?;
            let said = Said {
                assumptions: motion.header.provenance.assumptions.clone(),
                ..Said::default()
            };
            Ok((json(&said)?, motion.to_csv().into_bytes()))
        }
        "json" => Ok((json(&Said::default())?, json(&SceneView::new(scene))?)),
        "png" => {
            let origin = scene.metadata.origin.as_ref().map_or("", |origin| origin.stem());
            let name = options.name.as_deref().unwrap_or(origin);
            let drawing = Drawing::sheet(&[Clip { name, scene }], &SheetOptions::default());
            Ok((json(&Said::default())?, drawing.to_png()?))
        }
        extension => write_format(entry, extension, options),
    }
}

/// Writes a file of a format.
fn write_format(entry: &Entry, extension: &str, options: &WriteOptions) -> Result<Answer, Failure> {
    let name = format!("scene.{extension}");
    let Some(row) = FormatInfo::of_output(name.as_ref()) else {
        let known = FormatInfo::written_extensions();
        return Err(Failure::argument(format!(
            "the format must be csv, json, png, or an extension of {known} without the dot, got {extension:?}"
        )));
    };
    if let Some(refusal) = options.refusal(row, extension) {
        return Err(Error::from(refusal).into());
    }
    if row.takes(WriteOption::Compress) && options.is_shell_without_bound() {
        return Err(Failure::argument(
            "shellDistance has no effect without maxError or compress: set one of them, or omit shellDistance",
        ));
    }
    let character = entry.character.as_ref().filter(|_| !options.is_skeleton_only());
    if let Some(character) = character.filter(|_| row.keeps_characters) {
        let written = character.with_clips(&entry.scene, &entry.provenance, false, &options.gltf())?;
        return file(written, Vec::new());
    }
    let (mut scene, assumptions) = match row.keeps_units() {
        true => (entry.scene.clone(), Vec::new()),
        false => on_skeleton(entry)?,
    };
    // The meshes of links are only for pictures.
    if options.is_skeleton_only() || entry.robot.is_some() {
        scene.leave_out_meshes();
    }
    let mut exporter = options.exporter();
    if let Some(humanoid) = &entry.humanoid {
        exporter = exporter.humanoid(humanoid.clone());
    }
    file(exporter.write_as(&scene, name)?, assumptions)
}

fn file(mut written: Export, assumptions: Vec<Assumption>) -> Result<Answer, Failure> {
    let said = Said {
        assumptions,
        warnings: std::mem::take(&mut written.warnings),
        report: Some(WriterReport {
            nodes: written.nodes,
            notes: std::mem::take(&mut written.notes),
            renamed: std::mem::take(&mut written.renamed),
            achieved: written.error.take(),
        }),
    };
    Ok((json(&said)?, written.into_bytes()?))
}
