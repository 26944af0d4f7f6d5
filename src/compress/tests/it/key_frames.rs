//! Tests which frames get a key.

use std::slice;

use mocap_compress::internals::key_frames::{Insertion, Refine, for_each_frame, insert, reduce, refine};

#[test]
fn keys_are_as_far_apart_as_the_condition_allows() {
    for distance in [1, 2, 3, 7, 100] {
        let key_frames = reduce(50, |from, to| to - from <= distance);
        let expected: Vec<u32> = (0..49).step_by(distance).chain([49]).collect();
        assert_eq!(key_frames, expected, "{distance}");
    }
    assert_eq!(reduce(0, |_, _| true), [0]);
    assert_eq!(reduce(1, |_, _| true), [0]);
    assert_eq!(reduce(2, |_, _| true), [0, 1]);
}

#[test]
fn a_frame_with_too_large_an_error_gets_a_key() {
    let errors = [0.0, 2.0, 3.0, 0.5, 1.5, 0.0];
    let mut key_frames = vec![0, 3, 5];
    let insertion = |frame, after| Insertion { frame, after };
    let found = refine(&mut key_frames, &errors, 1.0, Refine::Worst);
    assert_eq!(found, (vec![insertion(2, 0), insertion(4, 1)], vec![0..3, 3..5]));
    assert_eq!(key_frames, [0, 2, 3, 4, 5]);
    let changed = slice::from_ref(&(0..2)).to_vec();
    let found = refine(&mut key_frames, &errors, 1.0, Refine::Worst);
    assert_eq!(found, (vec![insertion(1, 0)], changed));
    assert_eq!(key_frames, [0, 1, 2, 3, 4, 5]);
    assert_eq!(refine(&mut key_frames, &errors, 1.0, Refine::Worst), (vec![], vec![]));

    let mut key_frames = vec![0, 3, 5];
    let found = refine(&mut key_frames, &errors, 1.8, Refine::All);
    let changed = slice::from_ref(&(0..3)).to_vec();
    assert_eq!(found, (vec![insertion(1, 0), insertion(2, 0)], changed));
    assert_eq!(key_frames, [0, 1, 2, 3, 5]);
}

#[test]
fn every_frame_is_visited_with_the_key_before_it() {
    let ticks = [0.0, 1.0, 1.5, 2.0, 3.0, 4.0];
    let mut found = Vec::new();
    for_each_frame(&[0, 3, 5], &ticks, slice::from_ref(&(0..6)), |frame, key, alpha| {
        found.push((frame, key, alpha));
    });
    let expected = [
        (0, 0, 0.0),
        (1, 0, 0.5),
        (2, 0, 0.75),
        (3, 1, 0.0),
        (4, 1, 0.5),
        (5, 2, 0.0),
    ];
    assert_eq!(found, expected);
    let mut found = Vec::new();
    for_each_frame(&[0, 2, 3, 5], &ticks, &[0..2, 3..5], |frame, key, _| {
        found.push((frame, key));
    });
    assert_eq!(found, [(0, 0), (1, 0), (3, 2), (4, 2)]);
}

#[test]
fn values_are_inserted_after_others() {
    let mut values = vec!["a", "c", "d", "e", "g"];
    let insertion = |after| Insertion { frame: 0, after };
    insert(
        &mut values,
        &[insertion(0), insertion(3), insertion(4)],
        &["b", "f", "h"],
    );
    assert_eq!(values, ["a", "b", "c", "d", "e", "f", "g", "h"]);
}
