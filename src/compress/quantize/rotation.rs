//! Rotations as 32-bit floats, as 16-bit integers, or as points of a lattice. Lattice points are decoded as the
//! QUATERNION filter of meshopt decodes them, or without its rounding.
//!
//! The filter stores the three smaller components of a quaternion ("smallest three"), each as an integer of 4 to 16
//! bits, and the index of the dropped component. Its formula is in EXT_meshopt_compression, appendix B:
//! <https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Vendor/EXT_meshopt_compression>

use std::f32::consts::SQRT_2;

use glam::{Quat, Vec4};
use mocap_scene::math::quaternion::in_hemisphere_of;
use mocap_scene::math::soa::single::{LANES, Lanes};

use super::rounding::{floor, round};

/// The largest 16-bit integer: glTF divides normalized integers by this number.
pub const INT16_MAX: f32 = 32767.0;

/// The smallest number of lattice steps from 0 to the square root of 1/2: the QUATERNION filter with 4 bits, including
/// the sign.
const MIN_STEPS: f32 = 7.0;
/// The distance between two possible values of a lattice's largest integer. The two lowest bits of these values are
/// set.
const NEXT_MAX: f32 = 4.0;

/// The stored form of a track's rotations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub enum RotationFormat {
    /// Four 32-bit floats.
    Float32,
    /// Four 16-bit normalized integers, as in core glTF: `max(c / 32767, -1)`.
    Int16,
    /// The QUATERNION filter of meshopt, with the lattice of its bit rate.
    QuaternionFilter(Lattice),
    /// The three smaller components as points of this lattice.
    SmallestThree(Lattice),
}

/// One stored rotation.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct QuantizedRotation {
    /// The integers in the file, before any filter.
    #[doc(hidden)]
    pub stored: [i16; 4],
    /// The decoded value. Its length is 1 except for rounding. Some readers normalize the value, other readers do not.
    #[doc(hidden)]
    pub value: Quat,
    /// The number of components so near to the middle between two integers that another decoder may round differently.
    pub ambiguous: u8,
}

impl RotationFormat {
    /// Bytes of a key, without its time.
    pub(crate) fn bytes(self) -> usize {
        match self {
            Self::Float32 => 16,
            Self::Int16 | Self::QuaternionFilter(_) | Self::SmallestThree(_) => 8,
        }
    }

    /// This format with another lattice.
    pub(crate) fn with_lattice(self, lattice: Lattice) -> Self {
        match self {
            Self::QuaternionFilter(_) => Self::QuaternionFilter(lattice),
            Self::SmallestThree(_) => Self::SmallestThree(lattice),
            Self::Float32 | Self::Int16 => self,
        }
    }

    /// The nearest stored rotation. If the format stores the sign of the quaternion, the result is in the hemisphere of
    /// `previous`.
    pub fn quantize(self, rotation: Quat, previous: Option<&QuantizedRotation>) -> QuantizedRotation {
        let previous_value = previous.map_or(Quat::IDENTITY, |previous| previous.value);
        match self {
            Self::Float32 => QuantizedRotation {
                stored: [0; 4],
                value: in_hemisphere_of(previous_value, rotation.normalize()),
                ambiguous: 0,
            },
            Self::Int16 => quantize_int16(in_hemisphere_of(previous_value, rotation.normalize())),
            Self::QuaternionFilter(lattice) | Self::SmallestThree(lattice) => lattice.quantize(rotation, previous),
        }
    }
}

/// Four integers next to the components of `rotation`: of the sixteen roundings up or down, the one with the length
/// nearest to 1. With another length, a reader that does not normalize would stretch the descendants of the joint.
fn quantize_int16(rotation: Quat) -> QuantizedRotation {
    let exact = rotation.to_array().map(|c| c * INT16_MAX);
    let below = exact.map(floor);
    let mut best = ([0; 4], f32::INFINITY);
    for corner in 0..16 {
        let stored: [i32; 4] = std::array::from_fn(|c| (below[c] + (corner >> c & 1)).clamp(-32767, 32767));
        // Integers are exact: the sum of the squares is near 2^30.
        let squares: i32 = stored.iter().map(|c| c * c).sum();
        let stretch = (squares - 32767 * 32767).unsigned_abs() as f32;
        let distance: f32 = std::iter::zip(stored, exact)
            .map(|(c, exact)| (c as f32 - exact).powi(2))
            .sum();
        // An error in the quaternion's length weighs as much as an equal error of its components, both in quantization
        // steps. One step in length adds 2 * 32767 to the sum of the squares.
        let cost = (stretch / INT16_MAX).powi(2) + distance;
        if cost < best.1 {
            best = (stored, cost);
        }
    }
    let stored = best.0.map(|c| c as i16);
    QuantizedRotation {
        stored,
        value: Quat::from_array(stored.map(|c| f32::from(c) / INT16_MAX)),
        ambiguous: 0,
    }
}

