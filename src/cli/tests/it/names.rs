//! The option `--names`.

use std::fs;

use crate::at_root;
use crate::program::Folder;

/// The joints of a BVH file in their order, read without the library.
fn joints_of_bvh(text: &str) -> Vec<&str> {
    let lines = text.lines().map(str::trim);
    let named = lines.filter_map(|line| line.strip_prefix("ROOT ").or_else(|| line.strip_prefix("JOINT ")));
    named.map(str::trim).collect()
}

/// The command line: words, a file, `verify`, and rejected values.
#[test]
fn the_program_takes_words_and_files() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    let said = folder.succeeds("convert cmu_short.bvh out.glb --names unreal");
    assert!(
        said.contains("kept, because they are not bones: \"LHipJoint\""),
        "{said}"
    );
    folder.succeeds("verify cmu_short.bvh out.glb");
    // The names of one skeleton for another.
    let printed = folder.run("skeleton out.glb --json").stdout;
    folder.write("names.json", &printed);
    folder.succeeds("edit cmu_short.bvh -o named.bvh --step smooth --names names.json --sidecar");
    folder.succeeds("verify cmu_short.bvh named.bvh");
    let text = String::from_utf8(folder.read("named.bvh")).unwrap();
    assert!(joints_of_bvh(&text).contains(&"clavicle_r"));
    folder.write(
        "hero.glb",
        &fs::read(at_root("fixtures/characters/human_default.glb")).unwrap(),
    );
    folder.succeeds("retarget cmu_short.bvh hero.glb -o hero.fbx --names mixamo");
    let scene = mocap::import(folder.path("hero.fbx")).unwrap();
    assert!(scene.nodes.iter().any(|node| node.name == "mixamorig:LeftForeArm"));
    folder.refuses(
        "retarget cmu_short.bvh hero.glb -o again.glb --names mixamo",
        2,
        "--names has no effect on a character, because mocap keeps the contents of the character's file",
    );
    folder.write("bad.json", b"{\"bones\": {\"hips\": \"A\",\n\"shin\": \"B\"}}");
    folder.refuses("convert cmu_short.bvh b.bvh --names bad.json", 2, "line 2 column");
    folder.refuses("convert cmu_short.bvh b.bvh --names mixanu", 2, "neither vrm, mixamo");
    assert!(!folder.path("b.bvh").exists());
}
