//! Lengths of bones, centres of joints and offsets of markers, together with the poses of some frames.
//!
//! All unknowns are refined together by Gauss-Newton. The unknowns of each pose are eliminated (Schur's complement), so
//! that a step costs as much as its frames. Where a joint moves, the motion of the markers tells its centre, as the
//! symmetric centre of rotation does (Ehrig et al., J. Biomech. 39, 2006), and bent knees and elbows tell their axes
//! (Ehrig et al., J. Biomech. 40, 2007), for markers of all segments at once; where it does not, the centre stays at
//! its regression.

use glam::DVec3;
use mocap_scene::math::cholesky;

use super::fit::{self, Fit, add_term};
use super::model::{Freedom, Model, Pose, World};

/// Steps over all frames at most, which bound the time.
const STEPS: usize = 15;

/// The step in metres below which the calibration ends: half of the noise of cameras.
const SMALLEST_STEP: f64 = 5e-4;

/// The weight of a frame, as a part of that of an independent one. Segments that bend and joints that are no hinges are
/// off in the same direction in all frames, which no number of frames corrects. With 1, planted centres are off by 5.0
/// mm in the mean of eight seeds of `tools/markers/planted.py`, with 0.3 and 0.5 by 4.4 and 4.3 mm.
const MOST_INDEPENDENT: f64 = 0.4;

/// A pose with the markers that were seen.
pub(super) struct Frame {
    pub(super) pose: Pose,
    pub(super) seen: Vec<Option<DVec3>>,
}

/// Which unknown is what.
struct Unknowns {
    /// The first of each joint's offset.
    offsets: Vec<Option<usize>>,
    /// The first of the offsets of markers.
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

/// How well the offset of a joint is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Certainty {
    /// The standard deviation in metres, from the covariance, and from its regression alone.
    pub(super) deviation: f64,
    pub(super) before: f64,
}

/// How much a frame counts of an independent one, by the part of noise in how far markers are from their bodies. Noise
/// of the cameras is another one in every frame, and sliding skin is not.
fn independence(model: &Model, noise: f64) -> f64 {
    let all = model.slides * model.slides;
    let noise = f64::min(noise * noise, all);
    (all / (noise + (all - noise) / model.weights.independent_slide)).min(MOST_INDEPENDENT)
}

/// Refines the body and the poses, and says how well each joint is known then. `first` has the regressions, `noise` is
/// that of a coordinate of a marker, in metres.
pub(super) fn calibrate(model: &mut Model, first: &Model, frames: &mut [Frame], noise: f64) -> Vec<Option<Certainty>> {
    model.slides = model.weights.slide;
    let unknowns = Unknowns::of(model);
    let mut fit = Fit::default();
    let mut factor = None;
    for _ in 0..STEPS {
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
            eliminated((model, counts), &unknowns, frame, &fit.world, (&mut matrix, &mut right));
        }
        prior(model, first, &unknowns, |term| {
            add_term(&mut matrix, &mut right, unknowns.count, term);
        });
        cholesky::solve(&mut matrix, &mut right, unknowns.count);
        let Some(largest) = fit::largest(&right) else { break };
        factor = Some(matrix);
        change(model, &unknowns, &right);
        // How far markers slide is told by the take, once the body is near.
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

/// The deviations of joints, of which `factor` is Cholesky's factor of the inverse covariance of the body.
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

/// Adds what a frame says of the body, after its pose has followed; it counts as so much of an independent one.
fn eliminated(
    (model, counts): (&Model, f64),
    unknowns: &Unknowns,
    frame: &Frame,
    world: &World,
    (matrix, right): (&mut [f64], &mut [f64]),
) {
    let (poses, bodies) = (model.unknowns, unknowns.count);
    let mut own = vec![0.0; poses * poses];
    let mut own_right = vec![0.0; poses];
    // A column of the body's unknowns is a row here.
    let mut mixed = vec![0.0; bodies * poses];
    let (mut moves, mut grows) = (Vec::new(), Vec::new());
    for (marker, seen) in frame.seen.iter().enumerate() {
        let Some(seen) = seen else { continue };
        let off = *seen - model.marker(marker, world);
        let weight = fit::weight(off.length(), model.weights.outlier) / (model.slides * model.slides) * counts;
        model.moves(marker, world, &mut moves);
        model.grows(marker, world, &unknowns.offsets, unknowns.markers, &mut grows);
        for &(row, a) in &moves {
            own_right[row] += weight * a.dot(off);
            for &(column, b) in &moves {
                own[row * poses + column] += weight * a.dot(b);
            }
        }
        for &(row, a) in &grows {
            right[row] += weight * a.dot(off);
            for &(column, b) in &grows {
                if column <= row {
                    matrix[row * bodies + column] += weight * a.dot(b);
                }
            }
            for &(column, b) in &moves {
                mixed[row * poses + column] += weight * a.dot(b);
            }
        }
    }
    model.terms(&frame.pose, world, |(value, slopes)| {
        let root = counts.sqrt();
        let slopes: Vec<(usize, f64)> = slopes.iter().map(|(column, slope)| (*column, slope * root)).collect();
        add_term(&mut own, &mut own_right, poses, (value * root, &slopes));
    });
    for row in 0..poses {
        own[row * poses + row] += 1e-3;
    }
    cholesky::factor_envelope(&mut own, &model.envelope);
    cholesky::forward_envelope(&own, &mut own_right, &model.envelope, 0);
    // Each unknown of the body with the first of the pose with which it has to do.
    let mut touched: Vec<(usize, usize)> = Vec::new();
    for body in 0..bodies {
        let row = &mut mixed[body * poses..(body + 1) * poses];
        if let Some(first) = row.iter().position(|value| *value != 0.0) {
            cholesky::forward_envelope(&own, row, &model.envelope, first);
            touched.push((body, first));
        }
    }
    for (index, &(body, first)) in touched.iter().enumerate() {
        let row = &mixed[body * poses..(body + 1) * poses];
        right[body] -= cholesky::dot(&row[first..], &own_right[first..]);
        for &(other, own) in &touched[..=index] {
            let from = first.max(own);
            let other_row = &mixed[other * poses + from..(other + 1) * poses];
            matrix[body * bodies + other] -= cholesky::dot(&row[from..], other_row);
        }
    }
}

/// What the regressions say of the body.
fn prior(model: &Model, first: &Model, unknowns: &Unknowns, mut add: impl FnMut(super::model::Term<'_>)) {
    let mut vector = |column: usize, off: DVec3, deviation: f64| {
        for axis in 0..3 {
            add((off[axis] / deviation, &[(column + axis, 1.0 / deviation)]));
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
            add((off / deviation, &[(column, 1.0 / deviation)]));
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
