//! Depth-first order of nodes, for files with another order.

use mocap_scene::scene::{Node, NodeId};

/// The indices of the nodes in depth-first order. A file may have them level by level.
pub(crate) fn depth_first(nodes: &[Node]) -> Vec<usize> {
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); nodes.len()];
    let mut next = Vec::new();
    // Backwards, because a stack returns the last node first.
    for (joint, node) in nodes.iter().enumerate().rev() {
        match node.parent {
            Some(parent) => children[parent.index()].push(joint),
            None => next.push(joint),
        }
    }
    let mut order = vec![0; nodes.len()];
    let mut count = 0;
    while let Some(joint) = next.pop() {
        order[joint] = count;
        count += 1;
        next.append(&mut children[joint]);
    }
    order
}

/// The nodes, in the order of the indices `order`.
pub(crate) fn sorted(nodes: Vec<Node>, order: &[usize]) -> Vec<Node> {
    let mut sorted = vec![Node::default(); nodes.len()];
    for (mut node, index) in nodes.into_iter().zip(order) {
        node.parent = node.parent.map(|parent| NodeId::new(order[parent.index()]));
        sorted[*index] = node;
    }
    sorted
}
