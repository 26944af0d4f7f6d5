//! `mocap clean`: cleans motion from video estimators, sensors and generators.

use std::path::PathBuf;

use mocap::edit::report::EditReport;
use mocap::job::{MotionJob, Notice};
use mocap::report::indented_json;
use mocap::visible_json;

use super::{extension, made, own, refuse_one_file, unknown_extension, verify};
use crate::args::{ArgumentSources, CleanArgs};
use crate::report::Voice;
use crate::{Failure, streams};

pub(crate) fn run(args: &CleanArgs, given: &ArgumentSources) -> Result<(), Failure> {
    let job = job(args, given)?;
    if args.json && !args.own.instead.print_job {
        return super::run::printed(job, given);
    }
    let Some(job) = own::begin(&args.own, given, job)? else {
        return Ok(());
    };
    verify::refuse_streams(&job)?;
    let policy = job.policy();
    let mut reports: Vec<EditReport> = Vec::new();
    let mut hear = |said: Notice<'_>| {
        if let Notice::Step(step) = said {
            reports.push(step.clone());
        }
        Voice::Aloud.hear(said);
    };
    let (_, mut made) = made::make(&job, given, None, &policy, &mut hear)?;
    made::tell(&made.written, &args.own.output, &mut Voice::Aloud);
    let report = args.report.as_deref().map(|file| {
        let text = match reports.as_slice() {
            [report] => indented_json(report),
            // A file with several clips has a report of each.
            reports => indented_json(reports),
        };
        let text = text.unwrap_or_default();
        (file, format!("{}\n", visible_json(&text)).into_bytes())
    });
    let report = report.as_ref().map(|(file, bytes)| (*file, bytes.as_slice()));
    streams::save(
        &made.written,
        &args.own.output,
        report.as_slice(),
        &policy,
        given.is_dry_run(),
    )?;
    match args.own.verify {
        true => verify::output(&job, made.scene.take()),
        false => Ok(()),
    }
}

/// The job that the arguments describe.
pub(crate) fn job(args: &CleanArgs, given: &ArgumentSources) -> Result<MotionJob, Failure> {
    check(args, given)?;
    own::job(&args.own, given, |extension| args.job(extension))
}

/// Refuses combinations of options that exclude each other.
fn check(args: &CleanArgs, given: &ArgumentSources) -> Result<(), Failure> {
    if let Some(file) = &args.report
        && extension(file) != "json"
    {
        return Err(unknown_extension(file, ".json"));
    }
    refuse_one_file(
        [Some(&args.own.output), args.report.as_ref()]
            .into_iter()
            .flatten()
            .map(PathBuf::as_path),
    )?;
    if !args.own.is_many() && args.inputs.len() > 1 {
        let message = format!("{} motions cannot go into one file; name a folder", args.inputs.len());
        return Err(Failure::Usage(message));
    }
    let of_one = (
        ["report"].as_slice(),
        "the manifest in the folder has the report of each motion",
    );
    own::refuse_beside(&args.own, given, of_one, &["report"])
}
