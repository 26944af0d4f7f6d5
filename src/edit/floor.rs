//! Estimates the height and the slope of the floor, and the drift of the whole body over a take.
//!
//! The estimate uses points of the feet (ankles and balls) in frames in which they are slow. A plane is fitted to the
//! lowest of these points, because a foot may be above the floor but not below. The method is iteratively reweighted
//! least squares (Tukey's biweight). Its scale, the distance from the plane within which a point counts, decreases from
//! round to round. The drift in height is a curve over time, which is fitted together with the plane. The drift over
//! the ground comes from the speed of feet in stance, which would be 0 without drift.

mod drift;
mod least_squares;

use glam::{DVec2, DVec3, Mat4, Quat, Vec3};
use mocap_figure::Figure;
use mocap_figure::contacts::points_of_feet;
use mocap_figure::ground::{FootPoints, height_drift, levels};
use mocap_scene::error::Result;
use mocap_scene::scene::{HumanoidBone, Scene, Side};

use self::drift::drift;
use self::least_squares::{Knots, LeastSquares, biweight};
use super::work::Work;
use crate::frames::tracks;

/// The largest speed of a slow point in m/s. A foot in the air is ten times as fast.
const SLOW: f64 = 0.35;
/// The time over which the speed of a point is measured, in seconds. Over a shorter time, noise would add speed.
const OVER: f64 = 0.1;
/// The largest height of a point in stance above the lowest tenth of its heights, in metres.
const LOW: f64 = 0.04;
/// The first and the last scale of the fit, in metres. The first scale includes all steps of a stair. The last scale
/// includes only the noise of feet in stance.
const SCALES: [f64; 2] = [0.25, 0.015];
/// The number of rounds of the fit. Each round makes the scale a sixth smaller.
const ROUNDS: usize = 16;
/// The time between two knots of the curve of the drift, in seconds. A walk has about four steps in this time.
const KNOT: f64 = 2.5;
/// The largest number of intervals between knots. The time of the fit grows with the square of this number.
const KNOTS: usize = 100;
/// The standard deviation of the height of a foot in stance, in metres. Its causes are soft soles and noise.
const OF_FOOT: f64 = 0.01;
/// The time that counts as one observation, in seconds, because the noise of neighbouring frames is correlated.
const ONE_OBSERVATION: f64 = 0.1;
/// The standard deviation of the slope of a floor before a measurement, in metres per metre. Typical cameras are tilted
/// by about 3 degrees.
const OF_RISE: f64 = 0.06;
/// The standard deviation of the height difference between the right and the left foot, in metres. The markers on both
/// feet differ by about this height.
const OF_SIDES: f64 = 0.008;
/// The standard deviations in metres of the drift in height, and of its change of slope at a knot. Both are typical
/// errors of cameras.
const OF_DRIFT: [f64; 2] = [0.015, 0.01];
/// The shortest stance in seconds that shows a drift over the ground. In a shorter stance, the foot rolls.
const STANDS: f64 = 0.8;
/// The range of floor heights in metres that `clean` does not change. The centres of joints and markers may be this far
/// below a floor at 0. A body above the range may sit, lie, hover or stand on something.
const KEPT_HEIGHTS: std::ops::Range<f64> = -0.06..0.3;
/// The smallest slope that is removed, in degrees. A smaller slope lifts a foot by less than 17 mm per metre, which is
/// not visible.
pub(super) const LEAST_SLOPE: f64 = 1.0;
/// The largest slope that is removed, in degrees. A steeper floor is a hill.
const LARGEST_SLOPE: f64 = 12.0;
/// The smallest ratio of points near the sloped plane to points near a level plane at which a slope is trusted.
const EXPLAINS: f64 = 1.1;
/// The distance at which a point is near a plane, in metres: twice `OF_FOOT`.
const NEAR: f64 = 0.02;
/// The smallest ratio of a slope to its uncertainty at which the slope is trusted. By chance, the ratio is larger in
/// fewer than four of 10,000 cases.
const CERTAIN: f64 = 4.0;
/// Two extents of the footsteps of one foot along an axis of the ground, in metres. Footsteps within the first extent
/// show no slope along this axis. Footsteps beyond the second extent show the whole slope.
const SHOWS_SLOPE: [f64; 2] = [0.4, 0.9];
/// An estimated floor. Lengths are in metres.
#[derive(Clone, Debug, Default)]
pub(super) struct Floor {
    /// The height of the ground, as [`FootPoints::ground`] computes it for all commands.
    pub(super) height: f64,
    /// The rise of the floor in metres per metre, along each of the two axes of the ground.
    rise: [f64; 2],
    /// The ratio of the slope to its uncertainty.
    certain: f64,
    /// The ratio of the number of points near the sloped plane to the number of points near a level plane.
    explains: f64,
    /// The mean position of the slow points, at which the plane has no rise.
    centre: DVec3,
    /// The drift in height in each frame.
    drift: Vec<f64>,
    /// The height in contact of each kind of point (ankles, balls), at the centre.
    levels: [f64; 2],
    right_over_left: f64,
}

