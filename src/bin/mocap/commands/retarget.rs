//! `mocap retarget`: motions on a character.

use std::path::{Path, PathBuf};

use mocap::fbx::FbxOptions;
use mocap::files::ReplacePolicy;
use mocap::job::Feet;
use mocap::retarget::RetargetReport;
use mocap::retargeting::{Retargeting, RetargetingOptions, Target};
use mocap::scene::{Scene, Topic};
use mocap::{Code, Importer, SkeletonMesh, vrma};

use super::{
    ImageFile, check_json, extension, import_moving, output_format, print_json, run as job, scene_bytes, short_name,
    unknown_extension, write_whole_output,
};
use crate::args::{Given, RetargetArgs};
use crate::report::Voice;
use crate::{Failure, report, streams};

pub(crate) fn run(args: &RetargetArgs, given: &Given) -> Result<(), Failure> {
    let (motions, file) = inputs(args)?;
    given.refuse(
        &["resume", "shard", "threads", "progress", "quiet", "allow-empty"],
        "all motions go into one file; -o FOLDER/ makes a file of each",
    )?;
    if let Some(folder) = motions.iter().find(|motion| motion.is_dir()) {
        let message = "is a folder, and each of its motions gets a file of its own: name an output folder, -o FOLDER/";
        return Err(Failure::Usage(format!("{} {message}", folder.display())));
    }
    check_json(args.json, &args.output)?;
    let policy = ReplacePolicy::new(args.paths.iter().chain([&file])).force(args.force);
    if !streams::is_standard(&args.output) {
        policy.check_inputs(&args.output)?;
    }
    let target = import_target(args, &file)?;
    let default = match target {
        Target::Character(_) if extension(&file) == "gltf" => "gltf",
        _ => "glb",
    };
    let format = output_format(&args.output, args.to.as_deref(), default)?;
    check_output(args, &file, &target, &format, &args.output)?;
    let fbx = args.fbx.options(given, &format, &args.output)?;
    if args.print.print_job {
        return job::print(&args.job(&motions, &file, &format));
    }
    let mut retargeting = onto(args, target, &file)?;
    let importer = args.read.importer();
    for motion in &motions {
        add(args, &mut retargeting, &importer, motion, &mut Voice::Aloud)?;
    }
    let written = write(&retargeting, &args.output, &format, &fbx, &mut Voice::Aloud);
    let (bytes, images) = written?;
    write_whole_output(&policy, &args.output, &bytes, &images)?;
    let reports: Vec<&RetargetReport> = retargeting
        .clips()
        .iter()
        .filter_map(|clip| clip.report.body())
        .collect();
    match args.json {
        true => print_json(&reports)?,
        false => reports.iter().for_each(|found| tell(found)),
    }
    let count = reports.len();
    let plural = if count == 1 { "" } else { "s" };
    report::say(&format!("{}: {count} clip{plural} added", args.output.display()));
    match args.max_angle {
        Some(most) => require(&reports, most.0),
        None => Ok(()),
    }
}

/// The target, without a motion yet.
pub(super) fn onto(args: &RetargetArgs, target: Target, file: &Path) -> Result<Retargeting, Failure> {
    let options = RetargetingOptions::new()
        .scale(args.scale.0)
        .lock_feet(args.feet == Feet::Lock)
        .source_bones(args.map.bones_here())
        .target_bones(args.character_map.clone().unwrap_or_default())
        .replace_animations(args.replace_animations);
    Retargeting::onto(target, options).map_err(|error| match error.code() {
        Code::InvalidValue => Failure::Usage(format!("--character-map: {}", error.diagnostic().message)),
        _ => error.with_path(file).into(),
    })
}

/// Puts the motions of a file on the target.
pub(super) fn add(
    args: &RetargetArgs,
    retargeting: &mut Retargeting,
    importer: &Importer,
    motion: &Path,
    voice: &mut Voice<'_>,
) -> Result<(), Failure> {
    let importer = importer.clone().skeleton_mesh(SkeletonMesh::None);
    let mut scene = import_moving(&importer, motion, voice)?;
    args.source.state(&mut scene);
    let source = retargeting.prepare(scene).map_err(|error| error.with_path(motion))?;
    let decisions = source.assumptions.iter();
    decisions.for_each(|decision| voice.say(&decision.to_string()));
    let moved = retargeting.add(source.named(short_name(motion)));
    if moved.map_err(|error| error.with_path(motion))?.is_rest_pose_left_out {
        let file = motion.display();
        voice.say(&format!("{file}: the first frame, a rest pose, is left out"));
    }
    Ok(())
}

