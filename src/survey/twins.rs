//! Clips that repeat others: the same bytes, the same motion, mirrored, retimed by up to a tenth, at another rate, on
//! another skeleton, or as a piece of at least two seconds.
//!
//! Each clip has samples of where ten limbs point ([`super::fingerprint`]). Moments of it (what the limbs do from
//! 0.4 s before to 0.4 s after) are hashed by the signs of random projections; moments of one hash that stand at one
//! offset in two clips vote for it. What has votes is aligned: the offset, the pace and the reflection with the least
//! distance of limbs win, and are a twin where that distance is small all along and the limbs move. Moments in which
//! hardly anything moves have no hash, and of a hash with many moments the first are looked up, so that the cost grows
//! with the number of clips and not with its square.

use std::collections::HashMap;

use super::fingerprint::{Fingerprint, LIMBS, RATE, WIDTH};
use crate::math::spread::spread;

/// How a clip repeats another, the strongest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Reason {
    Bytes,
    Motion,
    Rate,
    Skeleton,
    Retimed,
    Mirrored,
    Piece,
}

impl Reason {
    pub(super) const fn as_str(self) -> &'static str {
        match self {
            Self::Bytes => "bytes",
            Self::Motion => "motion",
            Self::Rate => "rate",
            Self::Skeleton => "skeleton",
            Self::Retimed => "retimed",
            Self::Mirrored => "mirrored",
            Self::Piece => "piece",
        }
    }
}

/// What is compared of a clip.
pub(super) struct Candidate<'a> {
    pub(super) fingerprint: &'a Fingerprint,
    pub(super) sha256: &'a str,
    pub(super) clip: &'a str,
    pub(super) skeleton: &'a str,
    pub(super) rate: f64,
    pub(super) size: f64,
}

/// Two clips of which one repeats the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pair {
    pub(super) first: usize,
    pub(super) second: usize,
    pub(super) reason: Reason,
}

/// Bits of a hash of a moment.
const BITS: usize = 24;
/// Signs of a moment that are least certain, of which one or two are also looked up as their opposite.
const UNCERTAIN: usize = 5;
/// Samples before and after that belong to a moment: 0.4 s.
const REACH: usize = 4;
/// Moments of one hash that are looked up at most, and that vote.
const MOST_OF_HASH: usize = 24;
/// The largest mean distance of limbs in the second around two moments of clips that are aligned, as a chord: that of
/// twins, and what a tenth of pace adds.
const NEAR_MOMENT: f32 = 0.1;
/// What the time between samples adds to the distance of twins, as a fraction of a step from one to the next: half of
/// one where whole samples are compared, and where values between them are taken what a line misses of a curve.
const HALF_A_STEP: f32 = 0.5;
const OFF_A_LINE: f32 = 0.12;
/// That second, in samples on each side.
const HALF_SECOND: isize = 5;
/// Bits of a hash that find it in the list of all moments.
const LEADING: usize = 20;
/// How far limbs must move within a moment, on average, as a chord: others are like any that stand.
const MOMENT_MOVES: f32 = 0.03;
/// Votes that make two clips worth aligning, and how many such clips are aligned with one at most.
const VOTES: u16 = 3;
const MOST_ALIGNED: usize = 24;
/// The shortest piece, in samples: two seconds, less a sample for the rounding at its ends.
const SHORTEST: usize = 19;
/// The largest mean distance of limbs of twins, as a chord: 3.2 degrees; and the largest of nine tenths of samples.
const NEAR: f32 = 0.056;
const NEAR_MOST: f32 = 0.11;
/// How far the limbs must move in what is compared, each on average, as a sum of chords: one that stands is like any
/// other that stands.
const MOVES: f32 = 0.35;
/// Paces at which clips are compared: a tenth slower to a tenth faster.
const PACES: [f32; 21] = {
    let mut paces = [0.0; 21];
    let mut index = 0;
    while index < 21 {
        paces[index] = 0.9 + 0.01 * index as f32;
        index += 1;
    }
    paces
};

