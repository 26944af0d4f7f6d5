//! Robots of many kinds, each built here: feet without a joint, tilted feet, meaningless inertia, fingers, upper
//! bodies.

use std::fmt::Write;

use mocap::glam::{DQuat, DVec3, Quat, Vec3};
use mocap::retarget::report::Verdict;
use mocap::retarget::robot::report::RobotReport;
use mocap::retarget::robot::{
    Robot, RobotMotion, RobotOptions, RobotRetargeter, RobotShape, ShapeKind, robot_bones, robot_scene,
};
use mocap::scene::HumanoidBone as Bone;
use mocap::{Binding, Importer, Pose};

use crate::robot_to_robot;
use crate::robot_walk::{on, points, walk};

/// The parts of a built robot.
#[derive(Clone, Copy)]
struct Kind {
    legs: bool,
    ankles: bool,
    /// The tilt of feet with all joints at 0, toes down, in radians. At 0, knees and hips are bent by the same angle.
    tilt: f64,
    /// Whether feet and forearms have shapes.
    soles: bool,
    forearms: bool,
    /// The inertia of feet, if the file states it.
    inertia: Option<f64>,
    fingers: bool,
}

const PLAIN: Kind = Kind {
    legs: true,
    ankles: true,
    tilt: 0.0,
    soles: true,
    forearms: true,
    inertia: None,
    fingers: false,
};

/// Writes links and joints.
#[derive(Default)]
struct Urdf(String);

impl Urdf {
    fn link(&mut self, name: &str, inside: &str) {
        let _ = writeln!(self.0, "<link name=\"{name}\">{inside}</link>");
    }

    fn joint(&mut self, name: &str, links: [&str; 2], at: [f64; 3], pitch: f64, axis: Option<&str>) {
        let [parent, child] = links;
        let [x, y, z] = at;
        let kind = if axis.is_some() { "revolute" } else { "fixed" };
        let axis = axis.map_or_else(String::new, |axis| {
            // Elbows and knees bend in one direction.
            let lower = if name.contains("elbow") || name.contains("knee") {
                -0.1
            } else {
                -2.6
            };
            format!("<axis xyz=\"{axis}\"/><limit lower=\"{lower}\" upper=\"2.6\" velocity=\"30\" effort=\"300\"/>")
        });
        let _ = writeln!(
            self.0,
            "<joint name=\"{name}\" type=\"{kind}\"><origin xyz=\"{x} {y} {z}\" rpy=\"0 {pitch} 0\"/>\
             <parent link=\"{parent}\"/><child link=\"{child}\"/>{axis}</joint>"
        );
    }
}

fn shape(at: &str, geometry: &str) -> String {
    format!("<collision><origin xyz=\"{at}\"/><geometry>{geometry}</geometry></collision>")
}

/// A robot of this kind with legs of 0.8 m and arms of 0.5 m, whose forearms have no hand.
fn robot(kind: Kind) -> Robot {
    let mut urdf = Urdf::default();
    urdf.link("pelvis", &shape("0 0 0", "<box size=\"0.1 0.2 0.1\"/>"));
    for (side, sign) in [("left", 1.0), ("right", -1.0)] {
        if kind.legs {
            leg(&mut urdf, kind, side, sign);
        }
        arm(&mut urdf, kind, side, sign);
    }
    urdf.link("torso", &shape("0 0 0.2", "<box size=\"0.1 0.2 0.3\"/>"));
    urdf.joint("waist_yaw", ["pelvis", "torso"], [0.0, 0.0, 0.1], 0.0, Some("0 0 1"));
    let text = format!("<robot name=\"built\">{}</robot>", urdf.0);
    Importer::new().read_robot(text.as_bytes(), "built.urdf").unwrap()
}

