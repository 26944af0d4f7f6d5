//! Compares motions on entities with the closed form of the lecture's motion, and with the library's kinematics.

use std::time::Duration;

use bevy::prelude::*;
use mocap::scene::Scene;
use mocap::{LoopMode, Pose};
use mocap_bevy::{
    Clip, Motion, MotionFailed, MotionFinished, MotionLooped, MotionPlayer, MotionPlugin, MotionStarted, spawn,
};

const FIXTURES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures");
const STEP: Duration = Duration::from_millis(50);

/// The events that observers received, one word per event.
#[derive(Resource, Default)]
struct Heard(Vec<String>);

fn app() -> App {
    let mut app = App::new();
    let assets = AssetPlugin {
        file_path: FIXTURES.to_owned(),
        ..default()
    };
    app.add_plugins((TaskPoolPlugin::default(), assets, TransformPlugin, MotionPlugin))
        .init_resource::<Time>()
        .init_resource::<Heard>()
        .add_observer(|_: On<MotionStarted>, mut heard: ResMut<Heard>| heard.0.push("started".to_owned()))
        .add_observer(|_: On<MotionLooped>, mut heard: ResMut<Heard>| heard.0.push("looped".to_owned()))
        .add_observer(|_: On<MotionFinished>, mut heard: ResMut<Heard>| heard.0.push("finished".to_owned()))
        .add_observer(|failed: On<MotionFailed>, mut heard: ResMut<Heard>| heard.0.push(failed.reason.clone()));
    app
}

/// A figure with the skeleton of `scene`, and a player of the motion at `path`.
fn figure(app: &mut App, scene: &Scene, path: &str) -> (Entity, Vec<Entity>) {
    let motion = app.world().resource::<AssetServer>().load::<Motion>(path.to_owned());
    let root = app
        .world_mut()
        .spawn((Transform::default(), MotionPlayer::new(motion)))
        .id();
    let nodes = spawn(&mut app.world_mut().commands(), scene, root);
    app.world_mut().flush();
    (root, nodes)
}

