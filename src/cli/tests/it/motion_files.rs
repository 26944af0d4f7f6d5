//! The GitHub action and the hooks of pre-commit name the extensions of motion files.

use std::collections::BTreeSet;
use std::fs;

use mocap::{Format, FormatInfo};

use crate::at_root;

/// Readable formats whose files may not be motions: robots, skeletons, arrays, tables.
const OTHERS: [Format; 10] = [
    Format::Urdf,
    Format::Mjcf,
    Format::Pmx,
    Format::Npz,
    Format::Npy,
    Format::Torch,
    Format::Pickle,
    Format::Parquet,
    Format::Csv,
    Format::Mot,
];

#[test]
fn the_action_and_the_hooks_check_every_motion_format() {
    let rows = FormatInfo::ALL
        .iter()
        .filter(|row| !row.reading.starts_with("no") && !OTHERS.contains(&row.format));
    // An Acclaim skeleton is read together with its motion.
    let extensions = rows
        .flat_map(|row| row.extensions)
        .filter(|extension| **extension != "asf");
    let expected: BTreeSet<&str> = extensions.copied().collect();
    for (file, count) in [(".pre-commit-hooks.yaml", 2), ("tools/release/action", 1)] {
        let text = fs::read_to_string(at_root(file)).unwrap();
        let lists: Vec<&str> = text
            .split("\\.(")
            .skip(1)
            .map(|after| after.split(")$").next().unwrap())
            .collect();
        assert_eq!(lists.len(), count, "{file}");
        for list in lists {
            assert_eq!(list.split('|').collect::<BTreeSet<_>>(), expected, "{file}");
        }
    }
}
