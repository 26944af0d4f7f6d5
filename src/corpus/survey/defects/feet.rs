//! Foot sliding, feet below the floor, and walking in place as on a treadmill.

use glam::Vec3;
use mocap_edit::report::ContactPoint;
use mocap_scene::math::median::median;
use mocap_scene::scene::HumanoidBone as Bone;

use super::{Findings, confidence, ramp};
use crate::survey::motion::{Body, Motion};
use crate::survey::spans;
use crate::survey::thresholds::DefectKind::{FootThroughFloor, Skate, Treadmill, UnderFloor};

/// Heights of a sliding foot, in metres. Below the first height, the foot counts fully as on the floor; above the
/// second, not at all.
const LOW: [f32; 2] = [0.02, 0.06];

/// Speeds of a sliding foot, in m/s. Above the first speed, the foot begins to count; above the second, it counts
/// fully. A slower foot may roll.
const GLIDES: [f32; 2] = [0.15, 0.3];

/// Durations of sliding, in seconds. Above the first duration, sliding begins to count; above the second, it counts
/// fully. A foot in the swing phase is as low as a sliding foot, but for a shorter time.
const GLIDES_FOR: [f32; 2] = [0.15, 0.25];

/// Vertical accelerations of the hips, in m/s^2. Below the first, nothing carries the body; above the second, the feet
/// carry it. The hips accelerate downwards by 6.5 to 11 m/s^2 in the flight phase of a run.
const FALLS: [f32; 2] = [-6.0, -3.0];

/// Heights of a foot above its resting height, in metres. Below the first, the foot counts fully as at rest; above the
/// second, not at all.
const LEVEL: [f32; 2] = [0.02, 0.04];

/// Vertical speeds of a foot, in m/s. Below the first, the foot counts fully as staying on the floor; above the second,
/// not at all.
const RISES: [f32; 2] = [0.05, 0.12];

/// Heights of the hips above the floor, in leg lengths. Below the first, the feet do not carry the body: a sitting
/// person moves the feet freely. Above the second, the feet carry the body.
const STANDS: [f32; 2] = [0.6, 0.75];

/// The largest distance of one foot from the common level of both feet, in metres. Joints and markers of the two feet
/// differ by as much.
const OWN_LEVEL: f32 = 0.012;

/// The least depth of a span below the floor, in metres.
const BELOW: f32 = 0.02;
/// Depths in leg lengths. At the first depth or more, the foot may stand on a lower floor, such as a stair. At the
/// second depth or more, the foot certainly stands on a lower floor, and has not sunk.
const ANOTHER_FLOOR: [f32; 2] = [0.25, 0.35];
/// Two spans below the floor are joined if the foot is above the floor between them for at most this time, in seconds.
/// The time is a step.
const A_STEP: f64 = 0.4;
/// The window in which the survey searches for steps on a treadmill, in seconds.
const WINDOW: f64 = 2.0;

/// The shortest step on a treadmill, in leg lengths. Shorter steps are shuffling.
const STEP: f32 = 0.35;

/// The longest path of the hips in the window, in leg lengths. A person who walks on a floor covers more.
const STAYS: f32 = 0.45;

/// The longest path of the hips in a loop of a walk in place, in leg lengths. Such a loop is shorter than the window.
const STAYS_IN_LOOP: f32 = 0.15;

/// The least speed of the belt of a treadmill, in m/s. This speed is the median speed of the lower foot, backwards or
/// forwards, in the window. The feet of a person who dances on the spot are at rest.
const BELT: f32 = 0.25;

pub(super) fn find(motion: &Motion, body: &Body, findings: &mut Findings<'_>) {
    findings.look_for(&[Skate, UnderFloor, FootThroughFloor, Treadmill]);
    let belt = treadmill(motion, body, findings);
    let points = &body.contacts.points;
    let has_balls = points.iter().any(is_ball);
    for point in points.iter().filter(|point| is_ball(point) == has_balls) {
        slides(motion, body, point, &belt, findings);
    }
    glides(motion, body, &belt, findings);
    for point in points {
        sinks(motion, body, point, findings);
    }
}

