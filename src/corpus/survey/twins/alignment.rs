//! Finds how two clips fit best: the offset and the pace at which the limbs of both are nearest.

use mocap_scene::math::median::ranked;
use std::ops::RangeInclusive;

use glam::Vec4;

use super::limbs::numbers;
use crate::survey::fingerprint::{Fingerprint, LIMBS};

/// The shortest piece, in samples: two seconds, minus one sample for rounding at the ends.
pub(super) const SHORTEST: usize = 19;

/// The shortest clip that is compared as a whole, in samples: 0.91 s. Shorter parts of different takes match by chance,
/// such as 0.9 s of two runs by one person.
pub(in crate::survey) const SHORTEST_CLIP: usize = 10;

/// The most samples of a whole clip that the other clip may lack: one at each end, which rounding cuts off.
const CUT_BY_ROUNDING: f32 = 2.0;

/// The largest mean distance of limbs of near-duplicates, as a chord of the unit sphere: 1.1 degrees. Fitted by
/// `tools/survey/takes.py`: separate takes of one walk by one person differ by at least 0.028.
const NEAR: f32 = 0.02;

/// The largest distance of limbs in nine tenths of the samples of near-duplicates, as a chord.
const NEAR_MOST: f32 = 2.5 * NEAR;
/// [`NEAR`] and [`NEAR_MOST`] grow by this factor times the mean bend of the paths of limbs, for noise and for the
/// error of linear interpolation between samples.
const OFF_A_LINE: f32 = 0.2;
/// [`NEAR`] and [`NEAR_MOST`] also grow by this factor times the mean bend above [`ERRATIC`]. In motion from video,
/// limbs jump from sample to sample, so copies at another rate differ. Separate takes of such motion are still far
/// apart. Fitted by `tools/survey/takes.py`.
const OFF_IF_ERRATIC: f32 = 0.3;
/// [`OFF_A_LINE`] for clips shorter than [`SHORTEST`]. For such clips, erratic motion adds nothing, because runs of one
/// person differ by less in a second. Fitted by `tools/survey/takes.py --seconds 1.2`.
const SHORT_OFF_A_LINE: f32 = 0.1;
/// The mean bend above which a motion is erratic. Running has half of this value.
const ERRATIC: f32 = 0.2;

/// The least movement per limb in the compared part, as a sum of chords of the unit sphere. With less movement, any two
/// standing figures would match.
const MOVES: f32 = 0.2;
/// The least movement in clips shorter than [`SHORTEST`]: half as much in half the time.
const SHORT_MOVES: f32 = 0.1;
/// The time step in which movement is summed, in samples: half a second, in which slow limbs move by more than
/// [`GRAIN`].
const MOVE: usize = 5;
/// The least change of a direction that counts as movement, as a chord: the quantization step of a byte.
const GRAIN: f32 = 0.02;
/// The fewest limbs that two bodies must share: half of all limbs.
const LEAST_LIMBS: f32 = 5.0;

/// The slowest pace at which clips are compared, as a factor: 10 % slower.
const SLOWEST: f32 = 0.9;
const PACES: u8 = 11;

/// The step between paces in the first round, as a factor. The second round has half of this step.
const PACE_STEP: f32 = 0.02;
/// The largest offset between a moment of one clip and the matching moment of the other clip, in samples.
const AROUND: i8 = 4;

/// The largest offset between the beginnings of two clips, in samples, at which the clips are also compared from their
/// beginnings: one second.
const BEGIN_TOGETHER: f32 = 10.0;
const AROUND_BEGINNING: i8 = 2;

/// The number of samples in the first comparison, which rejects most pairs.
const FEW: usize = 16;

/// The least distance between the samples of the first comparison, so that they cover more than one moment.
const LEAST_STRIDE: usize = 3;

/// The largest error of the best timing that the first comparison tries, in samples: half a sample, with a margin.
/// Limbs move in this time, which adds to the allowed distance.
const OFF_AT_FIRST: f32 = 1.5;

