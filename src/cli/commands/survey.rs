//! `mocap survey`: a row for each clip of many files.

use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};

use mocap::files::ReplacePolicy;
use mocap::job::{InputOptions, SurveyJob, SurveyOptions};
use mocap::survey::Corpus;
use mocap::survey::report::{ClipRecord, ClipRow, Quality};

use serde::Serialize;

use super::{Place, print_report};
use crate::args::{RunArgs, SurveyArgs};
use crate::batch::gather::gather;
use crate::batch::hash::sha256;
use crate::batch::inputs::{self, Input, InputArgs};
use crate::batch::journal::Journal;
use crate::batch::progress::Counts;
use crate::batch::spread::SpreadArgs;
use crate::{Failure, report, streams};

/// The clips of an earlier run, by file.
type Former = HashMap<String, Vec<ClipRecord>>;
/// Files to write, with their bytes.
type Outputs = Vec<(PathBuf, Vec<u8>)>;

/// The number of worst clips in the list.
const WORST: usize = 10;
/// The number of near-duplicates in the list.
const TWINS: usize = 5;

pub(crate) fn run(args: &SurveyArgs) -> Result<(), Failure> {
    match args.print_job {
        true => super::print_job(&args.job()),
        false => survey(&SurveyTask {
            job: &args.job(),
            resume: args.resume,
            is_json: args.json,
            inputs: &args.inputs,
            spread: &args.spread,
        }),
    }
}

/// Surveys the inputs of a job, which may be folders and wildcards.
pub(super) fn of_job(job: &SurveyJob, args: &RunArgs) -> Result<(), Failure> {
    survey(&SurveyTask {
        job,
        resume: args.resume,
        is_json: args.json,
        inputs: &args.inputs,
        spread: &args.spread,
    })
}

/// A survey to make, with the options of its command.
struct SurveyTask<'a> {
    job: &'a SurveyJob,
    resume: bool,
    is_json: bool,
    inputs: &'a InputArgs,
    spread: &'a SpreadArgs,
}

impl SurveyTask<'_> {
    /// The file of the table, which has the shard in its name.
    fn output(&self) -> Option<PathBuf> {
        Some(self.spread.of_shard(self.job.write.output()?))
    }

    fn inputs(&self) -> Result<Vec<Input>, Failure> {
        let mut inputs = inputs::find(&self.job.source.inputs, self.inputs)?;
        inputs::refuse_missing(&inputs)?;
        inputs.retain(|input| self.spread.shard.is_none_or(|shard| shard.has(input)));
        Ok(inputs)
    }

    /// Examines the inputs. Keeps the rows of an earlier run, and adds the others to the journal.
    fn corpus(
        &self,
        inputs: &[Input],
        former: &Former,
        mut journal: Option<&mut Journal>,
    ) -> Result<(Corpus, Counts), Failure> {
        let surveying = &self.job.survey;
        let work = |input: &Input| match unchanged(former, input) {
            Some(clips) => Ok((clips, false)),
            None => Ok((surveying.examine(&self.job.read, input.path()?)?, true)),
        };
        let keep = |(clips, is_new): &(Vec<ClipRecord>, bool)| match (&mut journal, is_new) {
            (Some(journal), true) => journal.add(clips),
            _ => Ok(()),
        };
        let (files, counts) = gather(self.spread, inputs, work, keep)?;
        let clips = std::iter::zip(inputs, files).flat_map(|(input, found)| match found {
            Ok((found, _)) => found,
            Err(error) => vec![ClipRow::unreadable(&input.path.to_string_lossy(), &error).into()],
        });
        Ok((surveying.judge(clips.collect())?, counts))
    }
}

