//! Tests of joint angles in poses with known angles, and of the steps of walks.

mod animals;
mod events;
mod gait;
mod plates;
mod series;

use mocap::biomechanics::{Gait, JointAngles};
use mocap::edit::ContactOptions;

use mocap::figure::{Humanoid, HumanoidBone as Bone, Side};
use mocap::scene::{AnalogChannel, Recording};
use mocap::{Code, Conversion, Format, Importer, Pose, Scene};

/// The joints of a body in T-pose that faces +Z, with its left at +X: name, parent, and OFFSET in centimetres.
const JOINTS: [(&str, &str, [f32; 3]); 19] = [
    ("Hips", "", [0.0, 96.0, 0.0]),
    ("LeftUpLeg", "Hips", [10.0, -4.0, 0.0]),
    ("LeftLeg", "LeftUpLeg", [0.0, -42.0, 0.0]),
    ("LeftFoot", "LeftLeg", [0.0, -42.0, 0.0]),
    ("LeftToeBase", "LeftFoot", [0.0, -7.0, 14.0]),
    ("RightUpLeg", "Hips", [-10.0, -4.0, 0.0]),
    ("RightLeg", "RightUpLeg", [0.0, -42.0, 0.0]),
    ("RightFoot", "RightLeg", [0.0, -42.0, 0.0]),
    ("RightToeBase", "RightFoot", [0.0, -7.0, 14.0]),
    ("Spine", "Hips", [0.0, 10.0, 0.0]),
    ("Spine1", "Spine", [0.0, 20.0, 0.0]),
    ("LeftArm", "Spine1", [18.0, 20.0, 0.0]),
    ("LeftForeArm", "LeftArm", [28.0, 0.0, 0.0]),
    ("LeftHand", "LeftForeArm", [25.0, 0.0, 0.0]),
    ("RightArm", "Spine1", [-18.0, 20.0, 0.0]),
    ("RightForeArm", "RightArm", [-28.0, 0.0, 0.0]),
    ("RightHand", "RightForeArm", [-25.0, 0.0, 0.0]),
    ("Neck", "Spine1", [0.0, 25.0, 0.0]),
    ("Head", "Neck", [0.0, 10.0, 0.0]),
];

/// The body with two frames: the T-pose, and a pose in which the named joints are rotated. The angles are about Z, X
/// and Y, in this order, in the axes of the T-pose.
fn bent(turned: &[(&str, [f32; 3])]) -> Scene {
    fn add(text: &mut String, joint: usize) {
        let (name, _, [x, y, z]) = JOINTS[joint];
        let kind = if joint == 0 { "ROOT" } else { "JOINT" };
        *text += &format!("{kind} {name}\n{{\nOFFSET {x} {y} {z}\nCHANNELS 3 Zrotation Xrotation Yrotation\n");
        let below: Vec<usize> = (0..JOINTS.len()).filter(|index| JOINTS[*index].1 == name).collect();
        below.iter().for_each(|index| add(text, *index));
        if below.is_empty() {
            let [x, y, z] = if name == "Head" {
                [0.0, 18.0, 0.0]
            } else {
                [x.signum() * 8.0 * f32::from(x != 0.0), 0.0, z.min(6.0)]
            };
            *text += &format!("End Site\n{{\nOFFSET {x} {y} {z}\n}}\n");
        }
        *text += "}\n";
    }
    let mut text = "HIERARCHY\n".to_owned();
    add(&mut text, 0);
    text += "MOTION\nFrames: 3\nFrame Time: 0.01\n";
    let rest = vec!["0 0 0"; JOINTS.len()].join(" ");
    let angles = JOINTS.map(|(name, ..)| {
        let own = turned.iter().find(|(joint, _)| *joint == name);
        own.map_or([0.0; 3], |(_, angles)| *angles)
    });
    let row: Vec<String> = angles.iter().flatten().map(f32::to_string).collect();
    text += &format!("{rest}\n{0}\n{0}\n", row.join(" "));
    Importer::new().read(text.as_bytes(), "bent.bvh").unwrap()
}