/// A wrong pace adds to the error of the best timing. This is the added error for each sample of the overlap, in
/// samples: twice the error of half a step of pace.
const OFF_BY_PACE: f32 = 0.005;

/// The number of groups of four limbs.
const QUADS: usize = LIMBS.div_ceil(4);
/// The three coordinates of all limbs.
type Row = [[Vec4; QUADS]; 3];

/// The samples of a clip as floating-point numbers.
pub(super) struct Track {
    rows: Vec<Row>,
    /// 1 for each limb that the body has, and 0 for others.
    has: [Vec4; QUADS],
    /// The mean movement of limbs up to each sample.
    moved: Vec<f32>,
    /// The mean second difference of samples: twice the distance of a sample from the line between its neighbours.
    bend: f32,
}

impl Track {
    pub(super) fn new(fingerprint: &Fingerprint, mirrored: bool) -> Self {
        let rows: Vec<Row> = (0..fingerprint.samples())
            .map(|sample| {
                let mut row = [[[0.0; 4]; QUADS]; 3];
                for (number, limb) in numbers(fingerprint.limbs(sample), mirrored).into_iter().enumerate() {
                    for axis in 0..3 {
                        row[axis][number / 4][number % 4] = limb[axis];
                    }
                }
                row.map(|axis| axis.map(Vec4::from_array))
            })
            .collect();
        let mut sum = 0.0;
        let moved = (0..rows.len()).map(|sample| {
            sum += step(&rows[sample.saturating_sub(MOVE)], &rows[sample]) / sample.clamp(1, MOVE) as f32;
            sum
        });
        Self {
            moved: moved.collect(),
            bend: bend(&rows),
            has: has(&rows),
            rows,
        }
    }

    pub(super) fn samples(&self) -> usize {
        self.rows.len()
    }
}

/// Which limbs the body has. The direction of a limb is 0 if one of its bones is missing.
fn has(rows: &[Row]) -> [Vec4; QUADS] {
    let mut has = [Vec4::ZERO; QUADS];
    for quad in 0..QUADS {
        for row in rows {
            let squares = row.iter().map(|axis| axis[quad] * axis[quad]).sum::<Vec4>();
            has[quad] = has[quad].max(Vec4::select(squares.cmpgt(Vec4::ZERO), Vec4::ONE, Vec4::ZERO));
        }
    }
    has
}

/// The mean movement of limbs between two samples.
fn step(before: &Row, after: &Row) -> f32 {
    let mut sum = 0.0;
    for quad in 0..QUADS {
        for chord in chords(|axis| before[axis][quad] - after[axis][quad]) {
            sum += if chord > GRAIN { chord } else { 0.0 };
        }
    }
    sum / LIMBS as f32
}

/// The mean second difference of the directions of limbs.
fn bend(rows: &[Row]) -> f32 {
    let mut sum = 0.0;
    for ((before, here), after) in rows.iter().zip(rows.iter().skip(1)).zip(rows.iter().skip(2)) {
        for quad in 0..QUADS {
            let off = |axis: usize| before[axis][quad] - 2.0 * here[axis][quad] + after[axis][quad];
            sum += chords(off).iter().sum::<f32>();
        }
    }
    sum / (rows.len().saturating_sub(2).max(1) * LIMBS) as f32
}

/// The lengths of the differences of four limbs.
#[inline(always)]
fn chords(off: impl Fn(usize) -> Vec4) -> [f32; 4] {
    let (x, y, z) = (off(0), off(1), off(2));
    let squares = (x * x + y * y + z * z).to_array();
    [
        squares[0].sqrt(),
        squares[1].sqrt(),
        squares[2].sqrt(),
        squares[3].sqrt(),
    ]
}

/// A moment that two clips may have in common, as a sample of each.
#[derive(Clone, Copy)]
pub(super) struct Moments {
    pub(super) first: f32,
    pub(super) second: f32,
}

