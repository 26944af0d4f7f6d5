//! How far coded tracks are from what they stand for: the proof, in double precision, of what was made in single.

use glam::{DMat3, DQuat, DVec3};

use super::code::CodedRotation;
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

/// How a reader goes from one key to the next, and what it makes of a quaternion whose length is not quite 1.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Way {
    /// Slerp, and made unit length, as the specification says.
    Arc,
    /// Component by component, then made unit length, as many engines do.
    Chord,
    /// Slerp, and taken as it is: a matrix made of it stretches what it turns. Babylon.js does that, and three.js but
    /// for keys that are near to one another.
    AsItIs,
}

/// The largest errors: of all, at each frame, and of each node.
pub(super) struct Errors {
    pub(super) measured: Measured,
    pub(super) frames: Vec<f64>,
    pub(super) nodes: Vec<f64>,
}

/// Forward kinematics of both sides at every moment, for every way of reading. Where decoders may differ, the error is
/// the largest that any can have.
///
/// `times` are the 32-bit times of the frames in the file, and the moments of comparison: at a cut the moment before is
/// another pose. `rounding` is how far the source itself may be off, being of 32-bit numbers; it counts as error.
pub(super) fn measure(motion: &Motion, tracks: &[FittedTrack], times: &[f32], rounding: f64) -> Errors {
    let ways = ways(motion, tracks);
    let joints = motion.joints.len();
    let mut here = vec![(DVec3::ZERO, DQuat::IDENTITY); joints];
    let mut there = vec![vec![(DVec3::ZERO, DMat3::IDENTITY); joints]; ways.len()];
    // The angle by which a decoder may turn each joint differently, and whether one above it may.
    let mut doubts = vec![(0.0, false); joints];
    let mut players: Vec<Player> = tracks.iter().map(|track| Player::new(track, times, &ways)).collect();
    let mut measured = Measured::default();
    let mut frames = vec![0.0; motion.frames()];
    let mut nodes = vec![0.0; joints];
    let mut squares = 0.0;
    for frame in 0..motion.frames() {
        let second = f64::from(times[frame]);
        for (index, joint) in motion.joints.iter().enumerate() {
            let scale = joint
                .parent
                .map_or(1.0, |parent| f64::from(motion.joints[parent].scale));
            let player = &mut players[index];
            let way = player.translation(second);
            let source = joint.translation.at(frame).as_dvec3() * scale;
            here[index].0 = match joint.parent {
                None => source,
                Some(parent) => here[parent].0 + here[parent].1 * source,
            };
            let mut error = 0.0;
            for there in &mut there {
                there[index].0 = match joint.parent {
                    None => way,
                    Some(parent) => there[parent].0 + there[parent].1 * (way * scale),
                };
                let off = here[index].0.distance_squared(there[index].0);
                // A NaN is the worst of all.
                if off > error || off.is_nan() {
                    error = off;
                }
            }
            // How a joint is turned that carries nothing, nobody asks.
            if !joint.children.is_empty() {
                let source = joint.rotation.at(frame).as_dquat().normalize();
                here[index].1 = joint.parent.map_or(source, |parent| here[parent].1 * source);
                let turns = player.rotations(second, &ways);
                for (turn, there) in std::iter::zip(turns, &mut there) {
                    there[index].1 = joint.parent.map_or(*turn, |parent| there[parent].1 * *turn);
                }
            }
            let mut error = error.sqrt() + rounding;
            let doubt_above = joint.parent.is_some_and(|parent| doubts[parent].1);
            doubts[index] = (player.doubt, player.doubt > 0.0 || doubt_above);
            if doubt_above {
                let mut above = joint.parent;
                while let Some(place) = above.filter(|place| doubts[*place].1) {
                    error += doubts[place].0 * here[index].0.distance(here[place].0);
                    above = motion.joints[place].parent;
                }
            }
            squares += error * error;
            for largest in [&mut frames[frame], &mut nodes[index]] {
                if error > *largest || error.is_nan() {
                    *largest = error;
                }
            }
            if error > measured.max || error.is_nan() {
                measured.max = error;
                measured.node = index;
                measured.tick = motion.ticks[frame];
            }
        }
    }
    measured.rms = (squares / (joints * motion.frames()).max(1) as f64).sqrt();
    Errors {
        measured,
        frames,
        nodes,
    }
}

