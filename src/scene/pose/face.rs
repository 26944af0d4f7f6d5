//! Transfers the tracks of a face from one scene to another.

use super::{Binding, Trs};
use crate::scene::{Animation, Channel, Face, Keys, Node, NodeId, NodeKind, Scene};

/// A node of a face, and its keys in one animation. A node without animation has the keys of its rest pose.
#[derive(Clone, Debug, PartialEq)]
#[doc(hidden)]
pub struct FaceTrack {
    #[doc(hidden)]
    pub node: Node,
    #[doc(hidden)]
    pub face: Face,
    #[doc(hidden)]
    pub keys: Channel,
}

impl Scene {
    /// Whether the scene has expressions and no joints, so that it is a face without a body.
    #[doc(hidden)]
    pub fn is_face_alone(&self) -> bool {
        let has_faces = self.nodes.iter().any(|node| node.face.is_some());
        let is_none = |node: &Node| node.kind == NodeKind::Group || node.face.is_some();
        has_faces && self.nodes.iter().all(is_none)
    }

    /// The face tracks of an animation.
    #[doc(hidden)]
    pub fn face_tracks(&self, animation: &Animation) -> Vec<FaceTrack> {
        if self.nodes.iter().all(|node| node.face.is_none()) {
            return Vec::new();
        }
        let driven: Vec<_> = Binding::new(self, animation).driven().collect();
        let tracks = self.nodes.iter().enumerate().filter_map(|(index, node)| {
            let face = node.face.clone()?;
            let moved = driven.iter().find(|(driven, _)| driven.index() == index);
            let rest = Trs::from_matrix(node.transform);
            let keys = moved.map(|(_, channel)| animation.channels[*channel].clone());
            let keys = keys.unwrap_or_else(|| Channel {
                node_name: node.name.clone(),
                node: None,
                position_keys: Keys::constant(rest.translation),
                rotation_keys: Keys::constant(rest.rotation),
                scaling_keys: Keys::constant(rest.scale),
            });
            let node = node.clone();
            Some(FaceTrack { node, face, keys })
        });
        tracks.collect()
    }

    /// Sets the tracks of a face in an animation of the scene. `animation` is the index of the animation. A track
    /// without a node in the scene is dropped. If `adds` is set, such a track gets a new child node of the root
    /// instead. Returns the names of the dropped tracks.
    #[doc(hidden)]
    pub fn set_face(&mut self, animation: usize, tracks: &[FaceTrack], adds: bool) -> Vec<String> {
        let mut left_out = Vec::new();
        for track in tracks {
            let is_it = |node: &Node| node.face.as_ref().is_some_and(|face| face.is_part(&track.face));
            let index = match self.nodes.iter().position(is_it) {
                Some(index) => index,
                None if adds && !self.nodes.is_empty() => {
                    self.nodes.push(Node {
                        name: track.node.name.clone(),
                        kind: NodeKind::Group,
                        parent: Some(NodeId::new(0)),
                        transform: track.node.transform,
                        face: Some(track.face.clone()),
                        ..Node::default()
                    });
                    self.nodes.len() - 1
                }
                None => {
                    left_out.push(track.face.name().to_owned());
                    continue;
                }
            };
            let (id, name) = (NodeId::new(index), self.nodes[index].name.clone());
            let channels = &mut self.animations[animation].channels;
            channels.retain(|channel| channel.node != Some(id));
            let keys = Channel {
                node_name: name,
                node: Some(id),
                ..track.keys.clone()
            };
            let at = channels.partition_point(|channel| channel.node < Some(id));
            channels.insert(at, keys);
        }
        left_out
    }
}
