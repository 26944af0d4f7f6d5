//! Frames in which nothing moves, joints that hold one pose, and T-poses within the motion.

use std::ops::Range;

use glam::{Quat, Vec3};
use mocap_scene::math::median::median;
use mocap_scene::scene::{HumanoidBone as Bone, Side};

use super::Findings;
use crate::survey::motion::{Body, Motion};
use crate::survey::spans;
use crate::survey::thresholds::DefectKind::{Frozen, Gap, HeldEnd, TPose, TPoseEnd};

/// The largest change of rotation per frame of a joint that does not move, as a difference of quaternions: 0.005
/// degrees.
const STILL_ROTATION: f32 = 4e-5;
/// The shortest gap, in seconds. A gap is a span in which a joint holds its rotation while the body moves.
const SHORTEST_GAP: f64 = 0.4;

/// The least jump of the joint at an end of a gap, as a multiple of its median change per frame. A solver with few
/// sensors holds joints at the end of their range. Such a joint begins to move without a jump, and has no gap.
const JUMPS: f32 = 3.0;

/// The least jump at an end of a gap, in radians: 1 degree, which is visible.
const JUMPS_BY: f32 = 0.0175;
/// A joint with a gap must move in at least this fraction of the moving frames outside of the gap.
const MOVES: f32 = 0.6;

/// The cosine of the largest angle of the arms from the horizontal in a T-pose: 15 degrees.
const ARM: f32 = 0.966;

/// The cosine of the largest angle of the legs from the vertical in a T-pose: 25 degrees. The legs of CMU's T-pose are
/// at 20 degrees.
const LEG: f32 = 0.906;

/// The cosine of the largest angle of the trunk from the vertical in a T-pose: 18 degrees.
const TRUNK: f32 = 0.951;

/// The cosine of the largest angle of the arms from the horizontal in a calibration pose: 30 degrees.
const HELD_ARM: f32 = 0.866;

/// The speed below which hands hold a calibration pose, in m/s.
const HELD_SPEED: f32 = 0.1;

/// The shortest calibration pose, in seconds. Shorter poses are part of a movement.
const HELD: f64 = 0.5;

/// A T-pose counts as the beginning or the end of a clip within this time, in seconds. A person who is told to take a
/// T-pose needs a short time.
const BEGINS: f64 = 0.25;

/// The speed of a hand relative to the hips, from one frame to the next, above which a body snaps into a T-pose, in
/// m/s. A person lifts the arms at 2 m/s, and a punch reaches 10 m/s.
const SNAPS: f32 = 12.0;

pub(super) fn find(motion: &Motion, findings: &mut Findings<'_>) {
    findings.look_for(&[Frozen, HeldEnd, Gap]);
    let steps = motion.frames - 1;
    let still: Vec<bool> = (0..steps).map(|step| motion.held[step + 1]).collect();
    for [from, to] in spans(steps, |step| still[step]) {
        let seconds = (to + 1 - from) as f64 / motion.rate;
        let is_end = from <= motion.starts || to + 1 == steps;
        let kind = if is_end { HeldEnd } else { Frozen };
        findings.add(kind, [from, to + 1], None, seconds as f32, 1.0);
    }
    gaps(motion, &still, findings);
}

/// Finds joints that hold one rotation while other joints move. Gaps at the same time are one finding, which names the
/// first joint.
fn gaps(motion: &Motion, still: &[bool], findings: &mut Findings<'_>) {
    let moving = still.iter().filter(|still| !**still).count();
    let least = motion.frames_in(SHORTEST_GAP);
    let mut found: Vec<([usize; 2], &str)> = Vec::new();
    for node in (0..motion.nodes()).filter(|node| motion.is_joint[*node]) {
        let step = |step: usize| difference(motion.rotations(step)[node], motion.rotations(step + 1)[node]);
        let holds: Vec<bool> = (0..still.len()).map(|at| step(at) < STILL_ROTATION).collect();
        let moves = holds.iter().filter(|holds| !**holds).count();
        // Frames in which the whole body is still are no gap of a single joint.
        let mut gaps = spans(still.len(), |at| holds[at] && !still[at] && at >= motion.starts);
        gaps.retain(|[from, to]| to + 1 - from >= least);
        let missing: usize = gaps.iter().map(|[from, to]| to + 1 - from).sum();
        if (moves as f32) < MOVES * moving.saturating_sub(missing) as f32 || 5 * moves < moving {
            continue;
        }
        let mut steps: Vec<f32> = (0..still.len()).filter(|at| !holds[*at]).map(step).collect();
        // A difference of quaternions is half the angle.
        let least = (JUMPS * median(&mut steps).unwrap_or(0.0)).max(JUMPS_BY / 2.0);
        let jumps = |at: Option<usize>| at.is_some_and(|at| at < still.len() && step(at) > least);
        gaps.retain(|[from, to]| jumps(from.checked_sub(1)) || jumps(Some(to + 1)));
        for span in gaps {
            let near = |other: &[usize; 2]| other[0].abs_diff(span[0]) <= 2 && other[1].abs_diff(span[1] + 1) <= 2;
            if !found.iter().any(|(other, _)| near(other)) {
                found.push(([span[0], span[1] + 1], &motion.names[node]));
            }
        }
    }
    for (frames, joint) in found {
        let seconds = (frames[1] - frames[0]) as f64 / motion.rate;
        findings.add(Gap, frames, Some(joint), seconds as f32, 0.8);
    }
}

