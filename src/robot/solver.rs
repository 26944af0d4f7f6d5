//! Floating-base inverse kinematics: the pose whose links are where they should be, within the limits of the joints.
//!
//! Damped Gauss-Newton on the rotation vectors of links and the positions of points, each step the solution of the
//! normal equations by Cholesky's decomposition. Limits are a box: joints that a step would bring beyond are held at
//! the limit, and the others are solved again (projected, as in D. Bertsekas, "Projected Newton methods for
//! optimization problems with simple constraints", SIAM J. Control Optim. 20, 1982). It begins at the pose of the frame
//! before.

use glam::{DMat3, DQuat, DVec3};

use super::kinematics::{Kinematics, RobotPose};
use crate::scene::robot::{JointKind, Placement};

/// The unknowns of the base: three of its position and three of its rotation.
const ROOT: usize = 6;

/// How much a joint is held where it was in the frame before, against a turn of a link by the same angle.
const HOLD: f64 = 4e-4;

/// Against directions in which nothing changes.
const DAMPING: f64 = 1e-9;

/// The largest turn of a joint in a step, in radians.
const LARGEST_STEP: f64 = 0.6;

/// A step below this, in radians or metres, is the last.
const SMALLEST_STEP: f64 = 2e-6;

/// Rounds of holding joints at their limits.
const ROUNDS: usize = 4;

/// How a link should be turned.
#[derive(Clone, Debug)]
pub(super) struct Turn {
    pub(super) body: usize,
    /// The axes of the weights, in the frame of the body.
    pub(super) weight_axes: DQuat,
    /// Squares of the weights about these axes.
    pub(super) weights: DVec3,
    /// The rotation of the body to the world.
    pub(super) target: DQuat,
}

/// Where a point of a link should be.
#[derive(Clone, Debug)]
pub(super) struct Reach {
    pub(super) body: usize,
    pub(super) point: DVec3,
    /// The square of the weight, of a metre against a radian.
    pub(super) weight: f64,
    pub(super) target: DVec3,
}

/// What a pose should be.
#[derive(Clone, Debug, Default)]
pub(super) struct Goals {
    pub(super) turns: Vec<Turn>,
    pub(super) reaches: Vec<Reach>,
}

/// The limits of the positions in a frame.
#[derive(Clone, Debug)]
pub(super) struct Bounds {
    pub(super) lower: Vec<f64>,
    pub(super) upper: Vec<f64>,
}

/// Solves one frame after another.
#[derive(Clone, Debug)]
pub(super) struct Solver {
    /// The unknown of each position, and how much it moves with that; none for joints that carry no bone.
    unknown: Vec<Option<(usize, f64)>>,
    /// The position of each unknown after those of the base.
    positions: Vec<usize>,
    normal: Vec<f64>,
    gradient: Vec<f64>,
    step: Vec<f64>,
    columns: Vec<(usize, DVec3, DVec3)>,
    scratch: Vec<f64>,
}

impl Solver {
    /// A solver that moves the joints that turn the bodies of `goals`.
    pub(super) fn new(kinematics: &Kinematics, goals: &Goals) -> Self {
        let count = kinematics.bodies.len() - 1;
        let mut used = vec![false; count];
        let bodies = goals.turns.iter().map(|turn| turn.body);
        for body in bodies.chain(goals.reaches.iter().map(|reach| reach.body)) {
            for &joint in &kinematics.bodies[body].chain {
                used[joint - 1] = true;
            }
        }
        // A follower has the unknown of its leader.
        for follower in &kinematics.followers {
            used[follower.leader] |= std::mem::take(&mut used[follower.position]);
        }
        let positions: Vec<usize> = (0..count).filter(|position| used[*position]).collect();
        let mut unknown = vec![None; count];
        for (index, &position) in positions.iter().enumerate() {
            unknown[position] = Some((ROOT + index, 1.0));
        }
        for follower in &kinematics.followers {
            let leader: Option<(usize, f64)> = unknown[follower.leader];
            unknown[follower.position] = leader.map(|(unknown, _)| (unknown, follower.multiplier));
        }
        let size = ROOT + positions.len();
        Self {
            unknown,
            positions,
            normal: vec![0.0; size * size],
            gradient: vec![0.0; size],
            step: vec![0.0; size],
            columns: Vec::new(),
            scratch: Vec::new(),
        }
    }

