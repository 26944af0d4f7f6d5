//! Tests of `clean`: it repairs defects planted in cut fixtures, part by part, and leaves clean motions unchanged.

mod gaps;
mod rates;

use std::f32::consts::PI;

use mocap::edit::report::{CleanOutcome, CleanReport};
use mocap::edit::{Clean, CleanPart, LiveClean, Step, StepInput};
use mocap::glam::{Quat, Vec3};
use mocap::ik::Goal;
use mocap::scene::{NodeId, Scene};
use mocap::{Code, Pose, Trs};

/// A part of a walk.
fn walk() -> Scene {
    let mut scene = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
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

/// Runs only one part of the cleaning.
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

/// Random numbers between -1 and 1 that are equal on every machine: a linear congruential generator (Knuth's MMIX).
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    }

    /// An almost normal number of variance 1: the sum of twelve numbers, less their mean.
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
        assert!(report.to_string().contains("1 dropped frame inserted"), "{report}");
        assert_eq!(scene.animations[0].frame_count(), truth.animations[0].frame_count());
        // An inserted frame at the wrong place would be off by a step of the walk, at least a centimetre.
        assert!(
            distance(&truth, &scene) < 1e-3,
            "{report}: {}",
            distance(&truth, &scene)
        );
    }
}

/// Calls `change` with all keys of each channel. A constant channel has one key.
fn with_keys(scene: &mut Scene, change: impl Fn(&mut Vec<Quat>), moves: impl Fn(&mut Vec<Vec3>)) {
    for channel in &mut scene.animations[0].channels {
        change(&mut channel.rotation_keys.values);
        moves(&mut channel.position_keys.values);
    }
}

/// A film of 24 frames per second in a file of 30 repeats each fourth frame.
fn repeat_each_fourth_frame(scene: &mut Scene) {
    fn repeated<T: Copy>(keys: &mut Vec<T>) {
        let own = std::mem::take(keys);
        let is_constant = own.len() == 1;
        for (index, key) in own.into_iter().enumerate() {
            keys.extend(std::iter::repeat_n(
                key,
                if index % 4 == 3 && !is_constant { 2 } else { 1 },
            ));
        }
    }
    with_keys(scene, repeated, repeated);
    let animation = &mut scene.animations[0];
    animation.duration = animation.channels[0].position_keys.len() as f64 - 1.0;
}

#[test]
fn frames_that_repeat_in_a_pattern_are_taken_out_with_their_rate() {
    let truth = walk();
    let mut scene = truth.clone();
    repeat_each_fourth_frame(&mut scene);
    let report = only(CleanPart::Time, &mut scene);
    let [true_one, found] = [&truth, &scene].map(|scene| &scene.animations[0]);
    assert!(
        (found.ticks_per_second - 0.8 * true_one.ticks_per_second).abs() < 1e-9,
        "{report}"
    );
    assert!(found.frame_count().abs_diff(true_one.frame_count()) <= 1, "{report}");
    assert!(
        distance(&truth, &scene) < 1e-4,
        "{report}: {}",
        distance(&truth, &scene)
    );
}

/// A jump falls by gravity: a file that states half of the true rate shows slow motion.
#[test]
fn jumps_tell_of_a_rate_that_the_file_does_not_have() {
    let jumps = mocap::import("../../fixtures/real/cmu_01_01.bvh").unwrap();
    let stated = jumps.animations[0].ticks_per_second;
    for (factor, corrected) in [(1.0, 1.0), (0.5, 1.0), (0.25, 1.0), (0.7, 0.7)] {
        let mut scene = jumps.clone();
        scene.animations[0].ticks_per_second = factor * stated;
        let report = only(CleanPart::Time, &mut scene);
        let rate = scene.animations[0].ticks_per_second;
        assert!((rate / stated - corrected).abs() < 1e-6, "{factor}: {rate}, {report}");
        assert_eq!(report.doubts.len(), usize::from(factor == 0.7), "{report}");
        assert_eq!(report.after.frame_rate, rate);
    }
}

