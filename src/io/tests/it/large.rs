//! Large files, which the reader reads block by block.

use std::fmt::Write;
use std::fs::{self, File};
use std::path::Path;

use mocap::scene::Scene;
use mocap::{Code, Diagnostic, Importer};
use mocap_formats::Source;
use mocap_io::internals::{BEGINNING, BLOCK, LargeFile};
use sha2::{Digest, Sha256};

/// A text that is larger than the beginning of a file, which the reader reads first. `row` gives the text of a row by
/// its index.
fn take(row: impl Fn(usize) -> String) -> String {
    const ROWS: usize = 120_000;
    let mut text = String::from("HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n}\nMOTION\n");
    write!(text, "Frames: {ROWS}\nFrame Time: 0.1\n").unwrap();
    (0..ROWS).for_each(|index| text += &row(index));
    assert!(text.len() as u64 > BEGINNING + 2 * BLOCK);
    text
}

fn plain(index: usize) -> String {
    format!("{}.0000000000\n", index % 360)
}

/// Reads a file of `text`. Calls `change` on the file after its beginning was read.
fn read(text: &str, change: impl Fn(&Path)) -> (mocap::Result<Scene>, LargeFile) {
    let file = tempfile::NamedTempFile::with_suffix(".bvh").unwrap();
    fs::write(file.path(), text).unwrap();
    let large = LargeFile::new(File::open(file.path()).unwrap(), text.len() as u64).unwrap();
    change(file.path());
    (import(&large, 1), large)
}

fn import(large: &LargeFile, threads: usize) -> mocap::Result<Scene> {
    let source = Source {
        bytes: large.beginning(),
        blocks: None,
        name: Path::new("take.bvh"),
        release: &|_| {},
        open: &|_| Err(Diagnostic::new(Code::MissingFile, "there is no other file").into()),
        list: &|_| Vec::new(),
    };
    Importer::new().threads(threads).read_large(large, &source)
}

/// For each dialect, with block ends at different places.
#[test]
fn every_fixture_is_read_as_from_memory() {
    const LARGEST: usize = 60_000;
    let (mut streamed, mut whole) = (0, 0);
    for folder in ["dialects", "broken", "real"] {
        for entry in fs::read_dir(Path::new("../../fixtures").join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|extension| extension != "bvh") {
                continue;
            }
            let mut bytes = fs::read(&path).unwrap();
            // Truncate longer texts, some in the middle of a row.
            if bytes.len() > LARGEST {
                let is_cut_in_a_row = bytes.len() % 3 == 0;
                bytes.truncate(LARGEST);
                if !is_cut_in_a_row {
                    bytes.truncate(1 + memchr::memrchr(b'\n', &bytes).unwrap_or(LARGEST));
                }
            }
            let expected = Importer::new().threads(1).read(&bytes, "take.bvh");
            let copy = tempfile::NamedTempFile::new().unwrap();
            fs::write(copy.path(), &bytes).unwrap();
            for (beginning, block, threads) in [(1 << 20, 1 << 18, 2), (20_000, 1009, 1), (9_000, 300, 3)] {
                let file = File::open(copy.path()).unwrap();
                let large = LargeFile::with_lengths(file, bytes.len() as u64, beginning, block).unwrap();
                match (import(&large, threads), &expected) {
                    (Ok(found), Ok(expected)) => assert!(found == *expected, "{path:?} {block}"),
                    (Err(found), Err(expected)) => assert_eq!(found.to_string(), expected.to_string(), "{path:?}"),
                    (found, _) => panic!("{path:?}: {:?}", found.map(|scene| scene.warnings)),
                }
                match large.whole.get() {
                    Some(_) => whole += 1,
                    None => streamed += 1,
                }
            }
        }
    }
    assert!(streamed > 20 && whole > 20, "{streamed} {whole}");
}

#[test]
fn plain_rows_are_not_held_in_memory() {
    let text = take(plain);
    let (scene, file) = read(&text, |_| {});
    assert!(file.whole.get().is_none());
    let scene = scene.unwrap();
    assert!(scene == Importer::new().read(text.as_bytes(), "take.bvh").unwrap());
    assert_eq!(
        scene.metadata.origin.unwrap().sha256,
        format!("{:x}", Sha256::digest(&text))
    );
}

#[test]
fn another_row_is_read_from_the_whole_text() {
    let text = take(|index| match index {
        110_000 => "nan\n".to_owned(),
        _ => plain(index),
    });
    let (scene, file) = read(&text, |_| {});
    assert!(file.whole.get().is_some());
    assert!(scene.unwrap() == Importer::new().read(text.as_bytes(), "take.bvh").unwrap());
}

#[test]
fn a_file_that_changes_is_an_error_or_the_rows_that_are_left() {
    let text = take(plain);
    let shortened = read(&text, |path| {
        let open = File::options().write(true).open(path).unwrap();
        open.set_len(BEGINNING + BLOCK).unwrap();
    });
    let error = read(&text, |path| fs::write(path, text.replace("7.0", "x.0")).unwrap());
    let grown = read(&text, |path| fs::write(path, text.clone() + "1\n").unwrap());
    let scene = shortened.0.unwrap();
    assert_eq!(scene.warnings[0].code, Code::MissingFrames);
    assert!(scene.animations[0].frame_count() > 50_000);
    for (result, message) in [
        (error.0, "the file changed while it was read"),
        (grown.0, "the file grew while it was read"),
    ] {
        let error = result.unwrap_err();
        assert_eq!((error.code(), error.diagnostic().message.as_str()), (Code::Io, message));
        assert!(std::error::Error::source(&error).is_some());
    }
}
