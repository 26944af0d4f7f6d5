//! Repairs timing: repeated and missing frames.
//!
//! A *held* frame repeats the frame before. It either replaces a frame that was lost, or it is an additional duplicate.
//! The frames before and after it show which is true. They also show where a frame is missing ([`super::gaps`]).

use std::ops::Range;

use glam::Vec3;
use mocap_scene::math::quaternion::log;
use mocap_scene::pose::Trs;

use super::gaps::GapEvidence;
use super::rate::{self, Pattern, RateEvidence};
use crate::bridge::bridge;
use crate::flips;
use crate::frames::Frames;
use crate::work::Work;

/// The longest run of repeated frames that may be duplicates.
const LONGEST_DOUBLED: usize = 4;
/// A movement from frame to frame counts as none if it is smaller than this, in radians and in fractions of the body.
const STILL: f32 = 2e-6;

/// The largest fraction of dropped frames that are inserted. Dropped frames with a duplicate nearby do not count. If
/// more seem to be dropped, the cause is noise or resampling.
const MOST_DROPPED: f64 = 0.02;
/// The number of frames that may always be dropped, because the fraction of a short take is less than one frame.
const LEAST_MOST_DROPPED: f64 = 4.0;

/// The largest number of frames that interpolation makes from one: 15 frames per second in a file of 120.
const MOST_OF_ONE: usize = 8;
/// In an interpolated take, at least this fraction of all changes of speed is in the original frames.
const IN_OWN_FRAMES: f32 = 0.9;

/// The number of frames that are examined for interpolation.
const LOOKED_AT: usize = 4000;

/// The least number of original frames in an interpolated take.
const LEAST_OWN_FRAMES: usize = 10;

/// The repairs, in numbers of frames.
#[derive(Default)]
pub(super) struct TimeRepair {
    pub(super) filled: usize,
    pub(super) removed: usize,
    pub(super) inserted: usize,
    pub(super) frozen: usize,
    /// The rate of the file, and the rate of the motion if it differs.
    pub(super) rate: Option<[f64; 2]>,
    /// A message about the evidence for this rate.
    pub(super) tells: String,
}

/// Removes frames that repeat in a pattern, fills held frames, removes duplicates, inserts dropped frames, and corrects
/// the rate. Also returns a message about a rate that looks wrong but is not changed.
pub(super) fn mend(work: &mut Work<'_>) -> (TimeRepair, Option<String>) {
    let stated = work.frames.rate;
    let repeated = without_repeated(work);
    let (frames, mut done) = find(work);
    rebuild(work, &frames);
    done.tells = repeated.unwrap_or_default();
    let mut doubt = None;
    match rate::told(work) {
        Some(RateEvidence::Is { rate, flights, fall }) => {
            work.frames.rate = rate;
            let and = if done.tells.is_empty() { "" } else { ", " };
            done.tells += &format!("{and}in {flights} jumps, the body falls with {fall:.2} times gravity");
        }
        Some(RateEvidence::Perhaps(words)) => doubt = Some(words),
        None => {}
    }
    done.rate = (work.frames.rate != stated).then_some([stated, work.frames.rate]);
    (done, doubt)
}

/// Removes frames that repeat the frame before in a pattern. Returns a message about the pattern.
fn without_repeated(work: &mut Work<'_>) -> Option<String> {
    if work.frames.ticks.last()?.fract() != 0.0 {
        return None;
    }
    let held = Steps::new(work).held();
    let pattern = Pattern::of(&held)?;
    // The pattern may begin late, so the kept frames are those that move.
    let kept: Vec<usize> = (0..held.len()).filter(|frame| !held[*frame]).collect();
    let times: Vec<f64> = kept.iter().map(|frame| *frame as f64).collect();
    work.frames = work.frames.picked_of(&kept, &times);
    work.frames.rate *= pattern.fraction_of_own();
    let repeated = pattern.is_held.iter().filter(|held| **held).count();
    Some(format!(
        "{repeated} of {} frames repeat the frame before",
        pattern.is_held.len()
    ))
}

/// The frames that repeat the frame before, and the frames before which a frame is missing.
pub(super) fn errors(work: &Work<'_>) -> [Vec<usize>; 2] {
    let (frames, _) = find(work);
    let with = |rows: &[Row]| {
        (0..frames.len())
            .filter(|frame| rows.contains(&frames[*frame]))
            .collect()
    };
    [with(&[Row::Held, Row::Doubled]), with(&[Row::AfterDropped])]
}