impl Floor {
    pub(super) fn slope(&self) -> f64 {
        self.rise[0].hypot(self.rise[1]).atan().to_degrees()
    }

    /// The slope in degrees that the footsteps show. The slope along a principal axis of the footsteps counts only if
    /// the footsteps extend far enough along this axis.
    fn slope_shown_by(&self, steps: &[SlowPoint]) -> f64 {
        let places = || steps.iter().map(|step| (step.at() - self.centre).truncate());
        let [xx, xy, yy] = places().fold([0.0; 3], |[xx, xy, yy], at| {
            [xx + at.x * at.x, xy + at.x * at.y, yy + at.y * at.y]
        });
        let along = DVec2::from_angle(0.5 * (2.0 * xy).atan2(xx - yy));
        let shown = |axis: DVec2| {
            // Each foot is measured by itself, because one foot may stand lower than the other foot.
            let feet = steps.chunk_by(|a, b| (a.kind, a.is_right) == (b.kind, b.is_right));
            let reach = feet.map(|foot| {
                let at = || foot.iter().map(|step| step.at().truncate().dot(axis));
                at().fold(f64::NEG_INFINITY, f64::max) - at().fold(f64::INFINITY, f64::min)
            });
            let [from, to] = SHOWS_SLOPE;
            axis.dot(self.rise.into()) * ((reach.fold(0.0, f64::max) - from) / (to - from)).clamp(0.0, 1.0)
        };
        shown(along).hypot(shown(along.perp())).atan().to_degrees()
    }

    /// The part of the height of a point that comes from the slope of the floor and the drift in height.
    fn above(&self, point: &SlowPoint) -> f64 {
        self.above_at(point.at(), point.frame as usize)
    }

    fn above_at(&self, at: DVec3, frame: usize) -> f64 {
        let from = at - self.centre;
        self.rise[0] * from.x + self.rise[1] * from.y + self.drift[frame]
    }

    /// For each point of `feet`, the height of the point in contact on a level floor. Also, for each frame, the height
    /// of the point above its contact on the found floor. The found floor has a slope and a drift.
    pub(super) fn stands<'a>(&'a self, feet: &'a Feet) -> impl Iterator<Item = (f64, Vec<f64>)> + 'a {
        feet.points.iter().zip(&feet.sides).map(|((kind, track), side)| {
            let level = self.levels[*kind] + self.right_over_left * side;
            let above = track.iter().enumerate();
            let above = above.map(|(frame, at)| at.z - level - self.above_at(*at, frame));
            (level, above.collect())
        })
    }

    /// Whether the footsteps are so far apart that the slope is known within a degree.
    pub(super) fn tells(&self) -> bool {
        self.certain * LEAST_SLOPE > self.slope() * CERTAIN || self.certain > CERTAIN
    }

    /// Whether the floor has a slope that is certain and too small for a hill.
    pub(super) fn is_sloped(&self) -> bool {
        (LEAST_SLOPE..LARGEST_SLOPE).contains(&self.slope()) && self.certain > CERTAIN && self.explains > EXPLAINS
    }
}

