//! Candidates: the possible stored rotations around a target, and their costs.
//!
//! The QUATERNION filter can store the points of a lattice. The target lies in a cell of the lattice, whose eight
//! corners are the candidates. The cost of a candidate is its rate plus its distortion. The rate is the number of bits
//! of the difference between the candidate and the previous key. The distortion is the squared error, converted to bits
//! by a constant. This is rate-distortion optimization, as in video encoders. The candidates of eight frames are
//! evaluated together, and the [`trellis`](super::trellis) finds the cheapest sequence.

use glam::Quat;
use mocap_scene::math::soa::single::{LANES, Lanes, Quaternions, Vectors};

use super::compensation::Targets;
use super::error_metric::LeverArms;
use super::quantize::{Lattice, QuantizedRotation, dropped_component};
use super::trellis::{CORNERS, Component, Rates, Trellis, floor, least};

/// The distortion, in bits, of a candidate whose error equals the tolerance. Distortion grows with the square of the
/// error, because joints further down the chain have to compensate for the error. Tuned on the fixtures.
const DISTORTION: f32 = 12.0;
/// [`DISTORTION`] for a fine lattice. On a fine lattice, nearly every difference takes 8 bits, whichever
/// candidate is chosen.
const DISTORTION_OF_FINE: f32 = 18.0;

/// The largest allowed square of a candidate's error, divided by the square of the tolerance. It is below 1 to leave
/// room for rounding.
const MAX_SQUARED_ERROR: f32 = 0.98;

/// The largest allowed distance between the results of different decoders, as a fraction of the tolerance. A candidate
/// with a larger distance is *ambiguous*. Compensation cannot correct this distance, because each reader has another
/// result.
const MAX_AMBIGUITY: f32 = 0.15;

/// The additional cost of a candidate whose squared error is above [`MAX_SQUARED_ERROR`] is this number times the ratio
/// of the error to the tolerance. Other candidates have no additional cost.
const PENALTY: f32 = 1000.0;

/// The dropped component of the rotation at each of several frames: the quaternion component that a key does not store.
pub(super) enum DroppedComponents {
    Same(usize),
    Each([usize; LANES]),
}

impl DroppedComponents {
    /// The dropped components of consecutive frames. `previous` is the component that the key before the first frame
    /// has dropped.
    #[inline(always)]
    pub(super) fn in_sequence(target: &Quaternions, mut previous: Option<usize>) -> Self {
        if let Some(previous) = previous {
            let components = target.components();
            let largest = components[previous] * components[previous];
            let mut is_largest = true;
            for component in components {
                let square = component * component;
                for lane in 0..LANES {
                    is_largest &= square.0[lane] <= largest.0[lane];
                }
            }
            if is_largest {
                return Self::Same(previous);
            }
        }
        let mut each = [0; LANES];
        for (lane, dropped) in each.iter_mut().enumerate() {
            *dropped = dropped_component(target.lane(lane), previous);
            previous = Some(*dropped);
        }
        if each == [each[0]; LANES] {
            return Self::Same(each[0]);
        }
        Self::Each(each)
    }

    /// The dropped components of frames that need not be consecutive. `previous` returns the component that the key
    /// before a frame has dropped.
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

    /// Returns the components in the order x, y, z, w. `after_dropped` has the dropped component, then the three
    /// components that follow it in cyclic order.
    #[inline(always)]
    fn in_order(&self, after_dropped: [Lanes; 4]) -> Quaternions {
        let mut components = [Lanes::ZERO; 4];
        for (slot, component) in after_dropped.into_iter().enumerate() {
            if let Self::Same(same) = self {
                components[(same + slot) & 3] = component;
                continue;
            }
            for lane in 0..LANES {
                components[(self.at(lane) + slot) & 3].0[lane] = component.0[lane];
            }
        }
        let [x, y, z, w] = components;
        Quaternions { x, y, z, w }
    }
}

/// A corner of a cell.
#[derive(Clone, Copy)]
struct Corner {
    /// Bits 0, 1 and 2: whether the corner is on the far side along the first, second and third axis.
    index: usize,
    cost: f32,
}

impl Corner {
    #[inline(always)]
    fn cheapest(costs: Lanes) -> Self {
        let (index, cost) = least(costs);
        Self { index, cost }
    }

    fn is_within_tolerance(self) -> bool {
        self.cost < PENALTY
    }
}

