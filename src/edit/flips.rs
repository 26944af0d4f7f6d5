//! Finds flips, where the rotation of a joint jumps away from the motion and back, and repairs them. Both `despike` and
//! `clean` use this detector.
//!
//! A jump is a step between two frames that is far larger than the steps around. Two jumps that undo each other bound a
//! run of frames. If the whole run is off by one rotation, such as a bone rolled by 180 degrees, the run is rotated
//! back and keeps its own motion. Any other short run is interpolated between its neighbours. If a jump is not undone
//! and is a rotation about the bone, [`twist`] spreads it over several frames.

use std::ops::Range;

use glam::{Quat, Vec3};
use mocap_scene::math::median::median;
use mocap_scene::math::quaternion::{in_hemisphere_of, log};
use mocap_scene::scene::{NodeId, Scene};

use super::frames::Frames;
use super::twist;

/// Frames on either side that show the usual size of a step.
const AROUND: usize = 15;
/// The least ratio of a jump to the median of the steps around it.
const JUMP: f32 = 5.0;
/// The largest ratio of the smaller neighbouring step to a jump. In a real movement it is larger, because speed builds
/// up over several frames.
const BESIDE: f32 = 0.45;
/// The smallest jump that is looked for, in degrees. Smaller jumps are spikes, which `despike` finds by its threshold.
const LEAST: f32 = 35.0;
/// The smallest rotation across unknown frames that may be a jump, in degrees. It is smaller, because exchanged limbs
/// are alike.
const LEAST_OVER: f32 = 20.0;

/// The longest run that is rotated back, in seconds. A longer run may be intended.
const LONGEST: f64 = 2.0;

/// The longest run that is interpolated, in seconds, because interpolation loses the run's own motion.
const LONGEST_REPLACED: f64 = 0.2;
/// The largest number of frames in a run. It keeps the running time linear in the frames.
const MOST_FRAMES: usize = 2000;
/// The largest difference between the rotations at both ends of a run, as a fraction of the smaller jump.
const AGREE: f32 = 0.4;
/// The largest difference in degrees between a jump and half a turn about the bone that counts as half a turn.
const HALF_TURN: f32 = 35.0;

/// The speed of a joint that no animal reaches, in degrees per second. Joints of galloping dogs reach 2000.
const FASTEST: f32 = 4500.0;

/// The repairs in one track.
#[derive(Clone, Default)]
pub(super) struct FlipOutcome {
    /// For each frame, whether it was changed. Empty if none was.
    pub(super) frames: Vec<bool>,
    /// The number of repaired runs.
    pub(super) runs: usize,
    /// The number of spread steps.
    pub(super) spread: usize,
}

impl FlipOutcome {
    fn mark(&mut self, frames: Range<usize>, count: usize) {
        self.frames.resize(count, false);
        self.frames[frames].fill(true);
    }
}

/// The repair of a run.
enum FlipRepair {
    /// Rotations are multiplied on the right: the joint rotates in its own frame.
    Right(Quat),
    /// Rotations are multiplied on the left: the joint rotates in the frame of its parent.
    Left(Quat),
    /// Rotations are interpolated between the neighbours of the run.
    Replace,
}

/// Repairs the flips of all tracks. Returns the repairs in each. For an animal, steps that are too fast for a joint are
/// spread over several frames.
pub(super) fn mend_all(scene: &Scene, frames: &mut Frames, is_animal: bool) -> Vec<FlipOutcome> {
    let mut all = vec![FlipOutcome::default(); frames.nodes().len()];
    for column in 0..all.len() {
        let mut track: Vec<_> = frames.rotations(column).collect();
        let bone = bone(scene, frames.nodes()[column]);
        let FlipOutcome {
            frames: changed, runs, ..
        } = mend(&mut track, bone, frames.rate);
        if runs > 0 {
            frames.set_rotations(column, &track);
            all[column].runs = runs;
            changed
                .iter()
                .enumerate()
                .filter(|(_, is_changed)| **is_changed)
                .for_each(|(frame, _)| {
                    all[column].mark(frame..frame + 1, changed.len());
                });
        }
        for frame in jumps(&track) {
            let (columns, within) = twist::spread(scene, frames, column, frame);
            all[column].spread += usize::from(!columns.is_empty());
            columns
                .into_iter()
                .for_each(|column| all[column].mark(within.clone(), frames.len()));
        }
        if !is_animal {
            continue;
        }
        let least = FASTEST.to_radians() / frames.rate as f32;
        for frame in 1..frames.len() {
            let [before, after] = [frame - 1, frame].map(|frame| frames.at(frame, column).rotation);
            if angle(before, after) > least {
                let within = twist::ease(frames, column, frame);
                all[column].spread += 1;
                all[column].mark(within, frames.len());
            }
        }
    }
    all
}