fn leg(urdf: &mut Urdf, kind: Kind, side: &str, sign: f64) {
    let named = |part: &str| format!("{side}_{part}");
    let [yaw, roll, thigh, shin, ankle, foot] =
        ["hip_yaw_link", "hip_roll_link", "thigh", "shin", "ankle", "foot"].map(named);
    for name in [&yaw, &roll, &thigh, &ankle] {
        urdf.link(name, "");
    }
    let sole = shape("0.04 0 -0.05", "<box size=\"0.2 0.08 0.02\"/>");
    let sole = if kind.soles { sole.as_str() } else { "" };
    let inertial = kind.inertia.map_or_else(String::new, |value| {
        format!("<inertial><mass value=\"0.1\"/><inertia ixx=\"{value}\" iyy=\"{value}\" izz=\"{value}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>")
    });
    urdf.link(&foot, &format!("{sole}{inertial}"));
    urdf.link(&shin, &shape("0 0 -0.2", "<cylinder radius=\"0.04\" length=\"0.36\"/>"));
    let joint = |name: &str| format!("{side}_{name}_joint");
    let (x, y, z) = ("1 0 0", "0 1 0", "0 0 1");
    urdf.joint(
        &joint("hip_yaw"),
        ["pelvis", &yaw],
        [0.0, 0.1 * sign, 0.0],
        0.0,
        Some(z),
    );
    urdf.joint(&joint("hip_roll"), [&yaw, &roll], [0.0; 3], 0.0, Some(x));
    // The thigh is tilted forward and the shin back, both by the tilt of the foot.
    urdf.joint(&joint("hip_pitch"), [&roll, &thigh], [0.0; 3], -kind.tilt, Some(y));
    urdf.joint(
        &joint("knee"),
        [&thigh, &shin],
        [0.0, 0.0, -0.4],
        2.0 * kind.tilt,
        Some(y),
    );
    if kind.ankles {
        urdf.joint(&joint("ankle_pitch"), [&shin, &ankle], [0.0, 0.0, -0.4], 0.0, Some(y));
        urdf.joint(&joint("ankle_roll"), [&ankle, &foot], [0.0; 3], 0.0, Some(x));
    } else {
        urdf.joint(&joint("ankle_pitch"), [&shin, &ankle], [0.0, 0.0, -0.4], 0.0, None);
        urdf.joint(&joint("ankle_roll"), [&ankle, &foot], [0.0; 3], 0.0, None);
    }
}

fn arm(urdf: &mut Urdf, kind: Kind, side: &str, sign: f64) {
    let named = |part: &str| format!("{side}_{part}");
    let [pitch, roll, upper, fore] = ["shoulder_pitch_link", "shoulder_roll_link", "upper_arm", "forearm"].map(named);
    for name in [&pitch, &roll, &upper] {
        urdf.link(name, "");
    }
    let tube = shape("0 0 -0.12", "<cylinder radius=\"0.03\" length=\"0.24\"/>");
    urdf.link(&fore, if kind.forearms { &tube } else { "" });
    let joint = |name: &str| format!("{side}_{name}_joint");
    let (x, y, z) = ("1 0 0", "0 1 0", "0 0 1");
    urdf.joint(
        &joint("shoulder_pitch"),
        ["torso", &pitch],
        [0.0, 0.15 * sign, 0.35],
        0.0,
        Some(y),
    );
    urdf.joint(&joint("shoulder_roll"), [&pitch, &roll], [0.0; 3], 0.0, Some(x));
    urdf.joint(&joint("shoulder_yaw"), [&roll, &upper], [0.0; 3], 0.0, Some(z));
    urdf.joint(&joint("elbow"), [&upper, &fore], [0.0, 0.0, -0.25], 0.0, Some("0 -1 0"));
    if !kind.fingers {
        return;
    }
    let palm = format!("{side}_palm");
    urdf.link(&palm, "");
    urdf.joint(&joint("wrist_yaw"), [&fore, &palm], [0.0, 0.0, -0.24], 0.0, Some(z));
    for (finger, across) in [("index", 0.03), ("ring", -0.03)] {
        let mut above = palm.clone();
        for part in 0..3 {
            let link = format!("{side}_{finger}_{part}");
            urdf.link(&link, "");
            let at = if part == 0 {
                [across, 0.0, -0.05]
            } else {
                [0.0, 0.0, -0.03]
            };
            urdf.joint(&format!("{link}_joint"), [&above, &link], at, 0.0, Some(x));
            above = link;
        }
    }
}

/// The corners of the sole, in the axes of the foot.
fn sole() -> Vec<Vec3> {
    let ends = [(-0.06, 0.04), (-0.06, -0.04), (0.14, 0.04), (0.14, -0.04)];
    ends.map(|(x, y)| Vec3::new(x, y, -0.06)).to_vec()
}

