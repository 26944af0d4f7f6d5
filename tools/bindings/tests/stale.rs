//! The generated files match the library.

use mocap_bindings::{Generated, files};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// `MOCAP_WRITE=1` writes the files.
#[test]
fn generated_files_are_up_to_date() {
    let is_writing = std::env::var_os("MOCAP_WRITE").is_some();
    let mut stale = Vec::new();
    for Generated { path, text } in files() {
        let file = format!("{ROOT}/{path}");
        if std::fs::read_to_string(&file).unwrap_or_default() == text {
            continue;
        }
        match is_writing {
            true => std::fs::write(&file, text).unwrap(),
            false => stale.push(path),
        }
    }
    assert!(
        stale.is_empty(),
        "MOCAP_WRITE=1 cargo test -p mocap-bindings writes {}",
        stale.join(", ")
    );
}
