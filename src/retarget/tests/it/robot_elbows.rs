//! Elbows and knees with several hinges. The axes determine which link is the upper arm.

use mocap::Importer;
use mocap::retarget::robot::{Robot, robot_bones};
use mocap::scene::HumanoidBone as Bone;

/// A robot with its arms sideways. Its elbow has these bodies, each one link further out, with the axes of their
/// hinges.
fn robot(elbow: &[(&str, &[&str])], knee: &[&str]) -> Robot {
    let hinges = |name: &str, axes: &[&str]| -> String {
        let hinge = |(index, axis): (usize, &&str)| format!("<joint name=\"{name}_{index}\" axis=\"{axis}\"/>");
        axes.iter().enumerate().map(hinge).collect()
    };
    let side = |side: &str, sign: f64| {
        let mut arm = format!(
            "<body name=\"{side}_wrist\" pos=\"0 {} 0\">{}</body>",
            0.25 * sign,
            hinges(&format!("{side}_wrist"), &["0 1 0"])
        );
        for (name, axes) in elbow.iter().rev() {
            let name = format!("{side}_{name}");
            arm = format!(
                "<body name=\"{name}\" pos=\"0 {} 0\">{}{arm}</body>",
                0.15 * sign,
                hinges(&name, axes)
            );
        }
        let all = ["1 0 0", "0 1 0", "0 0 1"];
        format!(
            "<body name=\"{side}_shoulder\" pos=\"0 {} 0.5\">{}{arm}</body>\
             <body name=\"{side}_hip\" pos=\"0 {} 0\">{}<body name=\"{side}_knee\" pos=\"0 0 -0.4\">{}\
             <body name=\"{side}_ankle\" pos=\"0 0 -0.4\">{}</body></body></body>",
            0.2 * sign,
            hinges(&format!("{side}_shoulder"), &["0 1 0", "1 0 0"]),
            0.1 * sign,
            hinges(&format!("{side}_hip"), &all),
            hinges(&format!("{side}_knee"), knee),
            hinges(&format!("{side}_ankle"), &["0 1 0"]),
        )
    };
    let text = format!(
        "<mujoco><worldbody><body name=\"base\"><freejoint/>{}{}</body></worldbody></mujoco>",
        side("left", 1.0),
        side("right", -1.0)
    );
    Importer::new().read_robot(text.as_bytes(), "robot.xml").unwrap()
}

#[test]
fn an_upper_arm_ends_where_a_hinge_bends_the_arm() {
    let (bend, roll) = ("0 0 1", "0 1 0");
    for (elbow, upper, lower) in [
        // One hinge.
        (vec![("elbow", vec![bend])], "shoulder", "elbow"),
        // Three hinges of one joint, as in the bodies of SMPL.
        (vec![("elbow", vec!["1 0 0", roll, bend])], "shoulder", "elbow"),
        // The first hinge rolls the upper arm, as on Booster's T1.
        (
            vec![("elbow_pitch", vec![roll]), ("elbow_yaw", vec![bend])],
            "elbow_pitch",
            "elbow_yaw",
        ),
        // The last hinge rolls the forearm.
        (
            vec![("elbow_pitch", vec![bend]), ("elbow_yaw", vec![roll])],
            "shoulder",
            "elbow_yaw",
        ),
    ] {
        let elbow: Vec<(&str, &[&str])> = elbow.iter().map(|(name, axes)| (*name, axes.as_slice())).collect();
        for knee in [&["0 1 0"] as &[&str], &["1 0 0", "0 1 0", "0 0 1"]] {
            let robot = robot(&elbow, knee);
            let bones = robot_bones(&robot, None).unwrap();
            let link = |bone: Bone| {
                let found = bones.iter().find(|found| found.bone == bone).unwrap();
                robot.links[found.link].name.clone()
            };
            for (bone, name) in [
                (Bone::LeftUpperArm, format!("left_{upper}")),
                (Bone::LeftLowerArm, format!("left_{lower}")),
                (Bone::RightUpperArm, format!("right_{upper}")),
                (Bone::RightLowerArm, format!("right_{lower}")),
                (Bone::LeftHand, "left_wrist".to_owned()),
                (Bone::LeftUpperLeg, "left_hip".to_owned()),
                (Bone::LeftLowerLeg, "left_knee".to_owned()),
                (Bone::LeftFoot, "left_ankle".to_owned()),
            ] {
                assert_eq!(link(bone), name, "{elbow:?} {knee:?} {bone:?}");
            }
        }
    }
}
