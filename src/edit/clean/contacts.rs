//! Contacts: feet that stand do not slide.

use glam::Vec3;

use super::work::Work;
use crate::edit::contacts::{ContactOptions, ContactPoint, DetectedContacts, detect};
use crate::edit::foot_lock::{FootLockOptions, FootLockReport, foot_lock};
use crate::edit::frames::Frames;
use crate::error::Result;

/// Feet that slide less than this in contact are left where nothing else was changed, in m/s.
pub(super) const LEAST_SKATE: f64 = 0.16;
/// In a motion that was smoothed a foot comes to rest slowly and leaves slowly. It belongs to its contact while it is
/// within this distance of where it rests over the ground, in metres.
const WITHIN: f32 = 0.03;
/// It is then at most this high above where it rests, in metres.
const LOW: f32 = 0.08;

/// Locks the feet, where they slide or the motion was changed before, and says what it did: an empty text if nothing.
pub(super) fn lock(work: &mut Work<'_>, animation: usize, is_changed: bool, skate: Option<f64>) -> Result<String> {
    if !is_changed && skate.is_none_or(|skate| skate < LEAST_SKATE) {
        return Ok(String::new());
    }
    let mut options = FootLockOptions::default().humanoid(work.figure.humanoid.clone());
    if is_changed {
        options = options.known(whole(work));
    }
    let mut scene = work.scene.clone();
    work.frames.write_all(&mut scene, animation);
    let report: FootLockReport = foot_lock(&mut scene, animation, &options)?;
    work.frames = Frames::new(&scene, animation, work.frames.nodes())?;
    Ok(match report.contacts {
        0 => String::new(),
        contacts => format!("{contacts} contacts of the feet held"),
    })
}

/// The contacts of a motion that was smoothed, with their beginnings and ends.
fn whole(work: &Work<'_>) -> DetectedContacts {
    let mut found = detect(work.scene, &work.frames, work.figure, &ContactOptions::default());
    for point in &mut found.points {
        extend(point, work.up, WITHIN / work.metres);
    }
    found
}

/// Adds to each contact the frames beside it in which the point is where it rests.
fn extend(point: &mut ContactPoint, up: Vec3, within: f32) {
    for [first, last] in point.intervals() {
        let positions_held = &point.positions[first..=last];
        let centre = positions_held.iter().sum::<Vec3>() / positions_held.len() as f32;
        let is_there = |frame: &usize| {
            let off = (point.positions[*frame] - centre).reject_from_normalized(up).length();
            off < within && point.above_rest[*frame] < LOW
        };
        let before = (0..first).rev().take_while(is_there).count();
        let after = (last + 1..point.positions.len()).take_while(is_there).count();
        point.at_rest[first - before..=last + after].fill(true);
    }
}
