//! One command per file. Each command reads its arguments, calls the library, and prints.

pub(crate) mod angles;
pub(crate) mod chain;
pub(crate) mod check;
pub(crate) mod clean;
pub(crate) mod completions;
pub(crate) mod convert;
pub(crate) mod doctor;
pub(crate) mod dump;
pub(crate) mod edit;
pub(crate) mod find;
pub(crate) mod fk;
pub(crate) mod formats;
mod found;
pub(crate) mod gif;
pub(crate) mod graph;
pub(crate) mod index;
pub(crate) mod info;
pub(crate) mod live;
mod looks;
mod made;
mod many;
pub(crate) mod matching;
pub(crate) mod merge_manifest;
mod own;
#[cfg(feature = "parquet")]
pub(crate) mod pack;
#[doc(hidden)]
pub(crate) mod packets;
pub(crate) mod play_robot;
pub(crate) mod plot;
pub(crate) mod pose;
pub(crate) mod retarget;
pub(crate) mod robot;
mod robot_reports;
pub(crate) mod run;
pub(crate) mod score;
pub(crate) mod series;
pub(crate) mod sheet;
pub(crate) mod skeleton;
pub(crate) mod survey;
pub(crate) mod verify;
pub(crate) mod view;

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use mocap::Importer;
use mocap::figure::Figure;
use mocap::files::check_distinct;
use mocap::job::{InputOptions, Maker, SourceMap, SourceUp};
use mocap::render::Drawing;
use mocap::report::{Report, indented_json};
use mocap::retarget::report::ClipReport;
use mocap::retarget::robot::add_links;
use mocap::retarget::{RetargetOptions, Retargeter};
use mocap::scene::Scene;
use serde::Serialize;

use crate::args::{OutputFormat, PictureArgs};
use crate::printed::PictureReport;
use crate::{Failure, kinds, report, streams};

/// Imports a motion without meshes, prints the warnings, and reports which of several animations is used.
fn import_motion(read: &InputOptions, file: &Path) -> mocap::Result<Scene> {
    let scene = streams::import(&read.importer().with_own_meshes(), file)?;
    Ok(told(scene, file))
}

/// Imports a motion for a picture, as [`import_motion`] does, but with the meshes of the file and the given up axis.
fn import_drawn(read: &InputOptions, up: SourceUp, file: &Path) -> mocap::Result<Scene> {
    let importer = read.importer().with_own_meshes();
    let mut scene = streams::import(&importer, file)?;
    up.state(&mut scene);
    Ok(told(scene, file))
}

/// Retargets a motion to a robot, for a picture of the robot's links.
fn on_robot(scene: Scene, file: &Path, robot: &Path) -> mocap::Result<Scene> {
    let robot = Importer::new().import_robot(robot)?;
    let done = Retargeter::new(scene, robot.clone(), RetargetOptions::new());
    let mut moved = done.map_err(|error| error.with_path(file))?.scene();
    add_links(&robot, &mut moved);
    Ok(moved)
}

/// Prints the warnings of a scene, and reports which of several animations is used.
fn told(mut scene: Scene, file: &Path) -> Scene {
    report::warnings(Some(file), &scene.warnings);
    report::clip_taken(&mut scene);
    scene
}

/// The format of an output in lower case: its extension; for standard output and devices, `--to` or else `default`.
fn output_format(output: &Path, to: Option<&str>, default: &str) -> Result<String, Failure> {
    match (streams::is_unnamed(output), to) {
        (true, to) => Ok(to.unwrap_or(default).to_owned()),
        (false, None) => Ok(extension(output)),
        // `--to` may name a layout of arrays. The extension does not determine the layout, only the container.
        (false, Some(to)) if OutputFormat::named(to).is_some_and(OutputFormat::is_layout) => Ok(to.to_owned()),
        (false, Some(_)) => Err(Failure::Usage(format!("--to would do nothing: {TO_OF_FILE}"))),
    }
}

/// Refuses a report and data that both go to standard output.
fn check_json(json: bool, output: &Path) -> Result<(), Failure> {
    match json && streams::is_standard(output) {
        true => Err(Failure::Usage(
            "--json and -o - would both write to standard output: name a file".to_owned(),
        )),
        false => Ok(()),
    }
}

/// Refuses outputs of one command with equal paths, before any output is made. `PATH.json` of the first output counts
/// as an output too.
fn refuse_one_file<'a>(outputs: impl IntoIterator<Item = &'a Path>) -> Result<(), Failure> {
    let outputs: Vec<&Path> = outputs.into_iter().collect();
    let sidecar = outputs.first().map(|output| {
        let mut name = output.as_os_str().to_owned();
        name.push(".json");
        PathBuf::from(name)
    });
    check_distinct(outputs.into_iter().chain(sidecar.as_deref())).map_err(made::refused)
}

