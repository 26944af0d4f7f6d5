//! Euler angles of rotations, for plots.
//!
//! A scene has quaternions. The angles are computed from them, in the order of the joint's channels, and chosen among
//! the equivalent ones nearest to those of the tick before. They give the same rotations as the file's angles; in
//! gimbal lock the first and the third may differ from the file's, because only their sum is known.

use glam::{DQuat, Quat};

use mocap_scene::math::rotation::euler_rot;
use mocap_scene::scene::{Node, RotationOrder};

/// Degrees about the axes of `order`, one triple per rotation.
pub(super) fn unwrapped(rotations: &[Quat], order: RotationOrder) -> Vec<[f64; 3]> {
    let order = euler_rot(order);
    let mut before = [0.0; 3];
    rotations
        .iter()
        .map(|rotation| {
            let rotation = DQuat::from_array(rotation.to_array().map(f64::from)).normalize();
            let (a, b, c) = rotation.to_euler(order);
            before = nearest(before, [a, b, c].map(f64::to_degrees));
            before
        })
        .collect()
}

/// The order of a node's channels, or Z X Y, the most common one, if the node has none.
pub(super) fn order_of(node: &Node) -> RotationOrder {
    node.rotation_order.unwrap_or(RotationOrder::Zxy)
}

/// The triple closest to `before` of all that give the same rotation as `angles`.
fn nearest(before: [f64; 3], angles: [f64; 3]) -> [f64; 3] {
    let [a, b, c] = angles;
    let same = [angles, [a + 180.0, 180.0 - b, c + 180.0]];
    let closest = same.map(|triple| {
        let mut near = triple;
        for (angle, before) in near.iter_mut().zip(before) {
            *angle -= 360.0 * ((*angle - before) / 360.0).round();
        }
        near
    });
    let distance = |triple: &[f64; 3]| -> f64 { triple.iter().zip(before).map(|(a, b)| (a - b).abs()).sum() };
    if distance(&closest[1]) < distance(&closest[0]) {
        closest[1]
    } else {
        closest[0]
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use super::*;

    const AXES: [DVec3; 3] = DVec3::AXES;

    #[test]
    fn angles_that_grow_beyond_a_turn_come_back_as_they_were() {
        for order in RotationOrder::ALL {
            let angles: Vec<[f64; 3]> = (0..120)
                .map(f64::from)
                .map(|k| [7.0 * k, 25.0 * (0.1 * k).sin(), -5.0 * k])
                .collect();
            let rotations: Vec<Quat> = angles
                .iter()
                .map(|angles| {
                    std::iter::zip(order.axes(), angles)
                        .fold(DQuat::IDENTITY, |q, (axis, angle)| {
                            q * DQuat::from_axis_angle(AXES[axis], angle.to_radians())
                        })
                        .as_quat()
                })
                .collect();
            for (found, expected) in unwrapped(&rotations, order).iter().zip(&angles) {
                let error = std::iter::zip(found, expected)
                    .map(|(a, b)| (a - b).abs())
                    .fold(0.0, f64::max);
                assert!(error < 1e-3, "{order:?}: {found:?} is not {expected:?}");
            }
        }
    }
}
