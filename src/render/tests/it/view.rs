//! Tests the script of the player page.

mod listing;
mod morphs;
mod pack;
mod skin;

use mocap_render::internals::view::{filled, script};

#[test]
fn the_script_is_small() {
    let bytes = script().len();
    assert!(bytes < 132_000, "{bytes} bytes");
}

#[test]
fn a_script_has_no_words_of_modules() {
    let script = script();
    let is_of_modules = |line: &&str| line.starts_with("import ") || line.starts_with("export ");
    assert_eq!(script.lines().find(is_of_modules), None);
    // The entry point of the page comes last, after the modules that it uses.
    let place = |text: &str| script.find(text).unwrap();
    assert!(place("class Stage") < place("class Player"));
}

#[test]
fn a_template_is_filled_once() {
    let value = |name: &str| format!("<{name} {{{{x}}}}>").into();
    assert_eq!(filled("a {{b}} c {{d}}{", value), "a <b {{x}}> c <d {{x}}>{");
}
