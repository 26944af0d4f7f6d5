//! `mocap score`: measures how close a robot's motion is to its reference.

use std::fmt;

use mocap::job::BoneMap;
use mocap::retarget::robot::RobotMotion;
use mocap::retarget::robot::report::RobotReport;
use mocap::retarget::{RetargetOptions, Retargeter};
use mocap::{Importer, Scene};
use serde::Serialize;

use super::{Place, import_motion, print_report};
use crate::args::ScoreArgs;
use crate::{Failure, report, streams};

/// A report whose text includes the scores. The text of a plain report lacks them.
#[derive(Serialize)]
#[serde(transparent)]
struct Scored(RobotReport);

impl fmt::Display for Scored {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)?;
        let Some(scores) = &self.0.scores else { return Ok(()) };
        for line in scores.to_string().lines() {
            write!(f, "\n{}: {line}", self.0.clip)?;
        }
        Ok(())
    }
}

pub(crate) fn run(args: &ScoreArgs) -> Result<(), Failure> {
    print_report(&Scored(scored(args)?), args.json, Place::Result)
}

/// The answer for an agent.
pub(crate) fn result(args: &ScoreArgs) -> Result<serde_json::Value, Failure> {
    Ok(super::value(&scored(args)?))
}

fn scored(args: &ScoreArgs) -> Result<RobotReport, Failure> {
    let robot = Importer::new().import_robot(&args.robot)?;
    report::warnings(Some(&args.robot), &robot.warnings);
    let scene = streams::import(&Importer::new().body(&args.robot), &args.output)?;
    let motion = RobotMotion::of_arrays(&robot, &scene).map_err(|error| error.with_path(&args.output))?;
    let mut reference: Scene = import_motion(&args.read, &args.source)?;
    report::warnings(Some(&args.source), &args.space.contradictions(&reference));
    args.space.state(&mut reference);
    let bones = args.map.map.as_ref().map(BoneMap::bones).transpose()?;
    let options = RetargetOptions::new().source_bones(bones.unwrap_or_default());
    let found = Retargeter::onto(robot, options)?.judge(reference, &motion);
    Ok(found.map_err(|error| error.with_path(&args.source))?)
}
