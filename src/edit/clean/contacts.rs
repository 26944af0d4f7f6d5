//! Contacts: feet that stand do not slide.

use super::work::Work;
use crate::edit::foot_lock::{FootLockOptions, FootLockReport, foot_lock};
use crate::edit::frames::Frames;
use crate::error::Result;

/// Feet that slide less than this in contact are left where nothing else was changed, in m/s.
pub(super) const LEAST_SKATE: f64 = 0.16;

/// Locks the feet, where they slide or the motion was changed before, and says what it did: an empty text if nothing.
pub(super) fn lock(work: &mut Work<'_>, animation: usize, is_changed: bool, skate: Option<f64>) -> Result<String> {
    if !is_changed && skate.is_none_or(|skate| skate < LEAST_SKATE) {
        return Ok(String::new());
    }
    let mut scene = work.scene.clone();
    work.frames.write_all(&mut scene, animation);
    let options = FootLockOptions::default().humanoid(work.figure.humanoid.clone());
    let report: FootLockReport = foot_lock(&mut scene, animation, &options)?;
    work.frames = Frames::new(&scene, animation, work.frames.nodes())?;
    Ok(match report.contacts {
        0 => String::new(),
        contacts => format!("{contacts} contacts of the feet held"),
    })
}