/// Repairs the flips of a track. `bone` is the direction of the bone in the frame of its joint, if it has one.
pub(super) fn mend(track: &mut [Quat], bone: Option<Vec3>, rate: f64) -> FlipOutcome {
    let mut mended = FlipOutcome::default();
    let jumps = jumps(track);
    let frames = |seconds: f64| ((seconds * rate).round() as usize).clamp(3, MOST_FRAMES);
    let (longest, longest_replaced) = (frames(LONGEST), frames(LONGEST_REPLACED));
    let mut after = 0;
    for (index, &first) in jumps.iter().enumerate() {
        if first < after {
            continue;
        }
        let ends = jumps[index + 1..].iter().take_while(|end| **end - first <= longest);
        let found = ends
            .copied()
            .find_map(|end| Some((end, run(track, first, end, bone, longest_replaced)?)));
        let Some((end, mend)) = found else { continue };
        apply(track, first, end, mend);
        mended.mark(first..end, track.len());
        mended.runs += 1;
        after = end + 1;
    }
    mended
}

/// The direction of a joint's bone in the joint's frame: towards the first child at another position.
fn bone(scene: &Scene, joint: NodeId) -> Option<Vec3> {
    let children = scene.nodes.iter().filter(|node| node.parent == Some(joint));
    children
        .map(|child| child.transform.w_axis.truncate())
        .find_map(Vec3::try_normalize)
}

/// The number of jumps in a track.
pub(super) fn count(track: &[Quat]) -> usize {
    jumps(track).len()
}

/// The number of jumps of a track at which the track `before` has no step of nearly the same size. A step that was a
/// little below [`LEAST`] before does not become a new jump.
pub(super) fn count_new(track: &[Quat], before: &[Quat]) -> usize {
    /// The fraction of a step that is nearly as large.
    const NEARLY: f32 = 0.8;
    let step = |track: &[Quat], to: usize| angle(track[to - 1], track[to]);
    let is_new = |to: &usize| to >= &before.len() || step(before, *to) < NEARLY * step(track, *to);
    jumps(track).iter().filter(|to| is_new(to)).count()
}

/// The frames to which a track jumps. Each is the first frame after a jump.
fn jumps(track: &[Quat]) -> Vec<usize> {
    let least = LEAST.to_radians();
    // The cosine of half of the angle is a faster test, and most tracks have no jump.
    let near = (0.5 * least).cos() + 1e-3;
    if track.windows(2).all(|pair| pair[0].dot(pair[1]).abs() > near) {
        return Vec::new();
    }
    jumps_of(
        &track.windows(2).map(|pair| angle(pair[0], pair[1])).collect::<Vec<_>>(),
        least,
    )
}

/// The frames to which a track jumps by `least` or more, from the sizes of its steps.
fn jumps_of(steps: &[f32], least: f32) -> Vec<usize> {
    let is_jump = |step: &usize| {
        let here = steps[*step];
        if here < least {
            return false;
        }
        let from = step.saturating_sub(AROUND);
        let mut around = steps[from..(step + AROUND + 1).min(steps.len())].to_vec();
        let usual = median(&mut around).unwrap_or(0.0);
        // A run of one frame has another jump on one side, so the smaller neighbour counts.
        let beside = |other: Option<usize>| other.and_then(|other| steps.get(other)).copied().unwrap_or(0.0);
        let smaller = beside(step.checked_sub(1)).min(beside(Some(step + 1)));
        here > JUMP * usual && smaller < BESIDE * here
    };
    (0..steps.len()).filter(is_jump).map(|step| step + 1).collect()
}

