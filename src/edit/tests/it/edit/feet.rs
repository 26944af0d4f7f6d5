//! Tests of contacts and the foot lock.

use mocap::edit::{ContactOptions, FootLockOptions, foot_lock};
use mocap::figure::{Figure, HumanoidBone};

use mocap::scene::UpAxis;

use super::*;

/// Clips of seven programs in which a person stands, walks or dances.
const CLIPS: [&str; 7] = [
    "cmu_12_01_walk.bvh",
    "motionbuilder_vicon_walk.bvh",
    "cmu_salsa_poser_names.bvh",
    "mocopi_jump_six_channels.bvh",
    "z_up_dab.bvh",
    "kinect_openni.bvh",
    "additive_root_walk.bvh",
];

#[test]
fn feet_of_real_clips_hold_still_and_stay_above_the_floor() {
    for file in CLIPS {
        let mut scene = import(file);
        let before = scene.clone();
        let found = ContactOptions::default().detect(&before, 0, None).unwrap();
        let report = foot_lock(&mut scene, 0, &FootLockOptions::default()).unwrap();
        assert_bones_keep_their_lengths(&before, &scene);
        assert_eq!(scene.validate(), [], "{file}");

        // The slide is measured from positions alone: how far the ball of a foot moves in frames in which it rests.
        let at = positions(&scene);
        let (mut slid, mut slid_before) = (0.0, 0.0);
        let was_at = positions(&before);
        for point in [HumanoidBone::LeftToes, HumanoidBone::RightToes].map(|bone| found.point(bone).unwrap()) {
            let over_ground = |at: &[Vec<Vec3>], frame: usize| {
                let step = at[frame + 1][point.node.index()] - at[frame][point.node.index()];
                step.reject_from(Vec3::Y).length()
            };
            for frame in (0..found.frames - 1).filter(|&frame| point.at_rest[frame] && point.at_rest[frame + 1]) {
                slid += over_ground(&at, frame);
                slid_before += over_ground(&was_at, frame);
            }
        }
        assert!(slid < 0.05 * slid_before, "{file}: {slid} of {slid_before}");
        assert!(report.slide_after < 0.05 * report.slide_before, "{file}: {report:?}");

        let feet = [HumanoidBone::LeftFoot, HumanoidBone::RightFoot].map(|bone| found.point(bone).unwrap().node);
        let is_of_foot = |mut node: NodeId| loop {
            match scene.nodes[node.index()].parent {
                _ if feet.contains(&node) => return true,
                Some(parent) => node = parent,
                None => return false,
            }
        };
        let nodes: Vec<_> = (0..scene.nodes.len())
            .filter(|node| is_of_foot(NodeId::new(*node)))
            .collect();
        let lowest = at
            .iter()
            .flat_map(|frame| nodes.iter().map(|node| frame[*node].y))
            .fold(f32::MAX, f32::min);
        assert!(lowest > found.floor - 1e-3, "{file}: {lowest} is below {}", found.floor);
    }
}

/// In the clips with the most foot sliding, other joints move by more than 2 cm. With a limit of 2 cm, they stay within
/// the limit.
#[test]
fn other_joints_stay_within_a_limit() {
    for (file, mut largest) in [
        ("cmu_12_01_walk.bvh", 0.025),
        ("cmu_salsa_poser_names.bvh", 0.04),
        ("mocopi_jump_six_channels.bvh", 0.04),
        ("z_up_dab.bvh", 0.02),
    ] {
        for largest_change in [None, Some(0.02)] {
            let mut scene = import(file);
            let before = positions(&scene);
            let options = FootLockOptions::new().largest_change(largest_change);
            let report = foot_lock(&mut scene, 0, &options).unwrap();
            let found = ContactOptions::default().detect(&scene, 0, None).unwrap();
            let feet = [HumanoidBone::LeftFoot, HumanoidBone::RightFoot].map(|bone| found.point(bone).unwrap().node);
            let is_of_foot = |node: NodeId| {
                let mut above = std::iter::successors(Some(node), |node| scene.nodes[node.index()].parent);
                above.any(|node| feet.contains(&node))
            };
            let others: Vec<usize> = (0..scene.nodes.len())
                .filter(|node| !is_of_foot(NodeId::new(*node)))
                .collect();
            let after = positions(&scene);
            let change = |frame: usize, node: &usize| before[frame][*node].distance(after[frame][*node]);
            let frames = 0..before.len();
            let most = frames.flat_map(|frame| others.iter().map(move |node| change(frame, node)));
            let most = most.fold(0.0, f32::max);
            assert!(
                (most - report.largest_other_change).abs() < 1e-3,
                "{file}: {most} {report:?}"
            );
            assert!(most < largest, "{file}: {most}");
            assert!(report.slide_after < 0.2 * report.slide_before, "{file}: {report:?}");
            largest = 0.02;
        }
    }
}

