//! A job that surveys its inputs.

use std::path::PathBuf;

use mocap_formats::Export;
use mocap_scene::error::Result;
use mocap_scene::files::ReplacePolicy;
use serde::{Deserialize, Serialize};

use super::files::{Files, Outputs, check_inputs, check_outputs, output_files, policy, write_all, written};
use super::{FileOutputOptions, InputOptions, JobReport, SurveyOptions, is_default};

/// Surveys motions: one row for each clip, in the report and in the written table.
///
/// [`SurveyOptions`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SurveyJob {
    /// The options for reading the inputs.
    #[serde(default, skip_serializing_if = "is_default")]
    pub read: InputOptions,
    /// The inputs.
    #[serde(default)]
    pub source: SurveySources,
    /// The options of the survey.
    pub survey: SurveyOptions,
    /// The table.
    #[serde(default, skip_serializing_if = "is_default")]
    pub write: FileOutputOptions,
}

/// The inputs of a survey.
///
/// [`SurveyOptions`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SurveySources {
    /// The motion files, and `.jsonl` files of earlier surveys.
    pub inputs: Vec<PathBuf>,
}

impl SurveyJob {
    /// The files of the survey, the table last, and the rows.
    fn survey_of(&self, files: Files<'_>) -> Result<(Outputs, JobReport)> {
        let (inputs, surveying) = (&self.source.inputs, &self.survey);
        check_inputs(inputs)?;
        let corpus = surveying.corpus_of(&self.read, files, inputs)?;
        let mut made = surveying.beside_of(&self.read, files, &corpus)?;
        if let Some(table) = self.write.output() {
            made.push((table.to_owned(), corpus.to_format(&self.write.extension())?));
        }
        let report = JobReport {
            problem: surveying.problem(&corpus),
            survey: corpus.rows().cloned().collect(),
            files: output_files(&made),
            ..JobReport::default()
        };
        Ok((made, report))
    }

    pub(super) fn make_of(&self, files: Files<'_>) -> Result<(Export, JobReport)> {
        let (made, report) = self.survey_of(files)?;
        Ok((written(made), report))
    }

    /// Makes the survey, and writes the requested files: the page, the findings, then the table.
    pub(super) fn run_of(&self, files: Files<'_>) -> Result<JobReport> {
        let policy = self.policy();
        let beside = self.survey.html.iter().chain(&self.survey.sarif).map(AsRef::as_ref);
        check_outputs(&policy, beside.chain(self.write.output()))?;
        let (made, report) = self.survey_of(files)?;
        write_all(&policy, &made)?;
        Ok(report)
    }

    /// The policy for replacing files: outputs never replace an input.
    pub fn policy(&self) -> ReplacePolicy {
        policy(&self.source.inputs, &self.read, []).force(self.write.force)
    }
}
