//! `mocap retarget`: retargets motions to a character.

use std::cmp::Ordering;
use std::fmt;
use std::path::{Path, PathBuf};

use mocap::job::MotionJob;
use mocap::retarget::report::ClipReport;
use mocap::retarget::report::RetargetReport;
use mocap::retarget::report::Verdict;
use serde::Serialize;

use super::{MANY, Place, check_json, extension, looks, made, many, output_format, print_job, print_report};
use crate::args::{ArgumentSources, RetargetArgs};
use crate::{Failure, kinds, report, streams};

pub(crate) fn run(args: &RetargetArgs, given: &ArgumentSources) -> Result<(), Failure> {
    let job = job(args, given)?;
    if args.onto.instead.print_job {
        return print_job(&job);
    }
    if args.is_many() {
        return many::run(&job, given, &args.onto.inputs, &args.onto.spread, args.onto.resume);
    }
    let (maker, made) = made::save(&job, given)?;
    let table = ClipTable {
        reports: made.clips.iter().filter_map(ClipReport::body).collect(),
        clips: &made.clips,
        output: &args.output,
    };
    print_report(&table, args.onto.json, Place::Message)?;
    let clips = table.reports.len();
    let would_be = if given.is_dry_run() { "would be " } else { "" };
    report::say(&format!(
        "{}: {} {would_be}added",
        args.output.display(),
        report::counted(clips, "clip")
    ));
    super::require(&maker, &made.clips)?;
    let failed = made.left_out.len();
    for (file, why) in &made.left_out {
        report::fault(file, why);
    }
    match failed {
        0 => Ok(()),
        _ => {
            report::say(&format!("{failed} of {} motions were skipped", job.source.inputs.len()));
            Err(Failure::Some)
        }
    }
}

/// The job that the arguments describe.
pub(crate) fn job(args: &RetargetArgs, given: &ArgumentSources) -> Result<MotionJob, Failure> {
    let (motions, file) = inputs(args)?;
    if streams::is_standard(&file) {
        let message = "the character cannot come from standard input: name a file, not -";
        return Err(Failure::Usage(message.to_owned()));
    }
    kinds::refuse_robot([file.as_path()])?;
    let to = args.to.as_deref();
    if args.is_many() {
        if args.onto.json {
            let message =
                "--json prints the report of one output; the manifest in the folder has the reports of many outputs";
            return Err(Failure::Usage(message.to_owned()));
        }
        let format = to.map_or_else(|| default_format(args, &file), ToOwned::to_owned);
        return Ok(args.job(&motions, &file, &format));
    }
    given.refuse(
        MANY,
        "all motions are written to one file; -o FOLDER/ writes one file for each motion",
    )?;
    check_json(args.onto.json, &args.output)?;
    let format = output_format(&args.output, to, &default_format(args, &file))?;
    Ok(args.job(&motions, &file, &format))
}

/// With more clips than this, each clip gets only one line.
const MOST_TOLD: usize = 3;

/// The reports of the clips as JSON. As text, few clips print their reports, and more clips print a table.
#[derive(Serialize)]
#[serde(transparent)]
struct ClipTable<'a> {
    reports: Vec<&'a RetargetReport>,
    #[serde(skip)]
    clips: &'a [ClipReport],
    #[serde(skip)]
    output: &'a Path,
}

impl fmt::Display for ClipTable<'_> {
    /// One line for each clip, the worst first, followed by the reasons and the command that shows the clip.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.reports.len() <= MOST_TOLD {
            return self.reports.iter().try_for_each(|report| writeln!(f, "{report}"));
        }
        let mut sorted = Vec::from_iter(self.clips.iter().filter_map(|clip| Some((clip, clip.body()?))));
        let grade = |report: &RetargetReport| match report.verdict {
            Verdict::Poor => 0,
            Verdict::Fair => 1,
            _ => 2,
        };
        sorted.sort_by(|(_, a), (_, b)| {
            (grade(a), b.mean_degrees)
                .partial_cmp(&(grade(b), a.mean_degrees))
                .unwrap_or(Ordering::Equal)
        });
        let lengths = sorted.iter().map(|(_, report)| report.clip.chars().count());
        let width = lengths.max().unwrap_or(0);
        writeln!(
            f,
            "{:width$}  verdict  mean error, degrees   most  slide cm/s  in the source  frames",
            "clip"
        )?;
        for (clip, report) in sorted {
            let slides = report.feet.as_ref().map(|feet| [feet.target.skate, feet.source.skate]);
            let [slide, of_source] = slides.map_or(["-".to_owned(), "-".to_owned()], |slides| {
                slides.map(|metres| format!("{:.1}", 100.0 * metres))
            });
            writeln!(
                f,
                "{:width$}  {:7}  {:>19.2}  {:>5.1}  {slide:>10}  {of_source:>13}  {:>6}",
                report.clip,
                report.verdict.as_str(),
                report.mean_degrees,
                report.max_degrees,
                report.frames
            )?;
            if report.verdict != Verdict::Good {
                writeln!(f, "  {}", clip.reasons().join("; "))?;
                writeln!(f, "  {}", looks::clip(self.output, &report.clip))?;
            }
        }
        writeln!(f, "--json prints the full report of each clip")
    }
}

/// The motions, and the file of the character.
fn inputs(args: &RetargetArgs) -> Result<(Vec<PathBuf>, PathBuf), Failure> {
    if let Some(named) = args.character.as_ref().or(args.to_skeleton.as_ref()) {
        return Ok((args.paths.clone(), named.clone()));
    }
    match args.paths.as_slice() {
        [motions @ .., character] if !motions.is_empty() => Ok((motions.to_vec(), character.clone())),
        _ => Err(Failure::Usage(
            "name a motion, then a character: mocap retarget INPUT TARGET -o OUTPUT".to_owned(),
        )),
    }
}

/// The format of a glTF or VRM character, or GLB for a skeleton.
fn default_format(args: &RetargetArgs, file: &Path) -> String {
    let own = extension(file);
    match own.as_str() {
        "gltf" | "vrm" if args.to_skeleton.is_none() => own,
        _ => "glb".to_owned(),
    }
}
