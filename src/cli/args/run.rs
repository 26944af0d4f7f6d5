//! The options of `mocap run`, and `--print-job` and `--dry-run` of other commands.

use std::path::PathBuf;

use super::ForceArgs;
use super::write::extensions_and;
use crate::batch::inputs::InputArgs;
use crate::batch::spread::SpreadArgs;

#[derive(Debug, clap::Args)]
pub(crate) struct RunArgs {
    /// The job: a JSON file, or - for standard input. Paths in the job are relative to the current folder. If the job's
    /// output is a folder, each motion gets one output, and inputs may be folders and wildcards
    #[arg(required_unless_present = "schema", value_name = "INPUT")]
    pub(crate) job: Option<PathBuf>,
    /// Print the report as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Print the JSON Schema of a job
    #[arg(long, exclusive = true)]
    pub(crate) schema: bool,
    /// Format of standard output, or of the outputs in a folder, instead of write.to
    #[arg(long, value_name = "FORMAT", value_parser = extensions_and(&["vrm", "npz", "pkl", "csv", "qpos"]))]
    pub(crate) to: Option<String>,
    /// Do everything except writing. Print the assumptions, the changes, and the files that would be written, with
    /// their sizes
    #[arg(long)]
    pub(crate) dry_run: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Skip unchanged motions that the manifest lists with the same job
    #[arg(long)]
    pub(crate) resume: bool,
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    #[command(flatten)]
    pub(crate) spread: SpreadArgs,
}

/// Options to run without writing.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Instead of writing")]
pub(crate) struct InsteadArgs {
    /// Print the job of the arguments, for `mocap run` and for programs, and do nothing else
    #[arg(long, conflicts_with = "dry_run")]
    pub(crate) print_job: bool,
    /// Do everything except writing. Print the assumptions, the changes, and the files that would be written, with
    /// their sizes
    #[arg(long)]
    pub(crate) dry_run: bool,
}
