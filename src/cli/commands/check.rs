//! `mocap check`: reports errors and warnings of files.

use std::fmt;
use std::path::Path;

use mocap::scene::Assumption;
use mocap::{Code, Diagnostic, SkeletonMesh};
use serde::Serialize;

use super::{Place, print_report};
use crate::args::CheckArgs;
use crate::batch::gather::gather;
use crate::batch::inputs::{self, Input};
use crate::batch::progress::{Outcome, Progress};
use crate::batch::{self, InOrder, thread_count};
use crate::report::{self, Severity};
use crate::{Failure, kinds, streams};

/// The report of one file: one line of JSON.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct FileCheck {
    file: String,
    status: Status,
    diagnostics: Vec<CheckFinding>,
    assumptions: Vec<Assumption>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
enum Status {
    Ok,
    Warning,
    Error,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct CheckFinding {
    severity: Severity,
    /// The file with the error, if it is not the checked file: the file with the skeleton of a motion.
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<String>,
    line: Option<usize>,
    column: Option<usize>,
    #[serde(flatten)]
    diagnostic: Diagnostic,
}

pub(crate) fn run(args: &CheckArgs) -> Result<(), Failure> {
    let mut inputs = inputs::find(&args.paths, &args.inputs)?;
    inputs.retain(|input| args.spread.shard.is_none_or(|shard| shard.has(input)));
    let mut progress = Progress::new(args.spread.progress(), &inputs);
    let mut in_order = InOrder::new();
    let print = |index: usize, checked: FileCheck| -> Result<(), Failure> {
        let outcome = match checked.status {
            Status::Error => Outcome::Failed,
            Status::Ok | Status::Warning => Outcome::Done,
        };
        progress.add(&inputs[index], outcome);
        in_order.push(index, checked);
        while let Some(checked) = in_order.pop() {
            if args.json || checked.status != Status::Ok || !report::is_quiet() {
                print_report(&checked, args.json, Place::Row)?;
            }
        }
        Ok(())
    };
    let threads = thread_count(args.spread.threads);
    let panicked = |input: &Input| {
        let error = Diagnostic::new(Code::Io, batch::PANICKED).into();
        checked(args, input, Vec::new(), Some(error), Vec::new())
    };
    batch::for_each(&inputs, threads, |input| check(args, input), panicked, print)?;
    let counts = progress.finish();
    match counts.failed {
        0 => Ok(()),
        failed if failed == counts.files => Err(Failure::Told),
        _ => Err(Failure::Some),
    }
}

/// The output of `--json`, as a list.
pub(crate) fn result(args: &CheckArgs) -> Result<Vec<serde_json::Value>, Failure> {
    let inputs = inputs::find(&args.paths, &args.inputs)?;
    let (found, _) = gather(&args.spread, &inputs, |input| Ok(check(args, input)), |_| Ok(()))?;
    let all = std::iter::zip(&inputs, found).map(|(input, found)| {
        found.unwrap_or_else(|panicked| {
            let error = Diagnostic::new(Code::Io, panicked).into();
            checked(args, input, Vec::new(), Some(error), Vec::new())
        })
    });
    Ok(all.map(|checked| super::value(&checked)).collect())
}

fn check(args: &CheckArgs, input: &Input) -> FileCheck {
    // `--strict` is applied here and not by the importer, so that all warnings are reported.
    let importer = args
        .read
        .importer()
        .strict(false)
        .threads(1)
        .hash(false)
        .skeleton_mesh(SkeletonMesh::None);
    match input.path().and_then(|file| streams::import(&importer, file)) {
        Ok(scene) => {
            let assumptions = mocap::figure::assumptions(&scene);
            checked(args, input, scene.warnings, None, assumptions)
        }
        Err(error) => checked(args, input, error.warnings().to_vec(), Some(error), Vec::new()),
    }
}

/// The findings in a file.
fn checked(
    args: &CheckArgs,
    input: &Input,
    warnings: Vec<Diagnostic>,
    error: Option<mocap::Error>,
    assumptions: Vec<Assumption>,
) -> FileCheck {
    let file = input.path.as_path();
    // A file that lost frames is incomplete.
    let of_warning = |warning: &Diagnostic| match args.read.strict || warning.code.loses_frames() {
        true => Severity::Error,
        false => Severity::Warning,
    };
    let finding = |severity, diagnostic: Diagnostic| CheckFinding {
        severity,
        file: None,
        line: diagnostic.location.as_ref().map(|location| location.line),
        column: diagnostic.location.as_ref().map(|location| location.column),
        diagnostic,
    };
    let of_error = |error: mocap::Error| {
        let other = error.path().filter(|path| *path != file);
        CheckFinding {
            file: other.map(|path| path.display().to_string()),
            ..finding(Severity::Error, kinds::helped(error.path(), error.diagnostic()))
        }
    };
    let warnings = warnings
        .into_iter()
        .map(|warning| finding(of_warning(&warning), warning));
    let diagnostics: Vec<_> = warnings.chain(error.map(of_error)).collect();
    let status = |finding: &CheckFinding| match finding.severity {
        Severity::Error => Status::Error,
        Severity::Warning => Status::Warning,
    };
    FileCheck {
        file: file.display().to_string(),
        status: diagnostics.iter().map(status).max().unwrap_or(Status::Ok),
        diagnostics,
        assumptions,
    }
}

impl fmt::Display for FileCheck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for finding in &self.diagnostics {
            let file = Path::new(finding.file.as_ref().unwrap_or(&self.file));
            writeln!(
                f,
                "{}",
                report::render(finding.severity, Some(file), &finding.diagnostic)
            )?;
        }
        writeln!(f, "{}", report::visible(&self.summary()))
    }
}

impl FileCheck {
    /// `walk.bvh: 1 error, 2 warnings`.
    fn summary(&self) -> String {
        let counts = [(Severity::Error, "error"), (Severity::Warning, "warning")].map(|(severity, noun)| {
            let found = self.diagnostics.iter().filter(|finding| finding.severity == severity);
            match found.count() {
                0 => None,
                count => Some(report::counted(count, noun)),
            }
        });
        let counts: Vec<_> = counts.into_iter().flatten().collect();
        match counts.is_empty() {
            true => format!("{}: ok", self.file),
            false => format!("{}: {}", self.file, counts.join(", ")),
        }
    }
}
