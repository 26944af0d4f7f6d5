//! `clean`: planted defects on cut fixtures, each part alone, and what is clean stays.

use std::f32::consts::PI;

use mocap::edit::{Clean, CleanOutcome, CleanPart, CleanReport, LiveClean, Step, StepInput};
use mocap::glam::{Quat, Vec3};
use mocap::scene::{NodeId, Scene};
use mocap::{Code, Pose, Trs};

/// A part of a walk.
fn walk() -> Scene {
    let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh").unwrap();
    scene.trim(20.0, 260.0);
    scene
}

fn channel(scene: &Scene, name: &str) -> usize {
    let channels = &scene.animations[0].channels;
    channels.iter().position(|channel| channel.node_name == name).unwrap()
}

fn rotations<'a>(scene: &'a mut Scene, name: &str) -> &'a mut Vec<Quat> {
    let channel = channel(scene, name);
    &mut scene.animations[0].channels[channel].rotation_keys.values
}

/// Only one part.
fn only(part: CleanPart, scene: &mut Scene) -> CleanReport {
    let all = CleanPart::ALL.into_iter();
    let step = all.fold(Clean::new(), |step, other| step.part(other, other == part));
    let report = step.apply(scene, &StepInput::new()).unwrap();
    let left_out = report.parts.iter().filter(|other| other.part != part);
    assert!(left_out.into_iter().all(|other| other.outcome == CleanOutcome::LeftOut));
    report
}

fn outcome(report: &CleanReport, part: CleanPart) -> CleanOutcome {
    report.parts.iter().find(|other| other.part == part).unwrap().outcome
}

/// The mean distance of all joints of two motions, in units of the scene.
fn distance(a: &Scene, b: &Scene) -> f32 {
    let frames = a.animations[0].frame_count().min(b.animations[0].frame_count());
    let mut sum = 0.0;
    for frame in 0..frames {
        let [a, b] = [a, b].map(|scene| Pose::at_tick(scene, 0, frame as f64).unwrap());
        let nodes = 0..a.node_to_world.len();
        sum += nodes
            .clone()
            .map(|n| a.position(NodeId::new(n)).distance(b.position(NodeId::new(n))))
            .sum::<f32>()
            / nodes.len() as f32;
    }
    sum / frames as f32
}

/// Numbers that are alike on every machine, between -1 and 1: a linear congruential generator (Knuth's MMIX).
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    }

    /// Nearly normal, of variance 1: the sum of twelve, less their mean.
    fn normal(&mut self) -> f32 {
        (0..12).map(|_| self.roll()).sum::<f32>() / 2.0
    }

    fn normals(&mut self) -> Vec3 {
        Vec3::new(self.normal(), self.normal(), self.normal())
    }
}

#[test]
fn a_clean_walk_keeps_its_keys() {
    let before = walk();
    let mut after = before.clone();
    let report = Clean::new().floor(false).apply(&mut after, &StepInput::new()).unwrap();
    assert_eq!(before.animations, after.animations, "{report}");
    assert!(report.parts.iter().all(|part| part.outcome != CleanOutcome::Changed));
}

#[test]
fn frames_that_are_held_are_filled() {
    let truth = walk();
    let mut scene = truth.clone();
    for frame in [40, 81, 82, 150] {
        for channel in &mut scene.animations[0].channels {
            let rotations = &mut channel.rotation_keys.values;
            if rotations.len() > frame {
                rotations[frame] = rotations[frame - 1];
            }
            let positions = &mut channel.position_keys.values;
            if positions.len() > frame {
                positions[frame] = positions[frame - 1];
            }
        }
    }
    let off = distance(&truth, &scene);
    let report = only(CleanPart::Time, &mut scene);
    assert_eq!(
        (report.before.held_frames, report.after.held_frames),
        (4, 0),
        "{report}"
    );
    assert!(distance(&truth, &scene) < 0.1 * off, "{report}");
}

