//! Holds feet still while they stand.
//!
//! In contact, the step by which a foot's point of contact slides from frame to frame is taken back, so that a foot may
//! roll from heel to ball, and turn, but not slide. Each foot is shifted as a whole and keeps its rotation in the
//! world; [two-bone inverse kinematics](crate::ik::two_bone()) lets the leg follow. Between contacts the shift eases
//! out and in without a jump of its speed. Compare Kovar, Schreiner and Gleicher, "Footskate cleanup for motion capture
//! editing" (2002), which lengthens bones where a leg is too short; here the hips give way so that legs keep the length
//! that they have, above all those that are nearly straight, whose knees a millimetre moves by centimetres.

mod follow;
mod hips;
mod hold;
mod knee;
mod leg;
mod shift;
mod sole;
mod step;

use glam::Vec3;
use serde::Serialize;

use self::follow::Follow;
pub(crate) use self::follow::Followed;
use self::hold::Hold;
use self::leg::Foot;
pub(crate) use self::sole::SolePoint;
pub use self::step::FootLock;
use super::body::{Leg, and_below, figure_of, mover};
use super::contacts::{ContactOptions, DetectedContacts, detect};
use super::frames::Frames;
use crate::error::{Code, Diagnostic, Result};
use crate::figure::{Figure, Humanoid, HumanoidBone, Side};
use crate::ik::{Goal, two_bone};
use crate::limits::{not_negative, positive};
use crate::options::setters;
use crate::pose::{Pose, Trs};
use crate::scene::{NodeId, Scene};

/// Options of [`foot_lock()`].
///
/// [`foot_lock()`](crate::edit::foot_lock()) has an example.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
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

setters! {
    FootLockOptions {
        contacts: ContactOptions,
        known: Option<DetectedContacts>,
        blend: f64,
        largest_change: Option<f64>,
        floor: Option<f32>,
        humanoid: Option<Humanoid>,
    }
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
///
/// [`foot_lock()`](crate::edit::foot_lock()) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FootLockReport {
    /// How far the feet slid while in contact, all steps together.
    pub slide_before: f64,
    /// The same afterwards.
    pub slide_after: f64,
    /// The number of contacts.
    pub contacts: usize,
    /// The largest shift of a foot.
    pub largest_shift: f32,
    /// The deepest point of a foot below the floor before.
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
    let figure = figure_of(scene, options.humanoid.as_ref())?;
    let mut legs = Legs::new(scene, animation, &figure, &[])?;
    let detected = |legs: &Legs| detect(scene, &legs.frames, &figure, &options.contacts);
    let contacts = match &options.known {
        Some(known) => {
            legs.check(known)?;
            known.clone()
        }
        None => detected(&legs),
    };
    let rests = match options.known {
        // Contacts may be those of another body, whose floor is elsewhere.
        Some(_) => detected(&legs).floor,
        None => contacts.floor,
    };
    let floor = options.floor.unwrap_or(rests);
    let leg = legs.length(scene) * figure.metres();
    // One below the feet is far from none of them.
    if !floor.is_finite() || floor - rests > leg {
        let message = format!(
            "floor must be finite and at most {leg:.3} m, the length of a leg, above where the feet rest, {rests:.3} m, got {floor}"
        );
        return Err(Diagnostic::new(Code::InvalidValue, message).into());
    }
    let limit = options
        .largest_change
        .map_or(f32::INFINITY, |metres| metres as f32 / figure.metres());
    let (blend, floor) = (legs.frames.frames_in(options.blend), floor / figure.metres());
    let hold = |leg| Hold::new(scene, &figure, leg, &contacts);
    let mut feet: Vec<Hold> = std::mem::take(&mut legs.legs).into_iter().map(hold).collect();
    let report = legs.change(scene, &figure, floor, &mut feet, |feet, shifts| {
        hips::spare_knees(feet, shifts, figure.up_direction(), floor, blend, limit)
    });
    legs.write(scene, animation);
    Ok(report)
}

/// Holds the feet of a retargeted motion still while those of the other body are in contact, and as high above the
/// floor as they are there. `figure` is the one of the scene that is moved.
pub(crate) fn follow_feet(
    scene: &mut Scene,
    animation: usize,
    figure: &Figure,
    followed: &Followed<'_>,
) -> Result<FootLockReport> {
    let pivots: Vec<NodeId> = followed
        .soles
        .iter()
        .flatten()
        .filter_map(|point| point.pivot)
        .collect();
    let mut legs = Legs::new(scene, animation, figure, &pivots)?;
    legs.check(followed.contacts)?;
    let blend = legs.frames.frames_in(FootLockOptions::default().blend);
    let follow = |leg| Follow::new(scene, figure, leg, followed);
    let mut feet: Vec<Follow> = std::mem::take(&mut legs.legs).into_iter().map(follow).collect();
    let report = legs.change(scene, figure, followed.floor, &mut feet, |feet, shifts| {
        hips::follow(feet, &shifts, figure.up_direction(), blend)
    });
    legs.write(scene, animation);
    Ok(report)
}

/// The frames of a motion whose legs are to be changed.
struct Legs {
    frames: Frames,
    legs: Vec<(Side, Leg)>,
    /// The node that carries the figure.
    mover: NodeId,
    /// The joints that turn.
    turned: Vec<NodeId>,
    /// Whether the figure is shifted.
    moved: bool,
}

