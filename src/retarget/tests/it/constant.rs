//! Laws for the keys of motions on another skeleton. A joint with a constant position or rotation has one key. A motion
//! of constant speed keeps its speed on its own skeleton.

use mocap::Scene;
use mocap::glam::{Quat, Vec3};
use mocap::retarget::{RetargetOptions, Retargeter, Scale};
use mocap::scene::Keys;

use crate::positions::import;
use crate::still::still_joints;

const WALK: &str = "cmu_12_01_walk.bvh";

/// The number of frames of a motion of constant speed.
const FRAMES: usize = 30;

fn on(source: Scene, target: Scene) -> Scene {
    let options = RetargetOptions::new().scale(Scale::Factor(1.0)).lock_feet(false);
    Retargeter::new(source, target, options).unwrap().scene()
}

/// Whether a track has several keys with one value.
fn is_blurred<T: Copy>(keys: &Keys<T>, distance: impl Fn(T, T) -> f32, least: f32) -> bool {
    match keys.values.as_slice() {
        [first, others @ ..] => !others.is_empty() && others.iter().all(|value| distance(*first, *value) <= least),
        [] => false,
    }
}

#[test]
fn joints_that_keep_their_places_have_one_position_key_on_every_skeleton() {
    let walk = import(WALK);
    for target in [
        "real/cmu_short.bvh",
        "skeletons/accad_run_turn.bvh",
        "real/cmu_12_01_walk.bvh",
    ] {
        let skeleton = mocap::import(format!("../../fixtures/{target}")).unwrap();
        let size = skeleton
            .nodes
            .iter()
            .map(|node| node.transform.w_axis.truncate().length());
        let size = size.fold(f32::MIN_POSITIVE, f32::max);
        let done = on(walk.clone(), skeleton);
        let channels = &done.animations[0].channels;
        let moving = channels.iter().filter(|channel| channel.position_keys.len() > 1);
        let moving: Vec<&str> = moving.map(|channel| &*channel.node_name).collect();
        assert!(moving.len() <= 1, "{target}: {moving:?} have several positions");
        for channel in channels {
            let name = &channel.node_name;
            let distance = |a: Vec3, b: Vec3| a.distance(b);
            assert!(
                !is_blurred(&channel.position_keys, distance, 1e-4 * size),
                "{target}: positions of {name}"
            );
        }
    }
}

/// The text of the file shows which joints are still. On their own skeleton these joints stay still.
#[test]
fn joints_that_are_still_in_the_text_of_a_file_have_one_rotation_key() {
    let mut tried = 0;
    for file in [
        "real/cmu_mixed_rotation_orders.bvh",
        "real/motionbuilder_vicon_walk.bvh",
        "real/rokoko_dance.bvh",
        "skeletons/accad_run_turn.bvh",
    ] {
        let source = mocap::import(format!("../../fixtures/{file}")).unwrap();
        let done = on(source.clone(), source);
        let still = still_joints(file);
        for channel in &done.animations[0].channels {
            if still.contains(&channel.node_name) {
                assert_eq!(channel.rotation_keys.len(), 1, "{file}: {}", channel.node_name);
                tried += 1;
            }
        }
    }
    assert!(tried > 10, "{tried} joints are still");
}

/// Each joint of the walk rotates from its pose in the first frame, about its own axis and at a constant speed.
#[test]
fn a_motion_of_constant_speed_keeps_it_on_its_own_skeleton() {
    let mut source = import(WALK);
    source.trim(0.0, FRAMES as f64 - 1.0);
    let target = source.clone();
    let turn = |joint: usize, frame: usize| {
        let axis = Vec3::new((joint as f32).sin(), (joint as f32).cos(), 0.5).normalize();
        Quat::from_axis_angle(axis, 0.01 * frame as f32)
    };
    let mut expected = Vec::new();
    for (joint, channel) in source.animations[0].channels.iter_mut().enumerate() {
        let Some(first) = channel.rotation_keys.values.first().copied() else {
            continue;
        };
        let values: Vec<Quat> = (0..FRAMES).map(|frame| first * turn(joint, frame)).collect();
        channel.rotation_keys = Keys::every_tick(values.clone());
        expected.push((channel.node_name.clone(), values));
        if let [first, .., last] = *channel.position_keys.values.as_slice() {
            let line = |frame: usize| first.lerp(last, frame as f32 / (FRAMES - 1) as f32);
            channel.position_keys = Keys::every_tick((0..FRAMES).map(line).collect());
        }
    }
    let done = on(source.clone(), target);
    for (name, values) in expected {
        let mut channels = done.animations[0].channels.iter();
        let own = channels.find(|channel| channel.node_name == name).unwrap();
        for (frame, value) in values.into_iter().enumerate() {
            let found = own.rotation_keys.values[frame.min(own.rotation_keys.len() - 1)];
            assert!(
                found.angle_between(value) < 2e-3,
                "{name}, frame {frame}: {found} and not {value}"
            );
        }
    }
}
