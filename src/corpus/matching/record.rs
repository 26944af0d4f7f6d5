//! Records the motion of a figure.

use glam::{Quat, Vec3};
use mocap_scene::math::quaternion::in_hemisphere_of;
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::{Animation, Channel, Keys, NodeId, Scene};

use super::controller::Controller;
use super::features::FEATURE_RATE;

/// The recorded poses, frame by frame.
pub(super) struct Record {
    hips: NodeId,
    positions: Vec<Vec3>,
    nodes: Vec<NodeId>,
    rotations: Vec<Vec<Quat>>,
}

impl Record {
    pub(super) fn new(controller: &Controller, character: &Scene) -> Self {
        let hips = controller.hips();
        let moves = |node: &NodeId| *node == hips || controller.moved().contains(node);
        let nodes: Vec<NodeId> = (0..character.nodes.len()).map(NodeId::new).filter(moves).collect();
        Self {
            hips,
            positions: Vec::new(),
            rotations: vec![Vec::new(); nodes.len()],
            nodes,
        }
    }

    pub(super) fn add(&mut self, pose: &Pose) {
        for (node, rotations) in self.nodes.iter().zip(&mut self.rotations) {
            let trs = Trs::from_matrix(pose.node_to_parent[node.index()]);
            let last = rotations.last().copied().unwrap_or(trs.rotation);
            rotations.push(in_hemisphere_of(last, trs.rotation));
            if *node == self.hips {
                self.positions.push(trs.translation);
            }
        }
    }

    pub(super) fn animation(self, character: &Scene) -> Animation {
        let duration = self.positions.len().saturating_sub(1) as f64;
        let positions = self.positions;
        let hips = self.hips;
        let channel = |(node, rotations): (NodeId, Vec<Quat>)| {
            let at_rest = Trs::from_matrix(character.nodes[node.index()].transform);
            Channel {
                node_name: character.nodes[node.index()].name.clone(),
                node: Some(node),
                position_keys: match node == hips {
                    true => Keys::every_tick(positions.clone()),
                    false => Keys::constant(at_rest.translation),
                },
                rotation_keys: Keys::every_tick(rotations),
                scaling_keys: Keys::constant(at_rest.scale),
            }
        };
        Animation {
            name: "match".to_owned(),
            ticks_per_second: FEATURE_RATE,
            duration,
            channels: self.nodes.into_iter().zip(self.rotations).map(channel).collect(),
        }
    }
}