fn difference(a: Quat, b: Quat) -> f32 {
    let (minus, plus) = (a - b, a + b);
    minus.length().min(plus.length())
}

/// Finds T-poses at the beginning and the end of a clip, and T-poses within the motion.
pub(super) fn find_t_pose(motion: &Motion, body: &Body, findings: &mut Findings<'_>) {
    findings.look_for(&[TPose, TPoseEnd]);
    for [from, to] in t_poses(motion, body) {
        let seconds = (to + 1 - from) as f64 / motion.rate;
        let is_end = begins(motion, body, from) || ends(motion, body, to);
        let kind = if is_end { TPoseEnd } else { TPose };
        findings.add(kind, [from, to], None, seconds as f32, 0.9);
    }
}

/// The frames in which defects are searched: after rest poses and a T-pose at the beginning of the clip, and before a
/// T-pose at its end.
pub(in crate::survey) fn searched(motion: &Motion) -> Range<usize> {
    let Some(body) = &motion.body else {
        return motion.first..motion.frames;
    };
    let t_poses = t_poses(motion, body);
    let first = t_poses.first().copied();
    let after = first.filter(|[from, to]| begins(motion, body, *from) && to + 1 < motion.frames);
    let starts = after.map_or(motion.first, |[_, to]| motion.first.max(to + 1));
    let last = t_poses.last().copied();
    let before = last.filter(|[from, to]| ends(motion, body, *to) && *from > starts);
    starts..before.map_or(motion.frames, |[from, _]| from)
}

/// Whether a T-pose at `frame` is at the beginning of the clip. A T-pose into which the body snaps counts as within the
/// motion.
fn begins(motion: &Motion, body: &Body, frame: usize) -> bool {
    let is_early = frame < motion.first + motion.frames_in(BEGINS);
    is_early && (frame <= motion.first || !snaps(motion, body, frame))
}

/// Whether a T-pose with the last frame `frame` is at the end of the clip. A T-pose out of which the body snaps counts
/// as within the motion.
fn ends(motion: &Motion, body: &Body, frame: usize) -> bool {
    let is_late = frame + motion.frames_in(BEGINS) >= motion.frames;
    is_late && (frame + 1 >= motion.frames || !snaps(motion, body, frame + 1))
}

/// Whether a hand has moved since the previous frame faster than a human can.
fn snaps(motion: &Motion, body: &Body, frame: usize) -> bool {
    let from_hips = |frame: usize, hand: usize| motion.at(frame, hand) - motion.at(frame, body.hips());
    let hands = [Bone::LeftHand, Bone::RightHand];
    let mut nodes = hands.iter().filter_map(|hand| body.bones.get(hand));
    nodes.any(|hand| {
        let step = from_hips(frame, *hand).distance(from_hips(frame - 1, *hand));
        step * motion.rate as f32 > SNAPS
    })
}

/// The spans of T-poses: arms point sideways and legs down.
fn t_poses(motion: &Motion, body: &Body) -> Vec<[usize; 2]> {
    let mut is_t_pose: Vec<bool> = (0..motion.frames)
        .map(|frame| self::is_t_pose(motion, body, frame))
        .collect();
    let around = motion.frames_in(0.1);
    let rests = |frame: usize, hand: Bone| {
        let node = body.bones.get(&hand);
        node.is_some_and(|node| motion.velocity(frame, *node, around).length() < HELD_SPEED)
    };
    let is_held = |frame: usize| {
        has_arms_out(motion, body, frame, HELD_ARM)
            && [Bone::LeftHand, Bone::RightHand]
                .into_iter()
                .all(|hand| rests(frame, hand))
    };
    for [from, to] in spans(motion.frames, |frame| frame >= motion.first && is_held(frame)) {
        if (to + 1 - from) as f64 / motion.rate >= HELD {
            is_t_pose[from..=to].fill(true);
        }
    }
    spans(motion.frames, |frame| is_t_pose[frame])
}

/// Whether a frame is a T-pose.
pub(in crate::survey) fn is_t_pose(motion: &Motion, body: &Body, frame: usize) -> bool {
    has_arms_out(motion, body, frame, ARM)
}

/// Whether arms point sideways, up to an angle whose cosine is `arm`, and legs down.
fn has_arms_out(motion: &Motion, body: &Body, frame: usize, arm: f32) -> bool {
    let between = |from, to| {
        let (from, to) = (motion.bone(body, frame, from)?, motion.bone(body, frame, to)?);
        Some((to - from).normalize_or_zero())
    };
    let left = Vec3::Y.cross(body.forward(motion, frame));
    let points = |side: Side| {
        let along = if side == Side::Left { left } else { -left };
        let on = |bone: Bone| bone.on(side);
        // In few frames an arm points sideways, so the other limbs are rarely checked.
        Some(
            between(on(Bone::LeftUpperArm), on(Bone::LeftLowerArm))?.dot(along) > arm
                && between(on(Bone::LeftLowerArm), on(Bone::LeftHand))?.dot(along) > arm
                && -between(on(Bone::LeftUpperLeg), on(Bone::LeftLowerLeg))?.y > LEG
                && -between(on(Bone::LeftLowerLeg), on(Bone::LeftFoot))?.y > LEG,
        )
    };
    let mut sides = Side::ALL.into_iter().map(points);
    sides.all(|points| points == Some(true)) && body.trunk(motion, frame).y > TRUNK
}
