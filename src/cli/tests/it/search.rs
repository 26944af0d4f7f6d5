//! `mocap index`, `mocap find` and `mocap match`.

use mocap::matching::Database;

use crate::program::Folder;

const WALK: &str = "cmu_12_01_walk.bvh";

#[test]
fn the_commands_index_and_find() {
    let folder = Folder::of_real(&[WALK, "cmu_short.bvh", "lecture_Test.bvh"]);
    folder.ends_with(3, "index . -o moves.mdb");
    let first = folder.read("moves.mdb");
    // The same files give the same bytes, and an unchanged file is not read again.
    folder.ends_with(3, "index . -o moves.mdb --resume");
    assert_eq!(folder.read("moves.mdb"), first);
    folder.succeeds(&format!("index {WALK} -o walk.mdb"));
    folder.succeeds("index cmu_short.bvh -o short.mdb");
    folder.succeeds("index walk.mdb short.mdb -o both.mdb");
    let both = Database::read(&folder.read("both.mdb")[..]).unwrap();
    assert_eq!(both.clips().len(), 2);
    let output = folder.run(&format!("find moves.mdb --like {WALK}@1.0s..2.0s --json -n 3"));
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(found[0]["distance"].as_f64().unwrap() < 0.02, "{found}");
    assert_eq!(found[0]["mirrored"], false);
    assert!(found.as_array().unwrap().len() <= 3);
    let output = folder.run(&format!("find moves.mdb --like {WALK}@1.0s..1.5s --json"));
    let once: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let files: Vec<&str> = once
        .as_array()
        .unwrap()
        .iter()
        .map(|part| part["file"].as_str().unwrap())
        .collect();
    assert!(
        files.len() == 2 && files[0].ends_with(WALK) && files[1] != files[0],
        "{files:?}"
    );
    folder.refuses(&format!("find moves.mdb --like {WALK} --per-clip 0"), 2, "per-clip");
    let table = folder.run(&format!("find moves.mdb --pose {WALK}@1s --where seconds>3 -n 2"));
    let table = String::from_utf8(table.stdout).unwrap();
    assert!(table.starts_with("distance  second") && table.contains(WALK), "{table}");
    // A database of another program is kept.
    folder.write("theirs.mdb", b"\0\x01\0\0Standard Jet DB\0 and the tables of an office");
    folder.refuses(&format!("index {WALK} -o theirs.mdb"), 1, "--force");
    folder.succeeds(&format!("index {WALK} -o theirs.mdb --force"));
    folder.refuses("find cmu_short.bvh --pose cmu_short.bvh@0", 1, "mocapMDB");
    folder.refuses(&format!("find moves.mdb --like {WALK}@1m..2m"), 2, "A..B");
    folder.refuses("find moves.mdb", 2, "--like");
    let markers = "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tNumFrames\tNumMarkers\tUnits\n60\t2\t1\tm\n\
        Frame#\tTime\tA\n\t\tX1\tY1\tZ1\n1\t0\t0\t1\t0\n2\t0.0167\t0\t1\t0\n";
    folder.write("markers.trc", markers.as_bytes());
    for command in ["find moves.mdb --like markers.trc", "gait markers.trc"] {
        folder.refuses(command, 1, "solve a skeleton from the markers: --markers auto");
    }
    folder.refuses("index moves.mdb -o moves.mdb", 1, "input");
    folder.refuses(&format!("index {WALK} -o moves.xyz"), 2, ".mdb");
    folder.refuses(&format!("index {WALK} -o moves.mdb --resume --where x"), 2, "--where");
}

#[test]
fn the_command_matches() {
    let folder = Folder::of_real(&[WALK, "biovision_example1.bvh"]);
    folder.succeeds(&format!("index {WALK} -o moves.mdb --mirror"));
    folder.succeeds("match moves.mdb --path 0/0+0/2 --on biovision_example1.bvh -o out.glb");
    let scene = mocap::import(folder.path("out.glb")).unwrap();
    assert_eq!(scene.animations.len(), 1);
    let said = folder.run("match moves.mdb --path 0/0+0/1 --on biovision_example1.bvh -o out.bvh --json -q");
    let followed: serde_json::Value = serde_json::from_slice(&said.stdout).unwrap();
    assert_eq!(followed["has_arrived"], true);
    folder.refuses(
        "match moves.mdb --path 0/0 --on biovision_example1.bvh -o out.glb",
        2,
        "X/Z",
    );
    folder.refuses("match moves.mdb --path 0/0+0/2 --on none.bvh -o out.glb", 1, "none.bvh");
    folder.refuses(
        "match moves.mdb --path 0/0+0/2 --on biovision_example1.bvh -o biovision_example1.bvh",
        1,
        "input",
    );
    // The clips named by the database are also inputs.
    folder.refuses(
        &format!("match moves.mdb --path 0/0+0/2 --on biovision_example1.bvh -o {WALK} --force"),
        1,
        "input",
    );
    let text = String::from_utf8(folder.read(WALK)).unwrap();
    folder.write(WALK, text.replace(".0083333", ".0083").as_bytes());
    folder.refuses(
        "match moves.mdb --path 0/0+0/2 --on biovision_example1.bvh -o out.glb",
        1,
        "changed since it was indexed",
    );
}