impl Legs {
    fn new(scene: &Scene, animation: usize, figure: &Figure, pivots: &[NodeId]) -> Result<Self> {
        let hips = figure.humanoid.joint(HumanoidBone::Hips);
        let legs: Option<Vec<_>> = Side::ALL
            .into_iter()
            .map(|side| Some((side, Leg::new(&figure.humanoid, side)?)))
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
    fn length(&self, scene: &Scene) -> f32 {
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

    /// Changes the frames as `feet` ask for it. `floor` is in units of the scene. `hips` finds the shifts of the hips
    /// and completes those of the feet, of which it gets what is known.
    fn change<F: Foot>(
        &mut self,
        scene: &Scene,
        figure: &Figure,
        floor: f32,
        feet: &mut [F],
        hips: impl FnOnce(&mut [F], Vec<Vec<Option<Vec3>>>) -> Vec<Vec3>,
    ) -> FootLockReport {
        let (up, metres) = (figure.up_direction(), figure.metres());
        let mut pose = Pose::rest(scene);
        for frame in 0..self.frames.len() {
            self.frames.pose(frame, &mut pose);
            for foot in &mut *feet {
                foot.see(frame, &mut pose, up, floor);
            }
        }
        let rate = self.frames.rate as f32;
        let known = feet.iter().map(|foot| foot.known_shifts(up, rate)).collect();
        let carried = hips(feet, known);
        let heights = || carried.iter().map(|carried| carried.dot(up));
        let slide = |feet: &[F]| feet.iter().map(|foot| foot.slide(up)).sum::<f64>() * f64::from(metres);
        let mut report = FootLockReport {
            slide_before: slide(feet),
            contacts: feet.iter().map(|foot| foot.leg().contacts()).sum(),
            deepest_before: feet.iter().map(|foot| foot.leg().deepest(floor)).fold(0.0, f32::max) * metres,
            hips_lowered: heights().map(|height| -height).fold(0.0, f32::max) * metres,
            hips_raised: heights().fold(0.0, f32::max) * metres,
            ..FootLockReport::default()
        };
        self.apply(scene, figure, feet, &carried, floor, &mut report);
        report.slide_after = slide(feet);
        report
    }

    /// Moves the hips by `carried` and the feet by their shifts, and adds to the report what that changed.
    fn apply<F: Foot>(
        &mut self,
        scene: &Scene,
        figure: &Figure,
        feet: &mut [F],
        carried: &[Vec3],
        floor: f32,
        report: &mut FootLockReport,
    ) {
        let mut pose = Pose::rest(scene);
        let mut before = pose.clone();
        for (frame, &carried) in carried.iter().enumerate() {
            self.frames.pose(frame, &mut pose);
            if carried == Vec3::ZERO && !feet.iter().any(|foot| foot.is_changed(frame, floor)) {
                feet.iter_mut()
                    .for_each(|foot| foot.leg_mut().replace_points(frame, &pose));
                continue;
            }
            before.clone_from(&pose);
            if carried != Vec3::ZERO {
                self.carry(scene, frame, &mut pose, carried);
            }
            for (side, foot) in feet.iter_mut().enumerate() {
                let missed = self.place(foot, frame, (&before, &mut pose), figure, floor);
                if missed > OUT_OF_REACH {
                    report.out_of_reach[side] += 1;
                    report.farthest_out_of_reach[side] = report.farthest_out_of_reach[side].max(missed);
                }
                let shift = foot.leg().shifts[frame].length() * figure.metres();
                report.largest_shift = report.largest_shift.max(shift);
                foot.leg_mut().replace_points(frame, &pose);
            }
            for index in 0..scene.nodes.len() {
                let node = NodeId::new(index);
                let change = pose.position(node).distance(before.position(node)) * figure.metres();
                if change > report.largest_other_change && !feet.iter().any(|foot| foot.leg().foot.contains(&node)) {
                    report.largest_other_change = change;
                    report.largest_other_joint.clone_from(&scene.nodes[index].name);
                }
            }
        }
    }

    /// Brings one foot to its goal in a frame. Returns how far it is from there, in metres.
    fn place<F: Foot>(
        &mut self,
        foot: &F,
        frame: usize,
        (before, pose): (&Pose, &mut Pose),
        figure: &Figure,
        floor: f32,
    ) -> f32 {
        let (leg, up) = (foot.leg(), figure.up_direction());
        let [thigh, knee, ankle] = [leg.leg.thigh, leg.leg.knee, leg.leg.ankle];
        let rotation = Trs::from_matrix(before.node_to_world[ankle.index()]).rotation;
        let mut position = leg.ankle[frame] + leg.shifts[frame];
        let offset = position - pose.position(thigh);
        let rise = hips::rise_to_reach(offset, leg.reach(frame), up).unwrap_or(0.0);
        position += up * rise.min(foot.slack());
        let goal = Goal::at(position).with_rotation(rotation);
        let missed = two_bone(pose, [thigh, knee, ankle], &goal, None) * figure.metres();
        foot.turn(frame, pose, up, floor);
        for node in [thigh, knee].iter().chain(&leg.foot) {
            self.frames.set_rotation_of(frame, *node, pose);
        }
        missed
    }

    /// Moves the whole figure in a frame.
    fn carry(&mut self, scene: &Scene, frame: usize, pose: &mut Pose, offset: Vec3) {
        let Some(trs) = self.frames.get(frame, self.mover) else {
            return;
        };
        let parent = scene.nodes[self.mover.index()].parent;
        let to_parent = parent.map_or(glam::Mat4::IDENTITY, |parent| {
            pose.node_to_world[parent.index()].inverse()
        });
        self.moved = true;
        let translation = trs.translation + to_parent.transform_vector3(offset);
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
