//! The subjects of a file. Labels have the subject's name before a colon: `Anna:LASI`. One subject is solved.

use std::collections::HashMap;

use mocap_scene::error::{Code, Diagnostic, Result};

use super::landmarks::{self, KNOWN, Labels, Landmark};

/// The subject's name in a label.
pub(super) fn subject(label: &str) -> Option<&str> {
    let (subject, _) = label.rsplit_once(':')?;
    (!subject.is_empty()).then_some(subject)
}

/// Whether a label belongs to a subject, or to no subject.
pub(super) fn is_of(label: &str, solved: Option<&str>) -> bool {
    let Some(solved) = solved else { return true };
    subject(label).is_none_or(|own| own == solved)
}

/// The subject to solve: the requested one, or else the one with the most known markers. `None` if the labels name at
/// most one subject.
///
/// # Errors
/// No label belongs to the requested subject.
pub(super) fn chosen<'l>(
    labels: &'l [String],
    asked: &Labels,
    known: &HashMap<String, Landmark>,
) -> Result<Option<&'l str>> {
    let mut subjects: Vec<(&str, usize)> = Vec::new();
    for label in labels {
        let Some(own) = subject(label) else { continue };
        let is_known = match asked.named.is_empty() {
            true => known.contains_key(&landmarks::key(label)),
            false => asked.landmark(label).is_some(),
        };
        match subjects.iter_mut().find(|(subject, _)| *subject == own) {
            Some((_, count)) => *count += usize::from(is_known),
            None => subjects.push((own, usize::from(is_known))),
        }
    }
    if let Some(asked) = &asked.subject {
        let found = subjects.iter().find(|(subject, _)| subject.eq_ignore_ascii_case(asked));
        let names: Vec<&str> = subjects.iter().map(|(subject, _)| *subject).collect();
        return match found {
            Some((subject, _)) => Ok(Some(subject)),
            None => Err(Diagnostic::new(
                Code::InvalidValue,
                format!("no marker of the file belongs to the subject {asked:?}"),
            )
            .expected_found(
                format!("labels such as {asked}:LASI"),
                match names.as_slice() {
                    [] => "labels without the name of a subject before a colon".to_owned(),
                    names => format!("labels of {}", names.join(", ")),
                },
            )
            .help("the labels of a file: mocap info FILE")
            .into()),
        };
    }
    let people = subjects.iter().filter(|(_, count)| *count >= KNOWN).count();
    // On a tie, the first subject of the file.
    let most = subjects.iter().rev().max_by_key(|(_, count)| *count);
    Ok(most.filter(|_| people > 1).map(|(subject, _)| *subject))
}

/// The warning about subjects that are not solved.
pub(super) fn left_out(solved: &str, others: &[String]) -> Diagnostic {
    let mut names: Vec<&str> = others.iter().filter_map(|label| subject(label)).collect();
    names.sort_unstable();
    names.dedup();
    let message = format!(
        "the file has markers of several subjects: {solved} was solved; {} markers of {} were skipped",
        others.len(),
        names.join(", ")
    );
    let next = names.first().copied().unwrap_or_default();
    Diagnostic::new(Code::LooseMarker, message).help(format!("solve another one: {{markers}} auto:{next}"))
}
