//! Makes names unique: Unreal Engine rejects two bones with the same name, and other programs use only the first.

use crate::unique_names::UniqueNames;

/// Makes unique names.
#[derive(Default)]
pub(super) struct Names(UniqueNames);

impl Names {
    /// Returns `wanted`, or `instead` if `wanted` is empty. If the name is taken, returns the first free name of
    /// `wanted_2`, `wanted_3`, ... Control characters become `_`, because FBX separates a name from its class by two
    /// control characters.
    pub(super) fn unique(&mut self, wanted: &str, instead: &str) -> String {
        let wanted = if wanted.trim().is_empty() { instead } else { wanted };
        let wanted: String = wanted.chars().map(|c| if c.is_control() { '_' } else { c }).collect();
        self.0.first_free(wanted, str::to_owned)
    }

    /// A unique file name. The comparison ignores case, because some file systems ignore case.
    pub(super) fn unique_file(&mut self, wanted: &str, instead: &str) -> String {
        let wanted = if wanted.is_empty() { instead } else { wanted };
        self.0.first_free(wanted.to_owned(), str::to_lowercase)
    }
}
