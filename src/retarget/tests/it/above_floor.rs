//! Tests that the whole skin of a falling and lying body stays above the floor, in every frame.

use std::f32::consts::FRAC_PI_2;

use mocap::glam::{Quat, Vec3};
use mocap::retarget::{RetargetOptions, Retargeter};
use mocap::scene::Animation;
use mocap::{Binding, Importer, Pose, Scene};

const WALK: &str = "../../fixtures/real/cmu_12_01_walk.bvh";

/// The height of the source's lowest joint above its floor while it lies, as a fraction of the source's height.
const LIES: f32 = 0.03;

/// Characters, each with the axis about which it tips. They come to lie on the back, on the face and on both sides.
const FALLS: [(&str, Vec3); 4] = [
    ("human_default.glb", Vec3::X),
    ("human_game_engine.glb", Vec3::NEG_X),
    ("human_vrm0.vrm", Vec3::Z),
    ("human_default.glb", Vec3::NEG_Z),
];

/// The heights of the lowest and of the highest joint of a pose.
fn extent(pose: &Pose) -> [f32; 2] {
    let heights = pose.node_to_world.iter().map(|matrix| matrix.w_axis.y);
    heights.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], height| {
        [low.min(height), high.max(height)]
    })
}

/// A walk that tips over in its second third, and lies in its last third.
fn fall(axis: Vec3) -> Scene {
    let mut scene = mocap::import(WALK).unwrap();
    let walk = scene.animations[0].clone();
    let binding = Binding::new(&scene, &walk);
    let mut pose = Pose::rest(&scene);
    let frames = walk.frame_count();
    let mut at = |frame: usize, animation: &Animation| {
        pose.sample(&binding, animation, frame as f64);
        extent(&pose)
    };
    let [floor, top] = at(frames / 6, &walk);
    for frame in frames / 3..frames {
        let part = (3.0 * frame as f32 / frames as f32 - 1.0).min(1.0);
        let mut animation = scene.animations[0].clone();
        let hips = &mut animation.channels[0];
        hips.rotation_keys.values[frame] =
            Quat::from_axis_angle(axis, part * FRAC_PI_2) * hips.rotation_keys.values[frame];
        let [lowest, _] = at(frame, &animation);
        let wanted = floor + part * LIES * (top - floor);
        animation.channels[0].position_keys.values[frame].y += wanted - lowest;
        scene.animations[0] = animation;
    }
    scene
}

/// The depth of the lowest vertex below its height at rest in each frame, as a fraction of the body's height.
fn depths(scene: &Scene, animation: &Animation) -> Vec<f32> {
    let binding = Binding::new(scene, animation);
    let mut pose = Pose::rest(scene);
    let heights = |pose: &Pose| {
        let vertices = scene.meshes.iter().filter(|mesh| !mesh.bones.is_empty());
        let vertices = vertices.flat_map(|mesh| pose.skin(mesh));
        vertices.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], vertex| {
            [low.min(vertex.y), high.max(vertex.y)]
        })
    };
    let [floor, top] = heights(&pose);
    let frames = (0..animation.frame_count()).step_by(4);
    let depth = |frame: usize| {
        pose.sample(&binding, animation, frame as f64);
        (floor - heights(&pose)[0]) / (top - floor)
    };
    frames.map(depth).collect()
}

/// The last third of a fall: a body that lies all the time. On its face, it rests on its toes.
fn lie(axis: Vec3) -> Scene {
    let mut scene = fall(axis);
    let animation = &mut scene.animations[0];
    let frames = animation.frame_count();
    let from = 2 * frames / 3 + 1;
    for channel in &mut animation.channels {
        for keys in [&mut channel.position_keys, &mut channel.scaling_keys] {
            if keys.values.len() == frames {
                keys.values.drain(..from);
            }
        }
        if channel.rotation_keys.values.len() == frames {
            channel.rotation_keys.values.drain(..from);
        }
    }
    animation.duration -= from as f64;
    scene
}

#[test]
fn who_lies_all_the_time_lies_on_the_floor_and_neither_in_it_nor_above_it() {
    // 2 cm of a person of 1.7 m.
    const SEEN: f32 = 0.02 / 1.7;
    // A body on its side rests on shoulders and hips, whose widths differ between bodies.
    for (character, axis) in FALLS.into_iter().take(2) {
        let file = format!("../../fixtures/characters/{character}");
        let target = Importer::new().gltf_meshes(true).import(file).unwrap();
        let retargeting = Retargeter::new(lie(axis), target.clone(), RetargetOptions::new()).unwrap();
        let depths = depths(&target, &retargeting.clips()[0].animation);
        let deepest = depths.into_iter().fold(f32::NEG_INFINITY, f32::max);
        assert!(
            deepest.abs() < SEEN,
            "{character} about {axis}: {deepest} of the height"
        );
    }
}

#[test]
fn who_falls_lies_on_the_floor_and_not_in_it() {
    // 2 cm of a person of 1.7 m.
    const SEEN: f32 = 0.02 / 1.7;
    let mut deep = 0;
    for (character, axis) in FALLS {
        let file = format!("../../fixtures/characters/{character}");
        let target = Importer::new().gltf_meshes(true).import(file).unwrap();
        let counts = [false, true].map(|lock| {
            let options = RetargetOptions::new().lock_feet(lock);
            let retargeting = Retargeter::new(fall(axis), target.clone(), options).unwrap();
            let depths = depths(&target, &retargeting.clips()[0].animation);
            depths.into_iter().filter(|depth| *depth > SEEN).count()
        });
        let [free, kept] = counts;
        assert!(kept == 0, "{character} about {axis}: {kept} frames, {free} before");
        deep += free;
    }
    assert!(deep > 0, "nothing was too deep");
}