/// Updates without time until another event arrives.
fn wait(app: &mut App) -> String {
    let before = app.world().resource::<Heard>().0.len();
    app.world_mut().resource_mut::<Time>().advance_by(Duration::ZERO);
    for _ in 0..2000 {
        app.update();
        if let Some(heard) = app.world().resource::<Heard>().0.get(before) {
            return heard.clone();
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("nothing was heard in ten seconds");
}

fn step(app: &mut App) {
    app.world_mut().resource_mut::<Time>().advance_by(STEP);
    app.update();
}

fn positions(app: &App, nodes: &[Entity]) -> Vec<Vec3> {
    let of = |&node: &Entity| app.world().get::<GlobalTransform>(node).unwrap().translation();
    nodes.iter().map(of).collect()
}

fn player(app: &mut App, root: Entity) -> Mut<'_, MotionPlayer> {
    app.world_mut().get_mut::<MotionPlayer>(root).unwrap()
}

/// The positions of the nodes at a tick. The shoulder is at (0.1 (tick + 1), 0.02 tick), the links are 2, 1.5 and 0.5
/// long. The joints are turned by 5, 10 and 8 degrees times tick + 1, relative to the link before.
fn arm(tick: f64) -> [Vec3; 4] {
    let count = tick + 1.0;
    let (mut x, mut y, mut degrees) = (0.1 * count, 0.02 * tick, 0.0);
    let mut step = |length: f64, turn: f64| {
        degrees += turn * count;
        x += length * f64::to_radians(degrees).cos();
        y += length * f64::to_radians(degrees).sin();
        Vec3::new(x as f32, y as f32, 0.0)
    };
    let shoulder = Vec3::new((0.1 * count) as f32, (0.02 * tick) as f32, 0.0);
    [shoulder, step(2.0, 5.0), step(1.5, 10.0), step(0.5, 8.0)]
}

#[test]
fn entities_stand_where_the_lecture_puts_the_arm() {
    let mut app = app();
    let scene = mocap::import(format!("{FIXTURES}/real/lecture_Test.bvh")).unwrap();
    let (root, nodes) = figure(&mut app, &scene, "real/lecture_Test.bvh");
    assert!(player(&mut app, root).is_waiting());
    assert_eq!(wait(&mut app), "started");
    for count in 0..19 {
        // A tick is a tenth of a second, so it takes two steps.
        for (place, expected) in positions(&app, &nodes).iter().zip(arm(f64::from(count) / 2.0)) {
            assert!(
                place.abs_diff_eq(expected, 1e-5),
                "step {count}: {place}, not {expected}"
            );
        }
        step(&mut app);
    }
    step(&mut app);
    assert_eq!(app.world().resource::<Heard>().0, ["started", "looped"]);
    // Plays once, and backwards.
    let mut once = player(&mut app, root);
    (once.loop_mode, once.speed) = (LoopMode::Once, -1.0);
    for _ in 0..30 {
        step(&mut app);
    }
    assert_eq!(app.world().resource::<Heard>().0[2..], ["finished"]);
    assert!(!player(&mut app, root).is_playing());
    assert!(positions(&app, &nodes)[3].abs_diff_eq(arm(0.0)[3], 1e-5));
    assert_eq!(app.world().get::<Name>(nodes[0]).unwrap().as_str(), "Shoulder");
}

/// The names of limbs in both skeletons, CMU's and MakeHuman's.
const LIMBS: [[&str; 4]; 4] = [
    ["LeftArm", "LeftForeArm", "upperarm01.L", "lowerarm01.L"],
    ["RightForeArm", "RightHand", "lowerarm01.R", "wrist.R"],
    ["LeftUpLeg", "LeftLeg", "upperleg01.L", "lowerleg01.L"],
    ["RightLeg", "RightFoot", "lowerleg01.R", "foot.R"],
];

#[test]
fn a_motion_of_another_skeleton_is_retargeted() {
    let mut app = app();
    let hero = mocap::import(format!("{FIXTURES}/skeletons/human_default.gltf")).unwrap();
    let walk = mocap::import(format!("{FIXTURES}/real/cmu_short.bvh")).unwrap();
    let (root, nodes) = figure(&mut app, &hero, "real/cmu_short.bvh");
    player(&mut app, root).lock_feet = false;
    assert_eq!(wait(&mut app), "started");
    let direction = |from: [f32; 3], to: [f32; 3]| (Vec3::from(to) - Vec3::from(from)).normalize();
    let mut seen = 0;
    for _ in 0..8 {
        let tick = player(&mut app, root).clock().unwrap().tick;
        let pose = Pose::at_tick(&walk, 0, tick).unwrap();
        let place = |name: &str| pose.position(walk.find_node(name).unwrap()).to_array();
        let entities = positions(&app, &nodes);
        let found = |name: &str| entities[hero.find_node(name).unwrap().index()].to_array();
        for [a, b, c, d] in LIMBS {
            let angle = direction(place(a), place(b)).angle_between(direction(found(c), found(d)));
            assert!(
                angle.to_degrees() < 2.0,
                "tick {tick}: {a} is {} degrees off",
                angle.to_degrees()
            );
            seen += 1;
        }
        step(&mut app);
    }
    assert_eq!(seen, 32);
}

#[test]
fn clips_change_by_a_cross_fade() {
    let mut app = app();
    let hero = mocap::import(format!("{FIXTURES}/skeletons/human_default.gltf")).unwrap();
    let (root, nodes) = figure(&mut app, &hero, "real/cmu_short.bvh");
    assert_eq!(wait(&mut app), "started");
    step(&mut app);
    let before = positions(&app, &nodes);
    let other = app
        .world()
        .resource::<AssetServer>()
        .load::<Motion>("real/cmu_12_01_walk.bvh");
    player(&mut app, root).play(other, Clip::Index(0), 10 * STEP);
    assert_eq!(wait(&mut app), "started");
    // The other motion has no weight yet, and no time has passed.
    assert_eq!(player(&mut app, root).weight(), 0.0);
    let hips = hero.find_node("spine05").or(hero.find_node("root")).unwrap().index();
    assert!(positions(&app, &nodes)[hips].distance(before[hips]) < 1e-4);
    let mut weights = Vec::new();
    let mut largest = 0.0f32;
    let mut last = positions(&app, &nodes);
    for _ in 0..11 {
        step(&mut app);
        weights.push(player(&mut app, root).weight());
        let now = positions(&app, &nodes);
        for (a, b) in last.iter().zip(&now) {
            largest = largest.max(a.distance(*b));
        }
        last = now;
    }
    assert!(
        weights.windows(2).all(|pair| pair[0] <= pair[1]) && weights[4] > 0.4 && weights[4] < 0.6,
        "{weights:?}"
    );
    assert_eq!(weights[10], 1.0);
    // The two motions begin some metres apart: without the fade, a joint would jump this distance.
    let whole = last[hips].distance(before[hips]);
    assert!(largest < 0.5 * whole.max(0.5), "{largest} of {whole}");
}

#[test]
fn what_cannot_be_played_is_said() {
    let mut app = app();
    let hero = mocap::import(format!("{FIXTURES}/skeletons/human_default.gltf")).unwrap();
    let (root, _) = figure(&mut app, &hero, "real/cmu_short.bvh");
    assert_eq!(wait(&mut app), "started");
    for (path, clip, reason) in [
        (
            "real/cmu_short.bvh",
            Clip::from("dance"),
            "no motion is called \"dance\"; the file has ",
        ),
        (
            "real/cmu_short.bvh",
            Clip::from(7),
            "there is no motion 7: the file has 1, counted from 0",
        ),
        (
            "skeletons/human_default.gltf",
            Clip::First,
            "the file has a skeleton and no motion",
        ),
        ("real/lecture_Test.bvh", Clip::First, "humanoid"),
        ("real/no.bvh", Clip::First, "no.bvh"),
    ] {
        let motion = app.world().resource::<AssetServer>().load::<Motion>(path);
        player(&mut app, root).play(motion, clip, Duration::ZERO);
        let heard = wait(&mut app);
        assert!(heard.contains(reason), "{path}: {heard}");
        // The motion that played before continues.
        assert!(player(&mut app, root).is_playing() && !player(&mut app, root).is_waiting());
    }
}

#[test]
fn every_format_is_an_asset() {
    let mut app = app();
    for path in [
        "real/cmu_short.bvh",
        "real/cmu_01_01.amc",
        "real/animation_with_skeleton.fbx",
        "skeletons/human_default.gltf",
        "made/face.vrma",
    ] {
        if path.ends_with("fbx") && !cfg!(feature = "fbx") || path.ends_with("amc") && !cfg!(feature = "all-formats") {
            continue;
        }
        let motion = app.world().resource::<AssetServer>().load::<Motion>(path);
        for _ in 0..2000 {
            app.update();
            if app.world().resource::<Assets<Motion>>().get(&motion).is_some() {
                break;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        let found = app.world().resource::<Assets<Motion>>().get(&motion);
        let found = found.unwrap_or_else(|| panic!("{path} is not loaded"));
        let read = mocap::Importer::new().import(format!("{FIXTURES}/{path}")).unwrap();
        assert_eq!(found.scene.nodes.len(), read.nodes.len(), "{path}");
    }
}
