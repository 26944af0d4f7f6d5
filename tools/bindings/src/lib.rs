//! Generates the parts of the bindings in other languages that mirror the library.

mod docs;
pub mod model;
#[allow(dead_code, reason = "the module for WebAssembly uses the rest of it")]
#[path = "../../wasm/src/names.rs"]
mod names;
mod python;
mod tables;
mod typescript;

use model::Model;

/// The root of the repository.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// A generated file, or a document with a generated table.
#[derive(Clone, Debug)]
pub struct Generated {
    /// The path, relative to the root of the repository.
    pub path: &'static str,
    /// The contents of the file.
    pub text: String,
}

/// The generated files of all languages.
///
/// # Panics
/// Panics if the schema of jobs has a form that [`Model`] does not know, or if a document has no place for its table.
pub fn files() -> Vec<Generated> {
    let model = Model::new();
    [python::files(&model), typescript::files(&model), tables::files(&model)].concat()
}
