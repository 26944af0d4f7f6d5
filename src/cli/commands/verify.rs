//! `mocap verify`: compares a written file with its source.

use std::io::Write;

use mocap::Scene;
use mocap::job::MotionJob;
use mocap::verify::Verifier;
use mocap::verify::report::Verification;
use serde::Serialize;

use super::print_json;
use crate::args::VerifyArgs;
use crate::{Failure, report, streams};

/// What `--json` prints.
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
    if args.json {
        print_json(&VerifyReport::new(args, &verification))?;
    } else {
        writeln!(report::words(), "{}", summary(&verification))?;
    }
    require(&verification, args.tolerance.max_error.to_metres())
}

/// What `--json` prints, and whether the file is what its source is.
pub(crate) fn result(args: &VerifyArgs) -> Result<(serde_json::Value, bool), Failure> {
    let verification = verification(args)?;
    let verdict = VerifyReport::new(args, &verification);
    Ok((super::value(&verdict), verdict.ok))
}

fn verification(args: &VerifyArgs) -> mocap::Result<Verification> {
    // Steps are recorded with their weights; how markers were solved is not.
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
    report::say(&summary(&verification));
    require(&verification, job.write.smaller.tolerance())
}

/// Refuses a comparison of what is no file.
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

/// The first thing that is wrong.
pub(crate) fn difference(verification: &Verification, max_allowed: f64) -> String {
    if let Some(finding) = verification.findings.first() {
        return format!("the file is not what its source is: {finding}");
    }
    let largest = f64::max(verification.max_error, verification.rotation_error.unwrap_or(0.0));
    let (error, allowed) = (millimetres(largest), millimetres(max_allowed));
    format!("the largest error is {error} mm, more than the {allowed} mm allowed")
}

/// The result in a few lines.
pub(crate) fn summary(verification: &Verification) -> String {
    let mut text = format!(
        "{}, {}, {}: {} mm at most, {} mm RMS",
        report::counted(verification.frames, "frame"),
        report::counted(verification.joints, "joint"),
        report::counted(verification.end_sites, "end site"),
        millimetres(verification.max_error),
        millimetres(verification.rms_error),
    );
    if let Some(worst) = &verification.worst {
        text += &format!(
            "; at most at joint \"{}\", frame {}, {:.3} s",
            worst.joint, worst.frame, worst.seconds
        );
    }
    if let Some(lost) = &verification.resampling {
        text += &format!(
            "\nthe other frame rate: {} mm at most, {} mm RMS, at the {} frames of the source",
            millimetres(lost.max_error),
            millimetres(lost.rms_error),
            lost.frames,
        );
    }
    // What a conversion did is in the file; else the unit is found from the lengths of the figure.
    if !verification.has_provenance && (verification.metres_per_unit - 1.0).abs() > 1e-9 {
        text += &format!(
            "\nanother unit of length: 1 of the source is {:.6} of the file",
            verification.metres_per_unit
        );
    }
    for finding in &verification.findings {
        text += &format!("\n{finding}");
    }
    if !verification.missing_end_sites.is_empty() {
        let names = verification.missing_end_sites.join(", ");
        text += &format!("\nend sites missing in the file: {names}");
    }
    text
}

pub(crate) fn millimetres(metres: f64) -> String {
    format!("{:.4}", metres * 1000.0)
}
