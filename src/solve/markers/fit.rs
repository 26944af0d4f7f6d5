//! A pose from the markers of a frame: damped Gauss-Newton with robust weights, from a pose nearby.
//!
//! Weights are those of Geman and McClure (1987): a marker that is far off, because it was taken for another or is a
//! reflection, pulls little.

use glam::DVec3;
use mocap_scene::math::cholesky;

use super::model::{Model, Pose, World};

/// Where markers are in a frame, in metres; none where they were not seen.
pub(super) type Seen = [Option<DVec3>];

/// Iterations at most, which bound the time of a frame.
const ITERATIONS: usize = 12;

/// The step in radians or metres below which a frame is solved: half of the noise of cameras.
const SMALLEST_STEP: f64 = 5e-4;

/// The largest turn in a step, in radians: farther away the linear terms do not hold.
const LARGEST_STEP: f64 = 0.5;

/// What a fit needs of memory, used again for every frame.
#[derive(Debug, Default)]
pub(super) struct Fit {
    pub(super) world: World,
    matrix: Vec<f64>,
    right: Vec<f64>,
    /// The sum of the steps of a frame.
    moved: Vec<f64>,
    columns: Vec<(usize, DVec3)>,
}

/// The largest size of a step's numbers; none where one is not finite, and the step is none.
pub(super) fn largest(step: &[f64]) -> Option<f64> {
    step.iter().try_fold(0.0_f64, |most, number| {
        number.is_finite().then(|| most.max(number.abs()))
    })
}

/// The weight of a marker that is so far from where it should be; at `outlier` it is a quarter.
pub(super) fn weight(distance: f64, outlier: f64) -> f64 {
    let ratio = distance / outlier;
    1.0 / (1.0 + ratio * ratio).powi(2)
}

/// Adds `value` with its derivatives to normal equations, of which the lower triangle is kept.
pub(super) fn add_term(matrix: &mut [f64], right: &mut [f64], size: usize, (value, slopes): super::model::Term<'_>) {
    for &(row, a) in slopes {
        right[row] -= a * value;
        for &(column, b) in slopes {
            if column <= row {
                matrix[row * size + column] += a * b;
            }
        }
    }
}

impl Fit {
    /// Brings `pose` to the markers.
    pub(super) fn fit(&mut self, model: &Model, pose: &mut Pose, seen: &Seen) {
        let size = model.unknowns;
        self.moved.clear();
        self.moved.resize(size, 0.0);
        let deviation = model.weights.hold;
        for _ in 0..ITERATIONS {
            self.normal_equations(model, pose, seen);
            for row in 0..size {
                let hold = if row >= model.root {
                    1.0
                } else {
                    1.0 / (deviation * deviation)
                };
                self.matrix[row * size + row] += hold;
                self.right[row] -= hold * self.moved[row];
            }
            cholesky::solve_envelope(&mut self.matrix, &mut self.right, &model.envelope);
            let Some(largest) = largest(&self.right) else { break };
            if largest > LARGEST_STEP {
                self.right.iter_mut().for_each(|step| *step *= LARGEST_STEP / largest);
            }
            model.step(pose, &self.world, &self.right);
            std::iter::zip(&mut self.moved, &self.right).for_each(|(moved, step)| *moved += step);
            if largest < SMALLEST_STEP {
                break;
            }
        }
        model.world(pose, &mut self.world);
    }

    fn normal_equations(&mut self, model: &Model, pose: &Pose, seen: &Seen) {
        let size = model.unknowns;
        self.matrix.clear();
        self.matrix.resize(size * size, 0.0);
        self.right.clear();
        self.right.resize(size, 0.0);
        model.world(pose, &mut self.world);
        for (marker, seen) in seen.iter().enumerate() {
            let Some(seen) = seen else { continue };
            let off = *seen - model.marker(marker, &self.world);
            let weight = weight(off.length(), model.weights.outlier) / (model.slides * model.slides);
            model.moves(marker, &self.world, &mut self.columns);
            for (index, &(row, a)) in self.columns.iter().enumerate() {
                let a = a * weight;
                self.right[row] += a.dot(off);
                let here = &mut self.matrix[row * size..(row + 1) * size];
                for &(column, b) in &self.columns[..=index] {
                    here[column] += a.dot(b);
                }
            }
        }
        let (matrix, right) = (&mut self.matrix, &mut self.right);
        model.terms(pose, &self.world, |term| add_term(matrix, right, size, term));
    }

    /// How far markers that are seen are from where the pose has them, in metres.
    pub(super) fn distances(&self, model: &Model, seen: &Seen) -> Vec<Option<f64>> {
        let distance =
            |(marker, seen): (usize, &Option<DVec3>)| seen.map(|seen| seen.distance(model.marker(marker, &self.world)));
        seen.iter().enumerate().map(distance).collect()
    }
}
