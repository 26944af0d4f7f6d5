//! Robots: reading URDF and MJCF, the links that are bones, and motions on robots.

use std::fs;

use mocap::glam::{DQuat, DVec3};
use mocap::retarget::robot::{
    JointKind, Placement, Robot, RobotMap, RobotMotion, RobotOptions, RobotRetargeter, ShapeKind, robot_bones,
    robot_scene,
};
use mocap::scene::{Channel, HumanoidBone as Bone};
use mocap::{Code, Importer, Limits, Pose};

/// A leg that uses every feature of URDF.
const URDF: &str = r#"<?xml version="1.0"?>
<robot name="r">
  <link name="base"/>
  <joint name="turn" type="revolute">
    <origin xyz="0 0 1" rpy="0 0 1.5707963267948966"/>
    <parent link="base"/> <child link="arm"/>
    <axis xyz="0 2 0"/>
    <limit lower="-1" upper="0.5" velocity="3" effort="7"/>
  </joint>
  <joint name="slide" type="prismatic">
    <parent link="arm"/> <child link="hand"/> <axis xyz="0 0 1"/> <limit lower="0" upper="0.2"/>
  </joint>
  <joint name="spin" type="continuous"> <parent link="hand"/> <child link="wheel"/> </joint>
  <link name="arm">
    <inertial><origin xyz="0 0 0.1"/><mass value="2"/><inertia ixx="1" iyy="2" izz="3" ixy="0.1" ixz="0.2" iyz="0.3"/></inertial>
    <collision><origin xyz="1 0 0"/><geometry><box size="0.2 0.4 0.6"/></geometry></collision>
    <visual><geometry><sphere radius="0.3"/></geometry></visual>
  </link>
  <link name="hand"/> <link name="wheel"/>
</robot>"#;

const MJCF: &str = r#"<mujoco model="m">
  <compiler eulerseq="ZYX"/>
  <default>
    <joint range="-90 90"/>
    <default class="c"> <joint axis="0 1 0"/> <geom type="capsule" contype="0" conaffinity="0"/> </default>
  </default>
  <worldbody>
    <body name="base" pos="0 0 3" childclass="c"> <freejoint name="root"/>
      <body name="upper" pos="0 0 -1" euler="90 0 0">
        <joint name="a" pos="0 0 0.5"/> <joint name="b" axis="1 0 0" range="-10 20" actuatorfrcrange="-5 6"/>
        <geom fromto="0 0 0 0 0 -2" size="0.1"/>
        <body name="ball"> <joint name="s" type="ball" limited="false"/> </body>
      </body>
    </body>
  </worldbody>
</mujoco>"#;

fn robot(name: &str) -> Robot {
    Importer::new()
        .import_robot(format!("../../fixtures/robots/{name}"))
        .unwrap()
}

fn read(text: &str) -> Robot {
    Importer::new().read_robot(text.as_bytes(), "robot.xml").unwrap()
}

fn refused(text: &str) -> String {
    let error = Importer::new().read_robot(text.as_bytes(), "robot.xml").unwrap_err();
    let diagnostic = error.diagnostic();
    let line = diagnostic.location.as_ref().map_or(0, |location| location.line);
    format!("{} {line}: {diagnostic}", diagnostic.code)
}

#[test]
fn urdf_is_read() {
    let robot = read(URDF);
    let names: Vec<&str> = robot.links.iter().map(|link| link.name.as_str()).collect();
    assert_eq!(names, ["base", "arm", "hand", "wheel"]);
    assert_eq!(robot.dof_names(), ["turn", "slide", "spin"]);
    let arm = &robot.links[1];
    assert_eq!(arm.line, 14);
    assert_eq!(arm.joint.axis, DVec3::Y);
    let limits = arm.joint.limits;
    assert_eq!(
        (limits.lower, limits.upper, limits.velocity, limits.effort),
        (-1.0, 0.5, Some(3.0), Some(7.0))
    );
    // A quarter turn about Z moves the arm's +X to the base's +Y.
    let corner = robot.zero_pose()[1].point(DVec3::X);
    assert!(corner.abs_diff_eq(DVec3::new(0.0, 1.0, 1.0), 1e-12), "{corner}");
    assert_eq!(arm.inertial.unwrap().inertia, [1.0, 2.0, 3.0, 0.1, 0.2, 0.3]);
    assert_eq!(
        arm.shapes[0].kind,
        ShapeKind::Box {
            half_size: DVec3::new(0.1, 0.2, 0.3)
        }
    );
    assert_eq!((arm.shapes[0].collides, arm.shapes[1].collides), (true, false));
    assert_eq!(robot.links[2].joint.kind, JointKind::Slide);
    assert_eq!(robot.links[3].joint.limits.upper, f64::INFINITY);
    let scene = Importer::new().read(URDF.as_bytes(), "robot.urdf").unwrap();
    assert_eq!(scene.validate(), []);
    assert_eq!(scene.nodes.len(), 4);
    let hand = Pose::rest(&scene).node_to_world[2].w_axis;
    assert_eq!(hand.truncate().to_array(), [0.0, 0.0, 1.0]);
}

