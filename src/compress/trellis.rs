//! Trellis quantization: of all sequences of corners, one for each frame, the one that costs least, found by dynamic
//! programming (the algorithm of Viterbi), as video encoders do.
//!
//! The rate of a step from a corner to one of the next frame is a sum over the three axes, and a corner is on the near
//! or the far side along each. So the least of the 64 sums is found axis by axis, with 16 sums for each.

use mocap_scene::math::soa::single::{LANES, Lanes};

/// The corners of a cell. Bit 0, 1 and 2 of a corner: whether it is on the far side along the first, second and third
/// axis.
pub(super) const CORNERS: usize = 8;

// About the bits of a difference in a stream: `format/gltf/stream_size` counts them exactly. Found by trials on the
// fixtures.

/// Of the low byte. More than nothing for 0, for other differences of its group often need bits.
const LOW_BYTE: f32 = 0.8;
/// What is added to that for differences from 1, 2 and 8 on, which take 2, 4 and 8 bits.
const LARGER: [(f32, f32); 3] = [(0.5, 1.6), (1.5, 2.0), (7.5, 4.6)];
/// Of the high byte, which hardly ever changes: then its whole group takes bits.
const HIGH_BYTE: f32 = 7.0;

/// One component of eight rotations, as it is stored.
#[derive(Clone, Copy)]
pub(super) struct Component {
    value: Lanes,
    high_byte: Lanes,
}

impl Component {
    #[inline(always)]
    pub(super) fn new(value: Lanes) -> Self {
        Self {
            value,
            high_byte: floor(value * Lanes::all(1.0 / 256.0)),
        }
    }

