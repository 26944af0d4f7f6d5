//! Shortens long reports for an answer. The client can read the whole report as a resource.

use std::cmp::Reverse;
use std::fs;
use std::path::Path;

use mocap::job::Job;
use mocap::job::report::JobReport;
use mocap::retarget::report::ClipReport;
use mocap::retarget::report::Verdict;
use mocap::retarget::report::{LimbError, RetargetReport};
use mocap::survey::Corpus;
use mocap::survey::report::{ClipRow, Quality};
use serde_json::{Value, json};

use super::answer::Answer;
use crate::batch::manifest::{Manifest, Record};

/// The most clips, motions or files in an answer.
const MOST: usize = 50;

/// The most warnings for one of many motions in an answer.
const MOST_WARNINGS: usize = 3;

pub(super) fn value(found: &impl serde::Serialize) -> Value {
    serde_json::to_value(found).unwrap_or_default()
}

/// The answer for a finished job.
pub(super) fn done(job: &Job, found: &JobReport, is_dry: bool) -> Answer {
    let mut report = value(found);
    // Rename the error of the compression: in every other report, `error` is the reason of a failure.
    let compression = report.as_object_mut().and_then(|report| report.remove("error"));
    report["compression"] = compression.unwrap_or_default();
    report["output"] = job.output().display().to_string().into();
    report["dry_run"] = is_dry.into();
    let mut brief = json!({
        "notes": found.notes.iter().take(MOST).collect::<Vec<_>>(),
        "warnings": found.warnings.iter().take(MOST).map(ToString::to_string).collect::<Vec<_>>(),
        "steps": found.steps.iter().take(MOST).map(ToString::to_string).collect::<Vec<_>>(),
        "clips": sorted(found.clips.iter().map(clip)),
        "verification": found.verification.as_ref().map(|found| {
            json!({
                "frames": found.frames,
                "joints": found.joints,
                "end_sites": found.end_sites,
                "max_error": found.max_error,
                "rms_error": found.rms_error,
            })
        }),
    });
    for key in ["output", "dry_run", "files", "compression", "walk", "problem"] {
        brief[key] = report[key].clone();
    }
    let mut answer = Answer::new(report);
    answer.is_error = found.problem.is_some();
    answer.brief = Some(brief);
    answer
}

/// The answer for a folder: the result for each motion from the manifest, the worst first.
pub(super) fn folder(folder: &Path) -> Answer {
    let text = fs::read_to_string(Manifest::path(folder, None)).unwrap_or_default();
    let lines = text
        .lines()
        .filter_map(|line| serde_json::from_str::<Record>(line).ok());
    let records: Vec<Record> = lines.collect();
    let motions: Vec<Value> = records.iter().map(motion).collect();
    let counted = |verdict: &str| motions.iter().filter(|motion| motion["verdict"] == verdict).count();
    let verdicts = counts(
        [Verdict::Good, Verdict::Fair, Verdict::Poor].map(Verdict::as_str),
        counted,
    );
    let failed: Vec<&Record> = records.iter().filter(|record| record.error.is_some()).collect();
    // The error begins with the path of the file.
    let problem = failed.first().map(|first| {
        let error = first.error.as_deref().unwrap_or(&first.input);
        format!(
            "{} of {} motions failed; the first: {error}",
            failed.len(),
            records.len()
        )
    });
    let is_judged = motions.iter().any(|motion| motion.get("verdict").is_some());
    let brief = json!({
        "output": folder.display().to_string(),
        "dry_run": false,
        "count": motions.len(),
        "failed": failed.len(),
        "verdicts": is_judged.then_some(verdicts),
        "motions": sorted(motions.into_iter()),
    });
    let mut report = brief.clone();
    report["motions"] = value(&records);
    let mut answer = Answer::new(report);
    answer.brief = Some(brief);
    if let Some(problem) = problem {
        answer.add_problem(&problem);
    }
    answer
}

/// The row of one motion of a folder. If the motion has several clips, the row has the worst clip.
fn motion(record: &Record) -> Value {
    let robot = record.robot_report().map(ClipReport::Robot);
    let read = |text: &serde_json::value::RawValue| serde_json::from_str::<Vec<RetargetReport>>(text.get()).ok();
    let bodies = record.retarget.as_deref().and_then(read).unwrap_or_default();
    let reports = bodies.into_iter().map(ClipReport::Body).chain(robot);
    let mut worst = sorted(reports.map(|report| clip(&report))).into_iter().next();
    let mut motion = worst.take().unwrap_or_else(|| json!({}));
    motion["input"] = record.input.as_str().into();
    let others = [
        ("output", value(&record.output)),
        ("error", value(&record.error)),
        ("max_error", value(&record.max_error)),
    ];
    for (key, found) in others.into_iter().filter(|(_, found)| !found.is_null()) {
        motion[key] = found;
    }
    if !record.warnings.is_empty() {
        let first: Vec<&String> = record.warnings.iter().take(MOST_WARNINGS).collect();
        motion["warnings"] = json!(first);
    }
    motion
}

