//! `mocap record`, `mocap play` and `mocap bridge`: motion from and to programs that use the VMC protocol.

use std::io::{self, ErrorKind};
use std::net::{SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use mocap::edit::{Clean, Step, StepInput};
use mocap::files::ReplacePolicy;
use mocap::live::report::VmcCounts;
use mocap::live::{VmcBridge, VmcCleaner, VmcMotion, VmcRecorder};
use mocap::retarget::robot::robot_bones;
use mocap::{Code, Conversion, Diagnostic, Error, Exporter, FormatInfo, Importer, Scene};

use super::packets::{PATIENCE, Packets, of_socket};
use super::{Place, print_report};
use crate::args::{BridgeArgs, ListenAddress, PlayArgs, RecordArgs};
use crate::printed::{BridgeReport, HeardReport, PlayReport, RecordingReport};
use crate::{Failure, report, streams};

/// The default delay of a cleaned stream in seconds. With this delay, the filter knows the motion after a frame too.
const USUAL_DELAY: f64 = 0.5;

pub(crate) fn record(args: &RecordArgs) -> Result<(), Failure> {
    if streams::is_standard(&args.output) || FormatInfo::of_output(&args.output).is_none() {
        let known = FormatInfo::written_extensions();
        return Err(super::unknown_extension(&args.output, &known));
    }
    let nothing: [&str; 0] = [];
    let policy = ReplacePolicy::new(nothing).force(args.force.force);
    policy.check(&args.output)?;
    // A recording cannot be repeated, so check the output first.
    let folder = args.output.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
        let error = io::Error::new(ErrorKind::NotFound, "folder not found: create it before the recording");
        return Err(Failure::Folder(folder.to_owned(), error));
    }
    let packets = Packets::of(args.source, over_at_a_signal()?, args.seconds)?;
    report::say(&format!(
        "listening on {}; Ctrl-C ends the recording",
        packets.address()
    ));
    let mut recorder = VmcRecorder::new();
    for packet in &packets {
        recorder.hear(&packet.bytes, packet.seconds);
        if recorder.is_full() {
            break;
        }
    }
    tell_lost(&packets);
    let counts = recorder.counts();
    if recorder.is_full() {
        report::complain("the recording reached the memory limit; mocap dropped the later motion");
    }
    tell_left_out(&counts);
    let mut scene = recorder.scene()?;
    report::warnings(None, &scene.warnings);
    if args.clean {
        clean(&mut scene)?;
    }
    let seconds = scene.animations[0].duration / scene.animations[0].ticks_per_second;
    let mut written = Exporter::new().write_as(&scene, &args.output)?;
    report::warnings(Some(&args.output), &std::mem::take(&mut written.warnings));
    written.save(&args.output, &policy)?;
    let found = RecordingReport {
        output: args.output.display().to_string(),
        frames: counts.frames as u64,
        seconds,
        bones: scene.nodes.len(),
        heard: heard(&counts, &packets),
    };
    print_report(&found, args.json, Place::Message)
}

/// Reports the number of dropped packets.
pub(super) fn tell_lost(packets: &Packets) {
    let lost = packets.lost();
    if lost > 0 {
        report::complain(&format!(
            "{lost} packets were lost, because they came faster than mocap reads them"
        ));
    }
}

fn heard(counts: &VmcCounts, packets: &Packets) -> HeardReport {
    HeardReport {
        packets: counts.packets,
        lost: packets.lost(),
        malformed: counts.malformed,
        others: counts.others,
    }
}

fn tell_left_out(counts: &VmcCounts) {
    for (count, what) in [
        (counts.malformed, "packets or messages were malformed"),
        (counts.others, "messages contained no bones of the body"),
    ] {
        if count > 0 {
            report::say(&format!("{count} {what}"));
        }
    }
}

/// Cleans a motion with all parts, and reports the changes.
fn clean(scene: &mut Scene) -> Result<(), Error> {
    let did = Clean::new().apply(scene, &StepInput::new())?;
    report::say(&format!("clean: {did}"));
    Ok(())
}

/// The stream to play, if the input is not a file.
pub(super) fn source_of(args: &PlayArgs) -> Result<Option<ListenAddress>, Failure> {
    let source = args.file.to_str().filter(|file| file.starts_with("vmc:"));
    if source.is_none() && args.delay.is_some() {
        let message =
            "--delay works only with a stream, such as vmc:39539: mocap cleans a file before it sends the first pose";
        return Err(Failure::Usage(message.to_owned()));
    }
    let parsed = source.map(|source| {
        let parsed = source.parse::<ListenAddress>();
        parsed.map_err(|why| Failure::Usage(format!("{source}: {why}")))
    });
    parsed.transpose()
}

