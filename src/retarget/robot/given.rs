//! The last frames of a stream, for its report.

use mocap_scene::math::quaternion::in_hemisphere_of;
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::{Animation, Channel, Keys, NodeId, Scene};

use super::motion::RobotMotion;
use super::source_rotations::SourceRotations;
use super::terms::Goals;

/// The time for which frames are kept for the report, in seconds: some tens of steps.
const SECONDS: f64 = 30.0;

/// The largest number of kept frames: 30 s at 120 frames per second.
const FRAMES: usize = 3600;

/// The last returned frames, and the poses of the source for these frames.
#[derive(Clone, Debug)]
pub struct Given {
    /// The skeleton of the source.
    pub(super) skeleton: Scene,
    pub motion: RobotMotion,
    pub(super) goals: Vec<Goals>,
    /// The rotations of the source, also for frames that were not returned yet.
    pub(super) rotations: SourceRotations,
    poses: Vec<Vec<Trs>>,
    most: usize,
}

impl Given {
    pub fn new(source: &Scene, motion: RobotMotion, rotations: SourceRotations) -> Self {
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

    /// Adds a pose of the source, whose frame is not returned yet.
    pub fn push(&mut self, source: &Pose) {
        self.rotations.push(source);
        let nodes = source.node_to_parent.iter();
        self.poses.push(nodes.map(|node| Trs::from_matrix(*node)).collect());
    }

    /// Adds returned frames, with their goals. Returns the number of old frames that were dropped.
    pub fn add(&mut self, frames: &RobotMotion, goals: &[Goals]) -> usize {
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

    /// The motion of the source in the returned frames.
    pub fn source(&self) -> Animation {
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
