//! The job that a command line means.

use std::path::{Path, PathBuf};

use mocap::convert::RootMotion;
use mocap::job::{Job, Onto, RobotFormat, SourceMap, SourceSpace, Sources};

use super::{ConvertArgs, RetargetArgs, RobotArgs};

/// What two switches mean.
pub(super) fn root_motion(in_place: bool, root_motion: bool) -> RootMotion {
    match (in_place, root_motion) {
        (true, _) => RootMotion::InPlace,
        (false, true) => RootMotion::Extract,
        (false, false) => RootMotion::Keep,
    }
}

impl ConvertArgs {
    /// The job, with an output of the format of `extension`.
    pub(crate) fn job(&self, inputs: &[PathBuf], output: &Path, extension: &str) -> Job {
        let mut job = Job::new();
        job.read = self.read.clone();
        job.source = sources(inputs, &self.source, &self.map);
        job.source.frames = self.change.frames.clone();
        job.source.frames.root = root_motion(self.change.in_place, self.change.root_motion);
        job.steps.clone_from(&self.steps);
        self.write.fill(&mut job.write, output, extension);
        job.write.force = self.force.force;
        job.write.verify = self.verify;
        job
    }
}

impl RetargetArgs {
    /// The job of motions on the character of a file, with an output of the format of `extension`.
    pub(crate) fn job(&self, motions: &[PathBuf], file: &Path, extension: &str) -> Job {
        let mut body = self.onto.body(file, self.character_map.as_ref());
        body.replace_animations = self.replace_animations;
        body.names_of_clips.clone_from(&self.names_of_clips);
        body.max_angle = self.max_angle;
        let mut job = Job::new();
        job.read = self.read.clone();
        job.source = self.onto.sources(motions);
        job.onto = Some(match self.to_skeleton {
            Some(_) => Onto::Skeleton(body),
            None => Onto::Character(body),
        });
        self.onto.write.fill(&mut job.write, &self.output, extension);
        job.write.force = self.onto.force.force;
        job
    }
}

impl RobotArgs {
    /// The job, with outputs in a format.
    pub(crate) fn job(&self, format: &str) -> Job {
        let mut body = self.onto.body(&self.robot, self.robot_map.as_ref());
        body.velocity_limits = self.velocity_limits;
        body.passes = self.passes;
        body.floor = self.floor;
        body.require = self.require;
        let mut job = Job::new();
        job.read = self.read.clone();
        job.source = self.onto.sources(&self.paths);
        let rate = RobotFormat::named(format).and_then(RobotFormat::rate);
        job.source.frames.fps = job.source.frames.fps.or(rate);
        job.onto = Some(Onto::Robot(body));
        let folder = self.output.join("");
        let output = if self.is_many() { &folder } else { &self.output };
        self.onto.write.fill(&mut job.write, output, format);
        job.write.force = self.onto.force.force;
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
