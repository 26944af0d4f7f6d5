//! Fits a pose to the markers of a frame: damped Gauss-Newton with robust weights, from a nearby pose.
//!
//! The weights follow Geman and McClure (1987): a distant marker, such as a reflection or a swapped label, pulls
//! little.

use glam::{DMat3, DQuat, DVec3};

use super::model::{Model, Pose, Term, World};
use super::tree::TreeMatrix;

/// Marker positions in a frame, in metres; `None` if a marker was not seen.
pub(super) type Seen = [Option<DVec3>];

/// The largest number of iterations, which bounds the time of a frame.
const ITERATIONS: usize = 12;

/// The step in radians or metres below which a frame is solved: half of the camera noise.
pub(super) const SMALLEST_STEP: f64 = 5e-4;

/// The prior weight of every unknown, per squared radian or metre, so that the equations have a solution.
const LEAST_INFORMATION: f64 = 1e-3;

/// The largest rotation in an iteration, in radians. For a larger rotation, the linearization does not hold.
const LARGEST_STEP: f64 = 0.5;

/// The expected pose of joints in a frame, from other frames: the joint, its rotation relative to its parent, and the
/// standard deviation of the rotation in radians.
pub(super) type Toward = [(usize, DQuat, f64)];

/// The buffers of a fit, reused for every frame.
#[derive(Debug, Default)]
pub(super) struct Fit {
    pub(super) world: World,
    /// The normal equations, and after a solution their factor.
    pub(super) matrix: TreeMatrix,
    pub(super) right: Vec<DVec3>,
    /// The sum of the iteration steps of a frame.
    moved: Vec<DVec3>,
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

/// Adds a term to the normal equations.
fn add_term(model: &Model, matrix: &mut TreeMatrix, right: &mut [DVec3], (value, first, slope): Term) {
    right[first / 3] -= slope * value;
    *matrix.block(&model.tree, first / 3, 0) += outer(slope, slope);
}

/// The products of the coordinates of `a`, which are rows, with the coordinates of `b`.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// The largest absolute value of a step; `None` if a value is not finite, because the step is then invalid.
pub(super) fn largest(step: impl Iterator<Item = f64>) -> Option<f64> {
    step.map(f64::abs)
        .try_fold(0.0_f64, |most, size| size.is_finite().then(|| most.max(size)))
}

/// The weight of a marker at a distance from its expected position. At the distance `outlier` it is a quarter.
pub(super) fn weight(distance: f64, outlier: f64) -> f64 {
    let ratio = distance / outlier;
    1.0 / (1.0 + ratio * ratio).powi(2)
}

impl Fit {
    /// Fits `pose` to the markers.
    pub(super) fn fit(&mut self, model: &Model, pose: &mut Pose, seen: &Seen) {
        self.fit_toward(model, pose, seen, &[]);
    }

    /// Like [`fit`](Self::fit), and also toward the rotations that other frames predict.
    pub(super) fn fit_toward(&mut self, model: &Model, pose: &mut Pose, seen: &Seen, toward: &Toward) {
        let tree = &model.tree;
        self.moved.clear();
        self.moved.resize(model.unknowns / 3, DVec3::ZERO);
        let held = 1.0 / (model.weights.hold * model.weights.hold);
        for _ in 0..ITERATIONS {
            self.normal_equations(model, pose, seen);
            for &(joint, rotation, deviation) in toward {
                let (matrix, right) = (&mut self.matrix, &mut self.right);
                model.toward(joint, pose, &self.world, (rotation, deviation), |term| {
                    add_term(model, matrix, right, term);
                });
            }
            for (block, moved) in self.moved.iter().enumerate() {
                let hold = if 3 * block == model.root { 1.0 } else { held };
                self.matrix.add_diagonal(tree, block, hold);
                self.right[block] -= *moved * hold;
            }
            self.matrix.factor(tree);
            self.matrix.forward(tree, &mut self.right);
            self.matrix.backward(tree, &mut self.right);
            let Some(largest) = largest(self.right.iter().flat_map(DVec3::to_array)) else {
                break;
            };
            if largest > LARGEST_STEP {
                self.right.iter_mut().for_each(|step| *step *= LARGEST_STEP / largest);
            }
            model.step(pose, &self.world, &self.right);
            std::iter::zip(&mut self.moved, &self.right).for_each(|(moved, step)| *moved += *step);
            if largest < SMALLEST_STEP {
                break;
            }
        }
        model.world(pose, &mut self.world);
    }

