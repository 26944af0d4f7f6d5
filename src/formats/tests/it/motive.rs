//! Tables of Motive with values computed by hand, and formats that are not read.

use mocap::glam::{Quat, Vec3};
use mocap::scene::UpAxis;
use mocap::{Code, Format, FormatInfo, Importer, Scene};

const MARKERS: &str = "\
Format Version,1.23,Take Name,Take 1,Capture Frame Rate,240.000000,Export Frame Rate,120.000000,Total Exported \
Frames,3,Rotation Type,Quaternion,Length Units,Centimeters,Coordinate Space,Global

,,Marker,Marker,Marker,Marker,Marker,Marker
,,S:Head,S:Head,S:Head,S:Hip,S:Hip,S:Hip
,,\"1\",\"1\",\"1\",\"2\",\"2\",\"2\"
,,Position,Position,Position,Position,Position,Position
Frame,Time (Seconds),X,Y,Z,X,Y,Z
0,0.000000,10,170,20,10,100,20
1,0.008333,11,170,20,,,
2,0.016667,12,170,20,12,100,20
";

/// A table as Motive 3 writes it: row titles, parents, a rigid body in angles, and its expected markers and errors.
const BODIES: &str = "\
Format Version,1.25,Export Frame Rate,100,Rotation Type,ZXY,Length Units,Meters,Coordinate Space,Global

,Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body Marker,Rigid Body \
Marker,Rigid Body Marker,Marker,Marker,Marker
,Name,Wand,Wand,Wand,Wand,Wand,Wand,Wand,Wand:1,Wand:1,Wand:1,Wand:1,Wand:1,Wand:1
,ID,7,7,7,7,7,7,7,8,8,8,9,9,9
,Parent,,,,,,,,Wand,Wand,Wand,Wand,Wand,Wand
,,Rotation,Rotation,Rotation,Position,Position,Position,Mean Marker Error,Position,Position,Position,Position,\
Position,Position
Frame,Time (Seconds),X,Y,Z,X,Y,Z,,X,Y,Z,X,Y,Z
0,0.00,10,20,30,1,2,3,0.001,4,4,4,5,5,5
1,0.01,0,90,0,1,2,4,0.001,4,4,4,5,5,6
";

fn read(text: &str) -> Scene {
    let scene = Importer::new()
        .collapse_keys(false)
        .read(text.as_bytes(), "take.csv")
        .unwrap();
    assert_eq!(scene.validate(), []);
    scene
}

fn names(scene: &Scene) -> Vec<&str> {
    scene.nodes[1..].iter().map(|node| node.name.as_str()).collect()
}

#[test]
fn markers_of_motive_have_their_unit_rate_and_gaps() {
    let scene = read(MARKERS);
    assert_eq!(names(&scene), ["S:Head", "S:Hip"]);
    assert_eq!(scene.metadata.metres_per_unit, Some(0.01));
    assert_eq!(scene.metadata.up, Some(UpAxis::Y));
    let animation = &scene.animations[0];
    assert_eq!((animation.ticks_per_second, animation.duration), (120.0, 2.0));
    let hip = &animation.channels[1].position_keys;
    assert_eq!(hip.ticks, Some(vec![0.0, 2.0]));
    assert_eq!(hip.values, [Vec3::new(10.0, 100.0, 20.0), Vec3::new(12.0, 100.0, 20.0)]);
    let codes: Vec<_> = scene.warnings.iter().map(|warning| warning.code).collect();
    assert_eq!(codes, [Code::Gap]);
    // The file has a byte order mark and Windows line ends, or is truncated.
    let windows = format!("\u{feff}{}", MARKERS.replace('\n', "\r\n"));
    assert_eq!(read(&windows).animations, scene.animations);
    let cut = read(MARKERS.rsplit_once("2,0.01").unwrap().0);
    assert!(cut.warnings.iter().any(|warning| warning.code == Code::MissingFrames));
    assert_eq!(FormatInfo::of_contents(MARKERS.as_bytes()).unwrap().format, Format::Csv);
}