/// The angles in the last frame.
fn angle(angles: &JointAngles, column: &str) -> f64 {
    let mut column = angles.column(column).unwrap_or_else(|| panic!("{column} is missing"));
    column.by_ref().last().unwrap()
}

#[test]
fn angles_are_those_by_which_joints_were_turned() {
    // A positive angle about +X moves a hanging leg backwards.
    let scene = bent(&[
        ("LeftUpLeg", [0.0, -30.0, 0.0]),
        ("LeftLeg", [0.0, 60.0, 0.0]),
        ("LeftFoot", [0.0, -10.0, 0.0]),
        ("RightUpLeg", [0.0, 20.0, 0.0]),
        // The rotation goes from the left over the head to the right, so the right arm is lifted by a negative angle.
        ("RightArm", [-40.0, 0.0, 0.0]),
        ("LeftForeArm", [0.0, 0.0, -50.0]),
        ("Spine1", [0.0, 25.0, 0.0]),
        ("Head", [0.0, 0.0, 35.0]),
    ]);
    let angles = JointAngles::of(&scene).unwrap();
    for (column, expected) in [
        ("hip_flexion_l", 30.0),
        ("hip_adduction_l", 0.0),
        ("knee_angle_l", 60.0),
        ("ankle_angle_l", 10.0),
        ("hip_flexion_r", -20.0),
        ("knee_angle_r", 0.0),
        // The angle is relative to 90 degrees of the T-pose.
        ("shoulder_elevation_r", 130.0),
        ("shoulder_plane_r", 0.0),
        ("shoulder_elevation_l", 90.0),
        ("elbow_flex_l", 50.0),
        ("elbow_flex_r", 0.0),
        // The palms of a T-pose face down.
        ("pro_sup_r", 90.0),
        ("lumbar_extension", -25.0),
        ("neck_rotation", 35.0),
        ("pelvis_tilt", 0.0),
        ("wrist_flex_l", 0.0),
    ] {
        let found = angle(&angles, column);
        assert!(
            (found - expected).abs() < 0.01,
            "{column}: {found}, expected {expected}"
        );
    }
    let lines: Vec<String> = angles.to_mot().lines().map(str::to_owned).collect();
    assert_eq!(
        lines[2..4],
        ["nRows=3".to_owned(), format!("nColumns={}", angles.columns.len() + 1)]
    );
    assert_eq!(lines.len(), 7 + 3);
    assert_eq!(angles.to_csv().lines().count(), 1 + 3);
}

/// OpenSim's coordinates of a standing body with a bent knee. In older models, this knee angle is negative.
const COORDINATES: &str = "Coordinates\nversion=1\nnRows=3\nnColumns=8\ninDegrees=yes\n\nendheader\n\
    time\tpelvis_tx\tpelvis_ty\tpelvis_tilt\thip_flexion_r\thip_flexion_l\tknee_angle_r\tknee_angle_l\tmtp_angle_r\n\
    0.0\t0\t0.95\t0\t0\t0\t0\t0\t0\n0.5\t0.5\t0.95\t0\t40\t0\t-60\t0\t0\n1.0\t1\t0.95\t0\t40\t0\t-60\t0\t0\n";

fn of_mot(text: &str) -> mocap::Result<Scene> {
    Importer::new().read(text.as_bytes(), "walk_ik.mot")
}