fn survey(work: &SurveyTask<'_>) -> Result<(), Failure> {
    let (surveying, output) = (&work.job.survey, work.output());
    super::check_json(work.is_json, &work.job.write.output)?;
    let to = work.job.write.to.as_deref();
    let format = output.as_deref().map(|output| format_of(output, to)).transpose()?;
    let inputs = work.inputs()?;
    let sources: Vec<&Path> = inputs.iter().map(|input| input.path.as_path()).collect();
    let mut policy = ReplacePolicy::new(sources).force(work.job.write.force);
    let mut known = Former::new();
    if let (Some(output), true) = (&output, work.resume) {
        known = former(output)?;
        // The new table contains the rows of the old table, even rows that a user has changed.
        policy = policy.outputs([output]);
    }
    // Wrong options are reported before any file is read or written.
    surveying.thresholds()?;
    if let Some(output) = output.as_deref().filter(|output| !streams::is_standard(output)) {
        policy.check_ahead(output)?;
    }
    let beside = [&surveying.sarif, &surveying.html].into_iter().flatten();
    super::refuse_one_file(output.iter().chain(beside).map(PathBuf::as_path))?;
    for beside in [&surveying.sarif, &surveying.html].into_iter().flatten() {
        policy.check_ahead(beside)?;
    }
    for (path, warnings) in SurveyOptions::unmatched_patterns(inputs.iter().map(|input| input.path.as_path())) {
        report::warnings(Some(&path), &warnings);
    }
    let mut journal = None;
    if let Some(output) = output.as_deref().filter(|output| is_record(output)) {
        let (opened, clips) = Journal::open(output, work.resume)?;
        journal = Some(opened);
        known.extend(by_file(clips));
    }
    let (corpus, counts) = work.corpus(&inputs, &known, journal.as_mut())?;
    surveying.doubts(&corpus).iter().for_each(|doubt| report::say(doubt));
    let mut made = surveying.beside(&work.job.read, &corpus)?;
    if let (Some(output), Some(format)) = (&output, format) {
        made.push((output.clone(), corpus.to_format(&format)?));
    }
    streams::write_all(&made, &policy)?;
    journal.map_or(Ok(()), Journal::finish)?;
    for (path, _) in &made {
        let clips = report::counted(corpus.rows().len(), "clip");
        report::say(&format!("{}: {clips}", path.display()));
    }
    if work.is_json || output.is_none() {
        let report = SurveyReport {
            rows: corpus.rows().collect(),
            list: surveying.select.map(|_| corpus.to_list()),
            too_short: corpus.too_short_note(),
        };
        let place = match report.list {
            Some(_) => Place::Data,
            None => Place::Result,
        };
        print_report(&report, work.is_json, place)?;
    }
    // Files that cannot be read must not hide that the survey fails.
    match surveying.problem(&corpus) {
        Some(problem) => {
            report::complain(&problem);
            Err(Failure::Told)
        }
        None => counts.verdict(),
    }
}

/// The clips of a job, and its outputs, which are not yet written.
pub(crate) fn made(job: &SurveyJob, inputs: &InputArgs, spread: &SpreadArgs) -> Result<(Corpus, Outputs), Failure> {
    let work = SurveyTask {
        job,
        resume: false,
        is_json: false,
        inputs,
        spread,
    };
    let format = work.output().map(|output| format_of(&output, None)).transpose()?;
    job.survey.thresholds()?;
    let (corpus, _) = work.corpus(&work.inputs()?, &Former::new(), None)?;
    let mut outputs = job.survey.beside(&job.read, &corpus)?;
    if let (Some(output), Some(format)) = (work.output(), format) {
        outputs.push((output, corpus.to_format(&format)?));
    }
    Ok((corpus, outputs))
}

/// The format of the table.
fn format_of(output: &Path, to: Option<&str>) -> Result<String, Failure> {
    let format = super::output_format(output, to, "csv")?;
    match format.as_str() {
        #[cfg(not(feature = "parquet"))]
        "parquet" => Err(super::without_parquet()),
        known if Corpus::FORMATS.contains(&known) => Ok(format),
        _ => Err(super::unknown_extension(
            output,
            ".parquet, .csv, .json, .jsonl or .txt",
        )),
    }
}

