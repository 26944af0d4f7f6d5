//! Bones that change their length.

use mocap_scene::math::median::median;

use super::{Findings, confidence};
use crate::survey::motion::Motion;
use crate::survey::spans;
use crate::survey::thresholds::DefectKind::Breathing;

/// Bones shorter than this fraction of the skeleton's size are skipped, because their lengths are dominated by
/// rounding.
const SHORT: f32 = 0.004;
/// The least relative deviation of a span from the median length.
const BEGINS: f32 = 0.015;

pub(super) fn find(motion: &Motion, findings: &mut Findings<'_>) {
    findings.look_for(&[Breathing]);
    let size = motion.size();
    for node in 0..motion.nodes() {
        let Some(parent) = motion.bones[node].filter(|parent| motion.is_joint[*parent]) else {
            continue;
        };
        let lengths: Vec<f32> = (motion.starts..motion.frames)
            .map(|frame| motion.at(frame, node).distance(motion.at(frame, parent)))
            .collect();
        let usual = median(&mut lengths.clone()).unwrap_or(0.0);
        // Positions far from the origin are rounded to several micrometres.
        let least = lengths.iter().copied().fold(f32::INFINITY, f32::min);
        let most = lengths.iter().copied().fold(0.0, f32::max);
        if usual < SHORT * size || most - least < BEGINS * usual {
            continue;
        }
        let deviation = |at: usize| (lengths[at] - usual).abs() / usual;
        for [from, to] in spans(lengths.len(), |at| deviation(at) > BEGINS) {
            let percent = 100.0 * (from..=to).map(deviation).fold(0.0, f32::max);
            let frames = [from + motion.starts, to + motion.starts];
            findings.add(
                Breathing,
                frames,
                Some(&motion.names[node]),
                percent,
                confidence(percent, 3.0),
            );
        }
    }
}
