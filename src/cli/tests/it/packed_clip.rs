//! `convert` to packed clips.

use mocap::Conversion;
use mocap::compress::PackedClip;

#[test]
fn convert_writes_packed_clips() {
    use std::fs;

    use crate::program::Folder;

    let folder = Folder::with(&["w.bvh", "in/w.bvh"]);
    folder.succeeds("convert w.bvh w.mclip --max-error 0.1mm");
    folder.succeeds("convert w.bvh again.mclip --max-error 0.1mm");
    let bytes = folder.read("w.mclip");
    assert_eq!(bytes, folder.read("again.mclip"));
    let mut scene = mocap::import(folder.path("w.bvh")).unwrap();
    Conversion::new().apply(&mut scene).unwrap();
    let clip = PackedClip::new(bytes.as_slice()).unwrap();
    assert_eq!(clip.bytes(), PackedClip::encode(&scene, 0, 0.0001).unwrap().bytes());
    // A packed clip of another origin may be a source.
    fs::copy(folder.path("w.mclip"), folder.path("copy.mclip")).unwrap();
    folder.refuses("convert w.bvh copy.mclip --max-error 9mm", 1, "output-exists");
    folder.succeeds("verify w.bvh w.mclip --max-error 0.1mm");
    folder.refuses("verify w.bvh w.mclip --max-error 0.001mm", 1, "");
    folder.succeeds("convert w.bvh checked.mclip --verify");
    folder.succeeds("convert in -o out --to mclip");
    assert!(PackedClip::new(fs::read(folder.path("out/w.mclip")).unwrap()).is_ok());
    for option in ["--mesh none", "--compress int16", "--digits 3", "--out-unit cm"] {
        folder.refuses(&format!("convert w.bvh w.mclip {option}"), 2, "error");
    }
}
