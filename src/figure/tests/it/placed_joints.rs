//! Makes skeletons for tests from a list of joints.

use glam::{Mat4, Vec3};
use mocap::Scene;
use mocap::scene::{Node, NodeId, NodeKind};

/// The name of a joint, its parent, and its world position at rest.
pub(crate) type Joint = (&'static str, Option<usize>, [f32; 3]);

pub(crate) fn scene(joints: &[Joint]) -> Scene {
    let at = |joint: usize| Vec3::from(joints[joint].2);
    let nodes = joints.iter().enumerate().map(|(index, (name, parent, _))| Node {
        name: (*name).to_owned(),
        parent: parent.map(NodeId::new),
        transform: Mat4::from_translation(at(index) - parent.map_or(Vec3::ZERO, at)),
        kind: NodeKind::Joint,
        ..Node::default()
    });
    Scene {
        nodes: nodes.collect(),
        ..Scene::default()
    }
}
