//! Compares the committed header with the header generated from the source.

use std::fs;

/// Generates the header. `MOCAP_HEADER=write cargo test --test header` writes it.
#[test]
fn the_header_is_current() {
    let config = cbindgen::Config::from_file("cbindgen.toml").unwrap();
    let builder = cbindgen::Builder::new().with_config(config);
    let sources = ["src/border.rs", "src/handle.rs", "src/lib.rs"];
    let builder = sources.into_iter().fold(builder, cbindgen::Builder::with_src);
    let mut made = Vec::new();
    builder.generate().unwrap().write(&mut made);
    let made = String::from_utf8(made).unwrap();

    if std::env::var("MOCAP_HEADER").as_deref() == Ok("write") {
        fs::write("mocap.h", &made).unwrap();
    }
    let committed = fs::read_to_string("mocap.h").unwrap_or_default();
    assert!(
        committed == made,
        "mocap.h is not what src/ says; see the test for how to write it"
    );
}

#[test]
fn pkg_config_states_the_version() {
    let pc = fs::read_to_string("mocap.pc").unwrap();
    let version = format!("Version: {}", env!("CARGO_PKG_VERSION"));
    assert!(
        pc.lines().any(|line| line == version),
        "mocap.pc has no line \"{version}\""
    );
}

/// The classes in C++ use every function of the header.
#[test]
fn the_cpp_header_has_every_function() {
    let header = fs::read_to_string("mocap.h").unwrap();
    let owners = fs::read_to_string("mocap.hpp").unwrap();
    let words = header.split(|letter: char| !letter.is_ascii_alphanumeric() && letter != '_');
    let functions: std::collections::BTreeSet<_> = words
        .filter(|word| word.starts_with("mocap_") && header.contains(&format!("{word}(")))
        .collect();
    assert!(functions.len() > 30);
    for function in functions {
        assert!(owners.contains(function), "mocap.hpp does not use {function}");
    }
}

#[test]
fn the_header_names_every_format() {
    let header = fs::read_to_string("mocap.h").unwrap();
    for format in mocap::FormatInfo::ALL {
        for extension in format.extensions {
            let name = format!("`.{extension}`");
            assert!(header.contains(&name), "mocap.h does not name {name}");
        }
    }
}