/// The slope of the floor in degrees, the drift over the ground in metres, and the drift in height in metres. [`level`]
/// removes the slope and the drift over the ground.
pub(super) fn errors(work: &Work<'_>) -> [Option<f64>; 3] {
    let in_height = height_drift(&tracks_of_feet(work), work.up, work.metres, work.frames.rate);
    let feet = Feet::new(work);
    let Some(floor) = of(&feet) else {
        return [None, None, in_height];
    };
    let slope = floor.is_sloped().then(|| floor.slope_shown_by(&feet.slow()));
    let over_ground = drift(&feet, &floor.drift).map(|mut drift| {
        drift.iter_mut().for_each(|at| at.z = 0.0);
        extent(&drift)
    });
    [slope, over_ground.filter(|extent| *extent > 0.0), in_height]
}

/// The largest distance by which a drift moves the body, in metres.
fn extent(drift: &[DVec3]) -> f64 {
    let ends = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (first, last) = drift
        .iter()
        .fold(ends, |(least, most), at| (least.min(*at), most.max(*at)));
    (last - first).length()
}

/// The repairs of the floor. `None` for a repair that was not needed.
#[derive(Default)]
pub(super) struct FloorOutcome {
    pub(super) height: Option<f64>,
    pub(super) slope: Option<f64>,
    pub(super) drift: Option<f64>,
    /// The largest displacement of the body along the axis of a camera, in metres.
    pub(super) depth: Option<f64>,
}

/// The points of the feet. A position has three coordinates in metres: along the two axes of the ground, and up.
pub(super) struct Feet {
    /// The kind of each point (0 for ankles, 1 for balls), and its position in every frame.
    points: Vec<(usize, Vec<DVec3>)>,
    /// For each point, -0.5 on the left side and 0.5 on the right.
    sides: Vec<f64>,
    rate: f64,
    frames: usize,
}

/// The two axes of the ground, and up.
pub(super) fn axes(up: Vec3) -> [Vec3; 3] {
    let first = up.any_orthonormal_vector();
    [first, up.cross(first), up]
}

impl Feet {
    pub(super) fn new(work: &Work<'_>) -> Self {
        let kinds = points_of_feet(work.scene, &work.figure.humanoid);
        let nodes: Vec<_> = kinds.iter().flatten().map(|(_, node)| *node).collect();
        let kind = |index: usize| usize::from(index >= kinds[0].len());
        let [x, y, up] = axes(work.up);
        let metres = work.metres;
        let local = |point: &Vec3| (Vec3::new(point.dot(x), point.dot(y), point.dot(up)) * metres).as_dvec3();
        let tracks = tracks(&work.frames, work.scene, &nodes);
        let points = tracks.iter().enumerate();
        let half = |bone: &HumanoidBone| if bone.side() == Some(Side::Left) { -0.5 } else { 0.5 };
        Self {
            sides: kinds.iter().flatten().map(|(bone, _)| half(bone)).collect(),
            points: points
                .map(|(index, track)| (kind(index), track.iter().map(local).collect()))
                .collect(),
            rate: work.frames.rate,
            frames: work.frames.len(),
        }
    }

    /// The frames in which both feet have a long stance, each with the velocity of the slower foot. A drift moves both
    /// feet, but a shuffling figure moves one foot at a time.
    fn standing(&self) -> Vec<(usize, DVec3)> {
        let best = self.points.iter().map(|point| point.0).max().unwrap_or_default();
        let mut feet = self
            .points
            .iter()
            .filter(|point| point.0 == best)
            .map(|point| self.stands(&point.1));
        let (Some(left), Some(right)) = (feet.next(), feet.next()) else {
            return Vec::new();
        };
        let both = left.into_iter().zip(right).enumerate();
        both.filter_map(|(frame, (left, right))| {
            let (left, right) = (left?, right?);
            Some((frame, if left.length() < right.length() { left } else { right }))
        })
        .collect()
    }

