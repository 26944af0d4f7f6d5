//! MJCF in several files, bodies in `<frame>` elements, and the files that a robot may name.

use std::path::Path;

use mocap::Importer;
use mocap::glam::DVec3;
use mocap::retarget::robot::{Robot, ShapeKind};

const G1: &str = "../../fixtures/robots/g1_29dof_rev_1_0_nomesh.xml";

const FRAMES: &str = r#"<mujoco model="frames">
  <default> <default class="weak"> <joint range="-10 10"/> </default> </default>
  <worldbody>
    <frame pos="1 2 3">
      <body name="base"> <freejoint/>
        <frame pos="0 0 1" euler="0 0 90" childclass="weak">
          <body name="arm" pos="1 0 0">
            <joint name="swing" axis="1 0 0"/>
            <frame pos="0 0.5 0" euler="90 0 0">
              <joint name="twist" pos="0 0 0.25" axis="0 0 1"/>
              <geom type="box" size="0.1 0.2 0.3" pos="0 1 0"/>
              <body name="hand" pos="0 0 2"/>
            </frame>
          </body>
        </frame>
      </body>
    </frame>
  </worldbody>
</mujoco>"#;

/// Writes files into a folder, and reads the first file as a robot.
fn import(files: &[(&str, &str)]) -> mocap::Result<Robot> {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap_or(Path::new(""))).unwrap();
        std::fs::write(path, text).unwrap();
    }
    Importer::new().import_robot(folder.path().join(files[0].0))
}

fn refused(files: &[(&str, &str)]) -> String {
    let error = import(files).unwrap_err();
    let diagnostic = error.diagnostic();
    let line = diagnostic.location.as_ref().map_or(0, |location| location.line);
    format!("{} {line}: {diagnostic}", diagnostic.code)
}

/// A model as in every `scene.xml`: the robot in one file, its surroundings in another, and parts in further files.
#[test]
fn a_model_in_several_files_is_the_model_in_one() {
    let whole = Importer::new().import_robot(G1).unwrap();
    let text = std::fs::read_to_string(G1).unwrap();
    let scene = r#"<mujoco model="scene">
        <include file="robot/g1.xml"/>
        <worldbody> <light pos="0 0 3"/> <geom name="floor" type="plane" size="0 0 0.05"/> </worldbody>
    </mujoco>"#;
    let found = import(&[("scene.xml", scene), ("robot/g1.xml", &text)]).unwrap();
    assert_eq!(found.name, "scene");
    assert_eq!(found.dof_names(), whole.dof_names());
    for (a, b) in found.links.iter().zip(&whole.links) {
        assert_eq!((&a.name, a.parent, &a.joint), (&b.name, b.parent, &b.joint));
        assert_eq!((&a.shapes, a.inertial), (&b.shapes, b.inertial));
    }
    // An arm in its own file, included at its place in the tree. File names are relative to the folder of the main
    // file.
    let start = text.find("<body name=\"left_shoulder_pitch_link\"").unwrap();
    let end = text.find("<body name=\"right_shoulder_pitch_link\"").unwrap();
    let arm = format!("<mujocoinclude>{}</mujocoinclude>", &text[start..end]);
    let rest = format!("{}<include file=\"parts/arm.xml\"/>{}", &text[..start], &text[end..]);
    let files = [("scene.xml", scene), ("robot/g1.xml", &rest), ("parts/arm.xml", &arm)];
    let found = import(&files).unwrap();
    assert_eq!(found.dof_names(), whole.dof_names());
    assert_eq!(found.zero_pose(), whole.zero_pose());
}

