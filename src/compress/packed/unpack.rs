//! Converts a packed clip to a scene, with all its keys at once.

use glam::{Mat4, Quat, Vec3};
use mocap_scene::pose::Trs;
use mocap_scene::scene::{Animation, Channel, GROUP_OF_ROOTS, Keys, Node, NodeId, NodeKind, Scene};

use super::PackedClip;

impl PackedClip<'_> {
    /// Returns the skeleton, and an animation whose moving tracks have a key at each key frame.
    ///
    /// The memory grows with frames times tracks. A small file can state large counts, so check the counts first.
    #[doc(hidden)]
    pub fn unpack(&self) -> Scene {
        let key_ticks = self.key_ticks();
        let keys = |node: u32| (node as usize, Vec::with_capacity(key_ticks.len()));
        let mut rotations: Vec<(usize, Vec<Quat>)> = self.rotations.iter().map(|track| keys(track.node)).collect();
        let keys = |node: u32| (node as usize, Vec::with_capacity(key_ticks.len()));
        let mut translations: Vec<(usize, Vec<Vec3>)> =
            self.translations.iter().map(|track| keys(track.node)).collect();
        let mut pose = vec![Trs::IDENTITY; self.node_count()];
        for &tick in &key_ticks {
            self.sample(tick, &mut pose);
            for (node, values) in &mut rotations {
                values.push(pose[*node].rotation);
            }
            for (node, values) in &mut translations {
                values.push(pose[*node].translation);
            }
        }
        let mut nodes = self.scene_nodes();
        let mut channels: Vec<Channel> = std::iter::zip(&nodes, &self.rest)
            .enumerate()
            .map(|(index, (node, rest))| Channel {
                node_name: node.name.clone(),
                node: Some(NodeId::new(index)),
                position_keys: Keys::constant(rest.translation),
                rotation_keys: Keys::constant(rest.rotation.normalize()),
                scaling_keys: Keys::constant(rest.scale),
            })
            .collect();
        for (node, values) in rotations {
            channels[node].rotation_keys = Keys::at_ticks(values, key_ticks.clone());
            nodes[node].kind = NodeKind::Joint;
        }
        for (node, values) in translations {
            channels[node].position_keys = Keys::at_ticks(values, key_ticks.clone());
            nodes[node].kind = NodeKind::Joint;
        }
        let channels = std::iter::zip(channels, &nodes).filter(|(_, node)| node.kind == NodeKind::Joint);
        let animation = Animation {
            name: "Motion".to_owned(),
            ticks_per_second: self.ticks_per_second,
            duration: self.duration,
            channels: channels.map(|(channel, _)| channel).collect(),
        };
        Scene {
            nodes,
            animations: vec![animation],
            ..Scene::default()
        }
    }

    /// The nodes in their rest pose. An end site has no children.
    fn scene_nodes(&self) -> Vec<Node> {
        let node = |(index, rest): (usize, &Trs)| Node {
            name: self.name(index).to_owned(),
            kind: match self.is_end_site(index) {
                true => NodeKind::EndSite,
                false if index == 0 && self.name(index) == GROUP_OF_ROOTS => NodeKind::Group,
                false => NodeKind::Joint,
            },
            parent: self.parent(index).map(NodeId::new),
            transform: Mat4::from_scale_rotation_translation(rest.scale, rest.rotation.normalize(), rest.translation),
            ..Node::default()
        };
        let mut rest = self.rest.clone();
        for (index, at_rest) in &self.at_rest {
            rest[*index as usize] = *at_rest;
        }
        let mut nodes: Vec<Node> = rest.iter().enumerate().map(node).collect();
        for index in 1..nodes.len() {
            if let Some(parent) = self.parent(index)
                && nodes[parent].kind == NodeKind::EndSite
            {
                nodes[parent].kind = NodeKind::Joint;
            }
        }
        nodes
    }

    /// The ticks of the frames with keys.
    fn key_ticks(&self) -> Vec<f64> {
        if self.rotations.is_empty() && self.translations.is_empty() {
            return Vec::new();
        }
        let log2 = self.log2_block_frames;
        let has_key = |frame: usize| {
            let (start, offset) = (self.block_start(frame >> log2), frame & ((1 << log2) - 1));
            self.mask_bytes == 0 || self.mask(start)[offset / 64] >> (offset % 64) & 1 == 1
        };
        let frames = (0..self.frames).filter(|frame| has_key(*frame));
        frames.map(|frame| self.tick_of(frame)).collect()
    }
}
