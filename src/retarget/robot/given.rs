//! What a stream gave in the last seconds, which its report is of.

use mocap_scene::math::quaternion::in_hemisphere_of;
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::{Animation, Channel, Keys, NodeId, Scene};

use super::motion::RobotMotion;
use super::source_rotations::SourceRotations;
use super::terms::Goals;

/// How long frames are kept for the report, in seconds, and how many at most: 30 s at 120 frames a second.
const SECONDS: f64 = 30.0;
const FRAMES: usize = 3600;

/// The frames that were given last, and the poses of the source that they are of.
#[derive(Clone, Debug)]
pub(super) struct Given {
    /// The skeleton of the source.
    pub(super) skeleton: Scene,
    pub(super) motion: RobotMotion,
    pub(super) goals: Vec<Goals>,
    /// Those of frames that are still to be given too.
    pub(super) rotations: SourceRotations,
    poses: Vec<Vec<Trs>>,
    most: usize,
}

impl Given {
    pub(super) fn new(source: &Scene, motion: RobotMotion, rotations: SourceRotations) -> Self {
        Self {
            skeleton: Scene {
                nodes: source.nodes.clone(),
                metadata: source.metadata.clone(),
                ..Scene::default()
            },
            most: ((SECONDS * motion.fps) as usize).clamp(1, FRAMES),
            motion,
            goals: Vec::new(),
            rotations,
            poses: Vec::new(),
        }
    }

    /// Takes a pose of the source whose frame is still to be given.
    pub(super) fn push(&mut self, source: &Pose) {
        self.rotations.push(source);
        let nodes = source.node_to_parent.iter();
        self.poses.push(nodes.map(|node| Trs::from_matrix(*node)).collect());
    }

    /// Takes frames that are given, with their goals. Returns how many were forgotten for them.
    pub(super) fn add(&mut self, frames: &RobotMotion, goals: &[Goals]) -> usize {
        self.motion.root.extend(&frames.root);
        self.motion.dof_pos.extend(&frames.dof_pos);
        self.motion.contacts.extend(&frames.contacts);
        self.goals.extend_from_slice(goals);
        let count = self.motion.frames().saturating_sub(self.most);
        self.motion.forget(count);
        self.goals.drain(..count);
        self.rotations.forget(count);
        self.poses.drain(..count);
        count
    }

    /// The motion of the source in the frames that were given.
    pub(super) fn source(&self) -> Animation {
        let poses = &self.poses[..self.motion.frames()];
        let channel = |index: usize| {
            let of_node = || poses.iter().map(move |pose| pose[index]);
            let mut rotations: Vec<_> = of_node().map(|trs| trs.rotation).collect();
            for frame in 1..rotations.len() {
                rotations[frame] = in_hemisphere_of(rotations[frame - 1], rotations[frame]);
            }
            Channel {
                node_name: self.skeleton.nodes[index].name.clone(),
                node: Some(NodeId::new(index)),
                position_keys: Keys::every_tick(of_node().map(|trs| trs.translation).collect()),
                rotation_keys: Keys::every_tick(rotations),
                scaling_keys: Keys::every_tick(of_node().map(|trs| trs.scale).collect()),
            }
        };
        Animation {
            name: self.motion.name.clone(),
            ticks_per_second: self.motion.fps,
            duration: poses.len().saturating_sub(1) as f64,
            channels: (0..self.skeleton.nodes.len()).map(channel).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mocap_figure::Humanoid;
    use mocap_scene::scene::Node;
    use mocap_scene::scene::robot::Placement;

    #[test]
    fn half_a_minute_is_kept() {
        let scene = Scene {
            nodes: vec![Node::default()],
            ..Scene::default()
        };
        let frame = |at: f64| RobotMotion {
            fps: 10.0,
            root: vec![Placement::IDENTITY],
            dof_pos: vec![at],
            dof_names: vec!["joint".to_owned()],
            contacts: vec![[false; 2]],
            ..RobotMotion::default()
        };
        let mut empty = frame(0.0);
        empty.forget(1);
        let mut given = Given::new(&scene, empty, SourceRotations::empty(&Humanoid::of(&scene)));
        let mut pose = Pose::rest(&scene);
        for at in 0..400_u16 {
            pose.node_to_parent[0].w_axis.x = f32::from(at);
            given.push(&pose);
            if at >= 5 {
                given.add(&frame(f64::from(at - 5)), &[Goals::default()]);
            }
        }
        assert_eq!(given.motion.frames(), 300);
        assert_eq!(given.motion.dof_pos[0], 95.0);
        let positions = &given.source().channels[0].position_keys.values;
        assert_eq!((positions.len(), positions[0].x, positions[299].x), (300, 95.0, 394.0));
    }
}
