//! The rotation of pelvis and chest between two skeletons.

use glam::Vec3;
use mocap_figure::HumanoidBone as Bone;
use mocap_figure::ticks::ticks;
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{Animation, Scene};

use super::PoseRetargeter;
use super::measure::Moving;

/// The largest number of examined frames. Each frame needs two poses.
const LOOKS: usize = 400;

/// The joints at both ends of the pelvis and of the chest.
const ENDS: [[Bone; 2]; 2] = [
    [Bone::LeftUpperLeg, Bone::RightUpperLeg],
    [Bone::LeftUpperArm, Bone::RightUpperArm],
];

impl PoseRetargeter {
    /// The angle between the lines of both bodies' hip joints, or shoulder joints, as the mean over the frames in
    /// degrees. The larger of the two means counts. Only positions are used, so a T-pose that rotates the trunk is
    /// detected. `None` if one of the bodies has neither pair.
    pub(crate) fn trunk_degrees(
        &self,
        source: &Scene,
        animation: &Animation,
        (target, moved): (&Scene, &Animation),
        has_legs: bool,
    ) -> Option<f64> {
        let (from, to) = self.moving(source, animation, target, moved);
        let ticks = ticks(animation);
        let ticks: Vec<f64> = ticks
            .iter()
            .copied()
            .step_by(ticks.len().div_ceil(LOOKS).max(1))
            .collect();
        let lines = [&from, &to].map(|moving| lines(moving, &ticks));
        let means = (usize::from(!has_legs)..ENDS.len()).filter_map(|pair| {
            let (was, is) = (lines[0][pair].as_ref()?, lines[1][pair].as_ref()?);
            let angle = |(was, is): (&Vec3, &Vec3)| f64::from(was.cross(*is).length().atan2(was.dot(*is)));
            Some(was.iter().zip(is).map(angle).sum::<f64>().to_degrees() / ticks.len().max(1) as f64)
        });
        means.reduce(f64::max)
    }
}

/// The lines from right to left of the pelvis and of the chest at each tick, in the axes of the figure.
fn lines(moving: &Moving<'_>, ticks: &[f64]) -> [Option<Vec<Vec3>>; 2] {
    let joints = ENDS.map(|[left, right]| moving.body.joint(left).zip(moving.body.joint(right)));
    let mut found = joints.map(|joints| joints.map(|_| Vec::with_capacity(ticks.len())));
    let world_to_frame = moving.body.axes.inverse();
    let binding = Binding::new(moving.scene, moving.animation);
    let mut pose = Pose::rest(moving.scene);
    for &tick in ticks {
        pose.sample(&binding, moving.animation, tick);
        for (line, joints) in found.iter_mut().zip(joints) {
            if let (Some(line), Some((left, right))) = (line, joints) {
                line.push(world_to_frame * (pose.position(left) - pose.position(right)));
            }
        }
    }
    found
}
