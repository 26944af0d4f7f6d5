//! Holds feet still while they stand.
//!
//! In contact, the step by which a foot's point of contact slides from frame to frame is taken back, so that a foot may
//! roll from heel to ball, and turn, but not slide. Each foot is shifted as a whole and keeps its rotation in the
//! world; [two-bone inverse kinematics](crate::ik::two_bone()) lets the leg follow. Between contacts the shift eases
//! out and in without a jump of its speed. Compare Kovar, Schreiner and Gleicher, "Footskate cleanup for motion capture
//! editing" (2002), which lengthens bones where a leg is too short; here the hips give way so that legs keep the length
//! that they have, above all those that are nearly straight, whose knees a millimetre moves by centimetres.

mod hips;
mod knee;
mod leg;
mod shift;
mod sole;
mod step;

use glam::{Quat, Vec3};
use serde::Serialize;

use self::leg::LegTrack;
pub(crate) use self::sole::SolePoint;
pub use self::step::FootLock;
use super::body::{Body, Leg, and_below, mover};
use super::contacts::{ContactOptions, DetectedContacts, detect};
use super::frames::Frames;
use crate::error::{Code, Diagnostic, Result};
use crate::figure::{Humanoid, HumanoidBone, Side};
use crate::ik::{Goal, two_bone};
use crate::limits::{not_negative, positive};
use crate::pose::{Pose, Trs};
use crate::scene::{NodeId, Scene};

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
    /// The largest change of any other joint, in metres: a foot that would take a knee or the hips farther gives way,
    /// and keeps a part of its slide. Default: `None`, no foot slides.
    pub largest_change: Option<f64>,
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
            largest_change: None,
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
    /// The most by which they were raised.
    pub hips_raised: f32,
    /// The largest change of a joint other than those of the feet: a knee, or all that the hips carry.
    pub largest_other_change: f32,
    /// The name of that joint.
    pub largest_other_joint: String,
    /// The frames in which the left and the right leg are too short to bring the foot where it belongs.
    pub out_of_reach: [usize; 2],
    /// The largest distance of such a foot from there.
    pub farthest_out_of_reach: [f32; 2],
}

/// The feet of another body, which those of a retargeted motion follow.
pub(crate) struct Followed<'a> {
    /// The contacts of its motion.
    pub(crate) contacts: &'a DetectedContacts,
    /// How high feet go in units of the scene, where they go a metre high on the other body.
    pub(crate) units_per_metre: f32,
    /// From a way over the ground there to the way here: how many times as long, and turned how.
    pub(crate) scale: f32,
    pub(crate) turn: Quat,
    /// The height of the floor along the up axis, in units of the scene.
    pub(crate) floor: f32,
    /// The length of a leg, likewise.
    pub(crate) leg: f32,
    /// What of the left and of the right foot stays above the floor, parents before children.
    pub(crate) soles: [Vec<SolePoint>; 2],
}

/// What feet in contact do.
#[derive(Clone, Copy)]
enum Feet<'a> {
    /// They are held where they are. Other joints move by `limit` at most, in units of the scene.
    Held {
        limit: f32,
    },
    Following(&'a Followed<'a>),
}

/// The distance from a goal that counts as out of reach, in metres.
const OUT_OF_REACH: f32 = 0.001;

/// Holds the feet of `animation`, an index into the animations of `scene`, still while they are in contact, and above
/// the floor. Bones keep their lengths.
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
/// [`Code::InvalidValue`] where known contacts have another number of frames, or the floor is more than a leg above
/// the feet. `scene` is then unchanged.
pub fn foot_lock(scene: &mut Scene, animation: usize, options: &FootLockOptions) -> Result<FootLockReport> {
    options.contacts.check()?;
    not_negative(Code::InvalidValue, "blend", options.blend)?;
    if let Some(change) = options.largest_change {
        positive(Code::InvalidValue, "largest-change", change)?;
    }
    let body = Body::new(scene, options.humanoid.as_ref())?;
    let mut held = Held::new(scene, animation, &body, &[])?;
    let detected = |held: &Held| detect(scene, &held.frames, &body, &options.contacts);
    let contacts = match &options.known {
        Some(known) => {
            held.check(known)?;
            known.clone()
        }
        None => detected(&held),
    };
    let rests = match options.known {
        // Contacts may be those of another body, whose floor is elsewhere.
        Some(_) => detected(&held).floor,
        None => contacts.floor,
    };
    let floor = options.floor.unwrap_or(rests);
    let leg = held.leg_length(scene) * body.metres;
    // One below the feet is far from none of them.
    if !floor.is_finite() || floor - rests > leg {
        let message = format!(
            "floor must be finite and at most {leg:.3} m, the length of a leg, above where the feet rest, {rests:.3} m, got {floor}"
        );
        return Err(Diagnostic::new(Code::InvalidValue, message).into());
    }
    let limit = options
        .largest_change
        .map_or(f32::INFINITY, |metres| metres as f32 / body.metres);
    let report = held.lock(
        scene,
        &body,
        &contacts,
        floor / body.metres,
        options.blend,
        Feet::Held { limit },
    );
    held.write(scene, animation);
    Ok(report)
}