fn criterion(report: &RobotReport, name: &str) -> Option<f64> {
    let found = report.criteria.iter().find(|criterion| criterion.name == name);
    found.map(|criterion| criterion.value)
}

fn keeps_above_the_floor(robot: &Robot, motion: &RobotMotion) {
    for side in ["left", "right"] {
        let heights = points(robot, motion, &format!("{side}_foot"), &sole());
        let lowest = heights
            .iter()
            .flatten()
            .map(|point| point.z)
            .fold(f32::INFINITY, f32::min);
        assert!(lowest > -0.01, "{side} {lowest}");
        // The robot does not float: in a quarter of the frames, the foot is within 2 cm of the floor.
        let least = heights
            .iter()
            .map(|frame| frame.iter().map(|point| point.z).fold(f32::INFINITY, f32::min));
        assert!(least.filter(|height| *height < 0.02).count() > motion.frames() / 4);
    }
}

#[test]
fn a_foot_without_an_ankle_is_what_is_fixed_to_the_shin() {
    let built = robot(Kind { ankles: false, ..PLAIN });
    let bones = robot_bones(&built, None).unwrap();
    let foot = bones.iter().find(|bone| bone.bone == Bone::LeftFoot).unwrap();
    assert!(foot.joints.is_empty());
    assert!((foot.at - DVec3::new(0.0, 0.1, -0.8)).length() < 1e-9, "{}", foot.at);
    let (motion, report) = on(&built, &walk());
    keeps_above_the_floor(&built, &motion);
    assert!(report.mean_degrees < 5.0 && report.guessed.is_empty(), "{report:?}");
}

#[test]
fn a_foot_may_be_a_part_of_the_shin() {
    let text = r#"<mujoco><worldbody><body name="pelvis"><freejoint/><geom size="0.1"/>
        SIDE
      </body></worldbody></mujoco>"#;
    let leg = |side: &str, y: f64| {
        format!(
            r#"<body name="{side}_thigh" pos="0 {y} 0"><joint name="{side}_hip_x" axis="1 0 0"/><joint name="{side}_hip_z"/>
            <joint name="{side}_hip_y" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.05"/>
            <body name="{side}_shin" pos="0 0 -0.4"><joint name="{side}_knee" axis="0 1 0" range="0 150"/>
            <geom type="capsule" fromto="0 0 0 0 0 -0.35" size="0.05"/></body></body>"#
        )
    };
    let text = text.replace("SIDE", &(leg("left", 0.1) + &leg("right", -0.1)));
    let robot = Importer::new().read_robot(text.as_bytes(), "legs.xml").unwrap();
    let bones = robot_bones(&robot, None).unwrap();
    let find = |bone: Bone| bones.iter().find(|found| found.bone == bone).unwrap();
    assert_eq!(find(Bone::LeftFoot).link, find(Bone::LeftLowerLeg).link);
    assert!((find(Bone::LeftFoot).at - DVec3::new(0.0, 0.1, -0.8)).length() < 1e-9);
    assert_eq!(
        robot_scene(&robot).nodes[find(Bone::LeftFoot).link].humanoid_bone,
        Some(Bone::LeftLowerLeg)
    );
    let (motion, report) = on(&robot, &walk());
    assert_eq!(report.limit_violations, 0);
    for side in ["left", "right"] {
        // The centre of the ball at the end of the shin.
        let ends = points(&robot, &motion, &format!("{side}_shin"), &[Vec3::new(0.0, 0.0, -0.35)]);
        let lowest = ends.iter().map(|frame| frame[0].z - 0.05).fold(f32::INFINITY, f32::min);
        assert!((-0.01..0.02).contains(&lowest), "{side} {lowest}");
    }
}