/// The component of a quaternion that the QUATERNION filter drops: usually the largest one. If the other components
/// fit, the dropped component of the previous key stays. Another choice would make the differences to that key large.
pub(crate) fn dropped_component(components: [f32; 4], previous: Option<usize>) -> usize {
    /// The largest stored component of a unit quaternion. It is slightly below the square root of 1/2, 0.707, so that
    /// candidates next to the nearest candidate fit.
    const MAX_STORED: f32 = 0.705;

    /// A dropped component below this value is computed from the other components with a large error. Tuned on the
    /// fixtures.
    const MIN_DROPPED: f32 = 0.3;
    let larger = |a: usize, b: usize| {
        if components[b].abs() > components[a].abs() {
            b
        } else {
            a
        }
    };
    let largest = larger(larger(0, 1), larger(2, 3));
    match previous {
        Some(previous) if components[largest].abs() < MAX_STORED && components[previous].abs() > MIN_DROPPED => {
            previous
        }
        _ => largest,
    }
}

/// The storable rotations: a lattice in the space of the three smaller components.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub struct Lattice {
    /// The largest integer of a component. It represents the square root of 1/2. Its two lowest bits are set. In the
    /// fourth stored integer, the index of the dropped component replaces these two bits.
    max: i32,
    /// Whether a reader rounds its decoded values to 16-bit integers, as readers of the filter do.
    rounds: bool,
}

impl Lattice {
    /// The lattice of the QUATERNION filter with a bit rate in bits per component.
    #[doc(hidden)]
    pub fn of_filter(bits: u32) -> Self {
        Self {
            max: (1 << (bits - 1)) - 1,
            rounds: true,
        }
    }

    /// A lattice with at least this many steps from 0 to the square root of 1/2, or the finest lattice. Its decoder
    /// does not round.
    pub fn of_steps(steps: f32) -> Self {
        Self {
            max: (steps.clamp(MIN_STEPS, INT16_MAX) as i32) | 3,
            rounds: false,
        }
    }

    /// The lattice of a file that states its largest integer.
    pub(crate) fn of_max(max: u16) -> Self {
        Self {
            max: max.into(),
            rounds: false,
        }
    }

    /// The next finer lattice; `None` after the finest.
    pub(crate) fn finer(self) -> Option<Self> {
        if self.max >= INT16_MAX as i32 {
            return None;
        }
        Some(if self.rounds {
            Self {
                max: 2 * self.max + 1,
                rounds: true,
            }
        } else {
            Self::of_steps((self.max as f32 * FINER).max(self.max as f32 + NEXT_MAX))
        })
    }

    /// The largest integer of a component.
    pub fn max(self) -> i32 {
        self.max
    }

    /// Whether a step is much larger than a decoder's rounding.
    pub(crate) fn is_coarse(self) -> bool {
        self.max < (1 << (FINE_BITS - 1)) - 1
    }

    /// Steps per unit of a component.
    pub(crate) fn scale(self) -> f32 {
        self.max as f32 * SQRT_2
    }

    /// The fourth stored integer: the bit rate and the dropped component.
    fn tag(self, dropped: usize) -> i16 {
        ((self.max & !3) | dropped as i32) as i16
    }

    /// Whether keys are stored as differences to the previous key.
    pub(crate) fn stores_differences(self) -> bool {
        self.rounds
    }

    /// The three integers of the previous key. `None` if the previous key dropped another component than `dropped`, or
    /// if keys are not stored as differences.
    pub(crate) fn previous(self, dropped: usize, stored: [i16; 4]) -> Option<[i32; 3]> {
        let [x, y, z, tag] = stored;
        (self.rounds && tag == self.tag(dropped)).then(|| [x, y, z].map(i32::from))
    }

    /// The stored form of a lattice point: the integers of the three components after the dropped one.
    #[inline(always)]
    pub(crate) fn stored(self, [x, y, z]: [i32; 3], dropped: usize) -> [i16; 4] {
        let clamp = |c: i32| c.clamp(-self.max, self.max) as i16;
        [clamp(x), clamp(y), clamp(z), self.tag(dropped)]
    }

    /// The rotation at a lattice point.
    pub fn at(self, point: [i32; 3], dropped: usize) -> QuantizedRotation {
        let stored = self.stored(point, dropped);
        if self.rounds {
            decode_quaternion_filter(stored)
        } else {
            let [x, y, z, _] = stored.map(f32::from);
            QuantizedRotation {
                stored,
                value: Quat::from_array(self.decode([x, y, z], dropped)),
                ambiguous: 0,
            }
        }
    }

