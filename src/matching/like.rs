//! The parts of a database that are most like a part of a motion.
//!
//! Both are samples of where ten limbs point, how high the hips are, and how they move, 20 a second, which depend on no
//! skeleton (`survey::fingerprint`). Of the samples q of the query each has one sample of the clip, at j(q), in order:
//! j steps by 0, 1 or 2, and keeps within 20 % of the pace of the query: j(q) - j(0) is from q / 1.2 - 1 to 1.2 q + 1,
//! at the last q from q / 1.2 to 1.2 q.
//! The path of least cost is found by dynamic time warping, for each sample at which it may begin. Of parts that
//! overlap by more than half, the best is kept.

use serde::Serialize;

use super::clip::{IndexedClip, SAMPLE_RATE};
use super::database::Database;
use super::query::Query;
use crate::options::setters;
use crate::survey::{ClipRow, Condition, LIMBS, WIDTH, mirrored_row};

/// How much faster or slower a part may be.
const PACE: f64 = 1.2;
/// Samples beyond that before the last, for the steps of whole samples.
const SLACK: f64 = 1.0;
/// How much the numbers after the limbs count, each squared difference: height of the hips, steps to the side and
/// forward, turning.
const WEIGHTS: [i32; WIDTH - 3 * LIMBS] = [6, 2, 2, 2];

/// How to look for what is like a query.
///
/// The [module](crate::matching) has an example.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FindOptions {
    /// How many are found at most. Default: 10.
    pub count: usize,
    /// How many parts of one clip are found at most: with 1, other clips are not crowded out. Default: any number.
    pub per_clip: Option<usize>,
    /// Whether what is like the mirror image of the query is found too. Default: `true`.
    pub mirror: bool,
    /// The clips that are looked at, by their rows. Default: all.
    pub condition: Option<Condition>,
}

impl Default for FindOptions {
    fn default() -> Self {
        Self {
            count: 10,
            per_clip: None,
            mirror: true,
            condition: None,
        }
    }
}

setters! {
    FindOptions {
        count: usize,
        per_clip: Option<usize>,
        mirror: bool,
        condition: Option<Condition>,
    }
}

/// A part of a clip that is like a query.
///
/// The [module](crate::matching) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Found {
    /// The file.
    pub file: String,
    /// The name of the clip.
    pub clip: String,
    /// The first and the last moment of the part, in seconds of the file.
    pub first: f64,
    /// The last moment.
    pub last: f64,
    /// How far a limb points elsewhere, in the mean: a chord of a circle of radius 1, of which 0.1 are 5.7 degrees.
    pub distance: f64,
    /// Whether it is like the mirror image of the query.
    pub mirrored: bool,
    /// How many times as fast it is as the query; 1 for a pose.
    pub pace: f64,
}

impl Database {
    /// The parts that are most like `query`, the best first.
    pub fn find(&self, query: &Query, options: &FindOptions) -> Vec<Found> {
        let mirror: Vec<i8> = query.samples.chunks_exact(WIDTH).flat_map(mirrored_row).collect();
        let queries = [(&query.samples, false), (&mirror, true)];
        let queries = &queries[..1 + usize::from(options.mirror)];
        let mut found: Vec<Found> = Vec::new();
        let is_looked_at = |row: &ClipRow| options.condition.as_ref().is_none_or(|condition| condition.holds(row));
        // Mirrored clips are found by the mirrored query, where somebody wants them.
        let clips = self
            .clips
            .iter()
            .filter(|clip| !clip.mirrored && is_looked_at(&clip.row));
        for clip in clips {
            let mut parts: Vec<Part> = queries
                .iter()
                .flat_map(|(samples, mirrored)| parts(clip, samples, *mirrored))
                .collect();
            parts.sort_by_key(|part| (part.cost, part.first, part.mirrored));
            let count = options.per_clip.map_or(options.count, |most| most.min(options.count));
            found.extend(apart(&parts, count).iter().map(|part| part.found(clip, query)));
            found.sort_by(|a, b| a.distance.total_cmp(&b.distance));
            found.truncate(options.count);
        }
        found
    }
}

/// A part of a clip, by its first and its last sample.
#[derive(Clone, Copy)]
struct Part {
    cost: i64,
    first: usize,
    last: usize,
    mirrored: bool,
}

