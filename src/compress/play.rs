//! One joint at some frames: where the source has it, and where readers of the file do.

use std::sync::Arc;

use glam::DQuat;

use super::code::{CodedRotation, CodedTranslation};
use super::keys::Grid;
use super::lanes::{self, DOUBLES};
use super::motion::{Joint, Motion, Track};
use super::{FittedTrack, Rotation, Translation};

pub(super) type Lanes = lanes::Lanes<f64, DOUBLES>;
type Vectors = lanes::Vectors<f64, DOUBLES>;
type Quaternions = lanes::Quaternions<f64, DOUBLES>;
type Matrices = lanes::Matrices<f64, DOUBLES>;

/// The ways of readers. From key to key they go along the arc, as the specification says, or, as many engines do,
/// component by component. And some take a quaternion as it is whose length is not quite 1: a matrix made of it
/// stretches what it turns. Babylon.js does that, and three.js but for keys that are near to one another.
pub(super) const WAYS: usize = 3;
const ARC: usize = 0;
const AS_IT_IS: usize = 1;
pub(super) const CHORD: usize = 2;

/// Some frames that follow one another. The lanes beyond them hold the last one.
#[derive(Clone, Copy)]
pub(super) struct Frames {
    pub(super) first: usize,
    pub(super) count: usize,
}

impl Frames {
    fn at(self, lane: usize) -> usize {
        self.first + lane.min(self.count - 1)
    }
}

/// The keys of a grid that are played at some frames.
pub(super) struct Clock<'a> {
    pub(super) grid: &'a Arc<Grid>,
    /// The last key that is not after the frame, and how far it is from there to the next.
    keys: [usize; DOUBLES],
    shares: Lanes,
    /// Whether one of the frames lies between two keys.
    is_between: bool,
}

impl<'a> Clock<'a> {
    fn new(grid: &'a Arc<Grid>) -> Self {
        Self {
            grid,
            keys: [0; DOUBLES],
            shares: Lanes::ZERO,
            is_between: false,
        }
    }

    /// Frames have to come one after the other.
    #[inline(always)]
    pub(super) fn set(&mut self, times: &[f32], frames: Frames) {
        let grid = self.grid;
        let time = |key: usize| f64::from(times[grid[key] as usize]);
        let mut key = self.keys[DOUBLES - 1];
        self.is_between = false;
        for lane in 0..DOUBLES {
            let frame = frames.at(lane);
            let second = f64::from(times[frame]);
            while key + 1 < grid.len() && time(key + 1) <= second {
                key += 1;
            }
            self.keys[lane] = key;
            self.shares.0[lane] = if key + 1 == grid.len() || second <= time(key) {
                0.0
            } else {
                self.is_between = true;
                (second - time(key)) / (time(key + 1) - time(key))
            };
        }
    }

    /// The place of a grid among the clocks.
    fn find(clocks: &mut Vec<Self>, grid: &'a Arc<Grid>) -> usize {
        let known = clocks.iter().position(|clock| Arc::ptr_eq(clock.grid, grid));
        known.unwrap_or_else(|| {
            clocks.push(Self::new(grid));
            clocks.len() - 1
        })
    }
}

/// One joint at some frames: in the source, and as each way of reading has it.
#[derive(Clone)]
pub(super) struct Body {
    pub(super) here: Vectors,
    turn: Matrices,
    there: [(Vectors, Matrices); WAYS],
    /// The angle by which another decoder may turn it differently.
    pub(super) doubt: Option<Lanes>,
    /// Whether it or one above it has such.
    pub(super) is_doubtful: bool,
}

impl Default for Body {
    fn default() -> Self {
        Self {
            here: Vectors::ZERO,
            turn: Matrices::ZERO,
            there: [(Vectors::ZERO, Matrices::ZERO); WAYS],
            doubt: None,
            is_doubtful: false,
        }
    }
}

impl Body {
    #[inline(always)]
    fn set_turn(&mut self, way: usize, above: Option<&Self>, turn: &Matrices) {
        match above {
            None => self.there[way].1 = *turn,
            Some(above) => self.there[way].1.set_product(&above.there[way].1, turn),
        }
    }