    /// For each frame, the velocity in m/s of the slowest point of the feet. Only low points that are slower than
    /// `fastest` count. `None` if there is no such point.
    pub(super) fn ground(&self, fastest: f64) -> Vec<Option<DVec3>> {
        let half = ((0.5 * OVER * self.rate).round() as usize).max(1);
        let levels: Vec<f64> = self
            .points
            .iter()
            .map(|point| low(point.1.iter().map(|at| at.z)))
            .collect();
        let velocity = |(point, level): (&(usize, Vec<DVec3>), &f64), frame: usize| {
            let (track, end) = (&point.1, self.frames - 1);
            let (from, to) = (frame.saturating_sub(half), (frame + half).min(end));
            let velocity = (track[to] - track[from]) * self.rate / (to - from).max(1) as f64;
            (track[frame].z < level + 2.0 * LOW && velocity.length() < fastest).then_some(velocity)
        };
        let of_frame = |frame: usize| {
            let points = self
                .points
                .iter()
                .zip(&levels)
                .filter_map(|point| velocity(point, frame));
            points.min_by(|a, b| a.length().total_cmp(&b.length()))
        };
        (0..self.frames).map(of_frame).collect()
    }

    /// The velocity of a point during each stance longer than [`STANDS`]. At both ends of a stance, half of [`OVER`] is
    /// left out. `None` in other frames.
    fn stands(&self, track: &[DVec3]) -> Vec<Option<DVec3>> {
        let half = ((0.5 * OVER * self.rate).round() as usize).max(1);
        let least = (STANDS * self.rate) as usize;
        let level = low(track.iter().map(|at| at.z));
        let velocity = |frame: usize| (track[frame + half] - track[frame - half]) * self.rate / (2 * half) as f64;
        let mut found = vec![None; self.frames];
        let mut from = half;
        let inner = self.frames.saturating_sub(half);
        for (frame, at) in track.iter().enumerate().take(inner).skip(half) {
            let stands = velocity(frame).length() < 0.5 * SLOW && at.z < level + LOW;
            let end = if stands { frame + 1 } else { frame };
            let is_last = frame + half + 1 >= self.frames;
            if (!stands || is_last) && end > from + least {
                for (inside, found) in found.iter_mut().enumerate().take(end - half).skip(from + half) {
                    *found = Some(velocity(inside));
                }
            }
            if !stands {
                from = frame + 1;
            }
        }
        found
    }

    /// The points in the frames in which they are slow.
    fn slow(&self) -> Vec<SlowPoint> {
        let half = ((0.5 * OVER * self.rate).round() as usize).max(1);
        let seconds = 2.0 * half as f64 / self.rate;
        let mut found = Vec::new();
        for ((kind, track), side) in self.points.iter().zip(&self.sides) {
            for frame in half..self.frames.saturating_sub(half) {
                if (track[frame + half] - track[frame - half]).length() < SLOW * seconds {
                    found.push(SlowPoint {
                        at: track[frame].as_vec3(),
                        frame: frame as u32,
                        kind: *kind as u8,
                        is_right: *side > 0.0,
                    });
                }
            }
        }
        found
    }
}

/// A slow point of a foot in one frame. The type is small, because a motion of hours has one for almost every frame.
struct SlowPoint {
    at: Vec3,
    frame: u32,
    kind: u8,
    is_right: bool,
}

impl SlowPoint {
    fn at(&self) -> DVec3 {
        self.at.as_dvec3()
    }

    fn kind(&self) -> usize {
        usize::from(self.kind)
    }

    /// -0.5 on the left side, 0.5 on the right.
    fn side(&self) -> f64 {
        if self.is_right { 0.5 } else { -0.5 }
    }
}

/// The unknowns of the fit are two levels, two rises, a height difference and the knots of the drift. This constant has
/// the indices of the two rises.
const RISES: [usize; 2] = [2, 3];
/// The index of the height difference between the right and the left foot among the unknowns.
const RIGHT_OVER_LEFT: usize = 4;
/// The index of the first knot of the drift among the unknowns.
const DRIFT: usize = 5;
/// The floor of a motion; `None` if no foot is ever slow.
pub(super) fn find(work: &Work<'_>) -> Option<Floor> {
    let height = height(work);
    Some(Floor {
        height,
        ..of(&Feet::new(work))?
    })
}

