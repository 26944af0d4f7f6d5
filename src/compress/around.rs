//! The codes around the rotations of some frames: the corners of cubes.

use super::chain::{Aims, Arms, Lanes, Quaternions, Vectors};
use super::code::{CodedRotation, FINE, Lattice, left_out};
use super::lanes::SINGLES;

/// The bits of a difference of so many steps, nearly: see [`stream`](super::stream).
#[inline(always)]
fn price(difference: i32) -> f32 {
    const PRICES: [f32; 9] = [0.0, 2.0, 4.0, 4.0, 4.0, 4.0, 4.0, 4.0, 8.0];
    PRICES[difference.unsigned_abs().min(8) as usize]
}

/// Bits that an error as large as the tolerance is worth, in the square: what is left of it has to be made up for
/// further down the chain. Found by trying on the fixtures.
const WORTH: f32 = 12.0;

/// The share of the tolerance, squared, beyond which a code is none: what is left is for rounding.
const MOST: f32 = 0.98;

/// The share of the tolerance by which readers may differ about one joint. It cannot be made up for, for only some of them
/// see it.
const DIFFERENCE: f32 = 0.15;

/// What a code costs that is off by more than the tolerance.
const TOO_FAR: f32 = 1000.0;

/// The corners of a cube of the grid.
const CORNERS: usize = 8;

/// Of each frame, the component of its quaternion that is left out.
pub(super) enum LeftOut {
    Same(usize),
    Each([usize; SINGLES]),
}

impl LeftOut {
    /// For frames of which each has the one before it.
    #[inline(always)]
    pub(super) fn follow(wanted: &Quaternions, mut kept: Option<usize>) -> Self {
        if let Some(kept) = kept {
            let squares = wanted.components().map(|component| component * component);
            let is_largest = |lane: usize| squares.iter().all(|square| square.0[lane] <= squares[kept].0[lane]);
            if (0..SINGLES).all(is_largest) {
                return Self::Same(kept);
            }
        }
        Self::Each(std::array::from_fn(|lane| {
            let left_out = left_out(wanted.lane(lane), kept);
            kept = Some(left_out);
            left_out
        }))
    }

    /// For frames before which others are known.
    #[inline(always)]
    pub(super) fn of(wanted: &Quaternions, kept: impl Fn(usize) -> Option<usize>) -> Self {
        Self::Each(std::array::from_fn(|lane| left_out(wanted.lane(lane), kept(lane))))
    }

    #[inline(always)]
    fn at(&self, lane: usize) -> usize {
        match self {
            Self::Same(same) => *same,
            Self::Each(each) => each[lane],
        }
    }
}

/// A corner of a cube.
#[derive(Clone, Copy)]
struct Corner {
    place: usize,
    score: f32,
}

impl Corner {
    #[inline(always)]
    fn cheapest(scores: &[f32; CORNERS]) -> Self {
        // Of numbers that are not negative the bits are in order too; the last ones have room for the place.
        const PLACES: u32 = CORNERS as u32 - 1;
        let mut least = u32::MAX;
        for (place, score) in scores.iter().enumerate() {
            least = least.min((score.to_bits() & !PLACES) | place as u32);
        }
        let place = (least & PLACES) as usize;
        Self {
            place,
            score: scores[place],
        }
    }

    /// Whether its error is within the tolerance.
    #[inline(always)]
    fn is_near(self) -> bool {
        self.score < TOO_FAR
    }

    #[inline(always)]
    fn stored(self, first: [i32; 3]) -> [i32; 3] {
        [0, 1, 2].map(|slot| first[slot] + (self.place >> slot & 1) as i32)
    }
}

/// The costs of the errors at the corners of a cube, one a lane.
type Costs = [Lanes; CORNERS];

/// The codes around the rotations of some frames.
pub(super) struct Around<'a> {
    arms: &'a Arms,
    bits: u32,
    lattice: Lattice,
    tolerance: f32,
    left_out: LeftOut,
    cubes: Cubes,
    /// What the corners of the cubes around the rotations cost.
    costs: Costs,
}

/// Cubes of the lattice, one a lane, and what their corners mean.
struct Cubes {
    /// The first corner: whole numbers.
    first: [Lanes; 3],
    /// From the wanted rotation to there, in steps.
    way: [Lanes; 3],
    /// How much too far the wanted rotation turns the joint: the axis, times the angle.
    turn: Vectors,
    /// What a step of each component adds to that.
    turns: [Vectors; 3],
    /// The error of the joint's own place.
    error: Vectors,
}

impl<'a> Around<'a> {
    #[inline(always)]
    pub(super) fn new(arms: &'a Arms, bits: u32, tolerance: f32, aims: &Aims, left_out: LeftOut) -> Self {
        let lattice = Lattice::new(bits);
        let cubes = Cubes::new(aims, lattice.scale(), &left_out);
        Self {
            arms,
            bits,
            lattice,
            tolerance,
            left_out,
            costs: cubes.costs(arms, tolerance),
            cubes,
        }
    }

