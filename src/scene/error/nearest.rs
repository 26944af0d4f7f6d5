//! Suggestions for misspelled words.

/// The name closest to a misspelled one, ignoring case, if at most a third of the letters differ, and at most three.
#[doc(hidden)]
pub fn nearest<'a>(misspelled: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    /// Letters that may differ.
    const MOST: usize = 3;
    /// The longest word that is compared: the time grows with the product of the two lengths.
    const LONGEST: usize = 64;
    let misspelled = misspelled.to_ascii_lowercase();
    if misspelled.len() > LONGEST {
        return None;
    }
    let most = MOST.min(misspelled.len() / 3);
    names
        .filter(|name| name.len().abs_diff(misspelled.len()) <= most)
        .map(|name| (edit_distance(&name.to_ascii_lowercase(), &misspelled), name))
        .filter(|&(distance, _)| distance <= most)
        .min()
        .map(|(_, name)| name)
}

/// Levenshtein's distance: insertions, deletions and substitutions from `a` to `b`.
pub fn edit_distance(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, byte_a) in a.bytes().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, byte_b) in b.bytes().enumerate() {
            let substituted = diagonal + usize::from(byte_a != byte_b);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}