/// The base and `turn` are still, `slide` moves by a micrometre per frame, and `spin` rotates by a hundredth of a
/// degree.
#[test]
fn joints_of_a_robot_that_are_still_have_one_key() {
    let robot = read(URDF);
    let mut motion = RobotMotion::default();
    let base = Placement {
        rotation: DQuat::from_rotation_z(0.3),
        translation: DVec3::new(1.0, 2.0, 0.7),
    };
    (motion.fps, motion.root, motion.dof_names) = (30.0, vec![base; 50], robot.dof_names());
    for frame in 0..50 {
        let step = f64::from(frame);
        motion.dof_pos.extend([0.4, 1e-6 * step, 0.01_f64.to_radians() * step]);
    }
    let animation = motion.to_animation(&robot);
    let keys = |channel: &Channel| (channel.position_keys.len(), channel.rotation_keys.len());
    let counts: Vec<_> = animation.channels.iter().map(keys).collect();
    assert_eq!(counts, [(1, 1), (1, 1), (50, 1), (1, 50)]);
    assert_eq!(animation.duration, 49.0);
    let mut scene = robot_scene(&robot);
    scene.animations.push(animation);
    assert_eq!(scene.validate(), []);
    // A quarter turn of the joint's origin, and 0.4 rad of the joint itself about Y.
    let pose = Pose::at_tick(&scene, 0, 30.0).unwrap();
    let expected = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2) * DQuat::from_rotation_y(0.4);
    let found = DQuat::from_mat4(&pose.node_to_parent[1].as_dmat4());
    assert!(found.abs_diff_eq(expected, 1e-6), "{found}");
}

#[test]
fn mjcf_is_read() {
    let robot = read(MJCF);
    let names: Vec<&str> = robot.links.iter().map(|link| link.name.as_str()).collect();
    assert_eq!(names, ["base", "upper/a", "upper", "ball/s_x", "ball/s_y", "ball"]);
    assert_eq!(robot.dof_names(), ["a", "b", "s_x", "s_y", "s_z"]);
    let (a, b) = (&robot.links[1].joint, &robot.links[2].joint);
    assert_eq!((a.axis, b.axis), (DVec3::Y, DVec3::X));
    assert!((a.limits.upper - 90_f64.to_radians()).abs() < 1e-12);
    assert!((b.limits.lower + 10_f64.to_radians()).abs() < 1e-12);
    assert_eq!(b.limits.effort, Some(6.0));
    assert_eq!(robot.links[3].joint.limits.upper, f64::INFINITY);
    // `a` rotates by 90 degrees about Y through (0, 0, 0.5). The origin of the body moves from 0.5 below this point to
    // 0.5 beside it.
    let place = a.link_to_parent(std::f64::consts::FRAC_PI_2);
    let origin = a.origin.to_inner(place.translation);
    assert!(origin.abs_diff_eq(DVec3::new(-0.5, 0.0, 0.5), 1e-12), "{origin}");
    let capsule = &robot.links[2].shapes[0];
    assert_eq!(
        capsule.kind,
        ShapeKind::Capsule {
            radius: 0.1,
            half_length: 1.0
        }
    );
    assert!(!capsule.collides);
    assert_eq!(capsule.origin.translation, DVec3::new(0.0, 0.0, -1.0));
}

