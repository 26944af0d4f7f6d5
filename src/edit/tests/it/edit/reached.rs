//! Tests of limbs that move to a target. Separate kinematics in double precision check whether they arrive.

use mocap::edit::report::{EditReport, StepReport};
use mocap::edit::{EditStep, StepInput};
use mocap::figure::{Figure, Humanoid};

use super::*;

fn apply(scene: &mut Scene, step: &str) -> mocap::Result<EditReport> {
    step.parse::<EditStep>()?.apply(scene, &StepInput::new())
}

fn joint(scene: &Scene, bone: &str) -> usize {
    let bone = mocap::figure::HumanoidBone::from_name(bone).unwrap();
    Humanoid::of(scene).joint(bone).unwrap().index()
}

/// The hand is at the head within the time range, and the foot is at a point. Only the limb moves, and nothing moves
/// before and after the range.
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

/// An elbow or a knee does not swing around. The law holds for a limb far from its goal, for a limb near its goal for a
/// moment, and for a body that jumps in one frame. The acceleration is at most 1.3 times the largest of the source.
#[test]
fn the_middle_of_a_limb_is_not_swung_about() {
    let arm = ["leftLowerArm", "leftHand", "head"];
    let leg = ["rightLowerLeg", "rightFoot", "rightFoot"];
    let motions = [
        ("cmu_mixed_rotation_orders.bvh", arm, "left-hand,to=head", 37..88),
        (
            "perception_neuron_moving_positions.bvh",
            arm,
            "left-hand,to=0.218/1.291/-0.055",
            127..296,
        ),
        ("z_up_dab.bvh", leg, "right-foot,to=0.128/0.257/-0.110", 139..200),
    ];
    for (file, bones, limb, part) in motions {
        let before = import(file);
        let joints = bones.map(|bone| joint(&before, bone));
        let mut scene = before.clone();
        let (first, last) = (part.start, part.end - 1);
        apply(&mut scene, &format!("reach:limb={limb},range={first}f..{last}f")).unwrap();
        let rate = before.animations[0].ticks_per_second;
        let largest = |scene: &Scene, joints: &[usize], frames: std::ops::Range<usize>| {
            let at = exact_positions(scene);
            let of = |joint: usize, frame: usize| at[frame + 1][joint] - 2.0 * at[frame][joint] + at[frame - 1][joint];
            let all = frames.flat_map(|frame| {
                joints
                    .iter()
                    .map(|joint| of(*joint, frame).length() * rate * rate)
                    .collect::<Vec<_>>()
            });
            all.fold(0.0, f64::max)
        };
        let was = largest(&before, &joints, 1..exact_positions(&before).len() - 1);
        let is = largest(&scene, &joints[..2], first + 1..last);
        assert!(is <= 1.3 * was, "{file}: {is} m/s2, {was} in the source");
    }
}

/// The remaining distance is reported, and the limb is straight towards its target.
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
    for (frame, at) in at.iter().enumerate().take(241).skip(120) {
        let [arm, way] = [at[hand], target].map(|to| (to - at[shoulder]).normalize());
        assert!(arm.dot(way) > 1.0 - 1e-8, "frame {frame}");
    }
}

