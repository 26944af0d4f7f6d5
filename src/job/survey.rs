//! A survey of the inputs of a job, instead of an output of their motion.

use std::path::{Path, PathBuf};

use mocap_corpus::survey::{ClipRow, Condition, Corpus, Examined, Quality, SelectAmount, SelectBy, Thresholds};
use mocap_io::import::Importer;
use mocap_scene::error::Result;
use mocap_scene::math::spread::spread;
use mocap_scene::process::SkeletonMesh;
use mocap_scene::scene::Scene;
use serde::{Deserialize, Serialize};

use super::files::{Files, check_outputs, write_all};
use super::{Job, JobReport, OutputFile, Reading, Sources, file_name, is_default, refuse};

/// How motions are surveyed: thresholds, which clips are kept, and what is written beside the table.
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
pub struct Surveying {
    /// The amount from which a clip is bad, KIND=BAD, or suspect and bad, KIND=SUSPECT..BAD, as skate=2; inf turns a
    /// kind off; once for each kind
    #[cfg_attr(feature = "clap", arg(long, value_name = "KIND=AMOUNT"))]
    #[serde(skip_serializing_if = "is_default")]
    pub threshold: Vec<String>,
    /// Keep the rows for which this holds, as "skate < 1 and not twin"
    #[cfg_attr(feature = "clap", arg(id = "where", long = "where", value_name = "EXPR"))]
    #[cfg_attr(feature = "schema", schemars(with = "Option<String>"))]
    #[serde(rename = "where", skip_serializing_if = "is_default")]
    pub condition: Option<Condition>,
    /// Keep so many clips, or so many per cent, which are as different as can be
    #[cfg_attr(feature = "clap", arg(long, value_name = "N|N%"))]
    #[cfg_attr(feature = "schema", schemars(with = "Option<String>"))]
    #[serde(skip_serializing_if = "is_default")]
    pub select: Option<SelectAmount>,
    /// By what to select: quality leaves out bad clips and twins first [default: quality,diversity]
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "LIST", value_delimiter = ',', requires = "select")
    )]
    #[serde(skip_serializing_if = "is_default")]
    pub by: Vec<SelectBy>,
    /// Write the findings as SARIF, which code hosts show beside files
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    #[serde(skip_serializing_if = "is_default")]
    pub sarif: Option<PathBuf>,
    /// Write a page that shows the corpus: counts, the worst and usual clips as moving figures, twins, a map
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE"))]
    #[serde(skip_serializing_if = "is_default")]
    pub html: Option<PathBuf>,
    /// Fail where a clip that is kept is so bad: the exit code is 1, and the problem of a report says so
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

impl Surveying {
    /// From which amounts on a clip is suspect and bad.
    ///
    /// # Errors
    /// [`Code::InvalidValue`](mocap_scene::Code::InvalidValue) for a text that is no threshold.
    pub fn thresholds(&self) -> Result<Thresholds> {
        let mut thresholds = Thresholds::default();
        self.threshold.iter().try_for_each(|text| thresholds.set(text))?;
        Ok(thresholds)
    }

    /// The clips of a file as `read` reads it, or those of the record that it is, a `.jsonl` file.
    ///
    /// # Errors
    /// As [`Importer::import`]; [`Code::InvalidValue`](mocap_scene::Code::InvalidValue) for a line that is no row.
    pub fn examine(&self, read: &Reading, path: &Path) -> Result<Vec<Examined>> {
        let files = Files {
            given: &[],
            has_disk: true,
        };
        examine(&self.thresholds()?, read, files, path)
    }

    /// The corpus of files, by all cores. A file that cannot be read is a row with its error.
    ///
    /// # Errors
    /// As [`thresholds`](Self::thresholds).
    pub fn corpus(&self, read: &Reading, paths: &[PathBuf]) -> Result<Corpus> {
        let files = Files {
            given: &[],
            has_disk: true,
        };
        self.corpus_of(read, files, paths)
    }

    fn corpus_of(&self, read: &Reading, files: Files<'_>, paths: &[PathBuf]) -> Result<Corpus> {
        let thresholds = self.thresholds()?;
        let rows = spread(paths, |path| {
            let found = examine(&thresholds, read, files, path);
            found.unwrap_or_else(|error| vec![ClipRow::unreadable(&path.to_string_lossy(), &error.to_string()).into()])
        });
        self.judge(rows.into_iter().flatten().collect())
    }

