//! Tests of the events in a file.

use mocap::scene::{Event, Side};
use mocap_solve::internals::meaning;

#[test]
fn events_are_known_by_their_context_or_by_their_first_letters() {
    let event = |label: &str, context: &str| {
        let (label, context) = (label.to_owned(), context.to_owned());
        meaning(&Event {
            label,
            context,
            ..Event::default()
        })
    };
    assert_eq!(event("Foot Strike", "Left"), Some((Side::Left, true)));
    assert_eq!(event("FOOT OFF", "Right"), Some((Side::Right, false)));
    assert_eq!(event("RHS", ""), Some((Side::Right, true)));
    assert_eq!(event("LTO", "General"), Some((Side::Left, false)));
    assert_eq!(event("Left Heel Strike", ""), Some((Side::Left, true)));
    assert_eq!(event("Event", "Left"), None);
    assert_eq!(event("Foot Strike", ""), None);
}
