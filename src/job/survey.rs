//! Options of a survey.

use std::path::{Path, PathBuf};

use mocap_corpus::survey::report::{ClipRecord, ClipRow, Quality};
use mocap_corpus::survey::{Condition, Corpus, SelectAmount, SelectBy, Thresholds};
use mocap_io::import::Importer;
use mocap_scene::error::{Code, Diagnostic, Result, spelled};
use mocap_scene::math::spread::spread;
use mocap_scene::scene::Scene;
use serde::{Deserialize, Serialize};

use super::files::{Files, Outputs};
use super::{InputOptions, is_default};

/// Options of a survey: thresholds, the clips to keep, and further files next to the table.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::job::Job;
///
/// let job = Job::from_json(r#"{
///     "source": {"inputs": ["fixtures/real/cmu_short.bvh", "fixtures/real/lecture_Test.bvh"]},
///     "survey": {"where": "humanoid and not twin", "threshold": ["skate=20"]}
/// }"#)?;
/// let rows = job.run()?.survey;
/// assert_eq!((rows.len(), rows[0].joints), (1, 31));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SurveyOptions {
    /// Threshold from which a clip is bad, KIND=BAD, or thresholds for suspect and bad, KIND=SUSPECT..BAD, such as
    /// skate=2; inf turns a kind off; repeatable
    #[cfg_attr(feature = "clap", arg(long, value_name = "KIND=AMOUNT"))]
    #[serde(skip_serializing_if = "is_default")]
    pub threshold: Vec<String>,
    /// Keep the rows for which this is true, such as "skate < 1 and not twin"
    #[cfg_attr(feature = "clap", arg(id = "where", long = "where", value_name = "EXPR"))]
    #[cfg_attr(feature = "schema", schemars(with = "Option<String>"))]
    #[serde(rename = "where", skip_serializing_if = "is_default")]
    pub condition: Option<Condition>,
    /// Keep this number or percentage of clips, as diverse as possible
    #[cfg_attr(feature = "clap", arg(long, value_name = "N|N%"))]
    #[cfg_attr(feature = "schema", schemars(with = "Option<String>"))]
    #[serde(skip_serializing_if = "is_default")]
    pub select: Option<SelectAmount>,
    /// Split the clips into parts of these fractions, such as 0.8,0.1,0.1. The column `split` has train, validation or
    /// test; with two parts train or test
    #[cfg_attr(feature = "clap", arg(long, value_name = "FRACTIONS", value_delimiter = ','))]
    #[serde(skip_serializing_if = "is_default")]
    pub split: Vec<f64>,
    /// How to select: diversity, or quality,diversity, which first drops bad clips and near-duplicates. For a split,
    /// clips with the same value stay in one part: person, skeleton, near-duplicate [default: quality,diversity, and
    /// near-duplicate for a split]
    #[cfg_attr(feature = "clap", arg(long, value_name = "LIST", value_delimiter = ','))]
    #[serde(skip_serializing_if = "is_default")]
    pub by: Vec<SelectBy>,
    /// Write the findings as SARIF, which code hosts show next to files
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    #[serde(skip_serializing_if = "is_default")]
    pub sarif: Option<PathBuf>,
    /// Write a page that shows the dataset: counts, the worst and typical clips as moving figures, near-duplicates, a
    /// map
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    #[serde(skip_serializing_if = "is_default")]
    pub html: Option<PathBuf>,
    /// Fail if a kept clip has this verdict or a worse one: the exit code is 1, and the report has a problem
    #[cfg_attr(feature = "clap", arg(long, value_name = "VERDICT", value_parser = parse_verdict))]
    #[serde(skip_serializing_if = "is_default")]
    #[cfg_attr(feature = "schema", schemars(with = "Option<String>"))]
    pub fail_on: Option<Quality>,
}

#[cfg(feature = "clap")]
fn parse_verdict(text: &str) -> Result<Quality, String> {
    let known = [Quality::Suspect, Quality::Bad];
    let found = known.into_iter().find(|verdict| verdict.as_str() == text);
    found.ok_or_else(|| "it must be suspect or bad".to_owned())
}

impl SurveyOptions {
    /// The amounts from which a clip is suspect and bad.
    ///
    /// # Errors
    /// [`Code::InvalidValue`](mocap_scene::Code::InvalidValue) for a string that is not a threshold.
    pub fn thresholds(&self) -> Result<Thresholds> {
        let mut thresholds = Thresholds::default();
        self.threshold.iter().try_for_each(|text| thresholds.set(text))?;
        Ok(thresholds)
    }

    /// The clips of a motion file, read with `read`; or the clips of a record, a `.jsonl` file.
    ///
    /// # Errors
    /// As [`Importer::import`]; [`Code::InvalidValue`](mocap_scene::Code::InvalidValue) for a line that is not a row.
    pub fn examine(&self, read: &InputOptions, path: &Path) -> Result<Vec<ClipRecord>> {
        let files = Files {
            given: &[],
            has_disk: true,
        };
        examine(&self.thresholds()?, read, files, path)
    }

    /// The corpus of files, computed on all cores. A file that cannot be read gives a row with its error.
    ///
    /// # Errors
    /// As [`thresholds`](Self::thresholds).
    pub fn corpus(&self, read: &InputOptions, paths: &[PathBuf]) -> Result<Corpus> {
        let files = Files {
            given: &[],
            has_disk: true,
        };
        self.corpus_of(read, files, paths)
    }

    pub(super) fn corpus_of(&self, read: &InputOptions, files: Files<'_>, paths: &[PathBuf]) -> Result<Corpus> {
        let thresholds = self.thresholds()?;
        let rows = spread(paths, |path| {
            let found = examine(&thresholds, read, files, path);
            found.unwrap_or_else(|error| vec![ClipRow::unreadable(&path.to_string_lossy(), &error.to_string()).into()])
        });
        self.judge(rows.into_iter().flatten().collect())
    }

