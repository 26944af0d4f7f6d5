//! The options of commands that retarget motions.

use std::path::{Path, PathBuf};

use mocap::convert::TimeRange;
use mocap::job::{InputOptions, OutputOptions, SourceMap, SourceSpace, Sources};

use super::job::{root_motion, sources};
use super::write::writing;
use super::{ForceArgs, InsteadArgs, WeightsArgs};
use crate::batch::inputs::InputArgs;
use crate::batch::spread::SpreadArgs;

#[derive(Clone, Debug, clap::Args)]
pub(crate) struct OntoArgs {
    /// Resample to this number of frames per second, at the same playback speed. For an input without a valid rate, set
    /// its rate [default: the rate of the motion]
    #[arg(long, value_name = "RATE", value_parser = InputOptions::parse_rate)]
    fps: Option<f64>,
    /// Part to keep, both ends included: A..B in seconds, or Af..Bf in frames; either end is optional
    #[arg(long, value_name = "A..B", allow_hyphen_values = true)]
    trim: Option<TimeRange>,
    /// Keep the figure in place: remove its horizontal translation
    #[arg(long, conflicts_with = "root_motion")]
    in_place: bool,
    /// Move the horizontal translation and the heading of the hips to their highest ancestor
    #[arg(long)]
    root_motion: bool,
    /// Print the report of one output as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Skip unchanged motions that the manifest lists with the same options
    #[arg(long)]
    pub(crate) resume: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    #[command(flatten)]
    pub(crate) weights: WeightsArgs,
    #[command(flatten)]
    pub(crate) write: OutputOptions,
    #[command(flatten)]
    pub(crate) source: SourceSpace,
    #[command(flatten)]
    pub(crate) map: SourceMap,
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    #[command(flatten)]
    pub(crate) spread: SpreadArgs,
    #[command(flatten)]
    pub(crate) instead: InsteadArgs,
}

impl OntoArgs {
    /// The motions, with the user's statements about them.
    pub(super) fn sources(&self, motions: &[PathBuf]) -> Sources {
        let mut sources = sources(motions, &self.source, &self.map);
        sources.frames.fps = self.fps;
        sources.frames.trim = self.trim;
        sources.frames.root = root_motion(self.in_place, self.root_motion);
        sources
    }

    /// An output in the format of `extension`.
    pub(super) fn writing(&self, output: &Path, extension: &str) -> OutputOptions {
        writing(&self.write, output, extension, self.force)
    }
}
