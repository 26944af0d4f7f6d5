//! Holds feet still while they stand.
//!
//! In contact, the step by which a foot's point of contact slides from frame to frame is taken back, so that a foot may
//! roll from heel to ball, and turn, but not slide. Each foot is shifted as a whole and keeps its rotation in the world;
//! [two-bone inverse kinematics](crate::ik::two_bone()) lets the leg follow. Between contacts the shift eases out and in
//! without a jump of its speed. Compare Kovar, Schreiner and Gleicher, "Footskate cleanup for motion capture editing"
//! (2002), which lengthens bones where a leg is too short; here the hips come down instead.

mod floor;
mod leg;
mod shift;

use glam::Vec3;
use serde::Serialize;

use self::leg::LegTrack;
use super::body::{Body, and_below, mover};
use super::contacts::{ContactOptions, DetectedContacts, detect};
use super::frames::Frames;
use crate::error::{Code, Diagnostic, Result};
use crate::ik::{Goal, two_bone};
use crate::limits::not_negative;
use crate::pose::{Pose, Trs};
use crate::scene::{NodeId, Scene};
use crate::skeleton::{Humanoid, HumanoidBone, Side};

/// Options of [`foot_lock()`].
#[derive(Clone, Debug, PartialEq)]
pub struct FootLockOptions {
    /// When a foot is in contact.
    pub contacts: ContactOptions,
    /// Contacts that are known, for example those of the motion that was retargeted: they must have the frames of this
    /// one. Default: `None`, they are detected.
    pub known: Option<DetectedContacts>,
    /// Seconds in which a shift eases out after a contact, and in before one. Default: 0.2.
    pub blend: f64,
    /// The height of the floor along the up axis, in metres. Default: where the feet rest.
    pub floor: Option<f32>,
    /// The bones where the caller knows them.
    pub humanoid: Option<Humanoid>,
}

impl Default for FootLockOptions {
    fn default() -> Self {
        Self {
            contacts: ContactOptions::default(),
            known: None,
            blend: 0.2,
            floor: None,
            humanoid: None,
        }
    }
}

/// What [`foot_lock()`] changed. Lengths are in metres.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FootLockReport {
    /// How far the feet slid while in contact, all steps together.
    pub slide_before: f64,
    /// The same afterwards.
    pub slide_after: f64,
    /// The number of contacts.
    pub contacts: usize,
    /// The largest shift of a foot.
    pub largest_shift: f32,
    /// The deepest place of a foot below the floor before.
    pub deepest_before: f32,
    /// The most by which the hips were lowered.
    pub hips_lowered: f32,
    /// The largest change of a joint other than those of the feet: a knee, or all that the hips carry.
    pub largest_other_change: f32,
    /// The name of that joint.
    pub largest_other_joint: String,
}

/// How much of its full length a leg may be stretched to, unless the motion itself stretches it more.
const STRETCH: f32 = 0.9995;

/// Holds the feet of `animation`, an index into the animations of `scene`, still while they are in contact, and above the
/// floor. Bones keep their lengths.
///
/// ```
/// use mocap::edit::{FootLockOptions, foot_lock};
///
/// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// let report = foot_lock(&mut scene, 0, &FootLockOptions::default())?;
/// assert!(report.slide_after < 0.01 * report.slide_before);
/// # Ok::<(), mocap::Error>(())
/// ```
///
/// # Errors
/// As [`contacts()`](crate::edit::contacts()); [`Code::NotHumanoid`] also where a leg lacks a joint, and
/// [`Code::UnknownOption`] where known contacts have another number of frames. `scene` is then unchanged.
pub fn foot_lock(scene: &mut Scene, animation: usize, options: &FootLockOptions) -> Result<FootLockReport> {
    options.contacts.check()?;
    not_negative(Code::UnknownOption, "blend", options.blend)?;
    let body = Body::new(scene, options.humanoid.as_ref())?;
    let hips = body.humanoid.joint(HumanoidBone::Hips);
    let legs: Option<Vec<_>> = Side::ALL
        .into_iter()
        .map(|side| Some((side, body.leg(side)?)))
        .collect();
    let (Some(hips), Some(legs)) = (hips, legs) else {
        let message = "the skeleton has no joint for the hips, a thigh, a shin or a foot";
        return Err(Diagnostic::new(Code::NotHumanoid, message).into());
    };
    let moves = |node: NodeId| {
        let channels = scene.animations.get(animation).map(|animation| &animation.channels);
        channels.is_some_and(|channels| {
            let own = |channel: &&crate::scene::Channel| channel.node == Some(node);
            channels
                .iter()
                .find(own)
                .is_some_and(|channel| channel.position_keys.len() > 1)
        })
    };
    let mover = mover(scene, hips, moves);
    let mut held = vec![mover];
    for (_, leg) in &legs {
        held.extend([leg.thigh, leg.knee]);
        held.extend(and_below(scene, leg.ankle).filter(|node| floor::turns(scene, *node)));
    }
    let mut frames = Frames::new(scene, animation, &held)?;
    let contacts = match &options.known {
        Some(known) if known.frames != frames.len() => {
            let message = "the known contacts are those of another number of frames";
            return Err(Diagnostic::new(Code::UnknownOption, message)
                .expected_found(frames.len().to_string(), known.frames.to_string())
                .into());
        }
        Some(known) => known.clone(),
        None => detect(scene, &frames, &body, &options.contacts),
    };
    let floor = options.floor.unwrap_or(match options.known {
        // Contacts may be those of another body, whose floor is elsewhere.
        Some(_) => detect(scene, &frames, &body, &options.contacts).floor,
        None => contacts.floor,
    }) / body.metres;
    let blend = frames.frames_in(options.blend);

    let mut tracks: Vec<LegTrack> = legs
        .into_iter()
        .map(|(side, leg)| LegTrack::new(scene, &frames, &body, side, leg, &contacts))
        .collect();
    for track in &mut tracks {
        track.shift(body.up, floor, blend);
    }
    let lowered = shift::envelope(&needed_lowering(&tracks, body.up), blend);
    let mut report = FootLockReport {
        slide_before: tracks.iter().map(|track| track.slide(body.up)).sum::<f64>() * f64::from(body.metres),
        contacts: tracks.iter().map(LegTrack::contacts).sum(),
        deepest_before: tracks.iter().map(|track| track.deepest(floor)).fold(0.0, f32::max) * body.metres,
        hips_lowered: lowered.iter().copied().fold(0.0, f32::max) * body.metres,
        ..FootLockReport::default()
    };
    apply(
        scene,
        &mut frames,
        &tracks,
        &lowered,
        mover,
        body.up,
        floor,
        &mut report,
        body.metres,
    );
    let rotated: Vec<NodeId> = held.split_off(1);
    frames.write(
        scene,
        animation,
        &rotated,
        if report.hips_lowered > 0.0 { &held } else { &[] },
    );
    let after = tracks.iter().map(|track| track.measured(scene, &frames).slide(body.up));
    report.slide_after = after.sum::<f64>() * f64::from(body.metres);
    Ok(report)
}