    /// Moves `pose` to the goals, in at most `steps` steps.
    pub(super) fn solve(
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
            self.assemble(kinematics, goals, pose, &before);
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

    fn assemble(&mut self, kinematics: &Kinematics, goals: &Goals, pose: &RobotPose, before: &[f64]) {
        let size = self.gradient.len();
        self.normal.fill(0.0);
        self.gradient.fill(0.0);
        for index in 0..size {
            self.normal[index * size + index] = DAMPING;
        }
        for (index, &position) in self.positions.iter().enumerate() {
            let unknown = ROOT + index;
            self.normal[unknown * size + unknown] += HOLD;
            self.gradient[unknown] += HOLD * (before[position] - pose.positions[position]);
        }
        for turn in &goals.turns {
            let place = &pose.bodies[turn.body];
            let axes = DMat3::from_quat(place.rotation * turn.weight_axes);
            let weights = axes * DMat3::from_diagonal(turn.weights) * axes.transpose();
            let error = rotation_vector(turn.target * place.rotation.inverse());
            self.collect(kinematics, pose, turn.body, place.translation);
            self.add(weights, error, |(_, angular, _)| *angular);
        }
        for reach in goals.reaches.iter().filter(|reach| reach.weight > 0.0) {
            let point = pose.bodies[reach.body].point(reach.point);
            let weights = DMat3::from_diagonal(DVec3::splat(reach.weight));
            self.collect(kinematics, pose, reach.body, point);
            self.add(weights, reach.target - point, |(_, _, linear)| *linear);
        }
    }

    /// The columns of the Jacobian at a point of a body: the unknown, how it turns the body, and how it moves the
    /// point.
    fn collect(&mut self, kinematics: &Kinematics, pose: &RobotPose, body: usize, point: DVec3) {
        self.columns.clear();
        let from_root = point - pose.root.translation;
        for (index, axis) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
            self.columns.push((index, DVec3::ZERO, axis));
            self.columns.push((3 + index, axis, axis.cross(from_root)));
        }
        for &joint in &kinematics.bodies[body].chain {
            let Some((unknown, multiplier)) = self.unknown[joint - 1] else {
                continue;
            };
            let (axis, anchor) = kinematics.axis(pose, joint);
            let axis = multiplier * axis;
            let (angular, linear) = match kinematics.bodies[joint].kind {
                JointKind::Slide => (DVec3::ZERO, axis),
                _ => (axis, axis.cross(point - anchor)),
            };
            // Joints that are tied share a column.
            let is_tied = !kinematics.followers.is_empty();
            let mut columns = self.columns.iter_mut().filter(|_| is_tied);
            match columns.find(|column| column.0 == unknown) {
                Some(column) => {
                    column.1 += angular;
                    column.2 += linear;
                }
                None => self.columns.push((unknown, angular, linear)),
            }
        }
    }

    /// Adds a residual to the normal equations.
    fn add(&mut self, weights: DMat3, error: DVec3, column: impl Fn(&(usize, DVec3, DVec3)) -> DVec3) {
        let size = self.gradient.len();
        let weighted = weights * error;
        for (place, first) in self.columns.iter().enumerate() {
            let own = column(first);
            if own == DVec3::ZERO {
                continue;
            }
            self.gradient[first.0] += own.dot(weighted);
            let own = weights * own;
            for second in &self.columns[..=place] {
                let (row, line) = if first.0 > second.0 {
                    (first.0, second.0)
                } else {
                    (second.0, first.0)
                };
                self.normal[row * size + line] += own.dot(column(second));
            }
        }
    }