    /// The decoded components at several lattice points, with the same numbers as [`Self::at`]: the dropped component,
    /// the three components after it, and the number of ambiguous components.
    #[inline(always)]
    pub(crate) fn decode_lanes(self, [x, y, z]: [Lanes; 3]) -> ([Lanes; 4], [u8; LANES]) {
        let square = |value: f32| Lanes::all(value * value);
        if !self.rounds {
            let step = Lanes::all(1.0 / self.scale());
            let [a, b, c] = [x * step, y * step, z * step];
            let d = (square(1.0) - a * a - b * b - c * c).max(Lanes::ZERO).sqrt();
            return ([d, a, b, c], [0; LANES]);
        }
        let max = self.max as f32;
        let w = (square(max) * Lanes::all(2.0) - x * x - y * y - z * z)
            .max(Lanes::ZERO)
            .sqrt();
        let to_int16 = Lanes::all(INT16_MAX / SQRT_2 / max);
        let mut components = [w, x, y, z];
        let mut ambiguous = [0; LANES];
        for (slot, component) in components.iter_mut().enumerate() {
            let exact = *component * to_int16;
            for (lane, ambiguous) in ambiguous.iter_mut().enumerate() {
                let exact = exact.0[lane];
                let rounded = round(exact) as f32;
                let ambiguity = if slot == 0 {
                    ambiguity_of_dropped(exact)
                } else {
                    AMBIGUITY
                };
                *ambiguous += u8::from((exact - rounded).abs() > 0.5 - ambiguity);
                component.0[lane] = rounded / INT16_MAX;
            }
        }
        (components, ambiguous)
    }

    /// The rotation at a lattice point, without rounding.
    fn decode(self, point: [f32; 3], dropped: usize) -> [f32; 4] {
        let step = 1.0 / self.scale();
        let [a, b, c] = point.map(|c| c * step);
        let d = (1.0 - a * a - b * b - c * c).max(0.0).sqrt();
        let mut rotation = [0.0; 4];
        for (slot, component) in [d, a, b, c].into_iter().enumerate() {
            rotation[(dropped + slot) & 3] = component;
        }
        rotation
    }

    pub fn quantize(self, rotation: Quat, previous: Option<&QuantizedRotation>) -> QuantizedRotation {
        let components = rotation.to_array();
        let dropped = dropped_component(components, previous.map(QuantizedRotation::dropped));
        let scale = self.scale().copysign(components[dropped]);
        let point = [1, 2, 3].map(|slot| round(components[(dropped + slot) & 3] * scale));
        self.at(point, dropped)
    }
}

/// The lowest bit rate at which a lattice step is about as small as a decoder's rounding. From this bit rate on,
/// ambiguous rotations are avoided, because there are enough others.
const FINE_BITS: u32 = 10;

/// The factor from one lattice to the next finer one, for bit rates that need not be whole.
const FINER: f32 = 1.12;

/// The distance from the middle between two integers within which a component is ambiguous. It is a few rounding errors
/// of 32-bit floats below 32768.
const AMBIGUITY: f32 = 0.005;

/// The [`AMBIGUITY`] of the dropped component. This component is the square root of a difference. The smaller the
/// component is, the larger is its rounding error.
#[inline(always)]
fn ambiguity_of_dropped(exact: f32) -> f32 {
    AMBIGUITY * INT16_MAX / exact.max(1.0)
}

/// The decoded value of the four integers of the QUATERNION filter.
fn decode_quaternion_filter(stored: [i16; 4]) -> QuantizedRotation {
    let max = f32::from(stored[3] | 3);
    let dropped = (stored[3] & 3) as usize;
    let [x, y, z] = [stored[0], stored[1], stored[2]].map(f32::from);
    let w = (max * max * 2.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let to_int16 = INT16_MAX / SQRT_2 / max;
    let exact = (Vec4::new(x, y, z, w) * to_int16).to_array();
    let [a, b, c, d] = exact.map(|exact| round(exact) as f32);
    let ambiguity = [AMBIGUITY, AMBIGUITY, AMBIGUITY, ambiguity_of_dropped(exact[3])];
    let is_ambiguous = |slot: usize, rounded: f32| u8::from((exact[slot] - rounded).abs() > 0.5 - ambiguity[slot]);
    let decoded = match dropped {
        0 => [d, a, b, c],
        1 => [c, d, a, b],
        2 => [b, c, d, a],
        _ => [a, b, c, d],
    };
    QuantizedRotation {
        stored,
        value: Quat::from_array(decoded.map(|c| c / INT16_MAX)),
        ambiguous: is_ambiguous(0, a) + is_ambiguous(1, b) + is_ambiguous(2, c) + is_ambiguous(3, d),
    }
}

impl QuantizedRotation {
    /// The component that the QUATERNION filter dropped.
    pub fn dropped(&self) -> usize {
        (self.stored[3] & 3) as usize
    }

    /// The angle in radians by which other decoders may differ.
    pub fn ambiguity(&self) -> f64 {
        Self::angle_of(self.ambiguous)
    }

    /// The angle by which decoders may differ for a rotation with this number of ambiguous components.
    #[inline(always)]
    pub(crate) fn angle_of(ambiguous: u8) -> f64 {
        2.0 * f64::from(ambiguous).sqrt() / f64::from(INT16_MAX)
    }
}