/// Both descriptions of a robot place its links equally, up to the digits of MJCF, which has fewer.
#[test]
fn urdf_and_mjcf_are_one_robot() {
    let (urdf, mjcf) = (robot("g1_29dof_rev_1_0.urdf"), robot("g1_29dof_rev_1_0_nomesh.xml"));
    assert_eq!(urdf.dof_names(), mjcf.dof_names());
    let (a, b) = (urdf.zero_pose(), mjcf.zero_pose());
    for (index, link) in mjcf.links.iter().enumerate() {
        let other = urdf.links.iter().position(|other| other.name == link.name).unwrap();
        let apart = a[other].translation.distance(b[index].translation);
        assert!(apart < 1e-5, "{} {apart}", link.name);
        assert!(
            a[other].rotation.dot(b[index].rotation).abs() > 1.0 - 1e-9,
            "{}",
            link.name
        );
        if link.joint.moves() {
            let (limits, others) = (link.joint.limits, urdf.links[other].joint.limits);
            assert!((limits.lower - others.lower).abs() < 1e-5, "{}", link.name);
            assert!((limits.upper - others.upper).abs() < 1e-5, "{}", link.name);
        }
    }
}

#[test]
fn the_bones_are_those_of_the_truth() {
    let truth: serde_json::Value =
        serde_json::from_slice(&fs::read("../../fixtures/robots/truth.json").unwrap()).unwrap();
    let mut compared = 0;
    for name in [
        "g1_29dof_rev_1_0.urdf",
        "g1_29dof_rev_1_0_nomesh.xml",
        "h1.urdf",
        "h1_nomesh.xml",
    ] {
        let robot = robot(name);
        let bones = robot_bones(&robot, None).unwrap();
        let truth = &truth["robots"][name];
        assert_eq!(truth["dof"], robot.dof_names().len());
        let wanted = truth["bones"].as_object().unwrap();
        assert_eq!(bones.len(), wanted.len(), "{name}");
        for bone in bones {
            let wanted = &wanted[bone.bone.as_str()];
            assert_eq!(wanted["link"], robot.links[bone.link].name, "{name} {:?}", bone.bone);
            let joints: Vec<&str> = bone
                .joints
                .iter()
                .map(|link| robot.links[*link].joint.name.as_str())
                .collect();
            assert_eq!(wanted["joints"], serde_json::json!(joints), "{name} {:?}", bone.bone);
            compared += 1;
        }
    }
    assert!(compared > 50, "{compared}");
}

#[test]
fn a_map_names_other_links() {
    let robot = robot("h1.urdf");
    let map = RobotMap::from([(Bone::Chest, None), (Bone::LeftFoot, Some("left_knee_link".to_owned()))]);
    let bones = robot_bones(&robot, Some(&map)).unwrap();
    assert!(bones.iter().all(|bone| bone.bone != Bone::Chest));
    let foot = bones.iter().find(|bone| bone.bone == Bone::LeftFoot).unwrap();
    assert_eq!(robot.links[foot.link].name, "left_knee_link");
    let map = RobotMap::from([(Bone::Chest, Some("nothing".to_owned()))]);
    assert_eq!(robot_bones(&robot, Some(&map)).unwrap_err().code(), Code::InvalidValue);
    assert_eq!(robot_bones(&read(URDF), None).unwrap_err().code(), Code::NotHumanoid);
}

#[test]
fn two_arms_are_not_legs() {
    let arm = |side: &str, y: f64| {
        let link = |index: usize| {
            let parent = if index == 0 {
                "base".to_owned()
            } else {
                format!("{side}_arm_{}", index - 1)
            };
            let y = if index == 0 { y } else { 0.0 };
            format!(
                "<link name=\"{side}_arm_{index}\"/><joint name=\"{side}_{index}\" type=\"continuous\"><parent link=\"{parent}\"/>\
                 <child link=\"{side}_arm_{index}\"/><origin xyz=\"0 {y} -0.2\"/><axis xyz=\"0 1 0\"/></joint>"
            )
        };
        (0..5).map(link).collect::<String>()
    };
    let text = format!(
        "<robot name=\"r\"><link name=\"base\"/>{}{}</robot>",
        arm("left", 0.1),
        arm("right", -0.1)
    );
    let bones = |text: &str| -> Vec<Bone> {
        let found = robot_bones(&read(text), None).unwrap();
        found.into_iter().map(|bone| bone.bone).collect()
    };
    // An upper body. The same limbs with meaningless names are legs.
    let [upper, lower] = [bones(&text), bones(&text.replace("_arm_", "_"))];
    assert!(upper.contains(&Bone::LeftUpperArm) && !upper.contains(&Bone::LeftUpperLeg));
    assert!(lower.contains(&Bone::LeftUpperLeg) && !lower.contains(&Bone::LeftUpperArm));
}