    /// The normal equations of a pose.
    pub(super) fn normal_equations(&mut self, model: &Model, pose: &Pose, seen: &Seen) {
        self.matrix.clear(&model.tree);
        self.right.clear();
        self.right.resize(model.unknowns / 3, DVec3::ZERO);
        model.world(pose, &mut self.world);
        self.loads.clear();
        self.loads.resize(model.joints.len(), Load::default());
        for (marker, seen) in seen.iter().enumerate() {
            let Some(seen) = seen else { continue };
            let arm = model.arm(marker, &self.world);
            let joint = model.markers[marker].joint;
            let off = *seen - (self.world.positions[joint] + arm);
            let weight = weight(off.length(), model.outlier) / (model.slides * model.slides);
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
        let (load, root) = (&self.loads[0], model.root / 3);
        self.matrix.add_diagonal(&model.tree, root, load.weight);
        self.right[root] += load.force;
        let (matrix, right) = (&mut self.matrix, &mut self.right);
        model.terms(pose, &self.world, |term| add_term(model, matrix, right, term));
    }

    /// The standard deviation of each joint's rotation relative to its parent, in radians, given the seen markers.
    pub(super) fn deviations(&mut self, model: &Model, pose: &Pose, seen: &Seen) -> Vec<f64> {
        self.factor_of(model, pose, seen);
        let largest = |unknown: usize| self.matrix.variances(&model.tree, unknown / 3).max_element().sqrt();
        model
            .unknown
            .iter()
            .map(|unknown| unknown.map_or(0.0, largest))
            .collect()
    }

    /// The normal equations of a pose, with the factor of their matrix.
    pub(super) fn factor_of(&mut self, model: &Model, pose: &Pose, seen: &Seen) {
        self.normal_equations(model, pose, seen);
        for block in 0..self.right.len() {
            self.matrix.add_diagonal(&model.tree, block, LEAST_INFORMATION);
        }
        self.matrix.factor(&model.tree);
    }

    /// Adds the rows of all ancestor joints, and of the root position, in the columns of a joint's rotation. A rotation
    /// `u` moves a marker by the cross product of `u` with the marker's lever arm.
    fn add_joint(&mut self, model: &Model, joint: usize) {
        let Some(column) = model.unknown[joint] else { return };
        let (tree, load, block) = (&model.tree, &self.loads[joint], column / 3);
        let above = model
            .chain(joint)
            .iter()
            .filter(|above| model.unknown[**above].is_some());
        for (level, &above) in above.enumerate() {
            let arm = self.world.positions[joint] - self.world.positions[above];
            let sums = load.squares + outer(load.arms, arm);
            let trace = sums.x_axis.x + sums.y_axis.y + sums.z_axis.z;
            *self.matrix.block(tree, block, level) += DMat3::from_diagonal(DVec3::splat(trace)) - sums;
        }
        let [x, y, z] = DVec3::AXES.map(|unit| unit.cross(load.arms));
        let root = tree.chain(block).len() - 1;
        *self.matrix.block(tree, block, root) += DMat3::from_cols(x, y, z);
        self.right[block] += load.moment;
    }

    /// The distance of each seen marker from its position in the pose, in metres.
    pub(super) fn distances(&self, model: &Model, seen: &Seen) -> Vec<Option<f64>> {
        let distance =
            |(marker, seen): (usize, &Option<DVec3>)| seen.map(|seen| seen.distance(model.marker(marker, &self.world)));
        seen.iter().enumerate().map(distance).collect()
    }
}
