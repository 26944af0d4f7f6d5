//! The hierarchy of nodes.

use mocap_scene::scene::{NodeId, Scene};

/// The parents of the nodes of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
#[doc(hidden)]
pub struct Hierarchy {
    #[doc(hidden)]
    pub parents: Vec<Option<usize>>,
}

impl Hierarchy {
    pub(crate) fn new(scene: &Scene) -> Self {
        Self {
            parents: scene.nodes.iter().map(|node| node.parent.map(NodeId::index)).collect(),
        }
    }

    /// The ancestors of a node, from its parent to the root.
    pub(crate) fn above(&self, node: NodeId) -> impl Iterator<Item = usize> {
        std::iter::successors(self.parents[node.index()], |node| self.parents[*node])
    }

    /// Whether a node is a descendant of another.
    pub(crate) fn is_below(&self, node: NodeId, ancestor: NodeId) -> bool {
        self.above(node).any(|above| above == ancestor.index())
    }

    /// The nodes between the node `from` and its descendant `to`, from the top down. `from` and `to` are not included.
    /// `None` if `to` is not a descendant.
    pub(crate) fn path(&self, from: NodeId, to: NodeId) -> Option<Vec<NodeId>> {
        self.is_below(to, from).then(|| {
            let between = self.above(to).take_while(|node| *node != from.index());
            let mut path: Vec<_> = between.map(NodeId::new).collect();
            path.reverse();
            path
        })
    }

    pub(crate) fn first_child(&self, node: NodeId) -> Option<NodeId> {
        self.children(node).next()
    }

    /// The only child of a node.
    pub(crate) fn only_child(&self, node: NodeId) -> Option<NodeId> {
        let mut children = self.children(node);
        let child = children.next()?;
        children.next().is_none().then_some(child)
    }

    pub(crate) fn children(&self, node: NodeId) -> impl Iterator<Item = NodeId> {
        let is_child = move |child: &usize| self.parents[*child] == Some(node.index());
        (node.index() + 1..self.parents.len()).filter(is_child).map(NodeId::new)
    }
}
