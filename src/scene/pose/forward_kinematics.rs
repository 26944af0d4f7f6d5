//! Forward kinematics over nodes in which parents precede children.

/// Calls `update` for every node, parents first, with the index of the node, its updated parent, and the node.
///
/// The caller chooses the type of a node: a matrix at one time, or transforms at many times. `update` replaces the
/// node's transform relative to the parent by the product of the parent and this transform.
#[inline(always)]
#[doc(hidden)]
pub fn forward_kinematics<T>(
    nodes: &mut [T],
    parent_of: impl Fn(usize) -> Option<usize>,
    mut update: impl FnMut(usize, Option<&T>, &mut T),
) {
    for index in 0..nodes.len() {
        let (above, rest) = nodes.split_at_mut(index);
        if let Some(node) = rest.first_mut() {
            let parent = parent_of(index).and_then(|parent| above.get(parent));
            update(index, parent, node);
        }
    }
}
