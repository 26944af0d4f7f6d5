//! Removes or separates root motion.
//!
//! Both steps take the plane of x and z in the world as the ground. So call
//! [`convert_units`](crate::Scene::convert_units) before them. A group above the root may be rotated, as in files with
//! +Z up.

mod carriers;

use self::carriers::Carriers;
use crate::scene::report::AppliedStep;
use crate::scene::{Node, NodeId, NodeKind, Scene};

/// The name of the new node, unless another node has this name.
const ROOT_NAME: &str = "Root";

impl Scene {
    /// Makes the motion in-place: keeps every root over the ground point where its motion starts. Height and rotations
    /// do not change.
    #[doc(hidden)]
    pub fn put_in_place(&mut self) {
        let roots: Vec<_> = roots(self).collect();
        for index in 0..self.animations.len() {
            for root in &roots {
                let carriers = Carriers::new(self, &self.animations[index], *root);
                carriers.put_in_place(&mut self.animations[index]);
            }
        }
        self.metadata.steps.push(AppliedStep::InPlace);
    }
}

impl Scene {
    /// Adds a joint named `Root` as the parent of the first root. The ground translation and the heading move to the
    /// new joint, as game engines expect. The old root keeps its height and its other rotations. World positions do not
    /// change. Returns the new joint; `None` if there is no root.
    #[doc(hidden)]
    pub fn extract_root_motion(&mut self) -> Option<NodeId> {
        let old_root = roots(self).next()?;
        let name = self.root_name();
        for index in 0..self.animations.len() {
            let carriers = Carriers::new(self, &self.animations[index], old_root);
            carriers.extract(&mut self.animations[index], &name);
        }

        self.insert_root_above(old_root);
        for channel in self.animations.iter_mut().flat_map(|animation| &mut animation.channels) {
            if channel.node_name == name {
                channel.node = Some(old_root);
            }
        }
        self.metadata.steps.push(AppliedStep::RootMotion);
        Some(old_root)
    }

    /// The name for a new root.
    fn root_name(&self) -> String {
        let is_taken = |name: &str| self.nodes.iter().any(|node| node.name == name);
        let numbered = (2..).map(|number| format!("{ROOT_NAME}_{number}"));
        let mut names = std::iter::once(ROOT_NAME.to_owned()).chain(numbered);
        names.find(|name| !is_taken(name)).unwrap_or_default()
    }

    /// Inserts a joint named `Root`, without a transform, as the parent of a node. The new joint takes the index of the
    /// node, and the following indices increase by one.
    #[doc(hidden)]
    #[doc(hidden)]
    pub fn insert_root_above(&mut self, below: NodeId) {
        let name = self.root_name();
        let shifted = |id: NodeId| if id < below { id } else { NodeId(id.0 + 1) };
        for node in &mut self.nodes {
            node.parent = node.parent.map(shifted);
        }
        for bone in self.meshes.iter_mut().flat_map(|mesh| &mut mesh.bones) {
            bone.node = shifted(bone.node);
        }
        for channel in self.animations.iter_mut().flat_map(|animation| &mut animation.channels) {
            channel.node = channel.node.map(shifted);
        }
        let parent = self.nodes[below.index()].parent.replace(below);
        self.nodes.insert(
            below.index(),
            Node {
                name,
                parent,
                ..Node::default()
            },
        );
    }
}

/// The root joints: the first node, or its children if it is only a group.
fn roots(scene: &Scene) -> impl Iterator<Item = NodeId> {
    let is_top =
        |parent: Option<NodeId>| parent.is_none_or(|parent| scene.nodes[parent.index()].kind == NodeKind::Group);
    let tops = scene
        .nodes
        .iter()
        .enumerate()
        .filter(move |(_, node)| node.kind == NodeKind::Joint && is_top(node.parent));
    tops.map(|(index, _)| NodeId::new(index))
}
