//! Calibrates bone lengths, joint centres and marker offsets, together with the poses of some frames.
//!
//! Gauss-Newton refines all unknowns together. The unknowns of each pose are eliminated (Schur's complement), so that
//! the cost of an iteration is proportional to the number of frames.
//!
//! If a joint moves, the marker motion determines its centre, as in the symmetric centre of rotation (Ehrig et al., J.
//! Biomech. 39, 2006). Bent knees and elbows determine their axes (Ehrig et al., J. Biomech. 40, 2007). Here the
//! markers of all segments count at once. If a joint does not move, its centre stays where the regressions of `centres`
//! put it.

use glam::{DQuat, DVec3};
use mocap_scene::math::cholesky;
use mocap_scene::math::spread::spread;
use mocap_scene::math::wide;

use super::fit::{self, Fit};
use super::model::{Freedom, Model, Pose, World};

/// The largest number of iterations over all frames, which bounds the time.
pub(super) const STEPS: usize = 15;

/// The number of iterations of a first calibration. Its body solves the poses of other frames, which calibrate the body
/// again.
pub(super) const FIRST_STEPS: usize = 5;

/// The step in metres below which the calibration ends: half of the camera noise.
const SMALLEST_STEP: f64 = 5e-4;

/// The largest weight of a frame, as a fraction of the weight of an independent frame. Soft segments and joints that
/// are not hinges cause the same error in all frames, so more frames do not correct it. With 1, planted centres have a
/// mean error of 5.0 mm over eight seeds of `tools/markers/planted.py`; with 0.3 and 0.5 it is 4.4 and 4.3 mm.
const MOST_INDEPENDENT: f64 = 0.4;

/// The distance at which a marker has a quarter of its weight, as a factor of the standard deviation of markers. A
/// reflection that is nearer than the weight [`outlier`](super::MarkerWeights) would move the body otherwise.
const FAR: f64 = 20.0;

/// The number of frames in a part. A core works on a whole part, and the parts are summed in order. So the number of
/// cores does not change the result.
const PART: usize = 10;

/// A pose with the seen markers.
pub(super) struct Frame {
    pub(super) pose: Pose,
    pub(super) seen: Vec<Option<DVec3>>,
}

/// The indices of the unknowns.
struct Unknowns {
    /// The index of the first unknown of each joint's offset.
    offsets: Vec<Option<usize>>,
    /// The index of the first unknown of the marker offsets.
    markers: usize,
    count: usize,
}

impl Unknowns {
    fn of(model: &Model) -> Self {
        let mut count = 0;
        let offsets = model
            .joints
            .iter()
            .map(|joint| {
                let size = match joint.freedom {
                    Freedom::Fixed => return None,
                    Freedom::Length => 1,
                    Freedom::Position(_) => 3,
                };
                count += size;
                Some(count - size)
            })
            .collect();
        Self {
            offsets,
            markers: count,
            count: count + 3 * model.markers.len(),
        }
    }

    /// For each block of the pose, the unknowns of the body that move the markers of the block.
    fn coupled(&self, model: &Model, world: &World) -> Vec<Vec<usize>> {
        let mut coupled = vec![vec![false; self.count]; model.unknowns / 3];
        let mut grows = Vec::new();
        for (marker, own) in model.markers.iter().enumerate() {
            model.grows(marker, world, &self.offsets, self.markers, &mut grows);
            let joints = model.chain(own.joint).iter().filter_map(|joint| model.unknown[*joint]);
            for block in joints.chain([model.root]) {
                grows.iter().for_each(|(row, _)| coupled[block / 3][*row] = true);
            }
        }
        let indices = |own: &Vec<bool>| (0..own.len()).filter(|index| own[*index]).collect();
        coupled.iter().map(indices).collect()
    }
}

/// The uncertainty of a joint's offset.
#[derive(Clone, Copy, Debug)]
pub(super) struct Certainty {
    /// The standard deviation in metres from the covariance. `before` is the deviation from the regression alone.
    pub(super) deviation: f64,
    pub(super) before: f64,
}

