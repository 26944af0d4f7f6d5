//! Marks ancestors of the hips that only place the figure. Lengths, sizes, ids, units and graphs ignore these nodes.

use mocap_scene::scene::Scene;

use super::hierarchy::Hierarchy;
use crate::{Humanoid, HumanoidBone as Bone};

/// For each node, whether it only places the figure. The hips are a descendant of such a node, and neither the node nor
/// its other branches have a bone of the body. The line from such a joint to the next joint is not a bone: its length
/// changes with the position of the figure.
pub(super) fn placing(scene: &Scene, humanoid: &Humanoid) -> Vec<bool> {
    let mut places = vec![false; scene.nodes.len()];
    let Some(hips) = humanoid.joint(Bone::Hips).filter(|_| humanoid.found) else {
        return places;
    };
    let hierarchy = Hierarchy::new(scene);
    let outside: Vec<_> = humanoid
        .bones
        .values()
        .map(|bone| bone.joint)
        .filter(|joint| *joint != hips && !hierarchy.is_below(*joint, hips))
        .collect();
    for above in hierarchy.above(hips) {
        let is_above = |joint| hierarchy.above(joint).any(|node| node == above);
        places[above] = !outside.iter().any(|joint| joint.index() == above || is_above(*joint));
    }
    places
}