/// Joints accelerate no more than before the lock: knees do not pop, and toes do not jump.
#[test]
fn no_joint_is_jerked() {
    for file in [
        "cmu_12_01_walk.bvh",
        "motionbuilder_vicon_walk.bvh",
        "additive_root_walk.bvh",
    ] {
        let mut scene = import(file);
        let before = accelerations(&positions(&scene));
        foot_lock(&mut scene, 0, &FootLockOptions::default()).unwrap();
        let after = accelerations(&positions(&scene));
        let mut sorted = before.concat();
        sorted.sort_unstable_by(f32::total_cmp);
        let usual = sorted[sorted.len() * 99 / 100];
        for (frame, values) in after.iter().enumerate() {
            let around = &before[frame.saturating_sub(3)..(frame + 4).min(before.len())];
            for (node, value) in values.iter().enumerate() {
                let was = around.iter().map(|before| before[node]).fold(0.0, f32::max);
                let most = 1.1 * was.max(1.5 * usual);
                assert!(
                    *value < most,
                    "{file}: {} in frame {frame}: {value}, {most}",
                    scene.nodes[node].name
                );
            }
        }
    }
}

/// In the first clip, both feet are below the floor by unlike heights, because its recording rises by 20 cm.
#[test]
fn hips_move_over_the_ground_no_farther_than_feet() {
    for file in ["hip_knee_ankle_names.bvh", "rokoko_dance.bvh", "kinect_openni.bvh"] {
        let mut scene = import(file);
        let before = positions(&scene);
        let found = ContactOptions::default().detect(&scene, 0, None).unwrap();
        let report = foot_lock(&mut scene, 0, &FootLockOptions::default()).unwrap();
        let after = positions(&scene);
        let feet = found.points.iter().map(|point| point.node.index());
        let hips = Figure::new(&scene).humanoid.joint(HumanoidBone::Hips).unwrap().index();
        let over_ground = |node: usize| {
            let shifts = before
                .iter()
                .zip(&after)
                .map(|(a, b)| (b[node] - a[node]).reject_from(Vec3::Y));
            shifts.map(Vec3::length).fold(0.0, f32::max)
        };
        let (hips, feet) = (over_ground(hips), feet.map(over_ground).fold(0.0, f32::max));
        assert!(hips <= feet + 1e-3, "{file}: hips {hips}, feet {feet}, {report:?}");
    }
}

/// Locking never adds speed spikes: no foot is much faster with the lock, or accelerates much more.
#[test]
fn locked_feet_are_no_faster_than_free_ones() {
    for file in CLIPS {
        let mut scene = import(file);
        let free = positions(&scene);
        let found = ContactOptions::default().detect(&scene, 0, None).unwrap();
        let joints: Vec<NodeId> = found.points.iter().map(|point| point.node).collect();
        let report = foot_lock(&mut scene, 0, &FootLockOptions::default()).unwrap();
        let [speed, acceleration] = ratios(&positions(&scene), &free, &joints, found.frame_rate as f32);
        assert!(speed <= 1.2 && acceleration <= 1.5, "{file}: {speed} {acceleration}");
        let differs = (report.speed_ratio - speed)
            .abs()
            .max((report.acceleration_ratio - acceleration).abs());
        assert!(differs < 0.05, "{file}: {speed} {acceleration} {report:?}");
    }
}

/// The accelerations of all joints, frame by frame.
fn accelerations(at: &[Vec<Vec3>]) -> Vec<Vec<f32>> {
    let of_frame = |frames: &[Vec<Vec3>]| {
        let nodes = 0..frames[0].len();
        let of_node = |node: usize| (frames[2][node] - 2.0 * frames[1][node] + frames[0][node]).length();
        nodes.map(of_node).collect()
    };
    at.windows(3).map(of_frame).collect()
}

#[test]
fn what_holds_still_already_does_not_change() {
    let mut scene = import("cmu_12_01_walk.bvh");
    let first = foot_lock(&mut scene, 0, &FootLockOptions::default()).unwrap();
    let once = positions(&scene);
    let report = foot_lock(&mut scene, 0, &FootLockOptions::default()).unwrap();
    // The contacts of the locked motion may begin a frame earlier and end a frame later.
    assert!(report.slide_before < 0.1 * first.slide_before, "{report:?}");
    let moved = once
        .iter()
        .zip(positions(&scene))
        .flat_map(|(a, b)| a.iter().zip(b).map(|(a, b)| a.distance(b)).collect::<Vec<_>>());
    let moved = moved.fold(0.0, f32::max);
    assert!(moved < 0.03, "{moved}");
}

