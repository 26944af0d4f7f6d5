//! Removes foot sliding during ground contact.
//!
//! In each frame of a contact, the lock takes back the step by which the contact point slides. A foot may still roll
//! from heel to ball, and turn. The lock shifts a foot as a whole and keeps its rotation in the world;
//! [two-bone inverse kinematics](mocap_scene::Pose::bend_limb) moves the leg. Between contacts the shift eases out and
//! in without a jump in speed.
//!
//! Kovar, Schreiner and Gleicher, "Footskate cleanup for motion capture editing" (2002), lengthen the bones of a leg
//! that is too short. Here the hips give way instead, and bones keep their lengths. Nearly straight legs need this
//! most: one millimetre at the foot moves their knees by centimetres.

mod animal;
mod follow;
mod hips;
mod hold;
mod knee;
mod leg;
mod legs;
mod pace;
pub(crate) mod shift;
mod sole;
mod weights;

use mocap_figure::{Figure, Humanoid};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::{not_negative, positive};
use mocap_scene::options::setters;
use mocap_scene::scene::{NodeId, Scene};
use serde::Serialize;

use self::follow::FootFollower;
#[doc(hidden)]
pub use self::follow::FootGuide;
use self::hold::Hold;
use self::legs::Legs;
#[doc(hidden)]
pub use self::sole::SolePoint;
pub use self::weights::FootLockWeights;
use super::body::{animal_of, figure_of};
use super::contacts::{ContactOptions, DetectedContacts, detect};
use super::frames::Frames;

/// Options of [`foot_lock()`].
///
/// [`foot_lock()`](crate::foot_lock()) has an example.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FootLockOptions {
    /// When a foot is in contact.
    pub contacts: ContactOptions,
    /// Known contacts, for example of the source of a retargeted motion. They must have as many frames as the motion.
    /// Default: `None`, contacts are detected.
    pub known: Option<DetectedContacts>,
    /// Seconds in which a shift fades out after a contact, and fades in before a contact. Default: 0.2.
    pub blend: f64,
    /// The largest change of any other joint, in metres. The lock of a foot that would move a knee or the hips farther
    /// is relaxed, and the foot keeps a part of its slide. Default: `None`, no lock is relaxed for this reason.
    pub largest_change: Option<f64>,
    /// The height of the floor along the up axis, in metres. Default: where the feet rest.
    pub floor: Option<f32>,
    /// The bones, if the caller knows them.
    pub humanoid: Option<Humanoid>,
    /// The weights of the lock.
    pub weights: FootLockWeights,
    /// The height along the up axis of each known point in contact, in metres. Empty: each point keeps its height.
    pub(super) levels: Vec<f32>,
}

setters! {
    FootLockOptions {
        contacts: ContactOptions,
        known: Option<DetectedContacts>,
        blend: f64,
        largest_change: Option<f64>,
        floor: Option<f32>,
        humanoid: Option<Humanoid>,
        weights: FootLockWeights,
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
            weights: FootLockWeights::default(),
            levels: Vec::new(),
        }
    }
}

/// What [`foot_lock()`] changed. Lengths are in metres.
///
/// [`foot_lock()`](crate::foot_lock()) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FootLockReport {
    /// The distance that the feet slid in contact, summed over all frames.
    pub slide_before: f64,
    /// The distance that they slide after the lock.
    pub slide_after: f64,
    /// The number of contacts.
    pub contacts: usize,
    /// The largest shift of a foot.
    pub largest_shift: f32,
    /// The deepest point of a foot below the floor before.
    pub deepest_before: f32,
    /// The largest distance by which the hips were lowered.
    pub hips_lowered: f32,
    /// The largest distance by which the hips were raised.
    pub hips_raised: f32,
    /// The largest change of a joint that belongs to no foot, such as a knee or the head.
    pub largest_other_change: f32,
    /// The name of that joint.
    pub largest_other_joint: String,
    /// The frames in which the left and the right leg are too short to reach the target of the foot.
    pub out_of_reach: [usize; 2],
    /// The largest distance of such a foot from its target.
    pub farthest_out_of_reach: [f32; 2],
    /// The largest ratio of the speed of a foot to its speed without the lock, around the same frame. Above
    /// [`FootLockWeights::speed_ratio`] the lock is relaxed.
    pub speed_ratio: f32,
    /// The largest ratio of accelerations, measured in the same way. Above
    /// [`FootLockWeights::acceleration_ratio`] the lock is relaxed.
    pub acceleration_ratio: f32,
    /// The frames in which the lock of the left and of the right foot is relaxed.
    pub given_way: [usize; 2],
}