/// The height of the ground in metres, as [`FootPoints::ground`] computes it for all commands; 0 if it is unknown.
fn height(work: &Work<'_>) -> f64 {
    let points = FootPoints::new(work.scene, &work.figure.humanoid, work.up);
    let levels = levels(&tracks_of_feet(work), work.up, work.metres, work.frames.rate);
    let ground = points.ground(&levels);
    ground.map_or(0.0, |ground| f64::from(ground.height() * work.metres))
}

/// The positions in every frame of the points that show the height of the ground, in one list for each kind of point.
fn tracks_of_feet(work: &Work<'_>) -> [Vec<Vec<Vec3>>; 3] {
    let points = FootPoints::new(work.scene, &work.figure.humanoid, work.up);
    // Computes all kinds of points in one pass over the frames, because the poses take most of the time.
    let mut all = tracks(&work.frames, work.scene, &points.nodes.concat()).into_iter();
    points.nodes.map(|nodes| all.by_ref().take(nodes.len()).collect())
}

/// Fits a floor to the feet.
fn of(feet: &Feet) -> Option<Floor> {
    let points = feet.slow();
    if points.len() < 8 {
        return None;
    }
    let centre = points.iter().map(SlowPoint::at).sum::<DVec3>() / points.len() as f64;
    let knots = Knots::new(feet.frames, KNOT * feet.rate, KNOTS);
    let of_kind = |kind: usize| {
        points
            .iter()
            .filter(move |point| point.kind() == kind)
            .map(|point| point.at().z)
    };
    let mut levels = [0, 1].map(|kind| low(of_kind(kind)));
    let mut right_over_left = 0.0;
    let mut floor = Floor {
        centre,
        drift: vec![0.0; feet.frames],
        ..Floor::default()
    };
    // The noise of neighbouring frames is correlated, so the frames of [`ONE_OBSERVATION`] count as one observation.
    let one = 1.0 / (OF_FOOT.powi(2) * (ONE_OBSERVATION * feet.rate).max(1.0));
    for round in 0..ROUNDS {
        let part = round as f64 / (ROUNDS - 1) as f64;
        let scale = SCALES[0] * (SCALES[1] / SCALES[0]).powf((1.3 * part).min(1.0));
        let mut equations = LeastSquares::new(DRIFT + knots.count);
        for point in &points {
            let (at, kind, side) = (point.at(), point.kind(), point.side());
            let from = at - centre;
            let residual = at.z - levels[kind] - floor.above(point) - right_over_left * side;
            let weight = if residual > 0.0 {
                biweight(residual / scale)
            } else {
                biweight(residual / (4.0 * scale))
            };
            if weight > 0.0 {
                let [knot, next] = knots.terms(point.frame as usize, DRIFT);
                let rises = [(RISES[0], from.x), (RISES[1], from.y)];
                let terms = [(kind, 1.0), rises[0], rises[1], (RIGHT_OVER_LEFT, side), knot, next];
                equations.add(&terms, at.z, one * weight);
            }
        }
        for (kind, level) in levels.iter().enumerate() {
            equations.add(&[(kind, 1.0)], *level, 1e-6 * one);
        }
        for rise in RISES {
            equations.add(&[(rise, 1.0)], 0.0, OF_RISE.powi(-2));
        }
        equations.add(&[(RIGHT_OVER_LEFT, 1.0)], 0.0, OF_SIDES.powi(-2));
        knots.add_priors(&mut equations, DRIFT, OF_DRIFT[1].powi(-2), OF_DRIFT[0].powi(-2));
        let solution = equations.solve()?;
        let found = &solution.values;
        levels = [found[0], found[1]];
        floor.rise = RISES.map(|rise| found[rise]);
        right_over_left = found[RIGHT_OVER_LEFT];
        floor.drift = knots.curve(&found[DRIFT..]);
        if round + 1 == ROUNDS {
            let of_rises = |one: usize, other: usize| solution.covariance(RISES[one], RISES[other]);
            let [a, b, c] = [of_rises(0, 0), of_rises(0, 1), of_rises(1, 1)];
            let [x, y] = floor.rise;
            floor.certain = ((c * x * x - 2.0 * b * x * y + a * y * y) / (a * c - b * b))
                .max(0.0)
                .sqrt();
        }
    }
    let near = |height: &dyn Fn(&SlowPoint) -> f64| {
        let is_near = |point: &&SlowPoint| (point.at().z - levels[point.kind()] - height(point)).abs() < NEAR;
        points.iter().filter(is_near).count() as f64
    };
    // The number of points near a level plane, at the height where this number is largest.
    let heights = (0..=40).map(|step| near(&|_: &SlowPoint| f64::from(step - 20) * 0.02));
    let level = heights.fold(1.0, f64::max);
    (floor.levels, floor.right_over_left) = (levels, right_over_left);
    floor.explains = near(&|point: &SlowPoint| floor.above(point)) / level;
    Some(floor)
}