#[test]
fn motion_files_of_opensim_are_read() {
    let scene = of_mot(COORDINATES).unwrap();
    assert_eq!(
        (scene.metadata.format, scene.animations[0].ticks_per_second),
        (Some(Format::Mot), 2.0)
    );
    assert!(
        scene
            .warnings
            .iter()
            .any(|warning| warning.found.as_deref() == Some("mtp_angle_r"))
    );
    let pose = Pose::at_tick(&scene, 0, 1.0).unwrap();
    let position = |bone: Bone| pose.position(Humanoid::of(&scene).joint(bone).unwrap());
    // Forward is +Z. The thigh is flexed by 40 degrees, and the shin hangs 20 degrees behind it.
    let [hip, knee, ankle] = [Bone::RightUpperLeg, Bone::RightLowerLeg, Bone::RightFoot].map(position);
    let degrees = |bone: mocap::glam::Vec3| bone.z.atan2(-bone.y).to_degrees();
    assert!((degrees(knee - hip) - 40.0).abs() < 0.01 && (degrees(ankle - knee) + 20.0).abs() < 0.01);
    assert!((position(Bone::Hips).z - 0.5).abs() < 1e-5);
    // The arms hang.
    let arm = position(Bone::LeftLowerArm) - position(Bone::LeftUpperArm);
    assert!(arm.normalize().y < -0.999);
    let radians = COORDINATES
        .replace("inDegrees=yes", "inDegrees=no")
        .replace("40", "0.6981317")
        .replace("-60", "-1.0471976");
    let angles = JointAngles::of(&of_mot(&radians).unwrap()).unwrap();
    assert!((angle(&angles, "knee_angle_r") - 60.0).abs() < 0.01);
}

#[test]
fn motion_files_say_what_is_no_number_and_what_is_not_there() {
    let (header, _) = COORDINATES.split_at(COORDINATES.find("0.0\t").unwrap());
    let error = of_mot(header).unwrap_err();
    assert_eq!(
        (error.code(), error.diagnostic().message.as_str()),
        (Code::NoMotion, "the file has no rows")
    );
    let one = of_mot(&COORDINATES[..COORDINATES.find("0.5\t").unwrap()]).unwrap_err();
    assert_eq!(
        (one.code(), one.diagnostic().found.as_deref()),
        (Code::FrameTime, Some("a single row"))
    );

    // The flexion of the right hip is missing in the last frame, so the value of the frame before is used.
    let broken = COORDINATES.replace("1.0\t1\t0.95\t0\t40", "1.0\t1\t0.95\t0\tNaN");
    let scene = of_mot(&broken).unwrap();
    let said: Vec<_> = scene
        .warnings
        .iter()
        .filter(|warning| warning.code == Code::NonFiniteValue)
        .collect();
    assert_eq!((said.len(), said[0].count), (1, 1));
    assert_eq!(
        said[0].message,
        "column hip_flexion_r, frame 2: the value is not a finite number"
    );
    assert_eq!(said[0].location.as_ref().map(|at| at.line), Some(11));
    assert_eq!(scene.animations, of_mot(COORDINATES).unwrap().animations);

    let uneven = COORDINATES.replace("0.5\t0.5", "0.1\t0.5");
    let scene = of_mot(&uneven).unwrap();
    assert!(
        scene
            .warnings
            .iter()
            .any(|warning| warning.code == Code::FrameTime && warning.message.contains("frame 1"))
    );
}

#[test]
fn written_angles_are_read_again() {
    let walk = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    let angles = JointAngles::of(&walk).unwrap();
    let again = JointAngles::of(&of_mot(&angles.to_mot()).unwrap()).unwrap();
    assert_eq!(angles.columns, again.columns);
    for (column, (before, after)) in angles
        .columns
        .iter()
        .cycle()
        .zip(angles.values.iter().zip(&again.values))
    {
        // Near the ends of the ranges of the angles, two different sets of angles give one rotation.
        let apart = (before - after + 180.0).rem_euclid(360.0) - 180.0;
        assert!(
            apart.abs() < 0.02 || column.starts_with("arm_") || column.starts_with("shoulder_"),
            "{column}: {before} and {after}"
        );
    }
}