/// The motion of a file on a robot.
fn walk(name: &str, options: &RobotOptions) -> (Robot, RobotMotion, mocap::retarget::robot::report::RobotReport) {
    let robot = robot(name);
    let mut source = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
    let conversion = mocap::Conversion::new().first_frame(mocap::convert::FirstFrame::DropRestPose);
    conversion.frame_rate(30.0).apply(&mut source).unwrap();
    let mut retargeter = RobotRetargeter::new(&source, &robot, options).unwrap();
    let (motion, report) = retargeter.clip(&source, 0).unwrap();
    (robot, motion, report)
}

#[test]
fn a_walk_keeps_the_limits_the_floor_and_the_directions() {
    for name in [
        "g1_29dof_rev_1_0.urdf",
        "h1.urdf",
        "g1_29dof_rev_1_0_nomesh.xml",
        "h1_nomesh.xml",
    ] {
        let (robot, motion, report) = walk(name, &RobotOptions::default());
        let joints = robot.moving_joints();
        for frame in 0..motion.frames() {
            for (position, link) in motion.dof_of(frame).iter().zip(&joints) {
                let limits = robot.links[*link].joint.limits;
                assert!((limits.lower..=limits.upper).contains(position), "{name} {frame}");
            }
        }
        assert_eq!(report.limit_violations, 0, "{name}");
        assert!(report.mean_degrees < 5.0, "{name} {}", report.mean_degrees);
        assert_eq!(report.fraction_below_floor, 0.0, "{name}");
        assert!(report.skate.unwrap() < report.source_skate.unwrap() + 0.005, "{name}");
        // The poses of this animation put the links where the joint positions put them.
        let mut scene = robot_scene(&robot);
        scene.animations.push(motion.to_animation(&robot));
        assert_eq!(scene.validate(), []);
        let pose = Pose::at_tick(&scene, 0, 20.0).unwrap();
        let base = pose.node_to_world[0].w_axis.truncate().as_dvec3();
        assert!(base.abs_diff_eq(motion.root[20].translation, 1e-6), "{name}");
    }
}

#[test]
fn velocities_stay_within_the_limits_where_that_is_asked_for() {
    let options = RobotOptions::new().velocity_limits(true);
    let (robot, motion, report) = walk("h1.urdf", &options);
    for (dof, link) in robot.moving_joints().into_iter().enumerate() {
        let most = robot.links[link].joint.limits.velocity.unwrap();
        for frame in 1..motion.frames() {
            let velocity = (motion.dof_of(frame)[dof] - motion.dof_of(frame - 1)[dof]) * motion.fps;
            assert!(velocity.abs() <= most * (1.0 + 1e-9), "{dof} {frame} {velocity}");
        }
    }
    assert_eq!((report.limit_violations, report.fraction_too_fast), (0, 0.0));
}

