//! A dog on generated robots with four legs. The scene of the robot gives the positions of feet.

use std::sync::LazyLock;

use mocap::Scene;
use mocap::figure::Figure;
use mocap::glam::Vec3;
use mocap::retarget::report::Verdict;
use mocap::retarget::robot::report::{RobotReport, TimeScale};
use mocap::retarget::robot::{Robot, RobotMotion};
use mocap::retarget::{RetargetOptions, Retargeter};
use mocap::{Binding, Pose};
use mocap_figure::robot_bones::moving::scene_of_clips;

use crate::robot_walk::points;

const FEET: [&str; 4] = ["FL_foot", "FR_foot", "HL_foot", "HR_foot"];

/// The radius of the feet, in metres, as of small robots.
const RADIUS: f32 = 0.02;

/// The length of thighs and of shins, in metres, as of small robots.
const THIGH: f32 = 0.21;

/// The limits of a knee that bends only backward, only forward, or to both sides. The axis points to the right, so a
/// positive angle swings the lower leg forward.
const BACKWARD: [f64; 2] = [0.0, 2.6];
const FORWARD: [f64; 2] = [-2.6, 0.0];
const BOTH: [f64; 2] = [-2.6, 2.6];

/// A robot with four legs whose joints have this velocity limit.
fn robot(knee: [f64; 2], velocity: f64) -> Robot {
    let mut text = String::from(
        r#"<robot name="four"><link name="base"><inertial><mass value="8"/>
            <inertia ixx="0.1" iyy="0.3" izz="0.3" ixy="0" ixz="0" iyz="0"/></inertial></link>"#,
    );
    for (leg, x, y) in [
        ("FL", 0.2, 0.1),
        ("FR", 0.2, -0.1),
        ("HL", -0.2, 0.1),
        ("HR", -0.2, -0.1),
    ] {
        let mut part = |name: &str, parent: &str, at: [f64; 3], axis: &str, limits: Option<[f64; 2]>, shape: &str| {
            let [px, py, pz] = at;
            let kind = if limits.is_some() { "revolute" } else { "fixed" };
            let [lower, upper] = limits.unwrap_or_default();
            text += &format!(
                r#"<link name="{name}">{shape}</link><joint name="{name}_joint" type="{kind}"><parent link="{parent}"/>
                <child link="{name}"/><origin xyz="{px} {py} {pz}"/><axis xyz="{axis}"/>
                <limit lower="{lower}" upper="{upper}" velocity="{velocity}" effort="40"/></joint>"#
            );
        };
        let foot = format!(r#"<collision><geometry><sphere radius="{RADIUS}"/></geometry></collision>"#);
        let [hip, thigh, shin, foot_name] = ["hip", "thigh", "shin", "foot"].map(|part| format!("{leg}_{part}"));
        part(&hip, "base", [x, y, 0.0], "1 0 0", Some([-0.8, 0.8]), "");
        part(&thigh, &hip, [0.0, 0.3 * y, 0.0], "0 -1 0", Some([-2.5, 2.5]), "");
        part(&shin, &thigh, [0.0, 0.0, -f64::from(THIGH)], "0 -1 0", Some(knee), "");
        part(&foot_name, &shin, [0.0, 0.0, -f64::from(THIGH)], "0 0 1", None, &foot);
    }
    text += "</robot>";
    mocap::Importer::new().read_robot(text.as_bytes(), "four.urdf").unwrap()
}

static DOG: LazyLock<Scene> = LazyLock::new(|| mocap::import("../../fixtures/made/dog_walk.bvh").unwrap());

fn on(robot: &Robot) -> (RobotMotion, RobotReport) {
    of(DOG.clone(), robot)
}

fn of(source: Scene, robot: &Robot) -> (RobotMotion, RobotReport) {
    let retargeter = Retargeter::new(source, robot.clone(), RetargetOptions::new()).unwrap();
    let clip = retargeter.into_clips().remove(0);
    (clip.robot_motion.unwrap(), clip.report.robot().unwrap().clone())
}

fn refused(source: Scene, robot: Robot) -> String {
    Retargeter::new(source, robot, RetargetOptions::new())
        .unwrap_err()
        .to_string()
}

#[test]
fn a_dog_walks_on_a_robot_within_its_limits() {
    let robot = robot(BOTH, 9.0);
    let (motion, report) = on(&robot);
    assert_eq!((motion.frames(), report.limit_violations), (60, 0));
    for (dof, link) in robot.moving_joints().into_iter().enumerate() {
        let limits = &robot.links[link].joint.limits;
        let values: Vec<f64> = (0..60).map(|frame| motion.dof_of(frame)[dof]).collect();
        assert!(values.iter().all(|value| (limits.lower..=limits.upper).contains(value)));
        let fastest = values.windows(2).map(|pair| (pair[1] - pair[0]).abs() * motion.fps);
        assert!(fastest.fold(0.0, f64::max) <= 9.0 + 1e-9);
    }
    let feet = FEET.map(|foot| points(&robot, &motion, foot, &[Vec3::ZERO]));
    let lowest = feet
        .iter()
        .flatten()
        .map(|points| points[0].z - RADIUS)
        .fold(f32::MAX, f32::min);
    assert!(lowest > -1e-3, "{lowest}");
    let (_, contacts) = motion.contacts_of_feet();
    assert_eq!(contacts.len(), 4 * motion.frames());
    for (foot, track) in feet.iter().enumerate() {
        let stands = |frame: usize| contacts[4 * frame + foot];
        let held: Vec<usize> = (1..60).filter(|frame| stands(*frame) && stands(frame - 1)).collect();
        assert!((8..55).contains(&held.len()), "{}: {}", FEET[foot], held.len());
        let slid: f32 = held
            .iter()
            .map(|frame| (track[*frame][0] - track[frame - 1][0]).truncate().length())
            .sum();
        // 2 mm per frame are 6 cm/s. A dog of this size walks at 100 cm/s.
        assert!(slid < 0.002 * held.len() as f32, "{}: {slid}", FEET[foot]);
        let lifted = track.iter().map(|points| points[0].z).fold(f32::MIN, f32::max);
        assert!(lifted > RADIUS + 0.02, "{}: {lifted}", FEET[foot]);
    }
}

/// A robot with the joints of an animal: ankles and paws, and three joints in each of five parts of a spine. The front
/// legs are on the base, and the hind legs are on the end of the spine. If `with_blades`, each hip has three hinges, each
/// ankle has two, and three hinges that lie apart carry each front leg, as in dm_control's dog.
fn animal_robot(with_blades: bool) -> Robot {
    let mut text = format!(r#"<robot name="dog, blades: {with_blades}"><link name="base"/>"#);
    let mut part = |name: &str, parent: &str, at: [f64; 3], axis: &str, [lower, upper]: [f64; 2], shape: &str| {
        let [x, y, z] = at;
        text += &format!(
            r#"<link name="{name}">{shape}</link><joint name="{name}_joint" type="revolute"><parent link="{parent}"/>
            <child link="{name}"/><origin xyz="{x} {y} {z}"/><axis xyz="{axis}"/>
            <limit lower="{lower}" upper="{upper}" velocity="0" effort="0"/></joint>"#
        );
    };
    let mut parent = "base".to_owned();
    for index in 0..5 {
        for (name, axis, x) in [
            ("bend", "0 0 1", -0.06),
            ("extend", "0 1 0", 0.0),
            ("twist", "1 0 0", 0.0),
        ] {
            let name = format!("{name}_{index}");
            part(&name, &parent, [x, 0.0, 0.0], axis, [-0.4, 0.4], "");
            parent = name;
        }
    }
    let paw = r#"<collision><origin xyz="0.02 0 -0.01"/><geometry><sphere radius="0.01"/></geometry></collision>"#;
    for (leg, trunk, x, y) in [
        ("FL", "base", 0.06, 0.07),
        ("FR", "base", 0.06, -0.07),
        ("HL", parent.as_str(), -0.06, 0.07),
        ("HR", parent.as_str(), -0.06, -0.07),
    ] {
        let [hip, thigh, shin, foot, toe] = ["hip", "thigh", "shin", "foot", "toe"].map(|name| format!("{leg}_{name}"));
        let mut above = trunk.to_owned();
        let blades = [
            ("supinate", [x - 0.03, 0.0, 0.13], "0 0 1"),
            ("abduct", [0.03, 0.5 * y, -0.07], "1 0 0"),
            ("extend", [0.0, -0.3 * y, 0.07], "0 1 0"),
        ];
        for (name, at, axis) in blades.iter().filter(|_| with_blades && x > 0.0) {
            let blade = format!("{leg}_scapula_{name}");
            part(&blade, &above, *at, axis, [-0.3, 0.3], "");
            above = blade;
        }
        let at = match above == trunk {
            true => [x, y, 0.0],
            false => [0.0, 0.8 * y, -0.13],
        };
        part(&hip, &above, at, "1 0 0", [-0.5, 0.5], "");
        let mut above = hip;
        if with_blades {
            let twist = format!("{leg}_twist");
            part(&twist, &above, [0.0; 3], "0 0 1", [-0.3, 0.3], "");
            above = twist;
        }
        part(&thigh, &above, [0.0, 0.0, 0.0], "0 -1 0", [-1.5, 1.5], "");
        part(&shin, &thigh, [0.0, 0.0, -0.16], "0 -1 0", [-2.2, 2.2], "");
        let (mut above, mut at) = (shin, [0.0, 0.0, -0.15]);
        if with_blades {
            let anchor = format!("{leg}_anchor");
            part(&anchor, &above, at, "0 0 1", [-0.1, 0.1], "");
            (above, at) = (anchor, [0.0; 3]);
        }
        part(&foot, &above, at, "0 -1 0", [-2.2, 2.2], "");
        part(&toe, &foot, [0.0, 0.0, -0.06], "0 -1 0", [-1.5, 1.5], paw);
    }
    text += "</robot>";
    mocap::Importer::new().read_robot(text.as_bytes(), "dog.urdf").unwrap()
}

/// The many joints of the spine leave the pose open. Paws in stance still keep their place, and joints do not jump.
#[test]
fn a_robot_with_the_legs_of_an_animal_moves_steadily() {
    let robot = animal_robot(false);
    let (motion, _) = on(&robot);
    let (_, contacts) = motion.contacts_of_feet();
    for (foot, leg) in ["FL", "FR", "HL", "HR"].into_iter().enumerate() {
        let track = points(&robot, &motion, &format!("{leg}_toe"), &[Vec3::ZERO]);
        let stands = |frame: usize| contacts[4 * frame + foot];
        let held: Vec<usize> = (1..60).filter(|frame| stands(*frame) && stands(frame - 1)).collect();
        let steps = held.iter().map(|frame| track[*frame][0].distance(track[frame - 1][0]));
        let slid: f32 = steps.sum();
        // 5 mm per frame are 15 cm/s. The toe also rolls over the paw.
        assert!(slid < 0.005 * held.len() as f32, "{leg}: {slid} in {}", held.len());
    }
    let joints = motion.dof_names.len();
    let steps = motion.dof_pos.iter().zip(&motion.dof_pos[joints..]);
    let fastest = steps.map(|(before, after)| (after - before).abs()).fold(0.0, f64::max);
    // 0.6 rad per frame are 18 rad/s.
    assert!(fastest < 0.6, "{fastest}");
}

/// +X is forward for a robot, whatever the order and the names of the links in its file.
#[test]
fn legs_of_a_robot_are_front_and_hind_by_its_axes() {
    let mut robot = robot(BOTH, 9.0);
    let named = FEET.map(|foot| foot.replace("foot", "thigh"));
    for numbered in [false, true] {
        if numbered {
            for (index, link) in robot.links.iter_mut().enumerate() {
                link.name = format!("link_{index:02}");
            }
        }
        let scene = mocap_figure::robot_bones::robot_scene(&robot);
        let found = Figure::new(&scene).quadruped(&scene).unwrap().clone();
        let at = |node: mocap::scene::NodeId| Pose::rest(&scene).position(node);
        for (leg, name) in found.legs.iter().zip(&named) {
            let hip = at(leg.upper);
            assert_eq!(
                (hip.x > 0.0, hip.y > 0.0),
                (leg.is_fore, leg.as_str().starts_with("left")),
                "{hip}"
            );
            assert!(numbered || scene.nodes[leg.upper.index()].name == *name, "{name}");
        }
    }
}

/// A robot's motion, retargeted to the same robot, does not change, whatever up axis its scene has.
#[test]
fn a_motion_of_the_same_robot_stays() {
    for robot in [robot(BOTH, 9.0), animal_robot(false), animal_robot(true)] {
        let (motion, _) = on(&robot);
        let mut scene = scene_of_clips(&robot, vec![motion.to_animation(&robot)]);
        mocap::Conversion::new().apply(&mut scene).unwrap();
        let (again, report) = of(scene, &robot);
        for (own, found) in motion.dof_pos.iter().zip(&again.dof_pos) {
            assert!((own - found).abs() < 1e-3, "{}: {own} {found}", robot.name);
        }
        for (own, found) in motion.root.iter().zip(&again.root) {
            assert!(own.translation.distance(found.translation) < 1e-3);
            assert!(own.rotation.angle_between(found.rotation) < 1e-3);
        }
        assert_eq!(report.scale, 1.0);
        for limb in &report.limbs {
            assert!(limb.mean_degrees < 0.5, "{}: {limb:?}", robot.name);
        }
        // Feet and forces are measured in the motion itself, so the other criteria may differ.
        let directions = report.criteria.iter().filter(|found| found.name.ends_with("degrees"));
        let verdicts: Vec<Verdict> = directions.map(|found| found.verdict).collect();
        assert!(
            verdicts.len() > 1 && verdicts.iter().all(|verdict| *verdict == Verdict::Good),
            "{report}"
        );
    }
}

/// The legs of another robot point where the legs of the moving robot point, relative to its base.
#[test]
fn a_motion_of_one_robot_moves_to_another() {
    let (from, to) = (animal_robot(true), robot(BOTH, 30.0));
    let (motion, _) = on(&from);
    let mut scene = scene_of_clips(&from, vec![motion.to_animation(&from)]);
    mocap::Conversion::new().apply(&mut scene).unwrap();
    let (moved, _) = of(scene, &to);
    let legs = |robot: &Robot, motion: &RobotMotion, leg: &str, end: &str| -> Vec<Vec3> {
        let [hips, feet] = ["thigh", end].map(|part| points(robot, motion, &format!("{leg}_{part}"), &[Vec3::ZERO]));
        let vectors = hips.iter().zip(&feet).zip(&motion.root);
        vectors
            .map(|((hip, foot), root)| root.rotation.as_quat().inverse() * (foot[0] - hip[0]))
            .collect()
    };
    for leg in ["FL", "FR", "HL", "HR"] {
        let (was, is) = (legs(&from, &motion, leg, "toe"), legs(&to, &moved, leg, "foot"));
        let angles = was.iter().zip(&is).map(|(was, is)| was.angle_between(*is).to_degrees());
        let mean = angles.sum::<f32>() / was.len() as f32;
        assert!(mean < 10.0, "{leg}: {mean}");
    }
}

/// The base follows the path of the dog's hips and shoulders, scaled by the factor in the report. Each foot is in front
/// of its hip when the paw is in front of the dog's hip.
#[test]
fn base_and_feet_go_where_trunk_and_paws_go() {
    let robot = robot(BOTH, 30.0);
    let (motion, report) = on(&robot);
    let figure = Figure::new(&DOG);
    let dog = figure.quadruped(&DOG).unwrap();
    let animation = &DOG.animations[0];
    let binding = Binding::new(&DOG, animation);
    let mut pose = Pose::rest(&DOG);
    let metres = 0.01;
    let mut track: Vec<([Vec3; 4], [Vec3; 4])> = Vec::new();
    for frame in 0..motion.frames() {
        pose.sample(&binding, animation, frame as f64);
        let at = |node| metres * pose.position(node);
        track.push((
            dog.legs.each_ref().map(|leg| at(leg.upper)),
            dog.legs.each_ref().map(|leg| at(leg.paw)),
        ));
    }
    let middle = |hips: &[Vec3; 4]| 0.25 * hips.iter().sum::<Vec3>();
    let far = (middle(&track[59].0) - middle(&track[0].0)) * Vec3::new(1.0, 0.0, 1.0);
    let base = (motion.root[59].translation - motion.root[0].translation)
        .truncate()
        .length();
    let ratio = base / f64::from(far.length()) / report.scale;
    assert!((0.95..1.05).contains(&ratio), "{ratio}");
    let travel = far.normalize();
    for (index, name) in FEET.iter().enumerate() {
        let feet = points(&robot, &motion, name, &[Vec3::ZERO]);
        let hips = points(&robot, &motion, &name.replace("foot", "thigh"), &[Vec3::ZERO]);
        let along = motion.root[59].translation - motion.root[0].translation;
        let along = along.truncate().normalize().as_vec2();
        let pairs = (0..60).map(|frame| {
            let robot = (feet[frame][0] - hips[frame][0]).truncate().dot(along);
            let dog = (track[frame].1[index] - track[frame].0[index]).dot(travel);
            (f64::from(robot), f64::from(dog))
        });
        let pairs: Vec<(f64, f64)> = pairs.collect();
        assert!(correlation(&pairs) > 0.9, "{name}: {}", correlation(&pairs));
    }
}

fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let count = pairs.len() as f64;
    let (x, y) = pairs
        .iter()
        .fold((0.0, 0.0), |sum, pair| (sum.0 + pair.0 / count, sum.1 + pair.1 / count));
    let sums = pairs.iter().fold([0.0; 3], |[xx, xy, yy], (a, b)| {
        let (a, b) = (a - x, b - y);
        [xx + a * a, xy + a * b, yy + b * b]
    });
    sums[1] / (sums[0] * sums[2]).sqrt()
}

/// If the limits allow both sides, knees bend backward.
#[test]
fn knees_bend_to_one_side() {
    for (limits, sign) in [(BACKWARD, 1.0), (FORWARD, -1.0), (BOTH, 1.0)] {
        let robot = robot(limits, 30.0);
        let (motion, report) = on(&robot);
        let knees = motion
            .dof_names
            .iter()
            .enumerate()
            .filter(|(_, name)| name.contains("shin"));
        for (dof, name) in knees {
            let values = (0..motion.frames()).map(|frame| sign * motion.dof_of(frame)[dof]);
            let least = values.fold(f64::MAX, f64::min);
            assert!(least >= 0.0, "{limits:?} {name}: {least}");
        }
        assert!(report.mean_degrees < 5.0, "{limits:?}: {}", report.mean_degrees);
    }
}

#[test]
fn people_and_animals_go_on_robots_of_their_kind_alone() {
    let walk = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
    let message = refused(walk, robot(BOTH, 30.0));
    assert!(
        message.contains("the robot walks on four legs, and the source is a humanoid"),
        "{message}"
    );
    let h1 = mocap::Importer::new()
        .import_robot("../../fixtures/robots/h1.urdf")
        .unwrap();
    let message = refused(DOG.clone(), h1);
    assert!(message.contains("animal on four legs"), "{message}");
}

/// The speed follows from the fastest joint of the path, even where this joint is faster than motors of such robots.
#[test]
fn auto_slows_a_dog_to_its_fastest_joint() {
    let mut source = DOG.clone();
    source.animations[0].ticks_per_second *= 8.0;
    let with = |velocity: f64, scale: TimeScale| {
        let mut robot = robot(BOTH, velocity);
        for link in robot.moving_joints() {
            robot.links[link].joint.limits.effort = None;
        }
        let options = RetargetOptions::new().time_scale(scale);
        let clip = Retargeter::new(source.clone(), robot, options)
            .unwrap()
            .into_clips()
            .remove(0);
        (clip.robot_motion.unwrap(), clip.report.robot().unwrap().clone())
    };
    let (path, _) = with(1e4, TimeScale::default());
    let steps = (1..path.frames()).flat_map(|frame| std::iter::zip(path.dof_of(frame - 1), path.dof_of(frame)));
    let fastest = steps.map(|(from, to)| (to - from).abs() * path.fps).fold(0.0, f64::max);
    assert!(fastest > 30.0, "{fastest}");
    let (slow, report) = with(20.0, TimeScale::Auto);
    let wanted = 20.0 / fastest;
    assert!(
        (report.time_scale / wanted - 1.0).abs() < 1e-3,
        "{} {wanted}",
        report.time_scale
    );
    assert_eq!(report.fraction_too_fast, 0.0);
    assert!(slow.frames() > path.frames());
}
