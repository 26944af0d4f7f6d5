//! Whether a frame is missing between two others.
//!
//! Eight frames are taken, four on either side. A motion is smooth: a polynomial of degree 4 in their true times leaves
//! little over. Where a frame is missing, less is left over once the four later ones are moved by a frame.
//! Each joint says so for itself, and the mean of what they say counts, so that one that jumps alone does not decide.
//! What is left over where nothing is wrong is known from the frames around.

use glam::Vec3;

/// Frames on either side, and the degree of the polynomial.
const SIDE: usize = 4;
const WINDOW: usize = 2 * SIDE;
const DEGREE: usize = 4;
/// What the polynomial leaves of a window has as many dimensions.
const LEFT: usize = WINDOW - DEGREE - 1;
/// Windows on either side, each third one, that say what is usually left over.
const AROUND: isize = 4;
const STRIDE: isize = 3;
/// What is left over by rounding, in squares of radians and of fractions of the body.
const ROUNDING: f32 = 1e-9;
/// The mean of the logarithm of how much less is left over, from which a frame is missing. Of 42 clean cuts of 3 to 8
/// seconds at 30 and 60 frames a second, none has more than 0.22 anywhere, and 142 of 144 frames that were taken out of
/// them while a joint turned by at least 60 degrees a second have more than 0.24.
pub(super) const SURE: f32 = 0.23;
/// From this on it may be: what white noise of 2 degrees leaves of it.
const POSSIBLE: f32 = 0.08;
/// How many frames are missing, as the joints measure it: one.
const ONE: std::ops::Range<f32> = 0.7..1.5;

/// What a polynomial through the times of a window leaves over, as sums over its seven steps.
#[derive(Clone, Copy)]
struct Contrasts([[f32; WINDOW - 1]; LEFT]);

impl Contrasts {
    /// The orthonormal complement of the polynomials, by Gram and Schmidt.
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
        // A sum over the frames is one over the steps, since it is 0 for a constant.
        let over_steps = |row: usize, step: usize| basis[DEGREE + 1 + row][step + 1..].iter().sum::<f64>() as f32;
        Self(std::array::from_fn(|row| {
            std::array::from_fn(|step| over_steps(row, step))
        }))
    }

    fn of(&self, steps: &[&[Vec3]; WINDOW - 1], part: usize) -> [Vec3; LEFT] {
        self.0
            .map(|row| row.iter().zip(steps).map(|(factor, step)| *factor * step[part]).sum())
    }
}

fn square(left: [Vec3; LEFT]) -> f32 {
    left.iter().map(|value| value.length_squared()).sum()
}

/// Two times of the frames of a window: as they are, and with more between the fourth and the fifth.
struct Hypotheses {
    as_is: Contrasts,
    apart: Contrasts,
    /// The products of the contrasts of both.
    across: [[f32; LEFT]; LEFT],
}

impl Hypotheses {
    fn new(times: &[f64; WINDOW], by: f64) -> Self {
        let moved = std::array::from_fn(|at| times[at] + if at < SIDE { 0.0 } else { by });
        let (as_is, apart) = (Contrasts::new(times), Contrasts::new(&moved));
        // From sums over steps back to factors of frames.
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

/// The frames of a motion, each with the step that leads to it and with its time.
pub(super) struct Gaps<'a> {
    /// The step of index `n` leads to frame `n + 1`.
    steps: Vec<&'a [Vec3]>,
    times: Vec<f64>,
    /// The parts of a step that are not always 0.
    parts: Vec<usize>,
    even: Hypotheses,
    /// For each window and part what is left over, as is and with a frame more in the middle.
    left: Vec<[f32; 2]>,
}

impl<'a> Gaps<'a> {
    pub(super) fn new(steps: Vec<&'a [Vec3]>, times: Vec<f64>) -> Self {
        let count = steps.first().map_or(0, |step| step.len());
        let parts = (0..count).filter(|part| steps.iter().any(|step| step[*part] != Vec3::ZERO));
        let mut gaps = Self {
            parts: parts.collect(),
            even: Hypotheses::new(&std::array::from_fn(|at| at as f64), 1.0),
            left: Vec::new(),
            steps,
            times,
        };
        gaps.measure();
        gaps
    }

