//! One command per file; each reads its arguments, calls the library, and prints.

mod change;
pub(crate) mod check;
pub(crate) mod convert;
pub(crate) mod convert_many;
pub(crate) mod dump;
pub(crate) mod edit;
pub(crate) mod fk;
pub(crate) mod formats;
pub(crate) mod gif;
pub(crate) mod info;
pub(crate) mod merge_manifest;
#[cfg(feature = "parquet")]
pub(crate) mod pack;
pub(crate) mod plot;
pub(crate) mod pose;
pub(crate) mod retarget;
pub(crate) mod retarget_many;
pub(crate) mod robot;
pub(crate) mod robot_many;
mod robot_reports;
pub(crate) mod run;
pub(crate) mod sheet;
pub(crate) mod skeleton;
pub(crate) mod verify;
pub(crate) mod view;

use std::io::{self, Write};
use std::path::Path;

use mocap::fbx::FbxOptions;
use mocap::figure::{Figure, Humanoid, HumanoidMap, humanoid};
use mocap::files::{ReplacePolicy, write_files};
use mocap::gltf::BufferPlace;
use mocap::job::SourceMap;
use mocap::scene::{Scene, Topic};
use mocap::{Code, Conversion, Exporter, Importer, SkeletonMesh, WrittenFile};
use serde::Serialize;

use crate::args::FrameRateArgs;
use crate::report::Voice;
use crate::{Failure, report, streams};

/// Imports a motion without meshes, prints the warnings, and says which animation of several is taken.
fn import_motion(read: &FrameRateArgs, file: &Path) -> mocap::Result<Scene> {
    let scene = streams::import(&read.importer().skeleton_mesh(SkeletonMesh::None), file)?;
    report::warnings(Some(file), &scene.warnings);
    report::clip_taken(&scene);
    Ok(scene)
}

/// Imports a motion that is changed, and tells the warnings.
fn import_moving(importer: &Importer, file: &Path, voice: &mut Voice<'_>) -> Result<Scene, Failure> {
    let scene = streams::import(importer, file)?;
    voice.warnings(file, &scene.warnings);
    match scene.animations.is_empty() {
        true => Err(Failure::Usage(format!("{}: there is no motion in it", file.display()))),
        false => Ok(scene),
    }
}

/// Converts a scene, and says what was decided.
fn convert_aloud(conversion: &Conversion, scene: &mut Scene, file: &Path) -> mocap::Result<()> {
    let decisions = conversion.apply(scene).map_err(|error| error.with_path(file))?;
    decisions.iter().for_each(|decision| report::say(&decision.to_string()));
    Ok(())
}

/// The bytes of a scene in the format of an extension, a .gltf with its buffer within, and the images beside it.
fn scene_bytes(
    scene: &Scene,
    extension: &str,
    fbx: &FbxOptions,
    voice: &mut Voice<'_>,
) -> mocap::Result<(Vec<u8>, Vec<ImageFile>)> {
    let exporter = Exporter::new().fbx(fbx.clone()).buffer(BufferPlace::Embedded);
    let mut written = exporter.write_as(scene, format!("scene.{extension}"))?;
    written.notes.iter().for_each(|note| voice.say(note));
    let bytes = written.files.pop().map(WrittenFile::into_bytes).unwrap_or_default();
    let images = written.files.into_iter();
    let images = images.map(|image| (image.name().to_owned(), image.into_bytes()));
    Ok((bytes, images.collect()))
}

/// An image that stands beside an FBX file: its name, and its bytes.
type ImageFile = (String, Vec<u8>);

/// Writes a file and the images beside it: all of them or none.
fn write_with_textures(policy: &ReplacePolicy, output: &Path, bytes: &[u8], images: &[ImageFile]) -> mocap::Result<()> {
    let paths: Vec<_> = images.iter().map(|(name, _)| output.with_file_name(name)).collect();
    for (path, (_, bytes)) in paths.iter().zip(images) {
        policy.check_beside(path, bytes)?;
    }
    let images = paths
        .iter()
        .zip(images)
        .map(|(path, (_, bytes))| (path.as_path(), bytes.as_slice()));
    write_files(&images.chain([(output, bytes)]).collect::<Vec<_>>())
}

