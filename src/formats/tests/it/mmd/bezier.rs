//! Tests the Bézier curves of MikuMikuDance (MMD).

use mocap_formats::internals::mmd::ease;

#[test]
fn a_curve_is_that_of_its_points() {
    assert_eq!(ease([20, 20, 107, 107], 0.3), 0.3);
    assert_eq!(ease([0, 0, 0, 0], 0.3), 0.3);
    // The curve with both control points at (1, 0) is x = 1 - (1-s)^3, y = s^3. At s = 1/2, x = 7/8 and y = 1/8.
    assert!((ease([127, 0, 127, 0], 0.875) - 0.125).abs() < 1e-9);
    for curve in [[64, 0, 64, 127], [0, 127, 127, 0], [127, 0, 0, 127]] {
        assert!(ease(curve, 0.0).abs() < 1e-3 && (ease(curve, 1.0) - 1.0).abs() < 1e-3);
    }
}
