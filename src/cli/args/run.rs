//! The options of `mocap run`, and what other commands do instead of writing: `--print-job`, `--dry-run`.

use std::path::PathBuf;

use super::ForceArgs;
use super::write::extensions_and;
use crate::batch::inputs::InputArgs;
use crate::batch::spread::SpreadArgs;

#[derive(Debug, clap::Args)]
pub(crate) struct RunArgs {
    /// The job: a JSON file, or - for standard input; paths in it are relative to the current folder. Where its output
    /// is a folder, each motion of its inputs gets an output, and inputs may be folders and wildcards
    #[arg(required_unless_present = "schema", value_name = "INPUT")]
    pub(crate) job: Option<PathBuf>,
    /// Print what was done as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Print the JSON Schema of a job
    #[arg(long, exclusive = true)]
    pub(crate) schema: bool,
    /// Format of standard output, or of the outputs in a folder, instead of write.to
    #[arg(long, value_name = "FORMAT", value_parser = extensions_and(&["vrm", "npz", "pkl", "csv", "qpos"]))]
    pub(crate) to: Option<String>,
    /// Do everything but write: say what is assumed, what changes, and which files would be written, with their sizes
    #[arg(long)]
    pub(crate) dry_run: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Skip motions that were made by the same job, according to the manifest, and are unchanged
    #[arg(long)]
    pub(crate) resume: bool,
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    #[command(flatten)]
    pub(crate) spread: SpreadArgs,
}

/// What a command that does a job does instead of writing.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Instead of writing")]
pub(crate) struct InsteadArgs {
    /// Print the job of the arguments, for `mocap run` and for programs, and do nothing else
    #[arg(long, conflicts_with = "dry_run")]
    pub(crate) print_job: bool,
    /// Do everything but write: say what is assumed, what changes, and which files would be written, with their sizes
    #[arg(long)]
    pub(crate) dry_run: bool,
}
