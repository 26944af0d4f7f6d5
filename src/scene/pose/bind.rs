//! The bind pose of a whole skeleton.

use glam::DMat4;

use crate::scene::{Node, NodeId};

/// How far, as a fraction of its largest number, a bind pose may be from the rest pose that is equal to it.
const EQUAL: f64 = 1e-4;

/// Completes the bind pose of a skeleton. A node without a bound mesh, such as the end of a chain, follows the nearest
/// node above it that has one. Its pose relative to that node is that at rest. `None` remains for nodes that are where
/// they rest.
///
/// Both `rest` and `bind` are to the world.
pub fn complete_bind_pose(nodes: &[Node], rest: &[DMat4], bind: &mut [Option<DMat4>]) {
    let mut is_moved = vec![false; nodes.len()];
    for (index, node) in nodes.iter().enumerate() {
        let parent = node.parent.map(NodeId::index);
        if let Some(bind) = bind[index] {
            let largest = rest[index]
                .to_cols_array()
                .into_iter()
                .fold(0.0, |a: f64, b| a.max(b.abs()));
            is_moved[index] = !bind.abs_diff_eq(rest[index], EQUAL * largest);
        } else if let Some((parent, parent_bind)) = parent.and_then(|parent| Some((parent, bind[parent]?)))
            && is_moved[parent]
        {
            let follows = parent_bind * rest[parent].inverse() * rest[index];
            is_moved[index] = follows.is_finite();
            bind[index] = is_moved[index].then_some(follows);
        }
    }
}