/// The format of an output, in lower case: its extension, or for standard output that of `--to`, or else `default`.
fn output_format(output: &Path, to: Option<&str>, default: &str) -> Result<String, Failure> {
    match (streams::is_standard(output), to) {
        (true, to) => Ok(to.unwrap_or(default).to_owned()),
        (false, None) => Ok(extension(output)),
        (false, Some(_)) => {
            let message = "--to would do nothing: the name of the output names the format";
            Err(Failure::Usage(message.to_owned()))
        }
    }
}

/// Refuses a report on standard output beside the data.
fn check_json(json: bool, output: &Path) -> Result<(), Failure> {
    match json && streams::is_standard(output) {
        true => Err(Failure::Usage(
            "--json and -o - would both write to standard output: name a file".to_owned(),
        )),
        false => Ok(()),
    }
}

/// Writes an output, unless it would replace an input or a file that may be a source.
fn write_output(policy: &ReplacePolicy, output: &Path, bytes: &[u8]) -> Result<(), Failure> {
    if !streams::is_standard(output) {
        policy.check_bytes(output, bytes)?;
    }
    streams::write(output, bytes)
}

/// Writes an output with the images beside it, as the policy allows.
fn write_whole_output(
    policy: &ReplacePolicy,
    output: &Path,
    bytes: &[u8],
    images: &[ImageFile],
) -> Result<(), Failure> {
    if images.is_empty() {
        return write_output(policy, output, bytes);
    }
    policy.check_bytes(output, bytes)?;
    Ok(write_with_textures(policy, output, bytes, images)?)
}

/// The figure of `scene`, with the bones of `--map`.
fn mapped_figure(scene: &Scene, map: &SourceMap) -> Result<Figure, Failure> {
    let bones = mapped(humanoid(scene), scene, map.bones_here(), "--map")?;
    Ok(Figure::with_bones(scene, bones))
}

/// A humanoid with the bones of the map that `option` names.
fn mapped(found: Humanoid, scene: &Scene, map: HumanoidMap, option: &str) -> Result<Humanoid, Failure> {
    let mapped = found.with_map(scene, map);
    mapped.map_err(|error| Failure::Usage(format!("{option}: {}", error.diagnostic().message)))
}

/// Imports a file at its own frame rate, to be resampled to `rate`. Where the file states none, `rate` is its rate too.
fn import_to_resample(importer: impl Fn() -> Importer, file: &Path, rate: Option<f64>) -> mocap::Result<Scene> {
    let at_given_rate = |rate| streams::import(&importer().frame_rate(rate), file);
    let assumes_rate = |scene: &Scene| {
        let mut assumptions = scene.metadata.assumptions.iter();
        assumptions.any(|assumption| assumption.topic == Topic::FrameRate)
    };
    match (streams::import(&importer(), file), rate) {
        (Err(error), Some(rate)) if error.code() == Code::FrameTime => at_given_rate(rate),
        (Ok(scene), Some(rate)) if assumes_rate(&scene) => at_given_rate(rate),
        (result, _) => result,
    }
}

/// Prints a value as indented JSON.
fn print_json(value: &impl Serialize) -> io::Result<()> {
    let mut out = io::BufWriter::new(report::stdout());
    serde_json::to_writer_pretty(&mut out, value)?;
    writeln!(out)?;
    out.flush()
}

/// Writes a picture in the format of the file's extension; to standard output as PNG.
fn write_drawing(drawing: &mocap::render::Drawing, path: &Path) -> Result<(), crate::Failure> {
    let bytes = match extension(path).as_str() {
        "svg" => drawing.to_svg().into_bytes(),
        "png" => drawing.to_png()?,
        _ if streams::is_standard(path) => drawing.to_png()?,
        _ => return Err(unknown_extension(path, ".png or .svg")),
    };
    streams::write(path, &bytes)?;
    report::say(&format!(
        "{}: {} x {} pixels",
        path.display(),
        drawing.width,
        drawing.height
    ));
    Ok(())
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
    crate::Failure::Usage(match streams::is_standard(path) {
        true => format!("--to: the format must be {known}"),
        false => format!("{}: the name of the output must end in {known}", path.display()),
    })
}

/// The name of a file in a picture.
fn short_name(path: &Path) -> String {
    path.file_stem()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}
