//! The options of commands that put motions on another body.

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
    /// Frames per second to write, at the same speed; for an input that states no valid rate, its rate [default: those
    /// of the motion]
    #[arg(long, value_name = "RATE", value_parser = InputOptions::parse_rate)]
    fps: Option<f64>,
    /// Part to keep, both ends included: A..B in seconds, or Af..Bf in frames; either end may be left out
    #[arg(long, value_name = "A..B", allow_hyphen_values = true)]
    trim: Option<TimeRange>,
    /// Keep the figure in place over the ground
    #[arg(long, conflicts_with = "root_motion")]
    in_place: bool,
    /// Move the translation over the ground and the heading of the hips to the uppermost node above them
    #[arg(long)]
    root_motion: bool,
    /// Print the report of one output as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Skip motions that were made with the same options, according to the manifest, and are unchanged
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
    /// The motions, and what is known of them.
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
