//! `mocap convert`: a motion file to animated glTF, to BVH, to FBX or to a VRM animation.

use std::collections::BTreeMap;
use std::path::Path;

use mocap::compress::PackedClip;
use mocap::figure::humanoid;
use mocap::files::{ReplacePolicy, remove_unfinished, write_file};
use mocap::gltf::{self, Achieved, BufferPlace, Compression, Renamed};
use mocap::scene::{Animation, Assumption, Confidence, Scene, Topic, UpAxis};
use mocap::verify::{Verification, Verifier};
use mocap::{Diagnostic, SkeletonMesh, bvh, fbx, vrma};

use super::{change, fewer_keys, import_to_resample, textures_beside, verify, write_with_textures};
use crate::args::{CompressArg, ConvertArgs, FBX_OPTIONS, FormatArg, Given, NOT_FBX, NOT_ONE_FILE};
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
        [input] => (input, input.with_extension(args.batch.to.extension())),
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
    let format = match FormatArg::of(&output) {
        Some(format) => format,
        None if streams::is_standard(&output) => args.batch.to,
        None => {
            let message = format!(
                "{} should end in .glb, .gltf, .mclip, .bvh, .fbx or .vrma",
                output.display()
            );
            return Err(Failure::Usage(message));
        }
    };
    refuse_unused(args, given, format)?;
    if streams::is_standard(&output) {
        return to_standard_output(args, input, format);
    }
    if streams::is_standard(input) && args.verify {
        return Err(Failure::Usage(
            "--verify reads the source again: name a file, not -".to_owned(),
        ));
    }
    let policy = ReplacePolicy::new([input]).force(args.force);
    let converted = convert(args, input, &output, &policy, &|| false, Round::Alone)?;
    report::warnings(Some(input), &converted.warnings);
    if !args.batch.spread.quiet {
        tell(input, &output, &converted);
    }
    match &converted.verification {
        Some(verification) => verify::require(verification, args.compress.tolerance()),
        None => Ok(()),
    }
}

/// Converts one file to standard output.
fn to_standard_output(args: &ConvertArgs, input: &Path, format: FormatArg) -> Result<(), Failure> {
    if args.verify {
        return Err(Failure::Usage(
            "--verify reads the output again: name a file, not -".to_owned(),
        ));
    }
    let is_bvh = matches!(format, FormatArg::Bvh);
    let mut scene = import(args, input, Some(format))?;
    let mut decisions = change::apply(&mut scene, args, is_bvh, None).map_err(|error| error.with_path(input))?;
    let (bytes, mut warnings) = match format {
        FormatArg::Bvh => {
            let warning = bvh::scale_warning(&scene, &args.bvh.options())?;
            (bvh::write(&scene, &args.bvh.options())?, Vec::from_iter(warning))
        }
        FormatArg::Glb | FormatArg::Gltf => {
            let document = gltf::Document::new(&scene, &gltf_options(args))?;
            let bytes = match format {
                FormatArg::Gltf => document.to_embedded()?,
                _ => document.to_glb()?,
            };
            (bytes, document.report().warnings.clone())
        }
        FormatArg::Fbx => {
            let (bytes, written) = fbx::write(&scene, &args.fbx.options(args.compress.max_error()))?;
            decisions.extend(fewer_keys(&written));
            (bytes, written.warnings)
        }
        FormatArg::Mclip => (packed(args, &scene)?.bytes().to_vec(), Vec::new()),
        FormatArg::Vrma => {
            let (bytes, written) = vrma::write(&scene, &vrma_options(args, &scene))?;
            decisions.extend(left_out(&written.left_out));
            (bytes, written.warnings)
        }
    };
    scene.warnings.append(&mut warnings);
    report::warnings(Some(input), &scene.warnings);
    if !args.batch.spread.quiet {
        for decision in decisions {
            report::say(&decision);
        }
    }
    streams::write(Path::new("-"), &bytes)
}

