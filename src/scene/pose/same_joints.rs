//! Compares the joints of two scenes.

use crate::scene::Scene;

/// Checks that two scenes have the same joints with the same parents, so that a pose of one is a pose of the other. The
/// error describes the first difference.
#[doc(hidden)]
pub fn have_the_same_joints(a: &Scene, b: &Scene) -> Result<(), String> {
    if a.nodes.len() != b.nodes.len() {
        return Err(format!(
            "one skeleton has {} nodes and the other {}",
            a.nodes.len(),
            b.nodes.len()
        ));
    }
    match a
        .nodes
        .iter()
        .zip(&b.nodes)
        .find(|(a, b)| a.name != b.name || a.parent != b.parent)
    {
        Some((a, b)) if a.name != b.name => Err(format!(
            "one skeleton has {:?}, but the other has {:?} in the same place",
            a.name, b.name
        )),
        Some((a, _)) => Err(format!("{:?} has another parent", a.name)),
        None => Ok(()),
    }
}