/// Interpolates runs of frames in which a position jumps away by `least` or more and comes back. Returns the number of
/// runs. In so short a time, no body can go there and back.
pub(super) fn mend_positions(track: &mut [Vec3], least: f32, rate: f64) -> usize {
    let steps: Vec<f32> = track.windows(2).map(|pair| pair[0].distance(pair[1])).collect();
    let jumps = jumps_of(&steps, least);
    let longest = ((LONGEST_REPLACED * rate).round() as usize).clamp(1, MOST_FRAMES);
    let (mut runs, mut after) = (0, 0);
    for (index, &first) in jumps.iter().enumerate() {
        let comes_back = |end: &&usize| {
            let smaller = steps[first - 1].min(steps[**end - 1]);
            track[first - 1].distance(track[**end]) < AGREE * smaller
        };
        let mut ends = jumps[index + 1..].iter().take_while(|end| **end - first <= longest);
        let Some(&end) = (first >= after).then(|| ends.find(comes_back)).flatten() else {
            continue;
        };
        let [from, to] = [first - 1, end].map(|frame| track[frame]);
        for (index, position) in track[first..end].iter_mut().enumerate() {
            *position = from.lerp(to, (index + 1) as f32 / (end + 1 - first) as f32);
        }
        runs += 1;
        after = end + 1;
    }
    runs
}

/// Whether a jump, rather than a motion, separates two frames with unknown frames between them.
pub(super) fn is_jump_over(track: &[Quat], from: usize, to: usize) -> bool {
    let turned = angle(track[from], track[to]);
    let around = from.saturating_sub(AROUND)..(to + AROUND).min(track.len() - 1);
    let mut steps: Vec<f32> = around.map(|frame| angle(track[frame], track[frame + 1])).collect();
    let usual = median(&mut steps).unwrap_or(0.0);
    turned > LEAST_OVER.to_radians() && turned > JUMP * usual * (to - from) as f32 * 0.5
}

fn angle(a: Quat, b: Quat) -> f32 {
    log(a.inverse() * b).length()
}

/// The repair of the frames from `first` to before `end`, if the track jumps back at `end`.
fn run(track: &[Quat], first: usize, end: usize, bone: Option<Vec3>, longest_replaced: usize) -> Option<FlipRepair> {
    let (before, into, out, after) = (track[first - 1], track[first], track[end - 1], track[end]);
    let smaller = angle(before, into).min(angle(out, after));
    let rights = [into.inverse() * before, out.inverse() * after];
    let lefts = [before * into.inverse(), after * out.inverse()];
    let [right, left] = [rights, lefts].map(|ends| angle(ends[0], ends[1]));
    let mean = |[at_start, at_end]: [Quat; 2]| (at_start + in_hemisphere_of(at_start, at_end)).normalize();
    if right < AGREE * smaller
        && let Some(turn) = bone.and_then(|bone| half_turn(mean(rights), bone))
    {
        return Some(FlipRepair::Right(turn));
    }
    if end - first > 1 && right.min(left) < AGREE * smaller {
        return Some(match right <= left {
            true => FlipRepair::Right(mean(rights)),
            false => FlipRepair::Left(mean(lefts)),
        });
    }
    let comes_back = angle(before, after) < AGREE * smaller;
    (comes_back && end - first <= longest_replaced).then_some(FlipRepair::Replace)
}

/// Half a turn about the bone, if the rotation is near it.
fn half_turn(rotation: Quat, bone: Vec3) -> Option<Quat> {
    let turn = Quat::from_xyzw(bone.x, bone.y, bone.z, 0.0);
    (angle(rotation, turn) < HALF_TURN.to_radians()).then_some(turn)
}

fn apply(track: &mut [Quat], first: usize, end: usize, mend: FlipRepair) {
    let (before, after) = (track[first - 1], track[end]);
    let count = (end + 1 - first) as f32;
    for (index, rotation) in track[first..end].iter_mut().enumerate() {
        let mended = match mend {
            FlipRepair::Right(turn) => *rotation * turn,
            FlipRepair::Left(turn) => turn * *rotation,
            FlipRepair::Replace => before.slerp(after, (index + 1) as f32 / count),
        };
        *rotation = in_hemisphere_of(before, mended.normalize());
    }
}
