//! Events of force plates, and angles over the average stride.

use std::sync::Arc;

use mocap::Scene;
use mocap::biomechanics::{Gait, JointAngles};
use mocap::glam::Vec3;
use mocap::scene::{AnalogChannel, ForcePlate, Recording};
use mocap_solve::internals::PlateLoads;

/// Samples per second of the plates.
const RATE: f64 = 1200.0;

fn walk() -> Scene {
    mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap()
}

/// The walk with a plate that bears 700 N from `begin` to `end`, in seconds.
fn with_plate([begin, end]: [f64; 2]) -> Scene {
    let mut scene = walk();
    let samples = (RATE * scene.animations[0].duration / scene.animations[0].ticks_per_second) as usize;
    let is_loaded = |sample: usize| (begin..end).contains(&(sample as f64 / RATE));
    let channel = |index: usize| AnalogChannel {
        name: format!("channel {index}"),
        unit: "N".to_owned(),
        values: (0..samples)
            .map(|sample| if index == 2 && is_loaded(sample) { -700.0 } else { 0.5 })
            .collect(),
    };
    scene.metadata.recorded = Some(Arc::new(Recording {
        analog_rate: RATE,
        samples_per_frame: 10,
        channels: (0..6).map(channel).collect(),
        plates: vec![ForcePlate {
            plate_type: 2,
            corners: [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].map(|[x, z]| Vec3::new(x, 0.0, z)),
            channels: (0..6).collect(),
            scales: vec![1.0; 6],
            ..ForcePlate::default()
        }],
        ..Recording::default()
    }));
    scene
}

#[test]
fn plates_give_the_times_of_the_steps_on_them() {
    let without = Gait::of(&walk()).unwrap();
    assert_eq!(without.events_of_plates, 0);
    let strike = without.right.heel_strikes[1];
    let off = *without.right.toe_offs.iter().find(|off| **off > strike).unwrap();

    let with = Gait::of(&with_plate([strike + 0.031, off - 0.023])).unwrap();
    assert_eq!(with.events_of_plates, 2);
    let near = |times: &[f64], time: f64| times.iter().any(|own| (own - time).abs() < 1.0 / RATE);
    assert!(near(&with.right.heel_strikes, strike + 0.031) && near(&with.right.toe_offs, off - 0.023));
    assert_eq!(with.left.heel_strikes, without.left.heel_strikes);
    assert_eq!(with.left.toe_offs, without.left.toe_offs);
    // A load that begins at another time than a step is not the load of this step.
    let aside = Gait::of(&with_plate([strike + 0.2, off - 0.2])).unwrap();
    assert_eq!(aside.events_of_plates, 0);
    assert_eq!(aside.right.heel_strikes, without.right.heel_strikes);
}

#[test]
fn loads_that_are_no_steps_give_no_events() {
    let events = |is_loaded: &[bool]| {
        let mut loads = PlateLoads::default();
        loads.add(is_loaded, 100.0);
        let (mut strikes, mut toe_offs) = ([0.32], [0.48]);
        (loads.replace(&mut strikes, &mut toe_offs), strikes, toe_offs)
    };
    let loaded =
        |first: usize, end: usize| -> Vec<bool> { (0..80).map(|sample| (first..end).contains(&sample)).collect() };
    assert_eq!(events(&loaded(30, 50)), (2, [0.30], [0.50]));
    // A load that is too short, a load from the first sample on, and a load up to the last sample.
    assert_eq!(events(&loaded(30, 39)).0, 0);
    assert_eq!(events(&loaded(0, 50)), (1, [0.32], [0.50]));
    assert_eq!(events(&loaded(30, 80)), (1, [0.30], [0.48]));
    assert_eq!(events(&[]).0, 0);
}

#[test]
fn cycles_are_means_of_the_angles_over_the_strides() {
    let gait = Gait::of(&walk()).unwrap();
    let angles = JointAngles::of(&walk()).unwrap();
    let knee: Vec<f64> = angles.column("knee_angle_l").unwrap().collect();
    let cycle = gait
        .left
        .cycles
        .iter()
        .find(|cycle| cycle.column == "knee_angle_l")
        .unwrap();
    assert_eq!((cycle.mean.len(), cycle.deviation.len()), (101, 101));
    let strides: Vec<_> = gait
        .strides
        .iter()
        .filter(|stride| stride.side == mocap::figure::Side::Left)
        .collect();
    // Strikes are in whole frames. The middle of a stride is in a frame, or between two.
    for (per_cent, part) in [(0, 0.0), (50, 0.5), (100, 1.0)] {
        let value = |[first, second]: [f64; 2]| {
            let frame = (first + part * (second - first)) * angles.frame_rate;
            let [before, after] = [frame + 1e-6, frame - 1e-6].map(|frame| knee[frame.round() as usize]);
            0.5 * (before + after)
        };
        let mean = strides.iter().map(|stride| value(stride.strikes)).sum::<f64>() / strides.len() as f64;
        assert!(
            (cycle.mean[per_cent] - mean).abs() < 0.01,
            "{per_cent} %: {} and {mean}",
            cycle.mean[per_cent]
        );
    }
    // Knees of a walk bend by about 60 degrees in the swing.
    let most = (0..101)
        .max_by(|a, b| cycle.mean[*a].total_cmp(&cycle.mean[*b]))
        .unwrap();
    assert!((65..85).contains(&most) && cycle.mean[most] > 45.0, "{most} %");
    let columns: Vec<&str> = gait.left.cycles.iter().map(|cycle| cycle.column.as_str()).collect();
    assert!(columns.contains(&"pelvis_tilt") && columns.contains(&"lumbar_bending"));
    assert!(
        !columns
            .iter()
            .any(|column| column.ends_with("_r") || column.starts_with("pelvis_t") && column.len() == 9)
    );
}
