//! `mocap run`: does the job of a JSON file.

use std::fs;
use std::io::{self, Read, Write};
use std::path::Path;

use mocap::job::{Job, JobReport};

use super::print_json;
use crate::args::RunArgs;
use crate::{Failure, report, streams};

pub(crate) fn run(args: &RunArgs) -> Result<(), Failure> {
    if args.schema {
        return Ok(report::stdout().write_all(Job::SCHEMA.as_bytes())?);
    }
    let file = args.job.as_deref().unwrap_or(Path::new("-"));
    let job = Job::from_json(&text(file)?).map_err(|error| error.with_path(file))?;
    let found = job.run()?;
    match args.json {
        true => print_json(&found)?,
        false => tell(&job, &found),
    }
    match &found.problem {
        Some(problem) => {
            report::complain(problem);
            Err(Failure::Told)
        }
        None => Ok(()),
    }
}

/// Prints a job, which is then not done.
pub(super) fn print(job: &Job) -> Result<(), Failure> {
    Ok(writeln!(report::stdout(), "{}", job.to_json())?)
}

fn text(file: &Path) -> Result<String, Failure> {
    let mut text = String::new();
    let read = match streams::is_standard(file) {
        true => io::stdin().read_to_string(&mut text).map(|_| text),
        false => fs::read_to_string(file),
    };
    read.map_err(|error| Failure::Folder(file.to_owned(), error))
}

fn tell(job: &Job, found: &JobReport) {
    report::warnings(None, &found.warnings);
    for note in &found.notes {
        report::say(note);
    }
    for step in &found.steps {
        report::say(&step.to_string());
    }
    for clip in &found.clips {
        report::say(&format!(
            "{}: {}: limbs {:.2} degrees off in the mean",
            clip.name(),
            clip.verdict().as_str(),
            clip.mean_degrees()
        ));
    }
    if let Some(verification) = &found.verification {
        report::say(&super::verify::summary(verification));
    }
    let bytes: usize = found.files.iter().map(|file| file.bytes).sum();
    report::say(&format!("{}: {bytes} bytes", job.write.output.display()));
}
