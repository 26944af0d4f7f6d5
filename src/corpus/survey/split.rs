//! Splits a corpus into parts for training and testing, so that each group of clips is in one part.
//!
//! The part of a group depends only on a hash of what its clips have in common, such as the person. Other clips, and
//! the order of the clips, never change the part.

use std::collections::BTreeMap;

use mocap_scene::error::{Code, Diagnostic, Result};
use sha2::{Digest, Sha256};

use super::corpus::Corpus;
use super::row::ClipRow;
use super::select::SelectBy;

/// The largest deviation of the sum of the fractions from 1, because users round the fractions.
const OFF_ONE: f64 = 1e-6;

/// The names of the parts.
fn names(parts: usize) -> Vec<String> {
    match parts {
        2 => ["train", "test"].map(str::to_owned).into(),
        3 => ["train", "validation", "test"].map(str::to_owned).into(),
        _ => (1..=parts).map(|part| part.to_string()).collect(),
    }
}

impl Corpus {
    /// Assigns each clip to a part. `parts` has the fractions of the parts: two parts are train and test, three are
    /// train, validation and test. Clips that share a property in `by` are in the same part. A clip whose record has a
    /// part keeps the part, and so does its group. Files that cannot be read have no part.
    ///
    /// # Errors
    /// - [`Code::InvalidValue`] for fractions that are not above 0 or do not add up to 1
    /// - [`Code::InvalidValue`] if `by` has anything except person, skeleton and near-duplicates, or if a clip states
    ///   no person
    pub fn split(&mut self, parts: &[f64], by: &[SelectBy]) -> Result<()> {
        let sum: f64 = parts.iter().sum();
        if parts.len() < 2 || !parts.iter().all(|part| *part > 0.0) || (sum - 1.0).abs() > OFF_ONE {
            let found = parts.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
            return Err(Diagnostic::new(
                Code::InvalidValue,
                "{split} must state two or more fractions, one for each part",
            )
            .expected_found("two or more numbers above 0 whose sum is 1, such as 0.8,0.1,0.1", found)
            .into());
        }
        let names = names(parts.len());
        let rows: Vec<&ClipRow> = self.rows().collect();
        let groups = groups(&rows, by)?;
        let mut former: BTreeMap<usize, &str> = BTreeMap::new();
        let mut keys: BTreeMap<usize, String> = BTreeMap::new();
        for (row, group) in std::iter::zip(&rows, &groups).filter(|(row, _)| row.error.is_none()) {
            if let Some(part) = row
                .split
                .as_deref()
                .filter(|part| names.iter().any(|name| name == part))
            {
                former.entry(*group).or_insert(part);
            }
            // The key of a group is the alphabetically first text of its clips. The key does not change when later
            // texts are added.
            let key = common(row, by);
            let least = keys.entry(*group).or_insert_with(|| key.clone());
            *least = std::cmp::min(std::mem::take(least), key);
        }
        let chosen = |group: &usize| -> Option<String> {
            let hashed = || part_of(keys.get(group)?, parts).map(|part| names[part].clone());
            former.get(group).map(|part| (*part).to_owned()).or_else(hashed)
        };
        let split: Vec<Option<String>> = groups.iter().map(chosen).collect();
        for (row, part) in std::iter::zip(self.rows_mut(), split) {
            row.split = part.filter(|_| row.error.is_none());
        }
        Ok(())
    }
}

impl Corpus {
    /// The names of the parts of [`split`](Self::split) that have no clip.
    #[doc(hidden)]
    pub fn empty_parts(&self, parts: usize) -> Vec<String> {
        let mut names = names(parts);
        names.retain(|name| self.rows().all(|row| row.split.as_ref() != Some(name)));
        names
    }
}

/// The text that all clips of a group share. Near-duplicates share no such text, so the text is the SHA-256 of the
/// file, or its name if the SHA-256 is unknown.
fn common(row: &ClipRow, by: &[SelectBy]) -> String {
    match () {
        () if by.contains(&SelectBy::Person) => row.person.clone().unwrap_or_default(),
        () if by.contains(&SelectBy::Skeleton) => row.skeleton.clone(),
        () if row.sha256.is_empty() => row.file.clone(),
        () => row.sha256.clone(),
    }
}

/// For each clip, the index of the first clip of its group. Clips of one file are in one group.
fn groups(rows: &[&ClipRow], by: &[SelectBy]) -> Result<Vec<usize>> {
    let mut group: Vec<usize> = (0..rows.len()).collect();
    let mut first: BTreeMap<(&str, String), usize> = BTreeMap::new();
    let mut join = |kind: &'static str, key: String, index: usize| {
        let other = *first.entry((kind, key)).or_insert(index);
        let [a, b] = [root(&group, other), root(&group, index)];
        group[a.max(b)] = a.min(b);
    };
    for (index, row) in rows.iter().enumerate().filter(|(_, row)| row.error.is_none()) {
        join("file", row.file.clone(), index);
        for by in by {
            match by {
                SelectBy::Person => {
                    let person = row.person.clone().ok_or_else(|| without_person(rows))?;
                    join("person", person, index);
                }
                SelectBy::Skeleton => join("skeleton", row.skeleton.clone(), index),
                SelectBy::NearDuplicate => {
                    if let Some(number) = row.twin_group {
                        join("near-duplicate", number.to_string(), index);
                    }
                }
                SelectBy::Quality | SelectBy::Diversity => {
                    let message = "quality and diversity select clips; they cannot split a corpus";
                    return Err(Diagnostic::new(Code::InvalidValue, format!("{{by}}: {message}"))
                        .expected_found("person, skeleton or near-duplicate", "quality or diversity")
                        .into());
                }
            }
        }
    }
    Ok((0..rows.len()).map(|index| root(&group, index)).collect())
}

fn root(group: &[usize], mut clip: usize) -> usize {
    while group[clip] != clip {
        clip = group[clip];
    }
    clip
}

fn without_person(rows: &[&ClipRow]) -> mocap_scene::error::Error {
    let mut without = rows.iter().filter(|row| row.error.is_none() && row.person.is_none());
    let first = without.next().map_or("", |row| row.file.as_str());
    let message = format!("{} clips state no person; the first is {first}", 1 + without.count());
    Diagnostic::new(Code::InvalidValue, message)
        .help("state person = \"NAME\" in a mocap.toml beside the files, or exclude the clips with {where}")
        .into()
}

/// The part that the hash of a string selects.
fn part_of(key: &str, parts: &[f64]) -> Option<usize> {
    let hash = Sha256::digest(key.as_bytes());
    let head = hash.first_chunk::<8>()?;
    let at = u64::from_be_bytes(*head) as f64 / 2f64.powi(64);
    let mut end = 0.0;
    let found = parts.iter().position(|part| {
        end += part;
        at < end
    });
    Some(found.unwrap_or(parts.len() - 1))
}
