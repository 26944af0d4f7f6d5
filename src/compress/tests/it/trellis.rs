//! Tests the search for the cheapest sequence of rounded values. A corner is one of the rounded values around a
//! rotation.

use mocap_compress::internals::trellis::{CORNERS, Component, Rates, Trellis, floor, least};
use mocap_scene::math::soa::single::{LANES, Lanes};

#[test]
fn larger_differences_take_more_bits() {
    let before = Component::new(Lanes::all(250.0));
    let now = Component::new(Lanes::of(|lane| {
        [250.0, 251.0, 249.0, 248.0, 243.0, 242.0, 255.0, 256.0][lane]
    }));
    let rates = now.rate_after(&before).0.map(|rate| (rate * 10.0).round());
    assert_eq!(rates, [8.0, 24.0, 24.0, 44.0, 44.0, 90.0, 44.0, 114.0]);
}

#[test]
fn the_cheapest_sequence_is_found() {
    let mut seed = 7u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / 16_777_216.0
    };
    for jump in [None, Some(3)] {
        let origins = [(); 3].map(|()| {
            let numbers: [f32; LANES] = std::array::from_fn(|_| (random() * 20.0).floor() + 245.0);
            Lanes::of(|lane| numbers[lane])
        });
        // There are two corners for each frame, so that all sequences can be tried.
        let choices: [[usize; 2]; LANES] =
            std::array::from_fn(|_| [(random() * 4.0) as usize, 4 + (random() * 4.0) as usize]);
        let distortions: [Lanes; LANES] = std::array::from_fn(|lane| {
            let all = [(); CORNERS].map(|()| random() * 12.0);
            Lanes::of(|corner| {
                if choices[lane].contains(&corner) {
                    all[corner]
                } else {
                    1e4
                }
            })
        });

        let rates = Rates::between(&origins);
        let mut trellis = Trellis::new(distortions[0]);
        for (lane, distortions) in distortions.iter().enumerate().skip(1) {
            if jump == Some(lane) {
                trellis.jump(lane, *distortions);
            } else {
                trellis.step(lane, &rates, *distortions);
            }
        }
        let found = trellis.cheapest();

        let at = |lane: usize, corner: usize, axis: usize| {
            Component::new(Lanes::all(origins[axis].0[lane] + (corner >> axis & 1) as f32))
        };
        let cost = |corners: &[usize; LANES]| -> f32 {
            let step = |lane: usize| -> f32 {
                if lane == 0 || jump == Some(lane) {
                    return 0.0;
                }
                let rate = |axis| {
                    at(lane, corners[lane], axis)
                        .rate_after(&at(lane - 1, corners[lane - 1], axis))
                        .0[0]
                };
                (0..3).map(rate).sum()
            };
            (0..LANES)
                .map(|lane| distortions[lane].0[corners[lane]] + step(lane))
                .sum()
        };
        let sequences = (0..1usize << LANES).map(|bits| std::array::from_fn(|lane| choices[lane][bits >> lane & 1]));
        let least = sequences.map(|corners| cost(&corners)).fold(f32::INFINITY, f32::min);
        assert!((cost(&found) - least).abs() < 1e-3, "{} and {least}", cost(&found));
    }
}

#[test]
fn the_cheapest_corner_is_found() {
    for (costs, index) in [
        ([3.0, 2.0, 5.0, 1.0, 4.0, 9.0, 8.0, 7.0], 3),
        ([0.0, 0.0, 5.0, 1.0, 4.0, 9.0, 8.0, 7.0], 0),
        ([f32::INFINITY, 2e3, 5e3, 4e3, 1.5e3, 9e3, 8e3, f32::INFINITY], 4),
    ] {
        assert_eq!(least(Lanes::of(|corner| costs[corner])), (index, costs[index]));
    }
}

#[test]
fn numbers_are_rounded_down() {
    let found = floor(Lanes::of(|lane| {
        [0.0, 0.25, -0.25, 1.0, -1.0, 32767.5, -32767.5, 5.999][lane]
    }));
    assert_eq!(found.0, [0.0, 0.0, -1.0, 1.0, -1.0, 32767.0, -32768.0, 5.0]);
}
