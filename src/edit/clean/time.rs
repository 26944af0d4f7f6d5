//! Time: frames that are held, doubled or dropped.
//!
//! The step of the whole body from one frame to the next is compared with the steps around it, along their direction:
//! it is about once as long where nothing is wrong, not there where a frame is held, and twice as long where one is
//! missing.

use glam::Vec3;

use super::work::Work;
use crate::edit::fill::bridge;
use crate::math::quaternion::log;
use crate::pose::Trs;

/// The longest run of held frames that is filled, in seconds. A longer one is frozen, and may be meant.
const LONGEST_HELD: f64 = 0.5;
/// Steps on either side that say what a step should be.
const AROUND: usize = 4;
/// How sure the ratio of a step to those around it must be: its standard deviation.
const SURE: f32 = 0.12;
/// The ratio of a step over a missing frame, at least and at most, and of the steps beside it at most.
const DROPPED: [f32; 2] = [1.7, 2.5];
const BESIDE: f32 = 1.4;
/// A step in which nothing moves by more than this, in radians and in fractions of the body, is none.
const STILL: f32 = 2e-6;

/// What was found and done, in frames.
#[derive(Default)]
pub(super) struct Mended {
    pub(super) filled: usize,
    pub(super) removed: usize,
    pub(super) inserted: usize,
    pub(super) frozen: usize,
}

/// Fills frames that were held, takes doubled ones out, and puts those in that were dropped.
pub(super) fn mend(work: &mut Work<'_>) -> Mended {
    let (frames, done) = find(work);
    rebuild(work, &frames);
    done
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
fn find(work: &Work<'_>) -> (Vec<Row>, Mended) {
    let mut done = Mended::default();
    let steps = Steps::new(work);
    if steps.steps.len() < 2 * AROUND || work.frames.ticks.last().is_none_or(|tick| tick.fract() != 0.0) {
        return (Vec::new(), done);
    }
    let held = steps.held();
    let mut frames: Vec<Row> = vec![Row::Seen; work.frames.len()];
    let longest = work.frames.frames_in(LONGEST_HELD);
    let mut frame = 1;
    while frame < frames.len() {
        let end = (frame..frames.len()).find(|f| !held[*f]).unwrap_or(frames.len());
        let count = end - frame;
        if count > 0 && frame > 1 && end < frames.len() {
            // The step out of the run covers the frames that were held, unless these are there in excess.
            let is_excess = steps
                .ratio(end, &held)
                .is_some_and(|ratio| ratio < 0.5 * (count + 2) as f32);
            match is_excess {
                _ if count > longest => done.frozen += count,
                true => {
                    frames[frame..end].fill(Row::Doubled);
                    done.removed += count;
                }
                false => {
                    frames[frame..end].fill(Row::Held);
                    done.filled += count;
                }
            }
        }
        frame = end.max(frame) + 1;
    }
    for frame in 2..frames.len().saturating_sub(1) {
        if (frame - 1..=frame + 1).all(|f| !held[f]) && steps.is_dropped(frame, &held) {
            frames[frame] = Row::AfterDropped;
            done.inserted += 1;
        }
    }
    (frames, done)
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
    for (frame, row) in frames.iter().enumerate() {
        if *row == Row::Doubled {
            continue;
        }
        if *row == Row::AfterDropped {
            rows.push(work.frames.row(frame).to_vec());
            missing.push(true);
        }
        rows.push(work.frames.row(frame).to_vec());
        missing.push(*row == Row::Held);
    }
    work.frames = work.frames.with_rows(rows);
    for column in 0..work.frames.nodes().len() {
        let mut track = work.frames.track(column);
        let mut frame = 1;
        while frame + 1 < track.len() {
            let end = (frame..track.len()).find(|f| !missing[*f]).unwrap_or(track.len());
            if end > frame && end < track.len() {
                bridge(&mut track, frame, end - 1);
            }
            frame = end.max(frame) + 1;
        }
        work.frames.set_track(column, &track);
    }
    work.missing = missing;
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

    /// The length of the step to a frame along the mean of the steps around it, and how sure it is: nothing where that
    /// is not known well.
    fn ratio(&self, frame: usize, held: &[bool]) -> Option<f32> {
        let step = frame - 1;
        let is_good = |other: &usize| *other < self.steps.len() && !held[*other + 1] && !held[*other];
        let before = (0..step.saturating_sub(1)).rev().filter(is_good).take(AROUND);
        let after = (step + 2..self.steps.len()).filter(is_good).take(AROUND);
        let near: Vec<usize> = before
            .chain(after)
            .filter(|other| other.abs_diff(step) <= 3 * AROUND)
            .collect();
        if near.len() < AROUND {
            return None;
        }
        let parts = self.steps[step].len();
        let mean = |part: usize| near.iter().map(|other| self.steps[*other][part]).sum::<Vec3>() / near.len() as f32;
        let mean: Vec<Vec3> = (0..parts).map(mean).collect();
        let along = |step: &[Vec3]| step.iter().zip(&mean).map(|(a, b)| a.dot(*b)).sum::<f32>();
        let square = along(&mean);
        if square <= 0.0 {
            return None;
        }
        let ratio = along(&self.steps[step]) / square;
        let off = |other: &usize| (along(&self.steps[*other]) / square - 1.0).powi(2);
        let deviation = (near.iter().map(off).sum::<f32>() / near.len() as f32).sqrt();
        (deviation < SURE).then_some(ratio)
    }

    fn is_dropped(&self, frame: usize, held: &[bool]) -> bool {
        let is_long = |ratio: f32| (DROPPED[0]..DROPPED[1]).contains(&ratio);
        let is_usual = |frame: usize| self.ratio(frame, held).is_some_and(|ratio| ratio < BESIDE);
        self.ratio(frame, held).is_some_and(is_long) && is_usual(frame - 1) && is_usual(frame + 1)
    }
}
