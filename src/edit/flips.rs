//! Finds and repairs flips. In a flip, the rotation of a joint jumps away from the motion, and later jumps back. Both
//! `despike` and `clean` use this code.
//!
//! A step is the rotation of a joint from one frame to the next. A jump is a step that is far larger than the steps
//! around it. The frames between two jumps that undo each other are a run. If one rotation separates the whole run from
//! the motion, such as a roll of 180 degrees, the run is rotated back. The run then keeps its own motion. Any other
//! short run is replaced by rotations that are interpolated between the frames before and after it. If no later jump
//! undoes a jump, and the jump is a rotation about the bone, [`twist`] spreads it over several frames.

use std::ops::Range;

use glam::{Quat, Vec3};
use mocap_scene::math::median::median;
use mocap_scene::math::quaternion::{in_hemisphere_of, log};
use mocap_scene::scene::{NodeId, Scene};

use super::frames::Frames;
use super::twist;

/// The number of frames on either side of a step that show the usual size of a step.
const AROUND: usize = 15;
/// The smallest ratio of a jump to the median of the steps around it.
const JUMP: f32 = 5.0;
/// The largest ratio of the smaller neighbouring step to a jump. In a real movement, this ratio is larger, because the
/// speed grows over several frames.
const BESIDE: f32 = 0.45;
/// The smallest jump that is looked for, in degrees. Smaller jumps are spikes, which `despike` finds by its threshold.
const LEAST: f32 = 35.0;
/// The smallest rotation that may be a jump between two frames with unknown frames between them, in degrees. This angle
/// is below [`LEAST`]: if the unknown frames hide an exchange of left and right limbs, the jump is small, because both
/// limbs have similar poses.
const LEAST_OVER: f32 = 20.0;

/// The longest run that is rotated back, in seconds. In a longer run, the rotation may be intended.
const LONGEST: f64 = 2.0;

/// The longest run that is interpolated, in seconds, because interpolation loses the run's own motion.
const LONGEST_REPLACED: f64 = 0.2;
/// The largest number of frames in a run. With this limit, the running time is proportional to the number of frames.
const MOST_FRAMES: usize = 2000;
/// A flip begins with a jump and ends with the opposite jump. This is the largest difference between the first jump and
/// the inverse of the second jump, as a fraction of the smaller jump.
const AGREE: f32 = 0.4;
/// A jump counts as half a turn about the bone if it differs from half a turn by at most this angle, in degrees.
const HALF_TURN: f32 = 35.0;

/// A speed of rotation that no joint of an animal reaches, in degrees per second. Joints of galloping dogs reach 2000.
const FASTEST: f32 = 4500.0;

/// The repairs in one track.
#[derive(Clone, Default)]
pub(super) struct FlipOutcome {
    /// For each frame, whether the frame was changed. Empty if no frame was changed.
    pub(super) frames: Vec<bool>,
    /// The number of repaired runs.
    pub(super) runs: usize,
    /// The number of jumps that were spread over several frames.
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
    /// Rotations are multiplied on the right: the joint rotates in its own coordinate frame.
    Right(Quat),
    /// Rotations are multiplied on the left: the joint rotates in the coordinate frame of its parent.
    Left(Quat),
    /// Rotations are interpolated between the neighbours of the run.
    Replace,
}

/// Repairs the flips of all joints. Returns the repairs of each joint. For an animal, also spreads steps faster than
/// [`FASTEST`] over several frames.
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

/// Repairs the flips in the rotations of one joint. `bone` is the direction of the bone in the coordinate frame of the
/// joint.
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

/// The direction of a joint's bone in the joint's coordinate frame: towards the first child that is not at the position
/// of the joint.
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

/// The number of new jumps in `track`. A jump is new unless `before`, the track before a change, has a step of nearly
/// this size at the same frame. So a step that grows a little above [`LEAST`] is no new jump.
pub(super) fn count_new(track: &[Quat], before: &[Quat]) -> usize {
    /// The fraction of a jump above which an earlier step counts as nearly as large.
    const NEARLY: f32 = 0.8;
    let step = |track: &[Quat], to: usize| angle(track[to - 1], track[to]);
    let is_new = |to: &usize| to >= &before.len() || step(before, *to) < NEARLY * step(track, *to);
    jumps(track).iter().filter(|to| is_new(to)).count()
}

/// The first frame after each jump of a track.
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
        // If a run has only one frame, the next or the previous step is a jump, too. So the smaller of both
        // neighbouring steps counts.
        let beside = |other: Option<usize>| other.and_then(|other| steps.get(other)).copied().unwrap_or(0.0);
        let smaller = beside(step.checked_sub(1)).min(beside(Some(step + 1)));
        here > JUMP * usual && smaller < BESIDE * here
    };
    (0..steps.len()).filter(is_jump).map(|step| step + 1).collect()
}

/// Interpolates runs of frames in which a position jumps away by `least` or more and comes back. Returns the number of
/// runs. No body can move away and come back in such a short time.
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

/// Whether the rotation jumps between the frames `from` and `to`. The frames between them are unknown.
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

/// The repair of the run from the frame `first` to the frame before `end`. `None` if the jumps at `first` and `end` do
/// not undo each other.
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

/// Half a turn about the bone, if `rotation` is nearly half a turn about the bone.
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
