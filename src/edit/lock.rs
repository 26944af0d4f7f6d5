//! Holds feet still while they stand.
//!
//! In contact, the step by which a foot's point of contact slides from frame to frame is taken back, so that a foot may
//! roll from heel to ball, and turn, but not slide. Each foot is shifted as a whole and keeps its rotation in the
//! world; [two-bone inverse kinematics](mocap_scene::Pose::bend_limb) lets the leg follow. Between contacts the shift
//! eases out and in without a jump of its speed. Compare Kovar, Schreiner and Gleicher, "Footskate cleanup for motion
//! capture editing" (2002), which lengthens bones where a leg is too short; here the hips give way so that legs keep
//! the length that they have, above all those that are nearly straight, whose knees a millimetre moves by centimetres.

mod follow;
mod hips;
mod hold;
mod knee;
mod leg;
mod legs;
mod pace;
pub(crate) mod shift;
mod sole;

use mocap_figure::{Figure, Humanoid};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::{not_negative, positive};
use mocap_scene::options::setters;
use mocap_scene::scene::{NodeId, Scene};
use serde::Serialize;

use self::follow::Follow;
#[doc(hidden)]
pub use self::follow::Followed;
use self::hold::Hold;
use self::legs::Legs;
#[doc(hidden)]
pub use self::sole::SolePoint;
use super::body::figure_of;
use super::contacts::{ContactOptions, DetectedContacts, detect};

/// Options of [`foot_lock()`].
///
/// [`foot_lock()`](crate::foot_lock()) has an example.
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
    /// For each of the known points the height along the up axis to which it is brought in contact, in metres; empty
    /// where they keep theirs.
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
            levels: Vec::new(),
        }
    }
}

/// What [`foot_lock()`] changed. Lengths are in metres.
///
/// [`foot_lock()`](crate::foot_lock()) has an example.
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
    /// The largest ratio of the speed of a foot to its speed without the lock around that moment: at most 1.2, or the
    /// foot gives way.
    pub speed_ratio: f32,
    /// The largest ratio of accelerations likewise: at most 1.5.
    pub acceleration_ratio: f32,
    /// The frames in which the left and the right foot give way to the motion without the lock.
    pub given_way: [usize; 2],
}

/// Holds the feet of `animation`, an index into the animations of `scene`, still while they are in contact, and above
/// the floor. Bones keep their lengths.
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
/// As [`ContactOptions::detect`](crate::ContactOptions::detect); [`Code::NotHumanoid`] also where a leg lacks a
/// joint, and [`Code::InvalidValue`] where known contacts have another number of frames, or the floor is more than a
/// leg above the feet. `scene` is then unchanged.
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
    let levels: Vec<f32> = options.levels.iter().map(|level| level / figure.metres()).collect();
    let hold = |leg| Hold::new(scene, &figure, leg, &contacts, &levels);
    let mut feet: Vec<Hold> = std::mem::take(&mut legs.legs).into_iter().map(hold).collect();
    let report = legs.change(scene, &figure, floor, &mut feet, |feet, shifts| {
        hips::spare_knees(feet, shifts, figure.up_direction(), floor, blend, limit)
    });
    legs.write(scene, animation);
    Ok(report)
}

/// Holds the feet of a retargeted motion still while those of the other body are in contact, and as high above the
/// floor as they are there. `figure` is the one of the scene that is moved.
#[doc(hidden)]
pub fn follow_feet(
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
