//! The inner loops, each by itself: `cargo bench` in this folder, `cargo bench -- scan` for one of them.

use std::fs;
use std::hint::black_box;

use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};
use mocap::glam::{Quat, Vec3};
use mocap::process::{KeyTolerance, collapse_keys};
use mocap::scene::{Animation, Channel, Keys};
use mocap::{Scene, Updater};

#[path = "../src/floors.rs"]
#[allow(dead_code, reason = "not every floor is one of an inner loop")]
mod floors;

/// A walk of 96 channels and 2,752 frames.
const CAPTURE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/real/cmu_01_01.bvh");

fn main() {
    divan::main();
}

fn capture() -> Vec<u8> {
    fs::read(CAPTURE).expect("the fixtures are there")
}

/// What any reader of the numbers must do.
#[divan::bench]
fn floor_of_the_scan(bencher: Bencher) {
    let text = capture();
    let rows = floors::rows(&text);
    bencher
        .counter(BytesCount::new(rows.len()))
        .bench(|| floors::tokenise(black_box(rows)));
}

/// Every number into a block of columns.
#[divan::bench]
fn scan(bencher: Bencher) {
    let text = capture();
    bencher
        .counter(BytesCount::new(text.len()))
        .bench(|| mocap::format::bvh::scan(black_box(&text)).map(black_box).is_ok());
}

/// Three columns of a block into keys.
#[divan::bench]
fn euler_to_quaternion(bencher: Bencher) {
    const FRAMES: usize = 128;
    let column = |step: f64| -> Vec<f64> { (0..FRAMES).map(|frame| frame as f64 * step - 180.0).collect() };
    let [z, x, y] = [1.37, 2.11, 0.73].map(column);
    let mut keys = [Quat::IDENTITY; FRAMES];
    bencher.counter(ItemsCount::new(FRAMES)).bench_local(|| {
        mocap::format::bvh::turn(black_box([&z, &x, &y]), &mut keys);
        black_box(&keys);
    });
}

/// A track that never changes, which must be looked at to its end.
#[divan::bench]
fn collapse(bencher: Bencher) {
    const KEYS: usize = 10_000;
    let scene = Scene {
        animations: vec![Animation {
            channels: vec![Channel {
                position_keys: Keys::every_tick(vec![Vec3::ONE; KEYS]),
                rotation_keys: Keys::every_tick(vec![Quat::IDENTITY; KEYS]),
                ..Channel::default()
            }],
            ..Animation::default()
        }],
        ..Scene::default()
    };
    bencher
        .counter(ItemsCount::new(2 * KEYS))
        .with_inputs(|| scene.clone())
        .bench_refs(|scene| collapse_keys(scene, KeyTolerance::default()));
}

/// All node matrices at a tick between two keys.
#[divan::bench]
fn updater(bencher: Bencher) {
    let mut scene = mocap::import(CAPTURE).expect("the fixture is a BVH");
    let updater = Updater::new(&scene, 0).expect("the fixture moves");
    let channels = scene.animations[0].channels.len();
    let mut tick = 0.0;
    bencher.counter(ItemsCount::new(channels)).bench_local(|| {
        tick = (tick + 0.7) % 2_700.0;
        updater.update(&mut scene, tick);
    });
}