#[test]
fn a_walk_in_slow_motion_is_pointed_out_and_stays() {
    for (factor, word) in [(1.0, None), (0.5, Some("too slow")), (2.0, Some("too fast"))] {
        let mut scene = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
        scene.animations[0].ticks_per_second *= factor;
        let before = scene.animations.clone();
        let report = only(CleanPart::Time, &mut scene);
        assert_eq!(before, scene.animations);
        let doubt = report.doubts.first().map(String::as_str);
        assert_eq!(doubt.is_some(), word.is_some(), "{factor}: {report}");
        assert!(word.is_none_or(|word| doubt.unwrap().contains(word)), "{report}");
    }
}

/// Rolls the left shin by half a turn in frames 60 to 94. The roll axis is the offset of its child.
fn flip_left_shin(scene: &mut Scene) {
    let shin = scene.nodes.iter().position(|node| node.name == "LeftLeg").unwrap();
    let child = scene
        .nodes
        .iter()
        .find(|node| node.parent == Some(NodeId::new(shin)))
        .unwrap();
    let bone = child.transform.w_axis.truncate().normalize();
    for rotation in &mut rotations(scene, "LeftLeg")[60..95] {
        *rotation *= Quat::from_axis_angle(bone, PI);
    }
}

/// A held frame where a flip begins does not belong to the flip.
#[test]
fn a_flip_stays_a_flip_where_frames_are_held() {
    let truth = walk();
    let mut scene = truth.clone();
    flip_left_shin(&mut scene);
    fn hold<T: Copy>(keys: &mut [T], frame: usize) {
        if keys.len() > frame {
            keys[frame] = keys[frame - 1];
        }
    }
    for frame in [60, 95, 120] {
        with_keys(&mut scene, |keys| hold(keys, frame), |keys| hold(keys, frame));
    }
    let off = distance(&truth, &scene);
    let report = Clean::new().floor(false).apply(&mut scene, &StepInput::new()).unwrap();
    assert_eq!((report.after.held_frames, report.after.jumps), (0, 0), "{report}");
    assert!(
        distance(&truth, &scene) < 0.05 * off,
        "{report}: {} of {off}",
        distance(&truth, &scene)
    );
}

