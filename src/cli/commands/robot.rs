//! `mocap robot`: retargets motions to robots.

use mocap::FormatInfo;
use mocap::job::{MotionJob, RobotFormat};
use mocap::retarget::report::ClipReport;

use super::{
    MANY, ONE_OUTPUT, Place, check_json, extension, made, many, print_job, print_report, robot_reports,
    unknown_extension,
};
use crate::args::{ArgumentSources, RobotArgs};
use crate::{Failure, report, streams};

pub(crate) fn run(args: &RobotArgs, given: &ArgumentSources) -> Result<(), Failure> {
    if args.robot.len() > 1 && !args.onto.instead.print_job {
        return on_several(args, given);
    }
    let job = job(args, given)?;
    if args.onto.instead.print_job {
        return print_job(&job);
    }
    match args.is_many() {
        true => run_many(args, given, &job),
        false => one(args, given, &job),
    }
}

/// Retargets to several robots, each with a folder of its name. If a motion fails on one robot, the others continue.
fn on_several(args: &RobotArgs, given: &ArgumentSources) -> Result<(), Failure> {
    let robots = args.of_each_robot();
    let jobs = robots
        .iter()
        .map(|args| job(args, given))
        .collect::<Result<Vec<_>, _>>()?;
    for (index, one) in robots.iter().enumerate() {
        if robots[..index].iter().any(|other| other.output == one.output) {
            let (robot, folder) = (one.robot[0].display(), one.output.display());
            let message = format!("{robot}: two robots would use the folder {folder}: rename one of the files");
            return Err(Failure::Usage(message));
        }
    }
    let mut done = Ok(());
    for (args, job) in robots.iter().zip(&jobs) {
        report::say(&format!("{}:", args.robot[0].display()));
        match run_many(args, given, job) {
            Ok(()) => {}
            Err(failure @ (Failure::Told | Failure::Some)) => done = Err(failure),
            Err(failure) => return Err(failure),
        }
    }
    done
}

/// The job that the arguments describe.
pub(crate) fn job(args: &RobotArgs, given: &ArgumentSources) -> Result<MotionJob, Failure> {
    if args.robot.len() > 1 {
        return Err(Failure::Usage(
            "a job has one robot: name one robot with --robot".to_owned(),
        ));
    }
    let options_are_sound = args.job("npz").source.frames.conversion().check();
    options_are_sound.map_err(|error| Failure::Usage(error.diagnostic().message.clone()))?;
    match args.is_many() {
        true => job_of_many(args),
        false => {
            given.refuse(&["report"], ONE_OUTPUT)?;
            given.refuse(MANY, ONE_OUTPUT)?;
            check_json(args.onto.json, &args.output)?;
            Ok(args.job(&format(args)?))
        }
    }
}

fn job_of_many(args: &RobotArgs) -> Result<MotionJob, Failure> {
    let folder = args.output.as_path();
    if args.onto.json {
        let message =
            "--json prints the report of one motion; the manifest in the folder has the reports of many motions";
        return Err(Failure::Usage(message.to_owned()));
    }
    if named(&extension(folder)).is_some() && !folder.is_dir() {
        let message = "several motions need an output folder, but this is a file name: name a folder";
        return Err(Failure::Usage(format!("{}: {message}", folder.display())));
    }
    Ok(args.job(args.to.as_deref().unwrap_or("npz")))
}

fn run_many(args: &RobotArgs, given: &ArgumentSources, job: &MotionJob) -> Result<(), Failure> {
    let many = many::MotionBatch {
        job,
        given,
        inputs: &args.onto.inputs,
        spread: &args.onto.spread,
        resume: args.onto.resume,
        report: args.report.as_deref().map(|path| robot_reports::Table::new(path, args)),
    };
    many.run()
}

fn one(args: &RobotArgs, given: &ArgumentSources, job: &MotionJob) -> Result<(), Failure> {
    let (maker, made) = made::save(job, given)?;
    let found = made.clips.iter().filter_map(ClipReport::robot);
    for found in found {
        print_report(found, args.onto.json, Place::Message)?;
        let (input, output) = (&job.source.inputs[0], &args.output);
        if !streams::is_standard(output) && !given.is_dry_run() {
            report::say(&format!(
                "{} -> {}: {} frames, {} bytes",
                input.display(),
                output.display(),
                found.frames,
                made.written.len()
            ));
        }
    }
    super::require(&maker, &made.clips)
}

/// The format of an output by its name.
fn named(extension: &str) -> Option<&'static str> {
    let format = RobotFormat::named(extension).map(RobotFormat::extension);
    let written = FormatInfo::of_output(&std::path::Path::new("scene").with_extension(extension));
    let written = written.and_then(|row| row.extensions.iter().find(|own| **own == extension));
    format.or(written.copied())
}

/// The format of a single output.
fn format(args: &RobotArgs) -> Result<String, Failure> {
    let own = extension(&args.output);
    match (&args.to, named(&own)) {
        (Some(to), Some(_)) => match named(to) {
            Some(wanted) if wanted != own => Err(unknown_extension(&args.output, &format!(".{wanted}"))),
            _ => Ok(to.clone()),
        },
        (Some(to), None) => Ok(to.clone()),
        (None, Some(named)) => Ok(named.to_owned()),
        (None, None) if streams::is_unnamed(&args.output) => Ok("npz".to_owned()),
        (None, None) => {
            let known = format!(".npz, .pkl, .csv, {}", FormatInfo::written_extensions());
            Err(unknown_extension(&args.output, &known))
        }
    }
}
