//! Shared functions of `mocap edit` and `mocap clean`, which change motions and keep their skeletons.

use mocap::job::MotionJob;

use super::{MANY, ONE_OUTPUT, many, output_format, print_job};
use crate::Failure;
use crate::args::{ArgumentSources, OutputFormat, OwnArgs, refuse_options};

/// Prints a job, or runs it with an output folder. A job with one output is returned, and the caller runs it.
pub(super) fn begin(args: &OwnArgs, given: &ArgumentSources, job: MotionJob) -> Result<Option<MotionJob>, Failure> {
    if args.instead.print_job {
        return print_job(&job).map(|()| None);
    }
    if args.is_many() {
        return many::run(&job, given, &args.many, &args.spread, args.resume).map(|()| None);
    }
    Ok(Some(job))
}

/// The job that the arguments describe. `job` makes this job for the extension of the output.
pub(super) fn job(
    args: &OwnArgs,
    given: &ArgumentSources,
    job: impl FnOnce(&str) -> MotionJob,
) -> Result<MotionJob, Failure> {
    let to = args.to.map(|format| format.name);
    let format = match args.is_many() {
        true => to.unwrap_or("glb").to_owned(),
        false => output_format(&args.output, to, "glb")?,
    };
    let job = job(&format);
    if let Some(format) = OutputFormat::named(&format) {
        refuse_options(given, |option| format.refusal(option))?;
    }
    Ok(job)
}

/// Refuses options for one motion if there are many, and options for many if there is one. `beside` are options for
/// further outputs, which are not part of a job.
pub(super) fn refuse_beside(
    args: &OwnArgs,
    given: &ArgumentSources,
    (of_one, why): (&'static [&'static str], &str),
    beside: &'static [&'static str],
) -> Result<(), Failure> {
    match (args.is_many(), args.instead.print_job) {
        (true, _) => given.refuse(of_one, why),
        (false, true) => given.refuse(beside, "it is not part of a job; leave it out"),
        (false, false) => given.refuse(MANY, ONE_OUTPUT),
    }
}
