//! `mocap robot` of many motions: into a folder, with a manifest.

use std::path::{Path, PathBuf};

use mocap::files::ReplacePolicy;
use mocap::job::RobotFormat;
use mocap::retargeting::Retargeting;
use mocap::robot::RobotReport;

use super::robot::{import_robot, is_good_enough, moved};
use super::robot_reports;
use crate::args::{Given, RobotArgs};
use crate::batch::folder::{Made, Many, Work, verdicts};
use crate::batch::hash::sha256;
use crate::batch::manifest::Record;
use crate::batch::outputs::Output;
use crate::batch::progress::Counts;
use crate::{Failure, report};

pub(crate) fn run(args: &RobotArgs, given: &Given) -> Result<(), Failure> {
    let robot = import_robot(args)?;
    let folder = args.output.as_path();
    if args.json {
        let message = "--json prints the report of one motion; the manifest in the folder has those of many";
        return Err(Failure::Usage(message.to_owned()));
    }
    if RobotFormat::of_output(folder).is_some() && !folder.is_dir() {
        let message = "several motions go into a folder, and this is the name of a file: name a folder";
        return Err(Failure::Usage(format!("{}: {message}", folder.display())));
    }
    let format = args.to.unwrap_or(RobotFormat::Npz);
    let hash = sha256(&args.robot).map_err(|error| Failure::Folder(args.robot.clone(), error))?;
    let many = Many {
        paths: &args.paths,
        folder,
        others: std::slice::from_ref(&args.robot),
        inputs: &args.inputs,
        spread: &args.spread,
        resume: args.resume,
        force: args.force,
        options: format!("{} to={} robot-sha256={hash}", given.options, format.name()),
    };
    many.run(&mut OnRobots {
        args,
        robot,
        format,
        table: None,
    })
}

struct OnRobots<'a> {
    args: &'a RobotArgs,
    /// The robot, without a motion yet.
    robot: Retargeting,
    format: RobotFormat,
    /// The table of the reports, where one is asked for.
    table: Option<PathBuf>,
}

impl Work for OnRobots<'_> {
    fn extension(&self) -> &str {
        self.format.extension()
    }

    fn check(&mut self, policy: &ReplacePolicy) -> Result<(), Failure> {
        self.table = robot_reports::path(self.args, policy)?;
        Ok(())
    }

    fn make(&self, file: &Path, output: &Output<'_>, record: &mut Record) -> Result<Made, String> {
        let moved = moved(self.args, &self.robot, file).map_err(Failure::into_words)?;
        let bytes = moved.bytes(self.format).map_err(|error| error.to_string())?;
        output.write(&bytes).map_err(|error| error.to_string())?;
        record.robot = serde_json::value::to_raw_value(moved.report()).ok();
        record.warnings = moved.said;
        Ok(Made::Done)
    }

    fn is_complete(&self, former: &Record) -> bool {
        former.robot_report().is_some()
    }

    fn summary(&self, records: &[&Record]) -> Vec<String> {
        let found = reports(records);
        let found = found.iter().map(|report| report.verdict);
        Vec::from_iter(verdicts("motions on the robot", found))
    }

    fn finish(&self, records: &[&Record], counts: &Counts) -> Result<(), Failure> {
        if let Some(path) = &self.table {
            robot_reports::write(path, records.iter().copied())?;
        }
        counts.verdict()?;
        let found = reports(records);
        let worse = found.iter().filter(|report| !is_good_enough(report, self.args.require));
        match worse.count() {
            0 => Ok(()),
            worse => {
                report::say(&format!(
                    "error: {worse} of {} motions are worse than --require allows",
                    found.len()
                ));
                Err(Failure::Told)
            }
        }
    }
}

/// Those of motions that were put on the robot before, too.
fn reports(records: &[&Record]) -> Vec<RobotReport> {
    records.iter().filter_map(|record| record.robot_report()).collect()
}
