//! Tests how numbers are written in BVH.

use mocap_formats::internals::bvh::{push, shortest};

#[test]
fn numbers_have_the_decimals_asked_for_or_needed() {
    let printed = |value, digits| {
        let mut text = String::new();
        push(&mut text, value, digits);
        text
    };
    assert_eq!(printed(1.0, None), "1");
    assert_eq!(printed(-0.0, None), "0");
    assert_eq!(printed(0.1 + 0.2, None), "0.30000000000000004");
    assert_eq!(printed(-12.3456, Some(2)), "-12.35");
    assert_eq!(printed(-0.001, Some(2)), "0.00");
}

#[test]
fn the_shortest_spelling_is_the_first_that_will_do() {
    assert_eq!(
        shortest([0.300_000_000_000_01], |[value]| (value - 0.3).abs() < 1e-9),
        Some([0.3])
    );
    assert_eq!(shortest([1.0 / 3.0], |[value]| value == 1.0 / 3.0), Some([1.0 / 3.0]));
    assert_eq!(shortest([1.0], |_| false), None);
}
