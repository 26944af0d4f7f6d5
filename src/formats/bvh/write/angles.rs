//! Euler angles that are read back as the same rotation keys.

use glam::{DQuat, Quat};
use mocap_scene::math::rotation::{Axis, lanes, to_euler};
use mocap_scene::scene::RotationOrder;

use super::number::shortest;

/// How far a component may be off: the double precision of angles after some turns, and what half turns leave of zero.
/// It is below the single precision of every component above 1e-7.
const NOISE: f32 = 1e-14;

/// The angles of a joint from frame to frame, in degrees and in the order of its channels.
pub struct Angles {
    order: RotationOrder,
    before: [f64; 3],
    is_shortest: bool,
}

impl Angles {
    /// `is_shortest` asks for the fewest decimals that read back to the same keys, else for the angles as they are.
    pub fn new(order: RotationOrder, is_shortest: bool) -> Self {
        Self {
            order,
            before: [0.0; 3],
            is_shortest,
        }
    }

    /// The angles of the next frame, as near as possible to those of this one. `None` if `key` is not a rotation.
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
        let reads_back_to = |key: Quat| move |angles: [f64; 3]| read_back(axes, angles).abs_diff_eq(key, NOISE);
        shortest(angles, reads_back_to(key))
            .or_else(|| shortest(angles, reads_back_to(-key)))
            .unwrap_or(angles)
    }
}

/// The key that the reader makes of three angles.
fn read_back(axes: [Axis; 3], angles: [f64; 3]) -> Quat {
    let columns = std::array::from_fn::<_, 3, _>(|index| (axes[index], std::slice::from_ref(&angles[index])));
    let mut key = [Quat::IDENTITY];
    lanes::fill(&columns, &mut key);
    key[0]
}

/// A quaternion of length 1 that is `key` in single precision, if there is one.
///
/// A key is a rounded unit quaternion and has itself not quite length 1. Scaling it there may leave the numbers that
/// round to it. Its largest component changes the length most, so that one takes up what it can without rounding to
/// its neighbour, then the next.
pub fn unit_within(key: Quat) -> Option<DQuat> {
    /// Share of the distance to the middle between two neighbouring numbers, so that rounding has room.
    const INSIDE: f64 = 1.0 - 1e-7;
    let key = key.to_array();
    let mut exact = key.map(f64::from);
    let mut by_size = [0, 1, 2, 3];
    by_size.sort_by(|&a, &b| key[b].abs().total_cmp(&key[a].abs()));
    for index in by_size {
        // The length squared changes by 2 x dx, without the square of dx, which is below all precision.
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
