//! The verdict on motions with planted errors. A report of angles alone would call each of them good.

use mocap::glam::{Quat, Vec3};
use mocap::retarget::report::Verdict;
use mocap::retarget::robot::report::{Floor, InfeasibleCause, RobotReport};
use mocap::retarget::robot::{Robot, RobotMotion, RobotOptions, RobotRetargeter, robot_scene};
use mocap::{Binding, Importer, Pose, Scene};

fn h1() -> Robot {
    Importer::new().import_robot("../../fixtures/robots/h1.urdf").unwrap()
}

/// Two seconds of a walk at 30 frames per second, with +Y up, in metres.
fn walk() -> Scene {
    let mut source = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
    let conversion = mocap::Conversion::new().first_frame(mocap::convert::FirstFrame::DropRestPose);
    let conversion = conversion.trim(None, mocap::convert::Moment::Seconds(2.0));
    conversion
        .out_metres_per_unit(1.0)
        .frame_rate(30.0)
        .apply(&mut source)
        .unwrap();
    source
}

fn on(source: &Scene, options: &RobotOptions) -> (RobotMotion, RobotReport) {
    RobotRetargeter::new(source, &h1(), options)
        .unwrap()
        .clip(source, 0)
        .unwrap()
}

fn verdict(report: &RobotReport, name: &str) -> (f64, Verdict) {
    let found = report.criteria.iter().find(|criterion| criterion.name == name).unwrap();
    (found.value, found.verdict)
}

/// Changes the keys of a joint.
fn change(source: &mut Scene, joint: &str, mut to: impl FnMut(&mut Vec3, &mut Quat)) {
    let channel = source.animations[0]
        .channels
        .iter_mut()
        .find(|channel| channel.node_name == joint)
        .unwrap();
    let count = channel
        .position_keys
        .values
        .len()
        .max(channel.rotation_keys.values.len());
    for index in 0..count {
        let mut nothing = (Vec3::ZERO, Quat::IDENTITY);
        let position = channel.position_keys.values.get_mut(index).unwrap_or(&mut nothing.0);
        let rotation = channel.rotation_keys.values.get_mut(index).unwrap_or(&mut nothing.1);
        to(position, rotation);
    }
}

#[test]
fn a_walk_in_the_air_is_not_good() {
    let mut source = walk();
    change(&mut source, "Hips", |position, _| position.y += 0.3);
    let (motion, report) = on(&source, &RobotOptions::new().floor(Floor::Zero));
    let (share, by_it) = verdict(&report, "fraction_floating");
    assert!(
        share > 0.9 && by_it == Verdict::Poor && report.verdict == Verdict::Poor,
        "{share}"
    );
    let dynamics = report.dynamics.as_ref().unwrap();
    assert_eq!(dynamics.main_cause, Some(InfeasibleCause::NoSoleOnFloor));
    let said = report.to_string();
    for text in [
        ": poor, not feasible in ",
        " of frames (no sole is on the floor): mean limb error ",
        ": poor because fraction floating is ",
        ", above 0.2\n",
        ": also, fraction infeasible is ",
        "the step ground puts the source on the floor",
    ] {
        assert!(said.contains(text), "{text}: {said}");
    }
    assert!(report.why_infeasible().unwrap().ends_with("(no sole is on the floor)"));
    // The ankles of the H1 are 5 cm above its soles.
    let robot = h1();
    let (scene, animation) = (robot_scene(&robot), motion.to_animation(&robot));
    let ankle = scene
        .nodes
        .iter()
        .position(|node| node.name == "left_ankle_link")
        .unwrap();
    let binding = Binding::new(&scene, &animation);
    let mut pose = Pose::rest(&scene);
    for frame in 0..motion.frames() {
        pose.sample(&binding, &animation, frame as f64);
        assert!(pose.node_to_world[ankle].w_axis.z > 0.2);
    }
    let (_, on_the_ground) = on(&walk(), &RobotOptions::new());
    assert_eq!(verdict(&on_the_ground, "fraction_floating").1, Verdict::Good);
}

#[test]
fn a_motion_whose_up_axis_is_wrong_is_not_good() {
    let mut source = walk();
    let turn = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    change(&mut source, "Hips", |position, rotation| {
        *position = turn * *position;
        *rotation = turn * *rotation;
    });
    let (_, report) = on(&source, &RobotOptions::new());
    assert_ne!(report.verdict, Verdict::Good);
    assert!(verdict(&report, "fraction_lying").0 > 0.9);
}

/// If links collide in one frame of a thousand, the report does not print 0 %.
#[test]
fn a_small_fraction_is_not_zero() {
    let (_, report) = on(&walk(), &RobotOptions::new().passes(1));
    let mut value = serde_json::to_value(&report).unwrap();
    value["fraction_in_self_collision"] = 0.001.into();
    value["self_collisions"] = serde_json::json!([{"link": "a", "other": "b", "fraction": 0.001, "deepest": 0.03}]);
    let report: RobotReport = serde_json::from_value(value).unwrap();
    let said = report.to_string();
    assert!(
        said.contains("collide in less than 0.5 % of frames, deepest a and b: 3.0 cm"),
        "{said}"
    );
}