#[test]
fn the_unit_of_the_scene_changes_nothing() {
    let metres = import("z_up_dab.bvh");
    let mut inches = metres.clone();
    inches.convert_units(1.0 / 0.0254, UpAxis::Y);
    inches.metadata.metres_per_unit = Some(0.0254);
    let options = ContactOptions::new().hands(true);
    let (a, b) = (
        options.detect(&metres, 0, None).unwrap(),
        options.detect(&inches, 0, None).unwrap(),
    );
    assert_eq!((a.frames, a.points.len(), b.points.len()), (b.frames, 6, 6));
    for (a, b) in a.points.iter().zip(&b.points) {
        // One frame may be exactly on a threshold.
        let differ = a.at_rest.iter().zip(&b.at_rest).filter(|(a, b)| a != b).count();
        assert!(differ <= 1, "{}: {differ}", a.name);
        assert!((a.height - b.height).abs() < 1e-5);
    }
}

#[test]
fn what_cannot_be_done_is_refused_and_changes_nothing() {
    let mut arm = mocap::import("../../fixtures/real/lecture_Test.bvh").unwrap();
    let before = arm.clone();
    let error = foot_lock(&mut arm, 0, &FootLockOptions::default()).unwrap_err();
    assert_eq!(error.code().as_str(), "not-humanoid");
    assert_eq!(arm, before);

    let mut walk = import("cmu_short.bvh");
    let before = walk.clone();
    let refused = |walk: &mut Scene, animation, options: FootLockOptions| {
        foot_lock(walk, animation, &options)
            .unwrap_err()
            .diagnostic()
            .message
            .clone()
    };
    let known = ContactOptions::default()
        .detect(&import("cmu_12_01_walk.bvh"), 0, None)
        .unwrap();
    let other_frames = FootLockOptions::new().known(Some(known));
    assert_eq!(
        refused(&mut walk, 0, other_frames),
        "the known contacts have another number of frames"
    );
    assert_eq!(
        refused(&mut walk, 7, FootLockOptions::default()),
        "there is no animation 7: the scene has 1"
    );
    let endless = FootLockOptions::new().blend(f64::NAN);
    assert_eq!(
        refused(&mut walk, 0, endless),
        "blend must be finite and not negative, got NaN"
    );
    let high = |floor| FootLockOptions::new().floor(Some(floor));
    for floor in [1e30, f32::INFINITY, f32::NAN, 1.5] {
        let refused = refused(&mut walk, 0, high(floor));
        assert!(
            refused.ends_with(&format!("above the resting height of the feet, 0.000 m, got {floor}")),
            "{refused}"
        );
    }
    assert_eq!(walk, before);
}
/// Clean clips in which the whole figure slides. Tests that the drift is found, and how much of it remains.
#[test]
fn a_known_slide_is_found_and_taken_back() {
    for file in ["cmu_12_01_walk.bvh", "motionbuilder_vicon_walk.bvh", "z_up_dab.bvh"] {
        let mut clean = import(file);
        // In a locked motion, contacts begin a little earlier and end a little later. So the clip is locked twice.
        for _ in 0..2 {
            foot_lock(&mut clean, 0, &FootLockOptions::default()).unwrap();
        }
        let found = ContactOptions::default().detect(&clean, 0, None).unwrap();
        let rate = clean.animations[0].ticks_per_second as f32;
        for speed in [0.01f32, 0.05, 0.1, 0.2] {
            let mut scene = clean.clone();
            let hips = scene.animations[0]
                .channels
                .iter_mut()
                .find(|channel| channel.position_keys.len() > 1);
            for (frame, position) in hips.unwrap().position_keys.values.iter_mut().enumerate() {
                position.x += speed * frame as f32 / rate;
            }
            let slid = ContactOptions::default().detect(&scene, 0, None).unwrap();
            let slid_at = positions(&scene);
            let (mut hits, mut all) = (0, 0);
            for bone in [HumanoidBone::LeftToes, HumanoidBone::RightToes] {
                let (before, after) = (found.point(bone).unwrap(), slid.point(bone).unwrap());
                for frame in 0..found.frames - 1 {
                    let step = |at: &[Vec<Vec3>]| {
                        let step = at[frame + 1][after.node.index()] - at[frame][after.node.index()];
                        step.reject_from(Vec3::Y).length() * rate
                    };
                    if before.at_rest[frame] && before.at_rest[frame + 1] {
                        all += 1;
                        let is_found = after.at_rest[frame] && after.at_rest[frame + 1];
                        hits += usize::from(is_found && step(&slid_at) > 0.5 * speed);
                    }
                }
            }
            let report = foot_lock(&mut scene, 0, &FootLockOptions::default()).unwrap();
            let recall = hits as f32 / all as f32;
            assert!(
                recall > if speed < 0.2 { 0.95 } else { 0.85 },
                "{file} at {speed}: {recall}"
            );
            // A foot that stands for five seconds at 0.2 m/s would end a metre away, so its lock is relaxed.
            let largest = if speed < 0.2 { 0.1 } else { 0.25 };
            assert!(
                report.slide_after < largest * report.slide_before,
                "{file} at {speed}: {report:?}"
            );
        }
    }
}
