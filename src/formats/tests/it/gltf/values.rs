//! Keys that are inserted in the middle of half a turn.

use mocap::glam::Quat;
use mocap::scene::Keys;
use mocap_formats::internals::gltf::with_middles;

#[test]
fn half_a_turn_has_a_key_in_its_middle() {
    let start = Quat::from_xyzw(0.0, 0.705_533_7, -0.047_140_453, -0.707_106_77);
    let end = Quat::from_xyzw(-0.707_106_77, 0.047_140_453, 0.705_533_7, 0.0);
    let keys = |last| Keys::at_ticks(vec![start, end], vec![41.0, last]);
    let with_middle = with_middles(&keys(43.0)).expect("which way the turn goes is open");
    assert_eq!(with_middle.ticks.as_deref(), Some([41.0, 42.0, 43.0].as_slice()));
    let middle = keys(43.0).sample(42.0).expect("there are keys");
    assert_eq!(with_middle.values, [start, middle, end]);
    // The middle key is a quarter turn from both ends, so the direction of the rotation is unique.
    for end in [start, end] {
        assert!(middle.dot(end).abs() > 0.7);
    }
    assert!(with_middles(&keys(42.0)).is_none(), "no frame is between the two");
    assert!(with_middles(&Keys::at_ticks(vec![start, middle], vec![41.0, 43.0])).is_none());
}
