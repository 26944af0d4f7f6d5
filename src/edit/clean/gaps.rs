//! Estimates whether a frame is missing between two frames.
//!
//! The test fits a polynomial of degree 4 to a window of eight frames, four before and four after the possible gap. A
//! motion is smooth, so the residual (the remaining error) is small. If a frame is missing, the residual becomes
//! smaller when the four later frames are moved by one frame time. Every joint gives its own evidence. The mean over
//! the joints counts, so that one joint that jumps does not decide. The windows before and after give the usual
//! residual.

use glam::{Vec3, Vec3A};

use mocap_scene::math::median::median;

/// The number of frames on either side of a gap. Eight frames are enough to tell a quadratic motion from noise.
const SIDE: usize = 4;

/// The number of frames of a window.
const WINDOW: usize = 2 * SIDE;

/// The degree of the polynomial. A motion over eight frames needs no more.
const DEGREE: usize = 4;
/// The number of dimensions of the residual of a window.
const LEFT: usize = WINDOW - DEGREE - 1;

/// The number of windows on either side that give the usual residual. At 30 frames per second, they cover half a
/// second.
const AROUND: usize = 4;

/// The number of frames from one of these windows to the next. Neighbouring windows share most of their frames, so they
/// would add no evidence.
const STRIDE: usize = 3;
/// The residual that rounding causes, in squares of radians and of fractions of the body.
const ROUNDING: f32 = 1e-9;
/// The smallest evidence of a dropped frame, as the logarithm of a ratio.
const POSSIBLE: f32 = 0.08;
/// If the number of missing frames that is estimated from the joints is in this range, one frame is missing.
const ONE: std::ops::Range<f32> = 0.7..1.5;

/// The residual of a polynomial fit to a window, as linear combinations of the window's seven steps.
#[derive(Clone, Copy)]
struct Contrasts([[f32; WINDOW - 1]; LEFT]);

impl Contrasts {
    /// The orthonormal complement of the polynomials, by the Gram-Schmidt method.
    fn new(times: &[f64; WINDOW]) -> Self {
        let middle = 0.5 * (times[0] + times[WINDOW - 1]);
        let half = 0.5 * (times[WINDOW - 1] - times[0]);
        let power = |degree: usize| times.map(|time| ((time - middle) / half).powi(degree as i32));
        let unit = |at: usize| std::array::from_fn(|other| f64::from(u8::from(other == at)));
        let mut basis: Vec<[f64; WINDOW]> = Vec::with_capacity(WINDOW);
        for mut vector in (0..=DEGREE).map(power).chain((0..WINDOW).map(unit)) {
            for _ in 0..2 {
                for other in &basis {
                    let dot: f64 = vector.iter().zip(other).map(|(a, b)| a * b).sum();
                    vector.iter_mut().zip(other).for_each(|(a, b)| *a -= dot * b);
                }
            }
            let length = vector.iter().map(|value| value * value).sum::<f64>().sqrt();
            if length > 1e-3 && basis.len() < WINDOW {
                basis.push(vector.map(|value| value / length));
            }
        }
        // Each combination is 0 for a constant, so a sum over frames can be written as a sum over steps.
        let over_steps = |row: usize, step: usize| basis[DEGREE + 1 + row][step + 1..].iter().sum::<f64>() as f32;
        Self(std::array::from_fn(|row| {
            std::array::from_fn(|step| over_steps(row, step))
        }))
    }

    #[inline]
    fn of(&self, steps: &[Vec3A; WINDOW - 1]) -> [Vec3A; LEFT] {
        let sum = |row: &[f32; WINDOW - 1]| {
            let mut sum = Vec3A::ZERO;
            for at in 0..WINDOW - 1 {
                sum += row[at] * steps[at];
            }
            sum
        };
        [sum(&self.0[0]), sum(&self.0[1]), sum(&self.0[2])]
    }
}

fn square(left: [Vec3A; LEFT]) -> f32 {
    left.iter().map(|value| value.length_squared()).sum()
}

/// Two hypotheses for the times of a window: unchanged, and with extra time between its fourth and fifth frames.
struct Hypotheses {
    as_is: Contrasts,
    apart: Contrasts,
    /// The dot products of each combination of `as_is` with each combination of `apart`.
    across: [[f32; LEFT]; LEFT],
}

impl Hypotheses {
    fn new(times: &[f64; WINDOW], by: f64) -> Self {
        let moved = std::array::from_fn(|at| times[at] + if at < SIDE { 0.0 } else { by });
        let (as_is, apart) = (Contrasts::new(times), Contrasts::new(&moved));
        // Converts factors of steps back to factors of frames.
        let frames = |row: &[f32; WINDOW - 1]| -> [f32; WINDOW] {
            let step = |at: usize| row.get(at).copied().unwrap_or_default();
            std::array::from_fn(|at| at.checked_sub(1).map_or(0.0, step) - step(at))
        };
        let dot =
            |a: &[f32; WINDOW - 1], b: &[f32; WINDOW - 1]| frames(a).iter().zip(frames(b)).map(|(a, b)| a * b).sum();
        let across = as_is.0.map(|row| apart.0.map(|other| dot(&row, &other)));
        Self { as_is, apart, across }
    }
}

