//! The script of the player page.

mod listing;
mod morphs;
mod pack;
mod skin;

use mocap_render::internals::view::{MODULES, filled, script};

#[test]
fn the_script_is_small() {
    let bytes = script().len();
    assert!(bytes < 132_000, "{bytes} bytes");
}

#[test]
fn a_module_imports_only_those_before_it() {
    let names = "math dom curves reach fabrik posing clip skin batch renderer_skin renderer_gl renderer_2d camera \
                 colors marks chart morphs product source_text chain_panel sliders panel stage drag bytes webm gif mp4 \
                 film time_line player packed unpack page";
    let names = names.split_whitespace();
    let names: Vec<_> = names.map(|name| format!("\"./{name}.js\"")).collect();
    for (index, module) in MODULES.iter().enumerate() {
        for line in module.lines().filter(|line| line.starts_with("import ")) {
            let from = line.split(" from ").nth(1).unwrap().trim_end_matches(';');
            assert!(
                names[..index].iter().any(|name| name == from),
                "{}: {line}",
                names[index]
            );
        }
    }
}

#[test]
fn a_template_is_filled_once() {
    let value = |name: &str| format!("<{name} {{{{x}}}}>").into();
    assert_eq!(filled("a {{b}} c {{d}}{", value), "a <b {{x}}> c <d {{x}}>{");
}
