//! Unique identifiers of ASCII letters, digits and `_`, which every version of USD accepts.

use crate::unique_names::UniqueNames;

#[derive(Default)]
pub struct Names(UniqueNames);

impl Names {
    /// The identifier for a name, or for `instead` if no character remains. A taken identifier gets a suffix.
    pub fn unique(&mut self, wanted: &str, instead: &str) -> String {
        self.0.first_free(identifier(wanted, instead), str::to_owned)
    }
}

fn identifier(name: &str, instead: &str) -> String {
    let name = name.trim();
    let is_letter = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut found: String = name.chars().map(|c| if is_letter(c) { c } else { '_' }).collect();
    if !found.contains(|c: char| c.is_ascii_alphanumeric()) {
        found = format!("{instead}{found}");
    }
    match found.starts_with(|c: char| c.is_ascii_digit()) {
        true => format!("_{found}"),
        false => found,
    }
}