    /// Judges all clips together, and returns the clips to keep.
    ///
    /// # Errors
    /// As [`thresholds`](Self::thresholds).
    pub fn judge(&self, clips: Vec<ClipRecord>) -> Result<Corpus> {
        let mut corpus = Corpus::new(clips, &self.thresholds()?);
        self.check_by()?;
        if let Some(condition) = &self.condition {
            corpus.keep(|row| condition.holds(row));
        }
        if let Some(amount) = self.select {
            let mut by = self.by.iter().filter(|by| is_of_selection(**by)).peekable();
            let by_quality = by.peek().is_none() || by.any(|by| *by == SelectBy::Quality);
            let count = amount.of(corpus.rows().len());
            corpus.select(count, by_quality);
        }
        if !self.split.is_empty() {
            let by: Vec<SelectBy> = self.by.iter().copied().filter(|by| !is_of_selection(*by)).collect();
            let by: &[SelectBy] = match by.as_slice() {
                [] => &[SelectBy::NearDuplicate],
                by => by,
            };
            corpus.split(&self.split, by)?;
        }
        Ok(corpus)
    }

    /// Refuses a value of `by` without the selection or split that it controls.
    fn check_by(&self) -> Result<()> {
        let needs = |option: &str, by: &str| Diagnostic::new(Code::InvalidValue, format!("{{by}} {by} needs {option}"));
        let error = match self.by.iter().find(|by| is_of_selection(**by)) {
            Some(_) if self.select.is_none() => needs("{select}", "quality and diversity"),
            _ if self.split.is_empty() && !self.by.iter().copied().all(is_of_selection) => {
                needs("{split}", "person, skeleton and near-duplicate")
            }
            _ => return Ok(()),
        };
        Err(error.help("add {select} or {split}, or omit {by}").into())
    }

    /// The further files: the page and the findings, if requested.
    ///
    /// # Errors
    /// As [`thresholds`](Self::thresholds).
    pub fn beside(&self, read: &InputOptions, corpus: &Corpus) -> Result<Vec<(PathBuf, Vec<u8>)>> {
        let files = Files {
            given: &[],
            has_disk: true,
        };
        self.beside_of(read, files, corpus)
    }

    pub(super) fn beside_of(&self, read: &InputOptions, files: Files<'_>, corpus: &Corpus) -> Result<Outputs> {
        let (thresholds, importer) = (self.thresholds()?, importer(read));
        let import = |file: &str| -> Option<Scene> { files.import(&importer, Path::new(file)).ok() };
        let page = self
            .html
            .as_ref()
            .map(|path| (path.clone(), corpus.to_page(&thresholds, import)));
        let findings = self
            .sarif
            .as_ref()
            .map(|path| (path.clone(), corpus.to_sarif(&thresholds)));
        let made = page.into_iter().chain(findings);
        Ok(made.map(|(path, text)| (path, text.into_bytes())).collect())
    }

    /// The `mocap.toml` files near `paths` that have a pattern without a matching file. Each of these files has a
    /// warning for each of its unmatched patterns.
    #[doc(hidden)]
    pub fn unmatched_patterns<'a>(paths: impl IntoIterator<Item = &'a Path>) -> Vec<(PathBuf, Vec<Diagnostic>)> {
        mocap_io::import::attribution::unmatched_patterns(paths)
    }

    /// Describes the parts of a split that have no clip, and the clips that a split may not keep together.
    #[doc(hidden)]
    pub fn doubts(&self, corpus: &Corpus) -> Vec<String> {
        if self.split.is_empty() {
            return Vec::new();
        }
        let empty = corpus.empty_parts(self.split.len());
        let empty = (!empty.is_empty()).then(|| {
            spelled(&format!(
                "{{split}} puts no clip into {}: there are too few groups of clips that belong together; add clips, or \
                 split {{by}} another value",
                empty.join(" and ")
            ))
            .to_string()
        });
        let is_by_other = self
            .by
            .iter()
            .any(|by| !is_of_selection(*by) && *by != SelectBy::NearDuplicate);
        let too_short = corpus.too_short_note().filter(|_| !is_by_other);
        empty.into_iter().chain(too_short).collect()
    }

    /// Describes the clips that are worse than allowed.
    pub fn problem(&self, corpus: &Corpus) -> Option<String> {
        let least = self.fail_on?;
        let bad: Vec<&ClipRow> = corpus.rows().filter(|row| row.verdict >= least).collect();
        let first = bad.first()?;
        let (count, verdict) = (bad.len(), least.as_str());
        Some(format!(
            "{count} clips are {verdict} or worse; the first is {}: {}",
            first.file, first.reasons
        ))
    }
}

/// Whether `by` controls the selection, not the split.
fn is_of_selection(by: SelectBy) -> bool {
    matches!(by, SelectBy::Quality | SelectBy::Diversity)
}

/// Rows need no mesh, and files are read in parallel.
fn importer(read: &InputOptions) -> Importer {
    read.importer().threads(1).with_own_meshes()
}

fn examine(thresholds: &Thresholds, read: &InputOptions, files: Files<'_>, path: &Path) -> Result<Vec<ClipRecord>> {
    let is_record = path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("jsonl"));
    if !is_record {
        let scene = files.import(&importer(read), path)?;
        return Ok(thresholds.examine_read(scene, &path.to_string_lossy()));
    }
    let text = files.text(path)?;
    ClipRecord::from_lines(&text).map_err(|error| error.with_path(path))
}