    /// The best code of a frame.
    #[inline(always)]
    pub(super) fn best(&self, lane: usize, previous: Option<&CodedRotation>) -> CodedRotation {
        let left_out = self.left_out.at(lane);
        let before = previous.and_then(|previous| self.lattice.before(left_out, previous));
        let first = self.cubes.first(lane);
        let corner = Corner::cheapest(&scores(&self.costs, lane, first, before));
        let key = self.lattice.code(corner.stored(first), left_out);
        if corner.is_near() && self.is_clear(&key) {
            return key;
        }
        self.best_of_more(lane, left_out, before)
    }

    /// Of the corners of the cube, and then of the eight cubes around the corner that is next to it, the cheapest that
    /// all readers understand alike; if there is none, the one of those that are near enough about which they differ
    /// least.
    #[inline(never)]
    fn best_of_more(&self, lane: usize, left_out: usize, before: Option<[i32; 3]>) -> CodedRotation {
        let first = self.cubes.first(lane);
        let near = self.clearest(left_out, &mut [(first, scores(&self.costs, lane, first, before))]);
        near.unwrap_or_else(|_| {
            let cubes = self.cubes.around(lane);
            let costs = cubes.costs(self.arms, self.tolerance);
            let mut cubes: [_; CORNERS] = std::array::from_fn(|lane| {
                let first = cubes.first(lane);
                (first, scores(&costs, lane, first, before))
            });
            self.clearest(left_out, &mut cubes).unwrap_or_else(|least| least)
        })
    }

    /// The cheapest of the corners of some cubes that all readers understand alike; as an error, the one that comes
    /// next to that.
    fn clearest(
        &self,
        left_out: usize,
        cubes: &mut [([i32; 3], [f32; CORNERS])],
    ) -> std::result::Result<CodedRotation, CodedRotation> {
        let mut least: Option<(CodedRotation, f32)> = None;
        loop {
            let mut best = (0, Corner::cheapest(&cubes[0].1));
            for (place, (_, scores)) in cubes.iter().enumerate().skip(1) {
                let corner = Corner::cheapest(scores);
                if corner.score < best.1.score {
                    best = (place, corner);
                }
            }
            let (place, corner) = best;
            let key = self.lattice.code(corner.stored(cubes[place].0), left_out);
            if !corner.is_near() {
                return Err(least.map_or(key, |least| least.0));
            }
            if self.is_clear(&key) {
                return Ok(key);
            }
            let difference = self.difference(&key);
            if least.as_ref().is_none_or(|least| difference < least.1) {
                least = Some((key, difference));
            }
            cubes[place].1[corner.place] = f32::INFINITY;
        }
    }

    /// Whether all readers understand a code alike.
    #[inline(always)]
    fn is_clear(&self, key: &CodedRotation) -> bool {
        self.bits < FINE || self.difference(key) <= DIFFERENCE * self.tolerance
    }

    /// How far readers may differ, in metres at the end of the chain: about the rounding of a code, and about a length
    /// that is not 1.
    #[inline(always)]
    fn difference(&self, key: &CodedRotation) -> f32 {
        let stretch = (key.value.length_squared() - 1.0).abs();
        (stretch + key.doubt() as f32) * self.arms.reach
    }
}

/// What each corner of a cube costs, in bits: those of its differences to the code before, and what its error is worth.
#[inline(always)]
fn scores(costs: &Costs, lane: usize, first: [i32; 3], before: Option<[i32; 3]>) -> [f32; CORNERS] {
    let prices: [[f32; 2]; 3] = std::array::from_fn(|slot| {
        [0, 1].map(|side| before.map_or(0.0, |before| price(first[slot] + side - before[slot])))
    });
    std::array::from_fn(|corner| {
        let [a, b, c] = [0, 1, 2].map(|slot| prices[slot][corner >> slot & 1]);
        a + b + c + costs[corner].0[lane]
    })
}