/// Whether the output is a table that can be read again.
fn is_record(output: &Path) -> bool {
    super::extension(output) == "jsonl" && !streams::is_standard(output)
}

/// The clips of an earlier run.
fn former(output: &Path) -> Result<Former, Failure> {
    if !is_record(output) {
        return Err(Failure::Usage(format!(
            "{}: --resume needs a .jsonl output; for .parquet and .csv, survey that .jsonl file",
            output.display()
        )));
    }
    match output.is_file() {
        true => Ok(by_file(
            SurveyOptions::default().examine(&InputOptions::default(), output)?,
        )),
        false => Ok(Former::new()),
    }
}

fn by_file(clips: Vec<ClipRecord>) -> Former {
    let mut files = Former::new();
    for clip in clips {
        files.entry(clip.row.file.clone()).or_default().push(clip);
    }
    files
}

/// The clips that an earlier run found in a file, if the file is unchanged and the record has all of its clips.
fn unchanged(former: &Former, input: &Input) -> Option<Vec<ClipRecord>> {
    let clips = former.get(&*input.path.to_string_lossy())?;
    let sha256 = sha256(&input.path).ok()?;
    let is_same = |clip: &ClipRecord| clip.row.error.is_none() && clip.row.sha256 == sha256;
    (ClipRecord::are_all(clips) && clips.iter().all(is_same)).then(|| clips.clone())
}

/// The rows as JSON. As text: the list of selected files; or a table of verdicts and reasons, and the worst clips.
#[derive(Serialize)]
#[serde(transparent)]
struct SurveyReport<'a> {
    rows: Vec<&'a ClipRow>,
    /// The files of a selection.
    #[serde(skip)]
    list: Option<String>,
    /// The note on clips that are too short to compare.
    #[serde(skip)]
    too_short: Option<String>,
}

impl fmt::Display for SurveyReport<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(list) = &self.list {
            return f.write_str(list);
        }
        let rows = || self.rows.iter().copied();
        let count = |verdict| rows().filter(|row| row.verdict == verdict).count();
        // The sum of no numbers is -0. Adding 0 makes it 0.
        let seconds = 0.0 + rows().map(|row| row.seconds).sum::<f64>();
        writeln!(
            f,
            "{}, {:.1} min",
            report::counted(rows().len(), "clip"),
            seconds / 60.0
        )?;
        for verdict in Quality::ALL {
            writeln!(f, "  {:<12}{:>8}", verdict.as_str(), count(verdict))?;
        }
        self.write_twins(f)?;
        write_kinds(f, "defects", rows().map(|row| &*row.reasons))?;
        write_kinds(
            f,
            "properties, which do not lower a verdict",
            rows().map(|row| &*row.properties),
        )?;
        let mut worst: Vec<&ClipRow> = rows().filter(|row| row.verdict != Quality::Good).collect();
        worst.sort_by(|a, b| a.quality.total_cmp(&b.quality));
        if !worst.is_empty() {
            writeln!(f, "the worst")?;
        }
        for row in worst.into_iter().take(WORST) {
            writeln!(
                f,
                "  {:.2}  {:<10} {}  {}",
                row.quality,
                row.verdict.as_str(),
                row.file,
                reasons_of(row)
            )?;
            if row.verdict != Quality::Unreadable {
                writeln!(f, "        {}", look_at(row))?;
            }
        }
        Ok(())
    }
}