/// The entry of an answer for one retargeted clip, with its quality.
fn clip(report: &ClipReport) -> Value {
    let limbs = report.body().map(|report| &report.limbs);
    let limbs = limbs
        .or(report.robot().map(|report| &report.limbs))
        .into_iter()
        .flatten();
    let worst = |a: &&LimbError, b: &&LimbError| a.mean_degrees.total_cmp(&b.mean_degrees);
    let worst = limbs.max_by(worst).map(|limb| {
        json!({
            "bone": limb.bone.as_str(),
            "mean_degrees": rounded(limb.mean_degrees),
            "max_degrees": rounded(limb.max_degrees),
        })
    });
    let mut clip = json!({
        "clip": report.name(),
        "verdict": report.verdict().as_str(),
        "mean_degrees": rounded(report.mean_degrees()),
    });
    if let Some(worst) = worst {
        clip["worst_limb"] = worst;
    }
    if report.verdict() != Verdict::Good {
        clip["reasons"] = report.reasons().into();
    }
    clip
}

/// Two decimals are enough for an angle.
fn rounded(degrees: f64) -> f64 {
    (100.0 * degrees).round() / 100.0
}

/// The rows of an answer, the worst first: failures, then by verdict and angle.
fn sorted(rows: impl Iterator<Item = Value>) -> Vec<Value> {
    let mut rows: Vec<Value> = rows.collect();
    let grade = |row: &Value| match (row.get("error"), row["verdict"].as_str()) {
        (Some(_), _) => 3,
        (_, Some("poor")) => 2,
        (_, Some("fair")) => 1,
        _ => 0,
    };
    rows.sort_by(|a, b| {
        let degrees = |row: &Value| row["mean_degrees"].as_f64().unwrap_or_default();
        let by_angle = || degrees(b).total_cmp(&degrees(a));
        grade(b).cmp(&grade(a)).then_with(by_angle)
    });
    rows.truncate(MOST);
    rows
}

/// The answer for a survey: its clips, the best first, with the columns that guide a choice. The report has every
/// column.
pub(super) fn surveyed(corpus: &Corpus) -> Answer {
    let mut rows: Vec<&ClipRow> = corpus.rows().collect();
    // Characters and robots have neither defects nor a motion to choose.
    rows.sort_by(|a, b| {
        (a.frames == 0, a.verdict, b.quality)
            .partial_cmp(&(b.frames == 0, b.verdict, a.quality))
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    let brief = |row: &&ClipRow| {
        json!({
            "file": row.file.strip_prefix("./").unwrap_or(&row.file),
            "clip": row.clip,
            "verdict": row.verdict.as_str(),
            "quality": row.quality,
            "reasons": row.reasons,
            "error": row.error,
            "seconds": row.seconds,
            "frames": row.frames,
            "distance": row.distance,
            "walking": row.walking,
            "running": row.running,
            "standing": row.standing,
            "twin_of": row.twin_of,
        })
    };
    let counted = |verdict: &str| rows.iter().filter(|row| row.verdict.as_str() == verdict).count();
    let verdicts = counts(Quality::ALL.iter().map(|verdict| verdict.as_str()), counted);
    let clips: Vec<Value> = rows.iter().take(MOST).map(brief).collect();
    let shown = json!({"count": rows.len(), "verdicts": verdicts, "clips": clips});
    let mut answer = Answer::new(json!({"count": rows.len(), "verdicts": verdicts, "clips": value(&rows)}));
    answer.brief = Some(shown);
    answer
}

/// An object with a count for each name.
fn counts<'a>(names: impl IntoIterator<Item = &'a str>, count: impl Fn(&str) -> usize) -> Value {
    let mut counts = json!({});
    for name in names {
        counts[name] = count(name).into();
    }
    counts
}

/// The answer with the findings in files: files with errors first, then files with warnings.
pub(super) fn checked(mut files: Vec<Value>) -> Answer {
    const STATUSES: [&str; 3] = ["error", "warning", "ok"];
    let has = |file: &Value, status: &str| file["status"] == status;
    let statuses = counts(STATUSES, |status| files.iter().filter(|file| has(file, status)).count());
    let count = files.len();
    let whole = json!({"count": count, "statuses": statuses, "files": files});
    files.sort_by_key(|file| (Reverse(has(file, "error")), Reverse(has(file, "warning"))));
    files.truncate(MOST);
    let mut answer = Answer::new(whole);
    answer.brief = Some(json!({"count": count, "statuses": statuses, "files": files}));
    answer
}