#[test]
fn a_frame_that_was_dropped_is_put_in() {
    let truth = walk();
    for dropped in [47, 133] {
        let mut scene = truth.clone();
        for channel in &mut scene.animations[0].channels {
            let keys = [channel.rotation_keys.len(), channel.position_keys.len()];
            if keys[0] > dropped {
                channel.rotation_keys.values.remove(dropped);
            }
            if keys[1] > dropped {
                channel.position_keys.values.remove(dropped);
            }
        }
        scene.animations[0].duration -= 1.0;
        let report = only(CleanPart::Time, &mut scene);
        assert!(report.to_string().contains("1 dropped frames put in"), "{report}");
        assert_eq!(scene.animations[0].frame_count(), truth.animations[0].frame_count());
        // Another frame would be off by a step of the walk, which is a centimetre and more.
        assert!(
            distance(&truth, &scene) < 1e-3,
            "{report}: {}",
            distance(&truth, &scene)
        );
    }
}

#[test]
fn a_bone_turned_about_itself_is_turned_back() {
    let truth = walk();
    let mut scene = truth.clone();
    // The left shin of this file points along its own child's offset.
    let shin = scene.nodes.iter().position(|node| node.name == "LeftLeg").unwrap();
    let child = scene
        .nodes
        .iter()
        .find(|node| node.parent == Some(NodeId::new(shin)))
        .unwrap();
    let bone = child.transform.w_axis.truncate().normalize();
    for rotation in &mut rotations(&mut scene, "LeftLeg")[60..95] {
        *rotation *= Quat::from_axis_angle(bone, PI);
    }
    let off = distance(&truth, &scene);
    let report = only(CleanPart::Flips, &mut scene);
    assert_eq!((report.before.jumps, report.after.jumps), (2, 0), "{report}");
    assert!(distance(&truth, &scene) < 1e-3 * off, "{report}");
}

#[test]
fn noise_is_taken_out_and_peaks_stay() {
    let truth = walk();
    let mut scene = truth.clone();
    let mut dice = Dice(7);
    for channel in &mut scene.animations[0].channels {
        for rotation in &mut channel.rotation_keys.values {
            *rotation *= Quat::from_scaled_axis(dice.normals() * 2f32.to_radians());
        }
    }
    let off = distance(&truth, &scene);
    let report = only(CleanPart::Noise, &mut scene);
    assert!(report.after.jitter < 0.05 * report.before.jitter, "{report}");
    assert!(report.after.peak_speed > 0.9 * report.before.peak_speed, "{report}");
    assert!(distance(&truth, &scene) < 0.6 * off, "{report}");
}

#[test]
fn without_a_body_the_report_says_what_was_left_out() {
    let mut scene = mocap::import("fixtures/real/lecture_Test.bvh").unwrap();
    let report = Clean::new().apply(&mut scene, &StepInput::new()).unwrap();
    for part in [CleanPart::Lengths, CleanPart::Floor, CleanPart::Contacts] {
        assert_eq!(outcome(&report, part), CleanOutcome::LeftOut);
    }
    assert!(report.to_string().contains("left out: the skeleton is not a humanoid"));
}

/// What comes in frame by frame comes back half a second later, with hardly more noise than when all is known.
#[test]
fn a_live_motion_loses_its_noise_with_a_delay() {
    let truth = |frame: usize| Quat::from_rotation_x((0.05 * frame as f32).sin());
    let mut dice = Dice(3);
    let mut live = LiveClean::new(60.0, 0.5).unwrap();
    let (mut noise, mut left, mut given) = (0.0, 0.0, 0);
    for frame in 0..300 {
        let noisy = truth(frame) * Quat::from_scaled_axis(dice.normals() * 2f32.to_radians());
        noise += noisy.angle_between(truth(frame)) / 300.0;
        let rotation = noisy;
        if let Some(joints) = live.push(&[Trs {
            rotation,
            ..Trs::IDENTITY
        }]) {
            left += joints[0].rotation.angle_between(truth(frame - 30)) / 270.0;
            given += 1;
        }
    }
    assert_eq!((given, live.finish().len()), (270, 30));
    assert!(left < 0.5 * noise, "{left} of {noise}");
    for (rate, delay) in [
        (0.0, 0.5),
        (f64::NAN, 0.5),
        (60.0, -1.0),
        (60.0, f64::INFINITY),
        (1e300, 1.0),
    ] {
        assert_eq!(LiveClean::new(rate, delay).unwrap_err().code(), Code::InvalidValue);
    }
}
