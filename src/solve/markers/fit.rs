//! Fits a pose to the markers of a frame: damped Gauss-Newton with robust weights, from a nearby pose.
//!
//! The weights are those of Geman and McClure (1987): a distant marker, such as a reflection or a swapped label, pulls
//! little.

use glam::{DMat3, DQuat, DVec3};
use mocap_scene::math::cholesky;

use super::model::{Model, Pose, World};

/// Marker positions in a frame, in metres; `None` if a marker was not seen.
pub(super) type Seen = [Option<DVec3>];

/// The largest number of iterations, which bounds the time of a frame.
const ITERATIONS: usize = 12;

/// The step in radians or metres below which a frame is solved: half of the camera noise.
const SMALLEST_STEP: f64 = 5e-4;

/// The prior weight of every unknown, per squared radian or metre, so that the equations have a solution.
const LEAST_INFORMATION: f64 = 1e-3;

/// The largest rotation in an iteration, in radians. Beyond it the linearization does not hold.
const LARGEST_STEP: f64 = 0.5;

/// The expected pose of joints in a frame, from other frames: the joint, its rotation relative to its parent, and the
/// standard deviation of the rotation in radians.
pub(super) type Toward = [(usize, DQuat, f64)];

/// The buffers of a fit, reused for every frame.
#[derive(Debug, Default)]
pub(super) struct Fit {
    pub(super) world: World,
    matrix: Vec<f64>,
    right: Vec<f64>,
    /// The sum of the iteration steps of a frame.
    moved: Vec<f64>,
    loads: Vec<Load>,
}

/// Weighted sums over the markers that a joint moves, of their lever arms about the joint and of their residuals.
///
/// With these sums the normal equations cost a few products for each marker, and a block for each pair of joints on a
/// chain. Composite-body inertia is computed in the same way (Featherstone, Rigid Body Dynamics Algorithms, 2008,
/// chapter 6).
#[derive(Clone, Copy, Debug, Default)]
struct Load {
    weight: f64,
    arms: DVec3,
    /// Products of lever arms: row and column are coordinates.
    squares: DMat3,
    force: DVec3,
    moment: DVec3,
}

impl Load {
    fn add(&mut self, weight: f64, arm: DVec3, off: DVec3) {
        let (weighted, force) = (arm * weight, off * weight);
        self.weight += weight;
        self.arms += weighted;
        self.squares += outer(arm, weighted);
        self.force += force;
        self.moment += arm.cross(force);
    }

    /// Adds the sums of a child joint at the offset `arm`.
    fn add_child(&mut self, child: &Self, arm: DVec3) {
        self.weight += child.weight;
        self.arms += child.arms + arm * child.weight;
        let across = outer(child.arms, arm);
        self.squares += child.squares + across + across.transpose() + outer(arm, arm * child.weight);
        self.force += child.force;
        self.moment += child.moment + arm.cross(child.force);
    }
}

/// The products of the coordinates of `a`, which are rows, with the coordinates of `b`.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// The largest absolute value of a step; `None` if a value is not finite, because the step is then invalid.
pub(super) fn largest(step: &[f64]) -> Option<f64> {
    step.iter().try_fold(0.0_f64, |most, number| {
        number.is_finite().then(|| most.max(number.abs()))
    })
}

/// The weight of a marker at a distance from its expected position. At the distance `outlier` it is a quarter.
pub(super) fn weight(distance: f64, outlier: f64) -> f64 {
    let ratio = distance / outlier;
    1.0 / (1.0 + ratio * ratio).powi(2)
}

