//! What the commands have in common that change motions on their own skeletons.

use std::path::PathBuf;

use mocap::convert::FirstFrame;
use mocap::edit::EditStep;
use mocap::job::{InputOptions, MotionJob, OutputOptions, SourceMap, SourceSpace};

use super::batch::is_folder;
use super::job::sources;
use super::write::writing;
use super::{ForceArgs, InsteadArgs, OutputFormat, WeightsArgs};
use crate::batch::inputs::InputArgs;
use crate::batch::spread::SpreadArgs;

#[derive(Debug, clap::Args)]
pub(crate) struct OwnArgs {
    /// The file to write, in any format of mocap formats, or - for standard output. If it is a folder, or ends in /,
    /// each motion gets a file of its own in it, beside a manifest
    #[arg(short, long, value_name = "OUTPUT")]
    pub(crate) output: PathBuf,
    /// Format of standard output or of the outputs in a folder, or the layout of arrays [default: glb]
    #[arg(long, value_name = "FORMAT")]
    pub(crate) to: Option<OutputFormat>,
    /// Frames per second of the motions before they are changed, at the same speed; for an input that states no valid
    /// rate, its rate. The step resample of edit does it later
    #[arg(long, value_name = "RATE", value_parser = InputOptions::parse_rate)]
    pub(crate) fps: Option<f64>,
    /// Compare the written file with its source, changed again, as `mocap verify` does
    #[arg(long)]
    pub(crate) verify: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Skip motions that were changed in the same steps, according to the manifest, and are unchanged
    #[arg(long)]
    pub(crate) resume: bool,
    #[command(flatten)]
    pub(crate) weights: WeightsArgs,
    #[command(flatten)]
    pub(crate) write: OutputOptions,
    #[command(flatten)]
    pub(crate) source: SourceSpace,
    #[command(flatten)]
    pub(crate) map: SourceMap,
    #[command(flatten)]
    pub(crate) read: InputOptions,
    #[command(flatten)]
    pub(crate) many: InputArgs,
    #[command(flatten)]
    pub(crate) spread: SpreadArgs,
    #[command(flatten)]
    pub(crate) instead: InsteadArgs,
}

impl OwnArgs {
    /// Whether the output is a folder, with an output of each motion.
    pub(crate) fn is_many(&self) -> bool {
        is_folder(&self.output)
    }

    /// The job that does these steps, with an output of the format of `extension`.
    pub(super) fn job(
        &self,
        motions: &[PathBuf],
        with: Vec<PathBuf>,
        steps: Vec<EditStep>,
        extension: &str,
    ) -> MotionJob {
        let mut job = MotionJob::default();
        job.read = self.read.clone();
        job.source = sources(motions, &self.source, &self.map);
        job.source.with = with;
        // A rest pose before the motion is no part of it: a filter or a seam would mix it in.
        job.source.frames.drop_first_frame = FirstFrame::DropRestPose;
        job.source.frames.fps = self.fps;
        job.steps = steps;
        job.weights = self.weights.weights();
        job.write = writing(&self.write, &self.output, extension, self.force);
        job.verify = self.verify;
        job
    }
}
