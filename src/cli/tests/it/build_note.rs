//! Tests the note that an unoptimised build is slow.

use mocap_cli::internals::note;

#[test]
fn only_an_unoptimised_build_tells_a_person_that_a_command_is_slow() {
    assert!(note(true, true, true).is_some_and(|text| text.contains("cargo run --release")));
    assert_eq!(note(false, true, true), None);
    assert_eq!(note(true, false, true), None);
    assert_eq!(note(true, true, false), None);
}