/// The motions, and the file of the character.
pub(super) fn inputs(args: &RetargetArgs) -> Result<(Vec<PathBuf>, PathBuf), Failure> {
    if let Some(named) = args.character.as_ref().or(args.to_skeleton.as_ref()) {
        return Ok((args.paths.clone(), named.clone()));
    }
    match args.paths.as_slice() {
        [motions @ .., character] if !motions.is_empty() => Ok((motions.to_vec(), character.clone())),
        _ => Err(Failure::Usage(
            "name a motion and after it a character: mocap retarget MOTION CHARACTER -o OUT".to_owned(),
        )),
    }
}

pub(super) fn import_target(args: &RetargetArgs, file: &Path) -> Result<Target, Failure> {
    if streams::is_standard(file) {
        let message = "the character cannot come from standard input: name a file, not -";
        return Err(Failure::Usage(message.to_owned()));
    }
    // Meshes of the file come along; without any, the skeleton is drawn. A skeleton needs no mesh in FBX.
    let mesh = match writes_fbx(args) {
        true => SkeletonMesh::Own,
        false => SkeletonMesh::Skinned,
    };
    let target = match args.to_skeleton {
        Some(_) => Importer::new().skeleton_mesh(SkeletonMesh::None).import(file)?.into(),
        None => Target::import(file, &Importer::new().skeleton_mesh(mesh))?,
    };
    if let Target::Skeleton(scene) = &target {
        tell_of_skeleton(scene, file);
    }
    Ok(target)
}

/// What is to be known of a skeleton onto which motions go.
fn tell_of_skeleton(scene: &Scene, file: &Path) {
    // A character need not move.
    let warnings: Vec<_> = scene
        .warnings
        .iter()
        .filter(|warning| warning.code != Code::NoMotion)
        .cloned()
        .collect();
    report::warnings(Some(file), &warnings);
    for left_out in scene
        .metadata
        .assumptions
        .iter()
        .filter(|assumption| assumption.topic == Topic::Meshes)
    {
        report::say(&left_out.to_string());
    }
}

fn writes_fbx(args: &RetargetArgs) -> bool {
    extension(&args.output) == "fbx" || args.to.as_deref() == Some("fbx")
}

/// Refuses an output of another format than the target can be written in.
pub(super) fn check_output(
    args: &RetargetArgs,
    file: &Path,
    target: &Target,
    wanted: &str,
    output: &Path,
) -> Result<(), Failure> {
    // These are written from the scene, and hold the new motions alone.
    let is_whole = ["vrma", "fbx"].contains(&wanted);
    let adds = !is_whole && matches!(target, Target::Character(_));
    if args.replace_animations && !adds {
        let message =
            "--replace-animations would do nothing: only a glTF or VRM output keeps the animations of its character";
        return Err(Failure::Usage(message.to_owned()));
    }
    if is_whole {
        return Ok(());
    }
    let Target::Character(character) = target else {
        return match wanted {
            "glb" | "gltf" | "bvh" => Ok(()),
            _ => Err(unknown_extension(output, ".glb, .gltf, .bvh, .fbx or .vrma")),
        };
    };
    let is_text = extension(file) == "gltf";
    let fits = if is_text {
        wanted == "gltf"
    } else {
        ["glb", "vrm"].contains(&wanted)
    };
    if !fits {
        let known = if is_text {
            ".gltf, as that of the character, .fbx or .vrma"
        } else {
            ".glb or .vrm, as that of the character, .fbx or .vrma"
        };
        return Err(unknown_extension(
            output,
            &format!("{known}; --to-skeleton takes the skeleton alone"),
        ));
    }
    let folder = |path: &Path| path.parent().map(Path::to_owned).unwrap_or_default();
    let files = character.external_files()?;
    if let Some(beside) = files.first().filter(|_| folder(file) != folder(output)) {
        return Err(Failure::Usage(format!(
            "{} would not find {beside}, which is beside the character: write into its folder",
            output.display()
        )));
    }
    Ok(())
}

