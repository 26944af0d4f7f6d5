//! `mocap edit`: changes a motion.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use mocap::arrays::contacts_npz;
use mocap::edit::ContactOptions;
use mocap::edit::report::{EditReport, StepReport};
use mocap::figure::Humanoid;
use mocap::job::{MotionJob, Notice};
use mocap::render::{Clip, Drawing, PlotOptions};
use mocap::scene::Scene;
use mocap::visible_json;

use super::plot::joints_named;
use super::{
    Place, check_json, drawn, extension, made, own, print_report, refuse_one_file, short_name, unknown_extension,
    verify, view,
};
use crate::args::{ArgumentSources, EditArgs, ViewArgs};
use crate::printed::{PictureReport, ReportList};
use crate::report::Voice;
use crate::{Failure, report, streams};

pub(crate) fn run(args: &EditArgs, given: &ArgumentSources) -> Result<(), Failure> {
    match own::begin(&args.own, given, job(args, given)?)? {
        Some(job) => one(args, given, &job),
        None => Ok(()),
    }
}

/// The job that the arguments describe.
pub(crate) fn job(args: &EditArgs, given: &ArgumentSources) -> Result<MotionJob, Failure> {
    check_beside(args, given)?;
    own::job(&args.own, given, |extension| args.job(extension))
}

/// Refuses further outputs that cannot be made.
fn check_beside(args: &EditArgs, given: &ArgumentSources) -> Result<(), Failure> {
    check_json(args.json, &args.own.output)?;
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
    let beside = [&args.contacts, &args.curves].into_iter().flatten();
    let outputs = std::iter::once(&args.own.output).chain(beside);
    refuse_one_file(outputs.map(PathBuf::as_path))?;
    if args.steps.0.is_empty() && args.contacts.is_none() {
        return Err(Failure::Usage("name a step: --step NAME; --help lists them".to_owned()));
    }
    let of_one = (
        ["contacts-file", "curves", "json", "view"].as_slice(),
        "it is for one motion; name a file, not a folder",
    );
    if args.view
        && [&args.inputs[0], &args.own.output]
            .into_iter()
            .any(|file| streams::is_standard(file))
    {
        return Err(Failure::Usage(
            "--view reads the input and the output again: name files, not -".to_owned(),
        ));
    }
    own::refuse_beside(&args.own, given, of_one, &["contacts-file", "curves", "view"])
}

fn one(args: &EditArgs, given: &ArgumentSources, job: &MotionJob) -> Result<(), Failure> {
    verify::refuse_streams(job)?;
    let policy = job.policy();
    for file in [&args.contacts, &args.curves].into_iter().flatten() {
        policy.check_ahead(file)?;
    }
    let mut reports: Vec<EditReport> = Vec::new();
    let mut hear = |said: Notice<'_>| match said {
        Notice::Step(step) => {
            if !args.json {
                Voice::Aloud.hear(Notice::Step(step));
            }
            reports.push(step.clone());
        }
        said => Voice::Aloud.hear(said),
    };
    let (maker, mut made) = made::make(job, given, None, &policy, &mut hear)?;
    made::tell(&made.written, &args.own.output, &mut Voice::Aloud);
    let Some(scene) = made.scene.take() else { return Ok(()) };
    let mut besides: Vec<(&Path, Vec<u8>)> = Vec::new();
    let shown = match args.contacts.is_some() || args.curves.is_some() {
        true => shown(&scene, maker.changed_clip(&scene)?),
        false => Cow::Borrowed(&scene),
    };
    if let Some(file) = &args.contacts {
        besides.push((file, contact_bytes(args, &shown, made.humanoid.as_ref(), file)?));
    }
    let curves = match &args.curves {
        Some(file) => {
            let name = shown.animations.first().map(|clip| &clip.name);
            let is_of_shown = |report: &&EditReport| report.clip.is_none() || report.clip.as_ref() == name;
            Some((file, curves(args, &shown, reports.iter().rfind(is_of_shown))?))
        }
        None => None,
    };
    if let Some((file, drawing)) = &curves {
        besides.push((file, drawn(drawing, &extension(file))?));
    }
    let besides = Vec::from_iter(besides.iter().map(|(path, bytes)| (*path, bytes.as_slice())));
    streams::save(&made.written, &args.own.output, &besides, &policy, given.is_dry_run())?;
    if let Some((file, drawing)) = &curves {
        print_report(&PictureReport::of(drawing, file, 0), false, Place::Message)?;
    }
    if args.json {
        print_report(&ReportList(reports), true, Place::Message)?;
    }
    if args.own.verify {
        verify::output(job, Some(scene))?;
    }
    match args.view {
        true => view::before_and_after(&args.before(), &ViewArgs::of_file(args.own.output.clone())),
        false => Ok(()),
    }
}

/// The scene with the clip whose contacts and curves are written as its first clip.
fn shown(scene: &Scene, changed: Option<usize>) -> Cow<'_, Scene> {
    if scene.animations.len() < 2 {
        return Cow::Borrowed(scene);
    }
    let mut shown = scene.clone();
    match changed {
        Some(clip) => shown.keep_animation(clip),
        None => report::clip_taken(&mut shown),
    }
    Cow::Owned(shown)
}

/// The contacts of the changed motion, in the format of `file`.
fn contact_bytes(args: &EditArgs, scene: &Scene, humanoid: Option<&Humanoid>, file: &Path) -> Result<Vec<u8>, Failure> {
    let options = ContactOptions::new().hands(true);
    let found = options.detect(scene, 0, humanoid);
    let found = found.map_err(|error| error.with_path(&args.inputs[0]))?;
    Ok(match extension(file).as_str() {
        "npz" => contacts_npz(&found),
        _ => {
            let text = serde_json::to_string(&found).unwrap_or_default();
            visible_json(&text).into_owned().into_bytes()
        }
    })
}

/// Curves of the changed motion, with the keys of the last step.
fn curves(args: &EditArgs, scene: &Scene, last: Option<&EditReport>) -> Result<Drawing, Failure> {
    let marked_frames = match last.map(|last| &last.changed) {
        Some(StepReport::InBetween(report)) => report.keys.clone(),
        _ => Vec::new(),
    };
    let options = PlotOptions::new().marked_frames(marked_frames);
    let name = short_name(&args.own.output);
    let clip = Clip { name: &name, scene };
    Ok(Drawing::plot(
        &clip,
        &joints_named(scene, &args.joint, &args.inputs[0])?,
        &options,
    ))
}