/// MuJoCo 3.17 searches the folder of the main file, and then the folder of the including file.
#[test]
fn names_of_included_files_are_of_the_main_folder_or_of_their_own() {
    let scene = r#"<mujoco><include file="assets/a.xml"/></mujoco>"#;
    let assets = r#"<mujocoinclude><worldbody><include file="deep/b.xml"/></worldbody></mujocoinclude>"#;
    let body = |name: &str| format!(r#"<mujocoinclude><body name="{name}"><geom size="1"/></body></mujocoinclude>"#);
    let (own, of_main) = (body("own"), body("of_main"));
    let mut files = vec![("m.xml", scene), ("assets/a.xml", assets), ("assets/deep/b.xml", &own)];
    assert_eq!(import(&files).unwrap().links[0].name, "own");
    files.push(("deep/b.xml", &of_main));
    assert_eq!(import(&files).unwrap().links[0].name, "of_main");
}

/// A ball on a table is not a robot, even if it moves freely or comes first.
#[test]
fn of_several_bodies_that_with_the_most_joints_is_the_robot() {
    let model = |bodies: &str| format!("<mujoco><worldbody>{bodies}</worldbody></mujoco>");
    let ball = r#"<body name="ball"><freejoint/><geom size="1"/></body>"#;
    let arm = r#"<body name="arm"><joint name="a"/><geom size="1"/>
        <frame><body name="hand"><joint name="b"/><geom size="1"/></body></frame></body>"#;
    for bodies in [[ball, arm], [arm, ball]] {
        let robot = import(&[("m.xml", &model(&bodies.concat()))]).unwrap();
        assert_eq!(robot.links[0].name, "arm");
    }
    let [first, second] = ["first", "second"].map(|name| ball.replace("ball", name));
    let robot = import(&[("m.xml", &model(&[first, second].concat()))]).unwrap();
    assert_eq!(robot.links[0].name, "first");
}

#[test]
fn what_is_wrong_with_an_included_file_is_named_with_it() {
    let scene = "<mujoco>\n<include file=\"a.xml\"/>\n</mujoco>";
    let missing = refused(&[("scene.xml", scene)]);
    assert!(
        missing.starts_with("missing-file 2: the model includes a file that cannot be read"),
        "{missing}"
    );
    assert!(missing.contains("<include file=\"a.xml\">"), "{missing}");
    for (included, expected) in [
        ("<mujoco>", "invalid-xml 0: the file is not valid XML"),
        (
            "<robot/>",
            "missing-keyword 0: the outermost element is not <mujoco> or <mujocoinclude>",
        ),
        (
            "<mujoco>\n<include file=\"a.xml\"/></mujoco>",
            "invalid-robot 0: a file is included twice",
        ),
        (
            "<mujoco><worldbody>\n<body><joint axis=\"0 0 0\"/></body></worldbody></mujoco>",
            "invalid-robot 0: the axis of a joint has no length, in \"a.xml\", which is included, at line 2",
        ),
    ] {
        let found = refused(&[("scene.xml", scene), ("a.xml", included)]);
        assert!(found.starts_with(expected), "{found}");
        assert!(found.contains("\"a.xml\", which is included"), "{found}");
    }
    // A refused scene has no motion, so it gives no warning about one.
    let unread = Importer::new().read(scene.as_bytes(), "scene.xml").unwrap_err();
    assert!(unread.warnings().is_empty(), "{:?}", unread.warnings());
    // In memory, there is no other file.
    let read = Importer::new().read_robot(scene.as_bytes(), "scene.xml").unwrap_err();
    assert_eq!(read.code().as_str(), "missing-file");
}

const MESH: &str = "v -1 0 0\nv 1 2 3\nv 0 1 1\nf 1 2 3\n";

/// Whether the mesh of a robot with one link was found, and the warnings. Each of `files` is a path with the file's
/// contents. The first file is the robot.
fn mesh_of(files: &[(&str, &str)]) -> (bool, Vec<String>) {
    let robot = import(files).unwrap();
    let shapes = robot.links.iter().flat_map(|link| &link.shapes);
    let bounds: Vec<_> = shapes
        .map(|shape| match &shape.kind {
            ShapeKind::Mesh { bounds, .. } => *bounds,
            _ => panic!("it is a mesh"),
        })
        .collect();
    assert_eq!(bounds.len(), 1);
    let expected = [DVec3::new(-1.0, 0.0, 0.0), DVec3::new(1.0, 2.0, 3.0)];
    assert!(bounds[0].is_none_or(|bounds| bounds == expected));
    let warnings = robot.warnings.iter().map(ToString::to_string).collect();
    (bounds[0].is_some(), warnings)
}

/// The folders of ROS and of MuJoCo have meshes next to the folder of the robot.
#[test]
fn meshes_are_opened_around_the_robot_and_at_no_path_from_the_root() {
    let elsewhere = tempfile::tempdir().unwrap();
    std::fs::write(elsewhere.path().join("part.obj"), MESH).unwrap();
    let absolute = elsewhere.path().join("part.obj").display().to_string();
    let urdf = |mesh: &str| {
        format!(
            "<robot name=\"r\"><link name=\"a\"><visual><geometry><mesh filename=\"{mesh}\"/></geometry></visual></link></robot>"
        )
    };
    let mjcf = |folder: &str, mesh: &str| {
        format!(
            "<mujoco><compiler meshdir=\"{folder}\"/><asset><mesh name=\"m\" file=\"{mesh}\"/></asset><worldbody><body><joint/>\
             <inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/><geom type=\"mesh\" mesh=\"m\"/></body></worldbody></mujoco>"
        )
    };
    let deep = "package/a/b/c/d/e/f/robot.urdf";
    for (name, text, mesh) in [
        (
            "package/urdf/r.urdf",
            urdf("package://package/meshes/part.obj"),
            "package/meshes/part.obj",
        ),
        (
            "package/urdf/r.urdf",
            urdf("package://other/meshes/part.obj"),
            "other/meshes/part.obj",
        ),
        (
            "package/urdf/r.urdf",
            urdf("../meshes/part.obj"),
            "package/meshes/part.obj",
        ),
        (
            "package/urdf/r.urdf",
            urdf("file://../meshes/part.obj"),
            "package/meshes/part.obj",
        ),
        (deep, urdf("../../../../../../part.obj"), "package/part.obj"),
        ("mjcf/r.xml", mjcf("../meshes", "part.obj"), "meshes/part.obj"),
        ("mjcf/r.xml", mjcf("assets", "../stl/part.obj"), "mjcf/stl/part.obj"),
        // The name without a folder, next to the robot.
        ("r.urdf", urdf("/opt/robot/part.obj"), "part.obj"),
        ("r.urdf", urdf("file:///opt/robot/part.obj"), "part.obj"),
    ] {
        assert_eq!(mesh_of(&[(name, &text), (mesh, MESH)]), (true, vec![]), "{text}");
    }
    let folder = elsewhere.path().display().to_string();
    for (name, text) in [
        ("r.urdf", urdf(&absolute)),
        ("r.urdf", urdf(&format!("file://{absolute}"))),
        ("r.xml", mjcf(&folder, "part.obj")),
        (deep, urdf("../../../../../../../part.obj")),
        ("a/r.urdf", urdf("package://a/../../part.obj")),
    ] {
        let files = [(name, text.as_str()), ("part.obj", MESH)];
        // If the robot is in the outermost folder, the mesh would be found by its name.
        let (is_found, warnings) = mesh_of(&files[..1 + usize::from(name.contains('/'))]);
        assert!(!is_found, "{text}");
        assert!(
            matches!(&warnings[..], [only] if only.contains("too far away from the robot")),
            "{warnings:?}"
        );
    }
    // A mesh of another kind is not opened.
    assert_eq!(
        mesh_of(&[("r.urdf", &urdf("../r/part.txt")), ("r/part.txt", MESH)]),
        (false, vec![])
    );
}

#[test]
fn includes_are_opened_around_the_model_and_at_no_path_from_the_root() {
    let arm = "<mujoco><worldbody><body name=\"arm\"><joint/></body></worldbody></mujoco>";
    let scene = |file: &str| format!("<mujoco>\n<include file=\"{file}\"/>\n</mujoco>");
    let found = import(&[("scenes/scene.xml", &scene("../parts/arm.xml")), ("parts/arm.xml", arm)]).unwrap();
    assert!(found.links.iter().any(|link| link.name == "arm"));
    let elsewhere = tempfile::tempdir().unwrap();
    std::fs::write(elsewhere.path().join("arm.xml"), arm).unwrap();
    let absolute = elsewhere.path().join("arm.xml").display().to_string();
    for file in [absolute.as_str(), "../../../../../../../arm.xml", "/etc/passwd"] {
        let found = refused(&[("a/b/c/d/e/f/g/scene.xml", &scene(file)), ("arm.xml", arm)]);
        assert!(
            found.starts_with("missing-file 2: the path of an included file leads too far"),
            "{found}"
        );
    }
}

/// If each file includes two others, 30 levels would be a billion files.
#[test]
fn includes_end() {
    let names: Vec<String> = (0..100).map(|index| format!("{index}.xml")).collect();
    let texts: Vec<String> = (1..=100)
        .map(|next| format!("<mujoco><include file=\"{next}.xml\"/></mujoco>"))
        .collect();
    let files: Vec<(&str, &str)> = names
        .iter()
        .map(String::as_str)
        .zip(texts.iter().map(String::as_str))
        .collect();
    assert!(refused(&files).starts_with("limit-exceeded"));
}

/// The numbers are computed by hand, and equal MuJoCo 4.0's.
#[test]
fn frames_place_what_stands_in_them() {
    let robot = import(&[("frames.xml", FRAMES)]).unwrap();
    let names: Vec<&str> = robot.links.iter().map(|link| link.name.as_str()).collect();
    assert_eq!(names, ["base", "arm/swing", "arm", "hand"]);
    assert_eq!(robot.dof_names(), ["swing", "twist"]);
    let near = |found: DVec3, expected: [f64; 3]| {
        assert!(found.abs_diff_eq(DVec3::from(expected), 1e-12), "{found} {expected:?}");
    };
    let (swing, twist) = (&robot.links[1].joint, &robot.links[2].joint);
    near(swing.origin.translation, [0.0, 1.0, 1.0]);
    near(swing.origin.rotation * DVec3::X, [0.0, 1.0, 0.0]);
    near(swing.axis, [1.0, 0.0, 0.0]);
    near(twist.anchor, [0.0, 0.25, 0.0]);
    near(twist.axis, [0.0, -1.0, 0.0]);
    // A body in a `<frame>` element has the class of this element.
    assert!((twist.limits.upper - 10_f64.to_radians()).abs() < 1e-12);
    near(robot.links[2].shapes[0].origin.translation, [0.0, 0.5, 1.0]);
    near(robot.links[3].joint.origin.translation, [0.0, -1.5, 0.0]);

    let attached = FRAMES.replace("<body name=\"hand\" pos=\"0 0 2\"/>", "<attach model=\"m\"/>");
    let found = refused(&[("frames.xml", &attached)]);
    assert!(
        found.starts_with("unread-extension 12: the model attaches another model"),
        "{found}"
    );
}
