//! The explained differences in the table of `README.md`, which the comparison uses.

const README: &str = include_str!("../README.md");

/// The ids of the explained differences, in the order of the tables.
pub(crate) fn ids() -> impl Iterator<Item = &'static str> {
    rows().map(|(id, _)| id)
}

/// Whether the README explains the difference. A rule without a row explains nothing.
pub(crate) fn explains(id: &str) -> bool {
    ids().any(|row| row == id)
}

/// The rows whose first cell is an id in backquotes, as id and the rest.
fn rows() -> impl Iterator<Item = (&'static str, &'static str)> {
    README
        .lines()
        .filter_map(|line| line.strip_prefix("| `")?.split_once("` |"))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::explain::RULES;
    use crate::refusals::REFUSALS;
    use crate::text::{MINUS_ZERO, SIXTH_DIGIT};

    #[test]
    fn every_rule_has_its_row_and_every_row_its_rule() {
        let rules = RULES.iter().map(|rule| rule.id);
        let refusals = REFUSALS.iter().map(|refusal| refusal.id);
        let in_code: BTreeSet<&str> = rules.chain(refusals).chain([MINUS_ZERO, SIXTH_DIGIT]).collect();
        assert_eq!(in_code, ids().collect::<BTreeSet<&str>>());
        assert_eq!(ids().count(), in_code.len(), "an id stands twice");
    }

    #[test]
    fn every_row_gives_what_and_why() {
        for (id, rest) in rows() {
            assert_eq!(rest.matches(" | ").count(), 1, "{id}");
        }
    }
}