/// The lattice point at a corner of a cell.
#[inline(always)]
fn point(corner: usize, origin: [i32; 3]) -> [i32; 3] {
    let along = |axis: usize| origin[axis] + (corner >> axis & 1) as i32;
    [along(0), along(1), along(2)]
}

/// The distortion of each of the eight corners of a cell, in bits. Each lane has another cell.
type Distortions = [Lanes; CORNERS];

/// The candidates of several frames.
pub(super) struct Candidates<'a> {
    arms: &'a LeverArms,
    lattice: Lattice,
    tolerance: f32,
    dropped: DroppedComponents,
    cells: Cells,
    distortions: Distortions,
}

/// Cells of the lattice, one per lane, each with a linear approximation of the rotation error in the cell.
struct Cells {
    /// The corner of each cell with the smallest coordinates.
    origin: [Lanes; 3],
    /// The offset from the target to the origin, in lattice steps.
    offset: [Lanes; 3],
    /// The rotation error at the target, as axis times angle.
    rotation_error: Vectors,
    /// The change of the rotation error for a step along each axis.
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
        dropped: DroppedComponents,
    ) -> Self {
        let cells = Cells::new(targets, lattice.scale(), &dropped);
        Self {
            arms,
            lattice,
            tolerance,
            dropped,
            distortions: cells.distortions(arms, tolerance, lattice),
            cells,
        }
    }

    /// Appends the best candidates for the first `count` frames, which are consecutive and follow the last of `keys`.
    #[inline(always)]
    pub(super) fn push_best(&self, count: usize, keys: &mut Vec<QuantizedRotation>) {
        let good = if count == LANES { self.push_cheapest(keys) } else { 0 };
        for lane in good..count {
            let key = self.best(lane, keys.last());
            keys.push(key);
        }
    }

    /// Appends the cheapest sequence of candidates. The sequence ends before the first frame whose candidate is
    /// ambiguous or has an error above the tolerance. All candidates are chosen before the first is decoded, so that
    /// they can be decoded together. Returns the number of appended keys.
    #[inline(always)]
    fn push_cheapest(&self, keys: &mut Vec<QuantizedRotation>) -> usize {
        let mut stored = [[0; 4]; LANES];
        let mut points = [Lanes::ZERO; 3];
        let mut is_good = [true; LANES];
        let chosen = self.cheapest(keys.last());
        for lane in 0..LANES {
            let corner = chosen[lane];
            is_good[lane] = self.distortions[corner].0[lane] < PENALTY;
            stored[lane] = self
                .lattice
                .stored(point(corner, self.cells.origin(lane)), self.dropped.at(lane));
            for axis in 0..3 {
                points[axis].0[lane] = stored[lane][axis].into();
            }
        }
        let (components, ambiguous) = self.lattice.decode_lanes(points);
        let value = self.dropped.in_order(components);
        if !self.lattice.is_coarse() {
            let stretch = value.squared_length();
            for lane in 0..LANES {
                let ambiguity = self.ambiguity(stretch.0[lane], ambiguous[lane]);
                is_good[lane] &= self.is_negligible(ambiguity);
            }
        }
        let good = is_good.iter().position(|is_good| !is_good).unwrap_or(LANES);
        for lane in 0..good {
            keys.push(QuantizedRotation {
                stored: stored[lane],
                value: Quat::from_array(value.lane(lane)),
                ambiguous: ambiguous[lane],
            });
        }
        good
    }

    /// For each frame, the corner in the sequence of corners with the least total cost. The sequence follows the key
    /// `before`.
    #[inline(always)]
    fn cheapest(&self, before: Option<&QuantizedRotation>) -> [usize; LANES] {
        if !self.lattice.stores_differences() {
            return std::array::from_fn(|lane| least(at_lane(&self.distortions, lane)).0);
        }
        let dropped = self.dropped.at(0);
        let before = before.and_then(|before| self.lattice.previous(dropped, before.stored));
        let mut trellis = Trellis::new(costs(&self.distortions, 0, self.cells.origin(0), before));
        let rates = Rates::between(&self.cells.origin);
        for lane in 1..LANES {
            let distortions = at_lane(&self.distortions, lane);
            if self.dropped.at(lane) == self.dropped.at(lane - 1) {
                trellis.step(lane, &rates, distortions);
            } else {
                trellis.jump(lane, distortions);
            }
        }
        trellis.cheapest()
    }

    /// The cheapest candidate for the frame in `lane`, after the key `previous`. If this candidate is ambiguous or has
    /// an error above the tolerance, returns another lattice point near the target.
    #[inline(always)]
    pub(super) fn best(&self, lane: usize, previous: Option<&QuantizedRotation>) -> QuantizedRotation {
        let dropped = self.dropped.at(lane);
        let previous = previous.and_then(|previous| self.lattice.previous(dropped, previous.stored));
        let origin = self.cells.origin(lane);
        let corner = Corner::cheapest(costs(&self.distortions, lane, origin, previous));
        let key = self.lattice.at(point(corner.index, origin), dropped);
        if corner.is_within_tolerance() && self.is_unambiguous(&key) {
            return key;
        }
        self.best_of_more(lane, dropped, previous)
    }

    /// Returns the cheapest unambiguous corner of the cell. If all corners are ambiguous, it returns the cheapest
    /// unambiguous lattice point within one step of the cell. If all of these points are ambiguous, it returns the
    /// least ambiguous point within the tolerance.
    #[inline(never)]
    fn best_of_more(&self, lane: usize, dropped: usize, previous: Option<[i32; 3]>) -> QuantizedRotation {
        let origin = self.cells.origin(lane);
        let mut cell = [(origin, costs(&self.distortions, lane, origin, previous))];
        let found = self.cheapest_unambiguous(dropped, &mut cell);
        found.unwrap_or_else(|_| {
            let cells = self.cells.neighbours(lane);
            let distortions = cells.distortions(self.arms, self.tolerance, self.lattice);
            let mut cells: [_; CORNERS] = std::array::from_fn(|lane| {
                let origin = cells.origin(lane);
                (origin, costs(&distortions, lane, origin, previous))
            });
            self.cheapest_unambiguous(dropped, &mut cells)
                .unwrap_or_else(|fallback| fallback)
        })
    }

    /// The cheapest unambiguous corner of some cells, given the origin of each cell and the costs of its corners. `Err`
    /// has the least ambiguous corner within the tolerance, or the cheapest corner if no corner is within the
    /// tolerance.
    fn cheapest_unambiguous(
        &self,
        dropped: usize,
        cells: &mut [([i32; 3], Lanes)],
    ) -> std::result::Result<QuantizedRotation, QuantizedRotation> {
        let mut least: Option<(QuantizedRotation, f32)> = None;
        loop {
            let mut best = (0, Corner::cheapest(cells[0].1));
            for (index, (_, costs)) in cells.iter().enumerate().skip(1) {
                let corner = Corner::cheapest(*costs);
                if corner.cost < best.1.cost {
                    best = (index, corner);
                }
            }
            let (cell, corner) = best;
            let key = self.lattice.at(point(corner.index, cells[cell].0), dropped);
            if !corner.is_within_tolerance() {
                return Err(least.map_or(key, |least| least.0));
            }
            if self.is_unambiguous(&key) {
                return Ok(key);
            }
            let ambiguity = self.ambiguity_of(&key);
            if least.as_ref().is_none_or(|least| ambiguity < least.1) {
                least = Some((key, ambiguity));
            }
            cells[cell].1.0[corner.index] = f32::INFINITY;
        }
    }

    /// Whether all readers decode nearly the same value.
    #[inline(always)]
    fn is_unambiguous(&self, key: &QuantizedRotation) -> bool {
        self.lattice.is_coarse() || self.is_negligible(self.ambiguity_of(key))
    }

    #[inline(always)]
    fn is_negligible(&self, ambiguity: f32) -> bool {
        ambiguity <= MAX_AMBIGUITY * self.tolerance
    }

    /// The largest distance, in metres at the end of the joint chain, between the values that different glTF readers
    /// decode. Readers round components differently, and some do not normalize.
    #[inline(always)]
    fn ambiguity(&self, squared_length: f32, ambiguous: u8) -> f32 {
        let stretch = (squared_length - 1.0).abs();
        (stretch + QuantizedRotation::angle_of(ambiguous) as f32) * self.arms.chain_length
    }

    #[inline(always)]
    fn ambiguity_of(&self, key: &QuantizedRotation) -> f32 {
        self.ambiguity(key.value.length_squared(), key.ambiguous)
    }
}