/// The kind of each frame, and the number of repairs of each kind.
fn find(work: &Work<'_>) -> (Vec<Row>, TimeRepair) {
    let mut done = TimeRepair::default();
    if work.frames.ticks.last().is_none_or(|tick| tick.fract() != 0.0) {
        return (Vec::new(), done);
    }
    let steps = Steps::new(work);
    let held = steps.held();
    let seen: Vec<usize> = (0..held.len()).filter(|frame| !held[*frame]).collect();
    let mut frames = vec![Row::Seen; held.len()];
    let longest = work.frames.frames_in(work.weights.longest_held);
    let doubled = work.weights.least_evidence_of_doubled as f32;
    let (mut asked, mut runs) = (Vec::new(), Vec::new());
    for (index, pair) in seen.windows(2).enumerate() {
        let run = pair[0] + 1..pair[1];
        if run.len() > longest {
            done.frozen += run.len();
        } else if !run.is_empty() && pair[0] > 0 {
            done.filled += run.len();
            if run.len() <= LONGEST_DOUBLED {
                asked.push((index + 1, -(run.len() as f64)));
                runs.push(run.clone());
            }
            frames[run].fill(Row::Held);
        }
    }
    let times: Vec<f64> = seen.iter().map(|frame| *frame as f64).collect();
    let step = |index: usize, part: usize| steps.part(seen[index], part);
    let GapEvidence { mut dropped, longer } = GapEvidence::new(&times, steps.parts(), step, &asked);
    let excess =
        std::iter::zip(runs, longer).filter_map(|(run, sure)| Some((run, sure.filter(|sure| *sure > doubled)?)));
    let mut excess: Vec<(Range<usize>, f32)> = excess.collect();
    let least = (work.weights.least_speed / work.frames.rate) as f32;
    dropped.retain(|(index, _)| {
        let is_moving = |part: usize| steps.part(seen[*index], part).length() > least;
        seen[*index] == seen[*index - 1] + 1 && (0..steps.parts()).any(is_moving)
    });
    balance(&mut excess, &mut dropped, work.weights.least_evidence as f32);
    let most = (MOST_DROPPED * held.len() as f64).max(LEAST_MOST_DROPPED);
    let alone = dropped.len().saturating_sub(excess.len());
    if alone as f64 > most || (alone > 0 && steps.interpolated() > 1) {
        dropped.truncate(excess.len());
    }
    for (run, _) in excess {
        done.filled -= run.len();
        done.removed += run.len();
        frames[run].fill(Row::Doubled);
    }
    for (index, _) in dropped {
        frames[seen[index]] = Row::AfterDropped;
        done.inserted += 1;
    }
    (frames, done)
}

/// Keeps the duplicates and dropped frames that are certain. Uncertain ones are kept only in pairs, the most certain
/// first: a program that is late drops a frame, and duplicates another to catch up.
fn balance(excess: &mut Vec<(Range<usize>, f32)>, dropped: &mut Vec<(usize, f32)>, certain: f32) {
    excess.sort_by(|a, b| b.1.total_cmp(&a.1));
    dropped.sort_by(|a, b| b.1.total_cmp(&a.1));
    let sure = [
        excess.iter().filter(|found| found.1 > certain).count(),
        dropped.iter().filter(|found| found.1 > certain).count(),
    ];
    let pairs = excess.len().min(dropped.len());
    excess.truncate(pairs.max(sure[0]));
    dropped.truncate(pairs.max(sure[1]));
}

/// The number of frames that repeat the frame before, while the body moves before and after.
pub(super) fn held(work: &Work<'_>) -> usize {
    let held = Steps::new(work).held();
    let first = held.iter().skip(1).position(|held| !held).unwrap_or(held.len());
    let last = held.iter().rposition(|held| !held).unwrap_or(0);
    held.get(first..last)
        .unwrap_or_default()
        .iter()
        .filter(|held| **held)
        .count()
}

/// The distance of the original frames if the take was interpolated linearly; otherwise 1.
pub(super) fn interpolated(work: &Work<'_>) -> usize {
    Steps::new(work).interpolated()
}

/// The kind of an input frame.
#[derive(Clone, Copy, PartialEq)]
enum Row {
    Seen,
    /// The frame repeats the frame before, and its own values are lost.
    Held,
    /// The frame is an additional duplicate of the frame before.
    Doubled,
    /// A frame is missing before this frame.
    AfterDropped,
}

