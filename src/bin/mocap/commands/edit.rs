//! `mocap edit`: changes a motion.

use std::path::Path;

use mocap::convert::FirstFrame;
use mocap::edit::{ContactOptions, EditReport, EditStep, StepInput, StepReport, contacts};
use mocap::figure::{Humanoid, humanoid};
use mocap::files::ReplacePolicy;
use mocap::render::{Clip, Drawing, PlotOptions};
use mocap::scene::{AppliedStep, Scene};
use mocap::{Conversion, SkeletonMesh};

use super::plot::joints_named;
use super::{
    check_json, convert_aloud, extension, import_moving, mapped, output_format, print_json, run as job, scene_bytes,
    short_name, unknown_extension, write_drawing, write_output, write_whole_output,
};
use crate::args::{EditArgs, Given};
use crate::report::Voice;
use crate::{Failure, report, streams};

pub(crate) fn run(args: &EditArgs, given: &Given) -> Result<(), Failure> {
    let format = output_format(&args.output, args.to.as_deref(), "glb")?;
    check_json(args.json, &args.output)?;
    if !["glb", "gltf", "bvh", "fbx"].contains(&format.as_str()) {
        return Err(unknown_extension(&args.output, ".glb, .gltf, .bvh or .fbx"));
    }
    let fbx = args.fbx.options(given, &format, &args.output)?;
    if let Some(file) = &args.contacts
        && !["json", "npz"].contains(&extension(file).as_str())
    {
        return Err(unknown_extension(file, ".json or .npz"));
    }
    if let Some(file) = &args.curves
        && !["svg", "png"].contains(&extension(file).as_str())
    {
        return Err(unknown_extension(file, ".png or .svg"));
    }
    if args.steps.0.is_empty() && args.contacts.is_none() {
        return Err(Failure::Usage("name a step: --step NAME; --help lists them".to_owned()));
    }
    let names: Vec<String> = args.inputs[1..].iter().map(|file| file.display().to_string()).collect();
    let others = EditStep::second_motions(&args.steps.0, &names);
    let others = others.map_err(|error| Failure::Usage(error.diagnostic().message.clone()))?;
    if args.print.print_job {
        return job::print(&args.job(&format)?);
    }
    let policy = ReplacePolicy::new(&args.inputs).force(args.force);
    if !streams::is_standard(&args.output) {
        policy.check_inputs(&args.output)?;
    }
    let mut scenes = args
        .inputs
        .iter()
        .map(|file| import(args, file, &format))
        .collect::<Result<Vec<Scene>, _>>()?;
    let mut scene = scenes.remove(0);
    let bones = bones(args, &scene)?;
    let mut reports: Vec<EditReport> = Vec::new();
    for (step, other) in args.steps.0.iter().zip(others) {
        let other = other.map(|other| &scenes[other]);
        let input = StepInput::new().other(other).humanoid(bones.as_ref());
        let found = step
            .apply(&mut scene, &input)
            .map_err(|error| error.with_path(&args.inputs[0]))?;
        if !args.json {
            report::say(&found.to_string());
        }
        reports.push(found);
    }
    let contact_bytes = match &args.contacts {
        Some(file) => {
            policy.check_inputs(file)?;
            let options = ContactOptions::new().hands(true);
            let found = contacts(&scene, 0, bones.as_ref(), &options);
            let found = found.map_err(|error| error.with_path(&args.inputs[0]))?;
            let bytes = match extension(file).as_str() {
                "npz" => found.to_npz(),
                _ => serde_json::to_vec(&found).unwrap_or_default(),
            };
            Some((file, bytes))
        }
        None => None,
    };
    if let Some(file) = &args.curves {
        policy.check_inputs(file)?;
        joints_named(&scene, &args.joint)?;
    }
    let (bytes, images) = scene_bytes(&scene, &format, &fbx, &mut Voice::Aloud)?;
    write_whole_output(&policy, &args.output, &bytes, &images)?;
    if let Some((file, bytes)) = contact_bytes {
        write_output(&policy, file, &bytes)?;
    }
    if let Some(file) = &args.curves {
        draw(args, &scene, reports.last(), file)?;
    }
    if args.json {
        print_json(&reports)?;
    }
    Ok(())
}

/// Draws curves of the changed motion, with the keys of the last step.
fn draw(args: &EditArgs, scene: &Scene, last: Option<&EditReport>, file: &Path) -> Result<(), Failure> {
    let marked_frames = match last.map(|last| &last.changed) {
        Some(StepReport::InBetween(report)) => report.keys.clone(),
        _ => Vec::new(),
    };
    let options = PlotOptions::new().marked_frames(marked_frames);
    let name = short_name(&args.output);
    let clip = Clip { name: &name, scene };
    write_drawing(
        &Drawing::plot(&clip, &joints_named(scene, &args.joint)?, &options),
        file,
    )
}

/// The bones where `--map` names some; else each step finds them.
fn bones(args: &EditArgs, scene: &Scene) -> Result<Option<Humanoid>, Failure> {
    let map = args.map.bones_here();
    match map.is_empty() {
        true => Ok(None),
        false => mapped(humanoid(scene), scene, map, "--map").map(Some),
    }
}

/// A motion with one animation, without a rest pose in the first frame; for glTF and FBX in metres with +Y up.
fn import(args: &EditArgs, file: &Path, format: &str) -> Result<Scene, Failure> {
    let importer = match format {
        // A skeleton needs no mesh in FBX.
        "fbx" => args.read.importer().skeleton_mesh(SkeletonMesh::Own).gltf_meshes(true),
        _ => args.read.importer().skeleton_mesh(SkeletonMesh::Skinned),
    };
    let mut scene = import_moving(&importer, file, &mut Voice::Aloud)?;
    report::clip_taken(&scene);
    if scene.animations.len() > 1 {
        scene.animations.truncate(1);
        scene.metadata.steps.push(AppliedStep::SelectClip { index: 0 });
    }
    args.source.state(&mut scene);
    // A rest pose before the motion is no part of it: a filter or a seam would mix it in.
    let conversion = Conversion::new()
        .first_frame(FirstFrame::DropRestPose)
        .bones(args.map.bones_here())
        .keep_units(format == "bvh");
    convert_aloud(&conversion, &mut scene, file)?;
    Ok(scene)
}
