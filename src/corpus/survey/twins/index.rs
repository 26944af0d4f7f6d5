//! Finds candidates for near-duplicates. A moment is the motion of the limbs from 0.4 s before to 0.4 s after a sample.
//! The signs of random projections of a moment are its hash. If moments of two clips have the same hash, the moments
//! vote for this pair of clips and for the offset between the moments. Moments in which hardly anything moves have no
//! hash. If many moments have the same hash, only the first of them are looked up. So the cost grows linearly with the
//! number of clips.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use glam::Vec3;
use mocap_scene::math::spread::spread;

use super::Candidate;
use super::alignment::{Moments, SHORTEST};
use super::limbs::numbers;
use crate::survey::fingerprint::{Fingerprint, LIMBS};

/// Bits of a hash of a moment.
const BITS: usize = 24;
/// A hash of a moment has the sign of each feature. The signs of this many values nearest to 0 are uncertain. A lookup
/// also tries the hashes in which one or two of these signs are flipped.
const UNCERTAIN: usize = 5;
/// The samples of a moment on each side: 0.4 s.
const REACH: usize = 4;
/// The largest number of moments per hash that are looked up and vote.
const MOST_OF_HASH: usize = 24;
/// The largest mean distance of limbs, in the second around two moments, for which the clips are aligned. In chords of
/// the unit sphere. This limit allows for the distance of near-duplicates, and for a difference in pace of 10 %.
const NEAR_MOMENT: f32 = 0.1;
/// The distance that comparing whole samples adds, as a fraction of the movement from one sample to the next.
const HALF_A_STEP: f32 = 0.5;
/// Half of the second around a moment, in samples.
const HALF_SECOND: isize = 5;
/// The leading bits of a hash, which index the sorted list of moments.
const LEADING: usize = 20;

/// The least mean movement of limbs within a moment, as a chord of the unit sphere. A moment with less movement matches
/// any standing figure.
const MOMENT_MOVES: f32 = 0.03;
/// The fewest votes for which two clips are aligned. A short clip needs only one.
const VOTES: u16 = 2;

/// The largest number of clips that are aligned with a clip. The time of a survey grows with this number.
pub(super) const MOST_ALIGNED: usize = 24;

/// A moment of a clip, with its hash.
#[derive(Clone, Copy)]
struct Moment {
    hash: u32,
    clip: u32,
    sample: u32,
}

/// Moments by their hashes.
pub(super) struct Index {
    /// For each number of a moment, its factor in the projection of each bit of the hash.
    projections: Vec<[f32; BITS]>,
    mean: Vec<f32>,
    /// The moments, sorted by hash, clip and sample.
    moments: Vec<Moment>,
    /// For each value of the leading bits, the index of the first moment.
    starts: Vec<u32>,
}