    /// The square of the largest distance between the source and what a reader has.
    #[inline(always)]
    pub(super) fn off(&self, ways: usize) -> Lanes {
        let off = |way: usize| self.here.distance_squared(self.there[way].0);
        (0..ways).fold(Lanes::ZERO, |largest, way| largest.max(off(way)))
    }
}

/// Plays one joint of the source, and its track.
pub(super) struct Player<'a> {
    pub(super) joint: &'a Joint<'a>,
    /// Length in the world of a unit of its translation.
    scale: Lanes,
    translation: Played<'a, Vectors, CodedTranslation>,
    /// The rotation, as those have it who make it unit length, and as those who do not.
    rotation: Played<'a, [Matrices; 2], CodedRotation>,
}

/// A track of the file.
enum Played<'a, Still, Key> {
    Still(Still),
    Moving { clock: usize, keys: &'a [Key] },
}

impl<'a> Player<'a> {
    pub(super) fn new(
        motion: &'a Motion,
        joint: &'a Joint<'a>,
        track: &'a FittedTrack,
        clocks: &mut Vec<Clock<'a>>,
    ) -> Self {
        Self {
            joint,
            scale: Lanes::all(motion.unit(joint).into()),
            translation: match &track.translation {
                Translation::Still(still) => Played::Still(Vectors::all(still.as_dvec3().to_array())),
                Translation::Moving { grid, keys, .. } => Played::Moving {
                    clock: Clock::find(clocks, grid),
                    keys,
                },
            },
            rotation: match &track.rotation {
                Rotation::Still(still) => {
                    let still = still.as_dquat();
                    let unit = Quaternions::all(still.normalize().to_array());
                    let square = Lanes::all(still.length_squared());
                    Played::Still([unit.into(), Matrices::stretching(unit, square)])
                }
                Rotation::Moving { grid, keys, .. } => Played::Moving {
                    clock: Clock::find(clocks, grid),
                    keys,
                },
            },
        }
    }

    #[inline(always)]
    pub(super) fn play(&self, frames: Frames, clocks: &[Clock], ways: usize, bodies: &[Body], body: &mut Body) {
        let above = self.joint.parent.map(|parent| &bodies[parent]);
        let source = match &self.joint.translation {
            Track::Still(value) => Vectors::all(value.as_dvec3().to_array()),
            Track::Moving(values) => Vectors::of(|lane| values[frames.at(lane)].as_dvec3().to_array()),
        };
        let translation = match &self.translation {
            Played::Still(still) => *still,
            Played::Moving { clock, keys } => {
                let clock = &clocks[*clock];
                Vectors::of(|lane| {
                    let (key, share) = (clock.keys[lane], clock.shares.0[lane]);
                    let from = keys[key].value.as_dvec3();
                    match keys.get(key + 1) {
                        Some(to) if share > 0.0 => from.lerp(to.value.as_dvec3(), share).to_array(),
                        _ => from.to_array(),
                    }
                })
            }
        };
        match above {
            None => {
                body.here = source;
                body.there.iter_mut().for_each(|there| there.0 = translation);
            }
            Some(above) => {
                body.here = above.here + &above.turn * (source * self.scale);
                let way = translation * self.scale;
                for (there, above) in std::iter::zip(&mut body.there[..ways], &above.there) {
                    there.0 = above.0 + &above.1 * way;
                }
            }
        }
        // How a joint is turned that carries nothing, nobody asks.
        if !self.joint.children.is_empty() {
            let source = match &self.joint.rotation {
                Track::Still(value) => Quaternions::all(value.as_dquat().to_array()),
                Track::Moving(values) => Quaternions::of(|lane| values[frames.at(lane)].as_dquat().to_array()),
            };
            let turn = Matrices::from(source.normalize());
            match above {
                None => body.turn = turn,
                Some(above) => body.turn.set_product(&above.turn, &turn),
            }
            self.turn(clocks, ways, above, body);
        }
        body.is_doubtful = body.doubt.is_some() || above.is_some_and(|above| above.is_doubtful);
    }

