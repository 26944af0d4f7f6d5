//! Times in the ledger of losses: keys between frames, frame rates and durations in each written format.

use mocap::glam::Quat;
use mocap::scene::report::DataKind;
use mocap::scene::{Animation, Keys};
use mocap::{Exporter, Format, FormatInfo, Importer, Pose, Scene, SkeletonMesh};

use crate::losses::{channel_of, figure, written};

/// The number of items of a kind that a format loses, and the scene read back. A reader that samples keys uses `rate`.
fn output(scene: &Scene, row: &FormatInfo, kind: DataKind, rate: f64) -> (u64, Scene) {
    let output = Exporter::new().write(scene, row.format).unwrap();
    let loss = output.losses.iter().find(|loss| loss.kind == kind);
    let bytes = output.files.last().unwrap().bytes().into_owned();
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::None).sampling_rate(rate);
    let again = importer.read(&bytes, format!("scene.{}", row.extensions[0])).unwrap();
    (loss.map_or(0, |loss| loss.count), again)
}

/// A key between two frames at which an elbow bends. A file stores the key, or interpolates the pose from the
/// neighbouring frames.
#[test]
fn keys_between_frames_are_in_the_file_or_counted() {
    const BETWEEN: f64 = 1.5;
    let mut scene = figure();
    scene
        .animations
        .iter_mut()
        .for_each(|clip| clip.ticks_per_second = 30.0);
    let turns = [0.0, 0.0, 1.0, 0.0].map(Quat::from_rotation_z);
    channel_of(&mut scene, "LeftForeArm").rotation_keys = Keys::at_ticks(turns.to_vec(), vec![0.0, 1.0, BETWEEN, 2.0]);
    // The angle of the elbow.
    let angle = |scene: &Scene| {
        let tick = BETWEEN / 30.0 * scene.animations[0].ticks_per_second;
        let joints = Pose::at_tick(scene, 0, tick).unwrap().node_to_world;
        let names = ["LeftArm", "LeftForeArm", "LeftHand"];
        let [arm, elbow, hand] = names.map(|name| joints[scene.find_node(name).unwrap().index()].w_axis);
        (elbow - arm).truncate().angle_between((hand - elbow).truncate())
    };
    let planted = angle(&scene);
    let mut lose = Vec::new();
    for row in written() {
        let (lost, again) = output(&scene, row, DataKind::Frames, 60.0);
        if lost > 0 {
            assert_eq!(lost, 1, "{}", row.name);
            lose.push(row.extensions[0]);
        }
        // A VMD has its own joint names.
        if row.format != Format::Vmd {
            let is_there = (angle(&again) - planted).abs() < 0.01;
            assert_eq!(is_there, lost == 0, "{}: {}, not {planted}", row.name, angle(&again));
        }
    }
    assert_eq!(lose, ["bvh", "trc", "vmd"]);
}

/// At 30 frames per second, a file has every fourth of 120 frames.
#[test]
fn frames_that_a_format_of_one_rate_has_not_are_counted() {
    let scene = figure();
    let frames = scene.animations[0].frame_count();
    for row in written() {
        let (lost, _) = output(&scene, row, DataKind::Frames, 120.0);
        let expected = if row.format == Format::Vmd {
            frames - frames.div_ceil(4)
        } else {
            0
        };
        assert_eq!(lost, expected as u64, "{}", row.name);
    }
}

/// A second clip, at half the rate of the first.
#[test]
fn frame_rates_are_in_the_file_or_counted() {
    let mut scene = figure();
    let mut slow = scene.animations[0].clone();
    "slow".clone_into(&mut slow.name);
    slow.ticks_per_second /= 2.0;
    scene.animations.push(slow);
    for row in written() {
        let (lost, again) = output(&scene, row, DataKind::FrameRates, 120.0);
        let rates = std::iter::zip(&scene.animations, &again.animations);
        let is_other = |(a, b): &(&Animation, &Animation)| {
            (a.ticks_per_second - b.ticks_per_second).abs() > 1e-4 * a.ticks_per_second
        };
        assert_eq!(lost, rates.filter(is_other).count() as u64, "{}", row.name);
    }
}

/// A motion that ends between two frames.
#[test]
fn durations_are_in_the_file_or_counted() {
    let mut scene = figure();
    scene
        .animations
        .iter_mut()
        .for_each(|clip| clip.ticks_per_second = 30.0);
    scene.animations[0].duration += 0.4;
    let end = scene.animations[0].duration;
    let hand = channel_of(&mut scene, "LeftHand");
    hand.rotation_keys = Keys::at_ticks([0.0, 1.0].map(Quat::from_rotation_x).to_vec(), vec![0.0, end]);
    let seconds = |scene: &Scene| scene.animations[0].duration / scene.animations[0].ticks_per_second;
    for row in written() {
        // The reader samples FBX at whole frames: five frames of the file are two frames of the motion.
        let (lost, again) = output(&scene, row, DataKind::Durations, 75.0);
        let is_kept = (seconds(&again) - seconds(&scene)).abs() < 1e-4;
        assert_eq!(
            lost == 0,
            is_kept,
            "{}: {} s, not {}",
            row.name,
            seconds(&again),
            seconds(&scene)
        );
    }
}
