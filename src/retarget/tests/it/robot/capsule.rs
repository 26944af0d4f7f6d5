//! Tests the distances and the boxes of capsules.

use mocap::glam::DVec3;
use mocap::scene::robot::Placement;
use mocap_retarget::internals::capsule::{Capsule, add_box, distance};

#[test]
fn segments_are_as_far_apart_as_their_nearest_points() {
    let mut seed = 1_u64;
    let mut random = || {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
    };
    for round in 0..90 {
        let mut point = || DVec3::new(random(), random(), random());
        let (mut one, mut other) = ([point(), point()], [point(), point()]);
        match round % 6 {
            0 => one[1] = one[0],
            1 => other[1] = other[0],
            2 => other[1] = other[0] + 0.7 * (one[1] - one[0]),
            3 => (one[1], other[1]) = (one[0], other[0]),
            _ => {}
        }
        let found = distance(one, other);
        // Points on both capsules, on a grid.
        const STEPS: usize = 80;
        let on = |[a, b]: [DVec3; 2], step: usize| a.lerp(b, step as f64 / STEPS as f64);
        let steps = (0..=STEPS).flat_map(|s| (0..=STEPS).map(move |t| (s, t)));
        let nearest = steps
            .map(|(s, t)| on(one, s).distance(on(other, t)))
            .fold(f64::INFINITY, f64::min);
        assert!(found <= nearest + 1e-9, "{round}: {found} {nearest}");
        assert!(nearest - found < 2.0 / STEPS as f64, "{round}: {found} {nearest}");
    }
}

#[test]
fn capsules_are_within_their_box() {
    for half_size in [
        DVec3::new(0.3, 0.02, 0.1),
        DVec3::splat(0.2),
        DVec3::new(0.05, 0.4, 0.06),
    ] {
        let mut capsules = Vec::new();
        add_box(half_size, &Placement::IDENTITY, &mut capsules);
        assert!(!capsules.is_empty());
        for capsule in &capsules {
            for end in capsule.ends {
                assert!(
                    (end.abs() + capsule.radius - half_size).max_element() < 1e-12,
                    "{capsule:?}"
                );
            }
        }
        // The points reach each side of the box.
        for axis in 0..3 {
            let reach = |capsule: &Capsule| capsule.ends.map(|end| end[axis] + capsule.radius);
            let farthest = capsules.iter().flat_map(reach).fold(0.0, f64::max);
            assert!((farthest - half_size[axis]).abs() < 1e-12, "{half_size} {axis}");
        }
    }
}
