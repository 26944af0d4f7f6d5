//! Tests how the BVH reader finds the layout of rows.

use mocap_formats::internals::bvh::{Layout, count_numbers, find};
use mocap_formats::internals::text::Cursor;

fn find_in(text: &str, channel_count: usize, declared: u64) -> Option<Layout> {
    find(&Cursor::new(text.as_bytes()), channel_count, declared, 0, declared).ok()
}

#[test]
fn runs_are_counted_number_by_number() {
    assert_eq!(count_numbers(b" 0.0-5.0 1e-5\t-2 .5-.5 "), 6);
}

#[test]
fn a_broken_line_among_many_does_not_change_the_rule() {
    assert_eq!(find_in("1 2 3\n1 2\n1 2 3\n", 3, 3), Some(Layout::Lines));
    assert_eq!(find_in("1 2 3\n1 2 3 4\n", 3, 2), Some(Layout::Lines));
}

#[test]
fn lines_after_the_declared_rows_do_not_change_the_rule() {
    assert_eq!(find_in("1 2 3\n1 2 3\n1 2\n1 2\n1 2\n", 3, 2), Some(Layout::Lines));
}

#[test]
fn wrapped_and_joined_rows_are_a_stream() {
    assert_eq!(find_in("1 2\n3 4\n1 2\n3 4\n", 4, 2), Some(Layout::Stream));
    assert_eq!(find_in("1 2 3 4 1 2 3 4", 4, 2), Some(Layout::Stream));
    // Uneven wrapping is accepted if the total number of values is as declared.
    assert_eq!(find_in("1 2 3\n4 1 2 3 4\n", 4, 2), Some(Layout::Stream));
}

#[test]
fn rows_of_another_length_throughout_have_no_rule() {
    assert_eq!(find_in("1 2 3 4 5\n1 2 3 4 5\n", 4, 2), None);
    assert_eq!(find_in("1 2 3\n1 2 3\n1 2 3\n", 4, 3), None);
}