/// The number of windows that are processed together, so that a long motion needs little memory.
const BLOCK: usize = 1000 * STRIDE;

/// The number of additional windows on either side of a block. They give the usual residual and show which window has
/// the most evidence.
const MARGIN: usize = STRIDE * (AROUND + SIDE.div_ceil(STRIDE));

/// The evidence of gaps in the frames of a motion.
pub(super) struct GapEvidence {
    /// The frames before which a frame may be missing, each with its evidence.
    pub(super) dropped: Vec<(usize, f32)>,
    /// For each frame in `asked`, the evidence that the time since the previous frame was longer. `None` near the ends
    /// of the motion.
    pub(super) longer: Vec<Option<f32>>,
}

impl GapEvidence {
    /// Examines frames at `times`. `step` gives one part of the step that leads to a frame. `asked` lists frames in
    /// order, each with the additional time that its step may have.
    pub(super) fn new(
        times: &[f64],
        parts: usize,
        step: impl Fn(usize, usize) -> Vec3,
        asked: &[(usize, f64)],
    ) -> Self {
        let moves = |part: &usize| (1..times.len()).any(|frame| step(frame, *part) != Vec3::ZERO);
        let parts: Vec<usize> = (0..parts).filter(moves).collect();
        let windows = times.len().saturating_sub(WINDOW - 1);
        let mut evidence = Self {
            dropped: Vec::new(),
            longer: vec![None; asked.len()],
        };
        for start in (0..windows).step_by(BLOCK) {
            let end = (start + BLOCK).min(windows);
            let (from, to) = (start.saturating_sub(MARGIN), (end + MARGIN).min(windows));
            let frames = from..to + WINDOW - 1;
            let of_part = |part: &usize| frames.clone().skip(1).map(|frame| step(frame, *part).into()).collect();
            let gaps = Gaps::new(parts.iter().map(of_part).collect(), times[frames.clone()].to_vec());
            let is_inside = |frame: usize| (start + SIDE..end + SIDE).contains(&frame);
            let dropped = gaps.dropped().into_iter().map(|(frame, sure)| (from + frame, sure));
            evidence.dropped.extend(dropped.filter(|(frame, _)| is_inside(*frame)));
            let first = asked.partition_point(|(frame, _)| *frame < start + SIDE);
            let inside = asked.iter().enumerate().skip(first);
            for (index, (frame, by)) in inside.take_while(|(_, (frame, _))| is_inside(*frame)) {
                evidence.longer[index] = gaps.is_longer(frame - from, *by);
            }
        }
        evidence
    }
}

/// The frames of a section of a motion, with their steps and times.
struct Gaps {
    /// The steps of each part that moves: step `n` leads to frame `n + 1`.
    parts: Vec<Vec<Vec3A>>,
    times: Vec<f64>,
    even: Hypotheses,
    /// For each part and window, the residuals of both hypotheses: unchanged, and with a missing frame in the middle.
    left: Vec<Vec<[f32; 2]>>,
    /// For each part and window, the usual residual around it.
    usual: Vec<Vec<f32>>,
}

impl Gaps {
    fn new(parts: Vec<Vec<Vec3A>>, times: Vec<f64>) -> Self {
        let mut gaps = Self {
            parts,
            even: Hypotheses::new(&std::array::from_fn(|at| at as f64), 1.0),
            left: Vec::new(),
            usual: Vec::new(),
            times,
        };
        gaps.left = gaps.measured();
        gaps.usual = gaps.left.iter().map(|left| usual(left)).collect();
        gaps
    }

    /// The number of windows. The middle of window `n` is just before frame `n + 4`.
    fn windows(&self) -> usize {
        self.times.len().saturating_sub(WINDOW - 1)
    }

    fn measured(&self) -> Vec<Vec<[f32; 2]>> {
        let mut left = vec![Vec::with_capacity(self.windows()); self.parts.len()];
        for window in 0..self.windows() {
            self.with(window, 1.0, |both| {
                for (left, part) in left.iter_mut().zip(&self.parts) {
                    let steps = steps(part, window);
                    left.push([square(both.as_is.of(steps)), square(both.apart.of(steps))]);
                }
            });
        }
        left
    }

    /// Calls `with` with the hypotheses of a window.
    fn with<R>(&self, window: usize, by: f64, with: impl FnOnce(&Hypotheses) -> R) -> R {
        let times: [f64; WINDOW] = std::array::from_fn(|at| self.times[window + at]);
        let is_even = by == 1.0 && times[WINDOW - 1] - times[0] == (WINDOW - 1) as f64;
        match is_even {
            true => with(&self.even),
            false => with(&Hypotheses::new(&times, by)),
        }
    }

