//! How far coded tracks are from what they stand for: the proof, in double precision, of what was made in single.

use glam::{DQuat, DVec3};

use super::keys::Grid;
use super::motion::Motion;
use super::{FittedTrack, Rotation, Translation};

/// The largest distance between a joint and its place, and where it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Measured {
    /// In metres.
    pub(crate) max: f64,
    /// The root of the mean square of all distances.
    pub(crate) rms: f64,
    /// The node of the largest.
    pub(crate) node: usize,
    /// Its moment.
    pub(crate) tick: f64,
}

/// How a reader goes from one key to the next.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Way {
    /// Slerp, as the specification says.
    Arc,
    /// Component by component, then normalised, as many engines do.
    Chord,
}

/// Forward kinematics of both sides at every moment. Where decoders may differ, the error is the largest that any can
/// have. `times` are the 32-bit times of the frames in the file.
pub(super) fn measure(motion: &Motion, tracks: &[FittedTrack], times: &[f32], seconds: &[f64], way: Way) -> Measured {
    let joints = motion.joints.len();
    let mut here = vec![(DVec3::ZERO, DQuat::IDENTITY); joints];
    let mut there = here.clone();
    // The angle by which a decoder may turn each joint differently, and whether one above it may.
    let mut doubts = vec![(0.0, false); joints];
    let mut cursors = vec![(0usize, 0usize); joints];
    let mut measured = Measured::default();
    let mut squares = 0.0;
    for (frame, &second) in seconds.iter().enumerate() {
        for (index, joint) in motion.joints.iter().enumerate() {
            let (translation, rotation) = (joint.translation.at(frame), joint.rotation.at(frame));
            let source = (translation.as_dvec3(), rotation.as_dquat().normalize());
            let track = &tracks[index];
            let cursor = &mut cursors[index];
            let mut doubt = 0.0;
            let coded = (
                match &track.translation {
                    Translation::Still(value) => value.as_dvec3(),
                    Translation::Moving { grid, keys, .. } => {
                        let (key, share) = locate(grid, times, &mut cursor.0, second);
                        let from = keys[key].value.as_dvec3();
                        keys.get(key + 1)
                            .map_or(from, |to| from.lerp(to.value.as_dvec3(), share))
                    }
                },
                match &track.rotation {
                    Rotation::Still(value) => value.as_dquat().normalize(),
                    Rotation::Moving { grid, keys, .. } => {
                        let (key, share) = locate(grid, times, &mut cursor.1, second);
                        let from = keys[key].value.as_dquat().normalize();
                        doubt = keys[key].doubt();
                        if let Some(to) = keys.get(key + 1).filter(|_| share > 0.0) {
                            doubt = f64::max(doubt, to.doubt());
                        }
                        match keys.get(key + 1) {
                            Some(to) if share > 0.0 => mix(from, to.value.as_dquat().normalize(), share, way),
                            _ => from,
                        }
                    }
                },
            );
            let (own, coded) = match joint.parent {
                None => (source, coded),
                Some(parent) => {
                    let scale = f64::from(motion.joints[parent].scale);
                    (below(here[parent], source, scale), below(there[parent], coded, scale))
                }
            };
            (here[index], there[index]) = (own, coded);
            let doubt_above = joint.parent.is_some_and(|parent| doubts[parent].1);
            doubts[index] = (doubt, doubt > 0.0 || doubt_above);
            let mut error = own.0.distance(coded.0);
            if doubt_above {
                let mut above = joint.parent;
                while let Some(place) = above.filter(|place| doubts[*place].1) {
                    error += doubts[place].0 * own.0.distance(here[place].0);
                    above = motion.joints[place].parent;
                }
            }
            squares += error * error;
            // A NaN is the worst of all, and stays it.
            if error > measured.max || error.is_nan() {
                measured.max = error;
                measured.node = index;
                measured.tick = motion.ticks[frame];
            }
        }
    }
    measured.rms = (squares / (joints * motion.frames()).max(1) as f64).sqrt();
    measured
}

fn below(above: (DVec3, DQuat), own: (DVec3, DQuat), scale: f64) -> (DVec3, DQuat) {
    (above.0 + above.1 * (own.0 * scale), above.1 * own.1)
}

/// The last key that is not after `second`, and how far it is from there to the next.
fn locate(grid: &Grid, times: &[f32], cursor: &mut usize, second: f64) -> (usize, f64) {
    let time = |key: usize| f64::from(times[grid[key] as usize]);
    while *cursor + 1 < grid.len() && time(*cursor + 1) <= second {
        *cursor += 1;
    }
    let key = *cursor;
    if key + 1 == grid.len() || second <= time(key) {
        return (key, 0.0);
    }
    (key, (second - time(key)) / (time(key + 1) - time(key)))
}

fn mix(from: DQuat, to: DQuat, share: f64, way: Way) -> DQuat {
    match way {
        Way::Arc => from.slerp(to, share),
        Way::Chord => from.lerp(to, share),
    }
}
