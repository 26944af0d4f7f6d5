//! Measures how well two motions fit together where they meet: the differences between their poses and between their
//! speeds.

use glam::Vec3;
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::math::quaternion::log;
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::{NodeKind, Scene};

use super::carrier::Carrier;
use super::frames::Frames;

/// The largest difference between the rotations of a joint in two poses that still fit, in degrees. A viewer sees a
/// larger difference as a movement when the step fades it out.
const FAR_ROTATION: f32 = 45.0;

/// The largest distance between the positions of a joint in two poses that still fit, in metres.
const FAR_POSITION: f32 = 0.3;

/// The largest difference of speed that still fits, in m/s. A walk that stops abruptly has this difference.
const FAR_SPEED: f32 = 1.0;

/// The largest difference between two poses, and its joint and frame.
#[derive(Clone, Debug, Default)]
struct LargestDifference {
    by: f32,
    joint: usize,
    frame: usize,
}

impl LargestDifference {
    fn see(&mut self, by: f32, joint: usize, frame: usize) {
        if by > self.by {
            *self = Self { by, joint, frame };
        }
    }
}

/// The largest differences between two motions where they meet.
pub(super) struct Fit<'a> {
    scene: &'a Scene,
    frames: &'a Frames<'a>,
    metres_per_unit: f32,
    poses: [Pose; 2],
    rotation: LargestDifference,
    position: LargestDifference,
    speed: LargestDifference,
}

impl<'a> Fit<'a> {
    /// Starts without a difference. The compared motions have the nodes of `frames`.
    pub(super) fn new(scene: &'a Scene, frames: &'a Frames<'a>, metres_per_unit: f32) -> Self {
        Self {
            scene,
            frames,
            metres_per_unit,
            poses: [Pose::rest(scene), Pose::rest(scene)],
            rotation: LargestDifference::default(),
            position: LargestDifference::default(),
            speed: LargestDifference::default(),
        }
    }

    /// Compares the rotations in two poses, relative to the parents. `frame` is the frame of the result that a warning
    /// names.
    pub(super) fn see_rotations(&mut self, row: &[Trs], other: &[Trs], frame: usize) {
        for ((node, a), b) in self.frames.nodes().iter().zip(row).zip(other) {
            let by = log(a.rotation.inverse() * b.rotation).length().to_degrees();
            self.rotation.see(by, node.index(), frame);
        }
    }

    /// Compares the positions of the joints in two poses.
    pub(super) fn see_positions(&mut self, row: &[Trs], other: &[Trs], frame: usize) {
        let [a, b] = [self.positions(row, 0), self.positions(other, 1)];
        for (joint, (a, b)) in a.into_iter().zip(b).enumerate() {
            self.position.see(a.distance(b) * self.metres_per_unit, joint, frame);
        }
    }

    /// Compares the rotations and the positions in two poses, after both figures have the same position and heading.
    pub(super) fn see_poses(&mut self, carrier: &Carrier, row: &[Trs], other: &[Trs], frame: usize) {
        let mut beside = other.to_vec();
        carrier.apply(&carrier.placement(other, row), &mut beside);
        self.see_rotations(row, &beside, frame);
        self.see_positions(row, &beside, frame);
    }

    /// Compares the speeds of two motions at a frame. Each motion is given as two successive rows.
    pub(super) fn see_speeds(&mut self, pair: [&[Trs]; 2], other: [&[Trs]; 2], frame: usize) {
        let velocities = |fit: &mut Self, [from, to]: [&[Trs]; 2]| -> Vec<Vec3> {
            let (from, to) = (fit.positions(from, 0), fit.positions(to, 1));
            from.into_iter().zip(to).map(|(from, to)| to - from).collect()
        };
        let (a, b) = (velocities(self, pair), velocities(self, other));
        let per_second = self.metres_per_unit * self.frames.rate as f32;
        for (joint, (a, b)) in a.into_iter().zip(b).enumerate() {
            self.speed.see(a.distance(b) * per_second, joint, frame);
        }
    }

    /// The positions of all nodes of the scene. A node that is no joint has the position 0, so that it does not differ.
    fn positions(&mut self, row: &[Trs], pose: usize) -> Vec<Vec3> {
        let pose = &mut self.poses[pose];
        for (node, trs) in self.frames.nodes().iter().zip(row) {
            pose.node_to_parent[node.index()] = trs.matrix();
        }
        pose.update_world();
        let is_joint = |node: usize| self.scene.nodes[node].kind == NodeKind::Joint;
        let position = |(node, to_world): (usize, &glam::Mat4)| match is_joint(node) {
            true => to_world.w_axis.truncate(),
            false => Vec3::ZERO,
        };
        pose.node_to_world.iter().enumerate().map(position).collect()
    }

    /// The warning about the differences above the limits, if there are any.
    pub(super) fn warning(&self, step: &str, help: &str) -> Option<Diagnostic> {
        let found = [
            (&self.rotation, FAR_ROTATION, "degrees", 1.0),
            (&self.position, FAR_POSITION, "cm", 100.0),
            (&self.speed, FAR_SPEED, "m/s", 1.0),
        ];
        let far = found.into_iter().filter(|(found, limit, ..)| found.by > *limit);
        let far: Vec<String> = far
            .map(|(found, limit, unit, factor)| {
                let (joint, frame) = (&self.scene.nodes[found.joint].name, found.frame);
                let (by, limit) = (found.by * factor, (10.0 * limit * factor).round() / 10.0);
                format!("{joint} by {by:.1} {unit} at frame {frame} (more than {limit} {unit})")
            })
            .collect();
        (!far.is_empty()).then(|| {
            let message = format!("{step}: the two motions do not fit: {}", far.join(", "));
            Diagnostic::new(Code::PosesApart, message).help(help)
        })
    }
}
