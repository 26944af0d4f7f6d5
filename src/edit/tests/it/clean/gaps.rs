//! Tests the median of nine values, which the search for gaps uses.

use mocap_edit::internals::middle_of_nine;

#[test]
fn the_middle_of_nine_is_their_median() {
    let mut order = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
    let mut state = 1_u32;
    for _ in 0..2000 {
        for at in (1..order.len()).rev() {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            order.swap(at, (state >> 8) as usize % (at + 1));
        }
        assert_eq!(middle_of_nine(order), 4.0, "{order:?}");
    }
}
