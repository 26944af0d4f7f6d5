//! `mocap play --robot`: retargets a motion to a robot in real time, and prints a row for each frame.

use std::io::{Write, stdout};
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use mocap::arrays::robot_csv;
use mocap::convert::FirstFrame;
use mocap::live::{VmcCleaner, VmcPoses};
use mocap::retarget::robot::{Robot, RobotMotion, RobotOptions, RobotRetargeter, SmoothRobotStream};
use mocap::{Binding, Conversion, Importer, Pose, Scene};

use super::live::{self, over_at_a_signal, scene_of, wait_until};
use super::packets::Packets;
use super::{Place, print_report};
use crate::args::{ListenAddress, PlayArgs};
use crate::{Failure, report};

pub(crate) fn play(args: &PlayArgs) -> Result<(), Failure> {
    let Some(robot) = &args.robot else {
        return live::play(args);
    };
    match live::source_of(args)? {
        None => file(args, robot),
        Some(source) => stream(args, robot, source),
    }
}

/// Plays a file in real time.
fn file(args: &PlayArgs, robot: &Path) -> Result<(), Failure> {
    if args.repeat {
        let message = "--loop is for --vmc: a robot would jump from the end to the beginning";
        return Err(Failure::Usage(message.to_owned()));
    }
    let robot = Importer::new().import_robot(robot)?;
    let conversion = Conversion::new().first_frame(FirstFrame::DropRestPose);
    let scene = scene_of(args, &conversion)?;
    let animation = &scene.animations[0];
    let rate = args.rate.unwrap_or(animation.ticks_per_second);
    let mut stream = begin(&scene, &robot, rate).map_err(|error| error.with_path(&args.file))?;
    let frames = (animation.duration / animation.ticks_per_second * rate + 1e-6).floor() as u64 + 1;
    let (binding, mut pose) = (Binding::new(&scene, animation), Pose::rest(&scene));
    let is_over = over_at_a_signal()?;
    let (start, mut came) = (Instant::now(), 0_u64);
    while came < frames && !is_over.load(Ordering::Relaxed) {
        wait_until(start + Duration::from_secs_f64(came as f64 / rate), &is_over);
        let tick = (came as f64 / rate * animation.ticks_per_second).min(animation.duration);
        pose.sample(&binding, animation, tick);
        write(&robot, stream.push(&pose).as_ref())?;
        came += 1;
    }
    finish(&robot, &mut stream, came as usize)
}

/// Writes the remaining frames, and reports the quality of the last half minute on the robot.
fn finish(robot: &Robot, stream: &mut SmoothRobotStream, frames: usize) -> Result<(), Failure> {
    write(robot, Some(&stream.finish()))?;
    report::say(&report::counted(frames, "frame"));
    if let Some(mut found) = stream.report() {
        found.clip = format!("the last {:.1} s", found.frames as f64 / found.fps);
        print_report(&found, false, Place::Message)?;
    }
    Ok(())
}

/// Retargets a VMC stream to a robot, until Ctrl-C.
fn stream(args: &PlayArgs, robot: &Path, source: ListenAddress) -> Result<(), Failure> {
    if args.repeat || args.rate.is_some() {
        let message = "a live stream to a robot does not support --loop and --rate";
        return Err(Failure::Usage(message.to_owned()));
    }
    let robot = Importer::new().import_robot(robot)?;
    let mut cleaner = args.clean.then(|| VmcCleaner::new(live::delay(args))).transpose()?;
    let packets = Packets::of(source, over_at_a_signal()?, None)?;
    report::say(&format!("listening on {}; Ctrl-C ends the stream", packets.address()));
    let (mut poses, mut on_robot): (_, Option<SmoothRobotStream>) = (VmcPoses::new(), None);
    let (mut last, mut frames) = (0.0, 0_usize);
    let mut hear = |packets: Vec<Vec<u8>>, seconds: f64| -> Result<(), Failure> {
        for packet in packets {
            for pose in poses.hear(&packet, seconds) {
                if on_robot.is_none() {
                    let Some(scene) = poses.scene() else { continue };
                    on_robot = Some(begin(scene, &robot, scene.animations[0].ticks_per_second)?);
                }
                frames += 1;
                let given = on_robot.as_mut().and_then(|stream| stream.push(&pose));
                write(&robot, given.as_ref())?;
            }
        }
        Ok(())
    };
    for packet in &packets {
        last = packet.seconds;
        match &mut cleaner {
            Some(cleaner) => hear(cleaner.hear(&packet.bytes, last), last)?,
            None => hear(vec![packet.bytes], last)?,
        }
    }
    live::tell_lost(&packets);
    if let Some(cleaner) = &mut cleaner {
        hear(cleaner.finish(), last)?;
    }
    match on_robot {
        Some(mut stream) => finish(&robot, &mut stream, frames),
        None => {
            report::say(&report::counted(frames, "frame"));
            Ok(())
        }
    }
}

/// Begins a stream, and describes its rows.
fn begin(scene: &Scene, robot: &Robot, rate: f64) -> mocap::Result<SmoothRobotStream> {
    let stream = RobotRetargeter::new(scene, robot, &RobotOptions::default())?.stream(scene, rate)?;
    report::say(&format!(
        "rows: x, y, z, rotation as x, y, z, w, {}; {rate:.2} per second, with a delay of {:.2} s",
        stream.dof_names().join(", "),
        stream.delay()
    ));
    Ok(stream)
}

fn write(robot: &Robot, motion: Option<&RobotMotion>) -> Result<(), Failure> {
    let Some(motion) = motion else { return Ok(()) };
    let mut out = stdout().lock();
    let rows = robot_csv(motion, robot);
    out.write_all(rows.as_bytes())
        .and_then(|()| out.flush())
        .map_err(Failure::Output)
}