#[test]
fn tilted_feet_stand_on_their_whole_sole() {
    let built = robot(Kind { tilt: 0.3, ..PLAIN });
    let (motion, report) = on(&built, &walk());
    keeps_above_the_floor(&built, &motion);
    assert!(report.mean_degrees < 5.0, "{}", report.mean_degrees);
    // The feet are as flat as the feet of the robot without a tilt. The test compares the heights of the corners in
    // stance.
    let tilts = |robot: &Robot, motion: &RobotMotion| {
        let frames = points(robot, motion, "left_foot", &sole())
            .into_iter()
            .zip(&motion.contacts);
        let standing = frames.filter(|(_, contacts)| contacts[0]).map(|(corners, _)| {
            let heights = corners.iter().map(|corner| corner.z);
            heights.clone().fold(f32::NEG_INFINITY, f32::max) - heights.fold(f32::INFINITY, f32::min)
        });
        let standing: Vec<f32> = standing.collect();
        assert!(standing.len() > 10);
        standing.iter().sum::<f32>() / standing.len() as f32
    };
    let plain = robot(PLAIN);
    let (as_plain, _) = on(&plain, &walk());
    let [tilted, flat] = [tilts(&built, &motion), tilts(&plain, &as_plain)];
    assert!((tilted - flat).abs() < 0.01, "{tilted} {flat}");
}

#[test]
fn inertia_that_no_foot_has_shows_no_sole() {
    let without = robot(Kind { soles: false, ..PLAIN });
    let placeholder = robot(Kind {
        soles: false,
        inertia: Some(1.0),
        ..PLAIN
    });
    let source = walk();
    let ((a, _), (b, report)) = (on(&without, &source), on(&placeholder, &source));
    assert_eq!(a.dof_pos, b.dof_pos);
    assert_eq!(criterion(&report, "guessed_parts"), Some(2.0));
}

#[test]
fn shapes_show_where_a_forearm_without_mass_points() {
    let source = walk();
    let (_, shown) = on(&robot(PLAIN), &source);
    assert_eq!(criterion(&shown, "unmeasured_limbs"), Some(0.0));
    let arms = shown
        .limbs
        .iter()
        .filter(|limb| limb.bone.as_str().ends_with("LowerArm"));
    assert!(arms.clone().count() == 2 && arms.clone().all(|limb| limb.mean_degrees < 10.0));
    let (_, hidden) = on(
        &robot(Kind {
            forearms: false,
            ..PLAIN
        }),
        &source,
    );
    assert_eq!(criterion(&hidden, "unmeasured_limbs"), Some(2.0));
}

#[test]
fn fingers_are_no_limbs_and_stay() {
    let built = robot(Kind { fingers: true, ..PLAIN });
    let bones = robot_bones(&built, None).unwrap();
    let link = |bone: Bone| {
        let found = bones.iter().find(|found| found.bone == bone).unwrap();
        built.links[found.link].name.as_str()
    };
    assert_eq!(
        [Bone::LeftFoot, Bone::RightHand, Bone::LeftLowerArm].map(link),
        ["left_foot", "right_palm", "left_forearm"]
    );
    let (motion, report) = on(&built, &walk());
    assert!(report.mean_degrees < 5.0);
    for (index, name) in motion.dof_names.iter().enumerate() {
        if name.contains("index") || name.contains("ring") {
            assert!(
                (0..motion.frames()).all(|frame| motion.dof_of(frame)[index] == 0.0),
                "{name}"
            );
        }
    }
}

#[test]
fn an_upper_body_moves_its_arms_wherever_its_source_faces() {
    let built = robot(Kind { legs: false, ..PLAIN });
    let source = walk();
    let (motion, report) = on(&built, &source);
    assert!(motion.root.iter().all(|root| *root == motion.root[0]));
    // The box of the base stands on the floor.
    assert!((motion.root[0].translation - DVec3::new(0.0, 0.0, 0.05)).length() < 1e-9);
    assert_eq!(report.limbs.len(), 4);
    assert!(report.mean_degrees < 5.0, "{}", report.mean_degrees);
    assert_eq!(
        report.left_out,
        ["legs", "the path over the floor", "turns of the whole body"]
    );
    assert!(report.dynamics.is_none() && report.skate.is_none() && report.fraction_floating.is_none());
    let mut turned = source.clone();
    let root = turned.nodes[0].name.clone();
    for animation in &mut turned.animations {
        let about = Quat::from_rotation_y(2.0);
        let channel = animation
            .channels
            .iter_mut()
            .find(|channel| channel.node_name == root)
            .unwrap();
        let rotations = channel.rotation_keys.values.iter().map(|rotation| about * *rotation);
        channel.rotation_keys = mocap::scene::Keys::every_tick(rotations.collect());
        let positions = channel.position_keys.values.iter().map(|position| about * *position);
        channel.position_keys = mocap::scene::Keys::every_tick(positions.collect());
    }
    let (other, _) = on(&built, &turned);
    let apart = motion.dof_pos.iter().zip(&other.dof_pos).map(|(a, b)| (a - b).abs());
    let apart = apart.fold(0.0, f64::max);
    assert!(apart < 0.02, "{apart}");
}

