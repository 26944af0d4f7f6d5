//! Completes the bind pose of a skeleton.

use glam::DMat4;

use crate::scene::{Node, NodeId};

/// The largest difference at which a bind pose counts as equal to the rest pose, as a fraction of the largest number in
/// the pose.
const EQUAL: f64 = 1e-4;

/// Completes the bind pose of a skeleton. A node without a bound mesh, such as the end of a chain, follows its nearest
/// ancestor with a bound mesh. It keeps its rest pose relative to that ancestor. `None` remains for nodes in their rest
/// pose.
///
/// Both `rest` and `bind` are node-to-world matrices.
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
