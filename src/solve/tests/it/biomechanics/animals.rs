//! The names of gaits of a dog whose paws are planted by the definitions of the gaits.

use std::f64::consts::PI;
use std::fmt::Write;

use mocap::Scene;
use mocap::biomechanics::BodyGait;
use mocap::biomechanics::report::{AnimalGait, GaitName};
use mocap::figure::Confidence;

const FPS: f64 = 100.0;

/// The hips and shoulders relative to the middle of the trunk, in metres: +X to the left, +Z forward. The legs are in
/// the order of [`AnimalGait::paws`].
const HIPS: [[f64; 2]; 4] = [[0.1, 0.3], [-0.1, 0.3], [0.1, -0.3], [-0.1, -0.3]];

/// The joints of the legs.
const LEGS: [[&str; 4]; 4] = [
    ["LeftArm", "LeftForeArm", "LeftHand", "LeftFinger"],
    ["RightArm", "RightForeArm", "RightHand", "RightFinger"],
    ["LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToe"],
    ["RightUpLeg", "RightLeg", "RightFoot", "RightToe"],
];

/// The height of hips and shoulders of the dog that stands. Its legs are 0.5 m long.
const HIGH: f64 = 0.45;

/// The places of the trunk's two ends and of the paws in one frame.
#[derive(Clone, Copy)]
struct Placed {
    /// The path forward, and the heights of shoulders and hips.
    trunk: [f64; 3],
    /// The place forward, and the height of each paw.
    paws: [[f64; 2]; 4],
}

fn standing(at: f64) -> Placed {
    Placed {
        trunk: [at, HIGH, HIGH],
        paws: HIPS.map(|[_, z]| [at + z, 0.0]),
    }
}

/// A BVH file in which each joint has positions.
fn dog(frames: &[Placed]) -> Scene {
    let joints = |placed: &Placed| -> Vec<[f64; 3]> {
        let [at, fore, hind] = placed.trunk;
        let mut offsets = vec![
            [0.0, hind, at - 0.3],
            [0.0, fore - hind, 0.6],
            [0.0, 0.1, 0.15],
            [0.0, 0.05, 0.1],
        ];
        for (index, [x, z]) in HIPS.into_iter().enumerate() {
            let height = if z > 0.0 { fore } else { hind };
            let [paw, above] = placed.paws[index];
            // The elbow and the hock are behind the leg, and the stifle is in front of it.
            let bend = if z > 0.0 { [-0.08, -0.02] } else { [0.08, -0.06] };
            let along = |part: f64, bend: f64| {
                [
                    (1.0 - part) * (at + z) + part * paw + bend,
                    height + part * (above - height),
                ]
            };
            let points = [[at + z, height], along(0.4, bend[0]), along(0.8, bend[1]), [paw, above]];
            offsets.push([x, 0.0, 0.0]);
            offsets.extend(
                points
                    .windows(2)
                    .map(|pair| [0.0, pair[1][1] - pair[0][1], pair[1][0] - pair[0][0]]),
            );
        }
        offsets
    };
    let rest = joints(&standing(0.0));
    let mut text = "HIERARCHY\n".to_owned();
    let joint = |kind: &str, name: &str, index: usize| {
        let [x, y, z] = rest[index];
        format!(
            "{kind} {name}\n{{\nOFFSET {x} {y} {z}\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation \
             Yrotation\n"
        )
    };
    let end = "End Site\n{\nOFFSET 0 -0.02 0.03\n}\n";
    let leg = |index: usize| {
        let parts = LEGS[index].iter().enumerate();
        let parts: String = parts
            .map(|(part, name)| joint("JOINT", name, 4 + 4 * index + part))
            .collect();
        format!("{parts}{end}{}", "}\n".repeat(4))
    };
    text += &joint("ROOT", "Pelvis", 0);
    text += &joint("JOINT", "Chest", 1);
    text += &joint("JOINT", "Neck", 2);
    text += &(joint("JOINT", "Head", 3) + "End Site\n{\nOFFSET 0 0 0.15\n}\n}\n}\n");
    text += &(leg(0) + &leg(1) + "}\n" + &leg(2) + &leg(3) + "}\n");
    writeln!(text, "MOTION\nFrames: {}\nFrame Time: {}", frames.len(), 1.0 / FPS).unwrap();
    for placed in frames {
        for [x, y, z] in joints(placed) {
            write!(text, "{x} {y} {z} 0 0 0 ").unwrap();
        }
        text.push('\n');
    }
    let mut scene = mocap::Importer::new().read(text.as_bytes(), "dog.bvh").unwrap();
    mocap::Conversion::new().apply(&mut scene).unwrap();
    scene
}

fn gait(frames: &[Placed]) -> AnimalGait {
    match BodyGait::of(&dog(frames)).unwrap() {
        BodyGait::Animal(gait) => gait,
        other => panic!("{other:?}"),
    }
}

