//! Computes Euler angles that are read back as the same rotation keys.

use glam::{DQuat, Quat};
use mocap_scene::math::rotation::{Axis, lanes, to_euler};
use mocap_scene::scene::RotationOrder;

use super::number::roundings;

/// The largest error of a quaternion component: the double precision of angles after some turns, and the remainder of
/// half turns near zero. It is below the single precision of every component above 1e-7.
const NOISE: f32 = 1e-14;

/// The angles of a joint from frame to frame, in degrees and in the order of its channels.
pub struct Angles {
    order: RotationOrder,
    before: [f64; 3],
    is_shortest: bool,
}

impl Angles {
    /// `is_shortest` requests the fewest decimals that read back to the same keys. Otherwise the angles are exact.
    pub fn new(order: RotationOrder, is_shortest: bool) -> Self {
        Self {
            order,
            before: [0.0; 3],
            is_shortest,
        }
    }

    /// The angles of the next frame, as near as possible to the current angles. `None` if `key` is not a rotation.
    pub fn next(&mut self, key: Quat) -> Option<[f64; 3]> {
        if !(key.is_finite() && key.length_squared() > f32::EPSILON) {
            return None;
        }
        let (rotation, key) = match unit_within(key) {
            Some(rotation) => (rotation, key),
            None => {
                let rotation = key.as_dquat().normalize();
                (rotation, rotation.as_quat())
            }
        };
        let angles = to_euler(rotation, self.order, self.before);
        self.before = angles;
        Some(match self.is_shortest {
            true => self.shortest(angles, key),
            false => angles,
        })
    }

    /// The angles with the fewest decimals that are read back as `key`, or else as its negative, which is the same
    /// rotation.
    fn shortest(&self, angles: [f64; 3], key: Quat) -> [f64; 3] {
        let axes = self.order.axes().map(|axis| Axis::ALL[axis]);
        let mut roundings = roundings(angles);
        let mut negative = None;
        let (mut columns, mut keys) = ([[0.0; lanes::LANES]; 3], [Quat::IDENTITY; lanes::LANES]);
        loop {
            // One rotation takes as much time as all lanes, so each lane tries another rounding.
            let mut count = 0;
            for rounded in roundings.by_ref().take(lanes::LANES) {
                std::iter::zip(&mut columns, rounded).for_each(|(column, angle)| column[count] = angle);
                count += 1;
            }
            if count == 0 {
                return negative.unwrap_or(angles);
            }
            let with_axes = std::array::from_fn::<_, 3, _>(|index| (axes[index], &columns[index][..]));
            lanes::fill(&with_axes, &mut keys);
            let first = |key: Quat| {
                let index = keys[..count].iter().position(|own| own.abs_diff_eq(key, NOISE))?;
                Some(columns.map(|column| column[index]))
            };
            if let Some(found) = first(key) {
                return found;
            }
            negative = negative.or_else(|| first(-key));
        }
    }
}

/// A unit quaternion in double precision that rounds to `key`, if there is one.
///
/// A key is a rounded unit quaternion, so its length differs slightly from 1. Scaling the key to length 1 may give
/// numbers that round to another key. A change of the largest component changes the length most. So the largest
/// component takes as much of the correction as it can without rounding to its neighbour. Then the next largest
/// component takes its share.
pub fn unit_within(key: Quat) -> Option<DQuat> {
    /// The usable share of the distance to the middle between two neighbouring numbers, with room for rounding.
    const INSIDE: f64 = 1.0 - 1e-7;
    let key = key.to_array();
    let mut exact = key.map(f64::from);
    let mut by_size = [0, 1, 2, 3];
    by_size.sort_by(|&a, &b| key[b].abs().total_cmp(&key[a].abs()));
    for index in by_size {
        // A change dx of the component x changes the squared length by 2 · x · dx. The square of dx is below the
        // precision.
        let excess = exact.iter().map(|x| x * x).sum::<f64>() - 1.0;
        if excess.abs() < f64::EPSILON || key[index] == 0.0 {
            break;
        }
        let half_step = |neighbour: f32| 0.5 * INSIDE * (f64::from(neighbour) - exact[index]);
        exact[index] +=
            (-0.5 * excess / exact[index]).clamp(half_step(key[index].next_down()), half_step(key[index].next_up()));
    }
    let rotation = DQuat::from_array(exact).normalize();
    (rotation.as_quat().to_array() == key).then_some(rotation)
}
