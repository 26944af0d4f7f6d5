//! The parts of a database that are most like a part of a motion.
//!
//! Both are samples of where ten limbs point, how high the hips are, and how they move, 20 a second, which depend on no
//! skeleton (`survey::fingerprint`). Of the samples q of the query each has one sample of the clip, at j(q), in order:
//! j steps by 0, 1 or 2, and keeps within 20 % of the pace of the query: j(q) - j(0) is from q / 1.2 - 1 to 1.2 q + 1,
//! at the last q from q / 1.2 to 1.2 q.
//! The path of least cost is found by dynamic time warping, for each sample at which it may begin. Of parts that
//! overlap by more than half, the best is kept. Limbs that one of the bodies lacks are not compared.

use mocap_scene::options::setters;
use serde::Serialize;

use super::clip::{IndexedClip, SAMPLE_RATE};
use super::database::Database;
use super::movement::{Movement, Movements, Scale};
use super::query::Query;
use crate::survey::report::ClipRow;
use crate::survey::{Condition, LIMBS, WIDTH, mirrored_row};

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
    /// How many parts of one clip are found at most: with 1, other clips are not crowded out. Default: any number.
    pub per_clip: Option<usize>,
    /// Whether what is like the mirror image of the query is found too. Default: `true`.
    pub mirror: bool,
    /// Whether parts are ranked by what is done, and not by poses alone: half by the distance of the poses, half by
    /// that of how limbs and body move, whatever the order. A pose is always ranked by itself. Default: `false`.
    pub by_action: bool,
    /// The clips that are looked at, by their rows. Default: all.
    pub condition: Option<Condition>,
}

impl Default for FindOptions {
    fn default() -> Self {
        Self {
            count: 10,
            per_clip: None,
            mirror: true,
            by_action: false,
            condition: None,
        }
    }
}

setters! {
    FindOptions {
        count: usize,
        per_clip: Option<usize>,
        mirror: bool,
        by_action: bool,
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
    /// With [`by_action`](FindOptions::by_action), how far its movement is from that of the query: the root of the mean
    /// square over speeds and spreads of limbs, height, steps and turns, each by its deviation in what was looked at.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub movement: Option<f64>,
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
        match options.by_action && query.count() > 1 {
            true => search.by_action(clips.map(|clip| (clip, search.parts(clip))).collect()),
            false => {
                let mut found = Vec::new();
                for clip in clips {
                    let parts = search.parts(clip);
                    let ranked = parts.iter().map(|part| (part.cost as f64, *part, None));
                    search.add(&mut found, clip, ranked.collect());
                }
                found.into_iter().map(|(_, found)| found).collect()
            }
        }
    }
}

/// What is looked for, and how.
struct Search<'a> {
    query: &'a Query,
    mirror: Option<Vec<i8>>,
    options: &'a FindOptions,
}

/// What a part is ranked by, the part, and how far its movement is from that of the query.
type PartRank = (f64, Part, Option<f64>);

impl<'a> Search<'a> {
    fn new(query: &'a Query, options: &'a FindOptions) -> Self {
        let mirror = || query.samples.chunks_exact(WIDTH).flat_map(mirrored_row).collect();
        Self {
            query,
            mirror: options.mirror.then(mirror),
            options,
        }
    }

    /// The best parts of a clip from each of its samples on.
    fn parts(&self, clip: &IndexedClip) -> Vec<Part> {
        let mut found = parts(clip, &self.query.samples, false);
        if let Some(mirror) = &self.mirror {
            found.extend(parts(clip, mirror, true));
        }
        found
    }

    /// Adds the best parts of a clip to the best of all, each with its rank.
    fn add(&self, all: &mut Vec<(f64, Match)>, clip: &IndexedClip, mut parts: Vec<PartRank>) {
        let FindOptions { count, per_clip, .. } = *self.options;
        parts.sort_by(|(a, one, _), (b, other, _)| {
            a.total_cmp(b)
                .then((one.first, one.mirrored).cmp(&(other.first, other.mirrored)))
        });
        let kept = apart(&parts, per_clip.map_or(count, |most| most.min(count)));
        let found = kept
            .into_iter()
            .map(|(rank, part, movement)| (rank, part.found(clip, self.query, movement)));
        all.extend(found);
        all.sort_by(|(a, one), (b, other)| a.total_cmp(b).then(one.distance.total_cmp(&other.distance)));
        all.truncate(count);
    }

    /// Ranked half by poses and half by movement: each distance over its mean among all parts.
    fn by_action(&self, clips: Vec<(&IndexedClip, Vec<Part>)>) -> Vec<Match> {
        let own = Movements::new(&self.query.samples).part(0, self.query.count() - 1);
        let of_clip = |(clip, parts): &(&IndexedClip, Vec<Part>)| -> Vec<Movement> {
            let movements = Movements::new(&clip.samples);
            parts.iter().map(|part| movements.part(part.first, part.last)).collect()
        };
        let movements: Vec<Vec<Movement>> = clips.iter().map(of_clip).collect();
        let scale = Scale::new(movements.iter().flatten());
        let away: Vec<Vec<f64>> = clips
            .iter()
            .zip(&movements)
            .map(|((clip, _), movements)| {
                let limbs = limbs_of_both(&clip.samples, &self.query.samples);
                let distance = |movement: &Movement| scale.distance(&own, movement, &limbs);
                movements.iter().map(distance).collect()
            })
            .collect();
        let count = away.iter().map(Vec::len).sum::<usize>().max(1) as f64;
        let poses = clips
            .iter()
            .flat_map(|(_, parts)| parts)
            .map(|part| (part.cost as f64).sqrt());
        // Where all are alike nothing ranks them.
        let mean = |sum: f64| if sum > 0.0 { sum / count } else { 1.0 };
        let [by_pose, by_movement] = [mean(poses.sum()), mean(away.iter().flatten().sum())];
        let mut found = Vec::new();
        for ((clip, parts), away) in clips.into_iter().zip(away) {
            let rank = |(part, away): (Part, f64)| {
                let rank = (part.cost as f64).sqrt() / by_pose + away / by_movement;
                (rank, part, Some(away))
            };
            self.add(&mut found, clip, parts.into_iter().zip(away).map(rank).collect());
        }
        found.into_iter().map(|(_, found)| found).collect()
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
    fn found(&self, clip: &IndexedClip, query: &Query, movement: Option<f64>) -> Match {
        let second = |sample: usize| clip.begin + sample as f64 / SAMPLE_RATE;
        let steps = query.count() - 1;
        let unit = (query.count() * LIMBS) as f64 * 127.0 * 127.0;
        Match {
            file: clip.row.file.clone(),
            clip: clip.row.clip.clone(),
            first: second(self.first),
            last: second(self.last),
            distance: (self.cost as f64 / unit).sqrt(),
            movement,
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
fn apart(parts: &[PartRank], count: usize) -> Vec<PartRank> {
    let mut kept: Vec<PartRank> = Vec::new();
    for part in parts {
        if kept.len() == count {
            break;
        }
        if !kept.iter().any(|(_, better, _)| better.overlaps(&part.1)) {
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
