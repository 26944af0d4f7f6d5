//! The floor: its height, its slope, and the drift of the whole body over a take.
//!
//! What tells are the points of the feet while they are slow. A plane is fitted to those that are low, by weighted
//! least squares again and again with a scale that becomes smaller (iteratively reweighted, Tukey's biweight): a foot
//! in the air is above the floor, and nothing is below it. The drift is what is left over time: in height of these
//! points, and over the ground as the speed of feet that stand.

use glam::{DVec3, Mat4, Quat, Vec3};

use super::least_squares::{Knots, LeastSquares, biweight};
use super::work::Work;
use crate::edit::frames::tracks;
use crate::figure::contacts::points_of_feet;

/// A point of a foot may tell of the floor while it is slower than this, in m/s, over this many seconds.
const SLOW: f64 = 0.35;
const OVER: f64 = 0.1;
/// The first and the last scale of the fit in metres, and the number of rounds.
const SCALES: [f64; 2] = [0.25, 0.015];
const ROUNDS: usize = 16;
/// Seconds from a knot of the drift to the next, and how many there are at most.
const KNOT: f64 = 2.5;
const KNOTS: usize = 100;
/// A height, a slope in degrees and a drift below these are left, in metres and m/s.
pub(super) const LEAST_HEIGHT: f64 = 0.06;
pub(super) const LEAST_SLOPE: f64 = 1.0;
const LEAST_DRIFT: f64 = 0.03;
/// A slope above this is a hill, a drift in height beyond this is stairs, and one over the ground that is faster is a
/// treadmill: they are left.
const LARGEST_SLOPE: f64 = 12.0;
const LARGEST_DRIFT: f64 = 0.25;
const FASTEST_DRIFT: f64 = 0.08;
/// How many times its own uncertainty a slope must be.
const CERTAIN: f64 = 4.0;

/// The floor that the feet tell of. Lengths are in metres.
#[derive(Clone, Debug, Default)]
pub(super) struct Floor {
    /// The height under the origin of the ground.
    pub(super) height: f64,
    /// The rise per metre along the two axes of the ground.
    rise: [f64; 2],
    /// How uncertain they are.
    uncertain: f64,
    /// Where the points are, on the average.
    centre: DVec3,
    /// What is added to the height in each frame.
    drift: Vec<f64>,
}

impl Floor {
    pub(super) fn slope(&self) -> f64 {
        self.rise[0].hypot(self.rise[1]).atan().to_degrees()
    }
}

/// What was done.
#[derive(Default)]
pub(super) struct Levelled {
    pub(super) height: Option<f64>,
    pub(super) slope: Option<f64>,
    pub(super) drift: Option<f64>,
}

/// The points of the feet in every frame: in metres, along the two axes of the ground and up.
struct Feet {
    /// For each kind of point (ankles, balls) its tracks.
    points: Vec<(usize, Vec<DVec3>)>,
    rate: f64,
    frames: usize,
}

/// The axes of the ground, and up.
fn axes(up: Vec3) -> [Vec3; 3] {
    let first = up.any_orthonormal_vector();
    [first, up.cross(first), up]
}

impl Feet {
    fn new(work: &Work<'_>) -> Self {
        let kinds = points_of_feet(work.scene, &work.figure.humanoid);
        let nodes: Vec<_> = kinds.iter().flatten().map(|(_, node)| *node).collect();
        let kind = |index: usize| usize::from(index >= kinds[0].len());
        let [x, y, up] = axes(work.up);
        let metres = work.metres;
        let local = |point: &Vec3| (Vec3::new(point.dot(x), point.dot(y), point.dot(up)) * metres).as_dvec3();
        let tracks = tracks(&work.frames, work.scene, &nodes);
        let points = tracks.iter().enumerate();
        Self {
            points: points
                .map(|(index, track)| (kind(index), track.iter().map(local).collect()))
                .collect(),
            rate: work.frames.rate,
            frames: work.frames.len(),
        }
    }