    /// About the bits that this component takes after another.
    #[inline(always)]
    pub(super) fn rate_after(&self, before: &Self) -> Lanes {
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

/// The rates along each axis from the cell of the frame before to the cell of each frame, from the near or far side
/// to the near or far side: `[axis][from][to]`. The first frame has none.
pub(super) struct Rates([[[Lanes; 2]; 2]; 3]);

impl Rates {
    /// Between cells with these origins, which follow one another.
    #[inline(always)]
    pub(super) fn between(origins: &[Lanes; 3]) -> Self {
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

/// Rounds down numbers of a size below 2^16. Adding 1.5 * 2^23 leaves no bits for a fraction.
#[inline(always)]
pub(super) fn floor(value: Lanes) -> Lanes {
    const ROUND: f32 = 12_582_912.0;
    Lanes::of(|lane| {
        let rounded = value.0[lane] + ROUND - ROUND;
        rounded - if rounded > value.0[lane] { 1.0 } else { 0.0 }
    })
}

/// The costs so far, and where each came from.
pub(super) struct Trellis {
    /// The least cost of a sequence that ends at each corner.
    costs: Lanes,
    /// For each frame, and each corner, the corner of the frame before.
    before: [[u8; CORNERS]; LANES],
}

impl Trellis {
    /// With the costs of the corners of the first frame.
    #[inline(always)]
    pub(super) fn new(costs: Lanes) -> Self {
        Self {
            costs,
            before: [[0; CORNERS]; LANES],
        }
    }

    /// Goes on to the next frame.
    #[inline(always)]
    pub(super) fn step(&mut self, lane: usize, rates: &Rates, distortions: Lanes) {
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

    /// Goes on to a frame that no difference leads to.
    #[inline(always)]
    pub(super) fn jump(&mut self, lane: usize, distortions: Lanes) {
        let (corner, cost) = least(self.costs);
        self.before[lane] = [corner as u8; CORNERS];
        self.costs = Lanes::all(cost) + distortions;
    }

    /// The corners of the cheapest sequence.
    #[inline(always)]
    pub(super) fn cheapest(&self) -> [usize; LANES] {
        let mut corners = [0; LANES];
        let (mut corner, _) = least(self.costs);
        for lane in (0..LANES).rev() {
            corners[lane] = corner;
            corner = self.before[lane][corner].into();
        }
        corners
    }
}

/// The corner that costs least.
#[inline(always)]
pub(super) fn least(costs: Lanes) -> (usize, f32) {
    // Floats that are not negative are ordered as their bits are. The index replaces the lowest bits, so that
    // one minimum finds both, without branches.
    const INDEX: u32 = CORNERS as u32 - 1;
    let mut least = u32::MAX;
    for (index, cost) in costs.0.iter().enumerate() {
        least = least.min((cost.to_bits() & !INDEX) | index as u32);
    }
    let index = (least & INDEX) as usize;
    (index, costs.0[index])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn larger_differences_take_more_bits() {
        let before = Component::new(Lanes::all(250.0));
        let now = Component::new(Lanes::of(|lane| {
            [250.0, 251.0, 249.0, 248.0, 243.0, 242.0, 255.0, 256.0][lane]
        }));
        let rates = now.rate_after(&before).0.map(|rate| (rate * 10.0).round());
        assert_eq!(rates, [8.0, 24.0, 24.0, 44.0, 44.0, 90.0, 44.0, 114.0]);
    }

    #[test]
    fn the_cheapest_sequence_is_found() {
        let mut seed = 7u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / 16_777_216.0
        };
        for jump in [None, Some(3)] {
            let origins = [(); 3].map(|()| {
                let numbers: [f32; LANES] = std::array::from_fn(|_| (random() * 20.0).floor() + 245.0);
                Lanes::of(|lane| numbers[lane])
            });
            // Two corners for each frame, so that there are few enough sequences to try them all.
            let choices: [[usize; 2]; LANES] =
                std::array::from_fn(|_| [(random() * 4.0) as usize, 4 + (random() * 4.0) as usize]);
            let distortions: [Lanes; LANES] = std::array::from_fn(|lane| {
                let all = [(); CORNERS].map(|()| random() * 12.0);
                Lanes::of(|corner| {
                    if choices[lane].contains(&corner) {
                        all[corner]
                    } else {
                        1e4
                    }
                })
            });

            let rates = Rates::between(&origins);
            let mut trellis = Trellis::new(distortions[0]);
            for (lane, distortions) in distortions.iter().enumerate().skip(1) {
                if jump == Some(lane) {
                    trellis.jump(lane, *distortions);
                } else {
                    trellis.step(lane, &rates, *distortions);
                }
            }
            let found = trellis.cheapest();

            let at = |lane: usize, corner: usize, axis: usize| {
                Component::new(Lanes::all(origins[axis].0[lane] + (corner >> axis & 1) as f32))
            };
            let cost = |corners: &[usize; LANES]| -> f32 {
                let step = |lane: usize| -> f32 {
                    if lane == 0 || jump == Some(lane) {
                        return 0.0;
                    }
                    let rate = |axis| {
                        at(lane, corners[lane], axis)
                            .rate_after(&at(lane - 1, corners[lane - 1], axis))
                            .0[0]
                    };
                    (0..3).map(rate).sum()
                };
                (0..LANES)
                    .map(|lane| distortions[lane].0[corners[lane]] + step(lane))
                    .sum()
            };
            let sequences =
                (0..1usize << LANES).map(|bits| std::array::from_fn(|lane| choices[lane][bits >> lane & 1]));
            let least = sequences.map(|corners| cost(&corners)).fold(f32::INFINITY, f32::min);
            assert!((cost(&found) - least).abs() < 1e-3, "{} and {least}", cost(&found));
        }
    }

    #[test]
    fn the_cheapest_corner_is_found() {
        for (costs, index) in [
            ([3.0, 2.0, 5.0, 1.0, 4.0, 9.0, 8.0, 7.0], 3),
            ([0.0, 0.0, 5.0, 1.0, 4.0, 9.0, 8.0, 7.0], 0),
            ([f32::INFINITY, 2e3, 5e3, 4e3, 1.5e3, 9e3, 8e3, f32::INFINITY], 4),
        ] {
            assert_eq!(least(Lanes::of(|corner| costs[corner])), (index, costs[index]));
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