/// Arms that go through the trunk, as from a solver without collisions: points of the forearm are within the box of the
/// torso.
#[test]
fn arms_within_the_trunk_are_not_good() {
    let mut source = walk();
    for (joint, turn) in [
        ("LeftArm", -1.9),
        ("RightArm", 1.9),
        ("LeftForeArm", 0.0),
        ("RightForeArm", 0.0),
    ] {
        // In the rest pose, the arms point sideways. The test moves them down and across the body.
        let channels = &mut source.animations[0].channels;
        let channel = channels.iter_mut().find(|channel| channel.node_name == joint).unwrap();
        channel.rotation_keys.values.fill(Quat::from_rotation_z(turn));
    }
    let robot = robot(PLAIN);
    let options = RobotOptions::new().passes(1);
    let (motion, report) = RobotRetargeter::new(&source, &robot, &options)
        .unwrap()
        .clip(&source, 0)
        .unwrap();
    let along: Vec<Vec3> = (0..=24).map(|step| Vec3::NEG_Z * 0.01 * step as f32).collect();
    let (scene, animation) = (robot_scene(&robot), motion.to_animation(&robot));
    let link = |name: &str| scene.nodes.iter().position(|node| node.name == name).unwrap();
    let [torso, forearm] = [link("torso"), link("left_forearm")];
    let binding = Binding::new(&scene, &animation);
    let mut pose = Pose::rest(&scene);
    let inside = (0..motion.frames()).filter(|frame| {
        pose.sample(&binding, &animation, *frame as f64);
        let to_torso = pose.node_to_world[torso].inverse() * pose.node_to_world[forearm];
        along.iter().any(|point| {
            let from_middle = to_torso.transform_point3(*point) - Vec3::Z * 0.2;
            from_middle.abs().cmplt(Vec3::new(0.05, 0.1, 0.15)).all()
        })
    });
    let share = inside.count() as f64 / motion.frames() as f64;
    let seen = criterion(&report, "fraction_in_self_collision").unwrap();
    assert!(share > 0.5, "the arm is not in the trunk: {share}");
    assert!(
        seen >= share - 0.05 && report.verdict == Verdict::Poor,
        "{seen} {share}"
    );
}

/// By hand: a ball of 0.1 m and 1,000 kg/m3, and a rod of 2 kg. The rod is a cylinder of 0.05 m and 0.4 m, 0.3 m above
/// the ball.
#[test]
fn geoms_have_the_mass_of_a_body() {
    let text = r#"<mujoco><worldbody><body name="b"><freejoint/><geom size="0.1"/>
      <geom type="cylinder" size="0.05 0.2" pos="0 0 0.3" mass="2"/><geom size="1" group="7"/><geom size="1" density="0"/>
    </body></worldbody></mujoco>"#;
    let robot = Importer::new().read_robot(text.as_bytes(), "masses.xml").unwrap();
    let found = robot.links[0].inertial.unwrap();
    let ball = 1000.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.001;
    let mass = ball + 2.0;
    assert!((found.mass - mass).abs() < 1e-9);
    let centre = 2.0 * 0.3 / mass;
    assert!((found.origin.translation - DVec3::Z * centre).length() < 1e-9);
    let rod = 2.0 * (3.0 * 0.0025 + 0.16) / 12.0;
    let across = 0.4 * ball * 0.01 + ball * centre.powi(2) + rod + 2.0 * (0.3 - centre).powi(2);
    let along = 0.4 * ball * 0.01 + 0.5 * 2.0 * 0.0025;
    for (found, wanted) in found.inertia.into_iter().zip([across, across, along, 0.0, 0.0, 0.0]) {
        assert!((found - wanted).abs() < 1e-12, "{found} {wanted}");
    }
    let total = text.replace("<worldbody>", "<compiler settotalmass=\"10\"/><worldbody>");
    let robot = Importer::new().read_robot(total.as_bytes(), "masses.xml").unwrap();
    assert!((robot.links[0].inertial.unwrap().mass - 10.0).abs() < 1e-12);
    let never = text.replace("<worldbody>", "<compiler inertiafromgeom=\"false\"/><worldbody>");
    assert!(
        Importer::new()
            .read_robot(never.as_bytes(), "masses.xml")
            .unwrap()
            .links[0]
            .inertial
            .is_none()
    );
}

