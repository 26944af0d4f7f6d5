//! Facts about this build: version, commit, features and target.

use std::sync::OnceLock;

/// The version of all packages.
pub(crate) const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The first digits of the commit; `unknown` if the sources do not have it.
pub(crate) const COMMIT: &str = env!("MOCAP_COMMIT");

/// The target triple.
pub(crate) const TARGET: &str = env!("MOCAP_TARGET");

/// The optional features of the program, with whether this build has them.
pub(crate) const FEATURES: [(&str, bool); 3] = [
    ("fbx", cfg!(feature = "fbx")),
    ("meshopt", cfg!(feature = "meshopt")),
    ("parquet", cfg!(feature = "parquet")),
];

/// The features that this build has.
pub(crate) fn features() -> Vec<&'static str> {
    let built = FEATURES.iter().filter(|(_, is_built)| *is_built);
    built.map(|(name, _)| *name).collect()
}

/// The output of `mocap --version` after the name of the program.
pub(crate) fn long() -> &'static str {
    static TEXT: OnceLock<String> = OnceLock::new();
    TEXT.get_or_init(|| {
        let features = match features() {
            features if features.is_empty() => "none".to_owned(),
            features => features.join(", "),
        };
        format!("{VERSION}\ncommit: {COMMIT}\nfeatures: {features}\ntarget: {TARGET}")
    })
}