fn gltf_options(args: &ConvertArgs) -> gltf::GltfOptions {
    gltf::GltfOptions {
        keep_constant: args.keep_constant,
        buffer: if args.embed {
            BufferPlace::Embedded
        } else {
            BufferPlace::Beside
        },
        compression: args.compress.compression(),
        error_bound: args.compress.bound_of_keys(),
    }
}

fn vrma_options(args: &ConvertArgs, scene: &Scene) -> vrma::VrmaOptions {
    vrma::VrmaOptions {
        // The conversion has refused a map whose names are not those of joints.
        humanoid: humanoid(scene).with_map(scene, args.map.bones_here()).ok(),
        gltf: gltf_options(args),
    }
}

/// What a VRM animation does not have of its source, in words.
fn left_out(joints: &[String]) -> Option<String> {
    const MOST: usize = 8;
    let (shown, more) = joints.split_at(joints.len().min(MOST));
    let more = match more.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let names = shown.join(", ");
    (!joints.is_empty()).then(|| format!("joints: {names}{more} left out, because they are no bones of VRM"))
}

/// Refuses options that do not go together.
pub(crate) fn check(args: &ConvertArgs) -> Result<(), Failure> {
    let options_are_sound = change::conversion(args).check();
    options_are_sound.map_err(|error| Failure::Usage(error.diagnostic().message.clone()))?;
    Ok(())
}

/// Half of what to know about a smaller file was said; this is the other half.
fn choice(args: &ConvertArgs, format: Option<FormatArg>) -> Option<String> {
    match (args.compress.compress, args.compress.max_error()) {
        (None, Some(_)) if matches!(format, Some(FormatArg::Mclip | FormatArg::Fbx)) => None,
        (None, Some(_)) => {
            Some("compress: int16, core glTF that all but Assimp read; --compress names others".to_owned())
        }
        (Some(kind), None) if kind != CompressArg::None => Some(format!(
            "max-error: {} mm, because none was named",
            verify::millimetres(args.compress.tolerance())
        )),
        _ => None,
    }
}

/// A packed clip of the first animation.
fn packed(args: &ConvertArgs, scene: &Scene) -> mocap::Result<PackedClip<'static>> {
    PackedClip::encode(scene, 0, args.compress.error_bound())
}

