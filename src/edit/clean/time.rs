//! Time: frames that are held, doubled or dropped.
//!
//! A frame that has all that the frame before it has is held: it stands for one that was lost, or is there in excess.
//! Which of them, and where a frame was dropped, the frames on either side tell ([`super::gaps`]).

use std::ops::Range;

use glam::Vec3;
use mocap_scene::math::quaternion::log;
use mocap_scene::pose::Trs;

use super::gaps::Gaps;
use super::rate::{self, Pattern, RateEvidence};
use crate::bridge::bridge;
use crate::flips;
use crate::work::Work;

/// The longest run of held frames that may be there in excess.
const LONGEST_DOUBLED: usize = 4;
/// A step in which nothing moves by more than this, in radians and in fractions of the body, is none.
const STILL: f32 = 2e-6;

/// What was found and done, in frames.
#[derive(Default)]
pub(super) struct TimeRepair {
    pub(super) filled: usize,
    pub(super) removed: usize,
    pub(super) inserted: usize,
    pub(super) frozen: usize,
    /// The rate of the file, and that of the motion, where that is another.
    pub(super) rate: Option<[f64; 2]>,
    /// What tells of that rate, in words.
    pub(super) tells: String,
}

/// Takes out frames that are repeated in a pattern, fills those that were held, takes doubled ones out, puts those in
/// that were dropped, and finds the rate. Says beside what looks wrong and stays.
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
            done.tells += &format!("{and}{flights} jumps fall by {fall:.2} of gravity");
        }
        Some(RateEvidence::Perhaps(words)) => doubt = Some(words),
        None => {}
    }
    done.rate = (work.frames.rate != stated).then_some([stated, work.frames.rate]);
    (done, doubt)
}

/// Takes frames out that repeat the one before in a pattern, and says in words which.
fn without_repeated(work: &mut Work<'_>) -> Option<String> {
    if work.frames.ticks.last()?.fract() != 0.0 {
        return None;
    }
    let held = Steps::new(work).held();
    let pattern = Pattern::of(&held)?;
    // A pattern that begins late is one of the frames that move.
    let kept = || (0..held.len()).filter(|frame| !held[*frame]);
    let rows = kept().map(|frame| work.frames.row(frame).to_vec()).collect();
    let taken: Vec<_> = kept().map(|frame| (&work.frames, frame as f64)).collect();
    work.frames = work.frames.with_rows_of(rows, &taken);
    work.frames.rate *= pattern.fraction_of_own();
    let repeated = pattern.is_held.iter().filter(|held| **held).count();
    Some(format!(
        "{repeated} of {} frames repeat the one before",
        pattern.is_held.len()
    ))
}

/// The frames that are held or doubled, and those before which one was dropped.
pub(super) fn errors(work: &Work<'_>) -> [Vec<usize>; 2] {
    let (frames, _) = find(work);
    let with = |rows: &[Row]| {
        (0..frames.len())
            .filter(|frame| rows.contains(&frames[*frame]))
            .collect()
    };
    [with(&[Row::Held, Row::Doubled]), with(&[Row::AfterDropped])]
}

