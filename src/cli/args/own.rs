//! Shared options of the commands that change a motion but keep its skeleton.

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
    /// The file to write, in any format of mocap formats, or - for standard output. If OUTPUT is a folder, or ends in
    /// /, the folder gets one file for each motion, and a manifest
    #[arg(short, long, value_name = "OUTPUT")]
    pub(crate) output: PathBuf,
    /// Format of standard output or of the outputs in a folder, or the layout of arrays [default: glb]
    #[arg(long, value_name = "FORMAT")]
    pub(crate) to: Option<OutputFormat>,
    /// Resample the motions before the steps, at the same playback speed. For an input without a valid rate, set its
    /// rate. To resample later, use the step resample of edit
    #[arg(long, value_name = "RATE", value_parser = InputOptions::parse_rate)]
    pub(crate) fps: Option<f64>,
    /// Compare the written file with the source after the same changes, as `mocap verify` does
    #[arg(long)]
    pub(crate) verify: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Skip unchanged motions that the manifest lists with the same steps
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

    /// The job with these steps, and an output of the format of `extension`.
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
        // Drop a rest pose before the motion: a filter or a seam would blend the pose into the motion.
        job.source.frames.drop_first_frame = FirstFrame::DropRestPose;
        job.source.frames.fps = self.fps;
        job.steps = steps;
        job.weights = self.weights.weights();
        job.write = writing(&self.write, &self.output, extension, self.force);
        job.verify = self.verify;
        job
    }
}