/// Holds the feet of a retargeted motion still while those of the other body are in contact, and as high above the
/// floor as they are there.
pub(crate) fn follow_feet(
    scene: &mut Scene,
    animation: usize,
    humanoid: &Humanoid,
    followed: &Followed<'_>,
) -> Result<FootLockReport> {
    let body = Body::new(scene, Some(humanoid))?;
    let pivots: Vec<NodeId> = followed
        .soles
        .iter()
        .flatten()
        .filter_map(|point| point.pivot)
        .collect();
    let mut held = Held::new(scene, animation, &body, &pivots)?;
    held.check(followed.contacts)?;
    let blend = FootLockOptions::default().blend;
    let report = held.lock(
        scene,
        &body,
        followed.contacts,
        followed.floor,
        blend,
        Feet::Following(followed),
    );
    held.write(scene, animation);
    Ok(report)
}

/// The frames of a motion whose legs are to be changed.
struct Held {
    frames: Frames,
    legs: Vec<(Side, Leg)>,
    /// The node that carries the figure.
    mover: NodeId,
    /// The joints that turn.
    turned: Vec<NodeId>,
    /// Whether the figure is shifted.
    moved: bool,
}

impl Held {
    fn new(scene: &Scene, animation: usize, body: &Body, pivots: &[NodeId]) -> Result<Self> {
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
        let mut turned = Vec::new();
        for (_, leg) in &legs {
            turned.extend([leg.thigh, leg.knee]);
            let turns = |node: &NodeId| sole::turns(scene, *node) || pivots.contains(node);
            turned.extend(and_below(scene, leg.ankle).filter(turns));
        }
        let frames = Frames::new(scene, animation, &[&[mover], &*turned].concat())?;
        Ok(Self {
            frames,
            legs,
            mover,
            turned,
            moved: false,
        })
    }

    /// The length of the longer leg at rest.
    fn leg_length(&self, scene: &Scene) -> f32 {
        let rest = Pose::rest(scene);
        let length = |(_, leg): &(Side, Leg)| {
            let [thigh, knee, ankle] = [leg.thigh, leg.knee, leg.ankle].map(|node| rest.position(node));
            thigh.distance(knee) + knee.distance(ankle)
        };
        self.legs.iter().map(length).fold(0.0, f32::max)
    }

    fn check(&self, contacts: &DetectedContacts) -> Result<()> {
        if contacts.frames == self.frames.len() {
            return Ok(());
        }
        let message = "the known contacts are those of another number of frames";
        Err(Diagnostic::new(Code::InvalidValue, message)
            .expected_found(self.frames.len().to_string(), contacts.frames.to_string())
            .into())
    }