    /// The windows: that of index `n` has frame `n + 4` behind its middle.
    fn windows(&self) -> usize {
        self.times.len().saturating_sub(WINDOW - 1)
    }

    fn measure(&mut self) {
        let mut left = Vec::with_capacity(self.windows() * self.parts.len());
        for window in 0..self.windows() {
            self.with(window, 1.0, |both, steps| {
                for part in &self.parts {
                    left.push([&both.as_is, &both.apart].map(|contrasts| square(contrasts.of(steps, *part))));
                }
            });
        }
        self.left = left;
    }

    /// Calls `with` with the hypotheses of a window, and its steps.
    fn with<R>(&self, window: usize, by: f64, with: impl FnOnce(&Hypotheses, &[&[Vec3]; WINDOW - 1]) -> R) -> R {
        let steps = std::array::from_fn(|step| self.steps[window + step]);
        let times: [f64; WINDOW] = std::array::from_fn(|at| self.times[window + at]);
        let is_even = by == 1.0 && times[WINDOW - 1] - times[0] == (WINDOW - 1) as f64;
        match is_even {
            true => with(&self.even, &steps),
            false => with(&Hypotheses::new(&times, by), &steps),
        }
    }

    /// What is usually left over of a part around a window.
    fn usual(&self, window: usize, part: usize) -> f32 {
        let mut values = [0.0; 2 * AROUND as usize + 1];
        let mut count = 0;
        for at in -AROUND..=AROUND {
            let other = window
                .checked_add_signed(STRIDE * at)
                .filter(|other| *other < self.windows());
            if let Some([as_is, apart]) = other.map(|other| self.left[other * self.parts.len() + part]) {
                values[count] = as_is.min(apart);
                count += 1;
            }
        }
        *values[..count].select_nth_unstable_by(count / 2, f32::total_cmp).1 + ROUNDING
    }

    /// How much more speaks for a frame missing in the middle of a window than against it.
    fn score(&self, window: usize) -> f32 {
        let parts = self.parts.len();
        let of_part = |part: usize| {
            let usual = self.usual(window, part);
            let [as_is, apart] = self.left[window * parts + part];
            ((as_is + usual) / (apart + usual)).ln()
        };
        (0..parts).map(of_part).sum::<f32>() / parts.max(1) as f32
    }

    /// How many frames are missing in the middle of a window, as all parts measure it together.
    fn missing(&self, window: usize) -> f32 {
        self.with(window, 1.0, |both, steps| {
            let (mut along, mut whole) = (0.0, 0.0);
            for (index, part) in self.parts.iter().enumerate() {
                let (as_is, apart) = (both.as_is.of(steps, *part), both.apart.of(steps, *part));
                let weight = 1.0 / (self.usual(window, index) + square(as_is).min(square(apart)));
                for (row, value) in both.across.iter().zip(as_is) {
                    let would_be = value - row.iter().zip(apart).map(|(factor, left)| *factor * left).sum::<Vec3>();
                    along += weight * value.dot(would_be);
                    whole += weight * would_be.length_squared();
                }
            }
            along / whole.max(f32::MIN_POSITIVE)
        })
    }

    /// The frames before which one may be missing, each with how much speaks for it.
    pub(super) fn dropped(&self) -> Vec<(usize, f32)> {
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

    /// How much speaks for a longer time of the step to a frame, by so many frames; `None` at the ends.
    pub(super) fn is_longer(&self, frame: usize, by: f64) -> Option<f32> {
        let window = frame.checked_sub(SIDE).filter(|window| *window < self.windows())?;
        let sum = self.with(window, by, |both, steps| {
            let of_part = |(index, part): (usize, &usize)| {
                let usual = self.usual(window, index);
                let [as_is, apart] = [&both.as_is, &both.apart].map(|contrasts| square(contrasts.of(steps, *part)));
                ((as_is + usual) / (apart + usual)).ln()
            };
            self.parts.iter().enumerate().map(of_part).sum::<f32>()
        });
        Some(sum / self.parts.len().max(1) as f32)
    }
}