    /// Calls `add` with each point that is slow: its kind, its frame, where it is and its velocity.
    fn slow(&self, mut add: impl FnMut(usize, usize, DVec3, DVec3)) {
        let half = ((0.5 * OVER * self.rate).round() as usize).max(1);
        for (kind, track) in &self.points {
            for frame in half..self.frames.saturating_sub(half) {
                let seconds = 2.0 * half as f64 / self.rate;
                let velocity = (track[frame + half] - track[frame - half]) / seconds;
                if velocity.length() < SLOW {
                    add(*kind, frame, track[frame], velocity);
                }
            }
        }
    }
}

/// The floor of a motion; `None` where no foot is ever slow.
pub(super) fn find(work: &Work<'_>) -> Option<Floor> {
    let feet = Feet::new(work);
    let mut points = Vec::new();
    feet.slow(|kind, frame, at, _| points.push((kind, frame, at)));
    if points.len() < 8 {
        return None;
    }
    let centre = points.iter().map(|(_, _, at)| *at).sum::<DVec3>() / points.len() as f64;
    let knots = Knots::new(feet.frames, KNOT * feet.rate, KNOTS);
    let mut levels = [0, 1].map(|kind| low(points.iter().filter(|point| point.0 == kind).map(|point| point.2.z)));
    let mut floor = Floor {
        centre,
        drift: vec![0.0; feet.frames],
        ..Floor::default()
    };
    // Two levels, two slopes, and the knots of the drift.
    for round in 0..ROUNDS {
        let part = round as f64 / (ROUNDS - 1) as f64;
        let scale = SCALES[0] * (SCALES[1] / SCALES[0]).powf((1.3 * part).min(1.0));
        let mut equations = LeastSquares::new(4 + knots.count);
        let mut weights = 0.0;
        for &(kind, frame, at) in &points {
            let from = at - centre;
            let expected = levels[kind] + floor.rise[0] * from.x + floor.rise[1] * from.y + floor.drift[frame];
            let residual = at.z - expected;
            let weight = if residual > 0.0 {
                biweight(residual / scale)
            } else {
                biweight(residual / (4.0 * scale))
            };
            if weight > 0.0 {
                let [knot, next] = knots.terms(frame, 4);
                equations.add(&[(kind, 1.0), (2, from.x), (3, from.y), knot, next], at.z, weight);
                weights += weight;
            }
        }
        for (kind, level) in levels.iter().enumerate() {
            equations.add(&[(kind, 1.0)], *level, 1e-6 * (1.0 + weights));
        }
        for rise in [2, 3] {
            equations.add(&[(rise, 1.0)], 0.0, 2e-4 * weights);
        }
        knots.add_priors(
            &mut equations,
            4,
            0.2 * weights / knots.count as f64,
            0.02 * weights / knots.count as f64,
        );
        let (found, variances) = equations.solve()?;
        levels = [found[0], found[1]];
        floor.rise = [found[2], found[3]];
        floor.drift = knots.curve(&found[4..]);
        // Frames next to one another tell the same: a tenth of a second counts once.
        let of_one = 0.01f64.powi(2) * (0.1 * feet.rate).max(1.0);
        floor.uncertain = (of_one * variances[2].max(variances[3])).sqrt();
    }
    let has = |kind: usize| points.iter().any(|point| point.0 == kind);
    floor.height = (0..2)
        .filter(|kind| has(*kind))
        .map(|kind| levels[kind])
        .fold(f64::INFINITY, f64::min);
    Some(floor)
}

/// The level below which a tenth of the heights are.
fn low(heights: impl Iterator<Item = f64>) -> f64 {
    let mut heights: Vec<f64> = heights.collect();
    heights.sort_by(f64::total_cmp);
    heights.get(heights.len() / 10).copied().unwrap_or_default()
}