impl Index {
    pub(super) fn new(clips: &[&Candidate<'_>], distinct: &[usize]) -> Self {
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

    /// The projections of a moment. If `later` is set, the moment is half a sample later. `None` if hardly anything
    /// moves.
    fn project(&self, fingerprint: &Fingerprint, sample: usize, later: bool, mirrored: bool) -> Option<[f32; BITS]> {
        let mut values = [0.0; 9 * LIMBS];
        let mut limbs = [[Vec3::ZERO; LIMBS]; 3];
        for (part, at) in [sample - REACH, sample, sample + REACH].into_iter().enumerate() {
            let row = numbers(fingerprint.limbs(at), mirrored);
            let next = match later {
                true => numbers(fingerprint.limbs(at + 1), mirrored),
                false => row,
            };
            for limb in 0..LIMBS {
                limbs[part][limb] = 0.5 * (Vec3::from_array(row[limb]) + Vec3::from_array(next[limb]));
                let off = limbs[part][limb].to_array();
                for axis in 0..3 {
                    values[3 * (LIMBS * part + limb) + axis] = off[axis] - self.mean[3 * limb + axis];
                }
            }
        }
        let moved = |limb: usize| limbs[0][limb].distance(limbs[1][limb]) + limbs[1][limb].distance(limbs[2][limb]);
        if (0..LIMBS).map(moved).sum::<f32>() / (LIMBS as f32) < MOMENT_MOVES {
            return None;
        }
        let mut along = [0.0; BITS];
        for (projection, value) in self.projections.iter().zip(values) {
            for bit in 0..BITS {
                along[bit] += projection[bit] * value;
            }
        }
        Some(along)
    }

    /// The earlier clips that a clip may repeat.
    pub(super) fn candidates(&self, clips: &[&Candidate<'_>], clip: usize) -> Vec<CandidatePair> {
        let fingerprint = clips[clip].fingerprint;
        let votes = self.votes(fingerprint, clip);
        let least = if is_short(fingerprint) { 1 } else { VOTES };
        // Retimed clips drift apart by up to 10 %, so the votes of two neighbouring offsets are added.
        let mut best: HashMap<(u32, bool), (u16, i32, Votes)> = HashMap::new();
        for (vote, of_vote) in &votes {
            let at = |offset: i32| votes.get(&Vote { offset, ..*vote }).map_or(0, |votes| votes.count);
            let before = (of_vote.count.saturating_add(at(vote.offset - 1)), -vote.offset);
            let after = (of_vote.count.saturating_add(at(vote.offset + 1)), -vote.offset - 1);
            let (count, offset) = before.max(after);
            if count >= least {
                let entry = best.entry((vote.clip, vote.mirrored)).or_default();
                *entry = (*entry).max((count, offset, *of_vote));
            }
        }
        let mut found: Vec<_> = best.into_iter().collect();
        found.sort_by_key(|((other, mirrored), (count, ..))| (std::cmp::Reverse(*count), *other, *mirrored));
        let likely = found.into_iter().filter_map(|((other, mirrored), (_, _, votes))| {
            let both = [clips[other as usize].fingerprint, fingerprint];
            Some(CandidatePair {
                clip: other as usize,
                at: nearest(both, votes, mirrored)?,
                mirrored,
            })
        });
        likely.take(MOST_ALIGNED).collect()
    }

    /// The votes of a clip's moments for each earlier clip and offset, with one of the moments.
    fn votes(&self, fingerprint: &Fingerprint, clip: usize) -> VotesOf {
        let mut votes = VotesOf::default();
        let end = fingerprint.samples().saturating_sub(REACH);
        // A short clip has few samples to look up.
        let (step, last) = match is_short(fingerprint) {
            true => (1, end),
            false => (2, end.saturating_sub(1)),
        };
        for mirrored in [false, true] {
            // Look up every second sample, and half a sample later, to find clips that begin between two samples of
            // another clip.
            for (sample, later) in (REACH..last)
                .step_by(step)
                .flat_map(|sample| [(sample, false), (sample, true)])
                .filter(|(sample, later)| !later || sample + 1 < end)
            {
                let Some(along) = self.project(fingerprint, sample, later, mirrored) else {
                    continue;
                };
                let moments = near_hashes(&along).into_iter().flat_map(|hash| self.of_hash(hash));
                for moment in moments.filter(|moment| (moment.clip as usize) < clip) {
                    let vote = Vote {
                        clip: moment.clip,
                        offset: (moment.sample as i32 - sample as i32).div_euclid(5),
                        mirrored,
                    };
                    let Votes { count, later, at } = votes.entry(vote).or_default();
                    *count = count.saturating_add(1);
                    *later += moment.sample as i32 - sample as i32;
                    *at = sample as u32;
                }
            }
        }
        votes
    }
}

/// A clip that another clip may repeat, and a moment that both may share.
pub(super) struct CandidatePair {
    pub(super) clip: usize,
    pub(super) at: Moments,
    pub(super) mirrored: bool,
}

/// The target of a vote: a clip, the offset of the moment in half seconds, and whether the clip is mirrored.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Vote {
    clip: u32,
    offset: i32,
    mirrored: bool,
}

type VotesOf = HashMap<Vote, Votes, BuildHasherDefault<VoteHasher>>;

/// The votes for one target.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Votes {
    count: u16,
    /// The sum of the offsets of the moments in the other clip, in samples.
    later: i32,
    /// One of the moments that voted.
    at: u32,
}

/// A fast hasher of [`Vote`]s. No attacker chooses the votes, so a stronger hash is not necessary.
#[derive(Default)]
struct VoteHasher(u64);

impl Hasher for VoteHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.write_u32(u32::from(*byte)));
    }

    fn write_u8(&mut self, value: u8) {
        self.write_u32(u32::from(value));
    }

    fn write_i32(&mut self, value: i32) {
        self.write_u32(value.cast_unsigned());
    }

    fn write_u32(&mut self, value: u32) {
        /// The golden ratio, as a fraction of 2^64.
        const FACTOR: u64 = 0x9e37_79b9_7f4a_7c15;
        self.0 = (self.0.rotate_left(23) ^ u64::from(value)).wrapping_mul(FACTOR);
    }
}