#[test]
fn what_is_wrong_with_a_robot_is_named_with_its_line() {
    let changed = |from: &str, to: &str| {
        assert!(URDF.contains(from) || MJCF.contains(from), "{from}");
        let text = if URDF.contains(from) { URDF } else { MJCF };
        refused(&text.replacen(from, to, 1))
    };
    for (from, to, expected) in [
        (
            "</robot>",
            "",
            "invalid-xml 1: the file is not valid XML: the root node was opened but never closed",
        ),
        (
            "<child link=\"arm\"/>",
            "<child link=\"arn\"/>",
            "invalid-robot 6: no <link> is called \"arn\"; joint \"turn\"; help: did you mean arm?",
        ),
        (
            "<child link=\"wheel\"/>",
            "<child link=\"arm\"/>",
            "invalid-robot 13: the link \"arm\" is the child of two joints; joint \"spin\"; expected one joint for each link; found also \"turn\"",
        ),
        (
            "name=\"turn\" type=\"revolute\"",
            "name=\"turn\" type=\"hinge\"",
            "unexpected-token 4: the type of a joint is not known; joint \"turn\"; expected revolute, continuous, prismatic, fixed, floating or planar; found \"hinge\"",
        ),
        (
            "xyz=\"0 2 0\"",
            "xyz=\"0 2\"",
            "invalid-number 7: xyz has the wrong number of values; expected 3 numbers; found 2",
        ),
        (
            "xyz=\"0 2 0\"",
            "xyz=\"0 0 0\"",
            "invalid-robot 7: the axis of a joint has no length; joint \"turn\"; expected a direction such as 0 1 0; found \"0 0 0\"",
        ),
        (
            "lower=\"-1\"",
            "lower=\"x\"",
            "invalid-number 8: lower has a word that is not a number; expected a number; found \"x\"",
        ),
        (
            "lower=\"-1\"",
            "lower=\"1e30\"",
            "number-range 8: lower has a number that is not finite, or too large; expected a number of at most 1e18; found \"1e30\"",
        ),
        (
            "<link name=\"wheel\"/>",
            "<link name=\"hand\"/>",
            "invalid-robot 19: two links are called \"hand\"; help: rename one of them",
        ),
        (
            "<parent link=\"base\"/> <child link=\"arm\"/>",
            "<parent link=\"hand\"/> <child link=\"arm\"/>",
            "invalid-robot 4: some joints form a circle: their links are not connected to the base; joint \"turn\"",
        ),
        (
            "childclass=\"c\"",
            "childclass=\"d\"",
            "invalid-robot 8: no <default> has the class \"d\"",
        ),
        (
            "eulerseq=\"ZYX\"",
            "eulerseq=\"ZYw\"",
            "unexpected-token 2: the value of the compiler attribute eulerseq is unknown; expected three of x, y and z, or of X, Y and Z; found \"ZYw\"",
        ),
        (
            "type=\"ball\"",
            "type=\"free\"",
            "invalid-robot 12: a body within another has a free joint; joint \"s\"",
        ),
    ] {
        assert_eq!(changed(from, to), expected);
    }
}

/// The warnings, with their lines.
fn warned(text: &str) -> Vec<String> {
    let line = |warning: &mocap::Diagnostic| warning.location.as_ref().map_or(0, |location| location.line);
    let robot = read(text);
    let warnings = robot.warnings.iter();
    warnings
        .map(|warning| format!("{}: {warning}", line(warning)))
        .collect()
}

/// The file has a lower limit above the upper limit, as files of Pioneer robots do. Other readers use the smaller limit
/// as the lower limit.
#[test]
fn exchanged_limits_are_put_right_with_a_warning() {
    let exchanged = URDF.replacen("lower=\"-1\" upper=\"0.5\"", "lower=\"0.5\" upper=\"-1\"", 1);
    assert_ne!(exchanged, URDF);
    let limits = |text: &str| read(text).links[1].joint.limits;
    assert_eq!(limits(&exchanged), limits(URDF));
    let message = "8: the lower limit of a joint is above the upper limit; mocap swapped the limits; joint \
                   \"turn\"; expected a lower limit that is at most the upper limit; found 0.5 and -1";
    assert!(
        warned(&exchanged).iter().any(|found| found == message),
        "{:?}",
        warned(&exchanged)
    );
}

/// Elements of other programs are not part of a robot: elements of xacro with a declared or an undeclared prefix, and
/// of any other program.
#[test]
fn elements_of_other_programs_are_passed() {
    let plain = read(URDF).links.len();
    let declared = URDF
        .replacen("<robot ", "<robot xmlns:xacro=\"http://ros.org/wiki/xacro\" ", 1)
        .replacen("</robot>", "<xacro:imu_sensor link=\"arm\"/></robot>", 1);
    let undeclared = URDF.replacen("</robot>", "<xacro:imu_sensor link=\"arm\"/></robot>", 1);
    let sensor = URDF.replacen(
        "</robot>",
        "<sensor:camera sensor:rate='3'/><!-- a:b <c:d> --></robot>",
        1,
    );
    for text in [&declared, &undeclared, &sensor] {
        assert_eq!(read(text).links.len(), plain);
    }
    for text in [&declared, &undeclared] {
        let warnings = warned(text);
        assert!(
            warnings
                .iter()
                .any(|found| found.contains("<xacro:imu_sensor> belongs to xacro")),
            "{warnings:?}"
        );
    }
    assert_eq!(warned(&sensor), warned(URDF));
    // The declaration follows white space, one line later.
    let mut below = read(URDF).links;
    below.iter_mut().for_each(|link| link.line += 1);
    assert_eq!(read(&format!("\n {URDF}")).links, below);
    // Joints of other programs, and a joint of URDF without a single axis.
    for kind in ["spherical", "planar"] {
        let text = URDF.replacen("type=\"continuous\"", &format!("type=\"{kind}\""), 1);
        assert!(!read(&text).links[3].joint.moves());
        let warnings = warned(&text);
        let message = format!("{kind} joints are not supported: the joint does not move");
        assert!(warnings.iter().any(|found| found.contains(&message)), "{warnings:?}");
    }
    // A template has expressions or no joint.
    let template = declared.replacen("mass value=\"2\"", "mass value=\"${2*m}\"", 1);
    assert!(
        refused(&template).contains("a xacro template"),
        "{}",
        refused(&template)
    );
    let calls = "<robot name='r' xmlns:xacro='http://ros.org/wiki/xacro'><link name='a'/><xacro:leg/></robot>";
    assert!(refused(calls).contains("a xacro template"));
}

