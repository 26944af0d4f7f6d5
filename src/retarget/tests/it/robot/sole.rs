//! Tests the balls that stand for the sole of a robot's foot.

use mocap::glam::{DQuat, DVec3};
use mocap::scene::robot::{Placement, RobotShape, ShapeKind};
use mocap_retarget::internals::sole::{SoleBall, balls, on_the_floor};

/// A foot with a box of 24 x 10 x 4 cm, tilted by 20 degrees with the toes up.
fn foot(tilt: f64) -> Vec<SoleBall> {
    let shape = RobotShape {
        origin: Placement {
            rotation: DQuat::from_rotation_y(tilt.to_radians()),
            translation: DVec3::new(0.1, 0.0, -0.8),
        },
        kind: ShapeKind::Box {
            half_size: DVec3::new(0.12, 0.05, 0.02),
        },
        collides: true,
    };
    balls(&shape, &Placement::IDENTITY)
}

#[test]
fn a_tilted_foot_stands_on_its_whole_sole() {
    for tilt in [-25.0, -7.0, 20.0, 31.5] {
        let sole = on_the_floor(foot(tilt), &Placement::IDENTITY, 0.8, true);
        assert_eq!(sole.balls.len(), 4, "{tilt}");
        let back = (sole.to_flat * DQuat::from_rotation_y(f64::to_radians(tilt))).to_scaled_axis();
        assert!(back.length() < 1e-9, "{tilt} {back}");
    }
    assert_eq!(
        on_the_floor(foot(0.0), &Placement::IDENTITY, 0.8, true).to_flat,
        DQuat::IDENTITY
    );
}
