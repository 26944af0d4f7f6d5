//! Pairs the joints of the left and right side.

use glam::DVec3;

use mocap_figure::{Humanoid, HumanoidBone};
use mocap_scene::pose::Pose;
use mocap_scene::scene::{NodeId, Scene};

/// The partner of every node. A node in the middle, or without a partner, is its own partner. Partners are mutual.
///
/// Most pairs come from the bones of the humanoid. The joints between two bones are paired with the joints between
/// their partners. Nodes below two partners become partners if, in the T-pose, one is nearest to the mirror image of
/// the other.
pub(super) fn partners(
    scene: &Scene,
    humanoid: &Humanoid,
    reference: &Pose,
    hips: NodeId,
    normal: DVec3,
) -> Vec<NodeId> {
    let mut partners: Vec<Option<NodeId>> = vec![None; scene.nodes.len()];
    for (bone, joint) in &humanoid.bones {
        let other = humanoid.joint(HumanoidBone::mirrored(*bone)).unwrap_or(joint.joint);
        partners[joint.joint.index()] = Some(other);
    }
    // Above each pair of bones, pairs the joints up to the next bone, one by one.
    for joint in humanoid.bones.values() {
        let Some(partner) = partners[joint.joint.index()].filter(|partner| *partner != joint.joint) else {
            continue;
        };
        let parent = |node: NodeId| scene.nodes[node.index()].parent;
        let is_free =
            |(a, b): &(NodeId, NodeId)| partners[a.index()].is_none() && partners[b.index()].is_none() && a != b;
        let next = |(a, b): &(NodeId, NodeId)| Some((parent(*a)?, parent(*b)?));
        let pairs = std::iter::successors(next(&(joint.joint, partner)), next);
        for (a, b) in pairs.take_while(is_free).collect::<Vec<_>>() {
            (partners[a.index()], partners[b.index()]) = (Some(b), Some(a));
        }
    }
    let from_hips = |node: usize| (reference.position(NodeId::new(node)) - reference.position(hips)).as_dvec3();
    for node in 0..scene.nodes.len() {
        if partners[node].is_some() {
            continue;
        }
        let above = scene.nodes[node]
            .parent
            .map(|parent| partners[parent.index()].unwrap_or(parent));
        let image = from_hips(node);
        let image = image - 2.0 * image.dot(normal) * normal;
        let is_free = |other: &usize| partners[*other].is_none() && scene.nodes[*other].parent == above;
        let nearest = (0..scene.nodes.len())
            .filter(is_free)
            .min_by(|a, b| from_hips(*a).distance(image).total_cmp(&from_hips(*b).distance(image)));
        let other = nearest.unwrap_or(node);
        partners[node] = Some(NodeId::new(other));
        partners[other] = Some(NodeId::new(node));
    }
    partners
        .iter()
        .enumerate()
        .map(|(node, partner)| partner.unwrap_or(NodeId::new(node)))
        .collect()
}
