//! Joints that never rotate, found in the text of a BVH file.

use std::collections::BTreeMap;
use std::fs;

/// The joints of a file of `fixtures` whose rotation channels have one value in all rows.
pub(crate) fn still_joints(file: &str) -> Vec<String> {
    let text = fs::read_to_string(format!("../../fixtures/{file}")).unwrap();
    let (hierarchy, motion) = text.split_once("MOTION").unwrap();
    let rows = motion
        .lines()
        .skip_while(|line| !line.starts_with("Frame Time"))
        .skip(1);
    let rows: Vec<Vec<f64>> = rows
        .map(|row| row.split_whitespace().map(|word| word.parse().unwrap()).collect())
        .filter(|row: &Vec<f64>| !row.is_empty())
        .collect();
    let (mut joint, mut column) = ("", 0);
    let mut is_still = BTreeMap::new();
    for line in hierarchy.lines() {
        match line.split_whitespace().collect::<Vec<_>>().as_slice() {
            ["ROOT" | "JOINT", name, ..] => joint = *name,
            ["CHANNELS", _, channels @ ..] => {
                for channel in channels {
                    let is_same = rows.iter().all(|row| row[column] == rows[0][column]);
                    let still = is_still.entry(joint.to_owned()).or_insert(true);
                    *still &= is_same || channel.ends_with("position");
                    column += 1;
                }
            }
            _ => {}
        }
    }
    assert!(rows.len() > 1 && rows.iter().all(|row| row.len() >= column), "{file}");
    let still = is_still.into_iter().filter(|(_, is_still)| *is_still);
    still.map(|(joint, _)| joint).collect()
}