#[test]
fn what_cannot_be_a_target_is_refused() {
    let before = import("cmu_12_01_walk.bvh");
    for (step, message) in [
        ("reach", "reach needs a target: to=0.3/1.2/0.5 in metres"),
        ("reach:to=Hed", "no node or bone is called \"Hed\""),
        (
            "reach:to=right-hand",
            "\"right-hand\" cannot be the target: it moves together with",
        ),
        (
            "reach:to=head,start=Hips",
            "7 chains begin at \"Hips\": name the tip of the chain to move, such as ",
        ),
        (
            "reach:to=head,start=LeftArm,tip=Head",
            "tip must be a joint below \"LeftArm\", got \"Head\"",
        ),
        (
            "reach:to=head,limb=left-foot,start=LeftArm",
            "start names a chain of joints, and limb names a limb",
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

/// A hand in front of the swaying head is pinned to the hips: it stays at one place in the coordinate frame of the
/// hips.
#[test]
fn what_touches_keeps_touching() {
    let mut scene = import("cmu_12_01_walk.bvh");
    let (hand, hips) = (joint(&scene, "leftHand"), joint(&scene, "hips"));
    apply(&mut scene, "reach:limb=left-hand,to=head,range=60f..220f").unwrap();
    let report = apply(&mut scene, "pin:limb=left-hand,to=hips,range=100f..160f").unwrap();
    let StepReport::Pin(pin) = &report.changed else {
        unreachable!()
    };
    assert_eq!(
        (pin.contacts.as_slice(), pin.limb.out_of_reach),
        ([[100, 160]].as_slice(), 0),
        "{report}"
    );
    let (animation, mut pose) = (scene.animations[0].clone(), Pose::rest(&scene));
    let binding = Binding::new(&scene, &animation);
    let at = (100..=160).map(|frame| {
        pose.sample(&binding, &animation, f64::from(frame));
        let to_hips = pose.node_to_world[hips].inverse();
        to_hips.transform_point3(pose.position(NodeId::new(hand)))
    });
    let at: Vec<Vec3> = at.collect();
    let farthest = at.iter().map(|here| here.distance(at[0])).fold(0.0, f32::max);
    assert!(farthest < 1e-4 && pin.slide_before > 0.02, "{farthest}: {report}");

    // Contacts of hands that last for a second are found, and no hand slides more than before.
    let mut scene = import("cmu_12_01_walk.bvh");
    apply(&mut scene, "reach:limb=left-hand,to=hips,offset=0/0.2/0.3,range=1..2").unwrap();
    apply(&mut scene, "reach:limb=right-hand,to=hips,offset=0/0.2/0.3,range=1..2").unwrap();
    let report = apply(&mut scene, "pin:to=left-hand").unwrap();
    let StepReport::Pin(pin) = &report.changed else {
        unreachable!()
    };
    assert!(
        pin.contacts.len() + pin.left > 0 && pin.slide_after <= pin.slide_before,
        "{report}"
    );
}

/// The line of sight goes through the target, or the report states the distance.
#[test]
fn the_head_turns_to_its_target() {
    for file in ["cmu_12_01_walk.bvh", "rokoko_dance.bvh", "z_up_dab.bvh"] {
        let before = import(file);
        let mut scene = before.clone();
        let report = apply(&mut scene, "look-at:at=left-hand,range=30f..60f,limit=170").unwrap();
        let StepReport::LookAt(look) = &report.changed else {
            unreachable!()
        };
        assert_eq!((look.frames, look.range), (31, [30, 60]), "{file}: {report}");
        assert!(look.beyond > 0 || look.farthest < 1e-3, "{file}: {report}");
        let (was, is) = (exact_positions(&before), exact_positions(&scene));
        let shoulder = joint(&before, "leftUpperArm");
        assert!((0..was.len()).all(|frame| was[frame][shoulder].distance(is[frame][shoulder]) < 1e-5));
    }
    // The head does not jump when the target passes behind it.
    let mut scene = import("cmu_12_01_walk.bvh");
    let report = apply(&mut scene, "look-at:at=0/1.5/-50").unwrap();
    let StepReport::LookAt(look) = &report.changed else {
        unreachable!()
    };
    assert!(look.beyond == look.frames && look.largest_angle > 60.0, "{report}");
}

/// A walk passes a point beside its head. The added rotation is never faster than a head, and the frames in which the
/// rotation is late are counted.
#[test]
fn the_head_follows_a_target_that_passes_no_faster_than_heads_turn() {
    let before = import("cmu_12_01_walk.bvh");
    let head = joint(&before, "head");
    let rate = before.animations[0].ticks_per_second;
    let middle = exact_positions(&before)[262][head] + DVec3::new(0.15, 0.05, 0.0);
    let mut scene = before.clone();
    let step = format!("look-at:at={}/{}/{},limit=170", middle.x, middle.y, middle.z);
    let report = apply(&mut scene, &step).unwrap();
    let StepReport::LookAt(look) = &report.changed else {
        unreachable!()
    };
    assert!(look.beyond > 0 && look.turned > 60.0, "{report}");
    let rotation = |scene: &Scene, frame: usize| {
        let pose = mocap::Pose::at_tick(scene, 0, frame as f64).unwrap();
        pose.node_to_world[head].to_scale_rotation_translation().1.as_dquat()
    };
    let added = |frame: usize| rotation(&before, frame).inverse() * rotation(&scene, frame);
    let frames = before.animations[0].frame_count();
    let added: Vec<_> = (0..frames).map(added).collect();
    let fastest = added
        .windows(2)
        .map(|pair| pair[0].angle_between(pair[1]).to_degrees() * rate);
    let fastest = fastest.fold(0.0, f64::max);
    // The motion of the head itself moves the rotation axis of the neck.
    assert!(fastest < 1.1 * 400.0, "{fastest} degrees a second");
}

/// A motion that was turned and lifted is restored.
#[test]
fn turned_about_the_vertical_the_figure_looks_elsewhere() {
    let before = import("cmu_12_01_walk.bvh");
    let at = exact_positions(&before);
    let mut scene = before.clone();
    apply(&mut scene, "turn:by=90").unwrap();
    let hips = joint(&before, "hips");
    let pivot = at[0][hips];
    for (now, was) in exact_positions(&scene).iter().zip(&at) {
        for (now, was) in now.iter().zip(was) {
            let from = *was - pivot;
            // A rotation about +Y moves +Z to +X.
            let turned = pivot + DVec3::new(from.z, from.y, -from.x);
            assert!(now.distance(turned) < 1e-5, "{now} {turned}");
        }
    }
    apply(&mut scene, "turn:facing=z").unwrap();
    let report = apply(&mut scene, "turn:facing=z").unwrap();
    let StepReport::Turn(turn) = &report.changed else {
        unreachable!()
    };
    assert!(turn.by.abs() < 1e-3, "{report}");
    for (step, message) in [
        ("turn", "turn takes either by=DEGREES or facing=AXIS"),
        ("turn:facing=y", "facing takes an axis along the ground, got y"),
    ] {
        let error = apply(&mut scene, step).unwrap_err();
        assert_eq!(error.diagnostic().message, message);
    }
}

/// A walk that is lifted by 30 cm, and a walk on a slope of 3 degrees, stand on the floor afterwards.
#[test]
fn a_motion_is_put_on_the_floor() {
    let before = import("cmu_12_01_walk.bvh");
    let mut lifted = before.clone();
    for channel in &mut lifted.animations[0].channels {
        if channel.position_keys.len() > 1 {
            channel.position_keys.values.iter_mut().for_each(|at| at.y += 0.3);
        }
    }
    let (toes, floor) = (joint(&before, "leftToes"), |scene: &Scene| {
        let [left, right] = ["leftToes", "rightToes"].map(|bone| joint(scene, bone));
        let mut lowest: Vec<f64> = exact_positions(scene)
            .iter()
            .map(|at| at[left].y.min(at[right].y))
            .collect();
        lowest.sort_unstable_by(f64::total_cmp);
        lowest[lowest.len() / 10]
    });
    assert!(toes > 0 && floor(&lifted) > 0.29);
    let report = apply(&mut lifted, "ground").unwrap();
    let off = floor(&lifted) - floor(&before);
    assert!(off.abs() < 0.02, "{off} {report}");
}

/// The tip of the hand of the lecture's arm, which is no humanoid, moves to a point in frames 3 to 5. The tip of a
/// humanoid's hand does the same, with all joints of its arm. Joints keep their distances, and nothing else moves.
#[test]
fn the_tip_of_any_chain_reaches_its_target() {
    for (file, step, start, tip, range) in [
        (
            "lecture_Test.bvh",
            "reach:start=Shoulder,to=1.5/2.5/0.4",
            "Shoulder",
            "EndSite_Wrist",
            3..6,
        ),
        (
            "cmu_12_01_walk.bvh",
            "reach:start=LeftArm,tip=LeftHandIndex1,to=head",
            "LeftArm",
            "LeftHandIndex1",
            100..131,
        ),
    ] {
        let before = import(file);
        let mut scene = before.clone();
        let (first, last) = (range.start, range.end - 1);
        let report = apply(
            &mut scene,
            &format!("{step},range={first}f..{last}f,ease-in=0.1,ease-out=0.1"),
        )
        .unwrap();
        let StepReport::Reach(reach) = &report.changed else {
            unreachable!()
        };
        assert_eq!(
            (reach.limb.frames, reach.limb.out_of_reach),
            (range.len(), 0),
            "{file}: {report}"
        );
        let index = |name: &str| before.find_node(name).unwrap().index();
        let (start, tip) = (index(start), index(tip));
        let (was, is) = (exact_positions(&before), exact_positions(&scene));
        let metres = Figure::new(&before).survey.metres_per_unit;
        let ease = (0.1 * before.animations[0].ticks_per_second).ceil() as usize;
        for frame in 0..was.len() {
            if range.contains(&frame) {
                let target = match file {
                    "lecture_Test.bvh" => DVec3::new(1.5, 2.5, 0.4) / metres,
                    _ => is[frame][joint(&before, "head")],
                };
                let left = is[frame][tip].distance(target) * metres;
                assert!(left < 1e-4, "{file}: frame {frame}: {left} m");
            }
            let near = (first.saturating_sub(ease)..=last + ease).contains(&frame);
            for node in 0..was[frame].len() {
                let mut above = Some(node);
                while above.is_some_and(|node| node != start) {
                    above = before.nodes[above.unwrap()].parent.map(NodeId::index);
                }
                let moved = is[frame][node].distance(was[frame][node]) * metres;
                assert!(
                    (above.is_some() && near) || moved < 1e-5,
                    "{file}: node {node} in frame {frame}: {moved}"
                );
            }
        }
        assert_bones_keep_their_lengths(&before, &scene);
    }
}

/// The tip of a chain stays at its place although a moving shoulder carries the chain.
#[test]
fn the_tip_of_any_chain_is_pinned() {
    let mut scene = import("lecture_Test.bvh");
    let report = apply(&mut scene, "pin:start=Shoulder,range=2f..6f").unwrap();
    let StepReport::Pin(pin) = &report.changed else {
        unreachable!()
    };
    assert_eq!(
        (pin.contacts.as_slice(), pin.limb.out_of_reach),
        ([[2, 6]].as_slice(), 0),
        "{report}"
    );
    let at = exact_positions(&scene);
    let farthest = (2..=6).map(|frame| at[frame][3].distance(at[2][3])).fold(0.0, f64::max);
    assert!(farthest < 1e-4 && pin.slide_before > 1.0, "{farthest}: {report}");
}

/// For a skeleton without limbs, the message says how to move a chain of joints to a target.
#[test]
fn without_limbs_a_chain_is_offered() {
    let error = apply(&mut import("lecture_Test.bvh"), "reach:to=1/1/0").unwrap_err();
    assert_eq!(error.code(), mocap::Code::NotHumanoid);
    assert!(
        error.diagnostic().help.as_ref().unwrap().contains("start=JOINT"),
        "{error}"
    );
}
