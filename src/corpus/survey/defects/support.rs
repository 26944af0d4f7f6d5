//! Bodies that hover, bodies carried by an object that is not in the file, and clips that begin or end in the air.

use mocap_scene::math::median::median;

use super::{Findings, confidence, ramp};
use crate::survey::motion::{Body, Motion};
use crate::survey::spans;
use crate::survey::thresholds::DefectKind::{ClippedEnd, Floating, NoSupport};

/// The least height of the lowest joint of a floating body, in metres: a thick sole.
const HOVERS: f32 = 0.04;

/// Heights of the lowest joint, in leg lengths. At the first height or more, an object may carry the body; at the
/// second height or more, an object must carry the body. The hips of a lying body are lower.
const CARRIED: [f32; 2] = [0.2, 0.3];
/// Durations of hovering, in seconds. Above the first, hovering begins to count; above the second, it counts fully.
const SHORTEST: [f32; 2] = [0.2, 0.3];
/// Vertical accelerations of the hips, in m/s^2. A body in free fall accelerates by -9.81. Below the first value, the
/// body falls; above the second, it is carried.
const FALLS: [f32; 2] = [-6.0, -4.0];

/// The shortest clip from which the height of the floor is known, in seconds.
const TELLS: f64 = 0.3;

pub(super) fn find(motion: &Motion, body: &Body, findings: &mut Findings<'_>) {
    findings.look_for(&[Floating, NoSupport, ClippedEnd]);
    if motion.seconds() < TELLS {
        return;
    }
    let heights: Vec<f32> = (0..motion.frames).map(|frame| height(motion, body, frame)).collect();
    for [from, to] in spans(motion.frames, |frame| frame >= motion.starts && heights[frame] > HOVERS) {
        let seconds = (to + 1 - from) as f32 / motion.rate as f32;
        let rise = motion.rise((from + to) / 2, body.hips(), ((to - from) / 2).max(1));
        let weight = ramp(seconds, SHORTEST[0], SHORTEST[1]) * ramp(rise, FALLS[0], FALLS[1]);
        let usual = median(&mut heights[from..=to].to_vec()).unwrap_or(0.0);
        let carried = ramp(usual / body.leg, CARRIED[0], CARRIED[1]);
        findings.add(NoSupport, [from, to], None, seconds * carried * weight, 0.7);
        let centimetres = 100.0 * usual * (1.0 - carried) * weight;
        findings.add(Floating, [from, to], None, centimetres, confidence(centimetres, 6.0));
    }
    for frame in [motion.starts, motion.frames - 1] {
        let centimetres = 100.0 * heights[frame];
        findings.add(
            ClippedEnd,
            [frame, frame],
            None,
            centimetres,
            confidence(centimetres, 12.0),
        );
    }
}

/// The height of the lowest joint. For a point of the feet, the height above its resting height. For any other joint,
/// the height above the floor.
fn height(motion: &Motion, body: &Body, frame: usize) -> f32 {
    let joints = (body.hips()..motion.nodes()).filter(|node| motion.is_joint[*node]);
    let joints = joints.map(|node| motion.at(frame, node).y);
    let lowest = joints.fold(f32::INFINITY, f32::min) - body.contacts.floor;
    lowest.min(body.lowest_foot(frame))
}
