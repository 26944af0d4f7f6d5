//! Facts about skeletons from the clips of a folder: the up axis, if clips agree, and the units.

use std::collections::{BTreeMap, BTreeSet};

use mocap::Scene;
use mocap::scene::{Assumption, Confidence, Topic, UpAxis};

use crate::batch::hash::sha256_of;
use crate::batch::manifest::Record;

pub(super) fn is_doubtful_up(guess: &Assumption) -> bool {
    guess.topic == Topic::Up && guess.confidence != Some(Confidence::Sure)
}

/// The up axis of an output, if the motion alone does not determine the axis with certainty.
pub(super) fn doubtful_up(record: &Record) -> Option<&Assumption> {
    record.guesses.iter().rfind(|guess| is_doubtful_up(guess))
}

/// The up axis of a clip in which the figure lies or hangs, determined by other clips.
pub(super) fn told_by_others(up: UpAxis) -> Assumption {
    Assumption {
        topic: Topic::Up,
        choice: up.as_str().to_owned(),
        reason: "other clips of the same skeleton stand along this axis".to_owned(),
        confidence: Some(Confidence::Likely),
    }
}

/// A hash of the names and parents of all nodes, and of the rest positions below the root.
pub(super) fn skeleton_hash(scene: &Scene) -> String {
    let mut bytes = Vec::new();
    for node in &scene.nodes {
        bytes.extend(node.name.as_bytes());
        bytes.push(0);
        let parent = node.parent.map_or(u64::MAX, |parent| parent.index() as u64);
        bytes.extend(parent.to_le_bytes());
        if node.parent.is_some() {
            let matrix = node.transform.to_cols_array();
            bytes.extend(matrix.iter().flat_map(|value| value.to_le_bytes()));
        }
    }
    sha256_of(&bytes)
}

/// The evidence of clips about their skeletons.
#[derive(Default)]
pub(super) struct Clips {
    /// For each skeleton, the up axes of clips in which the axis is certain.
    up: BTreeMap<String, BTreeSet<String>>,
    /// The number of files in each unit.
    units: BTreeMap<String, usize>,
}

impl Clips {
    pub(super) fn of(records: &[&Record]) -> Self {
        let mut clips = Self::default();
        records.iter().for_each(|record| clips.add(record));
        clips
    }

    fn add(&mut self, record: &Record) {
        for guess in &record.guesses {
            if guess.topic == Topic::Unit {
                *self.units.entry(guess.choice.clone()).or_default() += 1;
            }
            if let (Topic::Up, Some(Confidence::Sure), Some(skeleton)) =
                (guess.topic, guess.confidence, &record.skeleton)
            {
                self.up
                    .entry(skeleton.clone())
                    .or_default()
                    .insert(guess.choice.clone());
            }
        }
    }

    /// The skeletons whose clips all have one up axis.
    pub(super) fn axes(&self) -> BTreeMap<String, UpAxis> {
        let one = |(skeleton, axes): (&String, &BTreeSet<String>)| {
            let named = |up: &UpAxis| axes.len() == 1 && axes.contains(up.as_str());
            let up = UpAxis::ALL.into_iter().find(named)?;
            Some((skeleton.clone(), up))
        };
        self.up.iter().filter_map(one).collect()
    }

    /// A line about the units of the files, such as `unit: cm in 12 files, inch in 1 file`. `None` if the outputs keep
    /// the units, and all units are equal.
    pub(super) fn units(&self, are_kept: bool) -> Option<String> {
        let unit = |(unit, files): (&String, &usize)| {
            let noun = if *files == 1 { "file" } else { "files" };
            format!("{unit} in {files} {noun}")
        };
        let units = self.units.iter().map(unit).collect::<Vec<_>>().join(", ");
        match (are_kept, self.units.len()) {
            (true, 2..) => Some(format!(
                "warning: positions keep the unit of each file: {units}; --out-unit m writes all positions in metres"
            )),
            (true, _) | (false, 0) => None,
            (false, _) => Some(format!("unit: {units}")),
        }
    }
}
