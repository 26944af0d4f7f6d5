//! `mocap graph`: builds the motion graph of many clips, and writes motions along paths of the graph (walks).

use std::path::{Path, PathBuf};

use mocap::job::report::JobReport;
use mocap::job::{GraphJob, WalkJob};

use super::{Place, check_json, made, output_format, print_job, print_report, refuse_one_file, unknown_extension};
use crate::args::{ArgumentSources, GraphArgs, GraphCommand, RunArgs, WalkArgs};
use crate::batch::inputs::{self, InputArgs};
use crate::printed::OutputReport;
use crate::{Failure, kinds, report, streams};

pub(crate) fn run(args: &GraphArgs, given: &ArgumentSources) -> Result<(), Failure> {
    match &args.command {
        Some(GraphCommand::Walk(args)) => {
            if args.instead.print_job {
                return print_job(&job_of_walk(args)?);
            }
            check_json(args.json, &args.output)?;
            let walk = made::save_walk(&job_of_walk(args)?, given)?;
            print_report(&walk, args.json, Place::Message)
        }
        None if args.print_job => print_job(&args.job()),
        None => write(args.job(), &args.inputs, args.json),
    }
}

/// Builds the graph of a job. The inputs may be folders and wildcards.
pub(super) fn of_job(job: GraphJob, args: &RunArgs) -> Result<(), Failure> {
    write(job, &args.inputs, args.json)
}

fn write(job: GraphJob, inputs: &InputArgs, is_json: bool) -> Result<(), Failure> {
    check_json(is_json, &job.write.output)?;
    let done = make(job, inputs)?;
    match is_json {
        true => print_report(&done, true, Place::Message),
        false => Ok(()),
    }
}

/// Writes a graph. Returns its contents for an agent.
pub(crate) fn summary(job: GraphJob, inputs: &InputArgs) -> Result<serde_json::Value, Failure> {
    let done = make(job, inputs)?;
    Ok(done.graph.as_ref().map(super::value).unwrap_or_default())
}

/// Writes a walk. Returns the output of `--json`.
pub(crate) fn summary_of_walk(args: &WalkArgs, given: &ArgumentSources) -> Result<serde_json::Value, Failure> {
    Ok(super::value(&made::save_walk(&job_of_walk(args)?, given)?))
}

/// Writes the requested files.
fn make(mut job: GraphJob, inputs: &InputArgs) -> Result<JobReport, Failure> {
    if let Some(output) = job.write.output()
        && output_format(output, job.write.to.as_deref(), "json")? != "json"
    {
        return Err(unknown_extension(output, ".json"));
    }
    if let Some(matrix) = job.matrix.as_deref()
        && !["png", "npy"].contains(&&*super::extension(matrix))
    {
        return Err(unknown_extension(matrix, ".png or .npy"));
    }
    kinds::refuse_robot(job.graph.on.as_deref())?;
    let found = inputs::find(&job.source.inputs, inputs)?;
    job.source.inputs = found.into_iter().map(|input| input.path).collect();
    let policy = job.policy();
    refuse_one_file(job.outputs())?;
    for output in job.outputs() {
        if !streams::is_standard(output) {
            policy.check_ahead(output)?;
        }
    }
    let given = streams::given(&job.read, job.source.inputs.iter())?;
    let (made, done) = job.compare(given).map_err(made::refused)?;
    report::warnings(None, &done.warnings);
    streams::write_all(&made, &policy)?;
    tell(&done, &made, job.matrix.as_deref())?;
    Ok(done)
}

/// Prints the size of a graph, and the dropped parts of its clips.
fn tell(done: &JobReport, made: &[(PathBuf, Vec<u8>)], matrix: Option<&Path>) -> Result<(), Failure> {
    if let Some(matrix) = matrix {
        report::say(&format!("{}: the distance matrix", matrix.display()));
    }
    let (Some(graph), Some((output, _))) = (
        &done.graph,
        made.iter().find(|(path, _)| Some(path.as_path()) != matrix),
    ) else {
        return Ok(());
    };
    for file in &graph.left_out {
        report::say(&format!(
            "{file}: not part of the graph: no transitions lead to it and back"
        ));
    }
    print_report(&OutputReport { output, report: graph }, false, Place::Message)
}

/// The job of a walk.
fn job_of_walk(args: &WalkArgs) -> Result<WalkJob, Failure> {
    kinds::refuse_robot(args.on.as_deref())?;
    let to = args.to.map(|format| format.name);
    Ok(args.job(&output_format(&args.output, to, "glb")?))
}
