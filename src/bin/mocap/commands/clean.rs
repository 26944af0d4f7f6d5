//! `mocap clean`: cleans motions that cameras and generators made.

use std::path::Path;

use mocap::edit::EditReport;
use mocap::job::Said;

use super::{MANY, ONE_OUTPUT, extension, made, many, output_format, run, unknown_extension, verify, write_output};
use crate::args::{CleanArgs, Given, OutputFormat, refuse_options};
use crate::report::Voice;
use crate::{Failure, streams};

pub(crate) fn run(args: &CleanArgs, given: &Given) -> Result<(), Failure> {
    check(args, given)?;
    let to = args.to.map(|format| format.extension);
    let format = match args.is_many() {
        true => to.unwrap_or("glb").to_owned(),
        false => output_format(&args.output, to, "glb")?,
    };
    let job = args.job(&format);
    if let Some(format) = OutputFormat::of(&Path::new("scene").with_extension(&format)) {
        refuse_options(given, |option| format.row().refusal(option, format.extension))?;
    }
    if args.print.print_job {
        return run::print(&job);
    }
    if args.is_many() {
        return many::run(&job, given, &args.many, &args.spread, args.resume);
    }
    verify::refuse_streams(&job)?;
    let policy = job.policy();
    let mut reports: Vec<EditReport> = Vec::new();
    let mut hear = |said: Said<'_>| {
        if let Said::Step(step) = said {
            reports.push(step.clone());
        }
        Voice::Aloud.hear(said);
    };
    let (_, mut made) = made::make(&job, given, None, &policy, &mut hear)?;
    made::tell(&made.written, &args.output, &mut Voice::Aloud);
    if let Some(file) = &args.report {
        policy.check_inputs(file)?;
    }
    streams::save(&mut made.written, &args.output, &policy)?;
    if let (Some(file), Some(report)) = (&args.report, reports.last()) {
        let mut bytes = serde_json::to_vec_pretty(report).unwrap_or_default();
        bytes.push(b'\n');
        write_output(&policy, file, &bytes)?;
    }
    match args.verify {
        true => verify::output(&job, made.scene.take()),
        false => Ok(()),
    }
}

/// Refuses what does not go together.
fn check(args: &CleanArgs, given: &Given) -> Result<(), Failure> {
    if let Some(file) = &args.report
        && extension(file) != "json"
    {
        return Err(unknown_extension(file, ".json"));
    }
    if !args.is_many() && args.inputs.len() > 1 {
        let message = format!("{} motions cannot go into one file; name a folder", args.inputs.len());
        return Err(Failure::Usage(message));
    }
    match (args.is_many(), args.print.print_job) {
        (true, _) => given.refuse(&["report"], "the manifest in the folder has the report of each motion"),
        (false, true) => given.refuse(&["report"], "it is no part of a job; leave it out"),
        (false, false) => given.refuse(MANY, ONE_OUTPUT),
    }
}