#[test]
fn broken_motion_files_of_opensim_are_errors() {
    for (from, to, code) in [
        ("endheader\n", "", Code::UnexpectedEnd),
        ("hip_flexion_r", "force", Code::MissingKeyword),
        ("time\t", "step\t", Code::MissingKeyword),
        ("-60", "bent", Code::InvalidNumber),
        ("\t40\t0\t-60\t0\t0\n1.0", "\t40\n1.0", Code::RowLength),
        ("1.0\t1", "0.0\t1", Code::FrameTime),
    ] {
        let text = COORDINATES.replacen(from, to, 1);
        assert_eq!(of_mot(&text).unwrap_err().code(), code, "{from:?}");
    }
    // An impossible value and a missing value give a warning, and the value before is kept.
    for value in ["1e39", "nan", ""] {
        let scene = of_mot(&COORDINATES.replace("-60", value));
        assert!(
            scene.is_ok_and(|scene| scene
                .warnings
                .iter()
                .any(|warning| warning.code == Code::NonFiniteValue)),
            "{value}"
        );
    }
}

#[test]
fn angles_are_compared_with_those_of_the_file() {
    // The hip is flexed by 0, 30 and 30 degrees.
    let mut scene = bent(&[("LeftUpLeg", [0.0, -30.0, 0.0])]);
    let output = |name: &str, flexion: [f32; 3]| AnalogChannel {
        name: name.to_owned(),
        unit: "deg".to_owned(),
        values: flexion.iter().flat_map(|flexion| [*flexion, 0.0, 0.0]).collect(),
    };
    let outputs = vec![
        output("Anna:LHipAnglesV", [1.0, 33.0, f32::NAN]),
        output("RKneePower", [1.0, 2.0, 3.0]),
        output("LHipAngles", [360.0, 390.0, 390.0]),
        output("LPelvisAngles", [3.0, 3.0, 3.0]),
    ];
    scene.metadata.recorded = Some(std::sync::Arc::new(Recording {
        outputs,
        ..Recording::default()
    }));
    let angles = JointAngles::of(&scene).unwrap();
    let found = angles.beside_outputs(&scene);
    let of = |output: &str| {
        let found = found
            .iter()
            .find(|found| found.output == output && found.column == "hip_flexion_l")
            .unwrap();
        [found.mean, found.deviation, found.correlation]
    };
    // The means are 15 and 17, with deviations of 15 and 16. A difference of a whole revolution counts as none.
    for (output, expected) in [("Anna:LHipAnglesV", [-2.0, 1.0, 1.0]), ("LHipAngles", [0.0, 0.0, 1.0])] {
        let off = std::iter::zip(of(output), expected).map(|(own, expected)| (own - expected).abs());
        assert!(off.fold(0.0, f64::max) < 0.01, "{output}: {:?}", of(output));
    }
    assert!(found.iter().all(|found| found.output != "RKneePower"));
    let tilt = found.iter().find(|found| found.column == "pelvis_tilt").unwrap();
    assert!((tilt.mean + 3.0).abs() < 0.01, "{tilt:?}");
    // Frames that were cut off are not compared.
    Conversion::new().frame_rate(50.0).apply(&mut scene).unwrap();
    let angles = JointAngles::of(&scene).unwrap();
    assert_eq!(angles.beside_outputs(&scene), []);
}

