//! `mocap run`: runs the job of a JSON file.

use std::fs;
use std::io::{self, Read, Write};
use std::path::Path;

use mocap::files::ReplacePolicy;
use mocap::job::report::JobReport;
use mocap::job::{Job, MotionJob};

use super::{MANY, Place, TO_OF_FILE, many, print_report};
use crate::args::{ArgumentSources, RunArgs};
use crate::{Failure, kinds, report, streams};

pub(crate) fn run(args: &RunArgs, given: &ArgumentSources) -> Result<(), Failure> {
    if args.schema {
        return Ok(report::json().write_all(Job::schema().as_bytes())?);
    }
    let file = args.job.as_deref().unwrap_or(Path::new("-"));
    let mut job = Job::from_json(&text(file)?).map_err(|error| kinds::no_job(error, file).with_path(file))?;
    state_output(&mut job, args, given)?;
    match job {
        Job::Survey(job) => {
            given.refuse(
                &["dry-run"],
                "it is only for jobs that write motions, and this job makes a survey",
            )?;
            super::survey::of_job(&job, args)
        }
        Job::Graph(job) => {
            given.refuse(
                &["dry-run"],
                "it is only for jobs that write motions, and this job makes a graph",
            )?;
            super::graph::of_job(job, args)
        }
        Job::Motion(job) if job.write.is_folder() => {
            given.refuse(&["json"], "see the manifest in the folder")?;
            many::run(&job, given, &args.inputs, &args.spread, args.resume)
        }
        job => one(&job, file, args, given),
    }
}

/// Applies the arguments that override the job.
fn state_output(job: &mut Job, args: &RunArgs, given: &ArgumentSources) -> Result<(), Failure> {
    let is_folder = matches!(job, Job::Motion(job) if job.write.is_folder());
    if !is_folder && !streams::is_standard(job.output()) {
        given.refuse(&["to"], TO_OF_FILE)?;
    }
    let (to, force) = job.to_and_force();
    *force |= args.force.force;
    if args.to.is_some() {
        to.clone_from(&args.to);
    }
    Ok(())
}

/// Runs a job with one output.
fn one(job: &Job, file: &Path, args: &RunArgs, given: &ArgumentSources) -> Result<(), Failure> {
    given.refuse(MANY, "the output of the job is one file; name a folder in write.output")?;
    let output = job.output();
    if !streams::is_standard(output) {
        ReplacePolicy::new([file]).check_inputs(output)?;
    }
    if streams::is_standard(file) && job.motions().any(|motion| streams::is_standard(motion)) {
        let message = "the job and a motion cannot both come from standard input: name the file of one";
        return Err(Failure::Usage(message.to_owned()));
    }
    super::check_json(args.json, output)?;
    let found = done(job, given)?;
    match args.json {
        true => print_report(&found, true, Place::Message)?,
        false => tell(job, &found, given.is_dry_run())?,
    }
    match &found.problem {
        Some(problem) => {
            report::complain(problem);
            Err(Failure::Told)
        }
        None => Ok(()),
    }
}

/// Runs a job with one output, without printing.
fn done(job: &Job, given: &ArgumentSources) -> Result<JobReport, Failure> {
    let output = job.output();
    let motions = streams::given(job.read(), job.motions())?;
    Ok(match streams::is_standard(output) {
        _ if given.is_dry_run() => {
            let (written, report) = job.make(motions)?;
            streams::save(&written, output, &[], &job.policy(), given.is_dry_run())?;
            report
        }
        true => {
            let (written, report) = job.make(motions)?;
            streams::write(output, &written.into_bytes()?)?;
            report
        }
        false => job.run_with(motions)?,
    })
}

/// Runs the job of a command with `--json`, and prints the report.
pub(super) fn printed(job: MotionJob, given: &ArgumentSources) -> Result<(), Failure> {
    if job.write.is_folder() {
        given.refuse(&["json"], "see the manifest in the folder")?;
    }
    super::check_json(true, &job.write.output)?;
    let found = done(&Job::Motion(job), given)?;
    print_report(&found, true, Place::Message)?;
    match &found.problem {
        Some(problem) => {
            report::complain(problem);
            Err(Failure::Told)
        }
        None => Ok(()),
    }
}

/// Runs a job with many motions.
pub(crate) fn many(job: &MotionJob, args: &RunArgs) -> Result<(), Failure> {
    many::run(
        job,
        &ArgumentSources::default(),
        &args.inputs,
        &args.spread,
        args.resume,
    )
}

fn text(file: &Path) -> Result<String, Failure> {
    let mut text = String::new();
    let read = match streams::is_standard(file) {
        true => io::stdin().read_to_string(&mut text).map(|_| text),
        false => fs::read_to_string(file),
    };
    read.map_err(|error| Failure::Folder(file.to_owned(), error))
}

fn tell(job: &Job, found: &JobReport, is_dry: bool) -> Result<(), Failure> {
    report::warnings(None, &found.warnings);
    print_report(found, false, Place::Message)?;
    if is_dry {
        return Ok(());
    }
    let bytes: usize = found.files.iter().map(|file| file.bytes).sum();
    report::say(&format!("{}: {bytes} bytes", job.output().display()));
    Ok(())
}
