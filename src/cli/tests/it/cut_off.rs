//! Files that are cut off. `check` fails for each. Readers of row-based formats return all complete frames.

use crate::program::{Folder, words};

/// The files, whether their format is row-based, and the command that makes them from `walk.bvh`; empty for fixtures.
const FILES: &[(&str, bool, &str)] = &[
    ("walk.bvh", true, ""),
    ("cmu_01_01.amc", true, ""),
    ("hand_take.c3d", true, ""),
    ("walk.trc", true, "convert walk.bvh walk.trc"),
    ("walk.csv", true, "fk walk.bvh -o walk.csv"),
    ("walk.mot", true, "angles walk.bvh -o walk.mot"),
    ("walk.npz", false, "fk walk.bvh -o walk.npz"),
    ("walk.glb", false, "convert walk.bvh walk.glb"),
    ("walk.vrma", false, "convert walk.bvh walk.vrma"),
    #[cfg(feature = "fbx")]
    ("walk.fbx", false, "convert walk.bvh walk.fbx"),
    ("walk.usda", false, "convert walk.bvh walk.usda"),
    ("walk.usdz", false, "convert walk.bvh walk.usdz"),
    ("walk.mclip", false, "convert walk.bvh walk.mclip"),
    ("walk.vmd", false, "convert walk.bvh walk.vmd"),
    #[cfg(feature = "parquet")]
    ("walk.parquet", false, "fk walk.bvh -o walk.parquet"),
];

#[test]
fn check_fails_for_a_file_that_is_cut_off_and_convert_keeps_its_whole_frames() {
    let folder = Folder::of_real(&["cmu_short.bvh", "cmu_01.asf", "cmu_01_01.amc", "hand_take.c3d"]);
    folder.write("walk.bvh", &folder.read("cmu_short.bvh"));
    for (name, has_rows, made_by) in FILES {
        if !made_by.is_empty() {
            folder.succeeds(made_by);
        }
        folder.succeeds(&format!("check {name}"));
        let whole = folder.read(name);
        for percent in [60, 75, 90] {
            let what = format!("{name} cut at {percent} %");
            folder.write(name, &whole[..whole.len() * percent / 100]);
            let output = folder.run(&format!("check {name}"));
            let said = words(&output) + &String::from_utf8_lossy(&output.stdout);
            assert_eq!(output.status.code(), Some(1), "{what}: {said}");
            assert!(said.contains("1 error") || said.contains("2 errors"), "{what}: {said}");
            let output = folder.run(&format!("convert {name} out.trc --force"));
            let said = words(&output);
            assert_eq!(output.status.code(), Some(i32::from(!has_rows)), "{what}: {said}");
            if *has_rows {
                let is_told = said.contains("frames are missing") || said.contains("which was dropped");
                assert!(is_told && said.contains("warning["), "{what}: {said}");
            }
        }
        folder.write(name, &whole);
    }
}

/// A frame is complete or absent: a truncated number is not a position.
#[test]
fn a_number_that_is_cut_in_two_is_not_read() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    folder.succeeds("convert cmu_short.bvh walk.trc");
    let text = String::from_utf8(folder.read("walk.trc")).unwrap();
    // The row of frame 5 without its last two digits.
    let lines: Vec<&str> = text.lines().collect();
    let (rows, row) = (lines[..10].join("\n"), lines[10]);
    folder.write("walk.trc", format!("{rows}\n{}", &row[..row.len() - 2]).as_bytes());
    let output = folder.run("convert walk.trc again.trc --strict");
    assert_eq!(output.status.code(), Some(1), "{}", words(&output));
    let output = folder.run("convert walk.trc again.trc");
    assert!(output.status.success(), "{}", words(&output));
    let again = String::from_utf8(folder.read("again.trc")).unwrap();
    let stated = again.lines().nth(2).unwrap().split('\t').nth(2);
    assert_eq!(stated, Some("4"), "{again}");
    assert_eq!(
        again.lines().last().map(|line| line.split('\t').next()),
        Some(Some("4"))
    );
}

/// Additional rows are not a loss of declared frames.
#[test]
fn check_warns_of_frames_beyond_the_number_of_the_file() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    let text = String::from_utf8(folder.read("cmu_short.bvh")).unwrap();
    let last = text.trim_end().lines().last().unwrap();
    folder.write("longer.bvh", format!("{}\n{last}\n", text.trim_end()).as_bytes());
    let output = folder.run("check longer.bvh");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success() && said.contains("warning[frame-count]"),
        "{said}"
    );
}
