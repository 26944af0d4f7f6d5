//! Tests how the library imitates readers that decode keys.

use mocap_compress::internals::slerp_weight;
use mocap_scene::math::soa::double::{LANES, Lanes};

#[test]
fn slerp_weights_of_small_angles_equal_ratios_of_sines() {
    let alphas = Lanes::of(|lane| [0.0, 0.25, 0.8, 1.0][lane]);
    for step in 1..=200 {
        let angle = f64::from(step) * 1e-3;
        let found = slerp_weight(alphas, Lanes::all(angle.cos()));
        for lane in 0..LANES {
            let expected = (alphas.0[lane] * angle).sin() / angle.sin();
            assert!((found.0[lane] - expected).abs() < 1e-15, "{angle}: {}", found.0[lane]);
        }
    }
}
