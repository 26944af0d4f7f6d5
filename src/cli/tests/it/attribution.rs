//! The origin of motions in `mocap.toml`, and its copy in written files.

use std::collections::BTreeMap;

use crate::program::Folder;

const WALK: &str = "cmu_12_01_walk.bvh";
const DANCE: &str = "rokoko_dance.bvh";

fn rows(folder: &Folder, command: &str) -> BTreeMap<String, serde_json::Value> {
    let output = folder.run(command);
    let rows: Vec<serde_json::Value> = serde_json::from_slice(&output.stdout).unwrap();
    let name = |row: &serde_json::Value| row["file"].as_str().unwrap().rsplit('/').next().unwrap().to_owned();
    rows.into_iter().map(|row| (name(&row), row)).collect()
}

#[test]
fn a_folder_says_where_its_motions_come_from_and_written_files_keep_it() {
    let folder = Folder::of_real(&[WALK, DANCE]);
    folder.write(
        "mocap.toml",
        b"# of all files\nlicence = \"CC-BY-4.0\" # a comment\nsource = 'mocap.cs.cmu.edu'\nsynthetic = false\n\n\
          [files.\"cmu_*\"]\nperson = \"CMU\\u0031\"\n",
    );
    let all = rows(&folder, "survey . --json");
    let (walk, dance) = (&all[WALK], &all[DANCE]);
    assert_eq!(
        (&walk["licence"], &walk["person"]),
        (&"CC-BY-4.0".into(), &"CMU1".into())
    );
    assert_eq!(
        (&walk["source"], &walk["synthetic"]),
        (&"mocap.cs.cmu.edu".into(), &false.into())
    );
    assert_eq!(
        (&dance["licence"], &dance["person"]),
        (&"CC-BY-4.0".into(), &serde_json::Value::Null)
    );
    let chosen = rows(&folder, "survey . --json --where person=CMU1");
    assert_eq!(chosen.keys().collect::<Vec<_>>(), [WALK]);
    assert_eq!(rows(&folder, "survey . --json --where not(synthetic)").len(), 2);
    // A folder without a `mocap.toml`.
    let outputs = ["walk.glb", "walk.gltf", "walk.fbx", "walk.usda"];
    std::fs::create_dir_all(folder.path("a/b")).unwrap();
    for output in outputs {
        folder.succeeds(&format!("convert {WALK} a/b/{output}"));
    }
    folder.succeeds(&format!("retarget {WALK} --to-skeleton {DANCE} -o a/b/other.glb"));
    let kept = rows(&folder, "survey a/b --json");
    for output in outputs.iter().chain(&["other.glb"]) {
        let row = &kept[*output];
        assert_eq!(
            (&row["licence"], &row["person"]),
            (&"CC-BY-4.0".into(), &"CMU1".into()),
            "{output}"
        );
        assert_eq!(row["synthetic"], false, "{output}");
    }
    // The folder's file adds statements that the motion's file lacks, and does not override it.
    folder.write("a/mocap.toml", b"licence = \"other\"\nperson = \"other\"\n");
    folder.succeeds(&format!("convert {DANCE} a/b/dance.glb"));
    let kept = rows(&folder, "survey a/b --json");
    assert_eq!(
        (&kept["walk.glb"]["licence"], &kept["walk.glb"]["person"]),
        (&"CC-BY-4.0".into(), &"CMU1".into())
    );
    assert_eq!(
        (&kept["dance.glb"]["licence"], &kept["dance.glb"]["person"]),
        (&"CC-BY-4.0".into(), &"other".into())
    );
}

#[test]
fn a_mocap_toml_that_is_none_is_an_error_with_its_line() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    for (text, expected) in [
        ("licence = \"a\"\nlicense = \"b\"", "did you mean licence"),
        ("synthetic = \"no\"", "true or false"),
        ("\nperson = 'a' b", "mocap.toml:2:1"),
        ("[folders.\"a\"]", "PATTERN"),
        ("person = \"a", "person"),
        ("person", "mocap.toml:1:1"),
    ] {
        folder.write("mocap.toml", text.as_bytes());
        folder.refuses("info cmu_short.bvh", 2, expected);
    }
}

#[test]
fn a_pattern_that_matches_no_file_is_a_warning_with_the_nearest_name() {
    let folder = Folder::of_real(&[WALK, "cmu_short.bvh"]);
    folder.write(
        "mocap.toml",
        b"[files.\"cmu_12_01_wlak*\"]\nperson = \"A\"\n[files.\"cmu_s*\"]\nperson = \"B\"\n",
    );
    let said = folder.run("survey .");
    let said = String::from_utf8(said.stderr).unwrap();
    assert!(
        said.contains("mocap.toml:1") && said.contains("cmu_12_01_wlak*"),
        "{said}"
    );
    assert!(said.contains(&format!("the nearest name is {WALK}")), "{said}");
    assert_eq!(said.matches("no file has a name").count(), 1, "{said}");
}
