//! `mocap retarget`: motions on a character.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

use mocap::job::MotionJob;
use mocap::retarget::report::ClipReport;
use mocap::retarget::report::RetargetReport;
use mocap::retarget::report::Verdict;

use super::{MANY, check_json, extension, looks, made, many, output_format, print_job, print_json};
use crate::args::{Given, RetargetArgs};
use crate::{Failure, kinds, report, streams};

pub(crate) fn run(args: &RetargetArgs, given: &Given) -> Result<(), Failure> {
    let job = job(args, given)?;
    if args.onto.instead.print_job {
        return print_job(&job);
    }
    if args.is_many() {
        return many::run(&job, given, &args.onto.inputs, &args.onto.spread, args.onto.resume);
    }
    let (maker, made) = made::save(&job, given)?;
    let reports: Vec<&RetargetReport> = made.clips.iter().filter_map(ClipReport::body).collect();
    match args.onto.json {
        true => print_json(&reports)?,
        false if reports.len() > MOST_TOLD => tell_all(&made.clips, &args.output),
        false => made.clips.iter().for_each(tell),
    }
    let would_be = if given.is_dry_run() { "would be " } else { "" };
    report::say(&format!(
        "{}: {} {would_be}added",
        args.output.display(),
        report::counted(reports.len(), "clip")
    ));
    super::require(&maker, &made.clips)?;
    let failed = made.left_out.len();
    for (file, why) in &made.left_out {
        report::fault(file, why);
    }
    match failed {
        0 => Ok(()),
        _ => {
            report::say(&format!(
                "{failed} of {} motions were left out",
                job.source.inputs.len()
            ));
            Err(Failure::Some)
        }
    }
}

/// The job that the arguments mean.
pub(crate) fn job(args: &RetargetArgs, given: &Given) -> Result<MotionJob, Failure> {
    let (motions, file) = inputs(args)?;
    if streams::is_standard(&file) {
        let message = "the character cannot come from standard input: name a file, not -";
        return Err(Failure::Usage(message.to_owned()));
    }
    kinds::refuse_robot([file.as_path()])?;
    let to = args.to.as_deref();
    if args.is_many() {
        if args.onto.json {
            let message = "--json prints the report of one output; the manifest in the folder has those of many";
            return Err(Failure::Usage(message.to_owned()));
        }
        let format = to.map_or_else(|| default_format(args, &file), ToOwned::to_owned);
        return Ok(args.job(&motions, &file, &format));
    }
    given.refuse(MANY, "all motions go into one file; -o FOLDER/ makes a file of each")?;
    check_json(args.onto.json, &args.output)?;
    let format = output_format(&args.output, to, &default_format(args, &file))?;
    Ok(args.job(&motions, &file, &format))
}

/// More clips than this are told a line each.
const MOST_TOLD: usize = 3;

/// A line of each clip, the worst first, and below the reasons and the command that shows it.
fn tell_all(reports: &[ClipReport], output: &Path) {
    let mut sorted = Vec::from_iter(reports.iter().filter_map(|found| Some((found, found.body()?))));
    let grade = |found: &RetargetReport| match found.verdict {
        Verdict::Poor => 0,
        Verdict::Fair => 1,
        _ => 2,
    };
    sorted.sort_by(|(_, a), (_, b)| {
        (grade(a), b.mean_degrees)
            .partial_cmp(&(grade(b), a.mean_degrees))
            .unwrap_or(Ordering::Equal)
    });
    let width = sorted
        .iter()
        .map(|(_, found)| found.clip.chars().count())
        .max()
        .unwrap_or(0);
    report::say(&format!(
        "{:width$}  verdict  degrees off, mean   most  slide cm/s  in the source  frames",
        "clip"
    ));
    for (report, found) in sorted {
        let slides = found.feet.as_ref().map(|feet| [feet.target.skate, feet.source.skate]);
        let [slide, of_source] = slides.map_or(["-".to_owned(), "-".to_owned()], |slides| {
            slides.map(|metres| format!("{:.1}", 100.0 * metres))
        });
        report::say(&format!(
            "{:width$}  {:7}  {:>17.2}  {:>5.1}  {slide:>10}  {of_source:>13}  {:>6}",
            found.clip,
            found.verdict.as_str(),
            found.mean_degrees,
            found.max_degrees,
            found.frames
        ));
        if found.verdict != Verdict::Good {
            report::say(&format!("  {}", report.reasons().join("; ")));
            report::say(&format!("  {}", looks::clip(output, &found.clip)));
        }
    }
    report::say("--json has all that is known of each clip");
}