impl Cubes {
    /// Those around what is wanted.
    #[inline(always)]
    fn new(aims: &Aims, scale: f32, left_out: &LeftOut) -> Self {
        let components = aims.wanted.components();
        // What a component of 1 makes of the rotation that it is of: the columns of a product of quaternions.
        let Quaternions { x, y, z, w } = aims.to_turn;
        let column = |x, y, z| Vectors { x, y, z };
        let columns = [column(w, z, -y), column(-z, w, x), column(y, -x, w), column(x, y, z)];
        // The component that is left out, and the three after it.
        let mut ordered = [Lanes::ZERO; 4];
        let mut turned = [Vectors::ZERO; 4];
        for slot in 0..4 {
            if let LeftOut::Same(same) = left_out {
                let from = (same + slot) & 3;
                ordered[slot] = components[from];
                turned[slot] = columns[from];
                continue;
            }
            for lane in 0..SINGLES {
                let from = (left_out.at(lane) + slot) & 3;
                ordered[slot].0[lane] = components[from].0[lane];
                turned[slot].x.0[lane] = columns[from].x.0[lane];
                turned[slot].y.0[lane] = columns[from].y.0[lane];
                turned[slot].z.0[lane] = columns[from].z.0[lane];
            }
        }
        let [out, stored @ ..] = ordered;
        let near = aims.to_turn * aims.wanted;
        // The left-out component is positive, of the quaternion that is stored.
        let stored = stored.map(|component| (component * Lanes::all(scale)).flipped(out));
        let first = stored.map(floor);
        let twice = Lanes::all(2.0).flipped(near.w);
        let step = (twice * Lanes::all(1.0 / scale)).flipped(out);
        Self {
            first,
            way: std::array::from_fn(|slot| first[slot] - stored[slot]),
            turn: near.xyz() * twice,
            turns: std::array::from_fn(|slot| {
                let share = ordered[slot + 1] * out.recip();
                (turned[slot + 1] - turned[0] * share) * step
            }),
            error: aims.error,
        }
    }

    /// The first corner of a cube.
    #[inline(always)]
    fn first(&self, lane: usize) -> [i32; 3] {
        self.first.map(|axis| axis.0[lane] as i32)
    }

    /// The eight cubes around the corner that is next to the cube of one lane.
    #[inline(always)]
    fn around(&self, lane: usize) -> Self {
        let all = |vectors: &Vectors| Vectors::all(vectors.lane(lane));
        let moved = |axis: usize| Lanes::of(|corner| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 });
        Self {
            first: [0, 1, 2].map(|axis| Lanes::all(self.first[axis].0[lane]) + moved(axis)),
            way: [0, 1, 2].map(|axis| Lanes::all(self.way[axis].0[lane]) + moved(axis)),
            turn: all(&self.turn),
            turns: self.turns.each_ref().map(all),
            error: all(&self.error),
        }
    }

    /// What the errors at the corners are worth, in bits. To first order, for a step is a small turn.
    #[inline(always)]
    fn costs(&self, arms: &Arms, tolerance: f32) -> Costs {
        let sides: [[Vectors; 2]; 3] = std::array::from_fn(|slot| {
            let near = self.turns[slot] * self.way[slot];
            [near, near + self.turns[slot]]
        });
        let share = Lanes::all(1.0 / (tolerance * tolerance));
        let mut costs = [Lanes::ZERO; CORNERS];
        for corner in 0..CORNERS {
            let [a, b, c] = [0, 1, 2].map(|slot| sides[slot][corner >> slot & 1]);
            let turn = self.turn + a + b + c;
            let share = arms.squares(self.error, turn) * share;
            let too_far = share.sqrt() * Lanes::all(TOO_FAR);
            costs[corner] = Lanes::of(|lane| {
                let beyond = if share.0[lane] > MOST { too_far.0[lane] } else { 0.0 };
                WORTH * share.0[lane] + beyond
            });
        }
        costs
    }
}

/// The whole number below. Numbers are below 2^16: adding 1.5 * 2^23 rounds them.
#[inline(always)]
fn floor(value: Lanes) -> Lanes {
    const ROUND: f32 = 12_582_912.0;
    Lanes::of(|lane| {
        let rounded = value.0[lane] + ROUND - ROUND;
        rounded - if rounded > value.0[lane] { 1.0 } else { 0.0 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prices_grow_with_differences() {
        let prices = [0, 1, -1, 2, 7, -7, 8, 5000].map(price);
        assert_eq!(prices, [0.0, 2.0, 2.0, 4.0, 4.0, 4.0, 8.0, 8.0]);
    }

    #[test]
    fn a_corner_is_the_cheapest_one() {
        for (scores, place) in [
            ([3.0, 2.0, 5.0, 1.0, 4.0, 9.0, 8.0, 7.0], 3),
            ([0.0, 0.0, 5.0, 1.0, 4.0, 9.0, 8.0, 7.0], 0),
            ([f32::INFINITY, 2e3, 5e3, 4e3, 1.5e3, 9e3, 8e3, f32::INFINITY], 4),
        ] {
            let corner = Corner::cheapest(&scores);
            assert_eq!((corner.place, corner.is_near()), (place, scores[place] < TOO_FAR));
        }
    }

    #[test]
    fn numbers_are_rounded_down() {
        let found = floor(Lanes::of(|lane| {
            [0.0, 0.25, -0.25, 1.0, -1.0, 32767.5, -32767.5, 5.999][lane]
        }));
        assert_eq!(found.0, [0.0, 0.0, -1.0, 1.0, -1.0, 32767.0, -32768.0, 5.0]);
    }
}
