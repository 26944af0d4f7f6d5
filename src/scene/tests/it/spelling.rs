//! Options in messages of the library, in the spelling of each interface.

use mocap_scene::error::{Code, Diagnostic, spelled};

#[test]
fn options_have_the_names_of_methods_where_no_door_says_otherwise() {
    let diagnostic = Diagnostic::new(Code::InvalidValue, "name it with {max-error}").help("leave {rest} out");
    assert_eq!(diagnostic.message, "name it with `max_error`");
    assert_eq!(diagnostic.help.as_deref(), Some("leave `rest` out"));
}

#[test]
fn other_braces_stay() {
    for text in [
        "{",
        "}",
        "{}",
        "{{",
        "a {\"bones\": 1}",
        "{Hips} {1}",
        "{a",
        "x{ y }",
        "{ö}",
    ] {
        assert_eq!(spelled(text), text);
    }
    assert_eq!(spelled("{{up}}"), "{`up`}");
    assert_eq!(spelled("{a {up} b}"), "{a `up` b}");
}