/// The weight of a frame relative to an independent frame. It grows with the share of noise in the marker residuals.
/// Camera noise is independent in every frame, but skin sliding is not.
fn independence(model: &Model, noise: f64) -> f64 {
    let all = model.slides * model.slides;
    let noise = f64::min(noise * noise, all);
    (all / (noise + (all - noise) / model.weights.independent_slide)).min(MOST_INDEPENDENT)
}

/// Refines the body and the poses, and returns the uncertainty of each joint. `first` has the regressions. `noise` is
/// the noise of a marker coordinate, in metres.
///
/// The body is refined in `steps` iterations, or in fewer if it no longer changes.
pub(super) fn calibrate(
    model: &mut Model,
    first: &Model,
    frames: &mut [Frame],
    (noise, steps): (f64, usize),
) -> Vec<Option<Certainty>> {
    let unknowns = Unknowns::of(model);
    let mut factor = None;
    for _ in 0..steps {
        bend_about_means(model, frames);
        let counts = independence(model, noise);
        let parts: Vec<&[Frame]> = frames.chunks(PART).collect();
        let parts = spread(&parts, |part| Equations::of((model, counts), &unknowns, part));
        let mut sums = Equations::new(&unknowns);
        for (frames, mut part) in std::iter::zip(frames.chunks_mut(PART), parts) {
            std::iter::zip(frames, part.poses.drain(..)).for_each(|(frame, pose)| frame.pose = pose);
            sums.add(&part);
        }
        let Equations {
            mut matrix,
            mut right,
            squares,
            weights,
            ..
        } = sums;
        prior(model, first, &unknowns, |column, value, slope| {
            right[column] -= slope * value;
            matrix[column * unknowns.count + column] += slope * slope;
        });
        cholesky::solve(&mut matrix, &mut right, unknowns.count);
        let Some(largest) = fit::largest(right.iter().copied()) else {
            break;
        };
        factor = Some(matrix);
        change(model, &unknowns, &right);
        // Near the solution, the take shows how far markers slide.
        model.slides = (squares / f64::max(3.0 * weights, 1.0))
            .sqrt()
            .max(model.weights.least_slide)
            .min(model.slides);
        model.outlier = f64::min(FAR * model.slides, model.weights.outlier);
        if largest < SMALLEST_STEP {
            break;
        }
    }
    model.outlier = model.weights.outlier;
    let mut fit = Fit::default();
    for frame in frames {
        fit.fit(model, &mut frame.pose, &frame.seen);
    }
    match factor {
        Some(factor) => certainties(model, &unknowns, &factor),
        None => vec![None; model.joints.len()],
    }
}

/// The usual rotations of the joints become their means in the frames. If a joint is bent in all frames, its bend is no
/// evidence of a wrong centre.
fn bend_about_means(model: &mut Model, frames: &[Frame]) {
    let joints = model.joints.iter_mut().enumerate();
    for (index, joint) in joints.filter(|(_, joint)| joint.is_shown) {
        let rotations = frames.iter().map(|frame| frame.pose.local[index]);
        let sum = rotations.reduce(|sum, own| sum + if sum.dot(own) < 0.0 { -own } else { own });
        joint.usual = sum.map_or(joint.usual, DQuat::normalize);
    }
}

/// The standard deviations of the joints. `factor` is the Cholesky factor of the inverse covariance of the body.
fn certainties(model: &Model, unknowns: &Unknowns, factor: &[f64]) -> Vec<Option<Certainty>> {
    let variance = |column: usize| {
        let mut unit = vec![0.0; unknowns.count];
        unit[column] = 1.0;
        cholesky::forward(factor, &mut unit, unknowns.count);
        unit.iter().map(|value| value * value).sum::<f64>()
    };
    let certainty = |(joint, column): (&super::model::Joint, &Option<usize>)| {
        let column = (*column)?;
        let (size, before) = match joint.freedom {
            Freedom::Fixed => return None,
            Freedom::Length => (1, model.weights.length),
            Freedom::Position(deviation) => (3, deviation * 3.0_f64.sqrt()),
        };
        let deviation = (column..column + size).map(variance).sum::<f64>().sqrt();
        Some(Certainty { deviation, before })
    };
    std::iter::zip(&model.joints, &unknowns.offsets)
        .map(certainty)
        .collect()
}

