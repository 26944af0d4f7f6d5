//! `mocap verify`: compares a written file with its source.

use std::io::{self, Write};

use mocap::verify::{Verification, verify_files};
use serde::Serialize;

use super::print_json;
use crate::args::VerifyArgs;
use crate::{Failure, report};

/// What `--json` prints.
#[derive(Serialize)]
struct Verdict<'a> {
    source: String,
    output: String,
    ok: bool,
    max_allowed: f64,
    #[serde(flatten)]
    verification: &'a Verification,
}

pub(crate) fn run(args: &VerifyArgs) -> Result<(), Failure> {
    let verification = verify_files(&args.source, &args.output)?;
    let max_allowed = args.tolerance.max_error;
    let ok = is_within(&verification, max_allowed);
    if args.json {
        print_json(&Verdict {
            source: args.source.display().to_string(),
            output: args.output.display().to_string(),
            ok,
            max_allowed,
            verification: &verification,
        })?;
    } else {
        writeln!(io::stdout().lock(), "{}", summary(&verification))?;
    }
    require(&verification, max_allowed)
}

/// NaN is not within the tolerance.
pub(crate) fn is_within(verification: &Verification, max_allowed: f64) -> bool {
    verification.max_error <= max_allowed
}

/// Reports an error above the tolerance.
pub(crate) fn require(verification: &Verification, max_allowed: f64) -> Result<(), Failure> {
    if is_within(verification, max_allowed) {
        return Ok(());
    }
    report::complain(&too_far(verification, max_allowed));
    Err(Failure::Told)
}

pub(crate) fn too_far(verification: &Verification, max_allowed: f64) -> String {
    let (error, allowed) = (millimetres(verification.max_error), millimetres(max_allowed));
    format!("the largest error is {error} mm, more than the {allowed} mm allowed")
}

/// The result in a few lines.
pub(crate) fn summary(verification: &Verification) -> String {
    let mut text = format!(
        "{} frames, {} joints: {} mm at most, {} mm RMS",
        verification.frames,
        verification.joints,
        millimetres(verification.max_error),
        millimetres(verification.rms_error),
    );
    if let Some(worst) = &verification.worst {
        text += &format!(
            "; at most at joint \"{}\", frame {}, {:.3} s",
            worst.joint, worst.frame, worst.seconds
        );
    }
    for (what, names) in [
        ("joints", &verification.missing),
        ("end sites", &verification.missing_end_sites),
    ] {
        if !names.is_empty() {
            text += &format!("\n{what} missing in the file: {}", names.join(", "));
        }
    }
    text
}

pub(crate) fn millimetres(metres: f64) -> String {
    format!("{:.4}", metres * 1000.0)
}
