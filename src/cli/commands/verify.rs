//! `mocap verify`: compares a written file with its source.

use std::fmt;

use mocap::Scene;
use mocap::job::MotionJob;
use mocap::verify::Verifier;
use mocap::verify::report::Verification;
use serde::Serialize;

use super::{Place, print_report};
use crate::args::VerifyArgs;
use crate::{Failure, report, streams};

/// The output of `--json`.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct VerifyReport<'a> {
    source: String,
    output: String,
    ok: bool,
    max_allowed: f64,
    #[serde(flatten)]
    verification: &'a Verification,
}

impl fmt::Display for VerifyReport<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.verification.fmt(f)
    }
}

impl<'a> VerifyReport<'a> {
    fn new(args: &VerifyArgs, verification: &'a Verification) -> Self {
        let max_allowed = args.tolerance.max_error.to_metres();
        Self {
            source: args.source.display().to_string(),
            output: args.output.display().to_string(),
            ok: verification.is_within(max_allowed),
            max_allowed,
            verification,
        }
    }
}

pub(crate) fn run(args: &VerifyArgs) -> Result<(), Failure> {
    let verification = verification(args)?;
    print_report(&VerifyReport::new(args, &verification), args.json, Place::Result)?;
    require(&verification, args.tolerance.max_error.to_metres())
}

/// The output of `--json`, and whether the file equals its source.
pub(crate) fn result(args: &VerifyArgs) -> Result<(serde_json::Value, bool), Failure> {
    let verification = verification(args)?;
    let verdict = VerifyReport::new(args, &verification);
    Ok((super::value(&verdict), verdict.ok))
}

fn verification(args: &VerifyArgs) -> mocap::Result<Verification> {
    // The file records steps with their weights, but not the weights for solving markers.
    let importer = args.read.importer().marker_weights(args.weights.weights().markers);
    let verifier = Verifier::new()
        .importer(importer)
        .allowing(args.tolerance.max_error.to_metres())
        .second_motions(&args.with);
    verifier.files(&args.source, &args.output)
}

/// Compares the output of a job with the input from which `scene` was made.
pub(crate) fn output(job: &MotionJob, scene: Option<Scene>) -> Result<(), Failure> {
    let verification = job.verify_output(scene, &job.write.output)?;
    print_report(&verification, false, Place::Message)?;
    require(&verification, job.write.smaller.tolerance())
}

/// Refuses to compare inputs or outputs that are not files.
pub(crate) fn refuse_streams(job: &MotionJob) -> Result<(), Failure> {
    let reads = job.source.inputs.iter().any(|input| streams::is_standard(input));
    let message = match (job.verify, streams::is_stream(&job.write.output)) {
        (true, true) => "--verify reads the output again: name a file, not a stream",
        (true, false) if reads => "--verify reads the source again: name a file, not -",
        _ => return Ok(()),
    };
    Err(Failure::Usage(message.to_owned()))
}

/// Reports findings and an error above the tolerance.
pub(crate) fn require(verification: &Verification, max_allowed: f64) -> Result<(), Failure> {
    if verification.is_within(max_allowed) {
        return Ok(());
    }
    report::complain(&difference(verification, max_allowed));
    Err(Failure::Told)
}

/// The first difference between the file and its source, in words.
pub(crate) fn difference(verification: &Verification, max_allowed: f64) -> String {
    if let Some(finding) = verification.findings.first() {
        return format!("the file differs from its source: {finding}");
    }
    let largest = f64::max(verification.max_error, verification.rotation_error.unwrap_or(0.0));
    let (error, allowed) = (millimetres(largest), millimetres(max_allowed));
    format!("the largest error is {error} mm, more than the {allowed} mm allowed")
}

pub(crate) fn millimetres(metres: f64) -> String {
    format!("{:.4}", metres * 1000.0)
}