/// Finds spans in which a point of a foot is below the floor: the whole body has sunk, or the other foot is on the
/// floor.
fn sinks(motion: &Motion, body: &Body, point: &ContactPoint, findings: &mut Findings<'_>) {
    let height = |frame: usize| point.above_rest.get(frame).copied().unwrap_or(0.0);
    let depth = |frame: usize| -height(frame);
    let contacts: Vec<([usize; 2], f32)> = point
        .intervals()
        .into_iter()
        .filter_map(|[from, to]| Some(([from, to], median(&mut (from..=to).map(height).collect::<Vec<_>>())?)))
        .collect();
    // Both feet and all contacts share one floor level. `own` is the height of this foot above that level, in the
    // contacts before and after the span.
    let own = |[from, to]: [usize; 2]| {
        let before = contacts.iter().rfind(|(at, _)| at[1] < from);
        let after = contacts.iter().find(|(at, _)| at[0] > to);
        let both = before.zip(after).map(|(before, after)| before.1.min(after.1));
        both.unwrap_or(0.0).clamp(0.0, OWN_LEVEL)
    };
    let others = body.contacts.points.iter();
    let others: Vec<&ContactPoint> = others.filter(|other| other.bone.side() != point.bone.side()).collect();
    let stands = |frame: &usize| {
        let is_on = |other: &&ContactPoint| {
            let height = other.above_rest.get(*frame).copied().unwrap_or(f32::INFINITY);
            height.abs() < BELOW && other.at_rest.get(*frame) == Some(&true)
        };
        others.iter().any(is_on)
    };
    let sunk = spans(motion.frames, |frame| frame >= motion.starts && depth(frame) > BELOW);
    for [from, to] in joined(sunk, motion.frames_in(A_STEP)) {
        let deepest = (from..=to).map(depth).fold(0.0, f32::max) + own([from, to]);
        let deepest = 100.0 * deepest * (1.0 - ramp(deepest / body.leg, ANOTHER_FLOOR[0], ANOTHER_FLOOR[1]));
        let on_other = (from..=to).filter(stands).count();
        let kind = match 2 * on_other > to + 1 - from {
            true => FootThroughFloor,
            false => UnderFloor,
        };
        findings.add(kind, [from, to], Some(&point.name), deepest, confidence(deepest, 5.0));
    }
}

/// Joins spans that are at most `apart` frames apart.
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

/// Measures foot sliding in each contact of a point. The point of the foot that moves least counts, because a foot that
/// pivots on its heel or ball does not slide.
fn slides(motion: &Motion, body: &Body, point: &ContactPoint, belt: &[bool], findings: &mut Findings<'_>) {
    let side = point.bone.side();
    let points = body.contacts.points.iter();
    let nodes: Vec<usize> = points
        .filter(|other| other.bone.side() == side)
        .map(|other| other.node.index())
        .collect();
    for [from, to] in point.intervals() {
        let (from, to) = (from.max(motion.starts), to.min(motion.frames - 1));
        if from > to || belt[from..=to].contains(&true) {
            continue;
        }
        let slide = |node: &usize| {
            let at = |frame: usize| motion.at(frame, *node).with_y(0.0);
            (from..=to)
                .map(|frame| at(frame).distance(at(from)))
                .fold(0.0, f32::max)
        };
        let hips = (from..=to).map(|frame| motion.at(frame, body.hips()).y - body.contacts.floor);
        let stands = ramp(hips.fold(0.0, f32::max) / body.leg, STANDS[0], STANDS[1]);
        let centimetres = 100.0 * stands * nodes.iter().map(slide).fold(f32::INFINITY, f32::min);
        findings.add(
            Skate,
            [from, to],
            Some(&point.name),
            centimetres,
            confidence(centimetres, 9.0),
        );
    }
}