#[test]
fn both_sides_have_one_sign() {
    let [left, right] = [("Left", 1.0), ("Right", -1.0)].map(|(side, sign)| {
        let name = |joint: &str| format!("{side}{joint}");
        let [thigh, foot, arm, forearm, hand] = ["UpLeg", "Foot", "Arm", "ForeArm", "Hand"].map(name);
        bent(&[
            (&thigh, [-12.0 * sign, -25.0, 8.0 * sign]),
            (&foot, [5.0 * sign, -6.0, 0.0]),
            (&arm, [-60.0 * sign, 10.0, -20.0 * sign]),
            (&forearm, [0.0, 15.0, -40.0 * sign]),
            (&hand, [-18.0 * sign, 0.0, 7.0 * sign]),
        ])
    });
    let [left, right] = [left, right].map(|scene| JointAngles::of(&scene).unwrap());
    let of_left: Vec<&String> = left.columns.iter().filter(|column| column.ends_with("_l")).collect();
    assert_eq!(of_left.len(), 7 * 3);
    for column in of_left {
        let other = format!("{}_r", column.trim_end_matches("_l"));
        let pair = [angle(&left, column), angle(&right, &other)];
        assert!((pair[0] - pair[1]).abs() < 0.01, "{column}: {pair:?}");
    }
    // A thigh that moves to the middle is adducted. A thigh whose toes turn to the middle is rotated inward.
    assert!(angle(&left, "hip_adduction_l") > 5.0 && angle(&left, "hip_rotation_l") < 0.0);
    // The left hand moves down towards its palm, which faces down, so it is flexed.
    assert!(angle(&left, "wrist_flex_l") > 10.0);
}

/// The times at which the feet come to rest, in seconds, by height and speed. The events of a walk do not use these
/// times.
fn landings(scene: &Scene, side: Side) -> Vec<f64> {
    let foot = match side {
        Side::Left => Bone::LeftFoot,
        Side::Right => Bone::RightFoot,
    };
    let contacts = ContactOptions::new().detect(scene, 0, None).unwrap();
    let of_foot = contacts.points.iter().filter(|point| point.bone == foot);
    let begins = of_foot
        .flat_map(mocap::edit::report::ContactPoint::intervals)
        .map(|[first, _]| first as f64 / contacts.frame_rate);
    begins.collect()
}

#[test]
fn heels_strike_just_before_feet_come_to_rest() {
    for (file, steps_a_minute) in [
        ("../../fixtures/real/cmu_12_01_walk.bvh", 85.0..125.0),
        ("../../fixtures/skeletons/bvhtoolbox_walk01.bvh", 85.0..125.0),
    ] {
        let mut scene = mocap::import(file).unwrap();
        Conversion::new().apply(&mut scene).unwrap();
        let gait = Gait::of(&scene).unwrap();
        assert!(
            gait.cadence.is_some_and(|cadence| steps_a_minute.contains(&cadence)),
            "{file}: {:?}",
            gait.cadence
        );
        assert!(gait.alternates && !gait.in_place);
        // The foot is flat on the ground after 12 % of the stride (Perry, Gait Analysis, 1992). It is reported to rest
        // at a whole frame.
        let frame = 1.0 / scene.animations[0].ticks_per_second;
        for (side, feet) in [(Side::Left, &gait.left), (Side::Right, &gait.right)] {
            let flat = 0.12 * feet.stride_time.unwrap().mean + 1.5 * frame;
            let landings = landings(&scene, side);
            for time in &feet.heel_strikes {
                let after = landings.iter().map(|landing| landing - time);
                let after = after.min_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap();
                assert!(
                    (-0.06..flat).contains(&after),
                    "{file}: {side:?} at {time}: at rest {after} s later"
                );
            }
            assert!(feet.heel_strikes.len() >= 2, "{file}: {:?}", feet.heel_strikes);
        }
        // A step is half of a stride.
        for side in [&gait.left, &gait.right] {
            let (stride, step) = (side.stride_length.unwrap().mean, side.step_length.unwrap().mean);
            assert!((0.4..0.6).contains(&(step / stride)), "{file}: {step} of {stride}");
            assert!(side.step_width.unwrap().mean < 0.35);
        }
    }
}

#[test]
fn what_makes_no_step_is_an_error() {
    let standing = bent(&[("LeftArm", [20.0, 0.0, 0.0])]);
    assert_eq!(Gait::of(&standing).unwrap_err().code(), Code::NoMotion);
    let hand = mocap::import("../../fixtures/real/lecture_Test.bvh").unwrap();
    assert_eq!(JointAngles::of(&hand).unwrap_err().code(), Code::NotHumanoid);
}
