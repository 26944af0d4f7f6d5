//! `mocap survey --split`: no group is in two parts, and new clips do not move others.

use std::collections::BTreeMap;

use mocap::survey::report::ClipRecord;
use mocap::survey::{Corpus, SelectBy, Thresholds};

use crate::program::Folder;

/// Clips without motion, with persons, files and near-duplicates.
fn corpus(clips: &[(&str, &str, Option<u64>)]) -> Corpus {
    let clips = clips.iter().map(|(file, person, twins)| {
        let line = serde_json::json!({"file": file, "clip": "0", "verdict": "good", "quality": 1.0, "reasons": "",
            "sha256": file, "format": "bvh", "person": person, "skeleton": file, "fingerprint": "b"});
        let mut record = ClipRecord::from_lines(&line.to_string()).unwrap().remove(0);
        record.row.twin_group = *twins;
        record
    });
    Corpus::new(clips.collect(), &Thresholds::default())
}

fn parts(corpus: &Corpus) -> BTreeMap<String, String> {
    let part = |row: &mocap::survey::report::ClipRow| (row.file.clone(), row.split.clone().unwrap());
    corpus.rows().map(part).collect()
}

#[test]
fn a_split_keeps_persons_together_and_new_clips_move_none() {
    let names: Vec<(String, String)> = (0..400)
        .map(|clip| (format!("{clip}"), format!("{}", clip % 80)))
        .collect();
    let clips: Vec<_> = names
        .iter()
        .map(|(file, person)| (file.as_str(), person.as_str(), None))
        .collect();
    let split = |clips: &[(&str, &str, Option<u64>)]| {
        let mut corpus = corpus(clips);
        corpus.split(&[0.8, 0.1, 0.1], &[SelectBy::Person]).unwrap();
        parts(&corpus)
    };
    let all = split(&clips);
    for (file, person) in &names {
        assert_eq!(all[file], all[person], "the clips of person {person} are in two parts");
    }
    let count = |part: &str| all.values().filter(|found| *found == part).count();
    assert_eq!(count("train") + count("validation") + count("test"), 400);
    assert!((280..=360).contains(&count("train")), "{}", count("train"));
    let some = split(&clips[..211]);
    assert!(some.iter().all(|(file, part)| all[file] == *part));
}

#[test]
fn a_split_that_cannot_be_made_is_an_error() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    for (options, expected) in [
        ("--split 0.8,0.3", "whose sum is 1"),
        ("--split 1", "0.8,0.1,0.1"),
        ("--split=-1,2", "above 0"),
        ("--split 0.5,0.5 --by person", "mocap.toml"),
        ("--by skeleton", "--split"),
        ("--split 0.5,0.5 --by quality", "--select"),
    ] {
        let said = folder.ends_with(2, &format!("survey . {options}"));
        assert!(said.contains(expected), "{options}: {said}");
    }
}
