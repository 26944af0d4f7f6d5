//! How a part of a motion moves, in whatever order: how fast each limb turns and how far it points apart, how high the
//! hips are, how fast the body goes and turns. Two dances have few poses in common, and hardly in one order; they have
//! this in common.
//!
//! Of the two limbs of a pair the faster, and the wider, one stands last, so the mirror image moves the same.

use super::clip::SAMPLE_RATE;
use crate::survey::{LIMBS, WIDTH};

/// Numbers of a movement: speeds of limbs, their spreads, then height of the hips, speeds to the side and forward and
/// of turning, and the spread of the height.
pub const NUMBERS: usize = 2 * LIMBS + 5;
/// What is summed of a sample: speeds of limbs, directions, their squares, the four numbers after the limbs, and the
/// square of the height.
const SUMS: usize = LIMBS + 3 * LIMBS + LIMBS + 5;

/// Where the directions of limbs begin among the sums.
const DIRECTIONS: usize = LIMBS;

/// Where the squares of directions begin among the sums.
const SQUARES: usize = 4 * LIMBS;

/// Where the numbers after the limbs begin among the sums.
const OTHERS: usize = 5 * LIMBS;
/// The first limb that is one of a pair: before it are trunk and neck.
const PAIRS: usize = 2;

/// The numbers of a part.
pub type Movement = [f32; NUMBERS];

/// Sums over the samples of a clip up to each, so that a part of any length takes a subtraction.
pub struct Movements {
    sums: Vec<[f64; SUMS]>,
}

impl Movements {
    pub fn new(samples: &[i8]) -> Self {
        let mut sums = Vec::with_capacity(samples.len() / WIDTH + 1);
        let mut sum = [0.0; SUMS];
        sums.push(sum);
        let mut before: Option<[f64; WIDTH]> = None;
        for row in samples.chunks_exact(WIDTH) {
            let row: [f64; WIDTH] = std::array::from_fn(|column| f64::from(row[column]) / 127.0);
            for limb in 0..LIMBS {
                let along = |row: &[f64; WIDTH]| -> [f64; 3] { std::array::from_fn(|axis| row[3 * limb + axis]) };
                let now = along(&row);
                let then = before.as_ref().map_or(now, along);
                let squares = |values: [f64; 3]| values.iter().map(|value| value * value).sum::<f64>();
                sum[limb] += SAMPLE_RATE * squares(std::array::from_fn(|axis| now[axis] - then[axis])).sqrt();
                for axis in 0..3 {
                    sum[DIRECTIONS + 3 * limb + axis] += now[axis];
                }
                sum[SQUARES + limb] += squares(now);
            }
            let others = &row[3 * LIMBS..];
            for (sum, value) in sum[OTHERS..].iter_mut().zip(others) {
                *sum += value.abs();
            }
            sum[SUMS - 1] += others[0] * others[0];
            sums.push(sum);
            before = Some(row);
        }
        Self { sums }
    }

    /// The movement from one sample to a later one, both included.
    pub fn part(&self, first: usize, last: usize) -> Movement {
        let mean = |column: usize| (self.sums[last + 1][column] - self.sums[first][column]) / (last + 1 - first) as f64;
        let mut movement = [0.0; NUMBERS];
        for limb in 0..LIMBS {
            // Between the first sample and the one before it is no movement of the part.
            let speed = self.sums[last + 1][limb] - self.sums[first + 1][limb];
            movement[limb] = (speed / (last - first).max(1) as f64) as f32;
            let squares = (0..3).map(|axis| mean(DIRECTIONS + 3 * limb + axis).powi(2)).sum();
            movement[LIMBS + limb] = deviation(mean(SQUARES + limb), squares);
        }
        for pair in (PAIRS..2 * LIMBS).step_by(2).filter(|pair| *pair != LIMBS) {
            let (one, other) = (movement[pair], movement[pair + 1]);
            (movement[pair], movement[pair + 1]) = (one.min(other), one.max(other));
        }
        for other in 0..4 {
            movement[2 * LIMBS + other] = mean(OTHERS + other) as f32;
        }
        movement[NUMBERS - 1] = deviation(mean(SUMS - 1), mean(OTHERS).powi(2));
        movement
    }
}

/// By the mean of squares and the square of the mean.
fn deviation(squares: f64, square: f64) -> f32 {
    (squares - square).max(0.0).sqrt() as f32
}

/// How far apart movements are: each number by its deviation in what is looked at.
pub struct Scale {
    deviations: [f64; NUMBERS],
}

impl Scale {
    pub fn new<'a>(movements: impl Iterator<Item = &'a Movement> + Clone) -> Self {
        let count = movements.clone().count().max(1) as f64;
        let mut means = [0.0; NUMBERS];
        for movement in movements.clone() {
            for (mean, value) in means.iter_mut().zip(movement) {
                *mean += f64::from(*value) / count;
            }
        }
        let mut squares = [0.0; NUMBERS];
        for movement in movements {
            for ((square, value), mean) in squares.iter_mut().zip(movement).zip(&means) {
                *square += (f64::from(*value) - mean).powi(2) / count;
            }
        }
        Self {
            deviations: squares.map(f64::sqrt),
        }
    }

    /// The distance of two movements by the limbs that both bodies have: the root of the mean square, in deviations.
    pub fn distance(&self, a: &Movement, b: &Movement, limbs: &[bool; LIMBS]) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for number in 0..NUMBERS {
            // Which of a pair a number is of is not known.
            let limb = number % LIMBS;
            let of_limb = number < 2 * LIMBS;
            let has = !of_limb
                || if limb < PAIRS {
                    limbs[limb]
                } else {
                    limbs[limb & !1] && limbs[limb | 1]
                };
            if has && self.deviations[number] > 0.0 {
                sum += (f64::from(a[number] - b[number]) / self.deviations[number]).powi(2);
                count += 1;
            }
        }
        (sum / f64::from(count.max(1))).sqrt()
    }
}