#[test]
fn copies_of_a_part_are_refused_by_their_name() {
    let replicated = |inner: &str| format!("<mujoco><worldbody>{inner}</worldbody></mujoco>");
    let body = "<body name='b'><freejoint/><geom size='.1' mass='1'/></body>";
    for inner in [
        format!("<replicate count='2' offset='0 1 0'>{body}</replicate>"),
        format!(
            "<body name='a'><freejoint/><replicate count='3'>{}</replicate></body>",
            "<geom size='.1'/>"
        ),
    ] {
        let message = refused(&replicated(&inner));
        assert!(message.contains("with <replicate>, which is not read"), "{message}");
    }
    let sites = replicated(&body.replacen("</body>", "<replicate count='2'><site/></replicate></body>", 1));
    assert_eq!(read(&sites).links.len(), 1);
}

#[test]
fn a_mass_that_no_body_has_is_warned_of() {
    let sound = URDF.replace("izz=\"3\"", "izz=\"2.5\"");
    let changed = |from: &str, to: &str| {
        assert!(sound.contains(from), "{from}");
        sound.replacen(from, to, 1)
    };
    assert_eq!(warned(&sound), Vec::<String>::new());
    let negative = changed("mass value=\"2\"", "mass value=\"-2\"");
    let message = "15: the link \"arm\" has a negative mass, which is ignored; expected a mass of at least 0; found -2; \
                   help: correct this value; until then this part weighs nothing";
    assert_eq!(warned(&negative), [message]);
    assert!(read(&negative).links[1].inertial.is_none());
    // For a thin plate, one moment is the sum of the other two.
    let plate = changed("izz=\"2.5\" ixy=\"0.1\" ixz=\"0.2\" iyz=\"0.3\"", "izz=\"3\"");
    assert!(warned(&plate).is_empty());
    let upright = warned(&changed("ixx=\"1\"", "ixx=\"-1\""));
    assert!(upright[0].starts_with("15: the link \"arm\" has a negative moment of inertia, which is ignored; "));
    let long = warned(&changed("izz=\"2.5\"", "izz=\"30\""));
    assert!(long[0].starts_with(
        "15: the link \"arm\" has an inertia that is impossible for a body; expected each moment at most the sum"
    ));

    let of_mjcf = |inner: &str| {
        warned(&format!(
            "<mujoco><worldbody><body name=\"b\">\n{inner}</body></worldbody></mujoco>"
        ))
    };
    for (inner, expected) in [
        (
            "<inertial pos=\"0 0 0\" mass=\"-3\"/>",
            "2: the link \"b\" has a negative mass, ",
        ),
        (
            "<geom size=\"0.1\" mass=\"-3\"/>",
            "2: the link \"b\" has a negative mass, ",
        ),
        (
            "<geom size=\"0.1\" density=\"-3\"/>",
            "2: the link \"b\" has a negative density, ",
        ),
        (
            "<inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 3\"/>",
            "2: the link \"b\" has an inertia that is impossible for a body; expected each moment at most the sum of the other two; \
             found moments of 1.000e0, 1.000e0 and 3.000e0",
        ),
    ] {
        let found = of_mjcf(inner);
        assert!(found.len() == 1 && found[0].starts_with(expected), "{inner}: {found:?}");
    }
    assert!(of_mjcf("<geom size=\"0.1\" mass=\"0\"/>").is_empty());
}

