//! `mocap retarget`: motions on a character.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use mocap::convert::leave_out_rest_pose;
use mocap::fbx::FbxOptions;
use mocap::figure::{Humanoid, humanoid};
use mocap::files::ReplacePolicy;
use mocap::gltf::{Character, Provenance};
use mocap::retarget::{RetargetOptions, RetargetReport, Retargeter, check_target};
use mocap::scene::{Animation, Scene, Topic};
use mocap::{Code, Conversion, Importer, SkeletonMesh, vrma};

use super::{
    ImageFile, check_json, convert_aloud, extension, import_moving, mapped, output_format, print_json, scene_bytes,
    short_name, unknown_extension, write_whole_output,
};
use crate::args::{FeetArg, Given, RetargetArgs};
use crate::{Failure, report, streams};

/// Where the motions go.
enum Target {
    /// A file that is passed through, with further animations.
    Character(Box<Character>),
    /// A scene that is written.
    Scene(Box<Scene>),
}

impl Target {
    fn scene(&self) -> &Scene {
        match self {
            Self::Character(character) => character.scene(),
            Self::Scene(scene) => scene,
        }
    }

    fn into_scene(self) -> Scene {
        match self {
            Self::Character(character) => character.scene().clone(),
            Self::Scene(scene) => *scene,
        }
    }
}

pub(crate) fn run(args: &RetargetArgs, given: &Given) -> Result<(), Failure> {
    let (motions, file) = inputs(args)?;
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
    check_output(args, &file, &target, &format)?;
    let fbx = args.fbx.options(given, &format, &args.output)?;
    let bones = match &target {
        Target::Character(character) => character.humanoid().cloned(),
        Target::Scene(_) => None,
    };
    let bones = bones.unwrap_or_else(|| humanoid(target.scene()));
    let bones = mapped(
        bones,
        target.scene(),
        args.character_map.clone().unwrap_or_default(),
        "--character-map",
    )?;
    check_target(target.scene(), Some(&bones)).map_err(|error| error.with_path(&file))?;
    let mut clips: Vec<(Animation, Provenance)> = Vec::new();
    let mut reports: Vec<RetargetReport> = Vec::new();
    let mut names = Names::new(&target, args.replace_animations);
    for motion in &motions {
        let mut source = import_source(args, motion)?;
        let options = RetargetOptions {
            scale: args.scale.0,
            source: Some(mapped(humanoid(&source), &source, args.map.bones_here(), "--map")?),
            target: Some(bones.clone()),
        };
        let retargeter = Retargeter::new(&source, target.scene(), &options);
        let mut retargeter = retargeter.map_err(|error| error.with_path(motion))?;
        if leave_out_rest_pose(&mut source).map_err(|error| error.with_path(motion))? {
            let file = motion.display();
            report::say(&format!("{file}: the first frame, a rest pose, is left out"));
        }
        let step = retargeter.step(target.scene(), args.feet == FeetArg::Lock);
        for (index, animation) in source.animations.iter().enumerate() {
            let name = names.of(motion, &source, animation);
            let mut provenance = Provenance::of_clip(&source, index);
            provenance.steps.push(step.clone());
            let (moved, found) = moved(&mut retargeter, &source, index, target.scene(), name, args.feet)?;
            reports.push(found);
            clips.push((moved, provenance));
        }
    }
    let count = clips.len();
    let (bytes, images) = write(args, target, bones, clips, (&format, &fbx))?;
    write_whole_output(&policy, &args.output, &bytes, &images)?;
    match args.json {
        true => print_json(&reports)?,
        false => reports.iter().for_each(tell),
    }
    let plural = if count == 1 { "" } else { "s" };
    report::say(&format!("{}: {count} clip{plural} added", args.output.display()));
    match args.max_angle {
        Some(most) => require(&reports, most.0),
        None => Ok(()),
    }
}

/// An animation of the source on the target, with its feet locked where that is asked for and better, and its report.
pub(super) fn moved(
    retargeter: &mut Retargeter,
    source: &Scene,
    index: usize,
    target: &Scene,
    name: String,
    feet: FeetArg,
) -> mocap::Result<(Animation, RetargetReport)> {
    let (mut moved, mut found) = retargeter.clip(source, index, target, feet == FeetArg::Lock)?;
    found.clip.clone_from(&name);
    moved.name = name;
    Ok((moved, found))
}