/// What each frame is, and what mending that comes to.
fn find(work: &Work<'_>) -> (Vec<Row>, TimeRepair) {
    let mut done = TimeRepair::default();
    if work.frames.ticks.last().is_none_or(|tick| tick.fract() != 0.0) {
        return (Vec::new(), done);
    }
    let steps = Steps::new(work);
    let held = steps.held();
    let seen: Vec<usize> = (0..held.len()).filter(|frame| !held[*frame]).collect();
    let leading: Vec<&[Vec3]> = seen
        .iter()
        .skip(1)
        .map(|frame| steps.steps[*frame - 1].as_slice())
        .collect();
    let gaps = Gaps::new(&leading, seen.iter().map(|frame| *frame as f64).collect());
    let mut frames = vec![Row::Seen; held.len()];
    let longest = work.frames.frames_in(work.weights.longest_held);
    let doubled = work.weights.least_evidence_of_doubled as f32;
    let mut excess = Vec::new();
    for (index, pair) in seen.windows(2).enumerate() {
        let run = pair[0] + 1..pair[1];
        if run.len() > longest {
            done.frozen += run.len();
        } else if !run.is_empty() && pair[0] > 0 {
            let is_short = run.len() <= LONGEST_DOUBLED;
            let by = -(run.len() as f64);
            let sure = if is_short { gaps.is_longer(index + 1, by) } else { None };
            excess.extend(sure.filter(|sure| *sure > doubled).map(|sure| (run.clone(), sure)));
            done.filled += run.len();
            frames[run].fill(Row::Held);
        }
    }
    let mut dropped = gaps.dropped();
    let least = (work.weights.least_speed / work.frames.rate) as f32;
    dropped.retain(|(index, _)| {
        let is_moving = |part: &Vec3| part.length() > least;
        seen[*index] == seen[*index - 1] + 1 && leading[*index - 1].iter().any(is_moving)
    });
    balance(&mut excess, &mut dropped, work.weights.least_evidence as f32);
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

/// Keeps of the frames in excess, and of those before which one was dropped, what is sure. What is less sure is kept in
/// pairs of both, the surest first: a program that is late drops a frame, and doubles one to catch up.
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

/// The number of frames that hold what the frame before them has, while the body moves before and after.
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

/// What a frame of the input is.
#[derive(Clone, Copy, PartialEq)]
enum Row {
    Seen,
    /// It holds what the frame before has, and its own values are lost.
    Held,
    /// It is there in excess.
    Doubled,
    /// A frame is missing before it.
    AfterDropped,
}

/// Makes the frames anew: those in excess go, and those that are missing or lost lie on the curve through the others.
fn rebuild(work: &mut Work<'_>, frames: &[Row]) {
    if frames.iter().all(|row| *row == Row::Seen) {
        return;
    }
    let mut rows = Vec::with_capacity(frames.len());
    let mut missing = Vec::with_capacity(frames.len());
    let mut taken = Vec::with_capacity(frames.len());
    for (frame, row) in frames.iter().enumerate() {
        if *row == Row::Doubled {
            continue;
        }
        if *row == Row::AfterDropped {
            rows.push(work.frames.row(frame).to_vec());
            taken.push((&work.frames, frame as f64 - 0.5));
            missing.push(true);
        }
        rows.push(work.frames.row(frame).to_vec());
        taken.push((&work.frames, frame as f64));
        missing.push(*row == Row::Held);
    }
    work.frames = work.frames.with_rows_of(rows, &taken);
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

/// Gives the frames before `end` what the nearer frame beside them has. A curve through a flip would be a turn of some
/// frames, which nobody could tell from a motion.
fn hold(track: &mut [Trs], first: usize, end: usize) {
    let middle = first + (end - first) / 2;
    let (before, after) = (track[first - 1], track[end]);
    track[first..middle].fill(before);
    track[middle..end].fill(after);
}

/// The steps of the whole body: that of index `n` leads to frame `n + 1`.
struct Steps {
    steps: Vec<Vec<Vec3>>,
}

impl Steps {
    fn new(work: &Work<'_>) -> Self {
        let columns = 0..work.frames.nodes().len();
        let size = columns
            .clone()
            .map(|column| work.reach(work.frames.nodes()[column]))
            .fold(0.0, f32::max);
        let per_unit = work.metres / size.max(1e-6);
        let step = |a: &Trs, b: &Trs| {
            [
                log(a.rotation.inverse() * b.rotation),
                (b.translation - a.translation) * per_unit,
            ]
        };
        let row = |frame: usize| {
            let pairs = work.frames.row(frame - 1).iter().zip(work.frames.row(frame));
            pairs.flat_map(|(a, b)| step(a, b)).collect()
        };
        Self {
            steps: (1..work.frames.len()).map(row).collect(),
        }
    }

    /// For each frame whether it has what the frame before has.
    fn held(&self) -> Vec<bool> {
        let is_still = |step: &Vec<Vec3>| step.iter().all(|part| part.abs().max_element() <= STILL);
        std::iter::once(false).chain(self.steps.iter().map(is_still)).collect()
    }
}
