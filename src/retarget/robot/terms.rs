//! The terms of the pose that is looked for, linearised: normal equations of one frame.

use glam::{DMat3, DQuat, DVec3};
use mocap_scene::math::quaternion::rotation_vector;
use mocap_scene::scene::robot::JointKind;

use super::kinematics::{Kinematics, RobotPose};

/// The unknowns of the base: three of its position and three of its rotation.
pub(super) const ROOT: usize = 6;

/// The weight of every unknown, in 1/rad^2 and 1/m^2: a billionth of a direction, against directions in which nothing
/// changes.
const DAMPING: f64 = 1e-9;

/// How a link should be turned.
#[derive(Clone, Debug)]
pub struct RotationGoal {
    pub body: usize,
    /// The axes of the weights, in the frame of the body.
    pub weight_axes: DQuat,
    /// Squares of the weights about these axes.
    pub weights: DVec3,
    /// The rotation of the body to the world.
    pub target: DQuat,
}

/// Where a point of a link should be.
#[derive(Clone, Debug)]
pub struct Reach {
    pub body: usize,
    pub point: DVec3,
    /// The squares of the weights along the axes of the world, of a metre against a radian.
    pub weight: DVec3,
    pub target: DVec3,
}

/// What a pose should be.
#[derive(Clone, Debug, Default)]
pub struct Goals {
    pub rotations: Vec<RotationGoal>,
    pub reaches: Vec<Reach>,
    /// How high the lowest points of both soles are at least, in metres.
    pub clearances: [f64; 2],
}

/// The normal equations of the terms of one frame, by the unknowns: those of the base, where it moves, and the
/// positions.
#[derive(Clone, Debug)]
pub struct Terms {
    /// How many unknowns the base has: [`ROOT`], or none where it stays.
    pub(super) base: usize,
    /// The unknown of each position, and how much it moves with that; none for joints that stay.
    unknown: Vec<Option<(usize, f64)>>,
    /// The position of each unknown after those of the base.
    pub(super) positions: Vec<usize>,
    /// The lower triangle, row by row.
    pub(super) normal: Vec<f64>,
    pub(super) gradient: Vec<f64>,
    columns: Vec<(usize, DVec3, DVec3)>,
    row: Vec<(usize, f64)>,
}

impl Terms {
    /// Of the joints that turn the bodies of `goals`.
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

    /// Of the positions that are `used`; the base has `base` unknowns.
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

    /// How many unknowns there are.
    pub(super) fn size(&self) -> usize {
        self.gradient.len()
    }

    /// Sets the equations to those of `goals` at a pose.
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

    /// Adds that a point should be elsewhere.
    pub(super) fn add_reach(&mut self, kinematics: &Kinematics, reach: &Reach, pose: &RobotPose) {
        let point = pose.bodies[reach.body].point(reach.point);
        let weights = DMat3::from_diagonal(reach.weight);
        self.collect(kinematics, pose, reach.body, point);
        self.add(weights, reach.target - point, |(_, _, linear)| *linear);
    }

    /// Adds that a position should change by `error`, with the square of a weight.
    pub(super) fn add_position(&mut self, unknown: usize, weight: f64, error: f64) {
        let size = self.size();
        self.normal[unknown * size + unknown] += weight;
        self.gradient[unknown] += weight * error;
    }

    /// Adds a separation residual: moves the two points apart by `error` metres along `direction`, the first along it.
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

    /// The columns of the Jacobian at a point of a body: the unknown, how it turns the body, and how it moves the
    /// point.
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
