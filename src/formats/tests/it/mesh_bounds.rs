//! Tests how the mesh files of a robot are found, and the extents of their meshes.

use std::path::PathBuf;

use mocap::glam::DVec3;
use mocap_formats::internals::mesh_bounds::{candidates, obj, stl};

#[test]
fn packages_are_looked_for_in_folders_above() {
    let (found, _) = candidates("", "package:///data/robots/r/meshes/a.stl");
    for wanted in [
        "robots/r/meshes/a.stl",
        "../robots/r/meshes/a.stl",
        "../../../data/robots/r/meshes/a.stl",
    ] {
        assert!(found.contains(&PathBuf::from(wanted)), "{wanted}");
    }
    for (folder, file, expected) in [
        ("meshes", "b/a.stl", "meshes/b/a.stl"),
        ("../meshes/", "a.stl", "../meshes/a.stl"),
        ("", "file://../a.stl", "../a.stl"),
    ] {
        let expected = [expected, "a.stl"].map(PathBuf::from);
        assert_eq!(candidates(folder, file), (expected.to_vec(), true), "{folder} {file}");
    }
}

#[test]
fn only_the_name_remains_of_a_path_that_leads_away() {
    for (folder, file) in [
        ("", "/opt/robot/a.stl"),
        ("", "file:///opt/robot/a.stl"),
        ("/opt/robot", "a.stl"),
        ("meshes", "../../../../../../../../a.stl"),
        ("", "package://robot/../../a.stl"),
        ("", "package://../a.stl"),
    ] {
        assert_eq!(
            candidates(folder, file),
            (vec![PathBuf::from("a.stl")], false),
            "{file}"
        );
    }
}

#[test]
fn meshes_have_bounds_and_a_false_count_has_none() {
    let low_high = [DVec3::new(-1.0, 0.0, 2.0), DVec3::new(3.0, 4.0, 5.0)];
    assert_eq!(obj(b"v -1 4 2\nvn 9 9 9\nv 3 0 5\nf 1 2 1\n"), Some(low_high));
    let mut bytes = vec![0; 80];
    bytes.extend(1_u32.to_le_bytes());
    let corners = [0.0_f32, 0.0, 1.0, -1.0, 4.0, 2.0, 3.0, 0.0, 5.0, 0.0, 1.0, 3.0];
    bytes.extend(corners.iter().flat_map(|number| number.to_le_bytes()));
    assert_eq!(stl(&bytes), None);
    bytes.extend([0, 0]);
    assert_eq!(stl(&bytes), Some(low_high));
    bytes[80] = 200;
    assert_eq!(stl(&bytes), None);
}