fn survive(bytes: &[u8], what: &dyn Fn() -> String) {
    let Ok(robot) = Importer::new().read_robot(bytes, "hostile.xml") else {
        return;
    };
    let scene = robot_scene(&robot);
    let violations = scene.validate();
    assert!(violations.is_empty(), "{}: {violations:?}", what());
    if let Ok(bones) = robot_bones(&robot, None) {
        assert!(bones.iter().all(|bone| bone.link < robot.links.len()));
    }
}

#[test]
fn damaged_robots_are_an_error_or_a_valid_scene() {
    for text in [URDF, MJCF] {
        for length in 0..text.len() {
            survive(&text.as_bytes()[..length], &|| format!("the first {length} bytes"));
        }
        for position in 0..text.len() {
            let mut bytes = text.as_bytes().to_vec();
            for byte in *b"\0<>/\"' &-9e\xff" {
                bytes[position] = byte;
                survive(&bytes, &|| format!("byte {position} = {byte:#04x}"));
            }
        }
    }
}

/// Long repetitions of one element. Work that grew with the square of their length would take minutes instead of
/// seconds.
#[test]
fn large_robots_are_an_error_or_a_valid_scene() {
    let links: String = (0..8_000).map(|link| format!("<link name=\"l{link}\"/>")).collect();
    let joints: String = (1..8_000)
        .map(|link| {
            format!("<joint name=\"j{link}\" type=\"fixed\"><parent link=\"l0\"/><child link=\"l{link}\"/></joint>")
        })
        .collect();
    let nested = |depth: usize| {
        let open: String = (0..depth)
            .map(|body| format!("<body name=\"{body}\"><joint/>"))
            .collect();
        format!(
            "<mujoco><worldbody>{open}{}</worldbody></mujoco>",
            "</body>".repeat(depth)
        )
    };
    for text in [
        format!("<robot name=\"r\">{links}{joints}</robot>"),
        format!("<robot name=\"r\">{}</robot>", "<a>".repeat(200_000)),
        format!("<robot name=\"r\">{}</robot>", "<a/>".repeat(200_000)),
        format!(
            "<robot {}/>",
            (0..8_000).map(|index| format!("a{index}=\"\" ")).collect::<String>()
        ),
        nested(1000),
        nested(100_000),
        "<!DOCTYPE a [<!ENTITY b \"b\"><!ENTITY c \"&b;&b;&b;\">]><robot name=\"&c;\"/>".to_owned(),
    ] {
        survive(text.as_bytes(), &|| text[..40].to_owned());
    }
    let tight = Importer::new().limits(Limits::new().max_nodes(3));
    let error = tight.read_robot(URDF.as_bytes(), "robot.urdf").unwrap_err();
    assert_eq!(error.code(), Code::LimitExceeded);
}

/// A robot of three joints, each with the given contents.
fn tied(first: &str, second: &str, third: &str) -> String {
    let joint = |index: usize, inner: &str| {
        format!(
            "<link name=\"l{index}\"/>\n<joint name=\"j{index}\" type=\"revolute\"><parent link=\"l{}\"/><child link=\"l{index}\"/>\
             <limit lower=\"-1\" upper=\"2\" velocity=\"3\"/>{inner}</joint>\n",
            index - 1
        )
    };
    let joints = [joint(1, first), joint(2, second), joint(3, third)].concat();
    format!("<robot name=\"r\">\n<link name=\"l0\"/>\n{joints}</robot>")
}

fn mimic(joint: &str, rest: &str) -> String {
    format!("<mimic joint=\"{joint}\" {rest}/>")
}

