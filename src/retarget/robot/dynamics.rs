//! Inverse dynamics of a robot with a floating base. It computes the force and the moment at the base, and the torques
//! of the joints, that a motion needs.
//!
//! It is the recursive Newton-Euler algorithm (R. Featherstone, "Rigid Body Dynamics Algorithms", Springer 2008,
//! chapter 5), in the axes of the world. Velocities and accelerations are computed from the base outwards, forces from
//! the ends back to the base.

use glam::{DMat3, DVec3};
use mocap_scene::math::quaternion::rotation_vector;
use mocap_scene::scene::robot::{JointKind, Robot};

use super::kinematics::{Kinematics, RobotPose};
use super::motion::RobotMotion;

/// The acceleration of gravity in MuJoCo, in metres per second squared.
pub const GRAVITY: f64 = 9.81;

/// The mass of a body, with all links that are fixed to it.
#[derive(Clone, Copy, Debug)]
struct Mass {
    mass: f64,
    /// The centre of mass, in the frame of the body.
    centre: DVec3,
    /// The inertia about the centre of mass, in the axes of the body.
    inertia: DMat3,
}

/// Velocities, accelerations or forces: of the base along and about the axes of the world, and of the joints.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rates {
    pub linear: DVec3,
    pub angular: DVec3,
    pub joints: Vec<f64>,
}

/// The motion of a body, and the forces on it.
#[derive(Clone, Copy, Debug, Default)]
struct Moving {
    angular: DVec3,
    angular_acceleration: DVec3,
    /// The acceleration of the origin of the body, with gravity as an upward acceleration.
    acceleration: DVec3,
    force: DVec3,
    /// The moment about the origin of the body.
    moment: DVec3,
}

/// The masses of a robot's bodies.
#[derive(Clone, Debug)]
pub struct Dynamics {
    masses: Vec<Mass>,
    /// The armature of each body's joint: the inertia of the motor in addition to the links.
    armatures: Vec<f64>,
    moving: Vec<Moving>,
}

impl Dynamics {
    pub fn new(robot: &Robot, kinematics: &Kinematics) -> Self {
        let mut masses = vec![Mass::NONE; kinematics.bodies.len()];
        let mut armatures = vec![0.0; kinematics.bodies.len()];
        for (index, link) in robot.links.iter().enumerate() {
            let (body, transform) = kinematics.body_of(index);
            if link.joint.moves() || index == 0 {
                armatures[body] = link.joint.armature;
            }
            let Some(inertial) = link.inertial.filter(|inertial| inertial.mass > 0.0) else {
                continue;
            };
            let there = transform.then(&inertial.origin);
            let axes = DMat3::from_quat(there.rotation);
            let added = Mass {
                mass: inertial.mass,
                centre: there.translation,
                inertia: axes * inertial.matrix() * axes.transpose(),
            };
            masses[body] = masses[body].with(&added);
        }
        Self {
            moving: vec![Moving::default(); masses.len()],
            masses,
            armatures,
        }
    }

    /// The mass of the robot, in kilograms.
    pub(super) fn mass(&self) -> f64 {
        self.masses.iter().map(|body| body.mass).sum()
    }

    /// The centre of mass of the robot in a pose.
    pub fn centre(&self, pose: &RobotPose) -> DVec3 {
        let bodies = self.masses.iter().zip(&pose.bodies);
        let sum: DVec3 = bodies
            .map(|(body, transform)| body.mass * transform.point(body.centre))
            .sum();
        sum / self.mass()
    }

    /// The forces that give a robot in a pose these velocities and accelerations.
    pub fn inverse(
        &mut self,
        kinematics: &Kinematics,
        pose: &RobotPose,
        velocity: &Rates,
        acceleration: &Rates,
    ) -> Rates {
        let moving = &mut self.moving;
        moving[0] = Moving {
            angular: velocity.angular,
            angular_acceleration: acceleration.angular,
            acceleration: acceleration.linear + GRAVITY * DVec3::Z,
            ..Moving::default()
        };
        for (index, body) in kinematics.bodies.iter().enumerate().skip(1) {
            let rates = (velocity.joints[index - 1], acceleration.joints[index - 1]);
            let (axis, anchor) = kinematics.axis(pose, index);
            let [from, here] = [body.parent, index].map(|body| pose.bodies[body].translation);
            let carrier = &moving[body.parent];
            moving[index] = match body.kind {
                JointKind::Slide => carrier.slides(here - from, rates.0 * axis, rates.1 * axis),
                _ => carrier.turns([anchor - from, here - anchor], rates.0 * axis, rates.1 * axis),
            };
        }
        for ((moving, mass), transform) in moving.iter_mut().zip(&self.masses).zip(&pose.bodies) {
            moving.act(mass, DMat3::from_quat(transform.rotation));
        }
        let mut joints = vec![0.0; kinematics.bodies.len() - 1];
        for (index, body) in kinematics.bodies.iter().enumerate().skip(1).rev() {
            let Moving { force, moment, .. } = moving[index];
            let (axis, anchor) = kinematics.axis(pose, index);
            let [carrier, here] = [body.parent, index].map(|body| pose.bodies[body].translation);
            let own = match body.kind {
                JointKind::Slide => axis.dot(force),
                _ => axis.dot(moment + (here - anchor).cross(force)),
            };
            joints[index - 1] = own + self.armatures[index] * acceleration.joints[index - 1];
            moving[body.parent].force += force;
            moving[body.parent].moment += moment + (here - carrier).cross(force);
        }
        Rates {
            linear: moving[0].force + self.armatures[0] * acceleration.linear,
            angular: moving[0].moment + self.armatures[0] * acceleration.angular,
            joints,
        }
    }
}

