//! Limbs that go to a target: kinematics of the tests' own in double precision say whether they are there.

use mocap::edit::{EditReport, EditStep, StepInput, StepReport};
use mocap::figure::humanoid;

use super::*;

fn apply(scene: &mut Scene, step: &str) -> mocap::Result<EditReport> {
    step.parse::<EditStep>()?.apply(scene, &StepInput::new())
}

fn joint(scene: &Scene, bone: &str) -> usize {
    let bone = mocap::figure::HumanoidBone::from_name(bone).unwrap();
    humanoid(scene).joint(bone).unwrap().index()
}

/// The hand is at the head within the part, the foot at a point; nothing moves beside the limb, and nothing before and
/// after.
#[test]
fn a_limb_reaches_its_target() {
    for file in ["cmu_12_01_walk.bvh", "rokoko_dance.bvh", "z_up_dab.bvh"] {
        let before = import(file);
        let at = exact_positions(&before);
        let (head, hand, arm) = (
            joint(&before, "head"),
            joint(&before, "leftHand"),
            joint(&before, "leftUpperArm"),
        );
        let mut scene = before.clone();
        let report = apply(
            &mut scene,
            "reach:limb=left-hand,to=head,range=60f..90f,ease-in=0.2,ease-out=0.2",
        )
        .unwrap();
        let StepReport::Reach(reach) = &report.changed else {
            unreachable!()
        };
        assert_eq!(
            (reach.limb.frames, reach.limb.out_of_reach),
            (31, 0),
            "{file}: {report}"
        );
        let ease = (0.2 * before.animations[0].ticks_per_second).ceil() as usize;
        let is_of_arm = |mut node: usize| loop {
            match before.nodes[node].parent {
                _ if node == arm => return true,
                Some(parent) => node = parent.index(),
                None => return false,
            }
        };
        for (frame, now) in exact_positions(&scene).iter().enumerate() {
            if (60..=90).contains(&frame) {
                assert!(now[hand].distance(now[head]) < 1e-5, "{file}: frame {frame}");
            }
            for node in 0..now.len() {
                let moved = now[node].distance(at[frame][node]);
                let is_free = is_of_arm(node) && (60 - ease..=90 + ease).contains(&frame);
                assert!(
                    is_free || moved < 1e-5,
                    "{file}: {} in frame {frame}: {moved}",
                    before.nodes[node].name
                );
            }
        }
    }
}

/// What is left is said, and the limb is straight towards its target.
#[test]
fn a_target_out_of_reach_is_said() {
    let mut scene = import("cmu_12_01_walk.bvh");
    let (shoulder, hand) = (joint(&scene, "rightUpperArm"), joint(&scene, "rightHand"));
    let report = apply(&mut scene, "reach:to=0/9/0,range=1..2").unwrap();
    let StepReport::Reach(reach) = &report.changed else {
        unreachable!()
    };
    assert_eq!((reach.limb.frames, reach.limb.out_of_reach), (121, 121));
    let at = exact_positions(&scene);
    let target = DVec3::new(0.0, 9.0, 0.0);
    let left = |frame: usize| at[frame][hand].distance(target);
    let farthest = (120..=240).map(left).fold(0.0, f64::max);
    assert!((f64::from(reach.limb.farthest) - farthest).abs() < 1e-4, "{report}");
    for frame in 120..=240 {
        let [arm, way] = [at[frame][hand], target].map(|to| (to - at[frame][shoulder]).normalize());
        assert!(arm.dot(way) > 1.0 - 1e-8, "frame {frame}");
    }
}

#[test]
fn what_cannot_be_a_target_is_refused() {
    let before = import("cmu_12_01_walk.bvh");
    for (step, message) in [
        ("reach", "reach takes a target: to=0.3/1.2/0.5 in metres"),
        ("reach:to=Hed", "no node is called \"Hed\", and no bone is"),
        (
            "reach:to=right-hand",
            "\"right-hand\" cannot be the target: it moves with",
        ),
        (
            "reach:to=head,tip=head",
            "tip must be \"RightHand\" or a joint below it",
        ),
        ("reach:to=1e39/0/0", "a point must have three finite lengths in metres"),
        ("reach:to=head,ease-in=-1", "ease-in must be"),
        (
            "reach:to=head,range=90..",
            "the part to keep begins after the last frame",
        ),
    ] {
        let mut scene = before.clone();
        let error = apply(&mut scene, step).unwrap_err();
        assert!(error.diagnostic().message.starts_with(message), "{step}: {error}");
        assert!(scene == before, "{step}");
    }
    let error = apply(&mut before.clone(), "reach:to=LeftHnd").unwrap_err();
    assert_eq!(error.diagnostic().help.as_deref(), Some("did you mean LeftHand?"));
}
