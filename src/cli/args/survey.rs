//! The options of `mocap survey`.

use std::path::PathBuf;

use mocap::job::{InputOptions, SurveyJob, SurveyOptions};

use super::ForceArgs;
use crate::batch::inputs::InputArgs;
use crate::batch::spread::SpreadArgs;

#[derive(Debug, clap::Args)]
pub(crate) struct SurveyArgs {
    /// The motion files, folders and wildcards, or .jsonl tables of earlier surveys and shards
    #[arg(required = true, value_name = "INPUT")]
    pub(crate) paths: Vec<PathBuf>,
    /// The table to write: .parquet, .csv, .json or .jsonl; - is standard output, in the format of --to. A .jsonl table
    /// can be read again and merged. .txt is only the list of files. Without this option, the command prints the
    /// verdicts and the ten worst clips, or with --select the list
    #[arg(short, long, value_name = "OUTPUT")]
    pub(crate) output: Option<PathBuf>,
    /// Format of standard output
    #[arg(long, value_name = "FORMAT", value_parser = ["csv", "json", "jsonl", "parquet", "txt"])]
    pub(crate) to: Option<String>,
    #[command(flatten)]
    pub(crate) surveying: SurveyOptions,
    /// Print the rows of all clips as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Reuse the rows in the .jsonl output of an earlier run if the bytes of their files are unchanged
    #[arg(long, requires = "output")]
    pub(crate) resume: bool,
    /// Print the job of the arguments, for `mocap run` and for programs, and do nothing else
    #[arg(long)]
    pub(crate) print_job: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    #[command(flatten)]
    pub(crate) read: InputOptions,
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    #[command(flatten)]
    pub(crate) spread: SpreadArgs,
}

impl SurveyArgs {
    /// The job of the arguments.
    pub(crate) fn job(&self) -> SurveyJob {
        let mut job = SurveyJob::default();
        job.read = self.read.clone();
        job.source.inputs.clone_from(&self.paths);
        job.survey = self.surveying.clone();
        job.write.output = self.output.clone().unwrap_or_default();
        job.write.to.clone_from(&self.to);
        job.write.force = self.force.force;
        job
    }
}
