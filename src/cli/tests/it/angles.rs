//! `mocap angles`: warnings about a figure.

use crate::program::Folder;

/// A pelvis that faces sideways tilts about axes other than its own, and the command warns.
#[test]
fn a_pelvis_that_faces_aside_is_said() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    for (facing, is_aside) in [("x", true), ("z", false)] {
        folder.succeeds(&format!(
            "edit cmu_short.bvh -o turned.bvh --force --step turn:facing={facing}"
        ));
        let said = folder.succeeds("angles turned.bvh -o angles.csv --force");
        assert_eq!(said.contains("to the left of +Z"), is_aside, "{said}");
    }
}