/// For each frame how far the hips must come down for both legs to reach.
fn needed_lowering(tracks: &[LegTrack], up: Vec3) -> Vec<f32> {
    let frames = tracks.first().map_or(0, |track| track.ankle.len());
    let of_leg = |track: &LegTrack, frame: usize| {
        let way = track.ankle[frame] + track.shifts[frame] - track.thigh[frame];
        let now = track.thigh[frame].distance(track.ankle[frame]);
        let reach = (STRETCH * track.length).max(now);
        let beyond = way.length_squared() - reach * reach;
        if track.shifts[frame] == Vec3::ZERO || beyond <= 0.0 {
            return 0.0;
        }
        // |way + h up| = reach, for the smaller h. A leg that no height brings near enough stays stretched.
        let along = way.dot(up);
        let square = along * along - beyond;
        if along < 0.0 && square >= 0.0 {
            -along - square.sqrt()
        } else {
            0.0
        }
    };
    (0..frames)
        .map(|frame| tracks.iter().map(|track| of_leg(track, frame)).fold(0.0, f32::max))
        .collect()
}

#[allow(clippy::too_many_arguments, reason = "one caller")]
fn apply(
    scene: &Scene,
    frames: &mut Frames,
    tracks: &[LegTrack],
    lowered: &[f32],
    mover: NodeId,
    up: Vec3,
    floor: f32,
    report: &mut FootLockReport,
    metres: f32,
) {
    let mut pose = Pose::rest(scene);
    let mut before = pose.clone();
    for (frame, &lowered) in lowered.iter().enumerate() {
        let is_shifted = |track: &LegTrack| track.shifts[frame] != Vec3::ZERO || track.is_below(frame, floor);
        if lowered == 0.0 && !tracks.iter().any(is_shifted) {
            continue;
        }
        frames.pose(frame, &mut pose);
        before.clone_from(&pose);
        if lowered > 0.0
            && let Some(trs) = frames.get(frame, mover)
        {
            let parent = scene.nodes[mover.index()].parent;
            let to_parent = parent.map_or(glam::Mat4::IDENTITY, |parent| {
                pose.node_to_world[parent.index()].inverse()
            });
            let translation = trs.translation + to_parent.transform_vector3(-up * lowered);
            frames.set(frame, mover, Trs { translation, ..trs });
            pose.node_to_parent[mover.index()].w_axis = translation.extend(1.0);
            pose.update_below(mover);
        }
        for track in tracks {
            let ankle = track.leg.ankle;
            let rotation = Trs::from_matrix(before.node_to_world[ankle.index()]).rotation;
            let goal = Goal::at(track.ankle[frame] + track.shifts[frame]).with_rotation(rotation);
            two_bone(&mut pose, [track.leg.thigh, track.leg.knee, ankle], &goal, None);
            floor::lift_below(scene, &mut pose, &track.foot, up, floor);
            for node in [track.leg.thigh, track.leg.knee].iter().chain(&track.foot) {
                frames.set_rotation_of(frame, *node, &pose);
            }
            report.largest_shift = report.largest_shift.max(track.shifts[frame].length() * metres);
        }
        for index in 0..scene.nodes.len() {
            let node = NodeId::new(index);
            let change = pose.position(node).distance(before.position(node)) * metres;
            if change > report.largest_other_change && !tracks.iter().any(|track| track.foot.contains(&node)) {
                report.largest_other_change = change;
                report.largest_other_joint.clone_from(&scene.nodes[index].name);
            }
        }
    }
}
