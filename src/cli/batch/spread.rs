//! How a command distributes the work on many files.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use super::progress::ProgressArg;
use super::shard::Shard;
use crate::{report, streams};

/// How to distribute the work.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Many files")]
pub(crate) struct SpreadArgs {
    /// Number of threads [default: the number of cores]
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<NonZeroUsize>,
    /// Process only part i of n. The parts depend only on the relative paths of the files
    #[arg(long, value_name = "i/n")]
    pub(crate) shard: Option<Shard>,
    /// How to show progress on standard error
    #[arg(long, value_name = "KIND", default_value = "auto")]
    progress: ProgressArg,
}

impl SpreadArgs {
    /// The name of this shard's output: `survey.2-of-8.jsonl`.
    pub(crate) fn of_shard(&self, output: &Path) -> PathBuf {
        match (self.shard, output.extension()) {
            (Some(shard), Some(extension)) if !streams::is_standard(output) => {
                output.with_extension(format!("{}.{}", shard.name(), extension.display()))
            }
            _ => output.to_owned(),
        }
    }

    pub(crate) fn progress(&self) -> ProgressArg {
        if report::is_quiet() {
            ProgressArg::None
        } else {
            self.progress
        }
    }
}
