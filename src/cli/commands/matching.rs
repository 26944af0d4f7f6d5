//! `mocap match`: moves a character along a path, or by a gamepad, with motion matching.

use std::fmt;
use std::path::{Path, PathBuf};

use mocap::files::ReplacePolicy;
use mocap::glam::Vec3;
use mocap::matching::report::{FollowReport, PlayReport};
use mocap::matching::{Controller, Database, Gamepad, Moves};
use mocap::scene::Animation;
use mocap::{Conversion, Exporter, Format, FormatInfo, Importer, Scene};

use serde::Serialize;

use super::{Place, check_json, index, output_format, print_report};
use crate::args::{ArgumentSources, MatchArgs};
use crate::printed::OutputReport;
use crate::{Failure, kinds, report, streams};

pub(crate) fn run(args: &MatchArgs, given: &ArgumentSources) -> Result<(), Failure> {
    check_json(args.json, &args.output)?;
    let Some(report) = made(args, given)? else {
        return Ok(());
    };
    let output = &args.output;
    print_report(&OutputReport { output, report }, args.json, Place::Message)
}

/// Makes the output. Returns the output of `--json`.
pub(crate) fn summary(args: &MatchArgs, given: &ArgumentSources) -> Result<serde_json::Value, Failure> {
    let done = made(args, given)?;
    Ok(done.map_or_else(|| serde_json::json!({}), |done| super::value(&done)))
}

/// Makes the output. Returns the motion of the figure, if it follows a path or a gamepad.
fn made(args: &MatchArgs, given: &ArgumentSources) -> Result<Option<MatchOutcome>, Failure> {
    let (format, output) = match super::extension(&args.output).as_str() {
        // A `.bin` output is two files without a motion.
        "bin" => (None, args.output.clone()),
        _ => {
            let (format, named) = written_format(args)?;
            (Some(format), named)
        }
    };
    let database = index::read(&args.database)?;
    let clips = database.clips().iter().map(|clip| Path::new(&clip.row.file));
    let sticks = args.aim.gamepad.as_deref();
    let inputs = [args.database.as_path(), &args.on]
        .into_iter()
        .chain(sticks)
        .chain(clips);
    let policy = ReplacePolicy::new(inputs).force(args.force.force);
    if !streams::is_standard(&args.output) {
        policy.check(&args.output)?;
    }
    kinds::refuse_robot([args.on.as_path()])?;
    let mut hero = streams::import(&Importer::new().gltf_meshes(true), &args.on)?;
    Conversion::new()
        .apply(&mut hero)
        .map_err(|error| error.with_path(&args.on))?;
    let Some(format) = format else {
        write_bones(args, &moves(args, &database, &hero)?, &policy)?;
        return Ok(None);
    };
    if args.aim.is_nothing() {
        return Err(nothing_to_follow());
    }
    let moves = moves(args, &database, &hero)?;
    let (animation, done) = moved(args, &database, moves, &hero)?;
    hero.animations = vec![animation];
    let written = Exporter::new().format(format).write_as(&hero, &output)?;
    streams::save(&written, &args.output, &[], &policy, given.is_dry_run())?;
    Ok(Some(done))
}

/// The format of the output, and a name with its extension.
fn written_format(args: &MatchArgs) -> Result<(Format, PathBuf), Failure> {
    let extension = output_format(&args.output, args.to.as_deref(), "glb")?;
    let output = match streams::is_unnamed(&args.output) {
        true => Path::new("match").with_extension(&extension),
        false => args.output.clone(),
    };
    let Some(format) = FormatInfo::of_output(&output) else {
        let extensions = ".glb, .gltf, .bvh, .fbx or another written format, or in .bin";
        return Err(super::unknown_extension(&args.output, extensions));
    };
    Ok((format.format, output))
}

/// Writes the files of Holden's demo: the bones under the name of the output, and features.bin in the same folder.
fn write_bones(args: &MatchArgs, moves: &Moves, policy: &ReplacePolicy) -> Result<(), Failure> {
    if !args.aim.is_nothing() || args.json {
        let message = "a .bin output has the frames of the database, not a motion: omit --path, --gamepad \
                       and --json";
        return Err(Failure::Usage(message.to_owned()));
    }
    let beside = args.output.with_file_name("features.bin");
    if beside == args.output {
        let message =
            "mocap writes features.bin as a second file: use another name for the output, such as database.bin";
        return Err(Failure::Usage(message.to_owned()));
    }
    policy.check(&beside)?;
    let files = moves.to_holden().map_err(|error| error.with_path(&args.on))?;
    streams::write_all(&Vec::from_iter([&args.output, &beside].into_iter().zip(files)), policy)?;
    report::say(&format!("{} and {}", args.output.display(), beside.display()));
    Ok(())
}

/// The motion of a figure that followed a path or a gamepad.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub(crate) enum MatchOutcome {
    Followed(FollowReport),
    Played(PlayReport),
}

impl fmt::Display for MatchOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Followed(report) => report.fmt(f),
            Self::Played(report) => report.fmt(f),
        }
    }
}

fn nothing_to_follow() -> Failure {
    Failure::Usage("name a path with --path, or an input with --gamepad".to_owned())
}

/// Moves the figure along the path or by the gamepad.
fn moved(
    args: &MatchArgs,
    database: &Database,
    moves: Moves,
    hero: &Scene,
) -> Result<(Animation, MatchOutcome), Failure> {
    if let Some(path) = &args.aim.path {
        let [start, next] = [path.0[0], path.0[1]].map(|point| Vec3::new(point.x, 0.0, point.y));
        let forward = (next - start).normalize_or(Vec3::Z);
        let mut controller = Controller::new(database, moves, start, forward)?;
        let (animation, followed) = controller.follow(hero, &path.0, args.speed)?;
        return Ok((animation, MatchOutcome::Followed(followed)));
    }
    let gamepad = match &args.aim.gamepad {
        Some(file) => gamepad(file)?,
        None => return Err(nothing_to_follow()),
    };
    let mut controller = Controller::new(database, moves, Vec3::ZERO, Vec3::Z)?;
    let (animation, played) = controller.play(hero, &gamepad, args.speed)?;
    Ok((animation, MatchOutcome::Played(played)))
}

/// The frames of the database, retargeted to the character.
fn moves(args: &MatchArgs, database: &Database, hero: &Scene) -> Result<Moves, Failure> {
    let importer = args.read.importer().with_own_meshes();
    let moves = Moves::of(database, hero, |file| streams::import(&importer, Path::new(file)));
    Ok(moves.map_err(|error| error.with_path(&args.on))?)
}

/// The largest file of a gamepad, in bytes: more than an hour at 1000 samples per second.
const LARGEST_GAMEPAD: u64 = 1 << 28;

/// The stick positions of a file.
fn gamepad(file: &Path) -> Result<Gamepad, Failure> {
    let text = streams::text(file, LARGEST_GAMEPAD)?;
    Ok(Gamepad::parse(&text).map_err(|error| error.with_path(file))?)
}