/// Whether a clip is compared only as a whole.
fn is_short(fingerprint: &Fingerprint) -> bool {
    fingerprint.samples() < SHORTEST
}

fn leading(hash: u32) -> usize {
    (hash >> (BITS - LEADING)) as usize
}

/// The pair of moments around which limbs are nearest, over one second. In the first clip the moment is later by the
/// mean offset of the votes, plus or minus two samples. Returns `None` if limbs are not near at any offset.
fn nearest([a, b]: [&Fingerprint; 2], votes: Votes, mirrored: bool) -> Option<Moments> {
    let sample = votes.at;
    let at = sample as i32 + votes.later / i32::from(votes.count.max(1));
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
    let distances = (-2..=2).map(|shift| (shifted(shift), shift));
    let (distance, shift) = distances.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (distance < near).then_some(Moments {
        first: at as f32 + shift as f32,
        second: sample as f32,
    })
}

/// The mean distance of limbs between two samples. With `mirrored`, the second sample is mirrored.
fn row_distance(a: &[i8], b: &[i8], mirrored: bool) -> f32 {
    let (a, b) = (numbers(a, false), numbers(b, mirrored));
    let mut sum = 0.0;
    for limb in 0..LIMBS {
        sum += Vec3::from_array(a[limb]).distance(Vec3::from_array(b[limb]));
    }
    sum / LIMBS as f32
}

/// The signs of a moment along all projections.
fn hash(along: &[f32; BITS]) -> u32 {
    along.iter().fold(0, |hash, value| hash << 1 | u32::from(*value > 0.0))
}

/// The hash of a moment, and the hashes with one or two of the least certain signs flipped.
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

/// The mean of all limbs of the corpus, over some 10,000 samples at most.
fn mean(clips: &[&Candidate<'_>], distinct: &[usize]) -> Vec<f32> {
    let mut sums = vec![0.0_f64; 3 * LIMBS];
    let mut count = 0.0;
    for &clip in distinct.iter().step_by(distinct.len().div_ceil(2000).max(1)) {
        let fingerprint = clips[clip].fingerprint;
        for sample in (0..fingerprint.samples()).step_by(10) {
            // Include the mirror image, so that hashes of mirrored clips agree.
            for mirrored in [false, true] {
                count += 1.0;
                let numbers = numbers(fingerprint.limbs(sample), mirrored);
                for (sum, number) in sums.iter_mut().zip(numbers.as_flattened()) {
                    *sum += f64::from(*number);
                }
            }
        }
    }
    sums.into_iter()
        .map(|sum| (sum / f64::max(count, 1.0)) as f32)
        .collect()
}

/// Fixed random directions. Each number is the sum of four uniform numbers from an xorshift generator.
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
