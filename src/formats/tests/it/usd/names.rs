//! Tests the names of prims, the nodes of USD.

use mocap_formats::internals::usd::Names;

#[test]
fn names_are_identifiers_and_each_is_there_once() {
    let mut names = Names::default();
    let made = ["mixamorig:Hips", "mixamorig Hips", "", "左腕", "左足", "1st", "Hips_2"];
    let made = made.map(|name| names.unique(name, "Joint"));
    assert_eq!(
        made,
        [
            "mixamorig_Hips",
            "mixamorig_Hips_2",
            "Joint",
            "Joint__",
            "Joint___2",
            "_1st",
            "Hips_2"
        ]
    );
}