/// A gait by its definition. The phases of the strikes and the duty factor are parts of the stride. The stride is in
/// seconds, and the speed is in metres per second.
#[derive(Clone, Copy)]
struct Planted {
    phases: [f64; 4],
    duty: f64,
    stride: f64,
    speed: f64,
}

impl Planted {
    /// A paw on the ground stays in place. In the air, it reaches its speed in a part of the swing, and keeps the speed.
    fn at(&self, time: f64, in_place: bool) -> Placed {
        let path = self.speed * time;
        let paws = std::array::from_fn(|index| {
            let strides = time / self.stride - self.phases[index];
            let (count, phase) = (strides.floor(), strides.rem_euclid(1.0));
            // The trunk is above the paw in the middle of the stance.
            let place = |count: f64| {
                let strike = (count + self.phases[index]) * self.stride;
                HIPS[index][1] + self.speed * (strike + 0.5 * self.duty * self.stride)
            };
            if phase < self.duty {
                return [place(count), 0.0];
            }
            let swing = (phase - self.duty) / (1.0 - self.duty);
            let part = path_of_swing(swing);
            let at = place(count) + part * (place(count + 1.0) - place(count));
            [at, 0.1 * (PI * swing).sin().powi(2)]
        });
        let back = if in_place { path } else { 0.0 };
        Placed {
            trunk: [path - back, HIGH, HIGH],
            paws: paws.map(|[at, height]: [f64; 2]| [at - back, height]),
        }
    }
}

/// The part of its path that a paw has made in a part of its swing.
fn path_of_swing(swing: f64) -> f64 {
    const SPEEDS_UP: f64 = 0.15;
    let speed = 1.0 / (1.0 - SPEEDS_UP);
    if swing < SPEEDS_UP {
        0.5 * speed * swing * swing / SPEEDS_UP
    } else if swing > 1.0 - SPEEDS_UP {
        1.0 - path_of_swing(1.0 - swing)
    } else {
        speed * (swing - 0.5 * SPEEDS_UP)
    }
}

const fn planted(phases: [f64; 4], duty: f64, stride: f64, speed: f64) -> Planted {
    Planted {
        phases,
        duty,
        stride,
        speed,
    }
}

/// The gaits of Hildebrand (1965), and of the definitions of riders. Phases: left and right fore, left and right hind.
const GAITS: [(GaitName, Planted); 9] = [
    (GaitName::Walk, planted([0.25, 0.75, 0.0, 0.5], 0.65, 0.8, 0.8)),
    // The walk of a dog, whose paws of one side strike sooner after each other.
    (GaitName::Walk, planted([0.15, 0.65, 0.0, 0.5], 0.62, 0.6, 1.2)),
    (GaitName::Amble, planted([0.25, 0.75, 0.0, 0.5], 0.3, 0.5, 2.4)),
    (GaitName::Trot, planted([0.5, 0.0, 0.0, 0.5], 0.42, 0.5, 1.9)),
    (GaitName::Pace, planted([0.0, 0.5, 0.0, 0.5], 0.35, 0.5, 2.2)),
    // The right hind paw, the left hind paw with the right fore paw, the left fore paw.
    (GaitName::Canter, planted([0.55, 0.3, 0.3, 0.0], 0.35, 0.45, 2.5)),
    (GaitName::Canter, planted([0.3, 0.55, 0.0, 0.3], 0.35, 0.45, 2.5)),
    // A transverse gallop, and a rotary gallop.
    (GaitName::Gallop, planted([0.58, 0.45, 0.12, 0.0], 0.25, 0.35, 4.5)),
    (GaitName::Gallop, planted([0.45, 0.58, 0.12, 0.0], 0.25, 0.35, 4.5)),
];

#[test]
fn planted_footfalls_have_the_names_of_their_gaits() {
    for (name, planted) in GAITS {
        for in_place in [false, true] {
            let frames: Vec<Placed> = (0..400)
                .map(|frame| planted.at(f64::from(frame) / FPS, in_place))
                .collect();
            let found = gait(&frames);
            let longest = found
                .stretches
                .iter()
                .max_by_key(|stretch| stretch.frames[1] - stretch.frames[0]);
            let stretch = longest.unwrap();
            let what = format!("{name:?}, in place: {in_place}: {:?}", found.stretches);
            assert_eq!(stretch.gait, name, "{what}");
            assert_eq!(found.stretches.len(), 1, "{what}");
            assert_ne!(stretch.confidence, Confidence::Unsure, "{what}");
            // The paw is foremost shortly before it strikes, and rearmost shortly after it lifts.
            let duty = stretch.duty_factor.unwrap() - planted.duty;
            assert!((-0.02..0.15).contains(&duty), "{what}");
            let speed = stretch.speed.unwrap();
            assert!((speed - planted.speed).abs() < 0.2 * planted.speed, "{what}");
            let lag = planted.phases[0] - planted.phases[2];
            if ![GaitName::Canter, GaitName::Gallop].contains(&name) {
                let apart = (stretch.lag.unwrap() - lag + 0.5).rem_euclid(1.0) - 0.5;
                assert!(apart.abs() < 0.03, "{what}");
            }
            let strikes = &found.paws[2].strikes;
            let stride = (strikes[strikes.len() - 1] - strikes[0]) / (strikes.len() - 1) as f64;
            assert!((stride - planted.stride).abs() < 0.01, "{what}");
        }
    }
}