/// Rebuilds the frames: removes duplicates, and interpolates missing or lost frames on a curve through the other
/// frames.
fn rebuild(work: &mut Work<'_>, frames: &[Row]) {
    if frames.iter().all(|row| *row == Row::Seen) {
        return;
    }
    let mut chosen = Vec::with_capacity(frames.len());
    let mut missing = Vec::with_capacity(frames.len());
    let mut times = Vec::with_capacity(frames.len());
    for (frame, row) in frames.iter().enumerate() {
        if *row == Row::Doubled {
            continue;
        }
        if *row == Row::AfterDropped {
            chosen.push(frame);
            times.push(frame as f64 - 0.5);
            missing.push(true);
        }
        chosen.push(frame);
        times.push(frame as f64);
        missing.push(*row == Row::Held);
    }
    work.frames = work.frames.picked_of(&chosen, &times);
    for column in 0..work.frames.nodes().len() {
        let mut track = work.frames.track(column);
        let rotations: Vec<_> = track.iter().map(|trs| trs.rotation).collect();
        let mut frame = 1;
        while frame + 1 < track.len() {
            let end = (frame..track.len()).find(|f| !missing[*f]).unwrap_or(track.len());
            if end > frame && end < track.len() {
                match flips::is_jump_over(&rotations, frame - 1, end) {
                    true => hold(&mut track, frame, end),
                    false => bridge(&mut track, frame, end - 1),
                }
            }
            frame = end.max(frame) + 1;
        }
        work.frames.set_track(column, &track);
    }
    work.missing = missing;
}

/// Fills frames with the values of the nearer known frame. It is used at a flip, where a curve would look like a real
/// rotation over several frames.
fn hold(track: &mut [Trs], first: usize, end: usize) {
    let middle = first + (end - first) / 2;
    let (before, after) = (track[first - 1], track[end]);
    track[first..middle].fill(before);
    track[middle..end].fill(after);
}

/// The steps of the whole body from frame to frame. A step has two parts for each node: a rotation and a translation.
struct Steps<'a> {
    frames: &'a Frames<'a>,
    /// The fraction of the body's size in one unit of the scene.
    per_unit: f32,
}

impl<'a> Steps<'a> {
    fn new(work: &'a Work<'_>) -> Self {
        let reaches = work.frames.nodes().iter().map(|node| work.reach(*node));
        Self {
            frames: &work.frames,
            per_unit: work.metres / reaches.fold(0.0, f32::max).max(1e-6),
        }
    }

    fn parts(&self) -> usize {
        2 * self.frames.nodes().len()
    }

    fn part(&self, frame: usize, part: usize) -> Vec3 {
        let column = part / 2;
        match part % 2 {
            0 => {
                let rotation = |frame: usize| self.frames.rotation(frame, column);
                log(rotation(frame - 1).inverse() * rotation(frame))
            }
            _ => {
                let translation = |frame: usize| self.frames.translation(frame, column);
                (translation(frame) - translation(frame - 1)) * self.per_unit
            }
        }
    }

    /// The distance of the frames between which the body moves linearly; 1 if it does not.
    fn interpolated(&self) -> usize {
        let bend = |frame: usize| {
            let bend = |part: usize| (self.part(frame + 1, part) - self.part(frame, part)).length();
            (0..self.parts()).map(bend).sum::<f32>()
        };
        let frames = self.frames.len().min(LOOKED_AT);
        let bends: Vec<f32> = (1..frames.saturating_sub(1)).map(bend).collect();
        let all: f32 = bends.iter().sum();
        let is_interpolated = |every: &usize| {
            let own = |first: usize| bends[first..].iter().step_by(*every).sum::<f32>();
            (0..*every).any(|first| own(first) > IN_OWN_FRAMES * all)
        };
        let most = MOST_OF_ONE.min(bends.len() / LEAST_OWN_FRAMES);
        (2..=most).rev().find(is_interpolated).unwrap_or(1)
    }

    /// For each frame, whether it repeats the frame before.
    fn held(&self) -> Vec<bool> {
        let is_still = |frame: usize, part: usize| self.part(frame, part).abs().max_element() <= STILL;
        let is_held = |frame: usize| (0..self.parts()).all(|part| is_still(frame, part));
        std::iter::once(false)
            .chain((1..self.frames.len()).map(is_held))
            .collect()
    }
}