/// Takes slope and drift out, and brings the floor to height 0 where it is farther from there than `least_height`.
pub(super) fn level(work: &mut Work<'_>, least_height: f64) -> Option<Levelled> {
    let carrier = work.carrier()?;
    let mut done = Levelled::default();
    let floor = find(work)?;
    let [x, y, up] = axes(work.up);
    let slope = floor.slope();
    if (LEAST_SLOPE..LARGEST_SLOPE).contains(&slope) && floor.rise[0].hypot(floor.rise[1]) > CERTAIN * floor.uncertain {
        let normal = up - x * floor.rise[0] as f32 - y * floor.rise[1] as f32;
        let turn = Quat::from_rotation_arc(normal.normalize(), up);
        let metres = work.metres;
        let pivot = (x * floor.centre.x as f32 + y * floor.centre.y as f32 + up * floor.height as f32) / metres;
        let motion = Mat4::from_translation(pivot) * Mat4::from_quat(turn) * Mat4::from_translation(-pivot);
        work.carry(carrier, |_| motion);
        done.slope = Some(slope);
    }
    let drift = drift(work, &floor.drift);
    if let Some(drift) = &drift {
        let metres = work.metres;
        let (first, last) = drift
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(least, most), at| {
                (least.min(*at), most.max(*at))
            });
        work.carry(carrier, |frame| {
            let by = drift[frame.min(drift.len() - 1)].as_vec3();
            Mat4::from_translation(-(x * by.x + y * by.y + up * by.z) / metres)
        });
        done.drift = Some((last - first).length());
    }
    let height = find(work)?.height;
    if height.abs() > least_height || done.slope.is_some() || done.drift.is_some() {
        let by = Mat4::from_translation(-up * height as f32 / work.metres);
        work.carry(carrier, |_| by);
        done.height = Some(height);
    }
    Some(done)
}

/// How far the body drifted in each frame, in metres: along the axes of the ground, and up as `height` has it. `None`
/// where that is little, or is no drift.
fn drift(work: &Work<'_>, height: &[f64]) -> Option<Vec<DVec3>> {
    let feet = Feet::new(work);
    let mut slow = Vec::new();
    feet.slow(|kind, frame, at, velocity| slow.push((kind, frame, at, velocity)));
    // The balls of the feet, where there are any: an ankle goes on while the foot rolls.
    let best = slow.iter().map(|point| point.0).max()?;
    slow.retain(|point| point.0 == best);
    let level = low(slow.iter().map(|point| point.2.z));
    slow.retain(|point| point.2.z < level + 0.03);
    let knots = Knots::new(feet.frames, KNOT * feet.rate, KNOTS);
    let mut velocities = [vec![0.0; feet.frames], vec![0.0; feet.frames]];
    for round in 0..ROUNDS {
        let scale = 0.25f64 * (0.04f64 / 0.25).powf(round as f64 / (ROUNDS - 1) as f64);
        let mut equations = [0, 1].map(|_| LeastSquares::new(knots.count));
        let mut weights = 0.0;
        for (_, frame, _, velocity) in &slow {
            let off = (velocity.x - velocities[0][*frame]).hypot(velocity.y - velocities[1][*frame]);
            let weight = biweight(off.hypot(velocity.z) / scale);
            let terms = knots.terms(*frame, 0);
            equations[0].add(&terms, velocity.x, weight);
            equations[1].add(&terms, velocity.y, weight);
            weights += weight;
        }
        for (mut equations, velocity) in equations.into_iter().zip(&mut velocities) {
            let of_knot = weights / knots.count as f64 + 1e-3;
            knots.add_priors(&mut equations, 0, 0.3 * of_knot, 0.02 * of_knot);
            *velocity = knots.curve(&equations.solve()?.0);
        }
    }
    let fastest = |velocity: &[f64]| velocity.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    let is_treadmill = velocities.iter().any(|velocity| fastest(velocity) > FASTEST_DRIFT);
    let mut at = DVec3::ZERO;
    let mut drift = Vec::with_capacity(feet.frames);
    for frame in 0..feet.frames {
        if !is_treadmill {
            at.x += velocities[0][frame] / feet.rate;
            at.y += velocities[1][frame] / feet.rate;
        }
        drift.push(DVec3::new(at.x, at.y, height[frame]));
    }
    let farthest = |part: fn(&DVec3) -> f64| {
        let (least, most) = drift
            .iter()
            .map(part)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        most - least
    };
    let over_ground = farthest(|at| at.x).hypot(farthest(|at| at.y));
    let in_height = farthest(|at| at.z);
    let keeps = [
        over_ground > LEAST_DRIFT,
        in_height > LEAST_DRIFT && in_height < LARGEST_DRIFT,
    ];
    if keeps == [false; 2] {
        return None;
    }
    for at in &mut drift {
        if !keeps[0] {
            (at.x, at.y) = (0.0, 0.0);
        }
        if !keeps[1] {
            at.z = 0.0;
        }
    }
    Some(drift)
}
