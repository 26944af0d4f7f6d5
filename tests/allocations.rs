//! Updating nodes does not allocate after the binding is made.

#![allow(unsafe_code, reason = "a global allocator cannot be written without")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use mocap::compress::PackedClip;
use mocap::glam::{Mat4, Quat, Vec2, Vec3};
use mocap::matching::{Controller, Database, IndexedClip, Moves, Trajectory};
use mocap::retarget::{PoseRetargetOptions, PoseRetargeter};
use mocap::retarget::{RetargetOptions, Retargeter};
use mocap::scene::{Animation, Channel, Keys, Node, NodeId, Scene};
use mocap::{Binding, Conversion, LoopMode, Player, Pose, Trs, Updater};

/// The system's allocator with a count of allocations.
struct Counting;

thread_local! {
    /// Each thread has its own count, so that the test runner's allocations are not counted.
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call goes unchanged to the system's allocator. The default `realloc` and `alloc_zeroed` call `alloc`,
// so these calls are counted too.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller keeps the rules of `GlobalAlloc::alloc`, which are also the rules of the system's
        // allocator.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: `pointer` comes from `alloc` above, and so from the system's allocator.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

fn allocations_of(work: impl FnOnce()) -> usize {
    let before = ALLOCATIONS.get();
    work();
    ALLOCATIONS.get() - before
}

/// A chain of 30 joints that all rotate. Half of them store the tick of each key; the others have a key at every tick.
fn chain() -> Scene {
    let mut scene = Scene::default();
    let mut animation = Animation {
        ticks_per_second: 100.0,
        duration: 49.0,
        ..Animation::default()
    };
    for index in 0usize..30 {
        scene.nodes.push(Node {
            name: format!("joint {index}"),
            parent: index.checked_sub(1).map(NodeId::new),
            transform: Mat4::from_translation(Vec3::X),
            ..Node::default()
        });
        animation.channels.push(Channel {
            node_name: format!("joint {index}"),
            node: None,
            position_keys: Keys::constant(Vec3::X),
            rotation_keys: Keys {
                values: (0..50u8)
                    .map(|tick| Quat::from_rotation_z(f32::from(tick) * 0.01))
                    .collect(),
                ticks: (index % 2 == 0).then(|| (0..50u8).map(f64::from).collect()),
            },
            scaling_keys: Keys::constant(Vec3::ONE),
        });
    }
    scene.animations.push(animation);
    scene
}

#[test]
fn the_counter_counts() {
    assert_eq!(allocations_of(|| drop(std::hint::black_box(Box::new(1)))), 1);
    assert!(allocations_of(|| drop(Pose::rest(&chain()))) > 30);
}

#[test]
fn an_update_of_the_scene_allocates_nothing() {
    let mut scene = chain();
    let updater = Updater::new(&scene, 0).unwrap();
    let count = allocations_of(|| {
        for tick in [0.0, 1.0, 1.5, 48.9, 1e9, -1.0, f64::NAN] {
            updater.update(&mut scene, tick);
        }
    });
    assert_eq!(count, 0);
}

#[test]
fn playing_into_a_pose_allocates_nothing() {
    let scene = chain();
    let animation = &scene.animations[0];
    let binding = Binding::new(&scene, animation);
    let mut pose = Pose::rest(&scene);
    let rest = pose.clone();
    let mut player = Player::new(animation);
    let mut tips = 0.0;
    let count = allocations_of(|| {
        for loop_mode in [LoopMode::Loop, LoopMode::PingPong, LoopMode::Once] {
            player.loop_mode = loop_mode;
            for _ in 0..100 {
                pose.sample(&binding, animation, player.advance(0.0123));
                tips += scene.end_effectors().map(|end| pose.position(end).x).sum::<f32>();
            }
        }
        pose.copy_from(&scene);
    });
    assert_eq!(count, 0);
    assert!(tips > 0.0);
    assert_eq!(pose, rest);
}

#[test]
fn a_pose_on_another_skeleton_takes_none() {
    let read = |file: &str| mocap::import(format!("fixtures/skeletons/{file}")).unwrap();
    let (source, target) = (read("xsens_names_tpose.bvh"), read("human_default.gltf"));
    let mut retargeter = PoseRetargeter::new(&source, &target, &PoseRetargetOptions::default()).unwrap();
    let binding = Binding::new(&source, &source.animations[0]);
    let (mut from, mut to) = (Pose::rest(&source), Pose::rest(&target));
    let rest = to.clone();
    let count = allocations_of(|| {
        for tick in 0..100 {
            from.sample(&binding, &source.animations[0], f64::from(tick));
            retargeter.pose(&from, &mut to);
        }
    });
    assert_eq!(count, 0);
    assert_ne!(to, rest);
}

#[test]
fn a_pose_from_a_packed_clip_takes_none() {
    let clip = PackedClip::encode(&chain(), 0, 0.001).unwrap();
    let mut pose = vec![Trs::IDENTITY; clip.node_count()];
    let count = allocations_of(|| {
        for tick in [0.0, 1.0, 1.5, 48.9, 1e9, -1.0, f64::NAN] {
            clip.sample(tick, &mut pose);
        }
    });
    assert_eq!(count, 0);
    assert_ne!(pose[7], Trs::IDENTITY);
}

#[test]
fn a_frame_of_motion_matching_takes_none() {
    let walk = mocap::import("fixtures/real/cmu_12_01_walk.bvh").unwrap();
    let database = Database::new(IndexedClip::of(&walk, "walk.bvh", false));
    let mut hero = mocap::import("fixtures/real/rokoko_dance.bvh").unwrap();
    Conversion::new().apply(&mut hero).unwrap();
    let clips = Retargeter::new(walk, hero.clone(), RetargetOptions::new()).unwrap();
    let mut moves = Moves::new(&hero).unwrap();
    moves.add(&database.clips()[0], &clips.clips()[0].animation).unwrap();
    let mut controller = Controller::new(&database, moves, Vec3::ZERO, Vec3::Z).unwrap();
    let allocations = allocations_of(|| {
        for _ in 0..600 {
            let ahead = [1.0, 2.0, 3.0].map(|thirds| controller.position() + thirds / 3.0 * Vec3::Z);
            controller.update(&Trajectory::new(ahead, [Vec3::Z; 3]));
            controller.steer(Vec2::Y, Vec2::ZERO);
        }
    });
    assert_eq!(allocations, 0);
    assert!(controller.jumps() > 1 && controller.position().z > 2.0);
}
