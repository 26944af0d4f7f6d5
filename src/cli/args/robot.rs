//! The options of `mocap robot`.

use std::path::PathBuf;

use mocap::job::{InputOptions, JobTarget, MotionJob, RobotFormat, RobotTarget};

use super::onto::OntoArgs;
use super::write::extensions_and;
use crate::streams;

/// The names of the formats of a robot's joints.
const ROBOT_FORMATS: [&str; RobotFormat::ALL.len()] = {
    let mut names = [""; RobotFormat::ALL.len()];
    let mut index = 0;
    while index < names.len() {
        names[index] = RobotFormat::ALL[index].name();
        index += 1;
    }
    names
};

#[derive(Clone, Debug, clap::Args)]
pub(crate) struct RobotArgs {
    /// The files with human motion. If the output is a folder: also folders and wildcards
    #[arg(required = true, value_name = "INPUT")]
    pub(crate) paths: Vec<PathBuf>,
    /// The robot: a .urdf file, or a MuJoCo .xml file; repeatable. With several robots, the output has one
    /// subfolder for each, with the robot's name
    #[arg(long, required = true, value_name = "TARGET")]
    pub(crate) robot: Vec<PathBuf>,
    /// The file to write, or - for standard output; for several motions, a folder. .npz (NumPy), .pkl (a pickle, as GMR
    /// writes) and .csv have the position of every joint. .glb and the other formats of mocap formats have the links of
    /// the robot as an animated skeleton
    #[arg(short, long, value_name = "OUTPUT")]
    pub(crate) output: PathBuf,
    /// Format of the outputs. qpos is an .npz for MuJoCo, with rotations as w x y z. dynamics also has velocities,
    /// accelerations and the forces of inverse dynamics. gmr, unitree-csv, mjlab, beyondmimic, isaaclab, protomotions,
    /// mimickit, twist, asap and max are the files that these programs load [default: the extension of the output, else
    /// npz]
    #[arg(long, value_name = "FORMAT", value_parser = extensions_and(&ROBOT_FORMATS))]
    pub(crate) to: Option<String>,
    #[command(flatten)]
    target: RobotTarget,
    /// Write the reports of many motions to this .parquet file, one row for each motion. With --shard 1/8, x.parquet
    /// becomes x.1-of-8.parquet. With several robots, each robot gets a table, such as x.g1.parquet for g1.urdf
    #[arg(long, value_name = "FILE")]
    pub(crate) report: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) onto: OntoArgs,
    #[command(flatten)]
    pub(crate) read: InputOptions,
    /// Whether there are several robots.
    #[arg(skip)]
    is_of_several: bool,
}

impl RobotArgs {
    /// Whether the output is a folder: for several motions, for a folder of motions, or if the output's name is not a
    /// file name.
    pub(crate) fn is_many(&self) -> bool {
        let is_one = matches!(&self.paths[..], [path] if !path.is_dir()) && !self.is_of_several;
        let is_file = streams::is_unnamed(&self.output) || self.output.extension().is_some();
        !(is_one && is_file) || self.output.is_dir()
    }
}

impl RobotArgs {
    /// The arguments for each of several robots, with the name of the robot's folder.
    pub(crate) fn of_each_robot(&self) -> Vec<Self> {
        let of_robot = |robot: &PathBuf| {
            let name = robot.file_stem().unwrap_or_default();
            let report = self.report.as_ref().map(|report| {
                let extension = report.extension().unwrap_or_default();
                report.with_extension(format!("{}.{}", name.display(), extension.display()))
            });
            Self {
                robot: vec![robot.clone()],
                output: self.output.join(name),
                report,
                is_of_several: true,
                ..self.clone()
            }
        };
        self.robot.iter().map(of_robot).collect()
    }

    /// The job, with outputs in a format, for the first robot.
    pub(crate) fn job(&self, format: &str) -> MotionJob {
        let mut target = self.target.clone();
        target.file.clone_from(&self.robot[0]);
        let mut job = MotionJob::default();
        job.read = self.read.clone();
        job.source = self.onto.sources(&self.paths);
        let rate = RobotFormat::named(format).and_then(RobotFormat::rate);
        job.source.frames.fps = job.source.frames.fps.or(rate);
        job.target = Some(JobTarget::Robot(target));
        let folder = self.output.join("");
        let output = if self.is_many() { &folder } else { &self.output };
        job.weights = self.onto.weights.weights();
        job.write = self.onto.writing(output, format);
        job
    }
}
