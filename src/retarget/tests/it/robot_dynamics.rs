//! Inverse dynamics of motions on robots; `tools/robot/dynamics.py` compares the numbers with MuJoCo.

use mocap::Importer;
use mocap::retarget::robot::report::{Feasibility, Floor};
use mocap::retarget::robot::{RobotOptions, RobotRetargeter};

fn feasibility(change: impl FnOnce(&mut mocap::retarget::robot::Robot)) -> Option<Feasibility> {
    let mut robot = Importer::new()
        .import_robot("../../fixtures/robots/g1_29dof_rev_1_0.urdf")
        .unwrap();
    change(&mut robot);
    let source = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    let mut retargeter = RobotRetargeter::new(&source, &robot, &RobotOptions::new().passes(1)).unwrap();
    retargeter.clip(&source, 0).unwrap().1.dynamics
}

#[test]
fn the_report_has_what_the_masses_of_the_file_say() {
    let found = feasibility(|_| {}).unwrap();
    // The sum of `mass value=` in the file, found with grep.
    let text = std::fs::read_to_string("../../fixtures/robots/g1_29dof_rev_1_0.urdf").unwrap();
    let masses = text.split("<mass value=\"").skip(1);
    let mass: f64 = masses
        .map(|rest| rest.split('"').next().unwrap().parse::<f64>().unwrap())
        .sum();
    assert!((found.mass - mass).abs() < 1e-9, "{} {mass}", found.mass);
    assert!((0.0..=1.0).contains(&found.fraction_feasible));
    assert!(found.most_loaded_joint.ends_with("_joint") && found.max_effort > 0.0);
}

#[test]
fn a_robot_without_masses_or_efforts_has_no_such_figures() {
    let without_masses = feasibility(|robot| robot.links.iter_mut().for_each(|link| link.inertial = None));
    assert_eq!(without_masses, None);
    let no_effort = |robot: &mut mocap::retarget::robot::Robot| {
        let joints = robot.links.iter_mut().map(|link| &mut link.joint);
        joints.for_each(|joint| joint.limits.effort = None);
    };
    let found = feasibility(no_effort).unwrap();
    assert_eq!((found.fraction_over_effort, found.max_effort), (None, 0.0));
}

/// If the base of the H1 were above the feet like the base of a person, the H1 would fall. With the source's base, 88 %
/// of the frames of this walk were feasible.
#[test]
fn the_base_goes_to_where_the_floor_carries_the_robot() {
    let robot = Importer::new().import_robot("../../fixtures/robots/h1.urdf").unwrap();
    let mut source = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
    let conversion = mocap::Conversion::new().first_frame(mocap::convert::FirstFrame::DropRestPose);
    conversion.frame_rate(60.0).apply(&mut source).unwrap();
    let mut retargeter = RobotRetargeter::new(&source, &robot, &RobotOptions::new()).unwrap();
    let (_, report) = retargeter.clip(&source, 0).unwrap();
    let feasible = report.dynamics.unwrap().fraction_feasible;
    assert!(feasible >= 0.95, "{feasible}");
    assert!(
        report.skate.unwrap() < 0.01 && report.mean_degrees < 2.3,
        "{:?} {}",
        report.skate,
        report.mean_degrees
    );
}

/// The source's floor is the mean height of its feet in stance. If the floor is 10 cm above height 0 of the file, the
/// robot is higher by 10 cm times the scale of the legs.
#[test]
fn the_floor_is_where_the_options_have_it() {
    let robot = Importer::new()
        .import_robot("../../fixtures/robots/g1_29dof_rev_1_0.urdf")
        .unwrap();
    let text = std::fs::read_to_string("../../fixtures/real/cmu_short.bvh").unwrap();
    // A unit of CMU's files is an inch / 0.45. The second number of a frame is the height of the hips.
    let (head, frames) = text.split_once("Frame Time: .0083333\n").unwrap();
    let higher = |line: &str| {
        let numbers: Vec<f64> = line.split_whitespace().map(|number| number.parse().unwrap()).collect();
        let moved = numbers.iter().enumerate();
        let moved = moved.map(|(at, number)| number + if at == 1 { 0.1 * 0.45 / 0.0254 } else { 0.0 });
        moved.map(|number| number.to_string()).collect::<Vec<_>>().join(" ")
    };
    let frames: Vec<String> = frames.lines().map(higher).collect();
    let raised = format!("{head}Frame Time: .0083333\n{}\n", frames.join("\n"));
    let [source, raised] = [text, raised].map(|text| Importer::new().read(text.as_bytes(), "walk.bvh").unwrap());
    let height = |source: &mocap::Scene, floor: Floor| {
        let options = RobotOptions::new().passes(1).floor(floor);
        let mut retargeter = RobotRetargeter::new(source, &robot, &options).unwrap();
        let (motion, report) = retargeter.clip(source, 0).unwrap();
        (motion.root[1].translation.z, report.scale)
    };
    for (floor, wanted) in [(Floor::Auto, 0.0), (Floor::Keep, 0.0), (Floor::Zero, 0.1)] {
        let ((low, scale), (high, _)) = (height(&source, floor), height(&raised, floor));
        assert!(
            (high - low - wanted * scale).abs() < 0.002,
            "{floor:?} {low} {high} {scale}"
        );
    }
}
