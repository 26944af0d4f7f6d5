//! Removes foot sliding during ground contact.
//!
//! In each frame of a contact, the lock shifts the foot back by the distance that the contact point slid. The shift
//! moves the foot as a whole. The shift keeps the foot's rotation in the world, so a foot may still roll from heel to
//! ball, and turn. [Two-bone inverse kinematics](mocap_scene::Pose::bend_limb) moves the leg. After a contact, the
//! shift fades out, and before the next contact it fades in, without a jump in speed.
//!
//! Kovar, Schreiner and Gleicher, "Footskate cleanup for motion capture editing" (2002), lengthen the bones of a leg
//! that is too short. This lock moves the hips instead, and bones keep their lengths. Nearly straight legs profit most,
//! because a shift of the foot by one millimetre moves the knee of such a leg by centimetres.

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
    /// The thresholds that decide when a foot is in contact.
    pub contacts: ContactOptions,
    /// The contacts, if the caller knows them, for example from the source of a retargeted motion. The known contacts
    /// must have as many frames as the motion. Default: `None`, the lock finds the contacts.
    pub known: Option<DetectedContacts>,
    /// Seconds before a contact during which the shift of the foot fades in, and after a contact during which it fades
    /// out. Default: 0.2.
    pub blend: f64,
    /// The largest distance by which the lock may move a joint that is not part of a foot, in metres. If a full lock
    /// would move a knee or the hips farther, a part of the sliding remains. Default: `None`, no limit.
    pub largest_change: Option<f64>,
    /// The height of the floor along the up axis, in metres. Default: the height at which the feet rest.
    pub floor: Option<f32>,
    /// The bones, if the caller knows them.
    pub humanoid: Option<Humanoid>,
    /// The weights of the lock.
    pub weights: FootLockWeights,
    /// For each point of `known`, its height along the up axis in contact, in metres. If the list is empty, each point
    /// keeps its height.
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

/// The report of [`foot_lock()`]. Lengths are in metres.
///
/// [`foot_lock()`](crate::foot_lock()) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FootLockReport {
    /// The distance that the feet slid during contacts before the lock, as the sum over all frames.
    pub slide_before: f64,
    /// The distance that the feet slide during contacts after the lock, as the sum over all frames.
    pub slide_after: f64,
    /// The number of contacts.
    pub contacts: usize,
    /// The largest distance by which the lock shifted a foot.
    pub largest_shift: f32,
    /// The depth of the deepest point of a foot below the floor, before the lock.
    pub deepest_before: f32,
    /// The largest distance by which the lock lowered the hips.
    pub hips_lowered: f32,
    /// The largest distance by which the lock raised the hips.
    pub hips_raised: f32,
    /// The largest distance by which the lock moved a joint that is not part of a foot, such as a knee or the head.
    pub largest_other_change: f32,
    /// The name of the joint with `largest_other_change`.
    pub largest_other_joint: String,
    /// For the left and the right leg, the number of frames in which the leg is too short to bring the foot to its
    /// target.
    pub out_of_reach: [usize; 2],
    /// For the left and the right leg, the largest distance of the foot from its target in the frames of
    /// `out_of_reach`.
    pub farthest_out_of_reach: [f32; 2],
    /// The largest ratio of the speed of a foot after the lock to its speed before the lock, around the same frame. If
    /// the ratio would be above [`FootLockWeights::speed_ratio`], the lock shifts the foot less, so that some sliding
    /// remains.
    pub speed_ratio: f32,
    /// The largest ratio of the acceleration of a foot after the lock to its acceleration before the lock, around the
    /// same frame. If the ratio would be above [`FootLockWeights::acceleration_ratio`], the lock shifts the foot less.
    pub acceleration_ratio: f32,
    /// For the left and the right foot, the number of frames in which the lock shifts the foot less, so that some
    /// sliding remains.
    pub given_way: [usize; 2],
}

/// Removes the foot sliding of `animation`, an index into the animations of `scene`, and keeps the feet above the
/// floor. Bones keep their lengths.
///
/// For an animal on four legs, only the option `blend` has an effect. The lock holds each paw in stance at its mean
/// position, and finds contacts relative to the length of the legs.
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
/// - The errors of [`ContactOptions::detect`](crate::ContactOptions::detect)
/// - [`Code::NotHumanoid`] also if a leg lacks a joint
/// - [`Code::InvalidValue`] if `known` has another number of frames, if the floor is higher above the feet than a leg
///   is long, or if a weight is out of its range
///
/// After an error, `scene` is unchanged.
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
        // The known contacts may come from another body with another floor. So the height of the floor comes from
        // contacts that are found in this motion.
        Some(_) => detected(&legs).floor,
        None => contacts.floor,
    };
    let floor = options.floor.unwrap_or(rests);
    let leg = legs.length(scene) * figure.metres();
    // A floor far below the feet is accepted, because it moves no foot.
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

/// Removes the foot sliding of a retargeted motion during the contacts of its source. The feet get the heights above
/// the floor that they have in the source. `figure` is the figure of `scene`.
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
