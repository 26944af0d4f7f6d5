//! The lecture's motion on entities, against its closed form.

use std::time::Duration;

use bevy::prelude::*;
use mocap_bevy::{Capture, CapturePlugin};

/// Where the nodes are at a tick: the shoulder at (0.1 (tick + 1), 0.02 tick), links 2, 1.5 and 0.5 long, each joint
/// turned by 5, 10 and 8 degrees times tick + 1 against the link before.
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
    let scene = mocap::import("../../fixtures/real/lecture_Test.bvh").unwrap();
    let mut app = App::new();
    app.add_plugins((TransformPlugin, CapturePlugin))
        .init_resource::<Time>();
    let root = mocap_bevy::spawn(&mut app.world_mut().commands(), scene).unwrap();
    app.world_mut().flush();

    for step in 0..19 {
        app.update();
        let world = app.world();
        let nodes = &world.get::<Capture>(root).unwrap().nodes;
        // A tick is a tenth of a second, and so two steps.
        for (&node, expected) in nodes.iter().zip(arm(f64::from(step) / 2.0)) {
            let place = world.get::<GlobalTransform>(node).unwrap().translation();
            assert!(
                place.abs_diff_eq(expected, 1e-5),
                "step {step}: {place}, not {expected}"
            );
        }
        app.world_mut()
            .resource_mut::<Time>()
            .advance_by(Duration::from_millis(50));
    }
    assert_eq!(app.world().get::<Name>(root).unwrap().as_str(), "Shoulder");
}
