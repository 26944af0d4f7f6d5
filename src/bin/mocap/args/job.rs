//! The job that a command line means.

use std::path::{Path, PathBuf};

use mocap::convert::{FirstFrame, RootMotion};
use mocap::edit::EditStep;
use mocap::figure::HumanoidMap;
use mocap::job::{BoneMap, Job, Onto, OntoBody, OntoRobot, RobotFormat, SourceMap, Sources};

use super::{ConvertArgs, EditArgs, RetargetArgs, RobotArgs};
use crate::Failure;

impl ConvertArgs {
    /// The job of one file.
    pub(crate) fn job(&self, input: &Path, output: &Path, extension: &str) -> Job {
        let mut job = Job::new();
        job.read = self.read.clone();
        job.source.inputs = vec![input.to_owned()];
        job.source.space = self.source.clone();
        job.source.map = self.map.clone();
        job.source.frames = self.change.frames.clone();
        job.source.frames.root = match (self.change.in_place, self.change.root_motion) {
            (true, _) => RootMotion::InPlace,
            (false, true) => RootMotion::Extract,
            (false, false) => RootMotion::Keep,
        };
        job.write.output = output.to_owned();
        job.write.to = named(output, extension);
        job.write.force = self.force;
        job.write.verify = self.verify;
        job.write.space = self.change.out.clone();
        job.write.mesh = self.mesh;
        job.write.embed = self.embed;
        self.write.fill(&mut job.write);
        job
    }
}

impl EditArgs {
    /// The job; contacts and curves, which are drawn beside it, are no part of it.
    pub(crate) fn job(&self, extension: &str) -> Result<Job, Failure> {
        if self.contacts.is_some() || self.curves.is_some() {
            let message = "--print-job: --contacts and --curves are no part of a job; leave them out";
            return Err(Failure::Usage(message.to_owned()));
        }
        let mut job = Job::new();
        job.read = self.read.reading();
        let mut inputs = self.inputs.iter().cloned();
        job.source.inputs = inputs.by_ref().take(1).collect();
        job.source.with = inputs.collect();
        job.source.space = self.source.clone();
        job.source.map = self.map.clone();
        job.source.frames.drop_first_frame = FirstFrame::DropRestPose;
        job.steps = self.steps.0.iter().map(EditStep::clone).collect();
        job.write.output.clone_from(&self.output);
        job.write.to = named(&self.output, extension);
        job.write.force = self.force;
        self.fbx.fill(&mut job.write);
        Ok(job)
    }
}

impl RetargetArgs {
    /// The job of motions on the character of a file.
    pub(crate) fn job(&self, motions: &[PathBuf], file: &Path, extension: &str) -> Job {
        let mut body = OntoBody::new(file);
        body.map = here(self.character_map.as_ref());
        body.scale = self.scale;
        body.feet = self.feet;
        body.replace_animations = self.replace_animations;
        body.max_angle = self.max_angle;
        let mut job = Job::new();
        job.read = self.read.reading();
        job.source = sources(motions, &self.source, &self.map);
        job.onto = Some(match self.to_skeleton {
            Some(_) => Onto::Skeleton(body),
            None => Onto::Character(body),
        });
        job.write.output.clone_from(&self.output);
        job.write.to = named(&self.output, extension);
        job.write.force = self.force;
        self.fbx.fill(&mut job.write);
        job
    }
}

impl RobotArgs {
    /// The job of one motion.
    pub(crate) fn job(&self, format: RobotFormat) -> Job {
        let mut robot = OntoRobot::new(&self.robot);
        robot.map = here(self.robot_map.as_ref());
        robot.scale = self.scale;
        robot.feet = self.feet;
        robot.velocity_limits = self.velocity_limits;
        robot.require = self.require;
        let mut job = Job::new();
        job.read = self.read.clone();
        job.source = sources(&self.paths, &self.source, &self.map);
        job.source.frames.trim = self.trim;
        job.source.frames.fps = self.fps;
        job.onto = Some(Onto::Robot(robot));
        job.write.output.clone_from(&self.output);
        job.write.to = named(&self.output, format.name());
        job.write.force = self.force;
        job
    }
}

fn sources(inputs: &[PathBuf], space: &mocap::job::SourceSpace, map: &SourceMap) -> Sources {
    let mut sources = Sources::default();
    sources.inputs = inputs.to_vec();
    sources.space = space.clone();
    sources.map = map.clone();
    sources
}

/// The format of an output whose extension is not its name.
fn named(output: &Path, name: &str) -> Option<String> {
    let extension = output.extension().unwrap_or_default();
    (!extension.eq_ignore_ascii_case(name)).then(|| name.to_owned())
}

fn here(map: Option<&HumanoidMap>) -> Option<BoneMap> {
    map.cloned().map(BoneMap::Bones)
}
