//! Steps that retarget: motions of two skeletons, and locked feet on another body.

use mocap::edit::report::StepReport;
use mocap::edit::{ContactOptions, EditStep};
use mocap::figure::{Humanoid, HumanoidBone};
use mocap::glam::Vec3;
use mocap::retarget::apply_steps;
use mocap::retarget::{PoseRetargetOptions, PoseRetargeter};
use mocap::scene::NodeId;

use crate::characters::character;
use crate::positions::{assert_bones_keep_their_lengths, import, positions, ratios};

const WALK: &str = "cmu_12_01_walk.bvh";

fn file(name: &str) -> String {
    format!("../../fixtures/{name}")
}

#[test]
fn a_motion_of_another_skeleton_is_retargeted_and_said_to_be() {
    let walk = import(WALK);
    let run = mocap::import(file("skeletons/accad_run_turn.bvh")).unwrap();
    let steps: Vec<EditStep> = vec!["concat:within=0.5".parse().unwrap()];
    let mut joined = walk.clone();
    let reports = apply_steps(&mut joined, &steps, &[&run], None).unwrap();
    let text = reports[0].to_string();
    assert!(
        text.starts_with("concat with accad_run_turn.bvh, retargeted from another skeleton ("),
        "{text}"
    );
    let StepReport::Concat(report) = &reports[0].changed else {
        unreachable!()
    };
    assert_eq!(joined.nodes, walk.nodes);
    assert_bones_keep_their_lengths(&walk, &joined);
    // The last pose is the last pose of the run: thighs and arms have the run's directions, except for the heading.
    let (own, theirs) = (Humanoid::of(&walk), Humanoid::of(&run));
    let (ours, source) = (positions(&joined), positions(&run));
    let (ours, source) = (&ours[report.frames - 1], source.last().unwrap());
    for (from, to) in [
        (HumanoidBone::LeftUpperLeg, HumanoidBone::LeftLowerLeg),
        (HumanoidBone::RightUpperArm, HumanoidBone::RightLowerArm),
    ] {
        let direction = |at: &[Vec3], found: &Humanoid| {
            let [from, to] = [from, to].map(|bone| at[found.joint(bone).unwrap().index()]);
            (to - from).normalize()
        };
        let (a, b) = (direction(ours, &own), direction(source, &theirs));
        assert!((a.y - b.y).abs() < 0.1, "{from:?}: {a} {b}");
    }

    // A skeleton that is not a humanoid is refused, with the reason.
    let chain = mocap::import(file("real/blender_two_joints.bvh")).unwrap();
    let error = apply_steps(&mut walk.clone(), &steps, &[&chain], None).unwrap_err();
    let expected = "the two motions have different skeletons, and the second cannot be retargeted: ";
    assert!(error.diagnostic().message.starts_with(expected), "{error}");
}

/// On their own body, locked feet are no faster than free feet. This also holds on another body, whose feet had to
/// catch up by 30 cm in one swing.
#[test]
fn locked_feet_of_another_body_are_no_faster_than_free_ones() {
    let target = character("human_vrm1");
    for file in ["motionbuilder_vicon_walk.bvh", "z_up_dab.bvh", "additive_root_walk.bvh"] {
        let source = import(file);
        let mut retargeter = PoseRetargeter::new(&source, &target, &PoseRetargetOptions::default()).unwrap();
        let mut on_target = |lock_feet| {
            let (animation, report) = retargeter.clip(&source, 0, &target, lock_feet).unwrap();
            let mut scene = target.clone();
            scene.animations = vec![animation];
            (scene, report)
        };
        let ((free, _), (locked, report)) = (on_target(false), on_target(true));
        let lock = report.lock.unwrap_or_else(|| panic!("{file}: the feet are free"));
        let found = ContactOptions::default().detect(&free, 0, None).unwrap();
        let joints: Vec<NodeId> = found.points.iter().map(|point| point.node).collect();
        let [speed, acceleration] = ratios(&positions(&locked), &positions(&free), &joints, found.frame_rate as f32);
        assert!(speed <= 1.2 && acceleration <= 1.5, "{file}: {speed} {acceleration}");
        let differs = (lock.speed_ratio - speed)
            .abs()
            .max((lock.acceleration_ratio - acceleration).abs());
        assert!(differs < 0.05, "{file}: {speed} {acceleration} {lock:?}");
    }
}
