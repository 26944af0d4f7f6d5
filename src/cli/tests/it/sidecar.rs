//! The option `--sidecar`.

#[test]
fn the_program_writes_one_by_choice() {
    use crate::program::Folder;
    let folder = Folder::with(&["w.bvh"]);
    folder.succeeds("convert w.bvh out.bvh --unit cm --out-unit m --trim 0.1..0.5 --sidecar --verify");
    folder.succeeds("verify w.bvh out.bvh");
    assert!(folder.path("out.bvh.json").exists());
    folder.succeeds("edit w.bvh -o edited.bvh --step in-place --sidecar");
    folder.succeeds("verify w.bvh edited.bvh");
    folder.ends_with(2, "convert w.bvh out.glb --sidecar");
    folder.refuses("convert w.bvh - --to bvh --sidecar", 2, "several files");
}
