//! Writes the parts of the bindings in other languages that mirror the library.

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

/// A file that is written here, or in which a table is.
#[derive(Clone, Debug)]
pub struct Generated {
    /// Its path from the root of the repository.
    pub path: &'static str,
    /// What it holds.
    pub text: String,
}

/// The generated files of all languages.
///
/// # Panics
/// Where the schema of jobs has a form that [`Model`] does not know, or a document has no place for its table.
pub fn files() -> Vec<Generated> {
    let model = Model::new();
    [python::files(&model), typescript::files(&model), tables::files(&model)].concat()
}