/// Where every frame has a key nobody goes from one to the next.
fn ways(motion: &Motion, tracks: &[FittedTrack]) -> Vec<Way> {
    let is_full = |track: &FittedTrack| match &track.rotation {
        Rotation::Still(_) => true,
        Rotation::Moving { grid, .. } => grid.len() == motion.frames(),
    };
    let mut ways = vec![Way::Arc, Way::AsItIs];
    if !tracks.iter().all(is_full) {
        ways.push(Way::Chord);
    }
    ways
}

/// Plays one track, from its beginning on.
struct Player<'a> {
    track: &'a FittedTrack,
    times: &'a [f32],
    /// The keys of the translation and of the rotation that are played.
    cursors: [usize; 2],
    /// What the last rotation is, one a way.
    turns: Vec<DMat3>,
    /// The angle by which another decoder may turn it differently.
    doubt: f64,
}

impl<'a> Player<'a> {
    fn new(track: &'a FittedTrack, times: &'a [f32], ways: &[Way]) -> Self {
        let turns = match &track.rotation {
            Rotation::Still(value) => ways
                .iter()
                .map(|way| DMat3::from_quat(read(value.as_dquat(), None, 0.0, *way)))
                .collect(),
            Rotation::Moving { .. } => vec![DMat3::IDENTITY; ways.len()],
        };
        Self {
            track,
            times,
            cursors: [0; 2],
            turns,
            doubt: 0.0,
        }
    }

    fn translation(&mut self, second: f64) -> DVec3 {
        match &self.track.translation {
            Translation::Still(value) => value.as_dvec3(),
            Translation::Moving { grid, keys, .. } => {
                let (key, share) = locate(grid, self.times, &mut self.cursors[0], second);
                let from = keys[key].value.as_dvec3();
                match keys.get(key + 1) {
                    Some(to) if share > 0.0 => from.lerp(to.value.as_dvec3(), share),
                    _ => from,
                }
            }
        }
    }

    /// The rotation, one a way.
    fn rotations(&mut self, second: f64, ways: &[Way]) -> &[DMat3] {
        if let Rotation::Moving { grid, keys, .. } = &self.track.rotation {
            let (key, share) = locate(grid, self.times, &mut self.cursors[1], second);
            let to = keys.get(key + 1).filter(|_| share > 0.0);
            self.doubt = to.map_or(0.0, CodedRotation::doubt).max(keys[key].doubt());
            let (from, to) = (keys[key].value.as_dquat(), to.map(|to| to.value.as_dquat()));
            for (way, turn) in std::iter::zip(ways, &mut self.turns) {
                *turn = DMat3::from_quat(read(from, to, share, *way));
            }
        }
        &self.turns
    }
}

/// What a reader has between two keys.
fn read(from: DQuat, to: Option<DQuat>, share: f64, way: Way) -> DQuat {
    let between = |from: DQuat, to: Option<DQuat>| match to {
        Some(to) if way == Way::Chord => from.lerp(to, share),
        Some(to) => from.slerp(to, share),
        None => from,
    };
    match way {
        Way::AsItIs => slerp_as_it_is(from, to, share),
        _ => between(from.normalize(), to.map(DQuat::normalize)),
    }
}

/// Slerp that keeps the lengths of its ends.
fn slerp_as_it_is(from: DQuat, to: Option<DQuat>, share: f64) -> DQuat {
    let Some(to) = to else { return from };
    let (length, other) = (from.length(), to.length());
    from.normalize().slerp(to.normalize(), share) * (length + (other - length) * share)
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
