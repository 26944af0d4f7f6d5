//! Names as the scene has them, each once: Unreal Engine refuses a second bone of a name, and others take the first.

use crate::unique_names::UniqueNames;

/// Makes unique names.
#[derive(Default)]
pub(super) struct Names(UniqueNames);

impl Names {
    /// `wanted`, or else `instead` where it is empty; or the first of `wanted_2`, `wanted_3`, ... that is free. Control
    /// characters become `_`, because two of them separate a name from its class.
    pub(super) fn unique(&mut self, wanted: &str, instead: &str) -> String {
        let wanted = if wanted.trim().is_empty() { instead } else { wanted };
        let wanted: String = wanted.chars().map(|c| if c.is_control() { '_' } else { c }).collect();
        self.0.first_free(wanted, str::to_owned)
    }

    /// A unique name of a file: some systems do not tell capitals from small letters.
    pub(super) fn unique_file(&mut self, wanted: &str, instead: &str) -> String {
        let wanted = if wanted.is_empty() { instead } else { wanted };
        self.0.first_free(wanted.to_owned(), str::to_lowercase)
    }
}