/// The figure of `scene`, with the bones of `--map`.
fn mapped_figure(scene: &Scene, map: &SourceMap) -> Result<Figure, Failure> {
    let mapped = Figure::mapped(scene, &map.bones_here());
    mapped.map_err(|error| {
        let diagnostic = error.diagnostic();
        let help = diagnostic.help.as_ref().map(|help| format!("; {help}"));
        Failure::Usage(format!("--map: {}{}", diagnostic.message, help.unwrap_or_default()))
    })
}

/// A report as a JSON value.
fn value(report: &impl Serialize) -> serde_json::Value {
    serde_json::to_value(report).unwrap_or_default()
}

/// Prints a job, which is then not run.
fn print_job(job: &impl Serialize) -> Result<(), Failure> {
    Ok(print_json(job)?)
}

/// The destination of a text report.
#[derive(Clone, Copy)]
enum Place {
    /// Standard output: the report is the result.
    Result,
    /// Standard output without escaping: another program reads the report.
    Data,
    /// Standard error, unless `--quiet`: the result is a file.
    Message,
    /// Standard output with colours: the report itself escapes strings from files.
    Screen,
    /// As [`Screen`](Self::Screen), for one of many reports: its JSON is one line.
    Row,
}

/// Prints a report: as JSON on standard output, or as text.
fn print_report(report: &impl Report, is_json: bool, place: Place) -> Result<(), Failure> {
    match (is_json, place) {
        (true, Place::Row) => {
            let line = serde_json::to_string(report).map_err(io::Error::from)?;
            return Ok(writeln!(report::json(), "{line}")?);
        }
        (true, _) => return Ok(print_json(report)?),
        (false, _) => {}
    }
    let text = report.to_string();
    let line = text.strip_suffix('\n').unwrap_or(&text);
    match place {
        Place::Result => writeln!(report::words(), "{line}")?,
        Place::Data => report::data().write_all(text.as_bytes())?,
        Place::Message if text.is_empty() => {}
        Place::Message => report::say(line),
        Place::Screen | Place::Row => report::beside_bar(|| io::stdout().write_all(text.as_bytes()))?,
    }
    Ok(())
}

/// Prints a value as indented JSON.
fn print_json(value: &impl Serialize) -> io::Result<()> {
    writeln!(report::json(), "{}", indented_json(value)?)
}

/// Checks that a picture may be written. Returns its format.
fn check_picture<P: AsRef<Path>>(inputs: &[P], picture: &PictureArgs) -> Result<String, Failure> {
    let format = output_format(&picture.output, picture.to.as_deref(), "png")?;
    if !["svg", "png"].contains(&format.as_str()) {
        return Err(unknown_extension(&picture.output, ".png or .svg"));
    }
    check_json(picture.json, &picture.output)?;
    streams::check_output(inputs, &picture.output, picture.force.force)?;
    Ok(format)
}

/// The bytes of a picture as SVG or PNG.
fn drawn(drawing: &Drawing, format: &str) -> Result<Vec<u8>, Failure> {
    Ok(match format {
        "svg" => drawing.to_svg().into_bytes(),
        _ => drawing.to_png()?,
    })
}

/// Writes a picture as SVG or PNG.
fn write_drawing(drawing: &Drawing, picture: &PictureArgs, format: &str) -> Result<(), Failure> {
    let (path, bytes) = (picture.output.as_path(), drawn(drawing, format)?);
    streams::write(path, &bytes)?;
    print_report(
        &PictureReport::of(drawing, path, bytes.len()),
        picture.json,
        Place::Message,
    )
}

/// The error of a build without the feature.
#[cfg(not(feature = "parquet"))]
pub(crate) fn without_parquet() -> Failure {
    Failure::Usage("this build cannot write Parquet; build it with `--features parquet`".to_owned())
}

/// The extension in lower case, without the dot; empty if there is none.
fn extension(path: &Path) -> String {
    let extension = path.extension().and_then(|extension| extension.to_str());
    extension.unwrap_or_default().to_ascii_lowercase()
}

fn unknown_extension(path: &Path, known: &str) -> crate::Failure {
    crate::Failure::Usage(match streams::is_unnamed(path) {
        true => format!("--to: the format must be {known}"),
        false => format!(
            "{}: the name of the output must end in {known}{}",
            path.display(),
            kinds::other_output(path, known)
        ),
    })
}

/// The name of a file in a picture.
fn short_name(path: &Path) -> String {
    path.file_stem()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}

/// The reason why a file name and `--to` exclude each other.
const TO_OF_FILE: &str = "the extension of the output sets the format";

/// The options for many motions, and the reason why one output does not support them.
const MANY: &[&str] = &["resume", "shard", "threads", "progress", "allow-empty"];
const ONE_OUTPUT: &str = "one motion is written to one file; to write many files, name a folder";

/// An error if a retargeted motion is worse than the arguments allow.
fn require(maker: &Maker<'_>, clips: &[ClipReport]) -> Result<(), Failure> {
    match maker.problem(clips) {
        None => Ok(()),
        Some(problem) => {
            report::complain(&problem);
            Err(Failure::Told)
        }
    }
}
