//! `mocap robot` of many motions: into a folder, with a manifest.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

use mocap::files::{ReplacePolicy, write_file};
use mocap::retarget::Verdict;
use mocap::retargeting::Retargeting;
use mocap::robot::RobotReport;

use super::convert_many::{KnownOutputs, name_outputs, remove_unfinished, summary, tell_failures};
use super::robot::{import_robot, is_good_enough, moved};
use super::robot_reports;
use crate::args::{Given, RobotArgs, RobotFormatArg};
use crate::batch::hash::sha256;
use crate::batch::inputs::{self, Input};
use crate::batch::manifest::{Manifest, Record};
use crate::batch::progress::{Outcome, Progress};
use crate::batch::{self, thread_count};
use crate::{Failure, report};

struct Run<'a> {
    args: &'a RobotArgs,
    robot: &'a Retargeting,
    folder: &'a Path,
    format: RobotFormatArg,
    /// The options and the robot as text, for the manifest.
    options: String,
    outputs: HashMap<String, String>,
    former: BTreeMap<String, Record>,
    policy: ReplacePolicy,
}

pub(crate) fn run(args: &RobotArgs, given: &Given) -> Result<(), Failure> {
    let robot = &import_robot(args)?;
    let (folder, spread) = (args.output.as_path(), &args.spread);
    let in_folder = |error: io::Error| Failure::Folder(folder.to_owned(), error);
    if args.json {
        let message = "--json prints the report of one motion; the manifest in the folder has those of many";
        return Err(Failure::Usage(message.to_owned()));
    }
    if RobotFormatArg::of(folder).is_some() && !folder.is_dir() {
        let message = "several motions go into a folder, and this is the name of a file: name a folder";
        return Err(Failure::Usage(format!("{}: {message}", folder.display())));
    }
    let format = args.to.unwrap_or(RobotFormatArg::Npz);
    let known = KnownOutputs::of(folder);
    let is_robot = |path: &Path| path == args.robot;
    let mut inputs = inputs::find_except(&args.paths, &args.inputs, |path| known.has(path) || is_robot(path))?;
    let outputs = name_outputs(&inputs, format.extension())?;
    let policy = ReplacePolicy::new(inputs.iter().map(|input| &input.path).chain([&args.robot])).force(args.force);
    let reports = robot_reports::path(args, &policy)?;
    inputs.retain(|input| spread.shard.is_none_or(|shard| shard.has(input)));
    fs::create_dir_all(folder).map_err(in_folder)?;
    let names: HashSet<&str> = inputs.iter().map(|input| input.relative.as_str()).collect();
    let is_input = |input: &str| names.contains(input);
    let mut manifest = Manifest::open(folder, spread.shard, Some(&is_input)).map_err(in_folder)?;
    let hash = sha256(&args.robot).map_err(|error| Failure::Folder(args.robot.clone(), error))?;
    let run = Run {
        args,
        robot,
        folder,
        format,
        options: format!("{} to={} robot-sha256={hash}", given.options, format.name()),
        outputs,
        former: manifest.records().clone(),
        policy,
    };
    let mut progress = Progress::new(spread.progress(), &inputs);
    let mut failures = Vec::new();
    let work = |input: &Input| run.one(input);
    let panicked = |input: &Input| {
        let mut record = Record::new(input, &run.options);
        record.error = Some(batch::PANICKED.to_owned());
        (Outcome::Failed, Some(record))
    };
    let add = |index: usize, (outcome, record): (Outcome, Option<Record>)| {
        progress.add(&inputs[index], outcome);
        let Some(record) = record else { return Ok(()) };
        if let Some(error) = &record.error {
            failures.push((record.input.clone(), error.clone()));
        }
        manifest.add(record)
    };
    batch::for_each(&inputs, thread_count(spread.threads), work, panicked, add).map_err(in_folder)?;
    let own = inputs.iter().filter_map(|input| run.outputs.get(&input.relative));
    let own = own.map(|output| folder.join(output));
    let own: Vec<PathBuf> = own.chain([Manifest::path(folder, spread.shard)]).collect();
    remove_unfinished(folder, own.into_iter()).map_err(in_folder)?;
    let counts = progress.finish();
    let records = manifest.records().clone();
    manifest.finish(is_input).map_err(in_folder)?;
    // Those that were put on the robot before, too.
    let records = || records.values().filter(|record| is_input(&record.input));
    let found: Vec<RobotReport> = records().filter_map(Record::robot_report).collect();
    if !spread.quiet {
        report::say(&summary(&counts));
        let verdicts = [Verdict::Good, Verdict::Fair, Verdict::Poor].map(|verdict| {
            let count = found.iter().filter(|report| report.verdict == verdict).count();
            format!("{count} {}", verdict.as_str())
        });
        if !found.is_empty() {
            report::say(&format!("motions on the robot: {}", verdicts.join(", ")));
        }
        tell_failures(failures);
    }
    if let Some(path) = &reports {
        robot_reports::write(path, records())?;
    }
    counts.verdict()?;
    let worse = found.iter().filter(|report| !is_good_enough(report, args.require));
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

impl Run<'_> {
    /// Puts a motion on the robot.
    fn one(&self, input: &Input) -> (Outcome, Option<Record>) {
        let start = Instant::now();
        let mut record = Record::new(input, &self.options);
        match self.fill(input, &mut record) {
            Ok(Outcome::Skipped) => (Outcome::Skipped, None),
            Ok(outcome) => {
                record.seconds = start.elapsed().as_secs_f64();
                (outcome, Some(record))
            }
            Err(error) => {
                record.error = Some(error);
                record.seconds = start.elapsed().as_secs_f64();
                (Outcome::Failed, Some(record))
            }
        }
    }

    fn fill(&self, input: &Input, record: &mut Record) -> Result<Outcome, String> {
        let in_file = |path: &Path, error: io::Error| format!("{}: {error}", path.display());
        let file = input.path().map_err(|error| error.to_string())?;
        record.sha256 = Some(sha256(file).map_err(|error| in_file(file, error))?);
        let output = &self.outputs[&input.relative];
        let path = self.folder.join(output);
        let former = self.former.get(&record.input).filter(|_| self.args.resume);
        let is_done = former.is_some_and(|former| {
            former.error.is_none()
                && former.sha256 == record.sha256
                && former.options == record.options
                && former.version == record.version
                && former.output.as_deref() == Some(output)
                && former.robot_report().is_some()
        });
        if is_done && path.exists() {
            return Ok(Outcome::Skipped);
        }
        let moved = moved(self.args, self.robot, file).map_err(|failure| match failure {
            Failure::File(error) => error.to_string(),
            Failure::Usage(message) => message,
            _ => "the motion could not be read".to_owned(),
        })?;
        let folder = path.parent().unwrap_or(self.folder);
        if !folder.is_dir() {
            fs::create_dir_all(folder).map_err(|error| in_file(folder, error))?;
        }
        let bytes = moved.bytes(self.format).map_err(|error| error.to_string())?;
        self.policy
            .check_bytes(&path, &bytes)
            .map_err(|error| error.to_string())?;
        write_file(&path, &bytes).map_err(|error| error.to_string())?;
        record.output = Some(output.clone());
        record.robot = serde_json::value::to_raw_value(moved.report()).ok();
        record.warnings = moved.said;
        Ok(Outcome::Done)
    }
}