    /// The corpus of clips: judged together, and of them those that are to be kept.
    ///
    /// # Errors
    /// As [`thresholds`](Self::thresholds).
    pub fn judge(&self, clips: Vec<Examined>) -> Result<Corpus> {
        let mut corpus = Corpus::new(clips, &self.thresholds()?);
        if let Some(condition) = &self.condition {
            corpus.keep(|row| condition.holds(row));
        }
        if let Some(amount) = self.select {
            let by_quality = self.by.is_empty() || self.by.contains(&SelectBy::Quality);
            let count = amount.of(corpus.rows().len());
            corpus.select(count, by_quality);
        }
        Ok(corpus)
    }

    /// What is written beside the table: the page and the findings, each where it is asked for.
    ///
    /// # Errors
    /// As [`thresholds`](Self::thresholds).
    pub fn beside(&self, read: &Reading, corpus: &Corpus) -> Result<Vec<(PathBuf, Vec<u8>)>> {
        let files = Files {
            given: &[],
            has_disk: true,
        };
        self.beside_of(read, files, corpus)
    }

    fn beside_of(&self, read: &Reading, files: Files<'_>, corpus: &Corpus) -> Result<Vec<(PathBuf, Vec<u8>)>> {
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

    /// Says which clips are as bad as must not be.
    pub fn problem(&self, corpus: &Corpus) -> Option<String> {
        let least = self.fail_on?;
        let bad: Vec<&ClipRow> = corpus.rows().filter(|row| row.verdict >= least).collect();
        let first = bad.first()?;
        let (count, verdict) = (bad.len(), least.as_str());
        Some(format!(
            "{count} clips are {verdict} or worse, the first {}: {}",
            first.file, first.reasons
        ))
    }
}

/// Files that are to be written, with their bytes.
type Outputs = Vec<(PathBuf, Vec<u8>)>;

/// Rows need no mesh, and files are read beside each other.
fn importer(read: &Reading) -> Importer {
    read.importer().threads(1).skeleton_mesh(SkeletonMesh::None)
}

fn examine(thresholds: &Thresholds, read: &Reading, files: Files<'_>, path: &Path) -> Result<Vec<Examined>> {
    let is_record = path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("jsonl"));
    if !is_record {
        let scene = files.import(&importer(read), path)?;
        return Ok(thresholds.examine(&scene, &path.to_string_lossy()));
    }
    let text = files.text(path)?;
    Examined::from_lines(&text).map_err(|error| error.with_path(path))
}

impl Job {
    /// The files of a survey, the table last, and the rows.
    pub(super) fn survey(&self, surveying: &Surveying, files: Files<'_>) -> Result<(Outputs, JobReport)> {
        self.check_survey()?;
        self.refuse_folders()?;
        let corpus = surveying.corpus_of(&self.read, files, &self.source.inputs)?;
        let mut made = surveying.beside_of(&self.read, files, &corpus)?;
        if let Some(format) = self.table_format() {
            made.push((self.write.output.clone(), corpus.to_format(&format)?));
        }
        let report = JobReport {
            problem: surveying.problem(&corpus),
            survey: corpus.rows().cloned().collect(),
            files: made
                .iter()
                .map(|(path, bytes)| OutputFile {
                    name: file_name(path),
                    bytes: bytes.len(),
                })
                .collect(),
            ..JobReport::default()
        };
        Ok((made, report))
    }

    /// Makes a survey, and writes what it is asked to: the page, the findings, and the table last.
    pub(super) fn run_survey(&self, surveying: &Surveying, files: Files<'_>) -> Result<JobReport> {
        let policy = self.policy();
        let table = Some(&self.write.output).filter(|output| !output.as_os_str().is_empty());
        let outputs = surveying.html.iter().chain(&surveying.sarif).chain(table);
        check_outputs(&policy, outputs)?;
        let (made, report) = self.survey(surveying, files)?;
        write_all(&policy, &made)?;
        Ok(report)
    }

    /// The format of the table, where the job has one.
    fn table_format(&self) -> Option<String> {
        let extension = self.write.output.extension();
        let extension = extension.map(|extension| extension.to_string_lossy().to_ascii_lowercase());
        match self.write.output.as_os_str().is_empty() {
            true => None,
            false => Some(self.write.to.clone().or(extension).unwrap_or_default()),
        }
    }

    /// Refuses what a survey would not heed: steps, another body, options of motions.
    ///
    /// # Errors
    /// [`Code::InvalidValue`](mocap_scene::Code::InvalidValue).
    pub fn check_survey(&self) -> Result<()> {
        let source = Sources {
            inputs: self.source.inputs.clone(),
            ..Sources::default()
        };
        if self.changes_motion(&source) {
            return refuse(
                "the job: a survey changes no motion, and writes tables alone",
                "leave out steps, target, all of source but inputs, and all of write but output, to and force",
            );
        }
        match self.source.inputs.is_empty() {
            true => refuse("the job names no input", "name files in source.inputs"),
            false => Ok(()),
        }
    }
}