    /// How the joint is turned, for every way of reading.
    #[inline(always)]
    fn turn(&self, clocks: &[Clock], ways: usize, above: Option<&Body>, body: &mut Body) {
        let (clock, keys) = match &self.rotation {
            Played::Still([unit, as_it_is]) => {
                body.set_turn(ARC, above, unit);
                body.set_turn(AS_IT_IS, above, as_it_is);
                if ways > CHORD {
                    body.set_turn(CHORD, above, unit);
                }
                return;
            }
            Played::Moving { clock, keys } => (&clocks[*clock], *keys),
        };
        let next = |lane: usize| (clock.keys[lane] + usize::from(clock.shares.0[lane] > 0.0)).min(keys.len() - 1);
        let from = Quaternions::of(|lane| keys[clock.keys[lane]].value.as_dquat().to_array());
        let mut length = from.length();
        let mut unit = from * length.recip();
        if clock.is_between {
            let to = Quaternions::of(|lane| keys[next(lane)].value.as_dquat().to_array());
            let other = to.length();
            let (arc, chord) = blend(unit, to * other.recip(), clock.shares);
            unit = arc;
            length = length + (other - length) * clock.shares;
            body.set_turn(CHORD, above, &chord.into());
        } else if ways > CHORD {
            body.set_turn(CHORD, above, &unit.into());
        }
        body.set_turn(ARC, above, &unit.into());
        body.set_turn(AS_IT_IS, above, &Matrices::stretching(unit, length * length));
        let ends = |lane: usize| [&keys[clock.keys[lane]], &keys[next(lane)]];
        let is_doubtful = (0..DOUBLES).any(|lane| ends(lane).iter().any(|key| key.doubts > 0));
        body.doubt =
            is_doubtful.then(|| Lanes::of(|lane| ends(lane).map(CodedRotation::doubt).into_iter().fold(0.0, f64::max)));
    }
}

/// Between unit quaternions: along the arc, and component by component.
#[inline(always)]
fn blend(from: Quaternions, to: Quaternions, share: Lanes) -> (Quaternions, Quaternions) {
    let dot = from.dot(to);
    // The shorter way.
    let side = Lanes::of(|lane| 1f64.copysign(dot.0[lane]));
    let (to, dot) = (to * side, dot * side);
    let rest = Lanes::ONE - share;
    let chord = (from * rest + to * share).normalize();
    if dot.0.iter().all(|dot| 1.0 - dot < SMALL) {
        (from * weight(rest, dot) + to * weight(share, dot), chord)
    } else {
        let arc = Quaternions::of(|lane| {
            let [from, to] = [from, to].map(|end| DQuat::from_array(end.lane(lane)));
            from.slerp(to, share.0[lane]).to_array()
        });
        (arc, chord)
    }
}

/// Up to here [`weight`] is as good as sines are: `1 - cos a` for 11 degrees.
const SMALL: f64 = 0.02;

/// `sin(share a) / sin(a)`, given the cosine of a small angle: the series of Eberly, "A Fast and Accurate Algorithm for
/// Computing SLERP", in powers of `cos(a) - 1`. The ninth term is below 1e-18.
#[inline(always)]
fn weight(share: Lanes, cosine: Lanes) -> Lanes {
    let x = cosine - Lanes::ONE;
    let square = share * share;
    let mut sum = Lanes::ONE;
    for term in (1..=8).rev() {
        let term = f64::from(term);
        let factor = Lanes::all(1.0 / (term * (2.0 * term + 1.0)));
        sum = Lanes::ONE + sum * ((square - Lanes::all(term * term)) * factor * x);
    }
    share * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_angles_are_weighed_as_by_sines() {
        let shares = Lanes::of(|lane| [0.0, 0.25, 0.8, 1.0][lane]);
        for step in 1..=200 {
            let angle = f64::from(step) * 1e-3;
            let found = weight(shares, Lanes::all(angle.cos()));
            for lane in 0..DOUBLES {
                let expected = (shares.0[lane] * angle).sin() / angle.sin();
                assert!((found.0[lane] - expected).abs() < 1e-15, "{angle}: {}", found.0[lane]);
            }
        }
    }
}
