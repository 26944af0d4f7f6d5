//! The scene and the bytes do not depend on the number of reading threads.

use std::fmt::Write;
use std::fs;

use crate::sample::Sample;
use mocap::gltf::GltfOptions;
use mocap::{Importer, Scene};

/// The reader uses several threads from 2 MiB on (`WORTHWHILE`).
const LONG: usize = 2_500_000;

/// Repeats the rows of a real capture until the reader uses several threads, with other numbers in each repetition.
/// `change` can edit each row.
fn long_take(change: impl Fn(usize, &str) -> String) -> String {
    let text = fs::read_to_string("../../fixtures/real/cmu_short.bvh").unwrap();
    let (hierarchy, motion) = text.split_once("MOTION").unwrap();
    let rows: Vec<&str> = motion.lines().skip(3).filter(|row| !row.trim().is_empty()).collect();
    let frames = LONG / rows[0].len();
    let mut take = format!("{hierarchy}MOTION\nFrames: {frames}\nFrame Time: 0.01\n");
    for frame in 0..frames {
        let row = rows[frame % rows.len()].replacen('.', &format!(".{frame}"), 1);
        writeln!(take, "{}", change(frame, &row)).unwrap();
    }
    take
}

fn read(text: &str, threads: usize) -> Scene {
    Importer::new()
        .threads(threads)
        .read(text.as_bytes(), "take.bvh")
        .unwrap()
}

/// Reads with one thread, with 2 or 7 threads from memory, and with 1 or 7 threads from a file. Checks that all scenes
/// are equal, and returns the scene.
fn read_alike(text: &str) -> Scene {
    let expected = read(text, 1);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("take.bvh");
    fs::write(&path, text).unwrap();
    let mut random = Sample::new();
    for threads in random.some([2, 7], 2) {
        let scene = read(text, threads);
        assert!(scene == expected, "{threads} threads give another scene");
    }
    for threads in random.some([1, 7], 2) {
        let scene = Importer::new().threads(threads).import(&path).unwrap();
        assert!(scene == expected, "{threads} threads give another scene of a file");
    }
    expected
}

#[test]
fn plain_rows() {
    let text = long_take(|_, row| row.to_owned());
    let scene = read_alike(&text);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    // Equal scenes may differ in the sign of a zero, so also compare files.
    let glb = |scene: &Scene| GltfOptions::default().write_glb(scene).unwrap();
    assert!(glb(&read(&text, 7)) == glb(&scene));
    let frames = text.lines().count() - text.lines().position(|line| line.starts_with("Frame Time")).unwrap() - 1;
    assert_eq!(scene.animations[0].frame_count(), frames);
    // Every row has a different first number, so that the test detects lost and misplaced rows.
    for (frame, row) in text
        .lines()
        .skip_while(|line| !line.starts_with("Frame Time"))
        .skip(1)
        .enumerate()
    {
        let x: f32 = row.split_whitespace().next().unwrap().parse().unwrap();
        assert_eq!(scene.animations[0].channels[0].position_keys.values[frame].x, x);
    }
}

#[test]
fn a_row_that_is_not_plain_in_the_middle() {
    // A value that is not finite takes the value of the previous row, which another thread has read.
    let scene = read_alike(&long_take(|frame, row| match frame {
        2_500 => row.replacen(row.split_whitespace().next().unwrap(), "nan", 1),
        _ => row.to_owned(),
    }));
    assert_eq!(scene.warnings.len(), 1);
    let positions = &scene.animations[0].channels[0].position_keys.values;
    assert_eq!(positions[2_500].x, positions[2_499].x);
    assert_ne!(positions[2_501].x, positions[2_500].x);
}

#[test]
fn fewer_frames_declared_than_there_are() {
    let text = long_take(|_, row| row.to_owned());
    let declared = text
        .lines()
        .find(|line| line.starts_with("Frames:"))
        .unwrap()
        .to_owned();
    let scene = read_alike(&text.replacen(&declared, "Frames: 3001", 1));
    assert_eq!(scene.animations[0].frame_count(), 3001);
    assert_eq!(scene.warnings.len(), 1);
}

#[test]
fn lines_that_are_no_rows_and_other_line_ends() {
    let text = long_take(|_, row| row.to_owned());
    // A different text has a different SHA-256, but the motion is equal.
    let expected = read(&text, 1).animations;
    let frames = expected[0].frame_count();
    for line_end in Sample::new().some(["\r", "\r\n"], 2) {
        assert!(
            read_alike(&text.replace('\n', line_end)).animations == expected,
            "{line_end:?}"
        );
    }
    // The reader counts lines to locate rows. An empty line must not shift the following rows.
    let with_gaps = long_take(|frame, row| match frame {
        1_500 | 2_500 => format!("\n{row}\n \t"),
        _ => row.to_owned(),
    });
    assert!(read_alike(&(with_gaps + "\n\n \n")).animations == expected);
    let claim = format!("Frames: {frames}");
    let scene = read_alike(&text.replacen(&claim, "Frames: 1000000", 1));
    assert!(scene.animations == expected);
    assert_eq!(scene.warnings.len(), 1);
}
