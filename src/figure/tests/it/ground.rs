//! The ground: laws that hold for every motion, and feet on a known floor.

use glam::Vec3;
use mocap::Importer;
use mocap::figure::{Axis, Figure};
use mocap::scene::{Scene, UpAxis};
use mocap_figure::ground::{height_drift, levels};
use mocap_scene::process::convert_units_to;

/// Clips of ten makers, in which a person stands, walks, dances, shuffles or jumps.
const CLIPS: [&str; 10] = [
    "cmu_12_01_walk",
    "cmu_mixed_rotation_orders",
    "cmu_salsa_poser_names",
    "kinect_openni",
    "makehuman_zombie_walk",
    "mocopi_jump_six_channels",
    "motionbuilder_vicon_walk",
    "nan_tokens",
    "perception_neuron_moving_positions",
    "z_up_dab",
];

/// The largest allowed change of the ground, in metres.
const SAME: f64 = 0.01;

/// A BVH file: the text before its rows, with the frame rate separate, and its rows.
struct Bvh {
    head: String,
    seconds: f64,
    rows: Vec<Vec<f64>>,
}

impl Bvh {
    fn open(name: &str) -> Self {
        let text = std::fs::read_to_string(format!("../../fixtures/real/{name}.bvh")).unwrap();
        let (head, rows) = text.split_once("MOTION").unwrap();
        let mut lines = rows.trim_start().lines();
        let value = |line: &str| line.split_once(':').unwrap().1.trim().to_owned();
        let _ = lines.next();
        let seconds = value(lines.next().unwrap()).parse().unwrap();
        let row = |line: &str| line.split_whitespace().map(|value| value.parse().unwrap()).collect();
        let rows = lines.filter(|line| !line.trim().is_empty()).map(row).collect();
        let head = head.to_owned();
        Self { head, seconds, rows }
    }

    fn scene(&self, rows: &[Vec<f64>], seconds: f64) -> Scene {
        let mut text = format!("{}MOTION\nFrames: {}\nFrame Time: {seconds}\n", self.head, rows.len());
        for row in rows {
            let values: Vec<String> = row.iter().map(f64::to_string).collect();
            text += &format!("{}\n", values.join(" "));
        }
        Importer::new().read(text.as_bytes(), "in.bvh").unwrap()
    }

    /// For each value of a row: its channel, and the OFFSET of the joint along the channel's axis.
    fn channels(&self) -> Vec<(&str, f64)> {
        let mut words = self.head.split_whitespace();
        let (mut offset, mut channels) = (Vec::new(), Vec::new());
        while let Some(word) = words.next() {
            match word.as_bytes() {
                b"OFFSET" => offset = words.by_ref().take(3).map(|word| word.parse().unwrap()).collect(),
                [axis @ b'X'..=b'Z', b'r' | b'p', ..] if word.ends_with("ion") => {
                    channels.push((word, offset[usize::from(axis - b'X')]));
                }
                _ => {}
            }
        }
        channels
    }

    /// The row of the rest pose: positions are OFFSETs, and rotations are 0.
    fn at_rest(&self) -> Vec<f64> {
        let value = |(name, offset): &(&str, f64)| if name.ends_with("position") { *offset } else { 0.0 };
        self.channels().iter().map(value).collect()
    }

    /// The mirror image of the motion.
    fn mirrored(&self) -> Self {
        let mut words = Vec::new();
        for line in self.head.lines() {
            let mut line: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
            if line.first().is_some_and(|word| word == "OFFSET") {
                line[1] = (-line[1].parse::<f64>().unwrap()).to_string();
            }
            words.push(line.join(" "));
        }
        let signs: Vec<f64> = self
            .channels()
            .iter()
            .map(|(name, _)| {
                if matches!(*name, "Xposition" | "Yrotation" | "Zrotation") {
                    -1.0
                } else {
                    1.0
                }
            })
            .collect();
        let row = |row: &Vec<f64>| row.iter().zip(&signs).map(|(value, sign)| value * sign).collect();
        Self {
            head: words.join("\n") + "\n",
            seconds: self.seconds,
            rows: self.rows.iter().map(row).collect(),
        }
    }
}

/// Three offsets that look like noise, with a standard deviation of 1.
fn noise(frame: usize) -> [f64; 3] {
    [12.9898, 78.233, 37.719].map(|seed| {
        let unit = ((frame as f64 + 1.0) * seed).sin() * 43758.5453;
        (unit - unit.floor() - 0.5) * 12f64.sqrt()
    })
}

/// The height of the floor in metres.
fn ground(scene: &Scene, metres: f64) -> f64 {
    f64::from(Figure::new(scene).ground_of(scene).unwrap().height()) * metres
}