/// A robot that stands straight is pushed along the floor. The frames with a foot in the air and a sole that is near
/// the floor and fast are counted by hand.
#[test]
fn a_sole_that_moves_along_the_floor_scrapes() {
    let (built, source) = (robot(PLAIN), walk());
    let mut retargeter = RobotRetargeter::new(&source, &built, &RobotOptions::default()).unwrap();
    let (own, _) = retargeter.clip(&source, 0).unwrap();
    let swings = |frame: usize| {
        let feet = std::iter::zip(own.contacts[frame], own.contacts[frame + 1]);
        feet.filter(|(before, after)| !before && !after).count()
    };
    let last = own.frames() - 1;
    let all: usize = (0..last).map(swings).sum();
    let pushed = 0..last / 3;
    let in_part: usize = pushed.clone().map(swings).sum();
    assert!(in_part > 0 && in_part < all, "{in_part} {all}");
    let part = in_part as f64 / all as f64;
    for (speed, height, wanted) in [(0.4, 0.0, part), (0.2, 0.0, 0.0), (0.4, 0.006, 0.0), (0.4, 0.004, part)] {
        let mut motion = own.clone();
        motion.dof_pos.fill(0.0);
        for (frame, root) in motion.root.iter_mut().enumerate() {
            root.rotation = DQuat::IDENTITY;
            // The soles are 0.86 m below the pelvis.
            let along = speed * frame.min(pushed.end) as f64 / motion.fps;
            root.translation = DVec3::new(along, 0.0, 0.86 + height);
        }
        let report = retargeter.judge(&source, 0, &motion).unwrap();
        let found = report.fraction_scraping.unwrap();
        assert!((found - wanted).abs() < 1e-12, "{speed} {height}: {found} {wanted}");
        assert_eq!(criterion(&report, "fraction_scraping"), report.fraction_scraping);
    }
}

/// G1's URDF has 24 links with collision meshes, whose files are not here. H1's URDF has its collision shapes.
#[test]
fn meshes_that_are_not_read_are_guessed_parts() {
    let on_file = |name: &str, change: &dyn Fn(&mut Robot)| {
        let mut robot = robot_to_robot::robot(name);
        change(&mut robot);
        on(&robot, &walk()).1
    };
    // The first links get meshes of 4 cm.
    let with_meshes = |robot: &mut Robot, count: usize| {
        let is_unread = |shape: &RobotShape| shape.collides && matches!(shape.kind, ShapeKind::Mesh { .. });
        let links = robot.links.iter_mut().filter(|link| link.shapes.iter().any(is_unread));
        for shape in links.take(count).flat_map(|link| &mut link.shapes) {
            if let ShapeKind::Mesh { bounds, .. } = &mut shape.kind {
                *bounds = Some([DVec3::splat(-0.02), DVec3::splat(0.02)]);
            }
        }
    };
    let report = on_file("g1_29dof_rev_1_0.urdf", &|_| {});
    assert_eq!(
        report.guessed,
        ["the shapes of 24 links, whose mesh files could not be read"]
    );
    assert_eq!(criterion(&report, "guessed_parts"), Some(1.0));
    assert_ne!(report.verdict, Verdict::Good);
    let report = on_file("g1_29dof_rev_1_0.urdf", &|robot| with_meshes(robot, 23));
    let [guess] = report.guessed.as_slice() else {
        panic!("{:?}", report.guessed);
    };
    assert!(
        guess.starts_with("the shape of ") && guess.ends_with(", whose mesh file could not be read"),
        "{guess}"
    );
    let report = on_file("g1_29dof_rev_1_0.urdf", &|robot| with_meshes(robot, 24));
    assert!(report.guessed.is_empty(), "{:?}", report.guessed);
    let report = on_file("h1.urdf", &|_| {});
    assert!(report.guessed.is_empty(), "{:?}", report.guessed);
}
