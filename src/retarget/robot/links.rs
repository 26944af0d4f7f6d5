//! The positions and velocities of a robot's links in a motion, in the order that a program expects.

use std::collections::VecDeque;

use glam::DVec3;
use mocap_scene::math::quaternion::rotation_vector;
use mocap_scene::scene::robot::{Placement, Robot};

use super::kinematics::Kinematics;
use super::motion::RobotMotion;

/// The order of links and joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub enum LinkOrder {
    /// The order of the file and of MuJoCo: each link before its children.
    DepthFirst,
    /// The order of PhysX and Isaac Lab: links by their depth in the tree.
    BreadthFirst,
}

/// The base and the links with a joint, frame by frame. Links that are fixed to other links have no row. Links between
/// several joints of one body have no row either.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct LinkMotion {
    #[doc(hidden)]
    pub names: Vec<String>,
    /// The placement of each link in each frame, in the world.
    #[doc(hidden)]
    pub transforms: Vec<Placement>,
    /// The velocities in m/s and rad/s, in the axes of the world.
    #[doc(hidden)]
    pub velocities: Vec<DVec3>,
    #[doc(hidden)]
    pub angular_velocities: Vec<DVec3>,
    /// The index of each joint in the motion, in the order of the links.
    #[doc(hidden)]
    pub joints: Vec<usize>,
}

impl LinkMotion {
    #[doc(hidden)]
    pub fn new(robot: &Robot, motion: &RobotMotion, order: LinkOrder) -> Self {
        let kinematics = Kinematics::new(robot);
        let bodies = in_order(&kinematics, order);
        let moving = robot.moving_joints();
        let link_of = |body: usize| body.checked_sub(1).map_or(0, |position| moving[position]);
        let is_between = |body: &usize| robot.links[link_of(*body)].name.contains('/');
        let named: Vec<usize> = bodies.iter().copied().filter(|body| !is_between(body)).collect();
        let mut transforms = Vec::with_capacity(motion.frames() * named.len());
        let mut pose = kinematics.rest();
        for frame in 0..motion.frames() {
            motion.set(frame, &kinematics, &mut pose);
            transforms.extend(named.iter().map(|body| pose.bodies[*body]));
        }
        let count = named.len();
        let of_links = |change: &dyn Fn(&Placement, &Placement) -> DVec3| {
            let mut values = Vec::with_capacity(transforms.len());
            for frame in 0..motion.frames() {
                let (before, after, seconds) = around(frame, motion);
                for link in 0..count {
                    let (from, to) = (&transforms[before * count + link], &transforms[after * count + link]);
                    values.push(change(from, to) / seconds);
                }
            }
            values
        };
        Self {
            velocities: of_links(&|from, to| to.translation - from.translation),
            angular_velocities: of_links(&|from, to| rotation_vector(to.rotation * from.rotation.inverse())),
            names: named
                .iter()
                .map(|body| robot.links[link_of(*body)].name.clone())
                .collect(),
            joints: bodies.iter().filter_map(|body| body.checked_sub(1)).collect(),
            transforms,
        }
    }

    /// The positions of links in the frame of the base.
    #[doc(hidden)]
    pub fn within_base(&self) -> Vec<f64> {
        let frames = self.transforms.chunks(self.names.len().max(1));
        let within = frames.flat_map(|frame| frame.iter().map(|transform| frame[0].to_inner(transform.translation)));
        within.flat_map(|point| point.to_array()).collect()
    }

    /// The names of the joints of a motion, in the order of the links.
    #[doc(hidden)]
    pub fn joint_names(&self, motion: &RobotMotion) -> Vec<String> {
        let joints = self.joints.iter();
        joints.map(|joint| motion.dof_names[*joint].clone()).collect()
    }

    /// The values of joints, frame by frame. The input has the motion's order, the output the order of the links.
    #[doc(hidden)]
    pub fn ordered(&self, values: &[f64]) -> Vec<f64> {
        let frames = values.chunks(self.joints.len().max(1));
        frames
            .flat_map(|frame| self.joints.iter().map(|joint| frame[*joint]))
            .collect()
    }
}

impl RobotMotion {
    /// The velocities of the joints: central differences, as in `numpy.gradient`.
    #[doc(hidden)]
    pub fn dof_velocities(&self) -> Vec<f64> {
        let frames = (0..self.frames()).flat_map(|frame| {
            let (before, after, seconds) = around(frame, self);
            let pairs = self.dof_of(before).iter().zip(self.dof_of(after));
            pairs.map(move |(from, to)| (to - from) / seconds)
        });
        frames.collect()
    }
}

/// The frames before and after a frame, if they exist, and the time between them.
fn around(frame: usize, motion: &RobotMotion) -> (usize, usize, f64) {
    let before = frame.saturating_sub(1);
    let after = (frame + 1).min(motion.frames() - 1);
    (before, after, ((after - before).max(1)) as f64 / motion.fps)
}

fn in_order(kinematics: &Kinematics, order: LinkOrder) -> Vec<usize> {
    let count = kinematics.bodies.len();
    if order == LinkOrder::DepthFirst {
        return (0..count).collect();
    }
    let mut found = Vec::with_capacity(count);
    let mut next = VecDeque::from([0]);
    while let Some(body) = next.pop_front() {
        found.push(body);
        next.extend((1..count).filter(|child| kinematics.bodies[*child].parent == body));
    }
    found
}
