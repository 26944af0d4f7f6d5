//! The linearised terms of a pose: the normal equations of one frame.

use glam::{DMat3, DQuat, DVec3};
use mocap_scene::math::quaternion::rotation_vector;
use mocap_scene::scene::robot::JointKind;

use super::kinematics::{Kinematics, RobotPose};

/// The number of unknowns of the base: three of its position and three of its rotation.
pub(super) const ROOT: usize = 6;

/// The weight of every unknown, in 1/rad^2 and 1/m^2: a billionth of a direction's weight, for directions that no term
/// changes.
const DAMPING: f64 = 1e-9;

/// The rotation goal of a link.
#[derive(Clone, Debug)]
pub struct RotationGoal {
    pub body: usize,
    /// The axes of the weights, in the frame of the body.
    pub weight_axes: DQuat,
    /// The squared weights about these axes.
    pub weights: DVec3,
    /// The wanted rotation from the body to the world.
    pub target: DQuat,
}

/// The position goal of a point of a link.
#[derive(Clone, Debug)]
pub struct Reach {
    pub body: usize,
    pub point: DVec3,
    /// The squared weights along the axes of the world. They weigh metres against radians.
    pub weight: DVec3,
    pub target: DVec3,
}

/// The goals of a pose.
#[derive(Clone, Debug, Default)]
pub struct Goals {
    pub rotations: Vec<RotationGoal>,
    pub reaches: Vec<Reach>,
    /// The smallest heights of the lowest points of both soles, in metres.
    pub clearances: [f64; 2],
}

/// The normal equations of one frame. The unknowns are the base, if it is free, and the positions.
#[derive(Clone, Debug)]
pub struct Terms {
    /// The number of unknowns of the base: [`ROOT`], or 0 for a fixed base.
    pub(super) base: usize,
    /// The unknown of each position, and the factor between both; `None` for fixed joints.
    unknown: Vec<Option<(usize, f64)>>,
    /// The position of each unknown after the unknowns of the base.
    pub(super) positions: Vec<usize>,
    /// The lower triangle of the matrix, row by row.
    pub(super) normal: Vec<f64>,
    pub(super) gradient: Vec<f64>,
    columns: Vec<(usize, DVec3, DVec3)>,
    row: Vec<(usize, f64)>,
}

impl Terms {
    /// The equations of the joints that move the bodies of `goals`.
    pub fn new(kinematics: &Kinematics, goals: &Goals) -> Self {
        let mut used = vec![false; kinematics.bodies.len() - 1];
        let bodies = goals.rotations.iter().map(|goal| goal.body);
        for body in bodies.chain(goals.reaches.iter().map(|reach| reach.body)) {
            for &joint in &kinematics.bodies[body].chain {
                used[joint - 1] = true;
            }
        }
        Self::of_positions(kinematics, used, ROOT)
    }

    /// The equations of the positions that are `used`. The base has `base` unknowns.
    pub(super) fn of_positions(kinematics: &Kinematics, mut used: Vec<bool>, base: usize) -> Self {
        let count = used.len();
        // A follower has the unknown of its leader.
        for follower in &kinematics.followers {
            used[follower.leader] |= std::mem::take(&mut used[follower.position]);
        }
        let positions: Vec<usize> = (0..count).filter(|position| used[*position]).collect();
        let mut unknown = vec![None; count];
        for (index, &position) in positions.iter().enumerate() {
            unknown[position] = Some((base + index, 1.0));
        }
        for follower in &kinematics.followers {
            let leader: Option<(usize, f64)> = unknown[follower.leader];
            unknown[follower.position] = leader.map(|(unknown, _)| (unknown, follower.multiplier));
        }
        let size = base + positions.len();
        Self {
            base,
            unknown,
            positions,
            normal: vec![0.0; size * size],
            gradient: vec![0.0; size],
            columns: Vec::new(),
            row: Vec::new(),
        }
    }

