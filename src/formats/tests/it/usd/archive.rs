//! Tests the archives of USD (`.usdz`).

use mocap_formats::internals::usd::{ALIGNMENT, stage, write};
use mocap_formats::usd::is_archive;

#[test]
fn files_begin_at_multiples_of_64_bytes_and_a_broken_archive_is_refused() {
    let files = [
        ("a.usda".to_owned(), &b"#usda 1.0\n"[..]),
        ("textures/b.png".to_owned(), &b"image"[..]),
    ];
    let archive = write(&files).unwrap();
    assert!(is_archive(&archive));
    assert_eq!(stage(&archive).unwrap(), files[0].1);
    for (_, bytes) in &files {
        let at = archive
            .windows(bytes.len())
            .position(|window| window == *bytes)
            .unwrap();
        assert_eq!(at % ALIGNMENT, 0);
    }
    for length in 0..archive.len() {
        assert!(stage(&archive[..length]).is_err(), "{length}");
    }
    let mut flipped = archive.clone();
    flipped[64] ^= 1;
    assert!(stage(&flipped).is_err());
}
