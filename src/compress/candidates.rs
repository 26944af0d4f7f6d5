//! Candidates: the stored rotations around a target, and what each costs.
//!
//! The QUATERNION filter can store the points of a lattice. The target lies in one of its cells, and the eight corners
//! of the cell are the candidates. A candidate costs its rate, the bits of its difference to the key before, and its
//! distortion, its error in units of bits: rate-distortion optimization, as in video encoders. All candidates of eight
//! frames are evaluated together.

use super::compensation::Targets;
use super::error_metric::LeverArms;
use super::quantize::{Lattice, QuantizedRotation, dropped_component};
use crate::math::soa::single::{LANES, Lanes, Quaternions, Vectors};

/// About the bits that a difference takes in a stream: see [`stream_size`](super::stream_size).
#[inline(always)]
fn rate(difference: i32) -> f32 {
    const BITS: [f32; 9] = [0.0, 2.0, 4.0, 4.0, 4.0, 4.0, 4.0, 4.0, 8.0];
    BITS[difference.unsigned_abs().min(8) as usize]
}

/// The distortion, in bits, of an error as large as the tolerance; it grows with the square of the error. Joints further
/// down the chain have to compensate for the error. Found by trials on the fixtures.
const DISTORTION: f32 = 12.0;

/// The largest error of a candidate, as a share of the tolerance, squared. The rest is for rounding.
const MAX_SQUARED_ERROR: f32 = 0.98;

/// The largest difference between decoders, as a share of the tolerance. It cannot be compensated for, because it is not
/// the same for all readers.
const MAX_AMBIGUITY: f32 = 0.15;

/// The cost of a candidate whose error is as large as the tolerance or larger.
const PENALTY: f32 = 1000.0;

/// The corners of a cell.
const CORNERS: usize = 8;

/// The component that is dropped at each of several frames.
pub(super) enum Dropped {
    Same(usize),
    Each([usize; LANES]),
}

impl Dropped {
    /// For frames that follow one another, after a key that has dropped `previous`.
    #[inline(always)]
    pub(super) fn in_sequence(target: &Quaternions, mut previous: Option<usize>) -> Self {
        if let Some(previous) = previous {
            let squares = target.components().map(|component| component * component);
            let is_largest = |lane: usize| squares.iter().all(|square| square.0[lane] <= squares[previous].0[lane]);
            if (0..LANES).all(is_largest) {
                return Self::Same(previous);
            }
        }
        Self::Each(std::array::from_fn(|lane| {
            let dropped = dropped_component(target.lane(lane), previous);
            previous = Some(dropped);
            dropped
        }))
    }

    /// For frames each of which has its own key before it.
    #[inline(always)]
    pub(super) fn independent(target: &Quaternions, previous: impl Fn(usize) -> Option<usize>) -> Self {
        Self::Each(std::array::from_fn(|lane| {
            dropped_component(target.lane(lane), previous(lane))
        }))
    }

    #[inline(always)]
    fn at(&self, lane: usize) -> usize {
        match self {
            Self::Same(same) => *same,
            Self::Each(each) => each[lane],
        }
    }
}

/// A corner of a cell.
#[derive(Clone, Copy)]
struct Corner {
    /// Bit 0, 1 and 2: whether it is on the far side along the first, second and third axis.
    index: usize,
    cost: f32,
}

impl Corner {
    #[inline(always)]
    fn cheapest(costs: &[f32; CORNERS]) -> Self {
        // Floats that are not negative are ordered as their bits are. The index takes the place of the lowest bits, so
        // that one minimum finds both, without branches.
        const INDEX: u32 = CORNERS as u32 - 1;
        let mut least = u32::MAX;
        for (index, cost) in costs.iter().enumerate() {
            least = least.min((cost.to_bits() & !INDEX) | index as u32);
        }
        let index = (least & INDEX) as usize;
        Self {
            index,
            cost: costs[index],
        }
    }

    fn is_within_tolerance(self) -> bool {
        self.cost < PENALTY
    }

    #[inline(always)]
    fn point(self, origin: [i32; 3]) -> [i32; 3] {
        [0, 1, 2].map(|axis| origin[axis] + (self.index >> axis & 1) as i32)
    }
}

/// The distortion of every corner, one cell per lane.
type Distortions = [Lanes; CORNERS];

/// The candidates of several frames.
pub(super) struct Candidates<'a> {
    arms: &'a LeverArms,
    lattice: Lattice,
    tolerance: f32,
    dropped: Dropped,
    cells: Cells,
    distortions: Distortions,
}

/// Cells of the lattice, one per lane, and the rotation errors in them, to first order.
struct Cells {
    /// The corner with the smallest coordinates.
    origin: [Lanes; 3],
    /// From the target to there, in steps.
    offset: [Lanes; 3],
    /// The rotation error at the target, as axis times angle.
    rotation_error: Vectors,
    /// What a step along each axis adds to it.
    per_step: [Vectors; 3],
    /// The error of the joint's position.
    position_error: Vectors,
}

