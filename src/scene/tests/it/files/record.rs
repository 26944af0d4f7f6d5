//! The record of outputs: which entries it trusts, and its size.

use std::fs;
use std::io::{self, Read};
use std::path::Path;

use mocap_scene::internals::{RecordState, UserRecord};

fn record(folder: &Path) -> UserRecord {
    UserRecord::new(folder.join("mocap"), hash)
}

/// The bytes themselves, because no test here depends on the hash.
fn hash(contents: &mut dyn Read) -> io::Result<(u64, String)> {
    let mut text = String::new();
    contents.read_to_string(&mut text)?;
    Ok((text.len() as u64, text))
}

fn note(record: &UserRecord, path: &Path, bytes: &[u8]) {
    record.note(path, &mut &*bytes, &["walk.bvh"]);
}

fn unchanged() -> RecordState {
    RecordState::Unchanged(vec!["walk.bvh".to_owned()])
}

#[test]
fn a_file_is_known_by_its_path_and_its_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let (one, other) = (record(folder.path()), record(folder.path()));
    let path = folder.path().join("out.bvh");
    fs::write(&path, "motion").unwrap();
    assert_eq!(one.find(&path), RecordState::Unknown);
    note(&one, &path, b"motion");
    // A process that has read the record earlier sees the new entries.
    for record in [&one, &other] {
        assert_eq!(record.find(&path), unchanged());
    }
    fs::write(&path, "MOTION").unwrap();
    assert_eq!(other.find(&path), RecordState::Changed { is_shorter: false });
    fs::write(&path, "mot").unwrap();
    assert_eq!(one.find(&path), RecordState::Changed { is_shorter: true });
    note(&other, &path, b"mot");
    assert_eq!(one.find(&path), unchanged());
    let copy = folder.path().join("copy.bvh");
    fs::copy(&path, &copy).unwrap();
    assert_eq!(one.find(&copy), RecordState::Unknown);
}

/// The process records an output before the output gets its name.
#[test]
fn a_process_that_is_killed_leaves_the_former_output_known() {
    let folder = tempfile::tempdir().unwrap();
    let record = record(folder.path());
    let path = folder.path().join("out.bvh");
    fs::write(&path, "motion").unwrap();
    note(&record, &path, b"motion");
    note(&record, &path, b"killed");
    note(&record, &path, b"again");
    assert_eq!(record.find(&path), unchanged());
    fs::write(&path, "edited").unwrap();
    assert_eq!(record.find(&path), RecordState::Changed { is_shorter: false });
}

#[test]
fn a_line_that_was_cut_off_spoils_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.bvh");
    fs::write(&path, "motion").unwrap();
    note(&record(folder.path()), &path, b"motion");
    let file = folder.path().join("mocap/outputs.jsonl");
    let whole = fs::read(&file).unwrap();
    for cut in 1..whole.len() {
        fs::write(&file, &whole[..cut]).unwrap();
        let next = record(folder.path());
        note(&next, &path, b"motion");
        assert_eq!(next.find(&path), unchanged(), "{cut}");
    }
}

/// If a user makes the same outputs repeatedly, the record has one line for each. Many outputs remove the oldest lines.
#[test]
fn the_record_stays_small_and_forgets_the_oldest() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.bvh");
    fs::write(&path, "motion").unwrap();
    note(&record(folder.path()), &path, b"motion");
    let file = folder.path().join("mocap/outputs.jsonl");
    let size = || -> u64 {
        let entries = fs::read_dir(folder.path().join("mocap")).unwrap().flatten();
        entries.map(|entry| entry.metadata().unwrap().len()).sum()
    };
    let line = |name: usize| format!(r#"{{"path":"/{name}","bytes":0,"sha256":"","from":[]}}"#) + "\n";
    let first = fs::read_to_string(&file).unwrap();
    // The record lists one file 300,000 times.
    fs::write(&file, first.clone() + &line(0).repeat(300_000)).unwrap();
    let next = record(folder.path());
    note(&next, Path::new("/new"), b"");
    assert_eq!(next.find(&path), unchanged());
    assert!(size() < 1 << 10, "{}", size());
    // The record gets the lines of many files.
    for _ in 0..3 {
        let many: String = (0..300_000).map(line).collect();
        fs::write(&file, many).unwrap();
        note(&record(folder.path()), Path::new("/new"), b"");
        assert!(size() < 9 << 20, "{}", size());
    }
    assert_eq!(record(folder.path()).find(&path), RecordState::Unknown);
    assert_eq!(fs::read_dir(folder.path().join("mocap")).unwrap().count(), 2);
}