/// The equations of some frames for the body, with the poses eliminated.
struct Equations {
    /// The lower triangle, row by row.
    matrix: Vec<f64>,
    right: Vec<f64>,
    /// The weighted sum of the squared distances of markers, in square metres, and the sum of the weights.
    squares: f64,
    weights: f64,
    poses: Vec<Pose>,
}

impl Equations {
    fn new(unknowns: &Unknowns) -> Self {
        Self {
            matrix: vec![0.0; unknowns.count * unknowns.count],
            right: vec![0.0; unknowns.count],
            squares: 0.0,
            weights: 0.0,
            poses: Vec::new(),
        }
    }

    fn add(&mut self, other: &Self) {
        std::iter::zip(&mut self.matrix, &other.matrix).for_each(|(own, other)| *own += other);
        std::iter::zip(&mut self.right, &other.right).for_each(|(own, other)| *own += other);
        self.squares += other.squares;
        self.weights += other.weights;
    }

    /// Fits the poses of `frames`, and sums up the equations. `counts` is the weight of a frame relative to an
    /// independent frame.
    fn of((model, counts): (&Model, f64), unknowns: &Unknowns, frames: &[Frame]) -> Self {
        let mut sums = Self::new(unknowns);
        let mut fit = Fit::default();
        let (bodies, blocks) = (unknowns.count, model.unknowns / 3);
        model.world(&frames[0].pose, &mut fit.world);
        let coupled = unknowns.coupled(model, &fit.world);
        // For each block of the pose and each frame, three rows with a column for each coupled unknown of the body.
        let pairs: usize = coupled.iter().map(Vec::len).sum();
        let mut columns = vec![0.0; 3 * pairs * frames.len()];
        let mut mixed = vec![DVec3::ZERO; bodies * blocks];
        for (index, frame) in frames.iter().enumerate() {
            let mut pose = frame.pose.clone();
            fit.fit(model, &mut pose, &frame.seen);
            for distance in fit.distances(model, &frame.seen).into_iter().flatten() {
                let weight = fit::weight(distance, model.outlier);
                sums.squares += distance * distance * weight;
                sums.weights += weight;
            }
            mixed.fill(DVec3::ZERO);
            fit.factor_of(model, &pose, &frame.seen);
            sums.add_markers((model, counts), unknowns, (&frame.seen, &fit), &mut mixed);
            let mut own_right = std::mem::take(&mut fit.right);
            fit.matrix.forward(&model.tree, &mut own_right);
            mixed
                .chunks_exact_mut(blocks)
                .for_each(|row| fit.matrix.forward(&model.tree, row));
            let mut at = 0;
            for (block, coupled) in coupled.iter().enumerate() {
                let count = coupled.len();
                let rows = &mut columns[3 * (at + count * index)..][..3 * count];
                for (column, &body) in coupled.iter().enumerate() {
                    let own = mixed[body * blocks + block];
                    sums.right[body] -= counts * own.dot(own_right[block]);
                    (0..3).for_each(|axis| rows[axis * count + column] = own[axis]);
                }
                at += count * frames.len();
            }
            fit.right = own_right;
            sums.poses.push(pose);
        }
        sums.subtract_products(counts, &coupled, (&columns, frames.len()));
        sums
    }

    /// Adds the equations of the markers of a frame for the body. Writes the products of derivatives with respect to
    /// the body, which are rows, and with respect to the blocks of the pose to `mixed`.
    fn add_markers(
        &mut self,
        (model, counts): (&Model, f64),
        unknowns: &Unknowns,
        (seen, fit): (&[Option<DVec3>], &Fit),
        mixed: &mut [DVec3],
    ) {
        let (bodies, blocks, world) = (unknowns.count, model.unknowns / 3, &fit.world);
        let mut grows = Vec::new();
        for (marker, seen) in seen.iter().enumerate() {
            let Some(seen) = seen else { continue };
            let at = model.marker(marker, world);
            let off = *seen - at;
            let weight = fit::weight(off.length(), model.outlier) / (model.slides * model.slides);
            model.grows(marker, world, &unknowns.offsets, unknowns.markers, &mut grows);
            for &(row, own) in &grows {
                let pull = own * weight;
                self.right[row] += counts * pull.dot(off);
                let line = &mut self.matrix[row * bodies..=row * bodies + row];
                for &(column, other) in &grows {
                    if column <= row {
                        line[column] += counts * pull.dot(other);
                    }
                }
                mixed[row * blocks + model.root / 3] += pull;
            }
            // A rotation `u` moves the marker by the cross product of `u` with the lever arm.
            for &joint in model.chain(model.markers[marker].joint) {
                let Some(unknown) = model.unknown[joint] else { continue };
                let arm = (at - world.positions[joint]) * weight;
                for &(row, own) in &grows {
                    mixed[row * blocks + unknown / 3] += arm.cross(own);
                }
            }
        }
    }