#[test]
fn followers_are_tied_to_joints_that_are_free() {
    // j1 = -2 j2 + 0.5 and j2 = 0.5 j3, so j1 = -j3 + 0.5. j3 gets the limits of all: -1 <= 0.5 - j3 <= 2.
    let text = tied(
        &mimic("j2", "multiplier=\"-2\" offset=\"0.5\""),
        &mimic("j3", "multiplier=\"0.5\""),
        "",
    );
    let robot = read(&text);
    assert_eq!(robot.dof_names(), ["j1", "j2", "j3"]);
    let ties = [1, 2, 3].map(|link: usize| {
        let mimic = robot.links[link].joint.mimic;
        mimic.map(|mimic| (mimic.leader, mimic.multiplier, mimic.offset))
    });
    assert_eq!(ties, [Some((3, -1.0, 0.5)), Some((3, 0.5, 0.0)), None]);
    let free = robot.links[3].joint.limits;
    assert_eq!((free.lower, free.upper, free.velocity), (-1.0, 1.5, Some(3.0)));
    let own = robot.links[1].joint.limits;
    assert_eq!((own.lower, own.upper), (-1.0, 2.0));

    let unknown = tied("", &mimic("j9", ""), "");
    assert_eq!(read(&unknown).dof_names(), ["j1", "j2", "j3"]);
    assert!(read(&unknown).links[2].joint.mimic.is_none());
    let said = warned(&unknown);
    assert!(
        said[0].contains("no joint is called \"j9\", so this joint follows no joint"),
        "{said:?}"
    );
    for circle in [
        tied(&mimic("j1", ""), "", ""),
        tied(&mimic("j2", ""), &mimic("j3", ""), &mimic("j1", "")),
        tied(&mimic("j2", ""), &mimic("j2", ""), ""),
    ] {
        let error = refused(&circle);
        assert!(error.contains("in a circle"), "{error}");
    }
    let beyond = refused(&tied(&mimic("j2", "offset=\"9\""), "", ""));
    assert!(
        beyond.starts_with("invalid-robot 4: ") && beyond.contains("no position of the joint \"j2\""),
        "{beyond}"
    );
    assert!(refused(&tied("", &mimic("j1", "multiplier=\"x\""), "")).starts_with("invalid-number 6: "));
}

#[test]
fn equalities_of_mjcf_tie_joints() {
    let tie = |equality: &str| MJCF.replace("</mujoco>", &format!("\n<equality>{equality}</equality></mujoco>"));
    let robot = read(&tie("<joint joint1=\"b\" joint2=\"a\" polycoef=\"0.1 0.5 0 0 0\"/>"));
    let mimic = robot.links[2].joint.mimic.unwrap();
    assert_eq!((mimic.leader, mimic.multiplier, mimic.offset), (1, 0.5, 0.1));
    let upper = robot.links[1].joint.limits.upper;
    assert!((upper - (20_f64.to_radians() - 0.1) / 0.5).abs() < 1e-12, "{upper}");

    let curved = read(&tie("<joint joint1=\"b\" joint2=\"a\" polycoef=\"0 1 2\"/>"));
    assert_eq!((curved.links[2].joint.mimic, curved.warnings.len()), (None, 1));
    let off = read(&tie("<joint joint1=\"b\" joint2=\"a\" active=\"false\"/>"));
    assert_eq!((off.links[2].joint.mimic, off.warnings.len()), (None, 0));
    let unknown = refused(&tie("<joint joint1=\"b\" joint2=\"z\"/>"));
    assert!(unknown.contains("no moving joint is called \"z\""), "{unknown}");
}

#[test]
fn a_follower_keeps_its_tie_in_a_motion() {
    let text = fs::read_to_string("../../fixtures/robots/h1.urdf").unwrap();
    let start = text.find("<joint name=\"right_elbow_joint\"").unwrap();
    let end = start + text[start..].find("</joint>").unwrap();
    let tie = mimic("left_elbow_joint", "multiplier=\"0.5\" offset=\"0.2\"");
    let text = format!("{}{tie}{}", &text[..end], &text[end..]);
    let robot = read(&text);
    let names = robot.dof_names();
    let of = |name: &str| names.iter().position(|other| other == name).unwrap();
    let (leader, follower) = (of("left_elbow_joint"), of("right_elbow_joint"));
    let mut source = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
    let conversion = mocap::Conversion::new().first_frame(mocap::convert::FirstFrame::DropRestPose);
    conversion.frame_rate(6.0).apply(&mut source).unwrap();
    let mut retargeter = RobotRetargeter::new(&source, &robot, &RobotOptions::default()).unwrap();
    let (motion, report) = retargeter.clip(&source, 0).unwrap();
    assert_eq!(report.limit_violations, 0);
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for frame in 0..motion.frames() {
        let positions = motion.dof_of(frame);
        assert_eq!(positions[follower], 0.5 * positions[leader] + 0.2, "{frame}");
        least = least.min(positions[follower]);
        most = most.max(positions[follower]);
    }
    assert!(motion.frames() > 5 && most - least > 0.01, "{least} {most}");
}
