//! Finds the parts of a database that are most similar to a part of a motion.
//!
//! Both motions are sampled 20 times per second. A sample has the directions of ten limbs, and the height and movement
//! of the hips, independent of the skeleton (`survey::fingerprint`). Each sample q of the query matches one sample j(q)
//! of the clip. From one q to the next, j steps by 0, 1 or 2. The pace of the clip stays within a factor of 1.2 of the
//! pace of the query. So j(q) - j(0) is from q / 1.2 - 1 to 1.2 q + 1. At the last q, j(q) - j(0) is from q / 1.2 to
//! 1.2 q. For each possible j(0), dynamic time warping finds the cheapest matches of all q. If parts overlap by more
//! than half, only the best part is kept. A limb is compared only if both bodies have it.

use mocap_scene::options::setters;
use serde::Serialize;

use super::clip::{IndexedClip, SAMPLE_RATE};
use super::database::Database;
use super::query::Query;
use crate::survey::report::ClipRow;
use crate::survey::{Condition, Fingerprint, LIMBS, WIDTH, are_of_one_take, mirrored_row};

/// The largest factor by which a part may be faster or slower than the query. Beyond it, the part looks like another
/// movement.
const PACE: f64 = 1.2;
/// The additional tolerance for all samples except the last, in samples. The alignment needs this tolerance, because it
/// advances by whole samples.
const SLACK: f64 = 1.0;
/// Weights of the squared differences of the last numbers of a sample: height of the hips, speed sideways, speed
/// forward, speed of turning.
const WEIGHTS: [i32; WIDTH - 3 * LIMBS] = [6, 2, 2, 2];

/// Options of a search.
///
/// The [module](crate::matching) has an example.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FindOptions {
    /// The largest number of matches. Default: 10.
    pub count: usize,
    /// The largest number of matches in one take. A clip and its near-duplicates are one take. `None` sets no limit.
    /// Default: 1.
    pub per_clip: Option<usize>,
    /// Whether the search also finds matches of the mirrored query. Default: `true`.
    pub mirror: bool,
    /// A condition on the rows of the clips to search. Default: all clips.
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

/// A part of a clip that is similar to a query.
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
    /// The start of the part, in seconds of the file.
    pub first: f64,
    /// The end of the part, in seconds of the file.
    pub last: f64,
    /// The mean difference of the directions of limbs, as a chord of the unit circle: 0.1 is 5.7 degrees.
    pub distance: f64,
    /// Whether the part matches the mirrored query.
    pub mirrored: bool,
    /// The speed of the part relative to the query; 1 for a pose.
    pub pace: f64,
}

impl Database {
    /// The parts that are most similar to `query`, the best first.
    pub fn find(&self, query: &Query, options: &FindOptions) -> Vec<Match> {
        let is_looked_at = |row: &ClipRow| options.condition.as_ref().is_none_or(|condition| condition.holds(row));
        // Skip mirrored clips: the mirrored query finds their originals.
        let clips = self.clips.iter();
        let clips = clips.filter(|clip| !clip.mirrored && is_looked_at(&clip.row));
        let search = Search::new(query, options);
        let mut found: Vec<(&IndexedClip, Part)> = clips
            .flat_map(|clip| search.best(clip).into_iter().map(move |part| (clip, part)))
            .collect();
        // The sort is stable: parts of equal cost stay in the order of their clips.
        found.sort_by_key(|(_, part)| part.cost);
        let kept = search.of_different_takes(found);
        kept.into_iter().map(|(clip, part)| part.found(clip, query)).collect()
    }
}

/// A query, and the options of its search.
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

    /// The best parts of a clip. No part overlaps a better part by more than half.
    fn best(&self, clip: &IndexedClip) -> Vec<Part> {
        let mut found = parts(clip, &self.query.samples, false);
        if let Some(mirror) = &self.mirror {
            found.extend(parts(clip, mirror, true));
        }
        found.sort_by_key(|part| (part.cost, part.first, part.mirrored));
        let FindOptions { count, per_clip, .. } = *self.options;
        apart(&found, per_clip.map_or(count, |most| most.min(count)))
    }

    /// The best of the sorted parts, with at most [`FindOptions::per_clip`] of each take.
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

/// Whether two clips are the same clip or near-duplicates around `parts`.
fn is_copy(clips: [&IndexedClip; 2], parts: [&Part; 2]) -> bool {
    let [row, other] = clips.map(|clip| &clip.row);
    if (&row.sha256, &row.clip) == (&other.sha256, &other.clip) && (!row.sha256.is_empty() || row.file == other.file) {
        return true;
    }
    let mirrored = parts[0].mirrored != parts[1].mirrored;
    // The survey compares 10 samples per second: every second sample.
    let fingerprints = clips.map(|clip| Fingerprint {
        values: clip.samples.chunks_exact(WIDTH).step_by(2).flatten().copied().collect(),
        is_body: true,
    });
    let at = parts.map(|part| part.first as f32 / 2.0);
    are_of_one_take([&fingerprints[0], &fingerprints[1]], at, mirrored)
}

/// A part of a clip, as its first and last sample.
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
        // Poses within a quarter of a second count as the same pose.
        let near = self.first.abs_diff(other.first) <= (SAMPLE_RATE / 4.0) as usize;
        2 * shared > shorter || near
    }
}

/// The best `count` of the sorted parts. No part overlaps a better part by more than half.
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

/// The limbs that both bodies have. The direction of a limb is 0 if one of its bones is missing.
pub fn limbs_of_both(a: &[i8], b: &[i8]) -> [bool; LIMBS] {
    let has = |samples: &[i8], limb: usize| {
        let mut rows = samples.chunks_exact(WIDTH);
        rows.any(|row| row[3 * limb..3 * limb + 3] != [0; 3])
    };
    std::array::from_fn(|limb| has(a, limb) && has(b, limb))
}

/// For each sample of a clip, the best part that begins at the sample.
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

/// The squared distance of two samples over `limbs`, scaled as if all ten limbs were compared.
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

/// The least costs of the current and the previous row of the dynamic time warping.
struct Warp {
    row: Vec<i64>,
    next: Vec<i64>,
}

/// The cost of a cell that no path reaches.
const NO_PATH: i64 = i64::MAX / 2;

impl Warp {
    fn new(queries: usize) -> Self {
        let width = (PACE * queries as f64 + SLACK) as usize + 4;
        Self {
            row: vec![NO_PATH; width],
            next: vec![NO_PATH; width],
        }
    }

    /// The least cost of the query along a clip of `count` samples, starting at `first`, and the number of samples to
    /// the end of the part.
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
