//! Tests texts of numbers that are packed to take less memory.

use std::fs;

use mocap_scene::files::{FilePart, OutputSet, ReplacePolicy};

#[test]
fn a_packed_text_of_numbers_has_its_bytes() {
    for text in ["", "7", "-0.25 3\n", "1234567890-. \n", "12 -3.5\n6 7.25", "0.1\n2"] {
        let part = FilePart::numbers(text.as_bytes());
        assert_eq!((&*part.bytes(), part.len()), (text.as_bytes(), text.len()));
        assert_eq!(part.is_empty(), text.is_empty());
        assert_eq!(part.borrowed().bytes(), part.bytes());
        assert_eq!(part.into_bytes(), text.as_bytes());
    }
}

#[test]
fn a_text_with_other_characters_is_kept() {
    for byte in 0..=255_u8 {
        for text in [vec![byte], vec![b'1', byte], vec![byte, b'1'], vec![b'1', b'2', byte]] {
            assert_eq!(FilePart::numbers(&text).bytes(), text);
        }
    }
}

#[test]
fn an_output_may_consist_of_both() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bvh");
    let (head, rows) = (FilePart::from(&b"MOTION\n"[..]), FilePart::numbers(b"1 -2.5\n"));
    let mut set = OutputSet::new();
    set.add(&path, [head, rows]);
    set.save(&ReplacePolicy::default()).unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"MOTION\n1 -2.5\n");
}
