//! Runs Assimp and `mocap` on the same files and lists every difference: equal, explained or unexplained.
//!
//! `tools/oracle/compare` builds both programs and calls this program; `README.md` describes the comparison.

#![warn(clippy::unwrap_used)]

mod assimp_json;
mod difference;
mod explain;
mod json;
mod mocap_json;
mod programs;
mod refusals;
mod report;
mod scene;
mod source;
mod table;
#[cfg(test)]
mod tests;
mod text;

use std::ffi::OsString;
use std::fs;
use std::path::Path;
use std::process::ExitCode;

use programs::{Failure, Programs};
use report::Report;
use source::Source;

const LAYOUTS: [&str; 4] = ["2017", "2018", "2019", "2021"];

fn main() -> ExitCode {
    let mut arguments: Vec<OsString> = std::env::args_os().skip(1).collect();
    let mut flag = |name: &str| {
        let count = arguments.len();
        arguments.retain(|argument| argument != name);
        arguments.len() < count
    };
    let (every_difference, every_row) = (flag("--all"), flag("--every-row"));
    let [assimp, mocap, files @ ..] = arguments.as_slice() else {
        eprintln!("usage: oracle ASSIMP_DUMP MOCAP [--all] [--every-row] FILE...");
        return ExitCode::from(2);
    };
    let programs = Programs {
        assimp: assimp.clone(),
        mocap: mocap.clone(),
    };
    let mut total = Report::default();
    for file in files {
        let report = match fs::read(file) {
            Ok(bytes) => compare(&programs, Path::new(file), &Source::new(&bytes)),
            Err(error) => {
                eprintln!("{}: {error}", file.display());
                return ExitCode::from(2);
            }
        };
        print!("{}", report.print(&file.display().to_string(), every_difference));
        total.equal += report.equal;
        total.findings.extend(report.findings);
    }
    println!("{} files: {total}", files.len());
    let idle: Vec<&str> = table::ids().filter(|id| every_row && !total.has(id)).collect();
    if !idle.is_empty() {
        println!("rows of the README that explain nothing here: {}", idle.join(", "));
    }
    if total.unexplained() > 0 || !idle.is_empty() {
        ExitCode::FAILURE
    } else {
        ExitCode::SUCCESS
    }
}

/// Both scenes of the file, as imported and processed, and the text of each in every layout.
fn compare(programs: &Programs, file: &Path, source: &Source) -> Report {
    let mut report = Report::default();
    for processed in [false, true] {
        if let Err(failure) = compare_scenes(&mut report, programs, file, source, processed) {
            report.failure(if processed { "processed" } else { "raw" }, failure);
        }
    }
    report
}

fn compare_scenes(
    report: &mut Report,
    programs: &Programs,
    file: &Path,
    source: &Source,
    processed: bool,
) -> Result<(), Failure> {
    let assimp = programs.assimp_scene(file, processed)?;
    let ours = programs.our_scene(file, processed)?;
    let Some(scenes) = report.answers(source, processed, &assimp, &ours) else {
        return Ok(());
    };
    for layout in LAYOUTS {
        let output = format!("{} text {layout}", if processed { "processed" } else { "raw" });
        let assimp = programs.assimp_text(file, processed, layout)?;
        let ours = programs.our_text(file, processed, layout)?;
        report.texts(&output, &scenes, &assimp, &ours);
    }
    Ok(())
}