impl Moments {
    /// Chains two matches: `self` matches clip A to clip B at `pace`, and `later` matches clip B to clip C. Returns a
    /// match of A to C.
    pub(super) fn through(self, pace: f32, later: Self) -> Self {
        Self {
            first: self.first + pace * (later.first - self.second),
            second: later.second,
        }
    }
}

/// How two clips fit best.
pub(super) struct Alignment {
    /// Seconds of the first clip per second of the second clip.
    pub(super) pace: f32,
    /// The middle of the shared part.
    pub(super) at: Moments,
    /// The number of samples of the first clip that the second clip covers.
    pub(super) overlap: f32,
}

impl Alignment {
    /// Tries offsets around a moment and paces around 1, first coarse and then fine. Returns `None` if the clips are
    /// far apart.
    pub(super) fn best(a: &Track, b: &Track, at: Moments, around: f32) -> Option<Self> {
        let both = Both::new(a, b)?;
        let mut coarse = Best::default();
        for number in 0..PACES {
            let pace = around * (SLOWEST + PACE_STEP * f32::from(number));
            let start = at.first - pace * at.second;
            for shift in -AROUND..=AROUND {
                coarse.consider(&both, [pace, start + f32::from(shift)], true);
            }
            if (at.first - at.second).abs() <= BEGIN_TOGETHER {
                for shift in -AROUND_BEGINNING..=AROUND_BEGINNING {
                    coarse.consider(&both, [pace, f32::from(shift)], true);
                }
            }
        }
        let [pace, start] = coarse.found?.1;
        let mut fine = Best::default();
        for pace_step in -2_i8..=2 {
            for start_step in -5_i8..=5 {
                let timing = [
                    pace + 0.5 * PACE_STEP * f32::from(pace_step),
                    start + 0.2 * f32::from(start_step),
                ];
                fine.consider(&both, timing, false);
            }
        }
        let timing = fine.found?.1;
        let overlap = both.overlap(timing)?;
        let most = NEAR_MOST + 2.0 * both.off_a_line();
        let middle = 0.5 * (overlap.start() + overlap.end()) as f32;
        (both.most(timing, &overlap) < most).then(|| Self {
            at: Moments {
                first: timing[1] + timing[0] * middle,
                second: middle,
            },
            pace: timing[0],
            overlap: (overlap.end() + 1 - overlap.start()) as f32 * timing[0],
        })
    }
}

/// A pace, and the sample of the first clip at which the second clip begins.
type Timing = [f32; 2];

/// The timing with the least distance so far.
#[derive(Default)]
struct Best {
    found: Option<(f32, Timing)>,
}

impl Best {
    /// Compares clips at a timing, with `at_first` only at a few samples. Discards timings that are too far apart for
    /// near-duplicates.
    fn consider(&mut self, both: &Both<'_>, timing: Timing, at_first: bool) {
        let Some(overlap) = both.overlap(timing) else { return };
        let samples = overlap.end() + 1 - overlap.start();
        let (stride, off) = match at_first {
            true => {
                let steps = OFF_AT_FIRST + OFF_BY_PACE * samples as f32;
                (LEAST_STRIDE.max(samples / FEW), steps * both.step(&overlap))
            }
            false => (1, 0.0),
        };
        let least = self.found.map_or(f32::INFINITY, |(least, _)| least);
        let near = NEAR + both.off_a_line() + off;
        let mean = both.mean(timing, overlap, stride, least.min(near));
        if let Some(mean) = mean {
            self.found = Some((mean, timing));
        }
    }
}

struct Both<'a> {
    a: &'a Track,
    b: &'a Track,
    /// The weight of each limb in the mean distance. Limbs that one body lacks have weight 0.
    weights: [Vec4; QUADS],
}

impl<'a> Both<'a> {
    /// Returns `None` if the bodies share too few limbs.
    fn new(a: &'a Track, b: &'a Track) -> Option<Self> {
        let has: [Vec4; QUADS] = std::array::from_fn(|quad| a.has[quad] * b.has[quad]);
        let count: f32 = has.iter().map(|quad| quad.element_sum()).sum();
        (count >= LEAST_LIMBS).then(|| Self {
            a,
            b,
            weights: has.map(|quad| quad / count),
        })
    }

