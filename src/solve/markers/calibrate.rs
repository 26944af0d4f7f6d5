//! Calibrates bone lengths, joint centres and marker offsets, together with the poses of some frames.
//!
//! Gauss-Newton refines all unknowns together. The unknowns of each pose are eliminated (Schur's complement), so that
//! the cost of an iteration is linear in the frames.
//!
//! If a joint moves, the marker motion determines its centre, as in the symmetric centre of rotation (Ehrig et al., J.
//! Biomech. 39, 2006). Bent knees and elbows determine their axes (Ehrig et al., J. Biomech. 40, 2007). Here the
//! markers of all segments count at once. If a joint does not move, its centre stays at its regression.

use glam::DVec3;
use mocap_scene::math::cholesky;

use super::fit::{self, Fit};
use super::model::{Freedom, Model, Pose};

/// The largest number of iterations over all frames, which bounds the time.
pub(super) const STEPS: usize = 15;

/// The number of iterations for a body from which other frames are solved, to calibrate it again.
pub(super) const FIRST_STEPS: usize = 5;

/// The step in metres below which the calibration ends: half of the camera noise.
const SMALLEST_STEP: f64 = 5e-4;

/// The largest weight of a frame, as a fraction of the weight of an independent frame. Soft segments and joints that
/// are not hinges cause the same error in all frames, so more frames do not correct it. With 1, planted centres have a
/// mean error of 5.0 mm over eight seeds of `tools/markers/planted.py`; with 0.3 and 0.5 it is 4.4 and 4.3 mm.
const MOST_INDEPENDENT: f64 = 0.4;

/// A pose with the seen markers.
pub(super) struct Frame {
    pub(super) pose: Pose,
    pub(super) seen: Vec<Option<DVec3>>,
}

/// The indices of the unknowns.
struct Unknowns {
    /// The first unknown of each joint's offset.
    offsets: Vec<Option<usize>>,
    /// The first unknown of the marker offsets.
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
/// The body has `steps` iterations, or fewer if it no longer changes.
pub(super) fn calibrate(
    model: &mut Model,
    first: &Model,
    frames: &mut [Frame],
    (noise, steps): (f64, usize),
) -> Vec<Option<Certainty>> {
    model.slides = model.weights.slide;
    let unknowns = Unknowns::of(model);
    let mut fit = Fit::default();
    let mut factor = None;
    for _ in 0..steps {
        let counts = independence(model, noise);
        let mut matrix = vec![0.0; unknowns.count * unknowns.count];
        let mut right = vec![0.0; unknowns.count];
        let (mut squares, mut seen) = (0.0, 0.0);
        for frame in frames.iter_mut() {
            fit.fit(model, &mut frame.pose, &frame.seen);
            for distance in fit.distances(model, &frame.seen).into_iter().flatten() {
                let weight = fit::weight(distance, model.weights.outlier);
                squares += distance * distance * weight;
                seen += weight;
            }
            eliminated((model, counts), &unknowns, frame, &mut fit, (&mut matrix, &mut right));
        }
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
        model.slides = (squares / f64::max(3.0 * seen, 1.0))
            .sqrt()
            .max(model.weights.least_slide)
            .min(model.slides);
        if largest < SMALLEST_STEP {
            break;
        }
    }
    for frame in frames {
        fit.fit(model, &mut frame.pose, &frame.seen);
    }
    match factor {
        Some(factor) => certainties(model, &unknowns, &factor),
        None => vec![None; model.joints.len()],
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

/// Adds a frame's equations for the body, with its pose eliminated. `counts` is the weight relative to an independent
/// frame.
fn eliminated(
    (model, counts): (&Model, f64),
    unknowns: &Unknowns,
    frame: &Frame,
    fit: &mut Fit,
    (matrix, right): (&mut [f64], &mut [f64]),
) {
    let bodies = unknowns.count;
    fit.factor_of(model, &frame.pose, &frame.seen);
    let (tree, world) = (&model.tree, &fit.world);
    let blocks = fit.right.len();
    // Each column of the body's unknowns is stored as a row here, in blocks of the pose.
    let mut mixed = vec![DVec3::ZERO; bodies * blocks];
    let (mut moves, mut grows) = (Vec::new(), Vec::new());
    for (marker, seen) in frame.seen.iter().enumerate() {
        let Some(seen) = seen else { continue };
        let off = *seen - model.marker(marker, world);
        let weight = fit::weight(off.length(), model.weights.outlier) / (model.slides * model.slides);
        model.moves(marker, world, &mut moves);
        model.grows(marker, world, &unknowns.offsets, unknowns.markers, &mut grows);
        for &(row, a) in &grows {
            right[row] += counts * weight * a.dot(off);
            for &(column, b) in &grows {
                if column <= row {
                    matrix[row * bodies + column] += counts * weight * a.dot(b);
                }
            }
            for &(column, b) in &moves {
                mixed[row * blocks + column / 3][column % 3] += weight * a.dot(b);
            }
        }
    }
    let mut own_right = std::mem::take(&mut fit.right);
    fit.matrix.forward(tree, &mut own_right);
    // For each block of the pose, the unknowns of the body that are coupled to it.
    let mut coupled: Vec<Vec<(usize, DVec3)>> = vec![Vec::new(); blocks];
    for body in 0..bodies {
        let row = &mut mixed[body * blocks..(body + 1) * blocks];
        fit.matrix.forward(tree, row);
        for (block, own) in row.iter().enumerate().filter(|(_, own)| **own != DVec3::ZERO) {
            coupled[block].push((body, *own));
            right[body] -= counts * own.dot(own_right[block]);
        }
    }
    for coupled in &coupled {
        for (index, &(body, own)) in coupled.iter().enumerate() {
            let (line, own) = (&mut matrix[body * bodies..(body + 1) * bodies], own * counts);
            for &(other, across) in &coupled[..=index] {
                line[other] -= own.dot(across);
            }
        }
    }
    fit.right = own_right;
}

/// The regressions as equations for the body. `add` takes an unknown, a residual divided by its standard deviation, and
/// its derivative.
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
