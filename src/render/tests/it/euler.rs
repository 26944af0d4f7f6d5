//! Tests curves of angles that grow beyond a turn.

use mocap::glam::{DQuat, DVec3, Quat};
use mocap::scene::RotationOrder;
use mocap_render::internals::unwrapped;

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
