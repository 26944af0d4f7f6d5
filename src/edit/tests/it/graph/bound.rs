//! Tests of the values that summarise a window of frames. From two summaries follows a lower bound of the distance of
//! the windows.

use mocap::figure::Figure;
use mocap_edit::internals::{Bound, CloudSpace, Clouds, SLACK, Window};

/// A bound above the distance would lose transitions. A bound far below would be useless.
#[test]
fn no_distance_is_below_its_bound() {
    for (file, frames) in [
        ("cmu_12_01_walk.bvh", 10),
        ("cmu_short.bvh", 2),
        ("kinect_openni.bvh", 10),
    ] {
        let scene = mocap::import(format!("../../fixtures/real/{file}")).unwrap();
        let space = CloudSpace::new(&scene, &Figure::new(&scene)).unwrap();
        let clip = Clouds::new(&space, &scene, &scene.animations[0], 30.0).unwrap();
        let window = Window::new(frames);
        let count = window.count(&clip);
        let exact = window.distances(&space, (&clip, 0..count), (&clip, 0..count));
        let clips = std::slice::from_ref(&clip);
        let numbers = Bound::new(&space, &window, clips)
            .numbers(&space, &window, clips)
            .remove(0);
        let (mut sum, mut near) = (0.0, 0.0);
        for (cell, exact) in exact.iter().enumerate().step_by(7) {
            let pairs = numbers[cell / count].iter().zip(&numbers[cell % count]);
            let bound = pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f32>().sqrt();
            assert!(
                bound <= exact * (1.0 + SLACK.0) + SLACK.1,
                "{file} {cell}: {bound} {exact}"
            );
            if *exact > 0.03 && *exact < 0.1 {
                sum += bound / exact;
                near += 1.0;
            }
        }
        let mean = sum / near;
        assert!(
            mean > 0.8,
            "{file}: the bound is {mean} of the distance in the mean of {near} pairs"
        );
    }
}
