//! Collects the joints of a source motion that a pose of the target depends on, and samples these joints.

use glam::{Quat, Vec3};
use mocap_scene::math::directions::rotation_of;
use mocap_scene::pose::Pose;
use mocap_scene::scene::NodeId;

use super::body::Body;
use super::rotations::{Points, Rotations};

/// The joints of the source on which a pose of the target depends. An index into this list identifies a joint.
#[derive(Clone, Debug, Default)]
pub struct WatchedJoints {
    pub joints: Vec<Joint>,
}

/// A watched joint.
#[derive(Clone, Copy, Debug)]
pub struct Joint {
    pub node: NodeId,
    pub has_rotation: bool,
    pub has_place: bool,
}

impl WatchedJoints {
    fn joint(&mut self, node: NodeId) -> usize {
        let known = self.joints.iter().position(|joint| joint.node == node);
        known.unwrap_or_else(|| {
            self.joints.push(Joint {
                node,
                has_rotation: false,
                has_place: false,
            });
            self.joints.len() - 1
        })
    }

    /// Watches the rotation of a joint.
    pub(crate) fn rotation(&mut self, node: NodeId) -> usize {
        let joint = self.joint(node);
        self.joints[joint].has_rotation = true;
        joint
    }

    /// Watches the position of a joint.
    pub fn index_of(&mut self, node: NodeId) -> usize {
        let joint = self.joint(node);
        self.joints[joint].has_place = true;
        joint
    }
}

/// The rotations and positions of the watched joints in `N` poses, in the coordinate frame of the T-pose.
#[derive(Clone, Debug)]
pub struct WatchedPose<const N: usize> {
    pub rotations: Vec<Rotations<N>>,
    pub positions: Vec<Points<N>>,
}

impl<const N: usize> WatchedPose<N> {
    pub fn new(joints: usize) -> Self {
        Self {
            rotations: vec![Rotations::IDENTITY; joints],
            positions: vec![Points::ZERO; joints],
        }
    }

    /// Sets one of the poses from the pose of a whole skeleton.
    pub fn set(&mut self, lane: usize, pose: &Pose, body: &Body, watched: &WatchedJoints) {
        let world_to_frame = body.axes.inverse();
        let seen = self.rotations.iter_mut().zip(&mut self.positions);
        for (joint, (rotation, position)) in watched.joints.iter().zip(seen) {
            let Some(matrix) = pose.node_to_world.get(joint.node.index()) else {
                continue;
            };
            if joint.has_rotation {
                let to_frame: Quat = world_to_frame * rotation_of(matrix);
                rotation.set_lane(lane, to_frame.to_array());
            }
            if joint.has_place {
                let here: Vec3 = world_to_frame * matrix.w_axis.truncate();
                position.set_lane(lane, here.to_array());
            }
        }
    }
}
