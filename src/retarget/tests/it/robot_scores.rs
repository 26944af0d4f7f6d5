//! The scores of a motion, computed again with plain kinematics.

use mocap::glam::{DMat4, DQuat, DVec3};
use mocap::retarget::robot::report::Floor;
use mocap::retarget::robot::{JointKind, Robot, RobotMotion, RobotOptions, RobotRetargeter};
use mocap::scene::HumanoidBone as Bone;
use mocap_figure::robot_bones::robot_bones;
use mocap_figure::robot_bones::t_pose::RobotTPose;

use crate::robot_to_robot::{robot, source};
use crate::robot_walk::{on, walk};

/// The placement of every link in a frame.
pub(crate) fn links(robot: &Robot, motion: &RobotMotion, frame: usize) -> Vec<DMat4> {
    let root = motion.root[frame];
    let mut positions = robot.moving_joints().into_iter().zip(motion.dof_of(frame));
    let mut next = positions.next();
    let mut world: Vec<DMat4> = Vec::new();
    for (index, link) in robot.links.iter().enumerate() {
        let Some(parent) = link.parent else {
            world.push(DMat4::from_rotation_translation(root.rotation, root.translation));
            continue;
        };
        let joint = &link.joint;
        let origin = DMat4::from_rotation_translation(joint.origin.rotation, joint.origin.translation);
        let mut here = world[parent] * origin;
        if let Some((_, position)) = next.filter(|(moving, _)| *moving == index) {
            here *= match joint.kind {
                JointKind::Slide => DMat4::from_translation(*position * joint.axis),
                _ => {
                    let turn = DMat4::from_quat(DQuat::from_axis_angle(joint.axis, *position));
                    DMat4::from_translation(joint.anchor) * turn * DMat4::from_translation(-joint.anchor)
                }
            };
            next = positions.next();
        }
        world.push(here);
    }
    world
}

fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.into_iter().collect();
    values.iter().sum::<f64>() / values.len() as f64
}

fn near(name: &str, score: f64, restated: f64) {
    assert!((score - restated).abs() < 1e-6, "{name}: {score}, restated {restated}");
}

