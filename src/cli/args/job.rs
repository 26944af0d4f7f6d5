//! The job of a command line.

use std::path::{Path, PathBuf};

use mocap::convert::RootMotion;
use mocap::job::{MotionJob, SourceMap, SourceSpace, Sources};

use super::ConvertArgs;
use super::write::writing;

/// The root motion that the two switches select.
pub(super) fn root_motion(in_place: bool, root_motion: bool) -> RootMotion {
    match (in_place, root_motion) {
        (true, _) => RootMotion::InPlace,
        (false, true) => RootMotion::Extract,
        (false, false) => RootMotion::Keep,
    }
}

impl ConvertArgs {
    /// The job, with an output of the format of `extension`.
    pub(crate) fn job(&self, inputs: &[PathBuf], output: &Path, extension: &str) -> MotionJob {
        let mut job = MotionJob::default();
        job.read = self.read.clone();
        job.source = sources(inputs, &self.source, &self.map);
        job.source.frames = self.change.frames.clone();
        job.source.frames.root = root_motion(self.change.in_place, self.change.root_motion);
        job.steps.clone_from(&self.steps);
        job.weights = self.weights.weights();
        job.write = writing(&self.write, output, extension, self.force);
        job.verify = self.verify;
        job
    }
}

pub(super) fn sources(inputs: &[PathBuf], space: &SourceSpace, map: &SourceMap) -> Sources {
    let mut sources = Sources::default();
    sources.inputs = inputs.to_vec();
    sources.space = space.clone();
    sources.map = map.clone();
    sources
}
