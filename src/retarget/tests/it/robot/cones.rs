//! Tests the forces that contacts can exert.

use mocap::glam::DVec3;
use mocap_retarget::internals::Cones;

/// The four corners of a sole of 20 by 10 cm, one metre below.
fn sole() -> Cones {
    let mut cones = Cones::default();
    let corners = [(0.1, 0.05), (0.1, -0.05), (-0.1, 0.05), (-0.1, -0.05)];
    cones.set(corners.into_iter().map(|(x, y)| DVec3::new(x, y, -1.0)));
    cones
}

/// By hand: each of four corners carries a quarter of the weight.
#[test]
fn corners_carry_a_weight_evenly() {
    let (forces, force, moment) = sole().reach(DVec3::Z, DVec3::ZERO);
    assert!(force.length() + moment.length() < 1e-5, "{force} {moment}");
    for corner in forces {
        assert!(corner.abs_diff_eq(0.25 * DVec3::Z, 1e-4), "{corner}");
    }
}

/// By hand: nothing pulls a robot down, friction is at most the weight, and a weight outside the sole is not carried.
#[test]
fn what_no_contact_gives_is_left() {
    let (_, force, _) = sole().reach(-DVec3::Z, DVec3::ZERO);
    assert!(force.abs_diff_eq(-DVec3::Z, 1e-5), "{force}");
    // The centre of pressure is 0.3 m ahead of the middle, but the sole ends at 0.1 m.
    let (_, force, moment) = sole().reach(DVec3::Z, DVec3::new(0.0, -0.3, 0.0));
    assert!(force.length() + moment.length() > 0.1, "{force} {moment}");
    // The centre of pressure is within the sole, at 0.05 m.
    let (_, force, moment) = sole().reach(DVec3::Z, DVec3::new(0.0, -0.05, 0.0));
    assert!(force.length() + moment.length() < 1e-5, "{force} {moment}");
    let mut none = Cones::default();
    let (_, force, _) = none.reach(DVec3::Z, DVec3::ZERO);
    assert_eq!(force, DVec3::Z);
}