/// Plays to a program that uses the VMC protocol.
pub(super) fn play(args: &PlayArgs) -> Result<(), Failure> {
    match (source_of(args)?, args.vmc) {
        (None, Some(peer)) => send_file(args, peer.0),
        (Some(source), Some(peer)) => send_on(args, source, peer.0),
        (_, None) => Err(Failure::Usage("name a destination with --vmc or --robot".to_owned())),
    }
}

/// The scene of the file to play, in metres, cleaned if requested.
pub(super) fn scene_of(args: &PlayArgs, conversion: &Conversion) -> Result<Scene, Failure> {
    let mut scene = super::import_motion(&args.read, &args.file)?;
    let with_path = |error: Error| error.with_path(&args.file);
    if scene.animations.is_empty() {
        let diagnostic = Diagnostic::new(Code::NoMotion, "the file has no motion to play");
        return Err(with_path(diagnostic.into()).into());
    }
    for guess in conversion.apply(&mut scene).map_err(with_path)? {
        report::say(&guess.to_string());
    }
    if args.clean {
        clean(&mut scene).map_err(with_path)?;
    }
    Ok(scene)
}

fn send_file(args: &PlayArgs, peer: SocketAddr) -> Result<(), Failure> {
    let motion = VmcMotion::new(&scene_of(args, &Conversion::new())?).map_err(|error| error.with_path(&args.file))?;
    let socket = sender(peer)?;
    let is_over = over_at_a_signal()?;
    let rate = args.rate.unwrap_or_else(|| motion.frames_per_second());
    // Count the last frame too.
    let frames = (motion.seconds() * rate + 1e-6).floor() as u64 + 1;
    report::say(&format!(
        "{}: {frames} frames at {rate} a second to {}",
        args.file.display(),
        peer
    ));
    let (begin, mut sent) = (Instant::now(), 0_u64);
    while !is_over.load(Ordering::Relaxed) && (args.repeat || sent < frames) {
        let clock = sent as f64 / rate;
        wait_until(begin + Duration::from_secs_f64(clock), &is_over);
        send(&socket, peer, &motion.packets_at((sent % frames) as f64 / rate, clock))?;
        sent += 1;
    }
    tell_sent(args, peer, (Some(sent), None))
}

/// Reports the number of sent frames or packets.
fn tell_sent(args: &PlayArgs, peer: SocketAddr, (frames, packets): (Option<u64>, Option<u64>)) -> Result<(), Failure> {
    let peer = peer.to_string();
    print_report(&PlayReport { peer, frames, packets }, args.json, Place::Message)
}

/// The delay of a cleaned stream in seconds.
pub(super) fn delay(args: &PlayArgs) -> f64 {
    args.delay.unwrap_or(USUAL_DELAY)
}

/// Refuses to send to the address of the received stream: the stream would loop forever.
fn refuse_itself(source: ListenAddress, peer: SocketAddr) -> Result<(), Failure> {
    let heard = source.0;
    let is_here = heard.ip() == peer.ip() || (heard.ip().is_unspecified() && peer.ip().is_loopback());
    if is_here && heard.port() == peer.port() {
        let message = format!(
            "mocap receives the stream at {peer}, and would receive its own result: name another port for the result"
        );
        return Err(Failure::Usage(message));
    }
    Ok(())
}

/// Forwards a stream without its noise, with a delay, until Ctrl-C.
fn send_on(args: &PlayArgs, source: ListenAddress, peer: SocketAddr) -> Result<(), Failure> {
    if !args.clean || args.repeat || args.rate.is_some() {
        let message = "a live stream requires --clean, and does not support --loop and --rate";
        return Err(Failure::Usage(message.to_owned()));
    }
    refuse_itself(source, peer)?;
    let delay = delay(args);
    let mut cleaner = VmcCleaner::new(delay)?;
    let output = sender(peer)?;
    let packets = Packets::of(source, over_at_a_signal()?, None)?;
    report::say(&format!(
        "receiving from {}, sending to {} {delay} s later; Ctrl-C ends the stream",
        packets.address(),
        peer
    ));
    let mut sent = 0_u64;
    for packet in &packets {
        let given = cleaner.hear(&packet.bytes, packet.seconds);
        send(&output, peer, &given)?;
        sent += given.len() as u64;
    }
    tell_lost(&packets);
    let left = cleaner.finish();
    send(&output, peer, &left)?;
    tell_sent(args, peer, (None, Some(sent + left.len() as u64)))
}

