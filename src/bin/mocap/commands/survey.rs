//! `mocap survey`: a row for each clip of many files.

use std::collections::HashMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use mocap::files::ReplacePolicy;
use mocap::survey::{ClipRow, Corpus, Examined, Quality, Thresholds};
use mocap::{Code, Diagnostic, SkeletonMesh};

use crate::args::SurveyArgs;
use crate::batch::gather::gather;
use crate::batch::hash::sha256;
use crate::batch::inputs::{self, Input};
use crate::batch::progress::Counts;
use crate::{Failure, report, streams};

/// Rows of the list of the worst.
const WORST: usize = 10;

pub(crate) fn run(args: &SurveyArgs) -> Result<(), Failure> {
    let thresholds = args.thresholds()?;
    let format = args
        .output
        .as_deref()
        .map(|output| format_of(args, output))
        .transpose()?;
    let mut inputs = inputs::find(&args.paths, &args.inputs)?;
    inputs.retain(|input| args.spread.shard.is_none_or(|shard| shard.has(input)));
    let output = args.output.as_deref().map(|output| args.spread.of_shard(output));
    let sources: Vec<&Path> = inputs.iter().map(|input| input.path.as_path()).collect();
    let policy = ReplacePolicy::new(sources).force(args.force.force);
    if let Some(output) = output.as_deref().filter(|output| !streams::is_standard(output)) {
        policy.check_inputs(output)?;
    }
    let beside = [&args.sarif, &args.html].into_iter().flatten();
    streams::refuse_one_file(output.iter().chain(beside).map(PathBuf::as_path))?;
    for beside in [&args.sarif, &args.html].into_iter().flatten() {
        policy.check_inputs(beside)?;
    }
    let former = match (&output, args.resume) {
        (Some(output), true) => former(output)?,
        _ => HashMap::new(),
    };
    let (corpus, counts) = chosen(args, &inputs, &thresholds, &former)?;
    // The largest first: where the disk is full, nothing is written.
    if let Some(path) = &args.html {
        let page = corpus.to_page(&thresholds, |file| {
            let importer = args.read.importer().threads(1).skeleton_mesh(SkeletonMesh::None);
            streams::import(&importer, Path::new(file)).ok()
        });
        super::write_output(&policy, path, page.as_bytes())?;
        report::say(&format!("{}: {} clips", path.display(), corpus.rows().len()));
    }
    if let Some(path) = &args.sarif {
        super::write_output(&policy, path, corpus.to_sarif(&thresholds).as_bytes())?;
    }
    if let (Some(output), Some(format)) = (&output, format) {
        streams::write(output, &bytes(&corpus, &format)?)?;
        report::say(&format!("{}: {} clips", output.display(), corpus.rows().len()));
    }
    match (&output, args.select) {
        (Some(_), _) => {}
        (None, Some(_)) => report::stdout().write_all(corpus.to_list().as_bytes())?,
        (None, None) => print(&corpus)?,
    }
    counts.verdict()?;
    let worst = corpus.rows().map(|row| row.verdict).max().unwrap_or_default();
    match args.fails_from().is_some_and(|least| worst >= least) {
        true => Err(Failure::Told),
        false => Ok(()),
    }
}

/// Writes the table of the clips to a file.
pub(crate) fn write(args: &SurveyArgs, corpus: &Corpus, output: &Path) -> Result<(), Failure> {
    let format = format_of(args, output)?;
    ReplacePolicy::new(&args.paths).check_inputs(output)?;
    streams::write(output, &bytes(corpus, &format)?)
}

/// The clips that the arguments ask for.
pub(crate) fn corpus(args: &SurveyArgs) -> Result<Corpus, Failure> {
    let inputs = inputs::find(&args.paths, &args.inputs)?;
    Ok(chosen(args, &inputs, &args.thresholds()?, &HashMap::new())?.0)
}

fn chosen(
    args: &SurveyArgs,
    inputs: &[Input],
    thresholds: &Thresholds,
    former: &HashMap<String, Vec<Examined>>,
) -> Result<(Corpus, Counts), Failure> {
    let (files, counts) = gather(&args.spread, inputs, |input| match unchanged(former, input) {
        Some(clips) => Ok(clips),
        None => of_file(args, input, thresholds),
    })?;
    let clips = std::iter::zip(inputs, files).flat_map(|(input, found)| match found {
        Ok(found) => found,
        Err(error) => vec![ClipRow::unreadable(&input.path.to_string_lossy(), &error).into()],
    });
    let clips = clips.collect();
    let mut corpus = Corpus::new(clips, thresholds);
    if let Some(condition) = &args.condition {
        corpus.keep(|row| condition.holds(row));
    }
    if let Some(amount) = args.select {
        let count = amount.of(corpus.rows().len());
        corpus.select(count, args.by_quality());
    }
    Ok((corpus, counts))
}

