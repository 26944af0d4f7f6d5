//! Floating-base inverse kinematics: solves for the pose in which links reach their goals, within the limits of the
//! joints.
//!
//! It is damped Gauss-Newton on the rotation vectors of links and the positions of points. Each step solves the normal
//! equations by Cholesky decomposition. Limits are a box: joints that a step would move beyond a limit are held at the
//! limit, and the others are solved again (projected, as in D. Bertsekas, "Projected Newton methods for optimization
//! problems with simple constraints", SIAM J. Control Optim. 20, 1982). The solver starts from the pose of the previous
//! frame.

use glam::{DQuat, DVec3};
use mocap_scene::math::cholesky;
use mocap_scene::scene::robot::Placement;

use super::kinematics::{Kinematics, RobotPose};
use super::terms::{Goals, ROOT, Terms};

/// The largest rotation of a joint in a step, in radians. The linear terms are not valid farther away.
const LARGEST_STEP: f64 = 0.6;

/// The step below which the solver ends, in radians or metres: near the last of six decimals in a file.
const SMALLEST_STEP: f64 = 2e-6;

/// The number of rounds in which joints are held at their limits. In a limb, at most this number of joints reach their
/// limits at once.
const ROUNDS: usize = 4;

/// The limits of the positions in a frame.
#[derive(Clone, Debug)]
pub struct Bounds {
    pub lower: Vec<f64>,
    pub upper: Vec<f64>,
}

impl Bounds {
    /// The limits of the robot's file.
    pub(super) fn of(kinematics: &Kinematics) -> Self {
        let bodies = &kinematics.bodies[1..];
        Self {
            lower: bodies.iter().map(|body| body.limits.lower).collect(),
            upper: bodies.iter().map(|body| body.limits.upper).collect(),
        }
    }
}

/// A solver for one frame after another.
#[derive(Clone, Debug)]
pub struct Solver {
    pub(super) terms: Terms,
    /// The weight of the change of a joint from the previous frame, in 1/rad^2.
    hold: f64,
    step: Vec<f64>,
    scratch: Vec<f64>,
}

impl Solver {
    pub fn new(terms: Terms, hold: f64) -> Self {
        Self {
            step: vec![0.0; terms.size()],
            terms,
            hold,
            scratch: Vec::new(),
        }
    }

    /// Moves `pose` to the goals, in at most `steps` steps.
    pub fn solve(
        &mut self,
        kinematics: &Kinematics,
        goals: &Goals,
        bounds: &Bounds,
        pose: &mut RobotPose,
        steps: usize,
    ) {
        let before = pose.positions.clone();
        for position in 0..pose.positions.len() {
            let (lower, upper) = (bounds.lower[position], bounds.upper[position]);
            pose.positions[position] = pose.positions[position].max(lower).min(upper);
        }
        kinematics.update(pose);
        for _ in 0..steps {
            self.terms.assemble(kinematics, goals, pose);
            for index in 0..self.terms.positions.len() {
                let position = self.terms.positions[index];
                let back = before[position] - pose.positions[position];
                self.terms.add_position(self.terms.base + index, self.hold, back);
            }
            self.bounded_step(bounds, pose);
            let largest = self.step.iter().fold(0.0_f64, |largest, step| largest.max(step.abs()));
            let scale = (LARGEST_STEP / largest).min(1.0);
            self.apply(bounds, pose, scale);
            kinematics.update(pose);
            if largest < SMALLEST_STEP {
                break;
            }
        }
    }

    /// The step of all unknowns within the limits.
    fn bounded_step(&mut self, bounds: &Bounds, pose: &RobotPose) {
        let size = self.terms.gradient.len();
        let mut fixed: Vec<Option<f64>> = vec![None; size];
        for (index, &position) in self.terms.positions.iter().enumerate() {
            let (at, pull) = (pose.positions[position], self.terms.gradient[self.terms.base + index]);
            let is_held = (at <= bounds.lower[position] && pull < 0.0) || (at >= bounds.upper[position] && pull > 0.0);
            fixed[self.terms.base + index] = is_held.then_some(0.0);
        }
        for _ in 0..ROUNDS {
            self.solve_free(&fixed);
            let mut is_within = true;
            for (index, &position) in self.terms.positions.iter().enumerate() {
                let unknown = self.terms.base + index;
                if fixed[unknown].is_some() {
                    continue;
                }
                let at = pose.positions[position] + self.step[unknown];
                let kept = at.max(bounds.lower[position]).min(bounds.upper[position]);
                if kept != at {
                    fixed[unknown] = Some(kept - pose.positions[position]);
                    is_within = false;
                }
            }
            if is_within {
                break;
            }
        }
    }

    /// The step of the free unknowns for the given steps of the fixed unknowns.
    fn solve_free(&mut self, fixed: &[Option<f64>]) {
        let size = self.terms.gradient.len();
        let free: Vec<usize> = (0..size).filter(|unknown| fixed[*unknown].is_none()).collect();
        let count = free.len();
        let normal = |a: usize, b: usize| self.terms.normal[a.max(b) * size + a.min(b)];
        self.scratch.clear();
        self.scratch.resize(count * count + count, 0.0);
        let (matrix, right) = self.scratch.split_at_mut(count * count);
        for (row, &a) in free.iter().enumerate() {
            for (column, &b) in free[..=row].iter().enumerate() {
                matrix[row * count + column] = normal(a, b);
            }
            let taken = fixed.iter().enumerate();
            let taken: f64 = taken
                .filter_map(|(other, step)| Some(normal(a, other) * step.filter(|step| *step != 0.0)?))
                .sum();
            right[row] = self.terms.gradient[a] - taken;
        }
        cholesky::solve(matrix, right, count);
        for (unknown, step) in self.step.iter_mut().enumerate() {
            *step = fixed[unknown].unwrap_or_default();
        }
        for (row, &unknown) in free.iter().enumerate() {
            self.step[unknown] = right[row];
        }
    }

    fn apply(&self, bounds: &Bounds, pose: &mut RobotPose, scale: f64) {
        let step = |index: usize| scale * self.step[index];
        if self.terms.base == ROOT {
            pose.root = moved(&pose.root, std::array::from_fn(step));
        }
        for (index, &position) in self.terms.positions.iter().enumerate() {
            let at = pose.positions[position] + step(self.terms.base + index);
            pose.positions[position] = at.max(bounds.lower[position]).min(bounds.upper[position]);
        }
    }
}

/// The base after a step of its unknowns.
pub(super) fn moved(root: &Placement, step: [f64; ROOT]) -> Placement {
    let [x, y, z, turn @ ..] = step;
    Placement {
        rotation: (DQuat::from_scaled_axis(DVec3::from_array(turn)) * root.rotation).normalize(),
        translation: root.translation + DVec3::new(x, y, z),
    }
}