/// Refuses options that change nothing in an output of this format.
pub(crate) fn refuse_unused(args: &ConvertArgs, given: &Given, format: FormatArg) -> Result<(), Failure> {
    let reason = match (&args.batch.out_dir, args.paths.get(1)) {
        (Some(_), _) => Some("textures of many files could have one name; convert one file at a time, or leave it out"),
        (None, Some(output)) if streams::is_standard(output) => Some(NOT_ONE_FILE),
        _ => None,
    };
    let out = &args.change.out;
    let is_exact = matches!(format, FormatArg::Fbx) || args.compress.compression() == Compression::None;
    if args.compress.max_error() == Some(0.0) && !is_exact {
        return Err(Failure::Usage(
            "--max-error 0: integer formats cannot be exact; name a length above 0, or --compress none".to_owned(),
        ));
    }
    let moves_over_ground = args.change.in_place || args.change.root_motion;
    let (converts_unit, converts_up) = match format {
        FormatArg::Bvh => {
            given.refuse(&["mesh"], "BVH has no meshes; write .glb or .gltf, or leave it out")?;
            given.refuse(&["keep-constant"], "BVH has a row for every frame; leave it out")?;
            given.refuse(&["embed"], "only .gltf has a buffer of its own; leave it out")?;
            let why = "it applies to glTF; for fewer digits in BVH use --digits";
            given.refuse(&["compress", "max-error", "shell-distance"], why)?;
            given.refuse(&FBX_OPTIONS, NOT_FBX)?;
            (out.metres_per_unit().is_some(), out.up().is_some() || moves_over_ground)
        }
        FormatArg::Fbx => {
            let why = "it applies to BVH; write .bvh, or leave it out";
            given.refuse(&["order", "digits", "channels"], why)?;
            let why = "FBX is written in centimetres with +Y up, and states both; leave it out";
            given.refuse(&["out-unit", "out-up"], why)?;
            given.refuse(
                &["keep-constant", "embed", "compress", "shell-distance"],
                "it applies to glTF; write .glb, or leave it out",
            )?;
            args.fbx.check(args.compress.max_error(), reason)?;
            (true, true)
        }
        FormatArg::Mclip => {
            given.refuse(&FBX_OPTIONS, NOT_FBX)?;
            let why = "it applies to BVH; write .bvh, or leave it out";
            given.refuse(&["order", "digits", "channels"], why)?;
            let why = "a packed clip is in metres with +Y up; for another unit or axis write .bvh";
            given.refuse(&["out-unit", "out-up"], why)?;
            let why = "it applies to glTF; a packed clip has a form of its own, and no meshes; leave it out";
            given.refuse(&["mesh", "keep-constant", "embed", "compress"], why)?;
            (true, true)
        }
        FormatArg::Glb | FormatArg::Gltf | FormatArg::Vrma => {
            given.refuse(&FBX_OPTIONS, NOT_FBX)?;
            let why = "it applies to BVH; write .bvh, or leave it out";
            given.refuse(&["order", "digits", "channels"], why)?;
            if args.compress.max_error().is_none() && args.compress.compression() == Compression::None {
                let why = "it needs a largest error; add --max-error 1mm, or leave it out";
                given.refuse(&["shell-distance"], why)?;
            }
            let why = "glTF is in metres with +Y up; for another unit or axis write .bvh";
            given.refuse(&["out-unit", "out-up"], why)?;
            if let FormatArg::Vrma = format {
                given.refuse(&["mesh"], "a VRM animation has no meshes; write .glb, or leave it out")?;
                let why = "a VRM animation has rotations alone, and the way of the hips; leave it out";
                given.refuse(&["keep-constant", "root-motion"], why)?;
                given.refuse(
                    &["rest"],
                    "the rest pose of a VRM animation is the T-pose; leave it out",
                )?;
            }
            if let FormatArg::Glb | FormatArg::Vrma = format {
                given.refuse(
                    &["embed"],
                    "a .glb or .vrma holds its buffer; write .gltf, or leave it out",
                )?;
            }
            (true, true)
        }
    };
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
    let has_bones = matches!(format, FormatArg::Vrma);
    if !finds_unit && !finds_up && !has_bones {
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
    dropped_keys: usize,
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
    args: &ConvertArgs,
    input: &Path,
    output: &Path,
    policy: &ReplacePolicy,
    is_known: &dyn Fn() -> bool,
    round: Round<'_>,
) -> mocap::Result<Converted> {
    let format = FormatArg::of(output);
    let is_bvh = matches!(format, Some(FormatArg::Bvh));
    let is_packed = matches!(format, Some(FormatArg::Mclip));
    // Whether a BVH file or a packed clip may be replaced depends on the bytes of the output.
    policy.check_inputs(output)?;
    if !is_bvh && !is_packed {
        policy.check(output)?;
    }
    if matches!(format, Some(FormatArg::Gltf)) && !args.embed {
        policy.check(&output.with_extension("bin"))?;
    }
    if args.batch.out_dir.is_none() {
        remove_unfinished(output);
    }
    let mut scene = import(args, input, format)?;
    let skeleton = match round {
        Round::Alone => String::new(),
        Round::First | Round::Last(_) => skeleton_hash(&scene),
    };
    let of_others = match round {
        Round::Last(axes) => axes.get(&skeleton).copied(),
        Round::Alone | Round::First => None,
    };
    let applied = change::apply(&mut scene, args, is_bvh, of_others);
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
    let mut plain_bytes = None;
    let mut written = gltf::GltfReport::default();
    let mut hash = None;
    let mut of_fbx = None;
    if is_bvh {
        let text = bvh::write(&scene, &args.bvh.options())?;
        if !is_known() {
            policy.check_bytes(output, &text)?;
        }
        write_file(output, &text)?;
        written.bytes = text.len();
        written
            .warnings
            .extend(bvh::scale_warning(&scene, &args.bvh.options())?);
        hash = args.batch.out_dir.is_some().then(|| sha256_of(&text));
    } else if matches!(format, Some(FormatArg::Vrma)) {
        written = vrma::export(&scene, output, &vrma_options(args, &scene)).map_err(|error| error.with_path(input))?;
        decisions.extend(left_out(&written.left_out));
    } else if is_packed {
        let clip = packed(args, &scene).map_err(|error| error.with_path(input))?;
        if !is_known() {
            policy.check_bytes(output, clip.bytes())?;
        }
        write_file(output, clip.bytes())?;
        written.bytes = clip.bytes().len();
        decisions.push(format!("error: {} mm at most", verify::millimetres(clip.max_error())));
        hash = args.batch.out_dir.is_some().then(|| sha256_of(clip.bytes()));
    } else if matches!(format, Some(FormatArg::Fbx)) {
        let options = args.fbx.options(args.compress.max_error());
        let (bytes, report) = fbx::write(&scene, &options).map_err(|error| error.with_path(input))?;
        write_with_textures(policy, output, &bytes, &textures_beside(&scene, &report))?;
        decisions.extend(fewer_keys(&report));
        of_fbx = report.max_error;
        (written.bytes, written.warnings) = (report.bytes, report.warnings);
        let renamed = report.renamed.into_iter();
        written.renamed = renamed.map(|(node, from, to)| Renamed { node, from, to }).collect();
    } else {
        written = gltf::export(&scene, output, &gltf_options(args))?;
        // For `tell` alone, which says nothing where `--quiet` is.
        if written.achieved.is_some() && args.batch.out_dir.is_none() && !args.batch.spread.quiet {
            let plain = gltf::GltfOptions {
                keep_constant: args.keep_constant,
                ..gltf::GltfOptions::default()
            };
            plain_bytes = Some(gltf::Document::new(&scene, &plain)?.glb_len()?);
        }
    }
    let nodes = match format {
        Some(FormatArg::Vrma) => written.joints,
        _ => scene.nodes.len(),
    };
    let frames = scene.animations.first().map_or(0, Animation::frame_count);
    let of_one_clip = match format {
        Some(FormatArg::Bvh) => Some("BVH"),
        Some(FormatArg::Mclip) => Some("a packed clip"),
        _ => None,
    };
    if let (Some(output), [first, _, ..]) = (of_one_clip, scene.animations.as_slice()) {
        let count = scene.animations.len();
        decisions.push(format!(
            "clip: 0 \"{}\" of {count}, because {output} has one; --clip takes another",
            first.name
        ));
    }
    let mut warnings = std::mem::take(&mut scene.warnings);
    warnings.append(&mut written.warnings);
    // A BVH file does not say how it was made.
    let verifier = args.verify.then(|| {
        let importer = args.read.importer();
        Verifier::new()
            .importer(importer)
            .provenance(gltf::Provenance::of(&scene))
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
        choice: choice(args, format),
        decisions,
        renamed: written.renamed,
        dropped_keys: written.dropped_keys,
        bytes: written.bytes,
        max_error: of_fbx.or(written.achieved.as_ref().map(|achieved| achieved.max_error)),
        achieved: written.achieved,
        plain_bytes,
        nodes,
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
    if converted.dropped_keys > 0 {
        report::say(&format!(
            "{} keys were dropped: 32-bit times cannot tell them apart",
            converted.dropped_keys
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

/// Imports a file for an output in a format. FBX has the meshes of the file; a skeleton needs none there.
fn import(args: &ConvertArgs, input: &Path, format: Option<FormatArg>) -> mocap::Result<Scene> {
    let is_fbx = matches!(format, Some(FormatArg::Fbx));
    let mesh = match args.mesh {
        Some(mesh) => mesh.into(),
        None if is_fbx => SkeletonMesh::Own,
        None => SkeletonMesh::Skinned,
    };
    // Many files keep all threads busy, a thread a file.
    let threads = match args.batch.out_dir {
        Some(_) => 1,
        None => thread_count(args.batch.spread.threads),
    };
    let importer = || {
        let importer = args.read.importer().skeleton_mesh(mesh).threads(threads);
        importer.gltf_meshes(is_fbx)
    };
    import_to_resample(importer, input, args.change.frames.fps)
}