    /// The number of unknowns.
    pub(super) fn size(&self) -> usize {
        self.gradient.len()
    }

    /// Sets the equations for `goals` at a pose.
    pub(super) fn assemble(&mut self, kinematics: &Kinematics, goals: &Goals, pose: &RobotPose) {
        let size = self.size();
        self.normal.fill(0.0);
        self.gradient.fill(0.0);
        for index in 0..size {
            self.normal[index * size + index] = DAMPING;
        }
        for goal in &goals.rotations {
            let transform = &pose.bodies[goal.body];
            let axes = DMat3::from_quat(transform.rotation * goal.weight_axes);
            let weights = axes * DMat3::from_diagonal(goal.weights) * axes.transpose();
            let error = rotation_vector(goal.target * transform.rotation.inverse());
            self.collect(kinematics, pose, goal.body, transform.translation);
            self.add(weights, error, |(_, angular, _)| *angular);
        }
        for reach in goals.reaches.iter().filter(|reach| reach.weight != DVec3::ZERO) {
            self.add_reach(kinematics, reach, pose);
        }
    }

    /// Adds the residual of a position goal.
    pub(super) fn add_reach(&mut self, kinematics: &Kinematics, reach: &Reach, pose: &RobotPose) {
        let point = pose.bodies[reach.body].point(reach.point);
        let weights = DMat3::from_diagonal(reach.weight);
        self.collect(kinematics, pose, reach.body, point);
        self.add(weights, reach.target - point, |(_, _, linear)| *linear);
    }

    /// Adds a residual that changes a position by `error`, with a squared weight.
    pub(super) fn add_position(&mut self, unknown: usize, weight: f64, error: f64) {
        let size = self.size();
        self.normal[unknown * size + unknown] += weight;
        self.gradient[unknown] += weight * error;
    }

    /// Adds a separation residual: moves the two points apart by `error` metres. The first moves along `direction`.
    pub(super) fn add_apart(
        &mut self,
        kinematics: &Kinematics,
        pose: &RobotPose,
        points: [(usize, DVec3); 2],
        along: DVec3,
        weight: f64,
        error: f64,
    ) -> &[(usize, f64)] {
        self.row.clear();
        for ((body, point), sign) in points.into_iter().zip([1.0, -1.0]) {
            self.collect(kinematics, pose, body, point);
            for (unknown, _, linear) in &self.columns {
                let value = sign * along.dot(*linear);
                match self.row.iter_mut().find(|(other, _)| other == unknown) {
                    Some((_, sum)) => *sum += value,
                    None => self.row.push((*unknown, value)),
                }
            }
        }
        let size = self.size();
        for &(a, first) in &self.row {
            self.gradient[a] += weight * first * error;
            for &(b, second) in self.row.iter().filter(|(b, _)| *b <= a) {
                self.normal[a * size + b] += weight * first * second;
            }
        }
        &self.row
    }

    /// Collects the columns of the Jacobian at a point of a body: the unknown, its rotation of the body, and its motion
    /// of the point.
    fn collect(&mut self, kinematics: &Kinematics, pose: &RobotPose, body: usize, point: DVec3) {
        self.columns.clear();
        let from_root = point - pose.root.translation;
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().take(self.base / 2);
        for (index, axis) in axes.enumerate() {
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
            // A joint and its followers share a column.
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
        let size = self.size();
        let weighted = weights * error;
        for (index, first) in self.columns.iter().enumerate() {
            let own = column(first);
            if own == DVec3::ZERO {
                continue;
            }
            self.gradient[first.0] += own.dot(weighted);
            let own = weights * own;
            for second in &self.columns[..=index] {
                let (row, line) = if first.0 > second.0 {
                    (first.0, second.0)
                } else {
                    (second.0, first.0)
                };
                self.normal[row * size + line] += own.dot(column(second));
            }
        }
    }
}