#[test]
fn a_bone_turned_about_itself_is_turned_back() {
    let truth = walk();
    let mut scene = truth.clone();
    flip_left_shin(&mut scene);
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

/// Adds noise of 2 degrees to every rotation.
fn add_noise(scene: &mut Scene, seed: u64) {
    let mut dice = Dice(seed);
    for channel in &mut scene.animations[0].channels {
        for rotation in &mut channel.rotation_keys.values {
            *rotation *= Quat::from_scaled_axis(dice.normals() * (2f32 / 3f32.sqrt()).to_radians());
        }
    }
}

const ANKLES: [&str; 2] = ["LeftFoot", "RightFoot"];
const BALLS: [&str; 2] = ["LeftToeBase", "RightToeBase"];

/// The mean speed over the ground of `points`, in units per second, in frames in which they are slow in `truth`.
fn slide(points: [&str; 2], scene: &Scene, truth: &Scene) -> f32 {
    let points = points.map(|name| NodeId::new(scene.nodes.iter().position(|node| node.name == name).unwrap()));
    let rate = truth.animations[0].ticks_per_second;
    let step = |scene: &Scene, frame: usize, point: NodeId| {
        let [a, b] = [0, 1].map(|more| Pose::at_tick(scene, 0, (frame + more) as f64).unwrap().position(point));
        Vec3::new(b.x - a.x, 0.0, b.z - a.z).length() * rate as f32
    };
    let (mut sum, mut count) = (0.0, 0.0);
    for frame in 0..truth.animations[0].frame_count() - 1 {
        for point in points {
            // The speed is in CMU's units of 5.6 cm per second.
            if step(truth, frame, point) < 1.5 {
                sum += step(scene, frame, point);
                count += 1.0;
            }
        }
    }
    sum / count
}

#[test]
fn feet_that_stand_slide_no_more_than_before_they_were_spoiled() {
    let truth = walk();
    let mut scene = truth.clone();
    add_noise(&mut scene, 11);
    let spoiled = slide(ANKLES, &scene, &truth);
    let report = Clean::new().floor(false).apply(&mut scene, &StepInput::new()).unwrap();
    assert_eq!(outcome(&report, CleanPart::Contacts), CleanOutcome::Changed, "{report}");
    let (clean, own) = (slide(ANKLES, &scene, &truth), slide(ANKLES, &truth, &truth));
    assert!(
        clean < 0.03 * spoiled && clean < 3.0 * own,
        "{clean} of {spoiled}, {own} in truth: {report}"
    );
}

#[test]
fn a_corrected_rate_stays_where_feet_are_locked() {
    let mut scene = walk();
    let rate = scene.animations[0].ticks_per_second;
    add_noise(&mut scene, 11);
    repeat_each_fourth_frame(&mut scene);
    let report = Clean::new().floor(false).apply(&mut scene, &StepInput::new()).unwrap();
    for part in [CleanPart::Time, CleanPart::Contacts] {
        assert_eq!(outcome(&report, part), CleanOutcome::Changed, "{report}");
    }
    let found = scene.animations[0].ticks_per_second;
    assert!((found - 0.8 * rate).abs() < 1e-9, "{found} for {rate}: {report}");
}

/// Many formats have no channel for a joint that does not move.
#[test]
fn a_foot_without_a_channel_is_locked() {
    let mut scene = walk();
    scene.animations[0]
        .channels
        .retain(|channel| channel.node_name != "LeftFoot");
    let truth = scene.clone();
    add_noise(&mut scene, 11);
    let spoiled = slide(ANKLES, &scene, &truth);
    let report = Clean::new().floor(false).apply(&mut scene, &StepInput::new()).unwrap();
    assert_eq!(outcome(&report, CleanPart::Contacts), CleanOutcome::Changed, "{report}");
    assert_eq!(scene.validate(), []);
    let clean = slide(ANKLES, &scene, &truth);
    assert!(clean < 0.1 * spoiled, "{clean} of {spoiled}: {report}");
}

/// The fastest moments of a body that stands still are noise. The peak speed is no reason to keep this noise.
#[test]
fn a_body_that_stands_still_loses_its_noise() {
    let mut truth = walk();
    with_keys(
        &mut truth,
        |rotations| {
            if let Some(&first) = rotations.first() {
                rotations.fill(first);
            }
        },
        |positions| {
            if let Some(&first) = positions.first() {
                positions.fill(first);
            }
        },
    );
    let mut scene = truth.clone();
    add_noise(&mut scene, 17);
    let off = distance(&truth, &scene);
    let report = only(CleanPart::Noise, &mut scene);
    assert_eq!(outcome(&report, CleanPart::Noise), CleanOutcome::Changed, "{report}");
    assert!(distance(&truth, &scene) < 0.6 * off, "{report}");
}

/// Noise that lasts for a tenth of a second resembles a motion, so it stays in the body. Feet that stand must not
/// slide. Noise also turns a foot about its ball. After the cleaning, neither the ankle nor the ball of a standing foot
/// moves.
#[test]
fn feet_under_lasting_noise_are_held() {
    let truth = walk();
    let mut scene = truth.clone();
    let mut dice = Dice(19);
    let kept = (-1.0 / (0.1 * truth.animations[0].ticks_per_second as f32)).exp();
    for channel in &mut scene.animations[0].channels {
        let mut noise = dice.normals();
        for rotation in &mut channel.rotation_keys.values {
            *rotation *= Quat::from_scaled_axis(noise * 1f32.to_radians());
            noise = noise * kept + dice.normals() * (1.0 - kept * kept).sqrt();
        }
    }
    let spoiled = slide(ANKLES, &scene, &truth);
    let report = Clean::new().floor(false).apply(&mut scene, &StepInput::new()).unwrap();
    assert_eq!(outcome(&report, CleanPart::Contacts), CleanOutcome::Changed, "{report}");
    let clean = [ANKLES, BALLS].map(|points| slide(points, &scene, &truth));
    // 0.5 cm per second, in CMU's units of 5.6 cm.
    assert!(
        clean.iter().all(|clean| *clean < 0.5 / 5.6),
        "{clean:?} of {spoiled}: {report}"
    );
}

/// Twist helpers and fingers that move by rounding only do not hide the noise of the other joints.
#[test]
fn helpers_that_hardly_move_change_nothing() {
    let mut scene = walk();
    let mut dice = Dice(23);
    let kept = (-1.0 / (0.04 * scene.animations[0].ticks_per_second as f32)).exp();
    for channel in &mut scene.animations[0].channels {
        let mut noise = dice.normals();
        for rotation in &mut channel.rotation_keys.values {
            *rotation *= Quat::from_scaled_axis(noise * 1f32.to_radians());
            noise = noise * kept + dice.normals() * (1.0 - kept * kept).sqrt();
        }
    }
    let mut helped = scene.clone();
    let head = channel(&scene, "Head");
    for index in 0..2 * scene.nodes.len() {
        let mut node = scene.nodes[scene.nodes.len() - 1].clone();
        node.name = format!("helper{index}");
        node.parent = Some(NodeId::new(0));
        let mut helper = scene.animations[0].channels[head].clone();
        helper.node_name = node.name.clone();
        helper.node = Some(NodeId::new(helped.nodes.len()));
        for rotation in &mut helper.rotation_keys.values {
            *rotation = Quat::from_scaled_axis(dice.normals() * 1e-6);
        }
        helped.nodes.push(node);
        helped.animations[0].channels.push(helper);
    }
    let alone = only(CleanPart::Noise, &mut scene);
    let report = only(CleanPart::Noise, &mut helped);
    assert_eq!(outcome(&report, CleanPart::Noise), CleanOutcome::Changed, "{report}");
    let about = |report: &CleanReport| report.parts.iter().map(|part| part.about.clone()).collect::<Vec<_>>();
    assert_eq!(about(&alone), about(&report));
}

/// The mean distance of the ankles above or below their mean height, in units of the scene. Only frames count in which
/// the ankles are slow in `truth`.
fn off_level(scene: &Scene, truth: &Scene) -> f32 {
    let (mut sum, mut count) = (0.0, 0.0);
    for name in ["LeftFoot", "RightFoot"] {
        let ankle = NodeId::new(scene.nodes.iter().position(|node| node.name == name).unwrap());
        let at = |scene: &Scene, frame: usize| Pose::at_tick(scene, 0, frame as f64).unwrap().position(ankle);
        let frames = 0..truth.animations[0].frame_count() - 1;
        let rate = truth.animations[0].ticks_per_second as f32;
        let stands = frames.filter(|frame| (at(truth, *frame + 1) - at(truth, *frame)).length() * rate < 1.0);
        let heights: Vec<f32> = stands.map(|frame| at(scene, frame).y).collect();
        let mean = heights.iter().sum::<f32>() / heights.len() as f32;
        sum += heights.iter().map(|height| (height - mean).abs()).sum::<f32>();
        count += heights.len() as f32;
    }
    sum / count
}

/// If a body moves up and down as a whole, its feet leave the ground. Cleaning brings them to one level.
#[test]
fn feet_in_contact_come_to_one_level() {
    let truth = walk();
    let mut scene = truth.clone();
    add_noise(&mut scene, 13);
    let (rate, hips) = (truth.animations[0].ticks_per_second as f32, channel(&scene, "Hips"));
    let positions = &mut scene.animations[0].channels[hips].position_keys.values;
    for (frame, position) in positions.iter_mut().enumerate() {
        // The motion is 2.5 cm, in CMU's units.
        position.y += 2.5 * 0.45 / 2.54 * (frame as f32 / rate * 3.0).sin();
    }
    let [(without, _), (with, report)] = without_and_with_contacts(&scene);
    let off = [&truth, &without, &with].map(|scene| off_level(scene, &truth));
    assert!(off[2] < 0.5 * off[1], "{off:?}: {report}");
    let (before, after) = (report.parts[4].after.uneven.unwrap(), report.after.uneven.unwrap());
    assert!(after < 0.7 * before, "{report}");
}

/// The sensors of this take jump, and an inserted frame would add a jump.
#[test]
fn a_part_that_makes_a_measure_worse_is_taken_back() {
    let before = mocap::import("../../fixtures/real/mocopi_jump_six_channels.bvh").unwrap();
    let mut after = before.clone();
    let report = only(CleanPart::Time, &mut after);
    assert_eq!(outcome(&report, CleanPart::Time), CleanOutcome::TakenBack, "{report}");
    assert!(
        report.to_string().contains("undone: ") && report.to_string().contains("; with this change, "),
        "{report}"
    );
    assert_eq!((before.animations, report.before), (after.animations, report.after));
}

/// The clock of the recording program runs unevenly. Up to this frame, no joint rotates by 20 degrees per second.
#[test]
fn no_frame_is_put_into_a_body_at_rest() {
    let mut before = mocap::import("../../fixtures/skeletons/rosemotion_robin.bvh").unwrap();
    before.trim(0.0, 86.0);
    let mut after = before.clone();
    let report = only(CleanPart::Time, &mut after);
    assert!(report.before.peak_speed < 0.05, "{report}");
    assert_eq!(outcome(&report, CleanPart::Time), CleanOutcome::Nothing, "{report}");
    assert_eq!(before.animations, after.animations);
}

/// The joints of the spine in the first take move relative to their parents, as recorded. Without this motion, the feet
/// of the take would slide. The second take runs on the spot, so a locked foot would have no place.
#[test]
fn feet_slide_no_more_and_stand_as_before() {
    for (file, part) in [
        ("perception_neuron_moving_positions.bvh", CleanPart::Lengths),
        ("run.fbx", CleanPart::Contacts),
    ] {
        let mut scene = mocap::import(format!("../../fixtures/real/{file}")).unwrap();
        let report = only(part, &mut scene);
        assert_eq!(outcome(&report, part), CleanOutcome::TakenBack, "{file}: {report}");
        assert!(
            report.before.skate.is_some() && report.before == report.after,
            "{file}: {report}"
        );
    }
}

/// The nodes of both arms of CMU's skeletons, from the shoulder to the hand.
fn arms(scene: &Scene) -> [[NodeId; 3]; 2] {
    let node = |name: String| NodeId::new(scene.nodes.iter().position(|node| node.name == name).unwrap());
    ["Left", "Right"].map(|side| ["Arm", "ForeArm", "Hand"].map(|part| node(format!("{side}{part}"))))
}

/// Moves both hands in front of the chest, `apart` units from each other in each frame.
fn join_hands(scene: &mut Scene, apart: impl Fn(usize) -> f32) {
    let arms = arms(scene);
    let chest = NodeId::new(scene.nodes.iter().position(|node| node.name == "Spine1").unwrap());
    let posed = scene.clone();
    for frame in 0..scene.animations[0].frame_count() {
        let mut pose = Pose::at_tick(&posed, 0, frame as f64).unwrap();
        let shoulders = arms.map(|[shoulder, ..]| pose.position(shoulder));
        let aside = (shoulders[0] - shoulders[1]).normalize();
        let up = (shoulders[0].midpoint(shoulders[1]) - pose.position(chest))
            .reject_from(aside)
            .normalize();
        let front = aside.cross(up);
        let middle = shoulders[0].midpoint(shoulders[1]) + front * 6.0 - up * 2.0;
        for (arm, side) in arms.into_iter().zip([0.5, -0.5]) {
            pose.bend_limb(arm, &Goal::at(middle + aside * side * apart(frame)), None);
            for node in arm {
                let rotation = Trs::from_matrix(pose.node_to_parent[node.index()]).rotation;
                rotations(scene, &posed.nodes[node.index()].name)[frame] = rotation;
            }
        }
    }
}

/// The mean error in `frames` of the position of one hand relative to the other.
fn hands_off(scene: &Scene, truth: &Scene, frames: &[usize]) -> f32 {
    let hands = arms(truth).map(|arm| arm[2]);
    let apart = |scene: &Scene, frame: usize| {
        let pose = Pose::at_tick(scene, 0, frame as f64).unwrap();
        pose.position(hands[0]) - pose.position(hands[1])
    };
    let off = frames
        .iter()
        .map(|frame| apart(scene, *frame).distance(apart(truth, *frame)));
    off.sum::<f32>() / frames.len() as f32
}

/// Runs the parts before the contacts, and then all parts.
fn without_and_with_contacts(scene: &Scene) -> [(Scene, CleanReport); 2] {
    [false, true].map(|contacts| {
        let mut scene = scene.clone();
        let step = Clean::new().floor(false).contacts(contacts);
        let report = step.apply(&mut scene, &StepInput::new()).unwrap();
        (scene, report)
    })
}

/// Clapping hands stay as near to each other as before the cleaning.
#[test]
fn a_clap_stays_a_clap() {
    let mut truth = walk();
    let period = 60.0;
    let apart = |frame: usize| 1.2 + 6.0 * (std::f32::consts::PI * frame as f32 / period).sin().abs();
    join_hands(&mut truth, apart);
    let mut scene = truth.clone();
    add_noise(&mut scene, 5);
    let frames: Vec<usize> = (0..truth.animations[0].frame_count())
        .filter(|frame| apart(*frame) < 2.0)
        .collect();
    let spoiled = hands_off(&scene, &truth, &frames);
    let [(without, _), (with, report)] = without_and_with_contacts(&scene);
    let off = [&without, &with].map(|scene| hands_off(scene, &truth, &frames));
    assert!(off[1] < 0.75 * off[0], "{off:?} of {spoiled}: {report}");
    let (before, after) = (report.before.hands.unwrap(), report.after.hands.unwrap());
    assert!((after / before - 1.0).abs() < 0.1, "{report}");
}

/// An estimate from one camera jitters and wavers along the camera's axis.
#[test]
fn the_depth_of_one_camera_is_steadied() {
    let truth = walk();
    let axis = Vec3::new(0.8, 0.0, 0.6);
    let mut scene = truth.clone();
    let mut dice = Dice(9);
    let rate = scene.animations[0].ticks_per_second as f32;
    let hips = channel(&scene, "Hips");
    let units = 0.45 / 2.54; // of CMU in a centimetre: they are inches by 0.45
    for (frame, place) in scene.animations[0].channels[hips]
        .position_keys
        .values
        .iter_mut()
        .enumerate()
    {
        let t = frame as f32 / rate * std::f32::consts::TAU;
        *place += axis * units * (4.0 * (0.9 * t).sin() + 2.5 * dice.normal());
    }
    add_noise(&mut scene, 21);
    let off = |scene: &Scene| {
        let place = |scene: &Scene, frame: f64| Pose::at_tick(scene, 0, frame).unwrap().position(NodeId::new(0));
        let frames = 0..truth.animations[0].frame_count();
        let steps: Vec<f32> = frames
            .map(|f| (place(scene, f as f64) - place(&truth, f as f64)).dot(axis))
            .collect();
        // No foot shows a constant displacement of the whole body, so the mean does not count.
        let mean = steps.iter().sum::<f32>() / steps.len() as f32;
        steps.iter().map(|step| (step - mean).abs()).sum::<f32>() / steps.len() as f32
    };
    let spoiled = off(&scene);
    let report = Clean::new().apply(&mut scene, &StepInput::new()).unwrap();
    assert!(report.to_string().contains("depth"), "{report}");
    assert!(off(&scene) < 0.4 * spoiled, "{} of {spoiled}: {report}", off(&scene));
}

#[test]
fn without_a_body_the_report_says_what_was_left_out() {
    let mut scene = mocap::import("../../fixtures/real/lecture_Test.bvh").unwrap();
    let report = Clean::new().apply(&mut scene, &StepInput::new()).unwrap();
    for part in [CleanPart::Lengths, CleanPart::Floor, CleanPart::Contacts] {
        assert_eq!(outcome(&report, part), CleanOutcome::LeftOut);
    }
    assert!(report.to_string().contains("skipped: the skeleton is not a humanoid"));
}

/// Live cleaning returns each frame half a second later, with hardly more noise than the cleaning of the whole motion.
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
