//! Which of the codes around a rotation to take: one that keeps the children where they belong and costs little.
//!
//! A joint's turn about the way to its child hardly moves that child, so that among the codes around the wanted one
//! there are some that are far better than the nearest. That spares about a bit of every component. What is cheap is
//! said by the streams: differences to the code before, in 2, 4 or 8 bits each.

use super::around::{Around, LeftOut};
use super::chain::Task;
use super::code::CodedRotation;
use super::lanes::SINGLES;

/// The most that the filter takes.
pub(super) const MOST_BITS: u32 = 16;

/// The codes for some frames, and their bits: `fewest` or as many as it takes that none of them is off by more than
/// `tolerance`; if even the most that there are do not, these.
pub(super) fn choose(task: &Task, fewest: u32, frames: &[u32], tolerance: f32) -> (u32, Vec<CodedRotation>) {
    let mut bits = fewest;
    loop {
        if (bits == MOST_BITS || may_suffice(task, bits, frames, tolerance))
            && let Some(keys) = with_bits(task, bits, frames, tolerance)
        {
            return (bits, keys);
        }
        bits += 1;
    }
}

/// The codes for some frames; none where so many bits leave one of them off by more than `tolerance`, unless they are
/// the most that there are.
fn with_bits(task: &Task, bits: u32, frames: &[u32], tolerance: f32) -> Option<Vec<CodedRotation>> {
    // Some room for keys that come back.
    let mut keys: Vec<CodedRotation> = Vec::with_capacity(frames.len() + frames.len() / 4);
    for frames in frames.chunks(SINGLES) {
        let aims = task.aims(frames);
        let left_out = LeftOut::follow(&aims.wanted, keys.last().map(CodedRotation::left_out));
        let around = Around::new(task.arms, bits, tolerance, &aims, left_out);
        let first = keys.len();
        for lane in 0..frames.len() {
            let key = around.best(lane, keys.last());
            keys.push(key);
        }
        if bits < MOST_BITS && aims.largest_error(task.arms, &keys[first..]) > tolerance {
            return None;
        }
    }
    Some(keys)
}

/// Whether codes of so many bits can be near enough, by a look at some frames.
fn may_suffice(task: &Task, bits: u32, frames: &[u32], tolerance: f32) -> bool {
    const EVERY: usize = 13;
    let some: Vec<u32> = frames.iter().step_by(EVERY).copied().collect();
    some.chunks(SINGLES).all(|frames| {
        let aims = task.aims(frames);
        let left_out = LeftOut::of(&aims.wanted, |_| None);
        let around = Around::new(task.arms, bits, tolerance, &aims, left_out);
        let keys: [CodedRotation; SINGLES] = std::array::from_fn(|lane| around.best(lane, None));
        aims.largest_error(task.arms, &keys) <= tolerance
    })
}

/// The codes for some frames, each given the one before it.
pub(super) fn choose_after(
    task: &Task,
    bits: u32,
    frames: &[u32],
    previous: &[CodedRotation],
    tolerance: f32,
) -> Vec<CodedRotation> {
    let mut keys = Vec::with_capacity(frames.len());
    for (frames, previous) in std::iter::zip(frames.chunks(SINGLES), previous.chunks(SINGLES)) {
        let aims = task.aims(frames);
        let left_out = LeftOut::of(&aims.wanted, |lane| previous.get(lane).map(CodedRotation::left_out));
        let around = Around::new(task.arms, bits, tolerance, &aims, left_out);
        keys.extend((0..frames.len()).map(|lane| around.best(lane, Some(&previous[lane]))));
    }
    keys
}

#[cfg(test)]
mod tests {
    use glam::{Quat, Vec3};

    use super::super::chain::Arms;
    use super::super::motion::World;
    use super::*;

    /// A joint that turns, with one child, below one that a reader has a little off.
    fn worlds(frames: usize) -> (World, World, Vec<Vec3>) {
        let turned = |frame: usize, speed: f32| {
            let angle = frame as f32 * speed;
            Quat::from_euler(glam::EulerRot::ZXY, angle, 0.6 * angle, (0.3 * angle).sin())
        };
        let off = Quat::from_rotation_x(4e-4);
        let truth = World {
            positions: vec![Vec3::ZERO; frames],
            rotations: (0..frames).map(|frame| turned(frame, 0.031)).collect(),
        };
        let above = World {
            positions: vec![Vec3::ZERO; frames],
            rotations: (0..frames).map(|frame| off * turned(frame, 0.007)).collect(),
        };
        let coded = (0..frames).map(|frame| Vec3::X * (frame as f32).sin() * 3e-4).collect();
        (truth, above, coded)
    }

    #[test]
    fn every_code_is_near_enough_and_needs_no_more_bits_than_that() {
        const TOLERANCE: f32 = 0.001;
        let (truth, above, positions) = worlds(1003);
        let arms = Arms::of(vec![Vec3::new(0.0, 0.3, 0.1)]);
        let task = Task {
            arms: &arms,
            truth: &truth,
            positions: &positions,
            above: Some(&above),
        };
        let frames: Vec<u32> = (0..1003).collect();
        let (bits, keys) = choose(&task, 4, &frames, TOLERANCE);
        assert!((6..12).contains(&bits), "{bits}");
        for (frame, key) in keys.iter().enumerate() {
            // Where the child is to be, and where it comes to be.
            let way = arms.ways[0];
            let wanted = truth.rotations[frame] * way;
            let found = positions[frame] + above.rotations[frame] * (key.value.normalize() * way);
            assert!(wanted.distance(found) <= 1.001 * TOLERANCE, "{frame}: {found}");
        }
        assert!(
            with_bits(&task, bits - 1, &frames, TOLERANCE).is_none()
                || !may_suffice(&task, bits - 1, &frames, TOLERANCE)
        );

        // A key that comes later has the same code.
        let codes = |keys: &[CodedRotation]| keys.iter().map(|key| key.code).collect::<Vec<_>>();
        let later = choose_after(&task, bits, &[500, 700], &[keys[499], keys[699]], TOLERANCE);
        assert_eq!(codes(&later), [keys[500].code, keys[700].code]);
    }
}
