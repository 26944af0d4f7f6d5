//! Tests cube roots.

use mocap_scene::math::cube_root::cube_root;

#[test]
fn it_is_the_nearest_number() {
    for value in [1e-38_f32, 1e-20, 3e-7, 0.001, 0.5, 1.0, 2.0, 27.0, 1e6, 3e38] {
        let expected = f64::from(value).cbrt() as f32;
        assert_eq!(cube_root(value).to_bits(), expected.to_bits(), "{value}");
    }
}