/// The bytes of the output, and the images beside it.
pub(super) fn write(
    retargeting: &Retargeting,
    output: &Path,
    format: &str,
    fbx: &FbxOptions,
    voice: &mut Voice<'_>,
) -> Result<(Vec<u8>, Vec<ImageFile>), Failure> {
    if format == "vrma" {
        let options = vrma::VrmaOptions::new().humanoid(retargeting.humanoid().cloned());
        return Ok((vrma::write(&retargeting.scene_in_metres()?, &options)?.0, Vec::new()));
    }
    if format != "fbx"
        && let Some(bytes) = retargeting.character_file()?
    {
        return Ok((bytes, Vec::new()));
    }
    if format == "bvh" && retargeting.clips().len() > 1 {
        let message = format!("{}: a BVH file has one motion; name one", output.display());
        return Err(Failure::Usage(message));
    }
    let scene = match format {
        // BVH keeps the target's own unit and axes.
        "bvh" => retargeting.scene(),
        _ => retargeting.scene_in_metres()?,
    };
    Ok(scene_bytes(&scene, format, fbx, voice)?)
}

pub(super) fn tell(found: &RetargetReport) {
    report::say(&format!(
        "{}: limbs {:.2} degrees off in the mean, {:.2} at most, in {} frames: {}; path scaled by {:.3}",
        found.clip,
        found.mean_degrees,
        found.max_degrees,
        found.frames,
        found.verdict.as_str(),
        found.scale
    ));
    for limb in found.limbs.iter().filter(|limb| limb.mean_degrees > 1.0) {
        report::say(&format!(
            "{}: {} {:.1} degrees off in the mean, {:.1} at tick {}",
            found.clip,
            limb.bone.as_str(),
            limb.mean_degrees,
            limb.max_degrees,
            limb.tick
        ));
    }
    for seen in found.seen.iter().filter(|seen| seen.mean_degrees > 15.0) {
        report::say(&format!(
            "{}: {seen} {:.0} degrees off in the mean, {:.0} at tick {}",
            found.clip, seen.mean_degrees, seen.max_degrees, seen.tick
        ));
    }
    for guess in &found.guessed {
        report::say(&format!(
            "{}: {} is guessed: {}",
            found.clip,
            guess.bone.as_str(),
            guess.reason
        ));
    }
    if let Some(feet) = &found.feet {
        let centimetres = |metres: f64| 100.0 * metres;
        report::say(&format!(
            "{}: feet on the ground slide {:.1} cm/s, {:.1} in the source; {:.1} % of frames are more than 1 cm below the floor, {:.1} % in the source",
            found.clip,
            centimetres(feet.target.skate),
            centimetres(feet.source.skate),
            100.0 * feet.target.share_below_floor,
            100.0 * feet.source.share_below_floor
        ));
    }
    for clamped in &found.clamped {
        report::say(&format!(
            "{}: {} is up to {:.1} cm away in {} frames: {}",
            found.clip,
            clamped.bone.as_str(),
            100.0 * clamped.largest,
            clamped.frames,
            clamped.reason
        ));
    }
    let reasons: Vec<&str> = found.unmapped.iter().map(|lack| lack.reason.as_str()).collect();
    let mut kinds = reasons.clone();
    kinds.sort_unstable();
    kinds.dedup();
    for reason in kinds {
        let bones = found.unmapped.iter().filter(|lack| lack.reason == reason);
        let (fingers, others): (Vec<_>, Vec<_>) = bones.map(|lack| lack.bone).partition(|bone| bone.is_finger());
        let mut bones: Vec<String> = others.iter().map(|bone| bone.as_str().to_owned()).collect();
        if !fingers.is_empty() {
            bones.push(format!("{} bones of fingers", fingers.len()));
        }
        report::say(&format!("{}: {}: {reason}", found.clip, bones.join(", ")));
    }
}

/// An error where anything of a motion is farther off than allowed.
fn require(reports: &[&RetargetReport], most: f64) -> Result<(), Failure> {
    let worst = reports
        .iter()
        .max_by(|a, b| a.worst_degrees().total_cmp(&b.worst_degrees()));
    let Some(problem) = worst.and_then(|found| found.problem(most)) else {
        return Ok(());
    };
    report::complain(&problem);
    Err(Failure::Told)
}