#[test]
fn rigid_bodies_turn_about_the_axes_of_the_header() {
    let scene = read(BODIES);
    // The expected marker is omitted in frames in which the marker was seen.
    assert_eq!(names(&scene), ["Wand", "Wand:1"]);
    let [wand, marker] = [0, 1].map(|channel| &scene.animations[0].channels[channel]);
    assert_eq!(marker.position_keys.values[0], Vec3::splat(5.0));
    // The rotation is about Z, then about the rotated X, then about the rotated Y.
    let expected = Quat::from_rotation_z(30_f32.to_radians())
        * Quat::from_rotation_x(10_f32.to_radians())
        * Quat::from_rotation_y(20_f32.to_radians());
    assert!(wand.rotation_keys.values[0].dot(expected).abs() > 1.0 - 1e-6);
    assert!(
        wand.rotation_keys.values[1]
            .mul_vec3(Vec3::Z)
            .abs_diff_eq(Vec3::X, 1e-6)
    );
    assert_eq!(wand.position_keys.values[1], Vec3::new(1.0, 2.0, 4.0));
    // The columns of a quaternion may be in any order.
    let quaternion = BODIES
        .replace("Rotation Type,ZXY", "Rotation Type,Quaternion")
        .replace(
            ",,Rotation,Rotation,Rotation,Position,Position,Position,Mean Marker Error",
            ",,Position,Position,Position,Rotation,Rotation,Rotation,Rotation",
        )
        .replace("X,Y,Z,X,Y,Z,,X", "X,Y,Z,X,Y,Z,W,X")
        .replace("10,20,30,1,2,3,0.001", "10,20,30,0,0.6,0,0.8");
    let scene = read(&quaternion);
    let turn = scene.animations[0].channels[0].rotation_keys.values[0];
    assert!(turn.abs_diff_eq(Quat::from_xyzw(0.0, 0.6, 0.0, 0.8), 1e-6));
}

#[test]
fn damaged_tables_of_motive_are_refused_or_valid() {
    for end in 0..BODIES.len() {
        if BODIES.is_char_boundary(end) {
            let _ = Importer::new()
                .format(Format::Csv)
                .read(&BODIES.as_bytes()[..end], "a.csv");
        }
    }
    let refused = |text: &str| Importer::new().read(text.as_bytes(), "a.csv").unwrap_err().code();
    assert_eq!(refused(&MARKERS.replace("11,170", "11,x")), Code::InvalidNumber);
    assert_eq!(
        refused(&MARKERS.replace("Frame,Time", "Row,Time")),
        Code::MissingKeyword
    );
    assert_eq!(refused(&MARKERS.replace("Quaternion", "Spin")), Code::UnexpectedToken);
    let local = BODIES.replace("Global", "Local").replace("Rigid Body,", "Bone,");
    let scene = read(&local);
    assert_eq!(names(&scene), ["Wand:1"]);
    assert!(
        scene
            .warnings
            .iter()
            .any(|warning| warning.code == Code::IgnoredChannel)
    );
}

#[test]
fn formats_that_are_not_read_say_what_to_export() {
    for (name, contents, help) in [
        (
            "a.dae",
            "<?xml version=\"1.0\"?><COLLADA version=\"1.4.1\"/>",
            "export glTF (.glb), FBX or BVH",
        ),
        (
            "a.smd",
            "version 1\nnodes\n0 \"root\" -1\nend\n",
            "Blender Source Tools",
        ),
        ("a.vpd", "Vocaloid Pose Data file\n\n", "save the motion as VMD"),
        ("a.mvnx", "<mvnx version=\"4\"/>", "MVN Analyze"),
        (
            "a.htr",
            "#Comment\n[Header]\nFileType htr\n",
            "export BVH, TRC or C3D from Cortex",
        ),
    ] {
        // The format is detected by the contents, and by the name.
        for (name, contents) in [("motion", contents), (name, "?")] {
            let error = Importer::new().read(contents.as_bytes(), name).unwrap_err();
            assert_eq!(error.code(), Code::UnreadableFormat, "{error}");
            assert!(error.to_string().contains(help), "{error}");
        }
    }
}
