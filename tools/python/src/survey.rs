//! Surveys of many motions.

use std::path::{Path, PathBuf};

use mocap::FormatInfo;
use mocap::files::{ReplacePolicy, write_file};
use mocap::job::{InputOptions, SurveyOptions};
use mocap::survey::Corpus;
use mocap::survey::report::{ClipRecord, ClipRow};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;

use crate::ReadOptions;
use crate::arrow::ArrowTable;
use crate::errors::{from_json, to_python};

/// The rows of a corpus, with the options of the survey.
#[pyclass(frozen, module = "mocap")]
pub(crate) struct Survey {
    corpus: Corpus,
    surveying: SurveyOptions,
    read: InputOptions,
}

#[pymethods]
impl Survey {
    fn __len__(&self) -> usize {
        self.corpus.rows().len()
    }

    fn rows_json(&self) -> String {
        self.corpus.to_json()
    }

    #[getter]
    fn files(&self) -> Vec<String> {
        self.corpus.to_list().lines().map(str::to_owned).collect()
    }

    #[getter]
    fn problem(&self) -> Option<String> {
        self.surveying.problem(&self.corpus)
    }

    fn arrow(&self) -> ArrowTable {
        ArrowTable::new(self.corpus.to_table())
    }

    /// Writes a table, a page or the findings, by the extension of the file.
    fn write(&self, py: Python<'_>, path: PathBuf, overwrite: bool) -> PyResult<()> {
        let made = py.detach(|| -> mocap::Result<()> {
            let policy = ReplacePolicy::new(self.corpus.rows().map(|row| Path::new(&row.file))).force(overwrite);
            policy.check_ahead(&path)?;
            let mut surveying = self.surveying.clone();
            let extension = path
                .extension()
                .unwrap_or_default()
                .to_string_lossy()
                .to_ascii_lowercase();
            (surveying.html, surveying.sarif) = match extension.as_str() {
                "html" => (Some(path.clone()), None),
                "sarif" => (None, Some(path.clone())),
                _ => {
                    let bytes = self
                        .corpus
                        .to_format(&extension)
                        .map_err(|error| error.with_path(&path))?;
                    policy.check_bytes(&path, &bytes)?;
                    return write_file(&path, &bytes);
                }
            };
            for (path, bytes) in surveying.beside(&self.read, &self.corpus)? {
                policy.check_bytes(&path, &bytes)?;
                write_file(&path, &bytes)?;
            }
            Ok(())
        });
        made.map_err(|error| to_python(py, &error))
    }
}

/// Surveys files and records. Records are lines of `examine` from other processes.
#[pyfunction]
pub(crate) fn survey(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    records: Vec<String>,
    options: &str,
    read: ReadOptions,
) -> PyResult<Survey> {
    let (surveying, read): (SurveyOptions, _) = (from_json(options, "")?, read.reading()?);
    let corpus = py.detach(|| match records.is_empty() {
        true => surveying.corpus(&read, &paths),
        false => surveying.judge(ClipRecord::from_lines(&records.join("\n"))?),
    });
    Ok(Survey {
        corpus: corpus.map_err(|error| to_python(py, &error))?,
        surveying,
        read,
    })
}

/// Examines files in memory. Returns the lines of a record, a line for each clip.
#[pyfunction]
pub(crate) fn examine(
    py: Python<'_>,
    files: Vec<(String, PyBackedBytes)>,
    options: &str,
    read: ReadOptions,
) -> PyResult<Vec<String>> {
    let thresholds = from_json::<SurveyOptions>(options, "")?
        .thresholds()
        .map_err(|error| to_python(py, &error))?;
    let importer = read.importer()?;
    let lines = py.detach(|| {
        let of_file = |(name, data): &(String, PyBackedBytes)| match importer.read(data, name) {
            Ok(scene) => thresholds.examine(&scene, name),
            Err(error) => vec![ClipRow::unreadable(name, &error.to_string()).into()],
        };
        files.iter().flat_map(of_file).map(|clip| clip.to_line()).collect()
    });
    Ok(lines)
}

/// The extensions of readable files.
#[pyfunction]
pub(crate) fn extensions() -> Vec<&'static str> {
    FormatInfo::ALL
        .iter()
        .flat_map(|format| format.extensions)
        .copied()
        .collect()
}
