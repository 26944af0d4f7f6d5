//! Suggestions for misspelled words.

/// The name closest to the word `misspelled`, ignoring case. At most a third of the letters may differ, and at most
/// three letters.
#[doc(hidden)]
pub fn nearest<'a>(misspelled: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    /// The largest number of letters that may differ.
    const MOST: usize = 3;
    /// The length in letters of the longest word to compare. The time grows with the product of the two lengths.
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

/// The number of insertions, deletions, substitutions and swaps of neighbouring letters from `a` to `b`.
pub fn edit_distance(a: &str, b: &str) -> usize {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let mut before: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 0..a.len() {
        let mut row = vec![i + 1];
        for j in 0..b.len() {
            let substituted = last[j] + usize::from(a[i] != b[j]);
            let mut least = substituted.min(row[j] + 1).min(last[j + 1] + 1);
            if i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j] {
                least = least.min(before[j - 1] + 1);
            }
            row.push(least);
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}