/// The cost of each corner of a cell: rate plus distortion, in bits.
#[inline(always)]
fn costs(distortions: &Distortions, lane: usize, origin: [i32; 3], previous: Option<[i32; 3]>) -> Lanes {
    let mut costs = at_lane(distortions, lane);
    if let Some(previous) = previous {
        for axis in 0..3 {
            let along = Lanes::of(|corner| (origin[axis] + (corner >> axis & 1) as i32) as f32);
            let previous = Component::new(Lanes::all(previous[axis] as f32));
            costs = costs + Component::new(along).rate_after(&previous);
        }
    }
    costs
}

#[inline(always)]
fn at_lane(distortions: &Distortions, lane: usize) -> Lanes {
    Lanes::of(|corner| distortions[corner].0[lane])
}

impl Cells {
    /// The cells that contain the targets.
    #[inline(always)]
    fn new(targets: &Targets, scale: f32, dropped: &DroppedComponents) -> Self {
        let components = targets.rotation.components();
        // The rotation error is a quaternion product, which is linear in the components of the rotation. These are the
        // vector parts of the products of the unit quaternions.
        let Quaternions { x, y, z, w } = targets.parent_to_raw;
        let vectors = |x, y, z| Vectors { x, y, z };
        let derivatives = [
            vectors(w, z, -y),
            vectors(-z, w, x),
            vectors(y, -x, w),
            vectors(x, y, z),
        ];
        // The dropped component first, then the three after it.
        let mut ordered = [Lanes::ZERO; 4];
        let mut ordered_derivatives = [Vectors::ZERO; 4];
        for slot in 0..4 {
            if let DroppedComponents::Same(same) = dropped {
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
        // The stored sign makes the dropped component positive.
        let twice = Lanes::all(2.0).negated_where_negative(at_target.w);
        let step = (twice * Lanes::all(1.0 / scale)).negated_where_negative(largest);
        let mut cells = Self {
            origin: [Lanes::ZERO; 3],
            offset: [Lanes::ZERO; 3],
            rotation_error: at_target.xyz() * twice,
            per_step: [Vectors::ZERO; 3],
            position_error: targets.position_error,
        };
        // These are loops, because `array::map` and `array::from_fn` would become separate functions without wide
        // vectors.
        for axis in 0..3 {
            let point = (stored[axis] * Lanes::all(scale)).negated_where_negative(largest);
            cells.origin[axis] = floor(point);
            cells.offset[axis] = cells.origin[axis] - point;
            // The dropped component follows from the others, because the length is 1.
            let of_dropped = stored[axis] * largest.recip();
            cells.per_step[axis] = (ordered_derivatives[axis + 1] - ordered_derivatives[0] * of_dropped) * step;
        }
        cells
    }

    #[inline(always)]
    fn origin(&self, lane: usize) -> [i32; 3] {
        let [x, y, z] = &self.origin;
        [x.0[lane] as i32, y.0[lane] as i32, z.0[lane] as i32]
    }

    /// Eight cells: the cell of one lane, moved by a step back or ahead along each axis. Their corners are the lattice
    /// points of the cell and up to a step around it.
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

    /// The approximate distortion of every corner, in bits. The approximation is linear, because a step of the lattice
    /// is a small rotation.
    #[inline(always)]
    fn distortions(&self, arms: &LeverArms, tolerance: f32, lattice: Lattice) -> Distortions {
        let weight = if lattice.is_coarse() {
            DISTORTION
        } else {
            DISTORTION_OF_FINE
        };
        let mut sides = [[Vectors::ZERO; 2]; 3];
        for (axis, sides) in sides.iter_mut().enumerate() {
            let near = self.per_step[axis] * self.offset[axis];
            *sides = [near, near + self.per_step[axis]];
        }
        let per_tolerance = Lanes::all(1.0 / (tolerance * tolerance));
        let mut distortions = [Lanes::ZERO; CORNERS];
        for corner in 0..CORNERS {
            let [x, y, z] = &sides;
            let rotation_error = self.rotation_error + x[corner & 1] + y[corner >> 1 & 1] + z[corner >> 2 & 1];
            let squares = arms.squared_errors(self.position_error, rotation_error) * per_tolerance;
            let penalties = squares.sqrt() * Lanes::all(PENALTY);
            distortions[corner] = Lanes::of(|lane| {
                let is_too_large = squares.0[lane] > MAX_SQUARED_ERROR;
                let penalty = if is_too_large { penalties.0[lane] } else { 0.0 };
                weight * squares.0[lane] + penalty
            });
        }
        distortions
    }
}