/// The format of the table.
fn format_of(args: &SurveyArgs, output: &Path) -> Result<String, Failure> {
    let format = super::output_format(output, args.to.as_deref(), "csv")?;
    match format.as_str() {
        "csv" | "json" | "jsonl" | "txt" => Ok(format),
        #[cfg(feature = "parquet")]
        "parquet" => Ok(format),
        #[cfg(not(feature = "parquet"))]
        "parquet" => Err(super::without_parquet()),
        _ => Err(super::unknown_extension(
            output,
            ".parquet, .csv, .json, .jsonl or .txt",
        )),
    }
}

fn bytes(corpus: &Corpus, format: &str) -> Result<Vec<u8>, Failure> {
    Ok(match format {
        "json" => corpus.to_json().into_bytes(),
        "txt" => corpus.to_list().into_bytes(),
        "jsonl" => corpus.to_record().into_bytes(),
        #[cfg(feature = "parquet")]
        "parquet" => mocap::arrays::table::to_parquet(&[corpus.to_table()])?,
        _ => corpus.to_csv().into_bytes(),
    })
}

/// The clips of an earlier run by their files.
fn former(output: &Path) -> Result<HashMap<String, Vec<Examined>>, Failure> {
    if super::extension(output) != "jsonl" {
        return Err(Failure::Usage(format!(
            "{}: --resume takes a .jsonl output, of which .parquet and .csv are then made",
            output.display()
        )));
    }
    let mut files = HashMap::<String, Vec<Examined>>::new();
    if output.is_file() {
        for clip in records(output)? {
            files.entry(clip.row.file.clone()).or_default().push(clip);
        }
    }
    Ok(files)
}

/// The clips of a file that an earlier run had, if its bytes are the same.
fn unchanged(former: &HashMap<String, Vec<Examined>>, input: &Input) -> Option<Vec<Examined>> {
    let clips = former.get(&*input.path.to_string_lossy())?;
    let sha256 = sha256(&input.path).ok()?;
    let is_same = |clip: &Examined| clip.row.error.is_none() && clip.row.sha256 == sha256;
    clips.iter().all(is_same).then(|| clips.clone())
}

/// The clips of a record.
fn records(path: &Path) -> mocap::Result<Vec<Examined>> {
    mocap::files::check_confined(path)?;
    let text = std::fs::read_to_string(path).map_err(|error| Diagnostic::new(Code::Io, error.to_string()));
    let text = text.map_err(|error| mocap::Error::from(error).with_path(path))?;
    Examined::from_lines(&text).map_err(|error| error.with_path(path))
}

/// The clips of a file, or of the record that it is.
fn of_file(args: &SurveyArgs, input: &Input, thresholds: &Thresholds) -> mocap::Result<Vec<Examined>> {
    let path = input.path()?;
    if super::extension(path) == "jsonl" {
        return records(path);
    }
    let importer = args.read.importer().threads(1).skeleton_mesh(SkeletonMesh::None);
    let scene = streams::import(&importer, path)?;
    Ok(thresholds.examine(&scene, &path.to_string_lossy()))
}

/// Prints a table of verdicts and reasons, and the worst clips.
fn print(corpus: &Corpus) -> io::Result<()> {
    let mut out = report::stdout();
    let count = |verdict| corpus.rows().filter(|row| row.verdict == verdict).count();
    let seconds: f64 = corpus.rows().map(|row| row.seconds).sum();
    writeln!(out, "{} clips, {:.1} min", corpus.rows().len(), seconds / 60.0)?;
    for verdict in Quality::ALL {
        writeln!(out, "  {:<12}{:>8}", verdict.as_str(), count(verdict))?;
    }
    let mut kinds = std::collections::BTreeMap::<&str, usize>::new();
    for row in corpus.rows() {
        row.reasons
            .split_whitespace()
            .for_each(|kind| *kinds.entry(kind).or_default() += 1);
    }
    let mut kinds: Vec<_> = kinds.into_iter().collect();
    kinds.sort_by_key(|(kind, count)| (std::cmp::Reverse(*count), *kind));
    if !kinds.is_empty() {
        writeln!(out, "reasons")?;
    }
    for (kind, count) in kinds {
        writeln!(out, "  {kind:<16}{count:>4}")?;
    }
    let mut worst: Vec<&ClipRow> = corpus.rows().filter(|row| row.verdict != Quality::Good).collect();
    worst.sort_by(|a, b| a.quality.total_cmp(&b.quality));
    if !worst.is_empty() {
        writeln!(out, "the worst")?;
    }
    for row in worst.into_iter().take(WORST) {
        writeln!(
            out,
            "  {:.2}  {:<10} {}  {}",
            row.quality,
            row.verdict.as_str(),
            row.file,
            row.reasons
        )?;
    }
    out.flush()
}