fn names(found: &AnimalGait) -> Vec<GaitName> {
    found.stretches.iter().map(|stretch| stretch.gait).collect()
}

/// Stretches follow each other without a gap.
fn assert_covers(found: &AnimalGait, frames: usize) {
    let mut next = 0;
    for stretch in &found.stretches {
        assert_eq!(stretch.frames[0], next);
        next = stretch.frames[1] + 1;
    }
    assert_eq!(next, frames);
}

#[test]
fn a_dog_walks_and_then_trots() {
    let [(_, walk), (_, trot)] = [GAITS[1], GAITS[3]];
    let mut frames: Vec<Placed> = (0..360).map(|frame| walk.at(f64::from(frame) / FPS, false)).collect();
    let gap = walk.at(3.6, false).trunk[0];
    frames.extend((0..300).map(|frame| {
        let mut placed = trot.at(f64::from(frame) / FPS, false);
        placed.trunk[0] += gap;
        placed.paws.iter_mut().for_each(|paw| paw[0] += gap);
        placed
    }));
    let found = gait(&frames);
    assert_covers(&found, frames.len());
    let [first, last] = [&found.stretches[0], &found.stretches[found.stretches.len() - 1]];
    assert_eq!(
        (first.gait, last.gait),
        (GaitName::Walk, GaitName::Trot),
        "{:?}",
        found.stretches
    );
    // The change falls within one stride of the walk.
    assert!(
        first.frames[1].abs_diff(360) < 60 && last.frames[0].abs_diff(360) < 60,
        "{:?}",
        found.stretches
    );
}

#[test]
fn a_dog_stands_sits_and_lies() {
    let postures = [[HIGH, HIGH], [HIGH, 0.14], [0.17, 0.12]];
    let mut frames = vec![standing(0.0); 450];
    for pair in postures.windows(2) {
        frames.extend((0..150).map(|frame| {
            let part = (f64::from(frame) / 30.0).min(1.0);
            let [fore, hind] = [0, 1].map(|end| pair[0][end] + part * (pair[1][end] - pair[0][end]));
            Placed {
                trunk: [0.0, fore, hind],
                ..standing(0.0)
            }
        }));
    }
    let found = gait(&frames);
    assert_covers(&found, 750);
    assert_eq!(names(&found), [GaitName::Stand, GaitName::Sit, GaitName::Lie]);
    assert!(
        found
            .stretches
            .iter()
            .all(|stretch| stretch.confidence == Confidence::Sure)
    );
}

#[test]
fn a_dog_jumps() {
    let flight = 40;
    let mut frames = vec![standing(0.0); 100];
    frames.extend((0..flight).map(|frame| {
        let time = f64::from(frame) / FPS;
        let rise = 0.5 * 9.81 * time * (f64::from(flight) / FPS - time);
        let mut placed = standing(2.0 * time);
        placed.trunk[1] += rise;
        placed.trunk[2] += rise;
        let tucked = (f64::from(frame.min(flight - frame)) / 4.0).min(1.0);
        placed.paws.iter_mut().for_each(|paw| paw[1] = rise + 0.15 * tucked);
        placed
    }));
    frames.extend(vec![standing(2.0 * f64::from(flight) / FPS); 100]);
    let found = gait(&frames);
    assert_covers(&found, frames.len());
    assert_eq!(names(&found), [GaitName::Stand, GaitName::Jump, GaitName::Stand]);
    let [first, last] = found.stretches[1].frames;
    assert!(
        (100..106).contains(&first) && (134..140).contains(&last),
        "{first} {last}"
    );
}

/// The fixture is a part of a take of a walk.
#[test]
fn a_captured_dog_walks() {
    let scene = mocap::import("../../fixtures/made/dog_walk.bvh").unwrap();
    let BodyGait::Animal(found) = BodyGait::of(&scene).unwrap() else {
        panic!("a dog has four legs");
    };
    assert_eq!(names(&found), [GaitName::Walk], "{:?}", found.stretches);
}

#[test]
fn a_person_keeps_the_table_of_a_laboratory() {
    let scene = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
    assert!(matches!(BodyGait::of(&scene).unwrap(), BodyGait::Humanoid(_)));
}