/// A walk of the G1, and a second motion of the G1 that lags, sways, sinks and exceeds its limits.
#[test]
fn scores_are_what_their_definitions_say() {
    let g1 = robot("g1_29dof_rev_1_0.urdf");
    let (was, _) = on(&g1, &walk());
    let mut is = was.clone();
    let joints = is.dof_names.len();
    for frame in 0..is.frames() {
        let time = frame as f64 / is.fps;
        is.root[frame].translation += DVec3::new(0.03 * (3.0 * time).sin(), 0.02, -0.015 - 0.01 * time.sin());
        for (joint, position) in is.dof_pos[frame * joints..][..joints].iter_mut().enumerate() {
            *position += 0.05 * (2.0 * time + joint as f64).sin();
        }
        // The knee bends backward for some frames.
        is.dof_pos[frame * joints + 3] -= if frame % 20 < 5 { 0.8 } else { 0.0 };
    }
    let reference = source(&g1, &was);
    let options = RobotOptions::new().floor(Floor::Keep);
    let mut retargeter = RobotRetargeter::new(&reference, &g1, &options).unwrap();
    let contacts = retargeter.clip(&reference, 0).unwrap().0.contacts;
    let report = retargeter.judge(&reference, 0, &is).unwrap();
    let scores = report.scores.as_ref().unwrap();

    let frames = is.frames();
    let places: Vec<[Vec<DMat4>; 2]> = (0..frames)
        .map(|frame| [links(&g1, &was, frame), links(&g1, &is, frame)])
        .collect();
    let place = |frame: usize, which: usize, link: usize| places[frame][which][link].w_axis.truncate();
    let errors = |bodies: &[usize], local: f64| {
        let apart = |frame: usize, link: usize| place(frame, 1, link) - place(frame, 0, link);
        mean((0..frames).flat_map(|frame| {
            let of_base = local * apart(frame, 0);
            bodies
                .iter()
                .map(move |link| (apart(frame, *link) - of_base).length())
                .collect::<Vec<f64>>()
        }))
    };
    let bodies: Vec<usize> = std::iter::once(0).chain(g1.moving_joints()).collect();
    assert_eq!(scores.bodies, bodies.len());
    near("MPBPE, global", scores.mpbpe_global, errors(&bodies, 0.0));
    near("MPBPE, local", scores.mpbpe_local, errors(&bodies, 1.0));
    let bones = robot_bones(&g1, None).unwrap();
    let link = |bone: Bone| bones.iter().find(|found| found.bone == bone).unwrap().link;
    let palms = [link(Bone::LeftHand), link(Bone::RightHand)];
    near("palms", scores.palm_error.unwrap(), errors(&palms, 1.0));

    let soles = RobotTPose::new(&g1, &bones).unwrap().soles;
    let feet = [link(Bone::LeftFoot), link(Bone::RightFoot)];
    let points = |frame: usize, side: usize| -> Vec<DVec3> {
        let foot = places[frame][1][feet[side]];
        soles[side]
            .iter()
            .map(|ball| foot.transform_point3(ball.centre))
            .collect()
    };
    let lowest = |frame: usize, side: usize| {
        let heights = points(frame, side)
            .into_iter()
            .zip(&soles[side])
            .map(|(point, ball)| point.z - ball.radius);
        heights.fold(f64::INFINITY, f64::min)
    };
    let (mut speeds, mut kept) = (Vec::new(), Vec::new());
    for frame in 0..frames {
        for (side, _) in contacts[frame].iter().enumerate().filter(|(_, stands)| **stands) {
            kept.push(f64::from(u8::from(lowest(frame, side) <= 0.02)));
            if frame > 0 && contacts[frame - 1][side] {
                let steps = points(frame, side).into_iter().zip(points(frame - 1, side));
                let steps = steps.map(|(now, before)| (now - before).truncate().length());
                speeds.push(is.fps * steps.fold(f64::INFINITY, f64::min));
            }
        }
    }
    assert!(speeds.len() > 20);
    near("sliding", scores.foot_sliding.unwrap(), mean(speeds.iter().copied()));
    let skating = speeds.iter().map(|speed| f64::from(u8::from(*speed > 0.1)));
    near("skating", scores.foot_skating_duration.unwrap(), mean(skating));
    let fastest = speeds.iter().copied().fold(0.0, f64::max);
    near("fastest", scores.foot_skating_velocity.unwrap(), fastest);
    near("contacts", scores.contact_preservation.unwrap(), mean(kept));
    // In a walk, no other link is near the floor.
    let depths: Vec<f64> = (0..frames)
        .map(|frame| -lowest(frame, 0).min(lowest(frame, 1)))
        .collect();
    let deep = depths.iter().map(|depth| f64::from(u8::from(*depth > 0.01)));
    near("penetration", scores.penetration_duration, mean(deep));
    near(
        "depth",
        scores.penetration_depth,
        depths.iter().copied().fold(0.0, f64::max),
    );
    assert!(scores.penetration_duration > 0.2 && scores.foot_skating_duration.unwrap() > 0.0);

    let at = |frame: usize, joint: usize| is.dof_pos[frame * joints + joint];
    let jerks = (3..frames).flat_map(|frame| {
        (0..joints).map(move |joint| {
            let third = at(frame, joint) - 3.0 * at(frame - 1, joint) + 3.0 * at(frame - 2, joint);
            (third - at(frame - 3, joint)).abs() * is.fps.powi(3)
        })
    });
    let jerk = mean(jerks);
    assert!(
        (scores.joint_jerk / jerk - 1.0).abs() < 1e-9,
        "{} {jerk}",
        scores.joint_jerk
    );
    let beyond: Vec<f64> = (0..frames * joints)
        .map(|sample| {
            let limits = g1.links[g1.moving_joints()[sample % joints]].joint.limits;
            (limits.lower - is.dof_pos[sample]).max(is.dof_pos[sample] - limits.upper)
        })
        .collect();
    let share = |least: f64| mean(beyond.iter().map(|beyond| f64::from(u8::from(*beyond > least))));
    near("beyond", scores.limit_violation, share(1e-4));
    near("at", scores.at_limit, share(-1e-4));
    let criterion = report
        .criteria
        .iter()
        .find(|found| found.name == "fraction_beyond_limits");
    near("criterion", criterion.unwrap().value, share(1e-4));
    assert!(scores.limit_violation > 0.001);

    // Only the common frames are compared.
    let mut short = is.clone();
    short.fps *= 2.0;
    assert!(retargeter.judge(&reference, 0, &short).is_err());
}