impl Part {
    fn found(&self, clip: &IndexedClip, query: &Query) -> Found {
        let second = |sample: usize| clip.begin + sample as f64 / SAMPLE_RATE;
        let steps = query.count() - 1;
        let unit = (query.count() * LIMBS) as f64 * 127.0 * 127.0;
        Found {
            file: clip.row.file.clone(),
            clip: clip.row.clip.clone(),
            first: second(self.first),
            last: second(self.last),
            distance: (self.cost as f64 / unit).sqrt(),
            mirrored: self.mirrored,
            pace: match self.last - self.first {
                0 => 1.0,
                taken => steps as f64 / taken as f64,
            },
        }
    }

    fn overlaps(&self, other: &Self) -> bool {
        let shared = (self.last.min(other.last) + 1).saturating_sub(self.first.max(other.first));
        let shorter = (self.last - self.first).min(other.last - other.first) + 1;
        // Poses within a quarter of a second are one.
        let near = self.first.abs_diff(other.first) <= (SAMPLE_RATE / 4.0) as usize;
        2 * shared > shorter || near
    }
}

/// The best of sorted parts, none of which overlaps a better one.
fn apart(parts: &[Part], count: usize) -> Vec<Part> {
    let mut kept: Vec<Part> = Vec::new();
    for part in parts {
        if kept.len() == count {
            break;
        }
        if !kept.iter().any(|better| better.overlaps(part)) {
            kept.push(*part);
        }
    }
    kept
}

/// For each sample of a clip, the best part that begins there.
fn parts(clip: &IndexedClip, query: &[i8], mirrored: bool) -> Vec<Part> {
    let rows = query.chunks_exact(WIDTH);
    let count = clip.samples.len() / WIDTH;
    let costs: Vec<Vec<i32>> = rows
        .map(|row| {
            clip.samples
                .chunks_exact(WIDTH)
                .map(|sample| cost(row, sample))
                .collect()
        })
        .collect();
    let mut path = Warp::new(costs.len());
    (0..count)
        .filter_map(|first| {
            let (cost, steps) = path.best(&costs, first, count)?;
            Some(Part {
                cost,
                first,
                last: first + steps,
                mirrored,
            })
        })
        .collect()
}

/// The squared distance of two samples.
fn cost(a: &[i8], b: &[i8]) -> i32 {
    let square = |(a, b): (&i8, &i8)| {
        let difference = i32::from(*a) - i32::from(*b);
        difference * difference
    };
    let limbs = a[..3 * LIMBS].iter().zip(&b[..3 * LIMBS]).map(square).sum::<i32>();
    let others = a[3 * LIMBS..].iter().zip(&b[3 * LIMBS..]).map(square);
    limbs + others.zip(WEIGHTS).map(|(square, weight)| weight * square).sum::<i32>()
}

/// The least costs of a row of the warp, and of the row before.
struct Warp {
    row: Vec<i64>,
    next: Vec<i64>,
}

/// What no path reaches.
const NO_PATH: i64 = i64::MAX / 2;

impl Warp {
    fn new(queries: usize) -> Self {
        let width = (PACE * queries as f64 + SLACK) as usize + 4;
        Self {
            row: vec![NO_PATH; width],
            next: vec![NO_PATH; width],
        }
    }

    /// The least cost of the query along a clip of `count` samples from `first` on, and the steps to its last sample.
    fn best(&mut self, costs: &[Vec<i32>], first: usize, count: usize) -> Option<(i64, usize)> {
        let queries = costs.len();
        self.row.fill(NO_PATH);
        self.row[0] = i64::from(costs[0][first]);
        for (query, costs) in costs.iter().enumerate().skip(1) {
            self.next.fill(NO_PATH);
            let at = query as f64;
            let slack = if query + 1 == queries { 0.0 } else { SLACK };
            let least = (at / PACE - slack).ceil().max(0.0) as usize;
            let most = ((at * PACE + slack) as usize).min(count - 1 - first);
            for step in least..=most {
                let before = self.row[step.saturating_sub(2)..=step].iter().min();
                if let Some(before) = before.filter(|before| **before < NO_PATH) {
                    self.next[step] = before + i64::from(costs[first + step]);
                }
            }
            std::mem::swap(&mut self.row, &mut self.next);
        }
        let ends = self.row.iter().enumerate().filter(|(_, cost)| **cost < NO_PATH);
        ends.map(|(step, cost)| (*cost, step)).min()
    }
}
