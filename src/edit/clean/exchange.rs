//! Repairs frames in which a pose estimator mistook the left limb for the right limb: exchanges the rotations of both
//! limbs.
//!
//! In each frame, a pair of limbs is exchanged or not. Viterbi's algorithm finds the sequence of these two states whose
//! rotation steps change least. A switch between the states costs as much as a large change of rotation, so limbs that
//! cross quickly are not exchanged.

use glam::{Quat, Vec3};
use mocap_scene::math::median::ranked;
use mocap_scene::math::quaternion::{log, squared_angle};
use mocap_scene::scene::{HumanoidBone as Bone, Side};

use crate::work::Work;

/// The limbs, each with its bones.
const LIMBS: [&[Bone]; 2] = [
    &[Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot, Bone::LeftToes],
    &[Bone::LeftUpperArm, Bone::LeftLowerArm, Bone::LeftHand],
];
/// The longest exchange that is repaired, in seconds.
const LONGEST: f64 = 2.0;
/// The largest change of a joint's rotation step that counts, in degrees. A larger change comes from a flip and is no
/// evidence of an exchange.
const MOST_OF_JOINT: f32 = 60.0;
/// The largest difference between the rest rotations of two joints, in degrees. If the difference is larger, a rotation
/// of one joint gives another pose when it is applied to the other joint.
const ALIKE: f32 = 20.0;

/// Exchanges limbs back. Returns the number of repaired runs.
pub(super) fn mend(work: &mut Work<'_>) -> usize {
    let mut runs = 0;
    for (pairs, is_exchanged, found) in find(work) {
        runs += found;
        for [left, right] in pairs {
            let mut tracks = [left, right].map(|column| rotations(work, column));
            let [lefts, rights] = &mut tracks;
            for frame in (0..is_exchanged.len()).filter(|frame| is_exchanged[*frame]) {
                std::mem::swap(&mut lefts[frame], &mut rights[frame]);
            }
            work.frames.set_rotations(left, &tracks[0]);
            work.frames.set_rotations(right, &tracks[1]);
        }
    }
    runs
}

/// For each frame, whether any limbs are exchanged. Empty if none ever are.
pub(super) fn frames(work: &Work<'_>) -> Vec<bool> {
    let either = |mut all: Vec<bool>, (_, limb, _): (_, Vec<bool>, _)| {
        all.resize(limb.len(), false);
        all.iter_mut().zip(limb).for_each(|(all, limb)| *all |= limb);
        all
    };
    find(work).into_iter().fold(Vec::new(), either)
}

/// For each exchanged pair of limbs: the pairs of joints, whether each frame is exchanged, and the number of runs of
/// exchanged frames.
fn find(work: &Work<'_>) -> Vec<(Vec<[usize; 2]>, Vec<bool>, usize)> {
    let mut found = Vec::new();
    for limb in LIMBS {
        let joint = |bone: &Bone, side: Side| {
            let node = work.figure.humanoid.joint(bone.on(side))?;
            work.frames.nodes().binary_search(&node).ok()
        };
        let pairs = limb
            .iter()
            .filter_map(|bone| Some([joint(bone, Side::Left)?, joint(bone, Side::Right)?]));
        let pairs: Vec<[usize; 2]> = pairs.collect();
        if pairs.len() > 1 && pairs.iter().all(|pair| are_alike(work, *pair)) {
            let mut is_exchanged = of_limb(work, &pairs);
            let runs = without_long(&mut is_exchanged, work.frames.frames_in(LONGEST));
            if runs > 0 {
                found.push((pairs, is_exchanged, runs));
            }
        }
    }
    found
}

fn rotations(work: &Work<'_>, column: usize) -> Vec<Quat> {
    work.frames.rotations(column).collect()
}

/// Whether the rest rotations of two joints are so similar that a rotation gives the same pose for both joints.
fn are_alike(work: &Work<'_>, pair: [usize; 2]) -> bool {
    let [left, right] = pair.map(|column| {
        let node = work.frames.nodes()[column];
        Quat::from_mat4(&work.scene.nodes[node.index()].transform)
    });
    squared_angle(left.to_array(), right.to_array()) < ALIKE.to_radians().powi(2)
}

/// For each frame, whether the two limbs with these pairs of joints are exchanged.
fn of_limb(work: &Work<'_>, pairs: &[[usize; 2]]) -> Vec<bool> {
    let frames = work.frames.len();
    let mut steps = vec![[0.0_f32; 2]; frames.saturating_sub(1)];
    for pair in pairs {
        add_steps(&pair.map(|column| rotations(work, column)), &mut steps);
    }
    steps.iter_mut().flatten().for_each(|square| *square = square.sqrt());
    let mut usual: Vec<f32> = steps.iter().map(|step| step[0]).collect();
    let middle = usual.len().saturating_sub(1) / 2;
    let Some(median) = ranked(&mut usual, middle) else {
        return vec![false; frames];
    };
    let cost = (work.weights.exchange as f32).to_radians() + median;
    // The smallest cost of each state (as recorded, exchanged), and the previous state on the way to it.
    let mut costs = [0.0, cost];
    let mut from: Vec<[bool; 2]> = Vec::with_capacity(frames);
    for step in &steps {
        let stay = [costs[0] + step[0], costs[1] + step[0]];
        let change = [costs[1] + step[1] + cost, costs[0] + step[1] + cost];
        from.push([change[0] < stay[0], change[1] < stay[1]]);
        costs = [stay[0].min(change[0]), stay[1].min(change[1])];
    }
    let mut is_exchanged = vec![false; frames];
    let mut state = costs[1] + cost < costs[0];
    for frame in (0..frames).rev() {
        is_exchanged[frame] = state;
        if frame > 0 {
            state ^= from[frame - 1][usize::from(state)];
        }
    }
    is_exchanged
}

/// Adds the squared change at each frame to `steps`, without and with an exchange. A step is the rotation from one
/// frame to the next. The change is the difference between a step and the mean of the steps before and after it. So a
/// fast movement with even steps costs no more than a slow movement.
fn add_steps(tracks: &[Vec<Quat>; 2], steps: &mut [[f32; 2]]) {
    let step = |from: Quat, to: Quat| log(from.inverse() * to);
    let own = [0, 1].map(|side: usize| -> Vec<Vec3> {
        let pairs = tracks[side].windows(2);
        pairs.map(|pair| step(pair[0], pair[1])).collect()
    });
    let most = MOST_OF_JOINT.to_radians().powi(2);
    for (index, sums) in steps.iter_mut().enumerate() {
        for from in [0, 1] {
            for (sum, to) in sums.iter_mut().zip([from, 1 - from]) {
                let beside = [
                    index.checked_sub(1).map(|before| own[from][before]),
                    own[to].get(index + 1).copied(),
                ];
                let count = beside.iter().flatten().count().max(1) as f32;
                let expected = beside.into_iter().flatten().sum::<Vec3>() / count;
                let step = match from == to {
                    true => own[from][index],
                    false => step(tracks[from][index], tracks[to][index + 1]),
                };
                *sum += (step - expected).length_squared().min(most);
            }
        }
    }
}

/// Clears each run of more than `longest` marked frames. Returns the number of the remaining runs.
fn without_long(marked: &mut [bool], longest: usize) -> usize {
    let (mut runs, mut frame) = (0, 0);
    while frame < marked.len() {
        let end = (frame..marked.len()).find(|f| !marked[*f]).unwrap_or(marked.len());
        if end - frame > longest {
            marked[frame..end].fill(false);
        } else if end > frame {
            runs += 1;
        }
        frame = end + 1;
    }
    runs
}
