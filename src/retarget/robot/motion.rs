//! The motion of a robot.

use mocap_figure::robot_clip;
use mocap_scene::scene::Animation;
use mocap_scene::scene::robot::{Placement, Robot};
use serde::Serialize;

use super::kinematics::{Kinematics, RobotPose};

/// The largest difference of a frame rate from a whole number at which the whole number is used, as a fraction. A frame
/// time of 0.033333 s has six decimals.
const WHOLE_RATE: f64 = 1e-4;

/// The largest difference in frames of equal times.
const SAME_FRAME: f64 = 1e-6;

/// The motion of a robot, frame by frame.
///
/// The [module](crate::robot) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RobotMotion {
    /// The name of the clip.
    pub name: String,
    /// Frames per second.
    pub fps: f64,
    /// The placement of the base in the world, in metres, +Z up. The floor is at 0.
    pub root: Vec<Placement>,
    /// The positions of the joints, in radians or metres, frame by frame.
    pub dof_pos: Vec<f64>,
    /// The names of the joints, in the order of the robot's links.
    pub dof_names: Vec<String>,
    /// For each frame, whether the left and the right foot of the source are in contact with the ground.
    pub contacts: Vec<[bool; 2]>,
    /// For each frame, the contacts of the hind feet of a robot with four legs, whose front feet are in `contacts`.
    /// Empty for other robots.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub hind_contacts: Vec<[bool; 2]>,
}

impl RobotMotion {
    /// The number of frames.
    pub fn frames(&self) -> usize {
        self.root.len()
    }

    /// The positions of the joints in a frame.
    pub fn dof_of(&self, frame: usize) -> &[f64] {
        let count = self.dof_names.len();
        &self.dof_pos[frame * count..(frame + 1) * count]
    }

    /// Drops the first frames.
    #[doc(hidden)]
    pub fn forget(&mut self, frames: usize) {
        let joints = self.dof_names.len();
        self.root.drain(..frames);
        self.dof_pos.drain(..frames * joints);
        self.contacts.drain(..frames);
        self.hind_contacts.drain(..frames.min(self.hind_contacts.len()));
    }

    /// Keeps only the first frames.
    pub(super) fn keep_first(&mut self, frames: usize) {
        self.root.truncate(frames);
        self.dof_pos.truncate(frames * self.dof_names.len());
        self.contacts.truncate(frames);
        self.hind_contacts.truncate(frames);
    }

    /// Plays the motion at `speed` times its speed, at the same frame rate. Catmull-Rom splines through the frames give
    /// the new frames. A rest at the end that is shorter than a frame is dropped.
    pub(super) fn at_speed(&self, speed: f64) -> Self {
        let last = self.frames().saturating_sub(1);
        let count = (last as f64 / speed + SAME_FRAME) as usize + 1;
        let mut scaled = Self {
            name: self.name.clone(),
            fps: self.fps,
            dof_names: self.dof_names.clone(),
            ..Self::default()
        };
        for frame in (0..count).filter(|_| !self.root.is_empty()) {
            let at = (frame as f64 * speed).min(last as f64);
            let from = (at as usize).min(last.saturating_sub(1));
            let frames = [from.saturating_sub(1), from, (from + 1).min(last), (from + 2).min(last)];
            let weights = spline(at - from as f64, [from == 0, from + 2 > last]);
            let parts = || frames.into_iter().zip(weights);
            let rotations = parts().map(|(frame, weight)| self.root[frame].rotation * weight);
            scaled.root.push(Placement {
                rotation: rotations.reduce(|a, b| a + b).unwrap_or_default().normalize(),
                translation: parts()
                    .map(|(frame, weight)| weight * self.root[frame].translation)
                    .sum(),
            });
            scaled.dof_pos.extend((0..self.dof_names.len()).map(|joint| {
                parts()
                    .map(|(frame, weight)| weight * self.dof_of(frame)[joint])
                    .sum::<f64>()
            }));
            let nearest = at.round() as usize;
            scaled.contacts.extend(self.contacts.get(nearest));
            scaled.hind_contacts.extend(self.hind_contacts.get(nearest));
        }
        scaled
    }

    /// The number of feet, and for each frame the feet in contact, the front feet first.
    #[doc(hidden)]
    pub fn contacts_of_feet(&self) -> (usize, Vec<bool>) {
        let hind = |frame: usize| self.hind_contacts.get(frame).into_iter().flatten();
        let frames = self.contacts.iter().enumerate();
        let contacts = frames.flat_map(|(frame, front)| front.iter().chain(hind(frame)).copied());
        (if self.hind_contacts.is_empty() { 2 } else { 4 }, contacts.collect())
    }

    /// Sets a pose to the pose of a frame.
    pub(super) fn set(&self, frame: usize, kinematics: &Kinematics, pose: &mut RobotPose) {
        pose.root = self.root[frame];
        pose.positions.copy_from_slice(self.dof_of(frame));
        kinematics.update(pose);
    }

    /// The positions of the base: x, y and z for each frame.
    pub fn root_pos(&self) -> Vec<f64> {
        let transforms = self.root.iter();
        transforms
            .flat_map(|transform| transform.translation.to_array())
            .collect()
    }

    /// The rotations of the base: x, y, z and w for each frame.
    pub fn root_rot(&self) -> Vec<f64> {
        let transforms = self.root.iter();
        transforms.flat_map(|transform| transform.rotation.to_array()).collect()
    }

    /// MuJoCo's `qpos`: for each frame the position of the base, its rotation as w, x, y and z, and the joints.
    pub fn qpos(&self) -> Vec<f64> {
        let mut values = Vec::with_capacity(self.frames() * (7 + self.dof_names.len()));
        for (frame, root) in self.root.iter().enumerate() {
            let rotation = root.rotation;
            values.extend(root.translation.to_array());
            values.extend([rotation.w, rotation.x, rotation.y, rotation.z]);
            values.extend(self.dof_of(frame));
        }
        values
    }

    /// The motion as an animation of [`robot_scene`](crate::robot::robot_scene).
    pub fn to_animation(&self, robot: &Robot) -> Animation {
        robot_clip(robot, &self.name, self.fps, &self.root, &self.dof_pos)
    }
}

/// The exact frame rate of a file whose frame time has few digits: 30, not 30.0003.
pub(super) fn rate(fps: f64) -> f64 {
    let whole = fps.round();
    match (fps - whole).abs() < WHOLE_RATE * fps {
        true => whole,
        false => fps,
    }
}

/// The weights of four points in a Catmull-Rom spline, at `t` from the second point to the third. At an end of the
/// motion, the point beyond the end continues the last step.
fn spline(t: f64, is_end: [bool; 2]) -> [f64; 4] {
    let (square, cube) = (t * t, t * t * t);
    let mut weights = [
        0.5 * (2.0 * square - cube - t),
        0.5 * (2.0 - 5.0 * square + 3.0 * cube),
        0.5 * (t + 4.0 * square - 3.0 * cube),
        0.5 * (cube - square),
    ];
    for (beyond, end, before) in [(0, 1, 2), (3, 2, 1)] {
        if is_end[beyond / 3] {
            let weight = std::mem::take(&mut weights[beyond]);
            weights[end] += 2.0 * weight;
            weights[before] -= weight;
        }
    }
    weights
}
