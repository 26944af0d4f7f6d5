//! Steadies the rotations of standing feet in a noisy motion. The foot lock stops only one point of a foot. Noise in
//! the rotations of the foot would still swing its other points about this point.

use std::ops::Range;

use glam::{Quat, Vec3};
use mocap_figure::contacts::ball;
use mocap_scene::math::directions::rotation_of;
use mocap_scene::math::quaternion;
use mocap_scene::pose::Pose;
use mocap_scene::scene::{HumanoidBone as Bone, NodeId, Side};

use crate::contacts::{ContactPoint, DetectedContacts};
use crate::frames::Frames;
use crate::lock::shift;
use crate::work::Work;

/// The time over which the rotation of a standing foot is averaged to either side, in seconds. It is as long as a
/// footstep. So a foot does not turn within a footstep, but a person who stands may still shift the weight.
const OVER: f64 = 0.6;

/// The seconds that a foot takes to reach its steady rotation, and again to leave it. A heel lifts in about 0.2 s.
const BLEND: f64 = 0.15;

/// The time over which noise is averaged before a foot is seen to roll, in seconds.
const SEEN_OVER: f64 = 0.07;

/// If the rotation of a foot differs from its mean by more than this angle in radians (6 degrees), the foot does not
/// stand flat: it lands, lifts or pivots. Smoothed noise is smaller, and a lifting heel turns so far within two frames.
const ROLLED: f32 = 0.105;

/// Turns the joints from the ankle to the ball of each foot to their mean rotations over the frames in which it stands
/// flat.
pub(super) fn steady(work: &Work<'_>, contacts: &DetectedContacts, frames: &mut Frames<'_>) {
    for side in Side::ALL {
        let (bones, foot) = (&work.figure.humanoid, Bone::LeftFoot.on(side));
        if let (Some(ankle), Some(ball), Some(point)) =
            (bones.joint(foot), ball(work.scene, bones, side), contacts.point(foot))
        {
            let above = std::iter::successors(Some(ball), |node| work.scene.nodes[node.index()].parent);
            let mut joints: Vec<NodeId> = above.skip(1).take_while(|node| *node != ankle).collect();
            joints.push(ankle);
            joints.reverse();
            steady_foot(work, &joints, point, frames);
        }
    }
}

/// Steadies the joints of a foot, parents first, where `ankle` rests.
fn steady_foot(work: &Work<'_>, joints: &[NodeId], ankle: &ContactPoint, frames: &mut Frames<'_>) {
    joints.iter().for_each(|joint| frames.hold(work.scene, *joint));
    let mut pose = Pose::rest(work.scene);
    let mut rotations: Vec<Vec<Quat>> = vec![Vec::with_capacity(frames.len()); joints.len()];
    for frame in 0..frames.len() {
        frames.pose(frame, &mut pose);
        for (rotations, joint) in rotations.iter_mut().zip(joints) {
            rotations.push(rotation_of(&pose.node_to_world[joint.index()]));
        }
    }
    let [over, noise, blend] = [OVER, SEEN_OVER, BLEND].map(|seconds| frames.frames_in(seconds));
    // The last of the joints has the rotation of the whole foot.
    let runs = rotations
        .last()
        .map_or(Vec::new(), |foot| flat_runs(foot, ankle, [over, noise]));
    let mut turns: Vec<Vec<Vec3>> = Vec::new();
    let mut carried = vec![Quat::IDENTITY; frames.len()];
    for mut own in rotations {
        // A joint turns with the joints above it.
        own.iter_mut()
            .zip(&carried)
            .for_each(|(own, carried)| *own = *carried * *own);
        let mut known: Vec<Option<Vec3>> = vec![None; own.len()];
        for run in &runs {
            for frame in run.clone() {
                let steady = mean(&own[run.clone()], frame - run.start, over);
                known[frame] = Some(quaternion::log(steady * own[frame].inverse()));
            }
        }
        let turn = shift::complete(&known, blend);
        carried
            .iter_mut()
            .zip(&turn)
            .for_each(|(carried, turn)| *carried = quaternion::exp(*turn) * *carried);
        turns.push(turn);
    }
    for frame in 0..frames.len() {
        if turns.iter().any(|turn| turn[frame] != Vec3::ZERO) {
            frames.pose(frame, &mut pose);
            for (joint, turn) in joints.iter().zip(&turns) {
                pose.rotate(*joint, quaternion::exp(turn[frame]));
                frames.set_rotation_of(frame, *joint, &pose);
            }
        }
    }
}

/// The runs of frames in which a foot with these rotations stands flat: its ankle rests, and it does not roll. `over`
/// has the widths of two averages in frames: of the steady rotation of a standing foot, and of the rotation without
/// noise.
fn flat_runs(rotations: &[Quat], ankle: &ContactPoint, over: [usize; 2]) -> Vec<Range<usize>> {
    let rests = ankle.intervals().into_iter();
    let mut runs: Vec<Range<usize>> = rests.map(|[first, last]| first..last + 1).collect();
    let mut flat = Vec::new();
    while let Some(run) = runs.pop() {
        let held = &rotations[run.clone()];
        let off = |index| {
            let [steady, seen] = over.map(|over| mean(held, index, over));
            steady.angle_between(seen)
        };
        let off: Vec<f32> = (0..run.len()).map(off).collect();
        let Some((rolls, most)) = off.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)) else {
            continue;
        };
        if *most <= ROLLED {
            flat.push(run);
            continue;
        }
        // A foot that lands or lifts shifts the mean, so half of such frames are removed before the next look.
        let before = off[..rolls].iter().rev().take_while(|off| **off > ROLLED).count();
        let after = off[rolls + 1..].iter().take_while(|off| **off > ROLLED).count();
        let half = (before + after + 2) / 2;
        if before == rolls {
            runs.push(run.start + half..run.end);
        } else if rolls + 1 + after == run.len() {
            runs.push(run.start..run.end - half);
        } else {
            runs.extend([run.start..run.start + rolls, run.start + rolls + 1..run.end]);
        }
    }
    flat
}

/// The mean of the rotations within `radius` frames of `frame`.
fn mean(rotations: &[Quat], frame: usize, radius: usize) -> Quat {
    let around = frame.saturating_sub(radius)..(frame + radius + 1).min(rotations.len());
    quaternion::mean(&rotations[around]).unwrap_or(rotations[frame])
}
