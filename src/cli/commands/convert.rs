//! `mocap convert`: writes a motion file in another format.

use std::path::{Path, PathBuf};

use mocap::files::ReplacePolicy;
use mocap::gltf::Compression;
use mocap::job::{JobOutput, MotionJob, Notice, SizeOptions};
use mocap::scene::Animation;
use mocap::{Diagnostic, Exporter, Format, FormatInfo, Importer, WriteOption};

use super::{Place, TO_OF_FILE, made, many, print_job, print_report, unknown_extension, verify};
use crate::args::{ArgumentSources, ConvertArgs, OutputFormat, refuse_options};
use crate::{Failure, report, streams};

pub(crate) fn run(args: &ConvertArgs, given: &ArgumentSources) -> Result<(), Failure> {
    let (job, format) = job_and_format(args, given)?;
    if args.instead.print_job {
        return print_job(&job);
    }
    if args.json {
        return super::run::printed(job, given);
    }
    if args.batch.out_dir.is_some() {
        return many::run(&job, given, &args.batch.inputs, &args.batch.spread, args.batch.resume);
    }
    verify::refuse_streams(&job)?;
    one(args, given, &job, format)
}

/// The job that the arguments describe.
pub(crate) fn job(args: &ConvertArgs, given: &ArgumentSources) -> Result<MotionJob, Failure> {
    job_and_format(args, given).map(|(job, _)| job)
}

fn job_and_format(args: &ConvertArgs, given: &ArgumentSources) -> Result<(MotionJob, OutputFormat), Failure> {
    let frames = args.change.frames.conversion();
    let options_are_sound = frames.check();
    options_are_sound.map_err(|error| Failure::Usage(error.diagnostic().message.clone()))?;
    if let Some(folder) = args.batch.folder()? {
        let job = wanted(args, given, &args.paths, &folder.join(""), args.batch.to)?;
        return Ok((job, args.batch.to));
    }
    let (input, output, format) = paths(args, given)?;
    let job = wanted(args, given, std::slice::from_ref(input), &output, format)?;
    Ok((job, format))
}

/// The input, the output and its format, for a single output.
fn paths<'a>(args: &'a ConvertArgs, given: &ArgumentSources) -> Result<(&'a PathBuf, PathBuf, OutputFormat), Failure> {
    let why = "this option works only with an output folder: -o FOLDER";
    given.refuse(&["shard", "progress", "allow-empty", "resume"], why)?;
    let is_layout = given.has("to") && args.batch.to.is_layout();
    if args.paths.len() == 2 && !streams::is_unnamed(&args.paths[1]) && !is_layout {
        given.refuse(&["to"], TO_OF_FILE)?;
    }
    let (input, output) = match args.paths.as_slice() {
        [input] if streams::is_standard(input) => {
            let message =
                "standard input has no file name for a default output: use mocap convert - OUTPUT, or - for OUTPUT";
            return Err(Failure::Usage(message.to_owned()));
        }
        [input] => (input, input.with_extension(args.batch.to.extension)),
        [input, output] => (input, output.clone()),
        _ => {
            return Err(Failure::Usage(
                "several inputs need an output folder: -o FOLDER".to_owned(),
            ));
        }
    };
    if Importer::is_of_many(input) {
        let message = format!("{} is a folder; name an output folder: -o FOLDER", input.display());
        return Err(Failure::Usage(message));
    }
    match OutputFormat::of(&output) {
        Some(_) if is_layout => Ok((input, output, args.batch.to)),
        Some(format) => Ok((input, output, format)),
        None if streams::is_unnamed(&output) => Ok((input, output, args.batch.to)),
        None => Err(unknown_extension(&output, &OutputFormat::extensions())),
    }
}

/// The job of the arguments. Refuses arguments without an effect.
fn wanted(
    args: &ConvertArgs,
    given: &ArgumentSources,
    inputs: &[PathBuf],
    output: &Path,
    format: OutputFormat,
) -> Result<MotionJob, Failure> {
    refuse_options(given, |option| format.refusal(option))?;
    if let Some(row) = format.row() {
        refuse_unused(args, given, row)?;
    }
    Ok(args.job(inputs, output, format.name))
}