impl Mass {
    const NONE: Self = Self {
        mass: 0.0,
        centre: DVec3::ZERO,
        inertia: DMat3::ZERO,
    };

    /// The mass of both bodies together.
    fn with(&self, other: &Self) -> Self {
        let mass = self.mass + other.mass;
        let centre = (self.mass * self.centre + other.mass * other.centre) / mass;
        // Steiner's theorem.
        let about = |part: &Self| {
            let away = part.centre - centre;
            let outer = DMat3::from_cols(away.x * away, away.y * away, away.z * away);
            part.inertia + part.mass * (DMat3::from_diagonal(DVec3::splat(away.length_squared())) - outer)
        };
        Self {
            mass,
            centre,
            inertia: about(self) + about(other),
        }
    }
}

impl Moving {
    /// The acceleration of a point of the body. `point` is its vector from the origin.
    fn acceleration_at(&self, point: DVec3) -> DVec3 {
        self.acceleration + self.angular_acceleration.cross(point) + self.angular.cross(self.angular.cross(point))
    }

    /// The motion of a child body with a hinge. `to_axis` leads from the origin of this body to the axis, and
    /// `to_origin` from the axis to the origin of the child.
    fn turns(&self, [to_axis, to_origin]: [DVec3; 2], velocity: DVec3, acceleration: DVec3) -> Self {
        let turned = Self {
            angular: self.angular + velocity,
            angular_acceleration: self.angular_acceleration + acceleration + self.angular.cross(velocity),
            acceleration: self.acceleration_at(to_axis),
            ..Self::default()
        };
        Self {
            acceleration: turned.acceleration_at(to_origin),
            ..turned
        }
    }

    /// The motion of a child body with a slide joint.
    fn slides(&self, to_origin: DVec3, velocity: DVec3, acceleration: DVec3) -> Self {
        let along = 2.0 * self.angular.cross(velocity) + acceleration;
        Self {
            acceleration: self.acceleration_at(to_origin) + along,
            force: DVec3::ZERO,
            moment: DVec3::ZERO,
            ..*self
        }
    }

    /// Sets force and moment from the motion of the body, by the equations of Newton and Euler.
    fn act(&mut self, mass: &Mass, axes: DMat3) {
        let centre = axes * mass.centre;
        let inertia = axes * mass.inertia * axes.transpose();
        self.force = mass.mass * self.acceleration_at(centre);
        let turning = inertia * self.angular_acceleration + self.angular.cross(inertia * self.angular);
        self.moment = turning + centre.cross(self.force);
    }
}

/// The velocities and the accelerations in a frame of a motion, by central differences. The first and the last frame
/// have the values of their neighbours. `None` for fewer than three frames.
pub(super) fn rates(motion: &RobotMotion, frame: usize) -> Option<(Rates, Rates)> {
    let middle = frame.min(motion.frames().checked_sub(2)?).max(1);
    if motion.frames() < 3 {
        return None;
    }
    let fps = motion.fps;
    let [before, here, after] = [middle - 1, middle, middle + 1].map(|frame| &motion.root[frame]);
    let turn = |from: usize, to: usize| {
        let [from, to] = [from, to].map(|frame| motion.root[frame].rotation);
        rotation_vector(to * from.inverse())
    };
    let joints = |of: &dyn Fn(f64, f64, f64) -> f64| {
        let [before, here, after] = [middle - 1, middle, middle + 1].map(|frame| motion.dof_of(frame));
        let three = before.iter().zip(here).zip(after);
        three
            .map(|((before, here), after)| of(*before, *here, *after))
            .collect()
    };
    let (first, second) = (turn(middle - 1, middle), turn(middle, middle + 1));
    let velocity = Rates {
        linear: 0.5 * fps * (after.translation - before.translation),
        angular: 0.5 * fps * (first + second),
        joints: joints(&|before, _, after| 0.5 * fps * (after - before)),
    };
    let change = after.translation - 2.0 * here.translation + before.translation;
    let acceleration = Rates {
        linear: fps * fps * change,
        angular: fps * fps * (second - first),
        joints: joints(&|before, here, after| fps * fps * (after - 2.0 * here + before)),
    };
    Some((velocity, acceleration))
}