/// The motions, and the file of the character.
fn inputs(args: &RetargetArgs) -> Result<(Vec<PathBuf>, PathBuf), Failure> {
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

fn import_target(args: &RetargetArgs, file: &Path) -> Result<Target, Failure> {
    if streams::is_standard(file) {
        let message = "the character cannot come from standard input: name a file, not -";
        return Err(Failure::Usage(message.to_owned()));
    }
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::None);
    if args.to_skeleton.is_none() {
        // The skin shows the soles of the feet.
        match Importer::new().gltf_meshes(true).import_character(file) {
            Ok(character) => return Ok(Target::Character(Box::new(character))),
            Err(error) if error.code() == Code::UnknownFormat => {}
            Err(error) => return Err(error.into()),
        }
    }
    // Meshes of the file come along; without any, the skeleton is drawn.
    let importer = match args.to_skeleton {
        Some(_) => importer,
        // A skeleton needs no mesh in FBX.
        None if writes_fbx(args) => Importer::new().skeleton_mesh(SkeletonMesh::Own),
        None => Importer::new().skeleton_mesh(SkeletonMesh::Skinned),
    };
    let scene = importer.import(file)?;
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
    Ok(Target::Scene(Box::new(scene)))
}

fn writes_fbx(args: &RetargetArgs) -> bool {
    extension(&args.output) == "fbx" || args.to.as_deref() == Some("fbx")
}

fn import_source(args: &RetargetArgs, motion: &Path) -> Result<Scene, Failure> {
    let importer = args.read.importer().skeleton_mesh(SkeletonMesh::None);
    let mut scene = import_moving(&importer, motion)?;
    args.source.state(&mut scene);
    convert_aloud(&Conversion::new().bones(args.map.bones_here()), &mut scene, motion)?;
    Ok(scene)
}

/// Names for clips that no other clip of the file has.
struct Names {
    taken: HashSet<String>,
}

impl Names {
    fn new(target: &Target, replace: bool) -> Self {
        // A scene that is written has the new motions alone.
        let stay = matches!(target, Target::Character(_)) && !replace;
        let present = target.scene().animations.iter().filter(|_| stay);
        Self {
            taken: present.map(|animation| animation.name.clone()).collect(),
        }
    }

    /// The name of the file, and that of the clip where the file has several.
    fn of(&mut self, motion: &Path, source: &Scene, animation: &Animation) -> String {
        let file = short_name(motion);
        let name = match (source.animations.len(), animation.name.as_str()) {
            (1, _) | (_, "") => file,
            (_, name) => name.to_owned(),
        };
        let numbered = (2..).map(|number| format!("{name}_{number}"));
        let mut candidates = std::iter::once(name.clone()).chain(numbered);
        let free = candidates.find(|candidate| self.taken.insert(candidate.clone()));
        free.unwrap_or(name)
    }
}

/// Refuses an output of another format than the target can be written in.
fn check_output(args: &RetargetArgs, file: &Path, target: &Target, wanted: &str) -> Result<(), Failure> {
    let output = &args.output;
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

fn write(
    args: &RetargetArgs,
    target: Target,
    bones: Humanoid,
    clips: Vec<(Animation, Provenance)>,
    (format, fbx): (&str, &FbxOptions),
) -> Result<(Vec<u8>, Vec<ImageFile>), Failure> {
    match target {
        target if ["vrma", "fbx"].contains(&format) => {
            let mut scene = target.into_scene();
            scene.animations = clips.iter().map(|(clip, _)| clip.clone()).collect();
            Conversion::new().apply(&mut scene)?;
            if let Some((_, provenance)) = clips.first() {
                provenance.record(&mut scene);
            }
            if format == "fbx" {
                return Ok(scene_bytes(&scene, format, fbx)?);
            }
            let options = vrma::VrmaOptions {
                humanoid: Some(bones),
                ..vrma::VrmaOptions::default()
            };
            Ok((vrma::write(&scene, &options)?.0, Vec::new()))
        }
        Target::Character(character) => Ok((character.with_clips(&clips, args.replace_animations)?, Vec::new())),
        Target::Scene(mut scene) => {
            if format == "bvh" && clips.len() > 1 {
                let message = format!("{}: a BVH file has one motion; name one", args.output.display());
                return Err(Failure::Usage(message));
            }
            scene.animations = clips.iter().map(|(clip, _)| clip.clone()).collect();
            // BVH keeps the target's own unit and axes.
            if format != "bvh" {
                Conversion::new().apply(&mut scene)?;
            }
            if let Some((_, provenance)) = clips.first() {
                provenance.record(&mut scene);
            }
            Ok(scene_bytes(&scene, format, fbx)?)
        }
    }
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

/// An error where a limb is farther off than allowed.
fn require(reports: &[RetargetReport], most: f64) -> Result<(), Failure> {
    let mut worst = None;
    for found in reports {
        for limb in &found.limbs {
            if worst.is_none_or(|(_, angle, _)| limb.max_degrees > angle) {
                worst = Some((&found.clip, limb.max_degrees, limb));
            }
        }
    }
    match worst {
        Some((clip, angle, limb)) if angle > most => {
            report::complain(&format!(
                "{clip}: {} is {angle:.2} degrees off at tick {}, and {most} are allowed",
                limb.bone.as_str(),
                limb.tick
            ));
            Err(Failure::Told)
        }
        _ => Ok(()),
    }
}