#[test]
fn what_changes_no_floor_changes_no_ground() {
    for name in CLIPS {
        let bvh = Bvh::open(name);
        let rows = &bvh.rows;
        let whole = bvh.scene(rows, bvh.seconds);
        let figure = Figure::new(&whole);
        let metres = figure.survey.metres_per_unit;
        let expected = ground(&whole, metres);
        let second = (1.0 / bvh.seconds).round() as usize;
        let held = |at: usize| [&rows[..at], &vec![rows[at].clone(); 30], &rows[at..]].concat();
        let mut frozen = rows.clone();
        let third = rows.len() / 3;
        frozen[third..third + second.min(rows.len() / 5)].fill(rows[third].clone());
        let at_rest = bvh.at_rest();
        let doubled: Vec<_> = rows.iter().flat_map(|row| [row.clone(), row.clone()]).collect();
        let reversed: Vec<_> = rows.iter().rev().cloned().collect();
        let halved: Vec<_> = rows.iter().step_by(2).cloned().collect();
        let mut noisy = rows.clone();
        for (frame, row) in noisy.iter_mut().enumerate() {
            for (value, noise) in row.iter_mut().zip(noise(frame)) {
                *value += 0.002 / metres * noise;
            }
        }
        let up = match figure.up.value {
            Axis::Z => UpAxis::Z,
            Axis::NegY => UpAxis::NegY,
            Axis::NegZ => UpAxis::NegZ,
            _ => UpAxis::Y,
        };
        let mut inches = whole.clone();
        convert_units_to(&mut inches, (metres, up), (0.0254, up));
        let mirrored = bvh.mirrored();
        let same_rate = |rows: &[Vec<f64>]| (bvh.scene(rows, bvh.seconds), metres);
        for (law, (changed, metres)) in [
            ("held in the middle", same_rate(&held(rows.len() / 2))),
            ("held at the end", same_rate(&held(rows.len() - 1))),
            ("frozen", same_rate(&frozen)),
            (
                "a rest pose first",
                same_rate(&[std::slice::from_ref(&at_rest), rows].concat()),
            ),
            (
                "a rest pose held first",
                same_rate(&[&vec![at_rest; 30], &rows[..]].concat()),
            ),
            ("reversed", same_rate(&reversed)),
            ("half the rate", (bvh.scene(&halved, 2.0 * bvh.seconds), metres)),
            ("doubled frames", (bvh.scene(&doubled, 0.5 * bvh.seconds), metres)),
            ("noise of 2 mm", same_rate(&noisy)),
            ("in inches", (inches, 0.0254)),
            ("mirrored", (mirrored.scene(&mirrored.rows, bvh.seconds), metres)),
        ] {
            let changed = ground(&changed, metres);
            assert!(
                (changed - expected).abs() < SAME,
                "{name}, {law}: {changed} m instead of {expected} m"
            );
        }
    }
}

/// Two feet that walk on a floor at 5 cm, at 25 frames per second. One stance of `stance` frames is at another level.
fn walk(stance: usize, level: f32) -> Vec<Vec<Vec3>> {
    let mut feet = vec![Vec::new(), Vec::new()];
    for step in 0..20 {
        let frames = if step == 10 { stance } else { 0 };
        let stands = 0.6 * step as f32;
        for frame in 0..frames {
            // A foot in stance trembles.
            let tremble = 0.0005 * (frame % 2) as f32;
            feet[step % 2].push(Vec3::new(stands, level + tremble, 0.0));
            feet[1 - step % 2].push(Vec3::new(stands - 0.6, level + tremble, 0.2));
        }
        for frame in 0..12 {
            let along = frame as f32 / 12.0;
            let lifted = 0.1 * (std::f32::consts::PI * along).sin();
            feet[step % 2].push(Vec3::new(stands, 0.05, 0.0));
            feet[1 - step % 2].push(Vec3::new(stands - 0.6 + 1.2 * along, 0.05 + lifted, 0.2));
        }
    }
    feet
}

#[test]
fn a_long_stance_counts_as_a_step() {
    for (stance, level) in [(0, 0.0), (100, 0.2), (400, 0.2), (20, 0.2)] {
        let found = levels(&[walk(stance, level)], Vec3::Y, 1.0, 25.0)[0].unwrap();
        assert!((found - 0.05).abs() < 0.005, "{stance} frames at {level} m: {found} m");
    }
    // Nothing moves, so the ground is at the feet.
    let still = vec![vec![Vec3::new(0.0, 0.3, 0.0); 50]; 2];
    assert_eq!(levels(&[still], Vec3::Y, 1.0, 25.0), [Some(0.3)]);
}

#[test]
fn a_drift_in_height_is_measured_and_a_stair_is_none() {
    let feet = walk(0, 0.0);
    let frames = feet[0].len() as f32;
    let drift = |by: &dyn Fn(usize) -> f32| {
        let raise = |track: &Vec<Vec3>| {
            let points = track.iter().enumerate();
            points.map(|(frame, at)| *at + by(frame) * Vec3::Y).collect()
        };
        let balls: Vec<Vec<Vec3>> = feet.iter().map(raise).collect();
        height_drift(&[Vec::new(), balls], Vec3::Y, 1.0, 25.0).unwrap()
    };
    assert!(drift(&|_| 0.0) < 0.01);
    for amount in [0.3, -0.3, 0.1] {
        let seen = drift(&|frame| amount * frame as f32 / frames);
        assert!(
            (seen - f64::from(amount.abs())).abs() < 0.03,
            "{seen} m instead of {amount} m"
        );
    }
    // A step is 0.48 s long.
    for rise in [0.18, 0.08, -0.18] {
        let seen = drift(&|frame| rise * (frame / 12) as f32);
        assert_eq!(seen, 0.0, "stairs of {rise} m");
    }
}

#[test]
fn feet_that_sink_into_the_ground_leave_it_where_it_is() {
    for (sunk, depth) in [(2, 0.07), (5, 0.12)] {
        let mut feet = walk(0, 0.0);
        for track in &mut feet {
            for at in &mut track[60..60 + 12 * sunk] {
                at.y -= depth;
            }
        }
        let found = levels(&[feet], Vec3::Y, 1.0, 25.0)[0].unwrap();
        assert!((found - 0.05).abs() < 0.005, "{sunk} steps at {depth} m: {found} m");
    }
}