#[test]
fn the_command_takes_a_gamepad_and_packed_motions() {
    let folder = Folder::of_real(&[WALK, "biovision_example1.bvh"]);
    folder.succeeds(&format!("index {WALK} -o moves.mdb --mirror --pack"));
    let first = folder.read("moves.mdb");
    folder.succeeds(&format!("index {WALK} -o moves.mdb --mirror --pack --resume"));
    assert_eq!(folder.read("moves.mdb"), first);
    folder.succeeds(&format!("index {WALK} -o moves.mdb --mirror --resume"));
    assert!(folder.read("moves.mdb").len() < first.len());
    folder.write("moves.mdb", &first);
    folder.write("sticks.csv", b"seconds,left_x,left_y\n0,0,1\n1,1,0\n2,0,0\n");
    let line = "match moves.mdb --gamepad sticks.csv --on biovision_example1.bvh";
    // The database includes the motion.
    std::fs::remove_file(folder.path(WALK)).unwrap();
    let said = folder.run(&format!("{line} -o out.bvh --json -q"));
    let played: serde_json::Value = serde_json::from_slice(&said.stdout).unwrap();
    assert_eq!(played["frames"], 121);
    assert_eq!(
        mocap::import(folder.path("out.bvh")).unwrap().animations[0].frame_count(),
        121
    );
    folder.refuses(&format!("{line} --path 0/0+0/1 -o new.bvh"), 2, "--path");
    folder.refuses(&format!("{line} -o sticks.csv --force"), 2, "sticks.csv");
    folder.refuses("match moves.mdb --on biovision_example1.bvh -o new.bvh", 2, "--gamepad");
    folder.write("sticks.csv", b"seconds,left_x\n0,1\n");
    folder.refuses(&format!("{line} -o new.bvh"), 1, "sticks.csv");
    folder.write("sticks.csv", b"\xff\xfe\x00\x01");
    folder.refuses(&format!("{line} -o new.bvh"), 1, "UTF-8");
}

#[test]
fn what_is_found_is_drawn() {
    let folder = Folder::of_real(&[WALK, "cmu_short.bvh"]);
    folder.ends_with(0, "index . -o moves.mdb");
    let line = format!("find moves.mdb --like {WALK}@1.0s..2.0s -n 2");
    folder.succeeds(&format!("{line} --sheet found.svg --page found.html"));
    let sheet = String::from_utf8(folder.read("found.svg")).unwrap();
    // A long name is shortened on the sheet.
    let row = "1: cmu_12";
    assert!(sheet.contains("looked for: ") && sheet.contains(row), "{row}");
    let page = String::from_utf8(folder.read("found.html")).unwrap();
    assert!(page.contains("1: cmu_12_01_walk, 1.0"));
    folder.succeeds(&format!("find moves.mdb --pose {WALK}@1s -n 1 --sheet found.png"));
    folder.refuses(&format!("{line} --sheet found.bvh"), 2, ".png");
    folder.refuses(&format!("{line} --page found.png"), 2, ".html");
    // A motion in the database needs no file.
    folder.ends_with(0, "index . -o packed.mdb --pack");
    std::fs::remove_file(folder.path("cmu_short.bvh")).unwrap();
    folder.refuses(
        "find moves.mdb --pose cmu_12_01_walk.bvh@1s --sheet all.svg -n 20",
        1,
        "cmu_short.bvh",
    );
    folder.succeeds("find packed.mdb --pose cmu_12_01_walk.bvh@1s --sheet all.svg -n 20");
}

/// The counts of both files; `tools/matching` compares their numbers.
#[test]
fn the_files_of_holdens_demonstration_are_written() {
    let folder = Folder::of_real(&[WALK, "biovision_example1.bvh"]);
    folder.succeeds(&format!("index {WALK} -o moves.mdb --mirror --pack"));
    folder.succeeds("match moves.mdb --on biovision_example1.bvh -o database.bin");
    let frames = Database::read(&folder.read("moves.mdb")[..]).unwrap().frames();
    let joints = mocap::import(folder.path("biovision_example1.bvh")).unwrap();
    let joints = joints
        .nodes
        .iter()
        .filter(|node| node.kind == mocap::scene::NodeKind::Joint)
        .count();
    let (bones, numbers) = (joints + 1, |bytes: &[u8], at: usize| {
        u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize
    });
    let bytes = folder.read("database.bin");
    assert_eq!([numbers(&bytes, 0), numbers(&bytes, 4)], [frames, bones]);
    let each = 4 * frames * bones;
    let expected = 8 + 3 * each + 8 + 3 * each + 8 + 4 * each + 8 + 3 * each;
    assert_eq!(numbers(&bytes, expected), bones);
    assert_eq!(bytes.len(), expected + 4 + 4 * bones + 2 * (4 + 4 * 2) + 8 + 2 * frames);
    let features = folder.read("features.bin");
    assert_eq!([numbers(&features, 0), numbers(&features, 4)], [frames, 27]);
    assert_eq!(features.len(), 8 + 4 * 27 * frames + 2 * (4 + 4 * 27));
    folder.refuses(
        "match moves.mdb --on biovision_example1.bvh -o features.bin --force",
        2,
        "second file",
    );
    folder.refuses(
        "match moves.mdb --on biovision_example1.bvh -o new.bin --path 0/0+0/1 --force",
        2,
        "--path",
    );
}
