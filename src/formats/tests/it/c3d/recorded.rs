//! Tests the conversion of the units of channels.

use mocap_formats::internals::c3d::si;

#[test]
fn units_of_channels_are_newtons_metres_and_newton_metres() {
    assert_eq!(si(2, 0, "N", 0.001), 1.0);
    assert_eq!(si(2, 4, "N.mm", 0.001), 0.001);
    assert_eq!(si(2, 4, "Nm", 0.001), 1.0);
    assert_eq!(si(2, 4, "", 0.01), 0.01);
    assert_eq!(si(1, 3, "mm", 1.0), 0.001);
    assert_eq!(si(3, 5, "N", 0.001), 1.0);
}