/// The motions, and the file of the character.
fn inputs(args: &RetargetArgs) -> Result<(Vec<PathBuf>, PathBuf), Failure> {
    if let Some(named) = args.character.as_ref().or(args.to_skeleton.as_ref()) {
        return Ok((args.paths.clone(), named.clone()));
    }
    match args.paths.as_slice() {
        [motions @ .., character] if !motions.is_empty() => Ok((motions.to_vec(), character.clone())),
        _ => Err(Failure::Usage(
            "name a motion and after it a character: mocap retarget INPUT TARGET -o OUTPUT".to_owned(),
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

pub(super) fn tell(report: &ClipReport) {
    let Some(found) = report.body() else { return };
    let what = if found.by_names.is_some() { "bones" } else { "limbs" };
    report::say(&format!(
        "{}: {what} {:.2} degrees off in the mean, {:.2} at most, in {} frames: {}; path scaled by {:.3}",
        found.clip,
        found.mean_degrees,
        found.max_degrees,
        found.frames,
        found.verdict.as_str(),
        found.scale
    ));
    if found.verdict != Verdict::Good {
        let (verdict, reasons) = (found.verdict.as_str(), report.reasons().join("; "));
        report::say(&format!("{}: {verdict} because {reasons}", found.clip));
    }
    for limb in found.limbs.iter().filter(|limb| limb.mean_degrees > 1.0) {
        report::say(&format!(
            "{}: {} {:.1} degrees off in the mean, {:.1} at tick {}",
            found.clip,
            limb.bone.as_str(),
            limb.mean_degrees,
            limb.max_degrees,
            limb.tick
        ));
    }
    if let Some(names) = &found.by_names {
        let lacking = match names.lacking.as_slice() {
            [] => String::new(),
            lacking => format!("; the target lacks {}", lacking.join(", ")),
        };
        report::say(&format!(
            "{}: both are {}, and {} joints go by their names{lacking}",
            found.clip, names.creature, names.joints
        ));
    }
    for seen in found.seen.iter().filter(|seen| seen.mean_degrees > 15.0) {
        report::say(&format!(
            "{}: {seen} {:.0} degrees off in the mean, {:.0} at tick {}",
            found.clip, seen.mean_degrees, seen.max_degrees, seen.tick
        ));
    }
    for guess in &found.guessed {
        report::say(&format!(
            "{}: {} is guessed: {}",
            found.clip,
            guess.bone.as_str(),
            guess.reason
        ));
    }
    if let Some(feet) = &found.feet {
        let centimetres = |metres: f64| 100.0 * metres;
        report::say(&format!(
            "{}: feet on the ground slide {:.1} cm/s, {:.1} in the source; {:.1} % of frames are more than 1 cm below the floor, {:.1} % in the source",
            found.clip,
            centimetres(feet.target.skate),
            centimetres(feet.source.skate),
            100.0 * feet.target.fraction_below_floor,
            100.0 * feet.source.fraction_below_floor
        ));
    }
    if let Some(lock) = &found.lock {
        let given_way = match lock.given_way.iter().sum::<usize>() {
            0 => String::new(),
            frames => format!(", for which they give way in {frames} frames"),
        };
        report::say(&format!(
            "{}: locked feet are at most {:.2} times as fast and {:.2} times as much accelerated as free ones{given_way}",
            found.clip, lock.speed_ratio, lock.acceleration_ratio
        ));
    }
    for clamped in &found.clamped {
        report::say(&format!(
            "{}: {} is up to {:.1} cm away in {} frames: {}",
            found.clip,
            clamped.bone.as_str(),
            100.0 * clamped.largest,
            clamped.frames,
            clamped.reason
        ));
    }
    let reasons: Vec<&str> = found.unmapped.iter().map(|lack| lack.reason.as_str()).collect();
    let mut kinds = reasons.clone();
    kinds.sort_unstable();
    kinds.dedup();
    for reason in kinds {
        let bones = found.unmapped.iter().filter(|lack| lack.reason == reason);
        let (fingers, others): (Vec<_>, Vec<_>) = bones.map(|lack| lack.bone).partition(|bone| bone.is_finger());
        let mut bones: Vec<String> = others.iter().map(|bone| bone.as_str().to_owned()).collect();
        if !fingers.is_empty() {
            bones.push(format!("{} bones of fingers", fingers.len()));
        }
        report::say(&format!("{}: {}: {reason}", found.clip, bones.join(", ")));
    }
}
