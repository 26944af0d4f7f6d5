//! The frames of two motions that share a skeleton.

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::pose::{Binding, have_the_same_joints};
use mocap_scene::scene::{NodeId, Scene};

use super::frames::Frames;

/// The frames of an animation, and the frames of the first animation of `other`, a scene with the same joints. Both
/// lists of frames store every node that is moved by at least one of the two animations.
pub(super) fn pair(scene: &Scene, animation: usize, other: &Scene) -> Result<(Frames<'static>, Frames<'static>)> {
    if let Err(difference) = have_the_same_joints(scene, other) {
        let message = format!("the two motions have different skeletons: {difference}");
        let diagnostic = Diagnostic::new(Code::InvalidValue, message);
        return Err(diagnostic
            .help("first retarget one motion to the skeleton of the other motion")
            .into());
    }
    let driven = |scene: &Scene, animation: usize| -> Vec<NodeId> {
        let animation = scene.animations.get(animation);
        let binding = animation.map(|animation| Binding::new(scene, animation));
        binding.iter().flat_map(Binding::driven).map(|(node, _)| node).collect()
    };
    let nodes = [driven(scene, animation), driven(other, 0)].concat();
    let first = Frames::new(scene, animation, &nodes)?;
    first.require_nodes()?;
    Ok((first, Frames::new(other, 0, &nodes)?))
}
