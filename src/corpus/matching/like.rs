//! The parts of a database that are most like a part of a motion.
//!
//! Both are sampled 20 times a second: directions of ten limbs, height and movement of the hips, on no skeleton
//! (`survey::fingerprint`). Each sample q of the query has one sample of the clip, at j(q), in order. j steps by 0, 1
//! or 2, and keeps within 20 % of the pace of the query: j(q) - j(0) is from q / 1.2 - 1 to 1.2 q + 1. At the last q it
//! is from q / 1.2 to 1.2 q. Dynamic time warping finds the cheapest path from each first sample. Of parts that overlap
//! by more than half, the best is kept. Limbs that one of the bodies lacks are not compared.

use mocap_scene::options::setters;
use serde::Serialize;

use super::clip::{IndexedClip, SAMPLE_RATE};
use super::database::Database;
use super::query::Query;
use crate::survey::report::ClipRow;
use crate::survey::{Condition, Fingerprint, LIMBS, WIDTH, are_of_one_take, mirrored_row};

/// The factor by which a part may be faster or slower: more looks like another movement.
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
    /// How many parts of one take are found at most: a clip and its near-duplicates are one take. `None` is any number,
    /// and finds parts of near-duplicates beside each other. Default: 1.
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
            per_clip: Some(1),
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Match {
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
    pub fn find(&self, query: &Query, options: &FindOptions) -> Vec<Match> {
        let is_looked_at = |row: &ClipRow| options.condition.as_ref().is_none_or(|condition| condition.holds(row));
        // Mirrored clips are found by the mirrored query, where somebody wants them.
        let clips = self.clips.iter();
        let clips = clips.filter(|clip| !clip.mirrored && is_looked_at(&clip.row));
        let search = Search::new(query, options);
        let mut found: Vec<(&IndexedClip, Part)> = clips
            .flat_map(|clip| search.best(clip).into_iter().map(move |part| (clip, part)))
            .collect();
        // Parts of equal cost stay in the order of their clips.
        found.sort_by_key(|(_, part)| part.cost);
        let kept = search.of_different_takes(found);
        kept.into_iter().map(|(clip, part)| part.found(clip, query)).collect()
    }
}

/// What is looked for, and how.
struct Search<'a> {
    query: &'a Query,
    mirror: Option<Vec<i8>>,
    options: &'a FindOptions,
}

impl<'a> Search<'a> {
    fn new(query: &'a Query, options: &'a FindOptions) -> Self {
        let mirror = || query.samples.chunks_exact(WIDTH).flat_map(mirrored_row).collect();
        Self {
            query,
            mirror: options.mirror.then(mirror),
            options,
        }
    }

    /// The best parts of a clip, none of which overlaps a better one.
    fn best(&self, clip: &IndexedClip) -> Vec<Part> {
        let mut found = parts(clip, &self.query.samples, false);
        if let Some(mirror) = &self.mirror {
            found.extend(parts(clip, mirror, true));
        }
        found.sort_by_key(|part| (part.cost, part.first, part.mirrored));
        let FindOptions { count, per_clip, .. } = *self.options;
        apart(&found, per_clip.map_or(count, |most| most.min(count)))
    }

    /// The first of sorted parts, of each take as many as are wanted.
    fn of_different_takes<'b>(&self, parts: Vec<(&'b IndexedClip, Part)>) -> Vec<(&'b IndexedClip, Part)> {
        let mut kept: Vec<(&IndexedClip, Part)> = Vec::new();
        for (clip, part) in parts {
            if kept.len() == self.options.count {
                break;
            }
            let is_of_one_take = |(other, better): &&(&IndexedClip, Part)| is_copy([clip, *other], [&part, better]);
            let most = self.options.per_clip;
            if most.is_none_or(|most| kept.iter().filter(is_of_one_take).count() < most) {
                kept.push((clip, part));
            }
        }
        kept
    }
}

/// Whether a clip is another, or its near-duplicate, around these parts of both.
fn is_copy(clips: [&IndexedClip; 2], parts: [&Part; 2]) -> bool {
    let [row, other] = clips.map(|clip| &clip.row);
    if (&row.sha256, &row.clip) == (&other.sha256, &other.clip) && (!row.sha256.is_empty() || row.file == other.file) {
        return true;
    }
    let mirrored = parts[0].mirrored != parts[1].mirrored;
    // The survey compares every second sample.
    let fingerprints = clips.map(|clip| Fingerprint {
        values: clip.samples.chunks_exact(WIDTH).step_by(2).flatten().copied().collect(),
        is_body: true,
    });
    let at = parts.map(|part| part.first as f32 / 2.0);
    are_of_one_take([&fingerprints[0], &fingerprints[1]], at, mirrored)
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
    fn found(&self, clip: &IndexedClip, query: &Query) -> Match {
        let second = |sample: usize| clip.begin + sample as f64 / SAMPLE_RATE;
        let steps = query.count() - 1;
        let unit = (query.count() * LIMBS) as f64 * 127.0 * 127.0;
        Match {
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

/// The limbs that both bodies have: a direction is 0 where a bone of it is missing.
pub fn limbs_of_both(a: &[i8], b: &[i8]) -> [bool; LIMBS] {
    let has = |samples: &[i8], limb: usize| {
        let mut rows = samples.chunks_exact(WIDTH);
        rows.any(|row| row[3 * limb..3 * limb + 3] != [0; 3])
    };
    std::array::from_fn(|limb| has(a, limb) && has(b, limb))
}

/// For each sample of a clip, the best part that begins there.
fn parts(clip: &IndexedClip, query: &[i8], mirrored: bool) -> Vec<Part> {
    let rows = query.chunks_exact(WIDTH);
    let count = clip.samples.len() / WIDTH;
    let limbs = limbs_of_both(&clip.samples, query);
    let costs: Vec<Vec<i32>> = rows
        .map(|row| {
            clip.samples
                .chunks_exact(WIDTH)
                .map(|sample| cost(row, sample, &limbs))
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

/// The squared distance of two samples, by these limbs: as much for all as if they were ten.
pub fn cost(a: &[i8], b: &[i8], limbs: &[bool; LIMBS]) -> i32 {
    let square = |(a, b): (&i8, &i8)| {
        let difference = i32::from(*a) - i32::from(*b);
        difference * difference
    };
    let pairs = a[..3 * LIMBS].chunks_exact(3).zip(b[..3 * LIMBS].chunks_exact(3));
    let of_limb = |((a, b), has): ((&[i8], &[i8]), &bool)| match has {
        true => a.iter().zip(b).map(square).sum::<i32>(),
        false => 0,
    };
    let compared = limbs.iter().filter(|has| **has).count().max(1) as i32;
    let limbs = pairs.zip(limbs).map(of_limb).sum::<i32>() * LIMBS as i32 / compared;
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
