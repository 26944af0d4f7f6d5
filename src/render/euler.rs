//! Euler angles of rotations, for plots.
//!
//! A scene has quaternions. mocap computes the angles from the quaternions, in the order of the joint's channels. Of
//! all equivalent angles, it chooses the angles nearest to the angles of the previous tick. These angles give the same
//! rotations as the angles of the file. In gimbal lock the first and the third angle may differ from the angles of the
//! file, because only their sum or their difference is known.

use glam::{DQuat, Quat};

use mocap_scene::math::rotation::euler_rot;
use mocap_scene::scene::{Node, RotationOrder};

/// The angles in degrees about the axes of `order`, one triple per rotation.
pub fn unwrapped(rotations: &[Quat], order: RotationOrder) -> Vec<[f64; 3]> {
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

/// The order of a node's channels. If the node has none, the most common order, Z X Y.
pub(super) fn order_of(node: &Node) -> RotationOrder {
    node.rotation_order.unwrap_or(RotationOrder::Zxy)
}

/// The equivalent triple closest to `before`, among all that give the same rotation as `angles`.
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
