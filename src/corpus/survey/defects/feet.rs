//! Feet that slide where they stand, feet below the floor, and legs that walk without going anywhere.

use glam::Vec3;
use mocap_edit::report::ContactPoint;
use mocap_scene::math::median::median;
use mocap_scene::scene::HumanoidBone as Bone;

use super::{Findings, confidence};
use crate::survey::motion::{Body, Motion};
use crate::survey::spans;
use crate::survey::thresholds::DefectKind::{Skate, Treadmill, UnderFloor};

/// The height in metres up to which a foot that slides fast counts as on the floor.
const GLIDES_BELOW: f32 = 0.04;

/// The least speed in m/s of such a foot: slower ones roll.
const GLIDES: f32 = 0.3;

/// The time in seconds for which it glides at least: a foot that swings past is as low for less.
const GLIDES_FOR: f64 = 0.2;
/// How deep below the floor a span begins, in metres.
const BELOW: f32 = 0.02;
/// Times between two in which a foot is below the floor, in which it may be lifted for a step, in seconds.
const A_STEP: f64 = 0.4;
/// The window in which steps of a treadmill are looked for, in seconds.
const WINDOW: f64 = 2.0;

/// The least length of the step of a treadmill, in lengths of the leg: shorter ones are shuffled.
const STEP: f32 = 0.35;

/// The longest path of the hips in the window, in lengths of the leg: who walks on a floor goes farther.
const STAYS: f32 = 0.45;
/// The median speed at which the lower foot goes backwards, or forwards, in the window, in metres per second: that of
/// the belt. The feet of one who dances on the spot stand.
const BELT: f32 = 0.25;

pub(super) fn find(motion: &Motion, body: &Body, findings: &mut Findings<'_>) {
    findings.look_for(&[Skate, UnderFloor, Treadmill]);
    let points = &body.contacts.points;
    let has_balls = points.iter().any(is_ball);
    for point in points.iter().filter(|point| is_ball(point) == has_balls) {
        slides(motion, body, point, findings);
    }
    glides(motion, body, findings);
    for point in points {
        let depth = |frame: usize| point.above_rest.get(frame).map_or(0.0, |height| -height);
        let sunk = spans(motion.frames, |frame| frame >= motion.first && depth(frame) > BELOW);
        for [from, to] in joined(sunk, motion.frames_in(A_STEP)) {
            let deepest = 100.0 * (from..=to).map(depth).fold(0.0, f32::max);
            findings.add(
                UnderFloor,
                [from, to],
                Some(&point.name),
                deepest,
                confidence(deepest, 4.0),
            );
        }
    }
    treadmill(motion, body, findings);
}

/// Spans of which those are one that are at most so many frames apart.
fn joined(spans: Vec<[usize; 2]>, apart: usize) -> Vec<[usize; 2]> {
    let mut joined: Vec<[usize; 2]> = Vec::new();
    for [from, to] in spans {
        match joined.last_mut() {
            Some(last) if from - last[1] <= apart => last[1] = to,
            _ => joined.push([from, to]),
        }
    }
    joined
}

fn is_ball(point: &ContactPoint) -> bool {
    matches!(point.bone, Bone::LeftToes | Bone::RightToes)
}

/// How far a foot moves along the floor in each contact of a point of it: that point of the foot which moves least. A
/// foot that turns on its heel or on its ball does not slide.
fn slides(motion: &Motion, body: &Body, point: &ContactPoint, findings: &mut Findings<'_>) {
    let side = point.bone.side();
    let points = body.contacts.points.iter();
    let nodes: Vec<usize> = points
        .filter(|other| other.bone.side() == side)
        .map(|other| other.node.index())
        .collect();
    for [from, to] in point.intervals() {
        let (from, to) = (from.max(motion.first), to.min(motion.frames - 1));
        let slide = |node: &usize| {
            let at = |frame: usize| motion.at(frame, *node).with_y(0.0);
            (from..=to)
                .map(|frame| at(frame).distance(at(from)))
                .fold(0.0, f32::max)
        };
        let centimetres = 100.0 * nodes.iter().map(slide).fold(f32::INFINITY, f32::min);
        findings.add(
            Skate,
            [from, to],
            Some(&point.name),
            centimetres,
            confidence(centimetres, 6.0),
        );
    }
}

/// Times in which a foot is on the floor and none is at rest.
fn glides(motion: &Motion, body: &Body, findings: &mut Findings<'_>) {
    let half = motion.frames_in(0.03);
    let slowest = |frame: usize| {
        let low = body.contacts.points.iter();
        let low = low.filter(|point| point.above_rest.get(frame).is_some_and(|height| *height < GLIDES_BELOW));
        let speed = |point: &ContactPoint| motion.velocity(frame, point.node.index(), half).with_y(0.0).length();
        low.map(|point| (speed(point), point))
            .min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let speeds: Vec<f32> = (0..motion.frames)
        .map(|frame| slowest(frame).map_or(0.0, |(speed, _)| speed))
        .collect();
    for [from, to] in spans(motion.frames, |frame| frame >= motion.first && speeds[frame] > GLIDES) {
        if to + 1 - from < motion.frames_in(GLIDES_FOR) {
            continue;
        }
        let path = 100.0 * speeds[from..=to].iter().sum::<f32>() / motion.rate as f32;
        let joint = slowest((from + to) / 2).map(|(_, point)| point.name.as_str());
        findings.add(Skate, [from, to], joint, path, confidence(path, 6.0));
    }
}

/// Windows in which the feet pass each other by steps, while the hips stay.
fn treadmill(motion: &Motion, body: &Body, findings: &mut Findings<'_>) {
    let feet = [Bone::LeftFoot, Bone::RightFoot].map(|bone| body.bones.get(&bone).copied());
    let [Some(left), Some(right)] = feet else { return };
    let apart: Vec<f32> = (0..motion.frames)
        .map(|frame| (motion.at(frame, left) - motion.at(frame, right)).dot(body.forward(motion, frame)))
        .collect();
    let hips: Vec<Vec3> = (0..motion.frames)
        .map(|frame| motion.at(frame, body.hips()).with_y(0.0))
        .collect();
    let around = motion.frames_in(0.03);
    let carried = |frame: usize| {
        let lower = match motion.at(frame, left).y < motion.at(frame, right).y {
            true => left,
            false => right,
        };
        motion.velocity(frame, lower, around).dot(body.forward(motion, frame))
    };
    let carried: Vec<f32> = (0..motion.frames).map(carried).collect();
    let (window, half) = (motion.frames_in(WINDOW), STEP * body.leg / 2.0);
    let mut walks = vec![false; motion.frames];
    let mut start = motion.first;
    while start + window <= motion.frames {
        let part = start..start + window;
        // Steps: the feet are apart by half a step to one side, and then to the other.
        let mut side = 0.0;
        let mut passes = 0;
        for frame in part.clone() {
            if apart[frame].abs() > half && side != apart[frame].signum() {
                passes += i32::from(side != 0.0);
                side = apart[frame].signum();
            }
        }
        let path = part
            .clone()
            .map(|frame| hips[frame].distance(hips[start]))
            .fold(0.0, f32::max);
        let belt = median(&mut carried[part.clone()].to_vec()).unwrap_or(0.0);
        if passes >= 2 && path < STAYS * body.leg && belt.abs() > BELT {
            walks[part].fill(true);
        }
        start += motion.frames_in(0.25);
    }
    for [from, to] in spans(motion.frames, |frame| walks[frame]) {
        let seconds = (to + 1 - from) as f64 / motion.rate;
        findings.add(Treadmill, [from, to], None, seconds as f32, 0.8);
    }
}