    /// The evidence that a frame is missing in the middle of a window: the mean over all parts.
    fn score(&self, window: usize) -> f32 {
        let of_part = |(left, usual): (&Vec<[f32; 2]>, &Vec<f32>)| speaks(left[window], usual[window]);
        self.left.iter().zip(&self.usual).map(of_part).sum::<f32>() / self.parts.len().max(1) as f32
    }

    /// The number of frames missing in the middle of a window, estimated from all parts together.
    fn missing(&self, window: usize) -> f32 {
        self.with(window, 1.0, |both| {
            let (mut along, mut whole) = (0.0, 0.0);
            for (part, usual) in self.parts.iter().zip(&self.usual) {
                let steps = steps(part, window);
                let (as_is, apart) = (both.as_is.of(steps), both.apart.of(steps));
                let weight = 1.0 / (usual[window] + square(as_is).min(square(apart)));
                for (row, value) in both.across.iter().zip(as_is) {
                    let would_be = value
                        - row
                            .iter()
                            .zip(apart)
                            .map(|(factor, left)| *factor * left)
                            .sum::<Vec3A>();
                    along += weight * value.dot(would_be);
                    whole += weight * would_be.length_squared();
                }
            }
            along / whole.max(f32::MIN_POSITIVE)
        })
    }

    /// The frames before which a frame may be missing, each with its evidence.
    fn dropped(&self) -> Vec<(usize, f32)> {
        let scores: Vec<f32> = (0..self.windows()).map(|window| self.score(window)).collect();
        let is_highest = |window: usize| {
            let around = &scores[window.saturating_sub(SIDE)..(window + SIDE + 1).min(scores.len())];
            around.iter().all(|other| *other <= scores[window])
        };
        let is_one = |window: usize| ONE.contains(&self.missing(window));
        (0..scores.len())
            .filter(|window| scores[*window] > POSSIBLE && is_highest(*window) && is_one(*window))
            .map(|window| (window + SIDE, scores[window]))
            .collect()
    }

    /// The evidence that the time from the previous frame to this frame was longer by `by` frames. `None` near the ends
    /// of the motion.
    fn is_longer(&self, frame: usize, by: f64) -> Option<f32> {
        let window = frame.checked_sub(SIDE).filter(|window| *window < self.windows())?;
        let sum = self.with(window, by, |both| {
            let of_part = |(part, usual): (&Vec<Vec3A>, &Vec<f32>)| {
                let steps = steps(part, window);
                let left = [square(both.as_is.of(steps)), square(both.apart.of(steps))];
                speaks(left, usual[window])
            };
            self.parts.iter().zip(&self.usual).map(of_part).sum::<f32>()
        });
        Some(sum / self.parts.len().max(1) as f32)
    }
}

/// The steps of a window.
fn steps(part: &[Vec3A], window: usize) -> &[Vec3A; WINDOW - 1] {
    part[window..].first_chunk().expect("a window has all its steps")
}

/// The evidence of a missing frame: the logarithm of the ratio of the residuals without and with the gap.
fn speaks([as_is, apart]: [f32; 2], usual: f32) -> f32 {
    ((as_is + usual) / (apart + usual)).ln()
}

/// The usual residual of a part around each window.
fn usual(left: &[[f32; 2]]) -> Vec<f32> {
    let least: Vec<f32> = left.iter().map(|[as_is, apart]| as_is.min(*apart)).collect();
    let reach = STRIDE * AROUND;
    let around = |window: usize| {
        if window >= reach && window + reach < least.len() {
            return middle_of_nine(std::array::from_fn(|at| least[window - reach + STRIDE * at])) + ROUNDING;
        }
        let centres = (window % STRIDE..least.len()).step_by(STRIDE);
        let mut values: Vec<f32> = centres
            .filter(|window_at| window_at.abs_diff(window) <= reach)
            .map(|window_at| least[window_at])
            .collect();
        median(&mut values).unwrap_or_default() + ROUNDING
    };
    (0..least.len()).map(around).collect()
}

/// The median of nine values, by a minimal sorting network.
pub fn middle_of_nine(mut values: [f32; 2 * AROUND + 1]) -> f32 {
    /// Pairs of the network, which needs no branches: Paeth, Graphics Gems (1990).
    const PAIRS: [[usize; 2]; 19] = [
        [1, 2],
        [4, 5],
        [7, 8],
        [0, 1],
        [3, 4],
        [6, 7],
        [1, 2],
        [4, 5],
        [7, 8],
        [0, 3],
        [5, 8],
        [4, 7],
        [3, 6],
        [1, 4],
        [2, 5],
        [4, 7],
        [4, 2],
        [6, 4],
        [4, 2],
    ];
    for [a, b] in PAIRS {
        let (low, high) = (values[a].min(values[b]), values[a].max(values[b]));
        (values[a], values[b]) = (low, high);
    }
    values[4]
}
