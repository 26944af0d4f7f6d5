//! Identifiers: letters, digits and `_` of ASCII, which every version of USD takes, each once.

use crate::unique_names::UniqueNames;

#[derive(Default)]
pub(super) struct Names(UniqueNames);

impl Names {
    /// The identifier of a name, or of `instead` where nothing of it is left; with a suffix where it is taken.
    pub(super) fn unique(&mut self, wanted: &str, instead: &str) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_identifiers_and_each_is_there_once() {
        let mut names = Names::default();
        let made = ["mixamorig:Hips", "mixamorig Hips", "", "左腕", "左足", "1st", "Hips_2"];
        let made = made.map(|name| names.unique(name, "Joint"));
        assert_eq!(
            made,
            [
                "mixamorig_Hips",
                "mixamorig_Hips_2",
                "Joint",
                "Joint__",
                "Joint___2",
                "_1st",
                "Hips_2"
            ]
        );
    }
}
