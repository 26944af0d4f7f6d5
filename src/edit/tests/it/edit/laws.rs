//! Tests of the laws that every step keeps, and of the inputs that each refuses.

use mocap::edit::{EditStep, Mirror, Step, StepInput};

use super::*;

/// Steps with parameters that change something. A step without a row is tried with its defaults.
const STEPS: [&str; 30] = [
    "foot-lock",
    "mirror",
    "smooth",
    "smooth:filter=gaussian,cut-off=3",
    "smooth:part=arms,range=0.5..1",
    "despike:threshold=2,angle=0.1",
    "fill",
    "loop",
    "loop:frames=10..70,in-place=true",
    "concat",
    "concat:align=false,blend=0",
    "blend",
    "blend:weight=0.5:0+1.5:1",
    "layer:part=arms",
    "warp:speed=0.7",
    "warp:path=0/0+1/2+3/2",
    "warp:path=0:0/0+1:0/1,facing=kept",
    "in-between:every=15",
    "in-between:every=15,interpolation=slerp",
    "trim:range=0..1",
    "resample:rate=30",
    "drop-first-frame:always=true",
    "in-place",
    "reverse",
    "reach:limb=left-hand,to=head,range=0.5..1",
    "reach:limb=right-foot,to=hips,offset=0/0/1",
    "pin:to=hips",
    "pin:limb=left-foot,range=0.5..1",
    "look-at:at=1/1/5,range=0.5..1",
    "turn:by=90",
];

pub(super) fn steps() -> Vec<&'static str> {
    let has_row = |name: &str| STEPS.iter().any(|step| step.split(':').next() == Some(name));
    let others = EditStep::ALL.iter().map(|step| step.name).filter(|name| !has_row(name));
    STEPS.into_iter().chain(others).collect()
}

pub(super) fn apply(step: &str, scene: &mut Scene, other: &Scene) -> mocap::Result<mocap::edit::report::EditReport> {
    let step: EditStep = step.parse().unwrap();
    step.apply(scene, &StepInput::new().other(other))
}

#[test]
fn no_step_changes_the_length_of_a_bone() {
    for file in ["cmu_12_01_walk.bvh", "rokoko_dance.bvh", "z_up_dab.bvh"] {
        let mut before = import(file);
        let rate = before.animations[0].ticks_per_second;
        before.trim(0.0, 2.5 * rate);
        let mut other = before.clone();
        Mirror::new().apply(&mut other, &StepInput::new()).unwrap();
        // `root-motion` adds a joint, so nodes cannot be compared by index.
        for step in steps().into_iter().filter(|step| *step != "root-motion") {
            let mut scene = before.clone();
            apply(step, &mut scene, &other).unwrap_or_else(|error| panic!("{file}: {step}: {error}"));
            assert_bones_keep_their_lengths(&before, &scene);
            assert_eq!(scene.validate(), [], "{file}: {step}");
        }
    }
}

/// Odd motions: of one frame, of two frames, with a useless rate, of a skeleton that is no figure, and without joints.
/// Each step gives a valid result, or gives a reason and leaves the scene unchanged.
#[test]
fn odd_motions_are_changed_or_refused() {
    let walk = import("cmu_12_01_walk.bvh");
    let part = |last: f64| {
        let mut scene = walk.clone();
        scene.trim(0.0, last);
        scene
    };
    let mut slow = part(20.0);
    slow.animations[0].ticks_per_second = 1e-3;
    let mut fast = part(20.0);
    fast.animations[0].ticks_per_second = 1e6;
    let mut empty = walk.clone();
    empty.animations[0].channels.clear();
    let mut fraction = part(30.0);
    fraction.trim(0.0, 20.5);
    let arm = import("lecture_Test.bvh");
    let still = {
        let mut scene = part(40.0);
        for channel in &mut scene.animations[0].channels {
            channel.rotation_keys.values.truncate(1);
            channel.position_keys.values.truncate(1);
        }
        scene
    };
    for (name, scene) in [
        ("one frame", part(0.0)),
        ("two frames", part(1.0)),
        ("three frames", part(2.0)),
        ("0.001 frames a second", slow),
        ("a million frames a second", fast),
        ("no channel", empty),
        ("a last frame between two ticks", fraction),
        ("an arm", arm),
        ("still", still),
    ] {
        for step in steps() {
            let mut changed = scene.clone();
            match apply(step, &mut changed, &scene) {
                Ok(_) => assert_eq!(changed.validate(), [], "{name}: {step}"),
                Err(_) => assert!(changed == scene, "{name}: {step} fails and changes the scene"),
            }
        }
        let mut none = scene.clone();
        none.animations.clear();
        for step in steps() {
            let refused = apply(step, &mut none, &scene).unwrap_err();
            let code = refused.code().as_str();
            assert!(
                ["no-motion", "not-humanoid"].contains(&code),
                "{name}: {step}: {refused}"
            );
        }
    }
}