    /// The samples of the second clip that overlap the first clip; `None` if they are too few or nothing moves.
    fn overlap(&self, [pace, start]: Timing) -> Option<RangeInclusive<usize>> {
        let last = self.a.samples() as f32 - 1.0;
        let from = (-start / pace).ceil().max(0.0) as usize;
        let to = (((last - start) / pace).floor() as isize).min(self.b.samples() as isize - 1);
        let to = usize::try_from(to).ok()?;
        let samples = (to + 1).checked_sub(from)?;
        // A piece lies within one of the clips, or at the ends of both clips with at least the shortest length. A
        // shorter part matches by chance, unless it is the whole of both clips.
        let least = match samples {
            SHORTEST.. => MOVES,
            _ if self.is_whole(samples, pace) => SHORT_MOVES,
            _ => return None,
        };
        (self.b.moved[to] - self.b.moved[from] >= least).then_some(from..=to)
    }

    /// Whether some samples of the second clip cover both clips, and the clips are long enough.
    fn is_whole(&self, samples: usize, pace: f32) -> bool {
        let shorter = self.a.samples().min(self.b.samples()).min(samples + 1);
        let longer = self.a.samples().max((self.b.samples() as f32 * pace).round() as usize);
        shorter >= SHORTEST_CLIP && samples as f32 * pace + CUT_BY_ROUNDING >= longer as f32
    }

    /// The distance of limbs that different sampling times cause between two copies of one motion.
    fn off_a_line(&self) -> f32 {
        let bend = 0.5 * (self.a.bend + self.b.bend);
        match self.a.samples().min(self.b.samples()) {
            SHORTEST.. => OFF_A_LINE * bend + OFF_IF_ERRATIC * (bend - ERRATIC).max(0.0),
            _ => SHORT_OFF_A_LINE * bend,
        }
    }

    /// The mean movement of limbs per sample.
    fn step(&self, overlap: &RangeInclusive<usize>) -> f32 {
        let moved = self.b.moved[*overlap.end()] - self.b.moved[*overlap.start()];
        moved / (overlap.end() + 1 - overlap.start()) as f32
    }

    /// The mean distance of limbs, if the distance is less than `most`.
    fn mean(&self, timing: Timing, overlap: RangeInclusive<usize>, stride: usize, most: f32) -> Option<f32> {
        let count = (overlap.end() - overlap.start()) / stride + 1;
        let (mut sum, most) = (0.0, most * count as f32);
        for sample in overlap.step_by(stride) {
            sum += self.distance(timing, sample);
            if sum >= most {
                return None;
            }
        }
        Some(sum / count as f32)
    }

    /// The distance that nine tenths of the samples do not exceed.
    fn most(&self, timing: Timing, overlap: &RangeInclusive<usize>) -> f32 {
        let mut distances: Vec<f32> = overlap.clone().map(|sample| self.distance(timing, sample)).collect();
        let nine_tenths = distances.len() * 9 / 10;
        ranked(&mut distances, nine_tenths).unwrap_or_default()
    }

    /// The mean distance of limbs between a sample of the second clip and the first clip at the same time.
    #[inline(always)]
    fn distance(&self, [pace, start]: Timing, sample: usize) -> f32 {
        let last = self.a.samples() - 1;
        let time = (start + pace * sample as f32).clamp(0.0, last as f32);
        let early = time as usize;
        let fraction = time - early as f32;
        let (early, late) = (&self.a.rows[early], &self.a.rows[(early + 1).min(last)]);
        let other = &self.b.rows[sample];
        let mut sum = 0.0;
        for quad in 0..QUADS {
            let off = chords(|axis| {
                let (early, late) = (early[axis][quad], late[axis][quad]);
                early + (late - early) * fraction - other[axis][quad]
            });
            sum += Vec4::from_array(off).dot(self.weights[quad]);
        }
        sum
    }
}