    /// Subtracts the products of the columns that belong to the same block.
    fn subtract_products(&mut self, counts: f64, coupled: &[Vec<usize>], (columns, frames): (&[f64], usize)) {
        let bodies = self.right.len();
        let mut columns = columns;
        let mut sums = vec![0.0; bodies];
        for coupled in coupled {
            let (own, others) = columns.split_at(3 * frames * coupled.len());
            columns = others;
            for (index, &body) in coupled.iter().enumerate() {
                let line = &mut self.matrix[body * bodies..=body * bodies + body];
                let sums = &mut sums[..=index];
                sums_of_products(sums, own, coupled.len());
                std::iter::zip(coupled, sums).for_each(|(column, sum)| line[*column] -= counts * *sum);
            }
        }
    }
}

wide::dispatch! {
    /// Writes the sums of the products of the last column with each column to `sums`. `rows` has three rows of `count`
    /// columns for each frame.
    fn sums_of_products(sums: &mut [f64], rows: &[f64], count: usize) {
        let size = sums.len();
        sums.fill(0.0);
        for frame in rows.chunks_exact(3 * count) {
            let (x, y, z) = (&frame[..size], &frame[count..count + size], &frame[2 * count..2 * count + size]);
            let own = [x[size - 1], y[size - 1], z[size - 1]];
            for at in 0..size {
                sums[at] += x[at] * own[0] + y[at] * own[1] + z[at] * own[2];
            }
        }
    }
}

/// The equations that pull the body toward the regressions. `add` takes the index of an unknown, a residual divided by
/// its standard deviation, and the derivative of the residual.
fn prior(model: &Model, first: &Model, unknowns: &Unknowns, mut add: impl FnMut(usize, f64, f64)) {
    let mut vector = |column: usize, off: DVec3, deviation: f64| {
        for axis in 0..3 {
            add(column + axis, off[axis] / deviation, 1.0 / deviation);
        }
    };
    for (joint, column) in unknowns.offsets.iter().enumerate() {
        let (Some(column), off) = (*column, model.joints[joint].offset - first.joints[joint].offset) else {
            continue;
        };
        if let Freedom::Position(deviation) = model.joints[joint].freedom {
            vector(column, off, deviation);
        }
    }
    for (marker, (own, first)) in std::iter::zip(&model.markers, &first.markers).enumerate() {
        vector(unknowns.markers + 3 * marker, own.offset - first.offset, own.spread);
    }
    for (joint, column) in unknowns.offsets.iter().enumerate() {
        if let (Some(column), Freedom::Length) = (*column, model.joints[joint].freedom) {
            let off = model.joints[joint].offset.length() - first.joints[joint].offset.length();
            let deviation = model.weights.length;
            add(column, off / deviation, 1.0 / deviation);
        }
    }
}

fn change(model: &mut Model, unknowns: &Unknowns, step: &[f64]) {
    for (joint, column) in unknowns.offsets.iter().enumerate() {
        let (Some(column), joint) = (*column, &mut model.joints[joint]) else {
            continue;
        };
        match joint.freedom {
            Freedom::Fixed => {}
            Freedom::Length => joint.offset += joint.offset.normalize_or_zero() * step[column],
            Freedom::Position(_) => joint.offset += DVec3::from_slice(&step[column..column + 3]),
        }
    }
    for (marker, own) in model.markers.iter_mut().enumerate() {
        own.offset += DVec3::from_slice(&step[unknowns.markers + 3 * marker..][..3]);
    }
}