/// Finds spans in which feet are on the floor and carry the body, but no foot is at rest.
fn glides(motion: &Motion, body: &Body, belt: &[bool], findings: &mut Findings<'_>) {
    let (half, around) = (motion.frames_in(0.03), motion.frames_in(0.06));
    // The speed of the slowest point, and the degree to which the points are on the floor. A point that is hardly on
    // the floor counts as fast.
    let slowest = |frame: usize| {
        let low = |point: &ContactPoint| {
            let height = point.above_rest.get(frame).copied().unwrap_or(f32::INFINITY);
            1.0 - ramp(height, LOW[0], LOW[1])
        };
        let points = body.contacts.points.iter().map(|point| (low(point), point));
        let points = points.filter(|(low, _)| *low > 0.0);
        let speed = |point: &ContactPoint| motion.velocity(frame, point.node.index(), half).with_y(0.0).length();
        let points = points.map(|(low, point)| (speed(point) / low, low, point));
        let most = points.clone().map(|(_, low, _)| low).fold(0.0, f32::max);
        let slowest = points.min_by(|a, b| a.0.total_cmp(&b.0));
        slowest.map(|(speed, _, point)| (speed * most * most, point))
    };
    // In a fast walk the hips also fall this fast, but a foot stays on the floor. In flight, the feet rise and fall.
    let stays_on = |point: &ContactPoint, frame: usize| {
        let height = point.above_rest.get(frame).copied().unwrap_or(f32::INFINITY).abs();
        let rises = motion.velocity(frame, point.node.index(), half).y.abs();
        (1.0 - ramp(height, LEVEL[0], LEVEL[1])) * (1.0 - ramp(rises, RISES[0], RISES[1]))
    };
    let speed = |frame: usize| {
        if frame < motion.starts || belt[frame] {
            return 0.0;
        }
        let (speed, point) = slowest(frame).unzip();
        let speed = speed.unwrap_or(0.0);
        let carried = ramp(motion.rise(frame, body.hips(), around), FALLS[0], FALLS[1]);
        let carried = carried.max(point.map_or(0.0, |point| stays_on(point, frame)));
        speed * ramp(speed, GLIDES[0], GLIDES[1]) * carried
    };
    let speeds: Vec<f32> = (0..motion.frames).map(speed).collect();
    for [from, to] in spans(motion.frames, |frame| speeds[frame] > 0.0) {
        let seconds = (to + 1 - from) as f32 / motion.rate as f32;
        let path = 100.0 * speeds[from..=to].iter().sum::<f32>() / motion.rate as f32;
        let path = path * ramp(seconds, GLIDES_FOR[0], GLIDES_FOR[1]);
        let joint = slowest((from + to) / 2).map(|(_, point)| point.name.as_str());
        findings.add(Skate, [from, to], joint, path, confidence(path, 9.0));
    }
}

/// Finds windows in which the feet step past each other while the hips stay in place. Returns whether each frame is in
/// such a window.
fn treadmill(motion: &Motion, body: &Body, findings: &mut Findings<'_>) -> Vec<bool> {
    let feet = [Bone::LeftFoot, Bone::RightFoot].map(|bone| body.bones.get(&bone).copied());
    let mut walks = vec![false; motion.frames];
    let [Some(left), Some(right)] = feet else { return walks };
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
    // A loop of one or two steps is shorter than the window. Its feet pass each other once.
    let frames = motion.frames - motion.starts;
    let (window, half) = (motion.frames_in(WINDOW).min(frames), STEP * body.leg / 2.0);
    let is_loop = window == frames && motion.seconds() < WINDOW;
    let (least, stays) = if is_loop { (1, STAYS_IN_LOOP) } else { (2, STAYS) };
    let mut start = motion.starts;
    while start + window <= motion.frames {
        let part = start..start + window;
        // A step: one foot is half a step ahead, and then the other foot.
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
        if passes >= least && path < stays * body.leg && belt.abs() > BELT {
            walks[part].fill(true);
        }
        start += motion.frames_in(0.25);
    }
    for [from, to] in spans(motion.frames, |frame| walks[frame]) {
        let seconds = (to + 1 - from) as f64 / motion.rate;
        findings.add(Treadmill, [from, to], None, seconds as f32, 0.8);
    }
    walks
}