impl<'a> Candidates<'a> {
    #[inline(always)]
    pub(super) fn new(
        arms: &'a LeverArms,
        lattice: Lattice,
        tolerance: f32,
        targets: &Targets,
        dropped: Dropped,
    ) -> Self {
        let cells = Cells::new(targets, lattice.scale(), &dropped);
        Self {
            arms,
            lattice,
            tolerance,
            dropped,
            distortions: cells.distortions(arms, tolerance),
            cells,
        }
    }

    /// The best candidate at one frame.
    #[inline(always)]
    pub(super) fn best(&self, lane: usize, previous: Option<&QuantizedRotation>) -> QuantizedRotation {
        let dropped = self.dropped.at(lane);
        let previous = previous.and_then(|previous| self.lattice.previous(dropped, previous));
        let origin = self.cells.origin(lane);
        let corner = Corner::cheapest(&costs(&self.distortions, lane, origin, previous));
        let key = self.lattice.at(corner.point(origin), dropped);
        if corner.is_within_tolerance() && self.is_unambiguous(&key) {
            return key;
        }
        self.best_of_more(lane, dropped, previous)
    }

    /// The cheapest unambiguous candidate of the cell or, where it has none, of the lattice points up to a step around it.
    /// If those have none either, the least ambiguous of those within the tolerance.
    #[inline(never)]
    fn best_of_more(&self, lane: usize, dropped: usize, previous: Option<[i32; 3]>) -> QuantizedRotation {
        let origin = self.cells.origin(lane);
        let mut cell = [(origin, costs(&self.distortions, lane, origin, previous))];
        let found = self.cheapest_unambiguous(dropped, &mut cell);
        found.unwrap_or_else(|_| {
            let cells = self.cells.neighbours(lane);
            let distortions = cells.distortions(self.arms, self.tolerance);
            let mut cells: [_; CORNERS] = std::array::from_fn(|lane| {
                let origin = cells.origin(lane);
                (origin, costs(&distortions, lane, origin, previous))
            });
            self.cheapest_unambiguous(dropped, &mut cells)
                .unwrap_or_else(|fallback| fallback)
        })
    }

    /// The cheapest unambiguous corner of some cells, each given by its origin and the costs of its corners. As an
    /// error, of those within the tolerance the least ambiguous; if none is, the cheapest.
    fn cheapest_unambiguous(
        &self,
        dropped: usize,
        cells: &mut [([i32; 3], [f32; CORNERS])],
    ) -> std::result::Result<QuantizedRotation, QuantizedRotation> {
        let mut least: Option<(QuantizedRotation, f32)> = None;
        loop {
            let mut best = (0, Corner::cheapest(&cells[0].1));
            for (index, (_, costs)) in cells.iter().enumerate().skip(1) {
                let corner = Corner::cheapest(costs);
                if corner.cost < best.1.cost {
                    best = (index, corner);
                }
            }
            let (cell, corner) = best;
            let key = self.lattice.at(corner.point(cells[cell].0), dropped);
            if !corner.is_within_tolerance() {
                return Err(least.map_or(key, |least| least.0));
            }
            if self.is_unambiguous(&key) {
                return Ok(key);
            }
            let ambiguity = self.ambiguity(&key);
            if least.as_ref().is_none_or(|least| ambiguity < least.1) {
                least = Some((key, ambiguity));
            }
            cells[cell].1[corner.index] = f32::INFINITY;
        }
    }

    /// Whether all readers decode nearly the same.
    #[inline(always)]
    fn is_unambiguous(&self, key: &QuantizedRotation) -> bool {
        self.lattice.is_coarse() || self.ambiguity(key) <= MAX_AMBIGUITY * self.tolerance
    }

    /// How far readers may differ about the end of the chain, in metres: because of the rounding of a component, and
    /// because some do not normalize.
    #[inline(always)]
    fn ambiguity(&self, key: &QuantizedRotation) -> f32 {
        let stretch = (key.value.length_squared() - 1.0).abs();
        (stretch + key.ambiguity() as f32) * self.arms.chain_length
    }
}

/// The cost of each corner of a cell: rate plus distortion, in bits.
#[inline(always)]
fn costs(distortions: &Distortions, lane: usize, origin: [i32; 3], previous: Option<[i32; 3]>) -> [f32; CORNERS] {
    let rates: [[f32; 2]; 3] = std::array::from_fn(|axis| {
        [0, 1].map(|side| previous.map_or(0.0, |previous| rate(origin[axis] + side - previous[axis])))
    });
    std::array::from_fn(|corner| {
        let [a, b, c] = [0, 1, 2].map(|axis| rates[axis][corner >> axis & 1]);
        a + b + c + distortions[corner].0[lane]
    })
}