/// The limb on the other side of each.
const OTHER_SIDE: [usize; LIMBS] = [0, 1, 3, 2, 5, 4, 7, 6, 9, 8];

/// All pairs of twins: each clip with those before it.
pub(super) fn pairs(clips: &[Candidate<'_>]) -> Vec<Pair> {
    let mut pairs = Vec::new();
    // Copies of a file are known by their bytes, and one of them stands for all.
    let mut by_bytes: HashMap<(&str, &str), usize> = HashMap::new();
    let mut distinct = Vec::new();
    for (index, clip) in clips.iter().enumerate() {
        if clip.sha256.is_empty() {
            distinct.push(index);
            continue;
        }
        match by_bytes.entry((clip.sha256, clip.clip)) {
            std::collections::hash_map::Entry::Occupied(first) => pairs.push(Pair {
                first: *first.get(),
                second: index,
                reason: Reason::Bytes,
            }),
            std::collections::hash_map::Entry::Vacant(place) => {
                place.insert(index);
                distinct.push(index);
            }
        }
    }
    let index = Index::new(clips, &distinct);
    let found = spread(&distinct, |&second| {
        let candidates = index.candidates(clips, second).into_iter();
        let pairs = candidates.filter_map(|(first, offset, mirrored)| {
            let reason = compare(&clips[first], &clips[second], offset, mirrored)?;
            Some(Pair { first, second, reason })
        });
        pairs.collect::<Vec<_>>()
    });
    pairs.extend(found.into_iter().flatten());
    pairs
}

/// A moment of a clip.
#[derive(Clone, Copy)]
struct Moment {
    hash: u32,
    clip: u32,
    sample: u32,
}

/// Moments by their hashes.
struct Index {
    /// For each number of a moment its part in each bit.
    projections: Vec<[f32; BITS]>,
    mean: Vec<f32>,
    /// By hash, clip and sample.
    moments: Vec<Moment>,
    /// Where the moments begin whose hash has these leading bits.
    starts: Vec<u32>,
}

impl Index {
    fn new(clips: &[Candidate<'_>], distinct: &[usize]) -> Self {
        let mut index = Self {
            projections: projections(),
            mean: mean(clips, distinct),
            moments: Vec::new(),
            starts: Vec::new(),
        };
        let of_clips = spread(distinct, |&clip| {
            let fingerprint = clips[clip].fingerprint;
            let samples = REACH..fingerprint.samples().saturating_sub(REACH);
            let moments = samples.filter_map(|sample| {
                let along = index.project(fingerprint, sample, false, false)?;
                Some(Moment {
                    hash: hash(&along),
                    clip: clip as u32,
                    sample: sample as u32,
                })
            });
            moments.collect::<Vec<_>>()
        });
        index.moments = of_clips.into_iter().flatten().collect();
        index
            .moments
            .sort_unstable_by_key(|moment| (moment.hash, moment.clip, moment.sample));
        let mut starts = vec![0; (1 << LEADING) + 1];
        for moment in &index.moments {
            starts[leading(moment.hash) + 1] += 1;
        }
        for bits in 0..1 << LEADING {
            starts[bits + 1] += starts[bits];
        }
        index.starts = starts;
        index
    }

    /// The first moments of a hash.
    fn of_hash(&self, hash: u32) -> impl Iterator<Item = &Moment> {
        let [from, to] = [0, 1].map(|next| self.starts[leading(hash) + next] as usize);
        let same = self.moments[from..to].iter().filter(move |moment| moment.hash == hash);
        same.take(MOST_OF_HASH)
    }

    /// A moment along all projections, or that half a sample later; `None` where hardly anything moves.
    fn project(&self, fingerprint: &Fingerprint, sample: usize, later: bool, mirrored: bool) -> Option<[f32; BITS]> {
        let mut values = [0.0; 9 * LIMBS];
        for (part, at) in [sample - REACH, sample, sample + REACH].into_iter().enumerate() {
            let row = fingerprint.limbs(at);
            let next = fingerprint.limbs(if later { at + 1 } else { at });
            for limb in 0..LIMBS {
                for axis in 0..3 {
                    let both = limb_value(row, limb, axis, mirrored) + limb_value(next, limb, axis, mirrored);
                    values[3 * LIMBS * part + 3 * limb + axis] = 0.5 * both - self.mean[3 * limb + axis];
                }
            }
        }
        let moved = |limb: usize| {
            let chord = |a: usize, b: usize| {
                let off =
                    |axis: usize| values[3 * LIMBS * a + 3 * limb + axis] - values[3 * LIMBS * b + 3 * limb + axis];
                (0..3).map(|axis| off(axis).powi(2)).sum::<f32>().sqrt()
            };
            chord(0, 1) + chord(1, 2)
        };
        if (0..LIMBS).map(moved).sum::<f32>() / (LIMBS as f32) < MOMENT_MOVES {
            return None;
        }
        let mut along = [0.0; BITS];
        for (projection, value) in self.projections.iter().zip(values) {
            for (sum, factor) in along.iter_mut().zip(projection) {
                *sum += factor * value;
            }
        }
        Some(along)
    }

    /// Clips before one that may be its twins, each with an offset in samples and whether it is mirrored.
    fn candidates(&self, clips: &[Candidate<'_>], clip: usize) -> Vec<(usize, i32, bool)> {
        // How many moments vote for an offset, and one of them.
        let mut votes: HashMap<(u32, i32, bool), (u16, [u32; 2])> = HashMap::new();
        let fingerprint = clips[clip].fingerprint;
        let last = fingerprint.samples().saturating_sub(REACH + 1);
        for mirrored in [false, true] {
            // Each other sample, and half a sample later: clips that begin between two samples of another are met.
            for (sample, later) in (REACH..last)
                .step_by(2)
                .flat_map(|sample| [(sample, false), (sample, true)])
            {
                let Some(along) = self.project(fingerprint, sample, later, mirrored) else {
                    continue;
                };
                let moments = near_hashes(&along).into_iter().flat_map(|hash| self.of_hash(hash));
                for moment in moments.filter(|moment| (moment.clip as usize) < clip) {
                    // Retimed clips drift apart by a tenth: half a second of offset is one.
                    let offset = (moment.sample as i32 - sample as i32).div_euclid(5);
                    for offset in [offset, offset + 1] {
                        let found = votes.entry((moment.clip, offset, mirrored)).or_default();
                        *found = (found.0.saturating_add(1), [moment.sample, sample as u32]);
                    }
                }
            }
        }
        let mut best: HashMap<(u32, bool), (u16, i32, [u32; 2])> = HashMap::new();
        let voted = votes.into_iter().filter(|(_, (count, _))| *count >= VOTES);
        for ((other, offset, mirrored), (count, moments)) in voted {
            let entry = best.entry((other, mirrored)).or_default();
            *entry = (*entry).max((count, -offset, moments));
        }
        let mut found: Vec<_> = best.into_iter().collect();
        found.sort_by_key(|((other, mirrored), (count, ..))| (std::cmp::Reverse(*count), *other, *mirrored));
        let found = found.into_iter().filter(|((other, mirrored), (_, _, moments))| {
            are_near((clips[*other as usize].fingerprint, fingerprint), *moments, *mirrored)
        });
        found
            .take(MOST_ALIGNED)
            .map(|((other, mirrored), (_, offset, _))| (other as usize, -offset * 5, mirrored))
            .collect()
    }
}

fn leading(hash: u32) -> usize {
    (hash >> (BITS - LEADING)) as usize
}

/// Whether limbs are near each other in the second around two moments, where one of them is a little earlier or later.
fn are_near((a, b): (&Fingerprint, &Fingerprint), [at, sample]: [u32; 2], mirrored: bool) -> bool {
    let shifted = |shift: isize| {
        let row = |clip: &Fingerprint, sample: isize| usize::try_from(sample).ok().filter(|at| *at < clip.samples());
        let pair = |time: isize| {
            let early = row(a, at as isize + time + shift)?;
            Some(row_distance(
                a.limbs(early),
                b.limbs(row(b, sample as isize + time)?),
                mirrored,
            ))
        };
        let distances: Vec<f32> = (-HALF_SECOND..=HALF_SECOND).step_by(2).filter_map(pair).collect();
        distances.iter().sum::<f32>() / distances.len().max(1) as f32
    };
    let from = (sample as usize).saturating_sub(HALF_SECOND as usize);
    let to = (sample as usize + HALF_SECOND as usize).min(b.samples() - 1);
    let steps: f32 = (from..to)
        .map(|at| row_distance(b.limbs(at), b.limbs(at + 1), false))
        .sum();
    let near = NEAR_MOMENT + HALF_A_STEP * steps / (to - from).max(1) as f32;
    (-2..=2).any(|shift| shifted(shift) < near)
}

/// The mean distance of limbs of two samples, of which the second may be mirrored.
fn row_distance(a: &[i8], b: &[i8], mirrored: bool) -> f32 {
    let limb = |limb: usize| {
        let off = |axis: usize| f32::from(a[3 * limb + axis]) / 127.0 - limb_value(b, limb, axis, mirrored);
        (0..3).map(|axis| off(axis).powi(2)).sum::<f32>().sqrt()
    };
    (0..LIMBS).map(limb).sum::<f32>() / LIMBS as f32
}

/// The signs of a moment along all projections.
fn hash(along: &[f32; BITS]) -> u32 {
    along.iter().fold(0, |hash, value| hash << 1 | u32::from(*value > 0.0))
}

/// The hash of a moment, and those in which one or two of the least certain signs are the other.
fn near_hashes(along: &[f32; BITS]) -> Vec<u32> {
    let mut bits: Vec<usize> = (0..BITS).collect();
    bits.sort_by(|a, b| along[*a].abs().total_cmp(&along[*b].abs()));
    let flips: Vec<u32> = bits[..UNCERTAIN].iter().map(|bit| 1 << (BITS - 1 - bit)).collect();
    let hash = hash(along);
    let mut hashes = vec![hash];
    for (number, a) in flips.iter().enumerate() {
        hashes.push(hash ^ a);
        hashes.extend(flips[..number].iter().map(|b| hash ^ a ^ b));
    }
    hashes
}

/// The mean of all limbs of the corpus, over at most some ten thousand samples.
fn mean(clips: &[Candidate<'_>], distinct: &[usize]) -> Vec<f32> {
    let mut sums = vec![0.0_f64; 3 * LIMBS];
    let mut count = 0.0;
    for &clip in distinct.iter().step_by(distinct.len().div_ceil(2000).max(1)) {
        let fingerprint = clips[clip].fingerprint;
        for sample in (0..fingerprint.samples()).step_by(10) {
            // With its mirror image, so that hashes of mirrored clips agree.
            for mirrored in [false, true] {
                count += 1.0;
                for (place, sum) in sums.iter_mut().enumerate() {
                    *sum += f64::from(limb_value(fingerprint.limbs(sample), place / 3, place % 3, mirrored));
                }
            }
        }
    }
    sums.into_iter()
        .map(|sum| (sum / f64::max(count, 1.0)) as f32)
        .collect()
}

/// Fixed random directions: xorshift, by the sum of four uniform numbers.
fn projections() -> Vec<[f32; BITS]> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut uniform = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as f32 / (1 << 24) as f32 - 0.5
    };
    let mut number = || (0..4).map(|_| uniform()).sum::<f32>();
    (0..9 * LIMBS).map(|_| std::array::from_fn(|_| number())).collect()
}

/// The numbers of a sample with left and right exchanged.
pub(crate) fn mirrored_row(row: &[i8]) -> [i8; WIDTH] {
    std::array::from_fn(|place| match (place / 3, place % 3) {
        (limb @ 0..LIMBS, 0) => -row[3 * OTHER_SIDE[limb]],
        (limb @ 0..LIMBS, axis) => row[3 * OTHER_SIDE[limb] + axis],
        // Steps to the side, and turning.
        _ if place == 3 * LIMBS + 1 || place == 3 * LIMBS + 3 => -row[place],
        _ => row[place],
    })
}

/// A coordinate of where a limb points; mirrored, that of the limb on the other side, seen in a mirror.
fn limb_value(row: &[i8], limb: usize, axis: usize, mirrored: bool) -> f32 {
    let from = if mirrored { OTHER_SIDE[limb] } else { limb };
    let sign = if mirrored && axis == 0 { -1.0 } else { 1.0 };
    sign * f32::from(row[3 * from + axis]) / 127.0
}

/// Why a clip is a twin of another, if it is. `offset` is about where it begins in the other, in samples.
fn compare(first: &Candidate<'_>, second: &Candidate<'_>, offset: i32, mirrored: bool) -> Option<Reason> {
    let (a, b) = (first.fingerprint, second.fingerprint);
    let same_skeleton = first.skeleton == second.skeleton;
    // What has no body is compared joint by joint, and has no left and right.
    if a.is_body != b.is_body || !a.is_body && (mirrored || !same_skeleton) {
        return None;
    }
    let found = best_alignment(a, b, offset, mirrored)?;
    let longer = a.samples().max(b.samples()) as f32;
    // Samples of the second clip are stretched by its pace.
    let shorter_by_pace = (b.samples() as f32 * found.pace).min(a.samples() as f32);
    let whole = found.overlap + 4.0 >= longer.min(a.samples() as f32).max(b.samples() as f32 * found.pace)
        || found.overlap + 4.0 >= 0.97 * longer && shorter_by_pace + 4.0 >= 0.97 * longer;
    let same_rate = (first.rate - second.rate).abs() < 0.01 * first.rate;
    let same_size = (first.size - second.size).abs() < 0.01 * first.size;
    Some(match () {
        () if !whole => Reason::Piece,
        () if mirrored => Reason::Mirrored,
        () if (found.pace - 1.0).abs() > 0.015 => Reason::Retimed,
        () if !same_skeleton || !same_size => Reason::Skeleton,
        () if !same_rate => Reason::Rate,
        () => Reason::Motion,
    })
}

/// How two clips fit best.
struct Alignment {
    /// Seconds of the first in one second of the second.
    pace: f32,
    /// Samples of the first that are covered.
    overlap: f32,
}

/// Tries paces and offsets around where hashes agree, coarse and then fine.
fn best_alignment(a: &Fingerprint, b: &Fingerprint, offset: i32, mirrored: bool) -> Option<Alignment> {
    let mut best: Option<(f32, f32, f32)> = None;
    let mut consider = |pace: f32, start: f32, stride: usize| {
        if let Some(Overlap { mean, .. }) = distance(a, b, pace, start, mirrored, stride)
            && best.is_none_or(|(least, _, _)| mean < least)
        {
            best = Some((mean, pace, start));
        }
    };
    let middle = b.samples() as f32 / 2.0;
    for pace in PACES.into_iter().step_by(2) {
        // The offset is that of the middle, where votes of all paces meet.
        let start = offset as f32 + middle * (1.0 - pace);
        for shift in -12..=12 {
            consider(pace, start + shift as f32, 3);
        }
        if offset.abs() <= 10 {
            for shift in -2..=2 {
                consider(pace, shift as f32, 3);
            }
        }
    }
    let (_, pace, start) = best?;
    best = None;
    let mut consider = |pace: f32, start: f32| {
        if let Some(Overlap { mean, .. }) = distance(a, b, pace, start, mirrored, 1)
            && best.is_none_or(|(least, _, _)| mean < least)
        {
            best = Some((mean, pace, start));
        }
    };
    for pace_step in -2..=2 {
        for start_step in -5..=5 {
            consider(pace + 0.01 * pace_step as f32, start + 0.2 * start_step as f32);
        }
    }
    let (mean, pace, start) = best?;
    let Overlap {
        most, overlap, step, ..
    } = distance(a, b, pace, start, mirrored, 1)?;
    let off = OFF_A_LINE * step;
    (mean < NEAR + off && most < NEAR_MOST + 2.0 * off).then_some(Alignment {
        pace,
        overlap: overlap * pace,
    })
}

/// How two clips differ where they overlap.
struct Overlap {
    /// The mean distance of limbs, and that which nine tenths of the samples keep below.
    mean: f32,
    most: f32,
    /// The samples of the second that overlap.
    overlap: f32,
    /// How far its limbs move from one sample to the next, on average.
    step: f32,
}

/// How two clips differ at a pace and from a start on; `None` where they overlap too little, or nothing moves.
fn distance(a: &Fingerprint, b: &Fingerprint, pace: f32, start: f32, mirrored: bool, stride: usize) -> Option<Overlap> {
    let last = a.samples() as f32 - 1.0;
    let from = (-start / pace).ceil().max(0.0) as usize;
    let to = (((last - start) / pace).floor() as isize).min(b.samples() as isize - 1);
    let to = usize::try_from(to).ok()?;
    // A piece lies within one of the two, or is at least as long as the shortest piece at an end of both.
    if to + 1 < from + SHORTEST {
        return None;
    }
    let mut distances = Vec::with_capacity((to - from) / stride + 1);
    let mut moved = 0.0;
    let mut before: Option<&[i8]> = None;
    for sample in (from..=to).step_by(stride) {
        let time = (start + pace * sample as f32).clamp(0.0, last);
        let (early, fraction) = (time.floor() as usize, time.fract());
        let late = (early + 1).min(a.samples() - 1);
        let (early, late, other) = (a.limbs(early), a.limbs(late), b.limbs(sample));
        let mut sum = 0.0;
        for limb in 0..LIMBS {
            let mut squares = 0.0;
            for axis in 0..3 {
                let place = 3 * limb + axis;
                let between = f32::from(early[place]) * (1.0 - fraction) + f32::from(late[place]) * fraction;
                let off = between / 127.0 - limb_value(other, limb, axis, mirrored);
                squares += off * off;
            }
            sum += squares.sqrt();
        }
        distances.push(sum / LIMBS as f32);
        if let Some(before) = before {
            moved += step(before, other);
        }
        before = Some(other);
    }
    if moved < MOVES {
        return None;
    }
    let mean = distances.iter().sum::<f32>() / distances.len() as f32;
    let place = (distances.len() * 9 / 10).min(distances.len() - 1);
    let (_, most, _) = distances.select_nth_unstable_by(place, f32::total_cmp);
    let most = *most;
    let overlap = (to + 1 - from) as f32;
    Some(Overlap {
        mean,
        most,
        overlap,
        step: moved / overlap,
    })
}

/// How far limbs move between two samples, on average; less than the grain of a byte counts as none.
fn step(before: &[i8], after: &[i8]) -> f32 {
    let limb = |limb: usize| {
        let squares = (0..3).map(|axis| {
            let off = f32::from(before[3 * limb + axis]) - f32::from(after[3 * limb + axis]);
            off * off
        });
        let chord = squares.sum::<f32>().sqrt() / 127.0;
        if chord > 0.02 { chord } else { 0.0 }
    };
    (0..LIMBS).map(limb).sum::<f32>() / LIMBS as f32
}

/// Seconds of a sample, for those who read this table.
const _: () = assert!(RATE == 10.0, "lengths in samples are those of ten samples a second");