    /// The step of all unknowns that keeps the bounds.
    fn bounded_step(&mut self, bounds: &Bounds, pose: &RobotPose) {
        let size = self.gradient.len();
        let mut fixed: Vec<Option<f64>> = vec![None; size];
        for (index, &position) in self.positions.iter().enumerate() {
            let (at, pull) = (pose.positions[position], self.gradient[ROOT + index]);
            let is_held = (at <= bounds.lower[position] && pull < 0.0) || (at >= bounds.upper[position] && pull > 0.0);
            fixed[ROOT + index] = is_held.then_some(0.0);
        }
        for _ in 0..ROUNDS {
            self.solve_free(&fixed);
            let mut is_within = true;
            for (index, &position) in self.positions.iter().enumerate() {
                let unknown = ROOT + index;
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

    /// The step of the free unknowns where the others make the given ones.
    fn solve_free(&mut self, fixed: &[Option<f64>]) {
        let size = self.gradient.len();
        let free: Vec<usize> = (0..size).filter(|unknown| fixed[*unknown].is_none()).collect();
        let count = free.len();
        let normal = |a: usize, b: usize| self.normal[a.max(b) * size + a.min(b)];
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
            right[row] = self.gradient[a] - taken;
        }
        cholesky(matrix, right, count);
        for (unknown, step) in self.step.iter_mut().enumerate() {
            *step = fixed[unknown].unwrap_or_default();
        }
        for (row, &unknown) in free.iter().enumerate() {
            self.step[unknown] = right[row];
        }
    }

    fn apply(&self, bounds: &Bounds, pose: &mut RobotPose, scale: f64) {
        let step = |index: usize| scale * self.step[index];
        let turn = DVec3::new(step(3), step(4), step(5));
        pose.root = Placement {
            rotation: (DQuat::from_scaled_axis(turn) * pose.root.rotation).normalize(),
            translation: pose.root.translation + DVec3::new(step(0), step(1), step(2)),
        };
        for (index, &position) in self.positions.iter().enumerate() {
            let at = pose.positions[position] + step(ROOT + index);
            pose.positions[position] = at.max(bounds.lower[position]).min(bounds.upper[position]);
        }
    }
}

/// Axis and angle of a rotation by at most half a turn, as one vector.
pub(super) fn rotation_vector(rotation: DQuat) -> DVec3 {
    let rotation = if rotation.w < 0.0 { -rotation } else { rotation };
    rotation.to_scaled_axis()
}

/// Solves a symmetric positive definite system, of which the lower triangle is given, in place.
fn cholesky(matrix: &mut [f64], right: &mut [f64], size: usize) {
    for row in 0..size {
        for column in 0..=row {
            let (above, here) = matrix.split_at_mut(row * size);
            let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
            if column < row {
                let other = &above[column * size..column * size + column];
                let sum = here[column] - dot(&here[..column], other);
                here[column] = sum / above[column * size + column];
            } else {
                let sum = here[row] - dot(&here[..row], &here[..row]);
                here[row] = sum.max(1e-18).sqrt();
            }
        }
    }
    for row in 0..size {
        let known: f64 = (0..row).map(|column| matrix[row * size + column] * right[column]).sum();
        right[row] = (right[row] - known) / matrix[row * size + row];
    }
    for row in (0..size).rev() {
        let known: f64 = (row + 1..size)
            .map(|other| matrix[other * size + row] * right[other])
            .sum();
        right[row] = (right[row] - known) / matrix[row * size + row];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::robot::{Mimic, Robot, RobotJoint, RobotLink};

    #[test]
    fn a_system_is_solved() {
        // By hand: x = (1, -2, 3).
        let full = [[4.0, 1.0, 0.5], [1.0, 3.0, -1.0], [0.5, -1.0, 5.0]];
        let known = [1.0, -2.0, 3.0];
        let mut right: Vec<f64> = full
            .iter()
            .map(|row| row.iter().zip(known).map(|(a, x)| a * x).sum())
            .collect();
        let mut matrix: Vec<f64> = full.iter().flatten().copied().collect();
        cholesky(&mut matrix, &mut right, 3);
        for (found, known) in right.iter().zip(known) {
            assert!((found - known).abs() < 1e-12, "{right:?}");
        }
    }

    /// Two hinges about one axis, of which the second turns twice as far: by hand, of a turn of 0.9 the first makes
    /// 0.3.
    #[test]
    fn a_follower_shares_the_turn_of_its_leader() {
        let link = |parent, mimic| RobotLink {
            parent,
            joint: RobotJoint {
                kind: JointKind::Hinge,
                mimic,
                ..RobotJoint::default()
            },
            ..RobotLink::default()
        };
        let mimic = Mimic {
            leader: 1,
            multiplier: 2.0,
            offset: 0.0,
        };
        let robot = Robot {
            links: vec![RobotLink::default(), link(Some(0), None), link(Some(1), Some(mimic))],
            ..Robot::default()
        };
        let kinematics = Kinematics::new(&robot);
        let turn = |body, target, weight| Turn {
            body,
            weight_axes: DQuat::IDENTITY,
            weights: DVec3::splat(weight),
            target,
        };
        let goals = Goals {
            turns: vec![
                turn(0, DQuat::IDENTITY, 1e6),
                turn(2, DQuat::from_axis_angle(DVec3::Z, 0.9), 1.0),
            ],
            reaches: Vec::new(),
        };
        let mut pose = kinematics.rest();
        let bounds = |most: f64| Bounds {
            lower: vec![-most; 2],
            upper: vec![most; 2],
        };
        let mut solver = Solver::new(&kinematics, &goals);
        solver.solve(&kinematics, &goals, &bounds(3.0), &mut pose, 30);
        assert!((pose.positions[0] - 0.3).abs() < 1e-4, "{:?}", pose.positions);
        assert_eq!(pose.positions[1], 2.0 * pose.positions[0]);
    }
}