/// Refuses options of reading without an effect on an output of this format.
fn refuse_unused(args: &ConvertArgs, given: &ArgumentSources, row: &FormatInfo) -> Result<(), Failure> {
    let out = &args.write.space;
    let moves_over_ground = args.change.in_place || args.change.root_motion;
    let converts_unit = !row.keeps_units() || out.metres_per_unit().is_some();
    let converts_up = !row.keeps_units() || out.up().is_some() || moves_over_ground;
    if !converts_unit {
        let why = "BVH does not state its unit, and lengths are kept; set the unit of the output with --out-unit";
        given.refuse(&["unit"], why)?;
    }
    if !converts_up {
        let why = "BVH does not state its up axis, and axes are kept; set the up axis of the output with --out-up";
        given.refuse(&["up"], why)?;
    }
    let finds_unit = converts_unit && args.source.metres_per_unit().is_none();
    let finds_up = converts_up && args.source.up().is_none();
    if !finds_unit && !finds_up && !row.states_bones {
        given.refuse(&["map"], "the bones are only needed to infer a unit or an up axis")?;
    }
    Ok(())
}

/// The notices of a file, until the file is written.
#[derive(Default)]
struct PendingWarnings {
    warnings: Vec<Diagnostic>,
    notes: Vec<String>,
}

/// Converts one file.
fn one(args: &ConvertArgs, given: &ArgumentSources, job: &MotionJob, format: OutputFormat) -> Result<(), Failure> {
    let policy: ReplacePolicy = job.policy();
    let mut heard = PendingWarnings::default();
    let mut hear = |said: Notice<'_>| match said {
        Notice::Warnings(_, warnings) => heard.warnings.extend(warnings.iter().cloned()),
        Notice::Note(note) => heard.notes.push(note.to_owned()),
        Notice::Step(step) => heard.notes.push(step.to_string()),
        _ => {}
    };
    let threads = args.batch.spread.threads;
    let (_, mut made) = made::make(job, given, threads, &policy, &mut hear)?;
    let (input, output) = (&job.source.inputs[0], job.write.output.as_path());
    let to_stream = streams::is_standard(output);
    if !to_stream {
        streams::save(&made.written, output, &[], &policy, given.is_dry_run())?;
    }
    let bytes = made.written.len();
    // Free the bytes of a long take before the next step.
    if !to_stream {
        made.written.files.clear();
    }
    heard.warnings.append(&mut made.written.warnings);
    report::warnings(Some(input), &heard.warnings);
    heard.notes.append(&mut made.written.notes);
    let choice = choice(&args.write.smaller, format.row()).filter(|_| !to_stream);
    choice.iter().chain(&heard.notes).for_each(|note| report::say(note));
    if !to_stream && !report::is_quiet() {
        tell(args, input, output, &made, bytes)?;
    }
    if to_stream {
        return streams::save(&made.written, output, &[], &policy, given.is_dry_run());
    }
    match args.verify {
        true => {
            let verification = job.verify_output(made.scene, output)?;
            print_report(&verification, false, Place::Message)?;
            verify::require(&verification, args.write.smaller.tolerance())
        }
        false => Ok(()),
    }
}

/// Names the compression option that the user left at its default.
fn choice(smaller: &SizeOptions, row: Option<&FormatInfo>) -> Option<String> {
    let row = row?;
    match (smaller.compress, smaller.max_error) {
        (None, Some(_)) if !row.takes(WriteOption::Compress) => None,
        (None, Some(_)) => Some(
            "compress: int16, core glTF that every program except Assimp reads; --compress selects another encoding"
                .to_owned(),
        ),
        (Some(kind), None) if kind != Compression::None => Some(format!(
            "max-error: {} mm, the default",
            verify::millimetres(smaller.tolerance())
        )),
        _ => None,
    }
}

fn tell(args: &ConvertArgs, input: &Path, output: &Path, made: &JobOutput, bytes: usize) -> Result<(), Failure> {
    let (written, scene) = (&made.written, made.scene.as_ref());
    for renamed in written.renamed.iter().filter(|renamed| !renamed.is_asked_for) {
        report::say(&renamed.to_string());
    }
    let animation = scene.and_then(|scene| scene.animations.first());
    let (nodes, frames) = (written.nodes, animation.map_or(0, Animation::frame_count));
    report::say(&format!(
        "{} -> {}: {nodes} nodes, {frames} frames, {bytes} bytes",
        input.display(),
        output.display(),
    ));
    let row = OutputFormat::of(output).and_then(OutputFormat::row);
    // If the format has no option `--compress`, the notes already have this message.
    let chooses = row.is_some_and(|row| row.takes(WriteOption::Compress));
    let (Some(achieved), Some(scene)) = (written.error.as_ref().filter(|_| chooses), scene) else {
        return Ok(());
    };
    let mut text = made::smaller(achieved);
    if row.is_some_and(|row| row.format == Format::Gltf) {
        let plain = Exporter::new().keep_constant(args.write.keep_constant);
        let plain = plain.write(scene, Format::Gltf)?.len();
        let ratio = plain as f64 / bytes.max(1) as f64;
        text += &format!("; {ratio:.1} times smaller than the {plain} bytes of a .glb without compression");
    }
    report::say(&text);
    Ok(())
}
