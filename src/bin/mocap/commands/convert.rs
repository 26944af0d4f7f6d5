//! `mocap convert`: a motion file in another format.

use std::collections::BTreeMap;
use std::path::Path;

use mocap::figure::humanoid;
use mocap::files::{ReplacePolicy, remove_unfinished};
use mocap::gltf::{Achieved, BufferPlace, Compression, Provenance, Renamed};
use mocap::job::Smaller;
use mocap::scene::{Animation, Assumption, Confidence, Scene, Topic, UpAxis};
use mocap::verify::{Verification, Verifier};
use mocap::{Diagnostic, Exporter, Format, FormatInfo, SkeletonMesh, WriteOption, Written};

use super::{change, import_to_resample, run as job, verify};
use crate::args::{ConvertArgs, Given, NOT_ONE_FILE, OutputFormat};
use crate::batch::hash::sha256_of;
use crate::batch::thread_count;
use crate::{Failure, report, streams};

/// Converts one file.
pub(crate) fn run(args: &ConvertArgs, given: &Given) -> Result<(), Failure> {
    check(args)?;
    let why = "it is for many files, which need an output folder: -o FOLDER";
    given.refuse(&["shard", "progress", "allow-empty"], why)?;
    if args.paths.len() == 2 && !streams::is_standard(&args.paths[1]) {
        given.refuse(&["to"], "the name of the output names the format")?;
    }
    let (input, output) = match args.paths.as_slice() {
        [input] if streams::is_standard(input) => {
            let message = "standard input has no name to name the output after: mocap convert - OUT, or - for OUT";
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
    if input.is_dir() {
        let message = format!("{} is a folder; name an output folder: -o FOLDER", input.display());
        return Err(Failure::Usage(message));
    }
    let format = match OutputFormat::of(&output) {
        Some(format) => format,
        None if streams::is_standard(&output) => args.batch.to,
        None => {
            let known = FormatInfo::written_extensions();
            return Err(Failure::Usage(format!("{} should end in {known}", output.display())));
        }
    };
    let wanted = Wanted::new(args, given, format)?;
    if args.print.print_job {
        return job::print(&args.job(input, &output, format.extension));
    }
    if streams::is_standard(&output) {
        return to_standard_output(&wanted, input);
    }
    if streams::is_standard(input) && args.verify {
        return Err(Failure::Usage(
            "--verify reads the source again: name a file, not -".to_owned(),
        ));
    }
    let policy = ReplacePolicy::new([input]).force(args.force);
    let converted = convert(&wanted, input, &output, &policy, &|| false, Round::Alone)?;
    report::warnings(Some(input), &converted.warnings);
    if !args.batch.spread.quiet {
        tell(input, &output, &converted);
    }
    match &converted.verification {
        Some(verification) => verify::require(verification, args.write.smaller.tolerance()),
        None => Ok(()),
    }
}

/// What is asked for of an output.
pub(crate) struct Wanted<'a> {
    args: &'a ConvertArgs,
    format: OutputFormat,
    exporter: Exporter,
}

impl<'a> Wanted<'a> {
    /// What `args` ask for in a format, unless one of them does nothing there.
    pub(crate) fn new(args: &'a ConvertArgs, given: &Given, format: OutputFormat) -> Result<Self, Failure> {
        let is_standard = args.paths.get(1).is_some_and(|output| streams::is_standard(output));
        let one_file = match (&args.batch.out_dir, is_standard) {
            (Some(_), _) => {
                Some("textures of many files could have one name; convert one file at a time, or leave it out")
            }
            (None, true) => Some(NOT_ONE_FILE),
            (None, false) => None,
        };
        let exporter = args.write.exporter(given, format, one_file)?;
        refuse_unused(args, given, format)?;
        let exporter = match args.embed || (is_standard && args.batch.out_dir.is_none()) {
            true => exporter.buffer(BufferPlace::Embedded),
            false => exporter,
        };
        Ok(Self { args, format, exporter })
    }

    /// The files of a scene under the name of `output`.
    fn files(&self, scene: &Scene, output: &Path) -> mocap::Result<Written> {
        let exporter = match self.format.row().states_bones {
            // The conversion has refused a map whose names are not those of joints.
            true => match humanoid(scene).with_map(scene, self.args.map.bones_here()) {
                Ok(humanoid) => &self.exporter.clone().humanoid(humanoid),
                Err(_) => &self.exporter,
            },
            false => &self.exporter,
        };
        exporter.write_as(scene, output)
    }
}

/// Converts one file to standard output.
fn to_standard_output(wanted: &Wanted<'_>, input: &Path) -> Result<(), Failure> {
    let Wanted { args, format, .. } = wanted;
    if args.verify {
        return Err(Failure::Usage(
            "--verify reads the output again: name a file, not -".to_owned(),
        ));
    }
    let mut scene = import(args, input, *format)?;
    let keeps_units = format.row().keeps_units();
    let mut decisions = change::apply(&mut scene, args, keeps_units, None).map_err(|error| error.with_path(input))?;
    let mut written = wanted.files(&scene, &Path::new("scene").with_extension(format.extension))?;
    scene.warnings.append(&mut written.warnings);
    decisions.append(&mut written.notes);
    report::warnings(Some(input), &scene.warnings);
    if !args.batch.spread.quiet {
        for decision in decisions {
            report::say(&decision);
        }
    }
    streams::write(Path::new("-"), &written.into_bytes()?)
}

/// Refuses options that do not go together.
pub(crate) fn check(args: &ConvertArgs) -> Result<(), Failure> {
    let options_are_sound = change::conversion(args).check();
    options_are_sound.map_err(|error| Failure::Usage(error.diagnostic().message.clone()))?;
    Ok(())
}

/// Half of what to know about a smaller file was said; this is the other half.
fn choice(smaller: &Smaller, format: OutputFormat) -> Option<String> {
    match (smaller.compress, smaller.max_error) {
        (None, Some(_)) if !format.row().takes(WriteOption::Compress) => None,
        (None, Some(_)) => {
            Some("compress: int16, core glTF that all but Assimp read; --compress names others".to_owned())
        }
        (Some(kind), None) if kind != Compression::None => Some(format!(
            "max-error: {} mm, because none was named",
            verify::millimetres(smaller.tolerance())
        )),
        _ => None,
    }
}

/// Refuses options of reading that change nothing in an output of this format.
fn refuse_unused(args: &ConvertArgs, given: &Given, format: OutputFormat) -> Result<(), Failure> {
    let out = &args.change.out;
    let row = format.row();
    let moves_over_ground = args.change.in_place || args.change.root_motion;
    let converts_unit = !row.keeps_units() || out.metres_per_unit().is_some();
    let converts_up = !row.keeps_units() || out.up().is_some() || moves_over_ground;
    if !converts_unit {
        let why = "BVH does not state its unit, and lengths are kept; name the unit of the output with --out-unit";
        given.refuse(&["unit"], why)?;
    }
    if !converts_up {
        let why = "BVH does not state its up axis, and axes are kept; name that of the output with --out-up";
        given.refuse(&["up"], why)?;
    }
    let finds_unit = converts_unit && args.source.metres_per_unit().is_none();
    let finds_up = converts_up && args.source.up().is_none();
    if !finds_unit && !finds_up && !row.states_bones {
        given.refuse(
            &["map"],
            "only a unit or an up axis that is searched for comes from the bones",
        )?;
    }
    Ok(())
}

/// Clips of one skeleton in one run, of which those that stand say which axis points up in the others.
#[derive(Clone, Copy)]
pub(crate) enum Round<'a> {
    /// There are no others.
    Alone,
    /// The others are not known yet: a clip whose up axis is not sure waits for the last round.
    First,
    /// The up axes of skeletons.
    Last(&'a BTreeMap<String, UpAxis>),
}

/// What is worth saying about a file that was written.
#[derive(Default)]
pub(crate) struct Converted {
    /// Whether nothing was written, because the clip waits for [`Round::Last`].
    pub(crate) waits: bool,
    /// The hash of the skeleton.
    pub(crate) skeleton: String,
    /// The guesses of unit and up axis.
    pub(crate) guesses: Vec<Assumption>,
    pub(crate) warnings: Vec<Diagnostic>,
    pub(crate) verification: Option<Verification>,
    /// The SHA-256 of a BVH output in a folder: its contents do not say who wrote it.
    pub(crate) hash: Option<String>,
    /// What was chosen of how to store keys.
    choice: Option<String>,
    decisions: Vec<String>,
    renamed: Vec<Renamed>,
    bytes: usize,
    achieved: Option<Achieved>,
    /// The largest distance of a joint from its place, in metres, where keys or bits were left out.
    pub(crate) max_error: Option<f64>,
    /// Bytes without compression; counted for a single file alone.
    plain_bytes: Option<usize>,
    nodes: usize,
    frames: usize,
}

/// Converts one file, without printing anything. An existing file at `output` is replaced if `policy` allows it or if
/// it `is_known` as an output of a former run.
pub(crate) fn convert(
    wanted: &Wanted<'_>,
    input: &Path,
    output: &Path,
    policy: &ReplacePolicy,
    is_known: &dyn Fn() -> bool,
    round: Round<'_>,
) -> mocap::Result<Converted> {
    let Wanted { args, format, .. } = wanted;
    let row = format.row();
    policy.check_inputs(output)?;
    // Whether a file that does not say who wrote it may be replaced depends on the bytes of the output.
    if row.states_origin {
        policy.check(output)?;
    }
    let mut scene = import(args, input, *format)?;
    let skeleton = match round {
        Round::Alone => String::new(),
        Round::First | Round::Last(_) => skeleton_hash(&scene),
    };
    let of_others = match round {
        Round::Last(axes) => axes.get(&skeleton).copied(),
        Round::Alone | Round::First => None,
    };
    let applied = change::apply(&mut scene, args, row.keeps_units(), of_others);
    let mut decisions = applied.map_err(|error| error.with_path(input))?;
    let is_space = |guess: &&Assumption| matches!(guess.topic, Topic::Unit | Topic::Up);
    let guesses: Vec<Assumption> = scene.metadata.assumptions.iter().filter(is_space).cloned().collect();
    let is_open = |guess: &Assumption| guess.topic == Topic::Up && guess.confidence != Some(Confidence::Sure);
    if matches!(round, Round::First) && guesses.iter().any(is_open) {
        return Ok(Converted {
            waits: true,
            skeleton,
            guesses,
            ..Converted::default()
        });
    }
    let mut written = wanted.files(&scene, output).map_err(|error| error.with_path(input))?;
    match !row.states_origin && is_known() {
        true => written.save(output, &policy.clone().force(true))?,
        false => written.save(output, policy)?,
    }
    let bytes = written.len();
    let is_of_many = args.batch.out_dir.is_some();
    // Not before, because a `.gltf` that is left says whose its buffer is.
    if !is_of_many {
        remove_unfinished(output);
    }
    let hash = (is_of_many && !row.states_origin)
        .then(|| written.files.last().map(|file| sha256_of(&file.bytes())))
        .flatten();
    // The bytes of a long take are better gone before what follows.
    written.files.clear();
    // For `tell` alone, which says nothing where `--quiet` is.
    let compares = row.format == Format::Gltf && written.error.is_some() && !is_of_many && !args.batch.spread.quiet;
    let plain_bytes = compares
        .then(|| {
            let plain = Exporter::new().keep_constant(args.write.keep_constant);
            Ok::<_, mocap::Error>(plain.write(&scene, Format::Gltf)?.len())
        })
        .transpose()?;
    decisions.append(&mut written.notes);
    let frames = scene.animations.first().map_or(0, Animation::frame_count);
    if let (true, [first, _, ..]) = (row.has_one_clip, scene.animations.as_slice()) {
        let count = scene.animations.len();
        decisions.push(format!(
            "clip: 0 \"{}\" of {count}, because {} has one; --clip takes another",
            first.name, row.name
        ));
    }
    let mut warnings = std::mem::take(&mut scene.warnings);
    warnings.append(&mut written.warnings);
    // A BVH file does not say how it was made.
    let verifier = args.verify.then(|| {
        let importer = args.read.importer();
        Verifier::new().importer(importer).provenance(Provenance::of(&scene))
    });
    // The keys of a long take are better gone before the file is read back.
    drop(scene);
    Ok(Converted {
        waits: false,
        skeleton,
        guesses,
        warnings,
        verification: verifier.map(|verifier| verifier.files(input, output)).transpose()?,
        hash,
        choice: choice(&args.write.smaller, *format),
        decisions,
        renamed: written.renamed,
        bytes,
        max_error: written.error.as_ref().map(|error| error.max_error),
        // What other formats have to say of it is one of their notes.
        achieved: written.error.filter(|_| row.takes(WriteOption::Compress)),
        plain_bytes,
        nodes: written.nodes,
        frames,
    })
}

/// A hash of the names and parents of all nodes, and of where those below the root are at rest.
fn skeleton_hash(scene: &Scene) -> String {
    let mut bytes = Vec::new();
    for node in &scene.nodes {
        bytes.extend(node.name.as_bytes());
        bytes.push(0);
        let parent = node.parent.map_or(u64::MAX, |parent| parent.index() as u64);
        bytes.extend(parent.to_le_bytes());
        if node.parent.is_some() {
            let place = node.transform.to_cols_array();
            bytes.extend(place.iter().flat_map(|value| value.to_le_bytes()));
        }
    }
    sha256_of(&bytes)
}

fn tell(input: &Path, output: &Path, converted: &Converted) {
    let Converted {
        nodes, frames, bytes, ..
    } = converted;
    if let Some(decision) = &converted.choice {
        report::say(decision);
    }
    for decision in &converted.decisions {
        report::say(decision);
    }
    for renamed in &converted.renamed {
        report::say(&format!(
            "node \"{}\" has the name \"{}\" in the file",
            renamed.from, renamed.to
        ));
    }
    report::say(&format!(
        "{} -> {}: {nodes} nodes, {frames} frames, {bytes} bytes",
        input.display(),
        output.display(),
    ));
    if let Some(achieved) = &converted.achieved {
        report::say(&smaller(achieved, *bytes, converted.plain_bytes));
    }
    if let Some(verification) = &converted.verification {
        report::say(&verify::summary(verification));
    }
}

/// How much was left out, and how far the file is from the scene for it.
fn smaller(achieved: &Achieved, bytes: usize, plain_bytes: Option<usize>) -> String {
    let (most, rms) = (
        verify::millimetres(achieved.max_error),
        verify::millimetres(achieved.rms_error),
    );
    let mut text = format!(
        "{} keys, {most} mm at most, {rms} mm RMS; at most at \"{}\", frame {}",
        achieved.keys, achieved.joint, achieved.tick
    );
    if let Some(plain) = plain_bytes {
        let ratio = plain as f64 / bytes.max(1) as f64;
        text += &format!("; {ratio:.1} times smaller than the {plain} bytes of a .glb without compression");
    }
    text
}

/// Imports a file for an output in a format. Where that has the meshes of the file, a skeleton needs none.
fn import(args: &ConvertArgs, input: &Path, format: OutputFormat) -> mocap::Result<Scene> {
    let has_file_meshes = format.row().has_file_meshes;
    let mesh = match args.mesh {
        Some(mesh) => mesh.into(),
        None if has_file_meshes => SkeletonMesh::Own,
        None => SkeletonMesh::Skinned,
    };
    // Many files keep all threads busy, a thread a file.
    let threads = match args.batch.out_dir {
        Some(_) => 1,
        None => thread_count(args.batch.spread.threads),
    };
    let importer = || {
        let importer = args.read.importer().skeleton_mesh(mesh).threads(threads);
        importer.gltf_meshes(has_file_meshes)
    };
    import_to_resample(importer, input, args.change.frames.fps)
}