    /// Changes the frames. `floor` is in units of the scene, `blend` in seconds.
    fn lock(
        &mut self,
        scene: &Scene,
        body: &Body,
        contacts: &DetectedContacts,
        floor: f32,
        blend: f64,
        feet: Feet<'_>,
    ) -> FootLockReport {
        let up = body.up;
        let followed = match feet {
            Feet::Following(followed) => Some(followed),
            Feet::Held { .. } => None,
        };
        let blend = self.frames.frames_in(blend);
        let legs = std::mem::take(&mut self.legs).into_iter();
        let mut tracks: Vec<LegTrack> = legs
            .map(|(side, leg)| LegTrack::new(scene, body, side, leg, contacts, followed))
            .collect();
        let mut pose = Pose::rest(scene);
        for frame in 0..self.frames.len() {
            self.frames.pose(frame, &mut pose);
            for track in &mut tracks {
                track.see(frame, &mut pose, up, floor);
            }
        }
        let held: Vec<_> = tracks
            .iter()
            .map(|track| track.held(up, self.frames.rate as f32))
            .collect();
        let carried = match feet {
            Feet::Following(_) => hips::follow(&mut tracks, &held, up, blend),
            Feet::Held { limit } => hips::spare_knees(&mut tracks, held, up, floor, blend, limit),
        };
        let heights = || carried.iter().map(|carried| carried.dot(up));
        let mut report = FootLockReport {
            slide_before: tracks.iter().map(|track| track.slide(up)).sum::<f64>() * f64::from(body.metres),
            contacts: tracks.iter().map(LegTrack::contacts).sum(),
            deepest_before: tracks.iter().map(|track| track.deepest(floor)).fold(0.0, f32::max) * body.metres,
            hips_lowered: heights().map(|height| -height).fold(0.0, f32::max) * body.metres,
            hips_raised: heights().fold(0.0, f32::max) * body.metres,
            ..FootLockReport::default()
        };
        self.apply(scene, body, &mut tracks, &carried, floor, &mut report);
        report.slide_after = tracks.iter().map(|track| track.slide(up)).sum::<f64>() * f64::from(body.metres);
        report
    }

    fn apply(
        &mut self,
        scene: &Scene,
        body: &Body,
        tracks: &mut [LegTrack],
        carried: &[Vec3],
        floor: f32,
        report: &mut FootLockReport,
    ) {
        let (up, metres) = (body.up, body.metres);
        let mut pose = Pose::rest(scene);
        let mut before = pose.clone();
        for (frame, &carried) in carried.iter().enumerate() {
            self.frames.pose(frame, &mut pose);
            let is_changed = |track: &LegTrack| {
                track.shifts[frame] != Vec3::ZERO || track.is_below(frame, floor) || track.follows(frame)
            };
            if carried == Vec3::ZERO && !tracks.iter().any(is_changed) {
                tracks.iter_mut().for_each(|track| track.place(frame, &pose));
                continue;
            }
            before.clone_from(&pose);
            if carried != Vec3::ZERO {
                self.carry(scene, frame, &mut pose, carried);
            }
            for (side, track) in tracks.iter_mut().enumerate() {
                let ankle = track.leg.ankle;
                let rotation = Trs::from_matrix(before.node_to_world[ankle.index()]).rotation;
                let mut place = track.ankle[frame] + track.shifts[frame];
                let way = place - pose.position(track.leg.thigh);
                let rise = hips::rise_to_reach(way, track.reach(frame), up).unwrap_or(0.0);
                place += up * rise.min(track.slack());
                let goal = Goal::at(place).with_rotation(rotation);
                let missed = two_bone(&mut pose, [track.leg.thigh, track.leg.knee, ankle], &goal, None) * metres;
                track.turn(frame, &mut pose, up, floor);
                for node in [track.leg.thigh, track.leg.knee].iter().chain(&track.foot) {
                    self.frames.set_rotation_of(frame, *node, &pose);
                }
                if missed > OUT_OF_REACH {
                    report.out_of_reach[side] += 1;
                    report.farthest_out_of_reach[side] = report.farthest_out_of_reach[side].max(missed);
                }
                report.largest_shift = report.largest_shift.max(track.shifts[frame].length() * metres);
                track.place(frame, &pose);
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

    /// Moves the whole figure in a frame.
    fn carry(&mut self, scene: &Scene, frame: usize, pose: &mut Pose, way: Vec3) {
        let Some(trs) = self.frames.get(frame, self.mover) else {
            return;
        };
        let parent = scene.nodes[self.mover.index()].parent;
        let to_parent = parent.map_or(glam::Mat4::IDENTITY, |parent| {
            pose.node_to_world[parent.index()].inverse()
        });
        self.moved = true;
        let translation = trs.translation + to_parent.transform_vector3(way);
        self.frames.set(frame, self.mover, Trs { translation, ..trs });
        pose.node_to_parent[self.mover.index()].w_axis = translation.extend(1.0);
        pose.update_below(self.mover);
    }

    /// Makes the frames the keys of what changed.
    fn write(&self, scene: &mut Scene, animation: usize) {
        let moved = if self.moved {
            std::slice::from_ref(&self.mover)
        } else {
            &[]
        };
        self.frames.write(scene, animation, &self.turned, moved);
    }
}
