//! The part `contacts` of the cleaning: stops the sliding of feet in stance.

use glam::Vec3;
use mocap_figure::contacts::ContactRule;
use mocap_scene::error::Result;

use super::soles;
use crate::contacts::{ContactOptions, ContactPoint, DetectedContacts, detect};
use crate::floor;
use crate::frames::Frames;
use crate::lock::{FootLockOptions, FootLockReport, FootLockWeights, foot_lock, lock_frames};
use crate::quantity::counted;
use crate::work::Work;

/// The largest speed of a locked foot, as a multiple of the speed of the same foot without the lock. The speed without
/// the lock includes noise. With the smaller ratio of `foot-lock`, feet of noisy walks still slide at 5 to 20 cm/s.
const SPEED_RATIO: f64 = 2.0;

/// The largest acceleration of a locked foot, as a multiple of its acceleration without the lock. The ratio is larger
/// than [`SPEED_RATIO`], because noise has more effect on accelerations than on speeds.
const ACCELERATION_RATIO: f64 = 3.0;

/// The speed of a foot in contact is also measured over this time, in seconds. Over this time, noise that lasts for a
/// tenth of a second moves a foot more slowly than from frame to frame. A footstep of a walk lasts three times as long.
const SPEED_OVER: f64 = 0.2;

/// Locks the feet if they slide, or if much noise was removed. Returns a message with the number of locked contacts.
/// The message is empty if no contact was locked. `is_noisy` states whether any noise was removed, and `is_changed`
/// whether most of the jitter was removed. With `steadies`, feet that stand also keep their rotation.
pub(super) fn lock(
    work: &mut Work<'_>,
    animation: usize,
    [is_noisy, is_changed]: [bool; 2],
    skate: Option<f64>,
    steadies: bool,
) -> Result<String> {
    if !is_changed && skate.is_none_or(|skate| skate < work.weights.least_skate) {
        return Ok(String::new());
    }
    let mut options = FootLockOptions::default();
    if !work.is_humanoid() {
        let mut scene = work.scene.clone();
        work.frames.write_all(&mut scene, animation);
        let report = foot_lock(&mut scene, animation, &options)?;
        work.frames = Frames::new(&scene, animation, work.frames.nodes())?;
        return Ok(about(&report));
    }
    let mut frames = work.frames.clone();
    if is_noisy {
        let (known, levels) = whole(work);
        if is_changed {
            options.levels = levels;
            if steadies {
                soles::steady(work, &known, &mut frames);
            }
        }
        let ratios = FootLockWeights::new().speed_ratio(SPEED_RATIO);
        options = options
            .known(known)
            .weights(ratios.acceleration_ratio(ACCELERATION_RATIO));
    }
    frames.settle();
    let (mut frames, report) = lock_frames(work.scene, work.figure, frames, &options)?;
    frames.settle();
    work.frames = frames;
    Ok(about(&report))
}

fn about(report: &FootLockReport) -> String {
    match report.contacts {
        0 => String::new(),
        contacts => format!("{} of the feet locked", counted(contacts, "contact")),
    }
}

/// The contacts of a smoothed motion. They are joined and extended, because noise cuts contacts short. Also the height
/// in metres of each point of the feet in contact.
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
        // The lock reads only `at_rest`, so these lists are dropped.
        (point.positions, point.above_rest) = Default::default();
    }
    (found, levels)
}

/// For each frame, whether a point with jitter is at rest. `above` has the height of the point above its resting level.
fn slow_and_low(point: &ContactPoint, above: &[f64], work: &Work<'_>) -> Vec<bool> {
    let rule = ContactRule {
        speed: work.weights.contact_speed,
        ..ContactRule::default()
    };
    let (positions, rate) = (&point.positions, work.frames.rate);
    let speed = |half: usize, frame: usize| {
        let (from, to) = (frame.saturating_sub(half), (frame + half).min(positions.len() - 1));
        let moved = f64::from(positions[to].distance(positions[from]) * work.metres);
        moved * rate / (to - from).max(1) as f64
    };
    let half = work.frames.frames_in(0.5 * SPEED_OVER);
    let speeds = (0..positions.len()).map(|frame| speed(1, frame).min(speed(half, frame)));
    rule.at_rest(above.iter().copied().zip(speeds), work.frames.rate)
}

/// Joins two contacts at one position if the time between them is too short for a step, or if the foot does not rise
/// between them. Noise that looked like motion can move a foot away and back, or along the ground.
fn join(point: &mut ContactPoint, up: Vec3, within: f32, most: usize) {
    /// The least height in metres to which a foot rises in a step: the toes in a low step, plus some noise.
    const RISEN: f32 = 0.04;
    /// The largest distance by which noise may move a foot along the ground, as a multiple of `within`.
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
