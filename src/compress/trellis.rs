//! Trellis quantization: finds the cheapest sequence of corners, one for each frame, by dynamic programming (the
//! Viterbi algorithm), as video encoders do.
//!
//! The rate from a corner to a corner of the next frame is a sum over the three axes. Along each axis, a corner is on
//! the near or the far side. So the minimum over all 64 pairs of corners is found axis by axis, with 16 sums for each
//! axis.

use mocap_scene::math::soa::single::{LANES, Lanes};

/// The number of corners of a cell. Bits 0, 1 and 2 of a corner state whether it is on the far side along the first,
/// second and third axis.
pub const CORNERS: usize = 8;

// The approximate bits of a difference in a stream. `src/formats/gltf/stream_size.rs` counts the bits exactly. Tuned on
// the fixtures.

/// Bits of the low byte of a difference. The number is above 0 even for a zero difference, because other differences of
/// its group often need bits.
const LOW_BYTE: f32 = 0.8;

/// Pairs of a threshold and a number of bits. A difference above the threshold takes these additional bits. In the
/// stream, a difference of 1 takes 2 bits, differences from 2 to 7 take 4 bits, and larger differences take 8 bits.
const LARGER: [(f32, f32); 3] = [(0.5, 1.6), (1.5, 2.0), (7.5, 4.6)];

/// Bits of the high byte. The high byte hardly ever changes, but a change costs bits for the whole group.
const HIGH_BYTE: f32 = 7.0;

/// One stored component of eight rotations.
#[derive(Clone, Copy)]
pub struct Component {
    value: Lanes,
    high_byte: Lanes,
}

impl Component {
    #[inline(always)]
    pub fn new(value: Lanes) -> Self {
        Self {
            value,
            high_byte: floor(value * Lanes::all(1.0 / 256.0)),
        }
    }

    /// The approximate bits of the difference between this component and the component `before`.
    #[inline(always)]
    pub fn rate_after(&self, before: &Self) -> Lanes {
        Lanes::of(|lane| {
            let difference = (self.value.0[lane] - before.value.0[lane]).abs();
            let mut bits = LOW_BYTE;
            for (from, more) in LARGER {
                bits += if difference > from { more } else { 0.0 };
            }
            let is_same = self.high_byte.0[lane] == before.high_byte.0[lane];
            bits + if is_same { 0.0 } else { HIGH_BYTE }
        })
    }
}

/// The rates along each axis from the previous frame's cell to each frame's cell, as `[axis][from][to]`. `from` and
/// `to` are the near or the far side. The first frame has no rates.
pub struct Rates([[[Lanes; 2]; 2]; 3]);

impl Rates {
    /// The rates between consecutive cells with these origins.
    #[inline(always)]
    pub fn between(origins: &[Lanes; 3]) -> Self {
        let mut rates = [[[Lanes::ZERO; 2]; 2]; 3];
        for (rates, origin) in std::iter::zip(&mut rates, origins) {
            let before = Lanes::of(|lane| origin.0[lane.max(1) - 1]);
            let before = [Component::new(before), Component::new(before + Lanes::ONE)];
            let now = [Component::new(*origin), Component::new(*origin + Lanes::ONE)];
            for from in 0..2 {
                for to in 0..2 {
                    rates[from][to] = now[to].rate_after(&before[from]);
                }
            }
        }
        Self(rates)
    }
}

/// Rounds down numbers below 2^16. Adding 1.5 * 2^23 leaves no bits for a fraction.
#[inline(always)]
pub fn floor(value: Lanes) -> Lanes {
    /// The number whose addition rounds to a whole number: 1.5 times 2^23.
    const ROUND: f32 = 12_582_912.0;
    Lanes::of(|lane| {
        let rounded = value.0[lane] + ROUND - ROUND;
        rounded - if rounded > value.0[lane] { 1.0 } else { 0.0 }
    })
}

/// The costs so far, and the path to each corner.
pub struct Trellis {
    /// The least cost of a sequence that ends at each corner.
    costs: Lanes,
    /// For each frame and corner, the corner in the previous frame.
    before: [[u8; CORNERS]; LANES],
}

impl Trellis {
    /// Starts with the costs of the corners of the first frame.
    #[inline(always)]
    pub fn new(costs: Lanes) -> Self {
        Self {
            costs,
            before: [[0; CORNERS]; LANES],
        }
    }

    /// Advances to the next frame.
    #[inline(always)]
    pub fn step(&mut self, lane: usize, rates: &Rates, distortions: Lanes) {
        let mut costs = self.costs;
        let mut from: [u8; CORNERS] = [0, 1, 2, 3, 4, 5, 6, 7];
        for axis in 0..3 {
            let (bit, rates) = (1 << axis, &rates.0[axis]);
            let (mut next, mut next_from) = (Lanes::ZERO, [0; CORNERS]);
            for (corner, next_from) in next_from.iter_mut().enumerate() {
                let (near, far, side) = (corner & !bit, corner | bit, corner >> axis & 1);
                let by_near = costs.0[near] + rates[0][side].0[lane];
                let by_far = costs.0[far] + rates[1][side].0[lane];
                let is_far = by_far < by_near;
                next.0[corner] = if is_far { by_far } else { by_near };
                *next_from = if is_far { from[far] } else { from[near] };
            }
            (costs, from) = (next, next_from);
        }
        self.costs = costs + distortions;
        self.before[lane] = from;
    }

    /// Advances to a frame whose key is not stored as a difference.
    #[inline(always)]
    pub fn jump(&mut self, lane: usize, distortions: Lanes) {
        let (corner, cost) = least(self.costs);
        self.before[lane] = [corner as u8; CORNERS];
        self.costs = Lanes::all(cost) + distortions;
    }

    /// The corners of the cheapest sequence.
    #[inline(always)]
    pub fn cheapest(&self) -> [usize; LANES] {
        let mut corners = [0; LANES];
        let (mut corner, _) = least(self.costs);
        for lane in (0..LANES).rev() {
            corners[lane] = corner;
            corner = self.before[lane][corner].into();
        }
        corners
    }
}

/// The corner with the least cost.
#[inline(always)]
pub fn least(costs: Lanes) -> (usize, f32) {
    // Non-negative floats are ordered like their bits. The index replaces the lowest bits, so that one minimum finds
    // both, without branches.
    const INDEX: u32 = CORNERS as u32 - 1;
    let mut least = u32::MAX;
    for (index, cost) in costs.0.iter().enumerate() {
        least = least.min((cost.to_bits() & !INDEX) | index as u32);
    }
    let index = (least & INDEX) as usize;
    (index, costs.0[index])
}
