//! The keys around a frame of a packed clip.

use mocap_compress::internals::key_in;

#[test]
fn the_keys_around_a_frame_are_found() {
    let mask = [1 | 1 << 5 | 1 << 63, 1 | 1 << 2, 1, 1];
    for (frame, expected) in [
        (0, (0, 0, Some(5))),
        (4, (0, 0, Some(5))),
        (5, (1, 5, Some(63))),
        (62, (1, 5, Some(63))),
        (63, (2, 63, Some(64))),
        (64, (3, 64, Some(66))),
        (100, (4, 66, Some(128))),
        (255, (6, 192, None)),
    ] {
        assert_eq!(key_in(&mask, frame), expected, "{frame}");
    }
}
