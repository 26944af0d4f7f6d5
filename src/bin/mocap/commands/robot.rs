//! `mocap robot`: motions on a robot.

use std::path::Path;

use mocap::files::ReplacePolicy;
use mocap::job::{Feet, RequiredVerdict, RobotFormat};
use mocap::retargeting::{Retargeting, RetargetingOptions};
use mocap::robot::RobotReport;
use mocap::{Conversion, Importer, Scene, SkeletonMesh};

use super::{check_json, import_to_resample, print_json, run as job, unknown_extension, write_output};
use crate::args::{Given, RobotArgs};
use crate::{Failure, report, streams};

pub(crate) fn run(args: &RobotArgs, given: &Given) -> Result<(), Failure> {
    let robot = import_robot(args)?;
    let named = RobotFormat::of_output(&args.output);
    given.refuse(
        &["resume", "shard", "threads", "progress", "allow-empty", "report"],
        "one motion goes into one file; name a folder",
    )?;
    check_json(args.json, &args.output)?;
    let format = match (args.to, named) {
        (Some(to), Some(named)) if to.extension() != named.extension() => {
            return Err(unknown_extension(&args.output, &format!(".{}", to.extension())));
        }
        (Some(to), _) => to,
        (None, Some(named)) => named,
        (None, None) if streams::is_standard(&args.output) => RobotFormat::Npz,
        (None, None) => return Err(unknown_extension(&args.output, ".npz, .pkl, .csv or .glb")),
    };
    if args.print.print_job {
        return job::print(&args.job(format));
    }
    let policy = ReplacePolicy::new(args.paths.iter().chain([&args.robot])).force(args.force);
    if !streams::is_standard(&args.output) {
        policy.check_inputs(&args.output)?;
    }
    let moved = moved(args, &robot, &args.paths[0])?;
    moved.said.iter().for_each(|warning| report::say(warning));
    write_output(&policy, &args.output, &moved.bytes(format)?)?;
    let found = moved.report();
    match args.json {
        true => print_json(found)?,
        false => tell(found),
    }
    match is_good_enough(found, args.require) {
        true => Ok(()),
        false => {
            let (clip, verdict) = (&found.clip, found.verdict.as_str());
            report::say(&format!(
                "error: {clip}: the motion is {verdict}, which --require refuses"
            ));
            Err(Failure::Told)
        }
    }
}

/// The robot, without a motion yet, after a look at the options.
pub(super) fn import_robot(args: &RobotArgs) -> Result<Retargeting, Failure> {
    let options_are_sound = conversion(args).check();
    options_are_sound.map_err(|error| Failure::Usage(error.diagnostic().message.clone()))?;
    let robot = Importer::new().import_robot(&args.robot)?;
    report::warnings(Some(&args.robot), &robot.warnings);
    let options = RetargetingOptions::new()
        .scale(args.scale.0)
        .lock_feet(args.feet == Feet::Lock)
        .source_bones(args.map.bones_here())
        .target_bones(args.robot_map.clone().unwrap_or_default())
        .conversion(conversion(args))
        .velocity_limits(args.velocity_limits);
    Ok(Retargeting::onto(robot, options).map_err(|error| error.with_path(&args.robot))?)
}

fn conversion(args: &RobotArgs) -> Conversion {
    let mut conversion = Conversion::new();
    if let Some(trim) = args.trim {
        conversion = conversion.trim(trim.first, trim.last);
    }
    match args.fps {
        Some(rate) => conversion.frame_rate(rate),
        None => conversion,
    }
}

/// A motion on the robot.
pub(super) struct OnRobot {
    retargeting: Retargeting,
    /// What is to be said of the file.
    pub(super) said: Vec<String>,
}

impl OnRobot {
    pub(super) fn report(&self) -> &RobotReport {
        let found = self.retargeting.clips().iter().find_map(|clip| clip.report.robot());
        found.expect("the source has a motion, and the target is a robot")
    }

    pub(super) fn bytes(&self, format: RobotFormat) -> mocap::Result<Vec<u8>> {
        format.write(&self.retargeting)?.into_bytes()
    }
}

/// Puts the first motion of a file on the robot.
pub(super) fn moved(args: &RobotArgs, robot: &Retargeting, file: &Path) -> Result<OnRobot, Failure> {
    let importer = || args.read.importer().skeleton_mesh(SkeletonMesh::None);
    let mut scene: Scene = import_to_resample(importer, file, args.fps)?;
    let mut said: Vec<String> = scene
        .warnings
        .iter()
        .map(|warning| format!("{}: {warning}", file.display()))
        .collect();
    if scene.animations.is_empty() {
        let message = format!(
            "{}: there is no motion in it: name a file with one, such as a .bvh",
            file.display()
        );
        return Err(Failure::Usage(message));
    }
    if scene.animations.len() > 1 {
        let count = scene.animations.len();
        said.push(format!(
            "{}: the first of {count} animations was taken; --clip names another",
            file.display()
        ));
        scene.animations.truncate(1);
    }
    args.source.state(&mut scene);
    let mut retargeting = robot.clone();
    let source = retargeting.prepare(scene).map_err(|error| error.with_path(file))?;
    said.extend(source.assumptions.iter().map(ToString::to_string));
    let moved = retargeting.add(source.named(super::short_name(file)));
    moved.map_err(|error| error.with_path(file))?;
    Ok(OnRobot { retargeting, said })
}

pub(super) fn is_good_enough(found: &RobotReport, wanted: Option<RequiredVerdict>) -> bool {
    wanted.is_none_or(|wanted| wanted.allows(found.verdict))
}

fn tell(found: &RobotReport) {
    let clip = &found.clip;
    report::say(&format!(
        "{clip}: {}: limbs {:.1} degrees off in the mean of {} frames; path scaled by {:.3}",
        found.verdict.as_str(),
        found.mean_degrees,
        found.frames,
        found.scale
    ));
    for limb in found.limbs.iter().filter(|limb| limb.mean_degrees > 5.0) {
        report::say(&format!(
            "{clip}: {} {:.1} degrees off in the mean, {:.1} at most",
            limb.bone.as_str(),
            limb.mean_degrees,
            limb.max_degrees
        ));
    }
    let clamped = found.clamped.iter().filter(|joint| joint.share >= 0.01);
    let clamped: Vec<String> = clamped
        .map(|joint| format!("{} in {:.0} %", joint.joint, 100.0 * joint.share))
        .collect();
    if !clamped.is_empty() {
        report::say(&format!("{clip}: at a limit: {} of frames", clamped.join(", ")));
    }
    if let (Some(skate), Some(source)) = (found.skate, found.source_skate) {
        report::say(&format!(
            "{clip}: feet on the ground slide at {:.1} cm/s in the mean, those of the source at {:.1}; soles are at most {:.1} mm below the floor",
            100.0 * skate,
            100.0 * source,
            1000.0 * found.deepest.max(0.0)
        ));
    }
    if let Some(pair) = found.self_collisions.first() {
        report::say(&format!(
            "{clip}: links of the robot collide in {:.0} % of frames, deepest {} and {}: {:.1} cm",
            100.0 * found.share_in_self_collision,
            pair.link,
            pair.other,
            100.0 * pair.deepest
        ));
    }
    if found.share_too_fast > 0.0 {
        report::say(&format!(
            "{clip}: joints are faster than the file of the robot allows in {:.2} % of samples; --velocity-limits holds them back",
            100.0 * found.share_too_fast
        ));
    }
    report::say(&format!(
        "{clip}: the fastest joint is {}, at {:.1} rad/s",
        found.fastest_joint, found.max_velocity
    ));
}
