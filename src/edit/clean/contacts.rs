//! Contacts: stops the sliding of feet in stance.

use glam::Vec3;
use mocap_figure::contacts::ContactRule;
use mocap_scene::error::Result;
use mocap_scene::math::velocity::velocities;

use crate::contacts::{ContactOptions, ContactPoint, DetectedContacts, detect};
use crate::floor;
use crate::frames::Frames;
use crate::lock::{FootLockOptions, FootLockReport, foot_lock};
use crate::quantity::counted;
use crate::work::Work;

/// Locks the feet if they slide or if the motion was changed before. Returns a text about the changes, which is empty
/// if nothing changed.
pub(super) fn lock(work: &mut Work<'_>, animation: usize, is_changed: bool, skate: Option<f64>) -> Result<String> {
    if !is_changed && skate.is_none_or(|skate| skate < work.weights.least_skate) {
        return Ok(String::new());
    }
    let mut options = FootLockOptions::default().humanoid(work.figure.humanoid.clone());
    if is_changed {
        let (known, levels) = whole(work);
        options = options.known(known);
        options.levels = levels;
    }
    let mut scene = work.scene.clone();
    work.frames.write_all(&mut scene, animation);
    let report: FootLockReport = foot_lock(&mut scene, animation, &options)?;
    work.frames = Frames::new(&scene, animation, work.frames.nodes())?;
    Ok(match report.contacts {
        0 => String::new(),
        contacts => format!("{} of the feet locked", counted(contacts, "contact")),
    })
}

/// The contacts of a smoothed motion, with their beginnings and ends, and the height in metres at which each point of
/// the feet stands.
fn whole(work: &Work<'_>) -> (DetectedContacts, Vec<f32>) {
    let mut found = detect(work.scene, &work.frames, work.figure, &ContactOptions::default());
    let feet = floor::Feet::new(work);
    let mut levels = Vec::new();
    if let Some(floor) = floor::find(work) {
        for (point, (level, above)) in found.points.iter_mut().zip(floor.stands(&feet)) {
            levels.push(level as f32);
            point.at_rest = slow_and_low(point, &above, work);
            point.above_rest = above.iter().map(|above| *above as f32).collect();
        }
    }
    let (within, most) = (
        work.weights.contact_distance as f32 / work.metres,
        work.frames.frames_in(work.weights.contact_gap),
    );
    for point in &mut found.points {
        join(point, work.up, within, most);
        extend(point, work.up, within, work.weights.contact_height as f32);
    }
    (found, levels)
}

/// The frames in which a point with jitter is at rest, by its height above its resting level.
fn slow_and_low(point: &ContactPoint, above: &[f64], work: &Work<'_>) -> Vec<bool> {
    let rule = ContactRule {
        speed: work.weights.contact_speed,
        ..ContactRule::default()
    };
    let flat: Vec<f32> = point.positions.iter().flat_map(Vec3::to_array).collect();
    let velocities = velocities(&flat, 3, work.frames.rate);
    let speed = |velocity: &[f32]| f64::from(Vec3::from_slice(velocity).length() * work.metres);
    let speeds = velocities.chunks_exact(3).map(speed);
    rule.at_rest(above.iter().copied().zip(speeds), work.frames.rate)
}

/// Joins contacts at one place if the time between them is too short for a step, or if the foot does not rise. There, a
/// foot that shoots away and back or wanders along the ground has noise that looked like motion.
fn join(point: &mut ContactPoint, up: Vec3, within: f32, most: usize) {
    /// The least height in metres to which a foot rises in a step: the toes in a low step, plus some noise.
    const RISEN: f32 = 0.04;
    /// How far noise may move a foot along the ground, as a multiple of `within`.
    const WANDERED: f32 = 2.5;
    let intervals = point.intervals();
    let centre =
        |[first, last]: [usize; 2]| point.positions[first..=last].iter().sum::<Vec3>() / (last + 1 - first) as f32;
    let gaps: Vec<_> = intervals
        .windows(2)
        .filter(|pair| {
            let off = (centre(pair[1]) - centre(pair[0])).reject_from_normalized(up).length();
            let between = pair[0][1] + 1..pair[1][0];
            let above = point.above_rest.get(between.clone());
            let is_low = || above.is_some_and(|above| above.iter().all(|above| *above < RISEN));
            off < within && between.len() <= most || off < WANDERED * within && is_low()
        })
        .map(|pair| pair[0][1]..pair[1][0])
        .collect();
    for gap in gaps {
        point.at_rest[gap].fill(true);
    }
}

/// Adds to each contact the neighbouring frames in which the point is near its resting place.
fn extend(point: &mut ContactPoint, up: Vec3, within: f32, low: f32) {
    for [first, last] in point.intervals() {
        let positions_held = &point.positions[first..=last];
        let centre = positions_held.iter().sum::<Vec3>() / positions_held.len() as f32;
        let is_there = |frame: &usize| {
            let off = (point.positions[*frame] - centre).reject_from_normalized(up).length();
            off < within && point.above_rest[*frame] < low
        };
        let before = (0..first).rev().take_while(is_there).count();
        let after = (last + 1..point.positions.len()).take_while(is_there).count();
        point.at_rest[first - before..=last + after].fill(true);
    }
}