impl SurveyReport<'_> {
    /// The number of near-duplicates with their reasons, and some of them with the command that shows both clips.
    fn write_twins(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let twins: Vec<&ClipRow> = self.rows.iter().copied().filter(|row| row.twin).collect();
        write!(f, "near-duplicates: {}", report::counted(twins.len(), "clip"))?;
        let reasons = counts(twins.iter().filter_map(|row| row.twin_reason.as_deref()));
        let reasons: Vec<String> = reasons
            .iter()
            .map(|(reason, count)| format!("{reason} {count}"))
            .collect();
        if !reasons.is_empty() {
            write!(f, " ({})", reasons.join(", "))?;
        }
        writeln!(f)?;
        // Copies with the same bytes look alike, so do not show them.
        let is_copy = |row: &ClipRow| row.twin_reason.as_deref() == Some("bytes");
        let (copies, others): (Vec<&ClipRow>, Vec<&ClipRow>) = twins.into_iter().partition(|row| is_copy(row));
        for row in others.into_iter().chain(copies).take(TWINS) {
            if let (Some(kept), Some(reason)) = (&row.twin_of, &row.twin_reason) {
                writeln!(f, "  {reason:<10}  mocap view {} {}", quoted(&row.file), quoted(kept))?;
            }
        }
        match &self.too_short {
            Some(note) => writeln!(f, "  {note}"),
            None => Ok(()),
        }
    }
}

/// The kinds of defects with their amounts, the worst first, as in `skate 18.1 cm`.
fn reasons_of(row: &ClipRow) -> String {
    let with_amount = |name: &str| {
        let mut amounts = row.amounts.iter();
        let found = amounts.find(|(kind, _)| kind.as_str() == name);
        found.map_or_else(
            || name.to_owned(),
            |(kind, amount)| format!("{name} {} {}", rounded(*amount), kind.unit()),
        )
    };
    let reasons = row.reasons.split_whitespace().map(with_amount);
    reasons.collect::<Vec<_>>().join(", ")
}

/// A number with three digits at most. Only digits after the point are rounded away.
fn rounded(amount: f64) -> String {
    match amount.abs() {
        ..10.0 => format!("{}", (amount * 100.0).round() / 100.0),
        ..100.0 => format!("{}", (amount * 10.0).round() / 10.0),
        _ => format!("{amount:.0}"),
    }
}

/// The number of clips with each kind, the most frequent first.
fn write_kinds<'a>(f: &mut fmt::Formatter<'_>, title: &str, of_rows: impl Iterator<Item = &'a str>) -> fmt::Result {
    let kinds = counts(of_rows.flat_map(str::split_whitespace));
    if !kinds.is_empty() {
        writeln!(f, "{title}")?;
    }
    for (kind, count) in kinds {
        writeln!(f, "  {kind:<18}{count:>4}")?;
    }
    Ok(())
}

/// How often each word occurs, the most frequent first.
fn counts<'a>(words: impl Iterator<Item = &'a str>) -> Vec<(&'a str, usize)> {
    let mut counts = std::collections::BTreeMap::<&str, usize>::new();
    for word in words {
        *counts.entry(word).or_default() += 1;
    }
    let mut counts: Vec<_> = counts.into_iter().collect();
    counts.sort_by_key(|(word, count)| (std::cmp::Reverse(*count), *word));
    counts
}

/// A path, quoted for a shell.
fn quoted(file: &str) -> String {
    match file.contains(|c: char| c.is_whitespace() || "\"'$&();<>|*?`\\".contains(c)) {
        true => format!("'{}'", file.replace('\'', "'\\''")),
        false => file.to_owned(),
    }
}

/// The command that shows a clip, around the largest finding of its worst kind.
fn look_at(row: &ClipRow) -> String {
    /// Seconds that are shown before and after the finding.
    const AROUND: f64 = 2.0;
    let worst = row.reasons.split(' ').next().unwrap_or_default();
    let findings = row.defects.iter().filter(|defect| defect.kind.as_str() == worst);
    let largest = findings.max_by(|a, b| a.amount.total_cmp(&b.amount));
    let file = quoted(&row.file);
    let last = row.frames.saturating_sub(1) as usize;
    let around = (AROUND * row.rate.unwrap_or(0.0)) as usize;
    match largest.map(|finding| finding.frames) {
        Some([from, to]) if from > around || to + around < last => {
            let (from, to) = (from.saturating_sub(around), (to + around).min(last));
            format!("mocap view {file} --trim {from}f..{to}f")
        }
        _ => format!("mocap view {file}"),
    }
}