/// Removes the foot sliding of `animation`, an index into the animations of `scene`, and keeps the feet above the
/// floor. Bones keep their lengths.
///
/// For an animal on four legs, only `blend` counts: paws in stance are held at their mean place, and contacts are found
/// relative to the length of its legs.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::edit::{FootLockOptions, foot_lock};
///
/// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// let report = foot_lock(&mut scene, 0, &FootLockOptions::default())?;
/// assert!(report.slide_after < 0.01 * report.slide_before);
/// # Ok::<(), mocap::Error>(())
/// ```
///
/// # Errors
/// - As [`ContactOptions::detect`](crate::ContactOptions::detect)
/// - [`Code::NotHumanoid`] also if a leg lacks a joint
/// - [`Code::InvalidValue`] if known contacts have another number of frames, the floor is more than a leg above the
///   feet, or a weight is out of its range
///
/// `scene` is then unchanged.
pub fn foot_lock(scene: &mut Scene, animation: usize, options: &FootLockOptions) -> Result<FootLockReport> {
    options.contacts.check()?;
    options.weights.check()?;
    not_negative(Code::InvalidValue, "blend", options.blend)?;
    if let Some(change) = options.largest_change {
        positive(Code::InvalidValue, "largest-change", change)?;
    }
    let known = options.humanoid.as_ref();
    if let Some((figure, animal)) = animal_of(scene, known) {
        return animal::lock_paws(scene, animation, (&figure, &animal), options.blend);
    }
    let figure = figure_of(scene, known)?;
    let frames = Frames::reading(scene, animation, &[])?;
    let (legs, report) = locked(scene, &figure, frames, options)?;
    legs.changes().write(scene, animation);
    Ok(report)
}

/// Locks the feet of `frames` as [`foot_lock()`] does. `figure` is the figure of `scene`.
pub(super) fn lock_frames<'a>(
    scene: &Scene,
    figure: &Figure,
    frames: Frames<'a>,
    options: &FootLockOptions,
) -> Result<(Frames<'a>, FootLockReport)> {
    let (legs, report) = locked(scene, figure, frames, options)?;
    Ok((legs.frames, report))
}

fn locked<'a>(
    scene: &Scene,
    figure: &Figure,
    frames: Frames<'a>,
    options: &FootLockOptions,
) -> Result<(Legs<'a>, FootLockReport)> {
    let mut legs = Legs::new(scene, figure, frames, &[])?;
    let detected = |legs: &Legs| detect(scene, &legs.frames, figure, &options.contacts);
    let found;
    let contacts = match &options.known {
        Some(known) => {
            legs.check(known)?;
            known
        }
        None => {
            found = detected(&legs);
            &found
        }
    };
    let rests = match options.known {
        // Known contacts may come from another body with another floor, so the floor is detected.
        Some(_) => detected(&legs).floor,
        None => contacts.floor,
    };
    let floor = options.floor.unwrap_or(rests);
    let leg = legs.length(scene) * figure.metres();
    // A floor below the feet is accepted: it moves no foot.
    if !floor.is_finite() || floor - rests > leg {
        let message = format!(
            "floor must be finite and at most {leg:.3} m (the length of a leg) above the resting height of the feet, {rests:.3} m, got {floor}"
        );
        return Err(Diagnostic::new(Code::InvalidValue, message).into());
    }
    let limit = options
        .largest_change
        .map_or(f32::INFINITY, |metres| metres as f32 / figure.metres());
    let (blend, floor) = (legs.blend(options.blend, &options.weights)?, floor / figure.metres());
    let levels: Vec<f32> = options.levels.iter().map(|level| level / figure.metres()).collect();
    let hold = |leg| Hold::new(scene, figure, leg, options.weights, contacts, &levels);
    let mut feet: Vec<Hold> = std::mem::take(&mut legs.legs).into_iter().map(hold).collect();
    let report = legs.change(scene, figure, floor, &mut feet, |feet, shifts| {
        hips::spare_knees(feet, shifts, figure.up_direction(), floor, blend, limit)
    });
    Ok((legs, report))
}

/// Removes the foot sliding of a retargeted motion during the contacts of its source. The feet get the source's heights
/// above the floor. `figure` is the figure of `scene`.
#[doc(hidden)]
pub fn follow_feet(
    scene: &mut Scene,
    animation: usize,
    figure: &Figure,
    followed: &FootGuide<'_>,
) -> Result<FootLockReport> {
    followed.weights.check()?;
    let pivots: Vec<NodeId> = followed
        .soles
        .iter()
        .flatten()
        .filter_map(|point| point.pivot)
        .collect();
    let mut legs = Legs::new(scene, figure, Frames::reading(scene, animation, &[])?, &pivots)?;
    legs.check(followed.contacts)?;
    let blend = legs.blend(FootLockOptions::default().blend, &followed.weights)?;
    let follow = |leg| FootFollower::new(scene, figure, leg, followed);
    let mut feet: Vec<FootFollower> = std::mem::take(&mut legs.legs).into_iter().map(follow).collect();
    let report = legs.change(scene, figure, followed.floor, &mut feet, |feet, shifts| {
        hips::follow(feet, &shifts, figure.up_direction(), blend)
    });
    legs.changes().write(scene, animation);
    Ok(report)
}
