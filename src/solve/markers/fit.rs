//! A pose from the markers of a frame: damped Gauss-Newton with robust weights, from a pose nearby.
//!
//! Weights are those of Geman and McClure (1987): a marker that is far off, because it was taken for another or is a
//! reflection, pulls little.

use glam::{DMat3, DQuat, DVec3};
use mocap_scene::math::cholesky;

use super::model::{Model, Pose, World};

/// Where markers are in a frame, in metres; none where they were not seen.
pub(super) type Seen = [Option<DVec3>];

/// Iterations at most, which bound the time of a frame.
const ITERATIONS: usize = 12;

/// The step in radians or metres below which a frame is solved: half of the noise of cameras.
const SMALLEST_STEP: f64 = 5e-4;

/// What is known of every unknown, of a radian or a metre, so that equations have a solution.
const LEAST_INFORMATION: f64 = 1e-3;

/// The largest turn in a step, in radians: farther away the linear terms do not hold.
const LARGEST_STEP: f64 = 0.5;

/// What joints do in a frame, as other frames say: the joint, its rotation to its parent, and the standard deviation of
/// that in radians.
pub(super) type Toward = [(usize, DQuat, f64)];

/// What a fit needs of memory, used again for every frame.
#[derive(Debug, Default)]
pub(super) struct Fit {
    pub(super) world: World,
    matrix: Vec<f64>,
    right: Vec<f64>,
    /// The sum of the steps of a frame.
    moved: Vec<f64>,
    loads: Vec<Load>,
}

/// Weighted sums over the markers that a joint moves, of their arms about the joint and of their deviations.
///
/// With these sums the normal equations cost a few products for each marker, and a block for each pair of joints on a
/// chain. The inertia of composite bodies is computed so too (Featherstone, Rigid Body Dynamics Algorithms, 2008,
/// chapter 6).
#[derive(Clone, Copy, Debug, Default)]
struct Load {
    weight: f64,
    arms: DVec3,
    /// Of products of arms: row and column are coordinates.
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

    /// Adds the sums of a joint that stands so far from this one.
    fn add_child(&mut self, child: &Self, arm: DVec3) {
        self.weight += child.weight;
        self.arms += child.arms + arm * child.weight;
        let across = outer(child.arms, arm);
        self.squares += child.squares + across + across.transpose() + outer(arm, arm * child.weight);
        self.force += child.force;
        self.moment += child.moment + arm.cross(child.force);
    }
}

/// The products of the coordinates of `a`, which are rows, with those of `b`.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
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
        self.fit_toward(model, pose, seen, &[]);
    }

    /// As [`fit`](Self::fit), and to rotations that other frames tell.
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

    /// The standard deviation of the rotation of each joint in its parent, in radians, by the markers that are seen.
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

    /// Adds the rows of the unknowns of all joints above, and of the root, in the columns of a joint's rotation. A turn
    /// `u` moves a marker by its cross product with the arm of the marker.
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

    /// How far markers that are seen are from where the pose has them, in metres.
    pub(super) fn distances(&self, model: &Model, seen: &Seen) -> Vec<Option<f64>> {
        let distance =
            |(marker, seen): (usize, &Option<DVec3>)| seen.map(|seen| seen.distance(model.marker(marker, &self.world)));
        seen.iter().enumerate().map(distance).collect()
    }
}
