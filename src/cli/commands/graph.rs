//! `mocap graph`: the motion graph of many clips, and walks over it.

use std::path::{Path, PathBuf};

use mocap::edit::WalkReport;
use mocap::job::{Job, JobReport};

use super::{check_json, made, output_format, print_job, print_json, refuse_one_file, unknown_extension};
use crate::args::{Given, GraphArgs, GraphCommand, InputArgs, RunArgs, WalkArgs};
use crate::batch::inputs;
use crate::{Failure, report, streams};

pub(crate) fn run(args: &GraphArgs, given: &Given) -> Result<(), Failure> {
    match &args.command {
        Some(GraphCommand::Walk(args)) => {
            if args.instead.print_job {
                return print_job(&job_of_walk(args)?);
            }
            check_json(args.json, &args.output)?;
            match (walk_over(args, given)?, args.json) {
                (Some(walk), true) => print_json(&walk)?,
                (Some(walk), false) => report::say(&walk.to_string()),
                (None, _) => {}
            }
            Ok(())
        }
        None if args.print_job => print_job(&args.job()),
        None => make(args.job(), &args.inputs).map(|_| ()),
    }
}

/// Compares the inputs of a job, which may be folders and wildcards.
pub(super) fn of_job(job: Job, args: &RunArgs) -> Result<(), Failure> {
    let is_json = args.json;
    check_json(is_json, &job.write.output)?;
    let done = make(job, &args.inputs)?;
    match is_json {
        true => Ok(print_json(&done)?),
        false => Ok(()),
    }
}

/// Writes a graph; what is in it, for an agent.
pub(crate) fn summary(job: Job, inputs: &InputArgs) -> Result<serde_json::Value, Failure> {
    let done = make(job, inputs)?;
    Ok(done.graph.as_ref().map(super::value).unwrap_or_default())
}

/// Writes a walk; what `--json` prints.
pub(crate) fn summary_of_walk(args: &WalkArgs, given: &Given) -> Result<serde_json::Value, Failure> {
    let walk = walk_over(args, given)?;
    Ok(walk.as_ref().map(super::value).unwrap_or_default())
}

/// Writes what is asked for.
fn make(mut job: Job, inputs: &InputArgs) -> Result<JobReport, Failure> {
    let graphing = job.graph.clone().unwrap_or_default();
    let output = &job.write.output;
    if !output.as_os_str().is_empty() && output_format(output, job.write.to.as_deref(), "json")? != "json" {
        return Err(unknown_extension(output, ".json"));
    }
    if let Some(matrix) = graphing.matrix.as_deref()
        && !["png", "npy"].contains(&&*super::extension(matrix))
    {
        return Err(unknown_extension(matrix, ".png or .npy"));
    }
    let found = inputs::find(&job.source.inputs, inputs)?;
    job.source.inputs = found.into_iter().map(|input| input.path).collect();
    let policy = job.policy();
    let outputs = graphing.matrix.iter().chain([&job.write.output]);
    let outputs = outputs.filter(|output| !output.as_os_str().is_empty());
    refuse_one_file(outputs.clone().map(AsRef::as_ref))?;
    for output in outputs {
        if !streams::is_standard(output) {
            policy.check_inputs(output)?;
        }
    }
    let (made, done) = job.compare(streams::given(&job)?).map_err(made::refused)?;
    report::warnings(None, &done.warnings);
    streams::write_all(&made, &policy)?;
    tell(&done, &made, graphing.matrix.as_deref());
    Ok(done)
}

/// Says how large a graph is, and what of its clips is left out.
fn tell(done: &JobReport, made: &[(PathBuf, Vec<u8>)], matrix: Option<&Path>) {
    if let Some(matrix) = matrix {
        report::say(&format!("{}: the distances of all moments", matrix.display()));
    }
    let (Some(graph), Some((output, _))) = (
        &done.graph,
        made.iter().find(|(path, _)| Some(path.as_path()) != matrix),
    ) else {
        return;
    };
    for file in &graph.left_out {
        report::say(&format!("{file}: no part of the graph: nothing leads to it and back"));
    }
    report::say(&format!(
        "{}: {} among {}; {:.1} of {:.1} s stay: from each moment there a walk reaches all others",
        output.display(),
        report::counted(graph.transitions, "transition"),
        report::counted(graph.clips, "clip"),
        graph.kept_seconds,
        graph.seconds
    ));
}

/// The job of a walk.
fn job_of_walk(args: &WalkArgs) -> Result<Job, Failure> {
    let to = args.to.map(|format| format.extension);
    Ok(args.job(&output_format(&args.output, to, "glb")?))
}

fn walk_over(args: &WalkArgs, given: &Given) -> Result<Option<WalkReport>, Failure> {
    let (_, made) = made::save(&job_of_walk(args)?, given)?;
    Ok(made.walk)
}