/// The 10th percentile of the heights.
fn low(heights: impl Iterator<Item = f64>) -> f64 {
    let mut heights: Vec<f64> = heights.collect();
    heights.sort_unstable_by(f64::total_cmp);
    heights.get(heights.len() / 10).copied().unwrap_or_default()
}

/// Removes the slope of the floor and the drift of the body over the ground. Then it moves the floor to height 0 in
/// three cases: if it removed a slope or a drift, if the height is outside [`KEPT_HEIGHTS`], or if `always` is set.
pub(super) fn level(work: &mut Work<'_>, always: bool) -> Option<FloorOutcome> {
    let carrier = work.carrier()?;
    let mut done = FloorOutcome::default();
    let floor = of(&Feet::new(work))?;
    let [x, y, up] = axes(work.up);
    let slope = floor.slope();
    if floor.is_sloped() {
        let normal = up - x * floor.rise[0] as f32 - y * floor.rise[1] as f32;
        let turn = Quat::from_rotation_arc(normal.normalize(), up);
        let metres = work.metres;
        let pivot = (x * floor.centre.x as f32 + y * floor.centre.y as f32 + up * floor.centre.z as f32) / metres;
        let motion = Mat4::from_translation(pivot) * Mat4::from_quat(turn) * Mat4::from_translation(-pivot);
        work.carry(carrier, |_| motion);
        done.slope = Some(slope);
    }
    let drift = drift(&Feet::new(work), &floor.drift);
    if let Some(drift) = &drift {
        let metres = work.metres;
        work.carry(carrier, |frame| {
            let by = drift[frame.min(drift.len() - 1)].as_vec3();
            Mat4::from_translation(-(x * by.x + y * by.y + up * by.z) / metres)
        });
        done.drift = Some(extent(drift));
    }
    let is_moved = done.slope.is_some() || done.drift.is_some();
    if always || is_moved || !KEPT_HEIGHTS.contains(&height(work)) {
        done.height = bring_to_zero(work);
    }
    Some(done)
}

/// Moves the floor to height 0. Returns its previous height if it was not 0.
pub(super) fn bring_to_zero(work: &mut Work<'_>) -> Option<f64> {
    let height = Some(height(work)).filter(|height| *height != 0.0)?;
    let by = Mat4::from_translation(-work.up * height as f32 / work.metres);
    work.carry(work.carrier()?, |_| by);
    Some(height)
}

/// Puts the motion of a figure on the floor. Returns the removed height of the floor in metres, slope in degrees and
/// drift of the body in metres. `None` stands for a value that was not removed.
pub(super) fn put_on_floor(scene: &mut Scene, figure: &Figure, animation: usize) -> Result<[Option<f64>; 3]> {
    let mut work = Work::new(scene, figure, &[], animation)?;
    let Some(done) = level(&mut work, true) else {
        return Ok([None; 3]);
    };
    let frames = work.frames.changes();
    let moved: Vec<_> = frames.nodes().to_vec();
    frames.write(scene, animation, &moved, &moved);
    Ok([Some(done.height.unwrap_or_default()), done.slope, done.drift])
}
