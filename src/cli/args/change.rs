//! The options of `mocap convert` that change a motion.

use mocap::job::{JobWeights, SourceFrames};

/// Changes of the motion.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Changing")]
pub(crate) struct ChangeArgs {
    #[command(flatten)]
    pub(crate) frames: SourceFrames,
    /// Keep the figure in place: remove its horizontal translation
    #[arg(long, conflicts_with = "root_motion")]
    pub(crate) in_place: bool,
    /// Move the horizontal translation and the heading to a new joint `Root`
    #[arg(long)]
    pub(crate) root_motion: bool,
}

/// The weights of solvers.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Changing")]
pub(crate) struct WeightsArgs {
    /// Weights of the solvers that differ from their defaults: a JSON file such as {"robot": {"hand": 1}, "clean": {},
    /// "foot-lock": {}, "markers": {}}; docs/weights.md lists them
    #[arg(long, value_name = "FILE", value_parser = JobWeights::parse_file)]
    weights: Option<JobWeights>,
}

impl WeightsArgs {
    /// The weights, in the form of a job.
    pub(crate) fn weights(&self) -> JobWeights {
        self.weights.clone().unwrap_or_default()
    }
}