/// Retargets a live stream, until Ctrl-C.
pub(crate) fn bridge(args: &BridgeArgs) -> Result<(), Failure> {
    let (Some(peer), is_json) = (args.vmc.or(args.udp_json), args.udp_json.is_some()) else {
        return Err(Failure::Usage("name a peer: --vmc or --udp-json HOST:PORT".to_owned()));
    };
    refuse_itself(args.source, peer.0)?;
    let mut bridge = bridge_onto(args, is_json)?;
    let delay = args.clean.then(|| args.delay.unwrap_or(USUAL_DELAY));
    let mut cleaner = delay.map(VmcCleaner::new).transpose()?;
    let output = sender(peer.0)?;
    let packets = Packets::of(args.source, over_at_a_signal()?, None)?;
    report::say(&format!(
        "receiving from {}, retargeting to {}, sending to {}; Ctrl-C ends the stream",
        packets.address(),
        args.onto.display(),
        peer.0
    ));
    let mut seconds = 0.0;
    for packet in &packets {
        seconds = packet.seconds;
        match &mut cleaner {
            None => send(&output, peer.0, &bridge.hear(&packet.bytes, seconds))?,
            Some(cleaner) => {
                for cleaned in cleaner.hear(&packet.bytes, seconds) {
                    send(&output, peer.0, &bridge.hear(&cleaned, seconds))?;
                }
            }
        }
    }
    for cleaned in cleaner.iter_mut().flat_map(VmcCleaner::finish) {
        send(&output, peer.0, &bridge.hear(&cleaned, seconds))?;
    }
    tell_lost(&packets);
    let counts = bridge.counts();
    tell_left_out(&counts);
    if let Some(problem) = bridge.problem() {
        report::complain(&format!("the last received bones do not form a body: {problem}"));
    }
    let found = BridgeReport {
        peer: peer.0.to_string(),
        poses: counts.frames as u64,
        heard: heard(&counts, &packets),
        problem: bridge.problem().map(ToString::to_string),
    };
    print_report(&found, args.json, Place::Message)
}

fn bridge_onto(args: &BridgeArgs, is_json: bool) -> Result<VmcBridge, Failure> {
    let importer = Importer::new();
    let with_path = |error: Error| error.with_path(&args.onto);
    let is_robot = |extension: &std::ffi::OsStr| ROBOTS.iter().any(|known| extension.eq_ignore_ascii_case(known));
    if args.onto.extension().is_some_and(is_robot) {
        let robot = importer.import_robot(&args.onto)?;
        report::warnings(Some(&args.onto), &robot.warnings);
        if !is_json {
            let message = "--vmc sends the bones of a humanoid, which a robot does not have: use --udp-json HOST:PORT";
            return Err(Failure::Usage(message.to_owned()));
        }
        robot_bones(&robot, None).map_err(with_path)?;
        return Ok(VmcBridge::onto_robot(&robot));
    }
    let mut scene = importer.import(&args.onto)?;
    for guess in Conversion::new().apply(&mut scene).map_err(with_path)? {
        report::say(&guess.to_string());
    }
    let bridge = VmcBridge::onto(&scene).map_err(with_path)?;
    Ok(if is_json { bridge.json() } else { bridge })
}

/// The file extensions of robots.
const ROBOTS: [&str; 3] = ["urdf", "mjcf", "xml"];

/// A socket that sends to an address.
fn sender(to: SocketAddr) -> Result<UdpSocket, Error> {
    let any = match to {
        SocketAddr::V4(_) => "0.0.0.0:0",
        SocketAddr::V6(_) => "[::]:0",
    };
    UdpSocket::bind(any).map_err(|error| of_socket(to, &error))
}

fn send(socket: &UdpSocket, to: SocketAddr, packets: &[Vec<u8>]) -> Result<(), Error> {
    for packet in packets {
        match socket.send_to(packet, to) {
            // No program listens at this address yet.
            Err(error) if error.kind() == ErrorKind::ConnectionRefused => {}
            Err(error) => return Err(of_socket(to, &error)),
            Ok(_) => {}
        }
    }
    Ok(())
}

pub(super) fn wait_until(moment: Instant, is_over: &AtomicBool) {
    while let Some(rest) = moment.checked_duration_since(Instant::now()) {
        if is_over.load(Ordering::Relaxed) {
            return;
        }
        thread::sleep(rest.min(PATIENCE));
    }
}

/// A flag that Ctrl-C or a termination signal sets.
pub(super) fn over_at_a_signal() -> Result<Arc<AtomicBool>, Failure> {
    let is_over = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&is_over))?;
    }
    Ok(is_over)
}
