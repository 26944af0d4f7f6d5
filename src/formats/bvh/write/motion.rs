//! The motion of a scene, and the first node of the hierarchy.

use glam::Vec3;
use mocap_scene::pose::{Binding, Trs};
use mocap_scene::scene::{Animation, Channel, GROUP_OF_ROOTS, Node, NodeId, NodeKind, Scene};

/// The largest difference between the scales of two axes in an even scale, as a fraction.
const EVEN: f32 = 1e-5;

/// The first animation of a scene, bound to its nodes.
pub(super) struct Motion<'a> {
    pub(super) scene: &'a Scene,
    pub(super) animation: Option<&'a Animation>,
    binding: Option<Binding>,
    /// The channel of each node.
    pub(super) channels: Vec<Option<&'a Channel>>,
    /// The first written node.
    pub(super) first: usize,
    /// The transform of the first node's ancestors.
    above: Trs,
}

impl<'a> Motion<'a> {
    pub(super) fn new(scene: &'a Scene) -> Self {
        let animation = scene.animations.first();
        let binding = animation.map(|animation| Binding::new(scene, animation));
        let mut channels = vec![None; scene.nodes.len()];
        if let (Some(animation), Some(binding)) = (animation, &binding) {
            for (node, channel) in binding.driven() {
                channels[node.index()] = animation.channels.get(channel);
            }
        }
        let first = first_written(scene, &channels);
        let mut above = Trs::IDENTITY;
        let parent = |node: usize| scene.nodes.get(node).and_then(|node| node.parent).map(NodeId::index);
        for node in std::iter::successors(parent(first), |node| parent(*node)) {
            above = placed(
                &stays(&scene.nodes[node], channels[node]).unwrap_or(Trs::IDENTITY),
                &above,
            );
        }
        Self {
            scene,
            animation,
            binding,
            channels,
            first,
            above,
        }
    }

    pub(super) fn rest(&self) -> Vec<Trs> {
        let nodes = self.scene.nodes.iter();
        let mut transforms: Vec<Trs> = nodes.map(|node| Trs::from_matrix(node.transform)).collect();
        if let Some(first) = transforms.get_mut(self.first) {
            *first = placed(&self.above, first);
        }
        transforms
    }

    /// Sets the transforms of the driven nodes in a frame.
    pub(super) fn sample(&self, frame: usize, transforms: &mut [Trs]) {
        if let (Some(animation), Some(binding)) = (self.animation, &self.binding) {
            binding.sample(animation, frame as f64, |node, trs| {
                transforms[node.index()] = match node.index() == self.first {
                    true => placed(&self.above, &trs),
                    false => trs,
                };
            });
        }
    }

    /// The written nodes: the first node and its descendants, or all nodes from the first if there are several roots.
    pub(super) fn written(&self) -> std::ops::Range<usize> {
        let nodes = &self.scene.nodes;
        let Some(first) = nodes.get(self.first) else {
            return 0..0;
        };
        let is_only_root = first
            .parent
            .is_none_or(|parent| nodes[parent.index()].name != GROUP_OF_ROOTS);
        let is_below = |node: &Node| node.parent.is_some_and(|parent| parent.index() >= self.first);
        let below = nodes[self.first + 1..].iter().take_while(|node| is_below(node)).count();
        match is_only_root {
            true => self.first..self.first + 1 + below,
            false => self.first..nodes.len(),
        }
    }

    /// The parent of a node, if the parent is written.
    pub(super) fn parent(&self, node: usize) -> Option<usize> {
        let parent = self.scene.nodes[node].parent.map(NodeId::index);
        parent.filter(|parent| *parent >= self.first)
    }
}

/// The first written node. Static groups with a single child that contains all joints are skipped, so that the skeleton
/// begins with its root. The group that a reader adds above several roots is skipped too.
fn first_written(scene: &Scene, channels: &[Option<&Channel>]) -> usize {
    let nodes = &scene.nodes;
    // A static group that only has a mesh needs no joint.
    let mut is_needed: Vec<bool> = std::iter::zip(nodes, channels)
        .map(|(node, channel)| node.kind != NodeKind::Group || stays(node, *channel).is_none())
        .collect();
    for (index, node) in nodes.iter().enumerate().rev() {
        if let Some(parent) = node.parent {
            is_needed[parent.index()] |= is_needed[index];
        }
    }
    let children = |index: usize| {
        let parent = Some(NodeId::new(index));
        let children = nodes.iter().enumerate().filter(move |(_, node)| node.parent == parent);
        children.map(|(child, _)| child)
    };
    let still = |index: usize| {
        let group = nodes.get(index).filter(|node| node.kind == NodeKind::Group)?;
        stays(group, channels[index])
    };
    let is_even = |scale: Vec3| scale.x > 0.0 && scale.abs_diff_eq(Vec3::splat(scale.x), EVEN * scale.x);
    let mut first = 0;
    while still(first).is_some_and(|place| is_even(place.scale)) {
        let needed: Vec<usize> = children(first).filter(|child| is_needed[*child]).collect();
        let only = match needed[..] {
            [only] => only,
            // Without joints, write the groups.
            [] => match children(first).collect::<Vec<_>>()[..] {
                [only] if still(first) == Some(Trs::IDENTITY) => only,
                _ => break,
            },
            _ => break,
        };
        first = only;
    }
    let holds_roots = |index: usize| {
        nodes[index].name == GROUP_OF_ROOTS
            && children(index).count() > 1
            && children(index).all(|child| nodes[child].kind != NodeKind::EndSite)
    };
    match still(first) == Some(Trs::IDENTITY) && holds_roots(first) {
        true => first + 1,
        false => first,
    }
}

/// The constant transform of a node; `None` if it moves. Some readers give keys to static nodes.
fn stays(node: &Node, channel: Option<&Channel>) -> Option<Trs> {
    let rest = Trs::from_matrix(node.transform);
    let Some(channel) = channel else { return Some(rest) };
    let scales = &channel.scaling_keys.values;
    let is_still = !channel.moves() && scales.iter().all(|scale| *scale == scales[0]);
    is_still.then(|| Trs {
        translation: channel
            .position_keys
            .values
            .first()
            .copied()
            .unwrap_or(rest.translation),
        rotation: channel.rotation_keys.values.first().copied().unwrap_or(rest.rotation),
        scale: scales.first().copied().unwrap_or(rest.scale),
    })
}

/// The product of an evenly scaled transform and a child's transform.
fn placed(above: &Trs, below: &Trs) -> Trs {
    // The child's transform keeps all bits, including the signs of zeros.
    if *above == Trs::IDENTITY {
        return *below;
    }
    Trs {
        translation: above.translation + above.rotation * (above.scale * below.translation),
        rotation: above.rotation * below.rotation,
        scale: above.scale * below.scale,
    }
}