impl Cells {
    /// The cells that the targets lie in.
    #[inline(always)]
    fn new(targets: &Targets, scale: f32, dropped: &Dropped) -> Self {
        let components = targets.rotation.components();
        // The rotation error is a quaternion product, which is linear in the components of the rotation. These are the
        // vector parts of the products with 1 in place of one component, and 0 in place of the others.
        let Quaternions { x, y, z, w } = targets.parent_to_raw;
        let vectors = |x, y, z| Vectors { x, y, z };
        let derivatives = [
            vectors(w, z, -y),
            vectors(-z, w, x),
            vectors(y, -x, w),
            vectors(x, y, z),
        ];
        // The dropped component first, and then the three after it.
        let mut ordered = [Lanes::ZERO; 4];
        let mut ordered_derivatives = [Vectors::ZERO; 4];
        for slot in 0..4 {
            if let Dropped::Same(same) = dropped {
                let from = (same + slot) & 3;
                ordered[slot] = components[from];
                ordered_derivatives[slot] = derivatives[from];
                continue;
            }
            for lane in 0..LANES {
                let from = (dropped.at(lane) + slot) & 3;
                ordered[slot].0[lane] = components[from].0[lane];
                ordered_derivatives[slot].x.0[lane] = derivatives[from].x.0[lane];
                ordered_derivatives[slot].y.0[lane] = derivatives[from].y.0[lane];
                ordered_derivatives[slot].z.0[lane] = derivatives[from].z.0[lane];
            }
        }
        let [largest, stored @ ..] = ordered;
        let at_target = targets.parent_to_raw * targets.rotation;
        // The sign that is stored is the one that makes the dropped component positive.
        let point = stored.map(|component| (component * Lanes::all(scale)).negated_where_negative(largest));
        let origin = point.map(floor);
        let twice = Lanes::all(2.0).negated_where_negative(at_target.w);
        let step = (twice * Lanes::all(1.0 / scale)).negated_where_negative(largest);
        Self {
            origin,
            offset: std::array::from_fn(|axis| origin[axis] - point[axis]),
            rotation_error: at_target.xyz() * twice,
            per_step: std::array::from_fn(|axis| {
                // The dropped component follows from the others, because the length is 1.
                let of_dropped = ordered[axis + 1] * largest.recip();
                (ordered_derivatives[axis + 1] - ordered_derivatives[0] * of_dropped) * step
            }),
            position_error: targets.position_error,
        }
    }

    #[inline(always)]
    fn origin(&self, lane: usize) -> [i32; 3] {
        self.origin.map(|axis| axis.0[lane] as i32)
    }

    /// Eight cells whose corners are all lattice points of one lane's cell and up to a step around it: the cell moved by
    /// a step back or ahead along each axis.
    #[inline(always)]
    fn neighbours(&self, lane: usize) -> Self {
        let all = |vectors: &Vectors| Vectors::all(vectors.lane(lane));
        let moved = |axis: usize| Lanes::of(|corner| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 });
        Self {
            origin: [0, 1, 2].map(|axis| Lanes::all(self.origin[axis].0[lane]) + moved(axis)),
            offset: [0, 1, 2].map(|axis| Lanes::all(self.offset[axis].0[lane]) + moved(axis)),
            rotation_error: all(&self.rotation_error),
            per_step: self.per_step.each_ref().map(all),
            position_error: all(&self.position_error),
        }
    }

    /// The distortion of every corner, in bits. To first order, because a step is a small rotation.
    #[inline(always)]
    fn distortions(&self, arms: &LeverArms, tolerance: f32) -> Distortions {
        let sides: [[Vectors; 2]; 3] = std::array::from_fn(|axis| {
            let near = self.per_step[axis] * self.offset[axis];
            [near, near + self.per_step[axis]]
        });
        let per_tolerance = Lanes::all(1.0 / (tolerance * tolerance));
        let mut distortions = [Lanes::ZERO; CORNERS];
        for corner in 0..CORNERS {
            let [a, b, c] = [0, 1, 2].map(|axis| sides[axis][corner >> axis & 1]);
            let rotation_error = self.rotation_error + a + b + c;
            let squares = arms.squared_errors(self.position_error, rotation_error) * per_tolerance;
            let penalties = squares.sqrt() * Lanes::all(PENALTY);
            distortions[corner] = Lanes::of(|lane| {
                let is_too_large = squares.0[lane] > MAX_SQUARED_ERROR;
                let penalty = if is_too_large { penalties.0[lane] } else { 0.0 };
                DISTORTION * squares.0[lane] + penalty
            });
        }
        distortions
    }
}

/// Rounds down numbers of a size below 2^16. Adding 1.5 * 2^23 leaves no bits for a fraction.
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
    fn larger_differences_take_more_bits() {
        let rates = [0, 1, -1, 2, 7, -7, 8, 5000].map(rate);
        assert_eq!(rates, [0.0, 2.0, 2.0, 4.0, 4.0, 4.0, 8.0, 8.0]);
    }

    #[test]
    fn the_cheapest_corner_is_found() {
        for (costs, index) in [
            ([3.0, 2.0, 5.0, 1.0, 4.0, 9.0, 8.0, 7.0], 3),
            ([0.0, 0.0, 5.0, 1.0, 4.0, 9.0, 8.0, 7.0], 0),
            ([f32::INFINITY, 2e3, 5e3, 4e3, 1.5e3, 9e3, 8e3, f32::INFINITY], 4),
        ] {
            let corner = Corner::cheapest(&costs);
            assert_eq!(
                (corner.index, corner.is_within_tolerance()),
                (index, costs[index] < PENALTY)
            );
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
