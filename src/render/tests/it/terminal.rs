//! Tests how messages are wrapped on a terminal.

use mocap_render::internals::wrapped;

#[test]
fn words_are_wrapped_between_them() {
    assert_eq!(wrapped("a bb ccc dddddddd e", 6), ["a bb", "ccc", "dddddddd", "e"]);
}