/// Adds `value` with its derivatives to the normal equations, which store only the lower triangle.
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
    /// Fits `pose` to the markers.
    pub(super) fn fit(&mut self, model: &Model, pose: &mut Pose, seen: &Seen) {
        self.fit_toward(model, pose, seen, &[]);
    }

    /// Like [`fit`](Self::fit), and also toward the rotations that other frames predict.
    pub(super) fn fit_toward(&mut self, model: &Model, pose: &mut Pose, seen: &Seen, toward: &Toward) {
        let size = model.unknowns;
        self.moved.clear();
        self.moved.resize(size, 0.0);
        let deviation = model.weights.hold;
        for _ in 0..ITERATIONS {
            self.normal_equations(model, pose, seen);
            for &(joint, rotation, deviation) in toward {
                let (matrix, right) = (&mut self.matrix, &mut self.right);
                model.toward(joint, pose, &self.world, (rotation, deviation), |term| {
                    add_term(matrix, right, size, term);
                });
            }
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
        self.loads.clear();
        self.loads.resize(model.joints.len(), Load::default());
        for (marker, seen) in seen.iter().enumerate() {
            let Some(seen) = seen else { continue };
            let arm = model.arm(marker, &self.world);
            let joint = model.markers[marker].joint;
            let off = *seen - (self.world.positions[joint] + arm);
            let weight = weight(off.length(), model.weights.outlier) / (model.slides * model.slides);
            self.loads[joint].add(weight, arm, off);
        }
        for joint in (0..model.joints.len()).rev() {
            self.add_joint(model, joint);
            if let Some(parent) = model.joints[joint].parent {
                let arm = self.world.positions[joint] - self.world.positions[parent];
                let load = self.loads[joint];
                self.loads[parent].add_child(&load, arm);
            }
        }
        let load = &self.loads[0];
        for axis in 0..3 {
            let row = model.root + axis;
            self.matrix[row * size + row] += load.weight;
            self.right[row] += load.force[axis];
        }
        let (matrix, right) = (&mut self.matrix, &mut self.right);
        model.terms(pose, &self.world, |term| add_term(matrix, right, size, term));
    }

    /// The standard deviation of each joint's rotation relative to its parent, in radians, given the seen markers.
    pub(super) fn deviations(&mut self, model: &Model, pose: &Pose, seen: &Seen) -> Vec<f64> {
        self.normal_equations(model, pose, seen);
        let size = model.unknowns;
        for row in 0..size {
            self.matrix[row * size + row] += LEAST_INFORMATION;
        }
        cholesky::factor_envelope(&mut self.matrix, &model.envelope);
        let variance = |unknown: usize| {
            let mut unit = vec![0.0; size];
            unit[unknown] = 1.0;
            cholesky::forward_envelope(&self.matrix, &mut unit, &model.envelope, unknown);
            unit.iter().map(|value| value * value).sum::<f64>()
        };
        let deviation = |unknown: &Option<usize>| {
            unknown.map_or(0.0, |first| (first..first + 3).map(variance).fold(0.0, f64::max).sqrt())
        };
        model.unknown.iter().map(deviation).collect()
    }

    /// Adds the rows of all ancestor joints, and of the root position, in the columns of a joint's rotation. A rotation
    /// `u` moves a marker by the cross product of `u` with the marker's lever arm.
    fn add_joint(&mut self, model: &Model, joint: usize) {
        let Some(column) = model.unknown[joint] else { return };
        let (size, load) = (model.unknowns, &self.loads[joint]);
        for &above in model.chain(joint) {
            let Some(row) = model.unknown[above] else { continue };
            let arm = self.world.positions[joint] - self.world.positions[above];
            let sums = load.squares + outer(load.arms, arm);
            let trace = sums.x_axis.x + sums.y_axis.y + sums.z_axis.z;
            for up in 0..3 {
                let own = if row == column { up + 1 } else { 3 };
                for axis in 0..own {
                    let here = &mut self.matrix[(row + up) * size + column + axis];
                    *here -= sums.col(axis)[up];
                    if axis == up {
                        *here += trace;
                    }
                }
            }
        }
        for (axis, unit) in DVec3::AXES.into_iter().enumerate() {
            let moved = unit.cross(load.arms);
            for up in 0..3 {
                self.matrix[(model.root + up) * size + column + axis] += moved[up];
            }
            self.right[column + axis] += load.moment[axis];
        }
    }

    /// The distance of each seen marker from its position in the pose, in metres.
    pub(super) fn distances(&self, model: &Model, seen: &Seen) -> Vec<Option<f64>> {
        let distance =
            |(marker, seen): (usize, &Option<DVec3>)| seen.map(|seen| seen.distance(model.marker(marker, &self.world)));
        seen.iter().enumerate().map(distance).collect()
    }
}
