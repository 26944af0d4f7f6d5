//! Doubled and dropped frames, flips, exchanged sides, noise, slope and drift. The survey finds them in the same way as
//! `mocap clean`.

use mocap_edit::MotionErrors;

use super::{Findings, confidence};
use crate::survey::motion::Motion;
use crate::survey::spans;
use crate::survey::thresholds::DefectKind::{
    Doubled, Drift, Dropped, Exchanged, FingerFlip, Flip, HeightDrift, Noise, Tilted,
};

/// The least speed of a joint, in m/s, at which a missing frame is visible: 3 mm per frame.
const SEEN: f32 = 0.1;

/// Half the window over which this speed is measured, in seconds: two frames of video.
const AROUND: f64 = 0.07;

pub(super) fn find(motion: &Motion, errors: &MotionErrors, findings: &mut Findings<'_>) {
    findings.look_for(&[Doubled, Dropped, Flip, FingerFlip, Noise]);
    for (kind, frames) in [(Doubled, &errors.doubled), (Dropped, &errors.dropped)] {
        for [from, to] in spans(motion.frames, |frame| {
            frame >= motion.starts && frames.binary_search(&frame).is_ok()
        }) {
            if is_seen(motion, from) {
                findings.add(kind, [from, to], None, (to + 1 - from) as f32, 0.8);
            }
        }
    }
    for (node, flipped) in &errors.flipped {
        let kind = if motion.is_detail[node.index()] {
            FingerFlip
        } else {
            Flip
        };
        for [from, to] in spans(flipped.len(), |frame| frame > motion.starts && flipped[frame]) {
            let joint = &motion.names[node.index()];
            findings.add(kind, [from, to], Some(joint), 1.0, 0.8);
        }
    }
    if motion.body.is_some() {
        of_body(motion, errors, findings);
    }
    for (node, metres) in &errors.noise {
        let millimetres = 1000.0 * *metres as f32;
        let joint = &motion.names[node.index()];
        let whole = [motion.starts, motion.frames - 1];
        findings.add(Noise, whole, Some(joint), millimetres, confidence(millimetres, 8.0));
    }
}

/// Whether the body moves around a frame, so that a missing or doubled frame is visible. Either the root moves, or a
/// joint moves relative to the root.
fn is_seen(motion: &Motion, frame: usize) -> bool {
    let around = motion.frames_in(AROUND);
    let speed = |node: usize| motion.velocity(frame, node, around).length();
    let root = motion.velocity(frame, 0, around);
    let joints = (1..motion.nodes()).map(|node| (motion.velocity(frame, node, around) - root).length());
    joints.fold(speed(0), f32::max) > SEEN
}

fn of_body(motion: &Motion, errors: &MotionErrors, findings: &mut Findings<'_>) {
    findings.look_for(&[Exchanged, Tilted, Drift, HeightDrift]);
    let exchanged = &errors.exchanged;
    for [from, to] in spans(exchanged.len(), |frame| frame >= motion.starts && exchanged[frame]) {
        findings.add(Exchanged, [from, to], None, (to + 1 - from) as f32, 0.8);
    }
    let whole = [motion.starts, motion.frames - 1];
    if let Some(degrees) = errors.slope {
        let degrees = degrees as f32;
        findings.add(Tilted, whole, None, degrees, confidence(degrees, 1.0));
    }
    for (kind, metres, least) in [(Drift, errors.drift, 6.0), (HeightDrift, errors.height_drift, 10.0)] {
        let centimetres = 100.0 * metres.unwrap_or_default() as f32;
        findings.add(kind, whole, None, centimetres, confidence(centimetres, least));
    }
}
