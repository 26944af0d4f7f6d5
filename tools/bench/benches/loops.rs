//! Measures single stages: `cargo bench` in this folder runs all of them, `cargo bench -- read` one of them.

use std::fs;
use std::hint::black_box;

use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};
use mocap::glam::{Quat, Vec3};
use mocap::process::KeyTolerance;
use mocap::scene::{Animation, Channel, Keys};
use mocap::{Importer, Scene, SkeletonMesh, Updater};

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

/// Parses every number of the file, and keeps no number: the least work of a reader.
#[divan::bench]
fn parse_numbers(bencher: Bencher) {
    let text = capture();
    let rows = floors::rows(&text);
    bencher
        .counter(BytesCount::new(rows.len()))
        .bench(|| floors::tokenise(black_box(rows)));
}

/// Reads the whole file into a scene on one thread, without mesh, hash and search for constant tracks.
#[divan::bench]
fn read(bencher: Bencher) {
    let text = capture();
    let importer = Importer::new()
        .threads(1)
        .skeleton_mesh(SkeletonMesh::None)
        .collapse_keys(false)
        .hash(false);
    bencher.counter(BytesCount::new(text.len())).bench(|| {
        importer
            .read(black_box(&text), "capture.bvh")
            .expect("the fixture is a BVH")
    });
}

/// A constant track, which the search must read to its end.
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
        .bench_refs(|scene| scene.collapse_keys(KeyTolerance::default()));
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
