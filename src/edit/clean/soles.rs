//! Steadies the feet of a noisy motion where they stand. The lock of a foot stops one point, so noise in the rotations
//! of the foot would still swing its other points about this one.

use std::ops::Range;

use glam::{Quat, Vec3, Vec4};
use mocap_figure::contacts::ball;
use mocap_scene::math::quaternion::in_hemisphere_of;
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::{HumanoidBone as Bone, NodeId, Side};

use crate::contacts::DetectedContacts;
use crate::frames::Frames;
use crate::lock::shift;
use crate::work::Work;

/// The time over which the rotation of a standing foot is averaged to either side, in seconds. It is as long as a step,
/// so a foot does not turn in a step, but somebody who stands may shift the weight.
const OVER: f64 = 0.6;

/// The time in which a foot reaches its steady rotation and leaves it, in seconds. A heel lifts in about 0.2 s.
const BLEND: f64 = 0.15;

/// The time over which noise is averaged before a foot is seen to roll, in seconds.
const SEEN_OVER: f64 = 0.07;

/// The angle in radians from the mean rotation at which a foot lands, lifts or pivots, and does not stand: 6 degrees.
/// That is more than noise leaves, and a lifting heel has turned so far within two frames.
const ROLLED: f32 = 0.105;

/// Turns the joints from the ankle to the ball of each foot to their mean rotations over the frames in which it stands
/// flat.
pub(super) fn steady(work: &Work<'_>, contacts: &DetectedContacts, frames: &mut Frames<'_>) {
    for side in Side::ALL {
        let (bones, foot) = (&work.figure.humanoid, Bone::LeftFoot.on(side));
        let (Some(ankle), Some(ball), Some(point)) =
            (bones.joint(foot), ball(work.scene, bones, side), contacts.point(foot))
        else {
            continue;
        };
        let above = std::iter::successors(Some(ball), |node| work.scene.nodes[node.index()].parent);
        let mut chain: Vec<NodeId> = above.skip(1).take_while(|node| *node != ankle).collect();
        chain.push(ankle);
        // The last of these joints has the rotation of the whole foot.
        let runs = steady_runs(&rotations(work, frames, chain[0]), &point.at_rest, frames);
        for joint in chain.into_iter().rev() {
            steady_joint(work, joint, &runs, frames);
        }
    }
}

/// The rotations of a joint in the world, in every frame.
fn rotations(work: &Work<'_>, frames: &Frames<'_>, joint: NodeId) -> Vec<Quat> {
    let mut pose = Pose::rest(work.scene);
    let mut last = Quat::IDENTITY;
    let of_frame = |frame| {
        frames.pose(frame, &mut pose);
        last = in_hemisphere_of(last, Trs::from_matrix(pose.node_to_world[joint.index()]).rotation);
        last
    };
    (0..frames.len()).map(of_frame).collect()
}

/// The runs of frames in which a joint with these rotations `stands` and does not roll.
fn steady_runs(rotations: &[Quat], stands: &[bool], frames: &Frames<'_>) -> Vec<Range<usize>> {
    let [over, noise] = [OVER, SEEN_OVER].map(|seconds| frames.frames_in(seconds));
    let mut runs = Vec::new();
    let mut first = 0;
    for run in stands.chunk_by(|a, b| a == b) {
        if run[0] {
            runs.push(first..first + run.len());
        }
        first += run.len();
    }
    let mut steady = Vec::new();
    while let Some(run) = runs.pop() {
        let held = &rotations[run.clone()];
        let off = |index| mean(held, index, over).angle_between(mean(held, index, noise));
        let off: Vec<f32> = (0..run.len()).map(off).collect();
        let Some((rolls, most)) = off.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)) else {
            continue;
        };
        if *most <= ROLLED {
            steady.push(run);
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
    steady
}

/// Gives a joint its mean rotation in the world in each of `runs`.
fn steady_joint(work: &Work<'_>, joint: NodeId, runs: &[Range<usize>], frames: &mut Frames<'_>) {
    let over = frames.frames_in(OVER);
    frames.hold(work.scene, joint);
    let rotations = rotations(work, frames, joint);
    let mut known: Vec<Option<Vec3>> = vec![None; frames.len()];
    for run in runs {
        let held = &rotations[run.clone()];
        for (index, frame) in run.clone().enumerate() {
            known[frame] = Some((mean(held, index, over) * held[index].inverse()).to_scaled_axis());
        }
    }
    let mut pose = Pose::rest(work.scene);
    for (frame, turn) in shift::complete(&known, frames.frames_in(BLEND)).into_iter().enumerate() {
        if turn != Vec3::ZERO {
            frames.pose(frame, &mut pose);
            pose.rotate(joint, Quat::from_scaled_axis(turn));
            frames.set_rotation_of(frame, joint, &pose);
        }
    }
}

/// The mean of the rotations within `radius` frames of `frame`.
fn mean(rotations: &[Quat], frame: usize, radius: usize) -> Quat {
    let around = frame.saturating_sub(radius)..(frame + radius + 1).min(rotations.len());
    let sum: Vec4 = rotations[around].iter().map(|rotation| Vec4::from(*rotation)).sum();
    Quat::from_vec4(sum).normalize()
}
