//! Finds the node of every channel once.

use std::borrow::Cow;
use std::collections::HashMap;

use crate::pose::sample::{Moment, Moving, Trs};
use crate::scene::{Animation, Channel, Node, NodeId, NodeKind, Scene};

/// The meaning of a tick outside of an animation's range.
///
/// [`Binding`](crate::Binding) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum OutOfRange {
    /// The nearest end: the first frame before the start, the last frame after the end.
    #[default]
    Clamp,
    /// The animation repeats in both directions. Its period is its duration, so the last frame and the first show the
    /// same phase of two cycles. Both ticks are in range, and each has its own frame.
    Loop,
}

impl OutOfRange {
    /// Maps `tick` to a tick from 0 to `duration`. The result is 0 for NaN, and if the duration is not above 0.
    ///
    /// ```
    /// use mocap::OutOfRange;
    ///
    /// assert_eq!(OutOfRange::Clamp.resolve(11.5, 9.0), 9.0);
    /// assert_eq!(OutOfRange::Loop.resolve(11.5, 9.0), 2.5);
    /// assert_eq!(OutOfRange::Loop.resolve(-2.5, 9.0), 6.5);
    /// ```
    pub fn resolve(self, tick: f64, duration: f64) -> f64 {
        if tick.is_nan() || duration.is_nan() || duration <= 0.0 {
            return 0.0;
        }
        match self {
            Self::Loop if tick.is_infinite() => 0.0,
            Self::Loop if !(0.0..=duration).contains(&tick) => tick.rem_euclid(duration),
            _ => tick.clamp(0.0, duration),
        }
    }
}

/// The nodes of an animation's channels.
///
/// The constructor looks up names; sampling needs neither look-ups nor allocations. A binding holds no reference. So
/// one animation can drive any number of skeletons, each with its own binding and [`Pose`](crate::pose::Pose), from any
/// thread. A binding stores the values of constant tracks. Make a new binding if the animation or the nodes change.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::{Binding, OutOfRange, Trs};
///
/// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
/// let animation = &scene.animations[0];
/// let binding = Binding::new(&scene, animation).out_of_range(OutOfRange::Loop);
/// let mut elbow = Trs::IDENTITY;
/// binding.sample(animation, 9.0 + 0.5, |node, transform| {
///     if scene.nodes[node.index()].name == "Elbow" {
///         elbow = transform;
///     }
/// });
/// assert_eq!(elbow.translation.x, 2.0); // the link from the shoulder keeps its length
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Binding {
    /// The channels without a node, as indices into [`Animation::channels`]. They have no effect.
    pub channels_without_node: Vec<usize>,
    /// The joints without a channel. These joints do not change.
    pub joints_without_channel: Vec<NodeId>,
    out_of_range: OutOfRange,
    links: Vec<Link>,
}

#[derive(Clone, Debug)]
struct Link {
    channel: usize,
    node: NodeId,
    /// The constant components: the single key of a track, or the node's own value if the track has no keys.
    still: Trs,
    /// The tracks with several keys, which are sampled.
    moving: Moving,
}

impl Binding {
    /// Binds `animation` to its own skeleton.
    ///
    /// A channel drives its [`node`](crate::scene::Channel::node) if that node has the channel's name. Otherwise,
    /// channels and nodes with the same name are paired in their order. End sites are not counted. Translations,
    /// rotations and scales all come from the animation.
    pub fn new(scene: &Scene, animation: &Animation) -> Self {
        let known = |channel: &Channel| {
            let named = |id: &NodeId| {
                scene
                    .nodes
                    .get(id.index())
                    .is_some_and(|node| node.name == channel.node_name)
            };
            channel.node.filter(named)
        };
        Self::find(scene, animation, known, Cow::Borrowed)
    }

    /// Binds `animation` to the skeleton of another file, joint by joint. `node_name_of` maps a channel's
    /// [`node_name`](crate::scene::Channel::node_name) to the name of a node of `scene`.
    ///
    /// The skeleton keeps its own proportions: a position track with a single key is only an OFFSET of the source
    /// skeleton, so it is applied only to a root. Rotations are applied unchanged. So the bones of both rest poses
    /// should have the same directions, as in T-poses.
    ///
    /// ```
    /// use mocap::Binding;
    /// use mocap::scene::{Animation, Channel, Node, Scene};
    ///
    /// let node = |name: &str| Node { name: name.into(), ..Node::default() };
    /// let channel = |name: &str| Channel { node_name: name.into(), ..Channel::default() };
    /// let scene = Scene { nodes: vec![node("Hips"), node("Tail")], ..Scene::default() };
    /// let channels = vec![channel("mixamorig:Hips"), channel("mixamorig:Head")];
    /// let clip = Animation { channels, ..Animation::default() };
    ///
    /// let binding = Binding::onto(&scene, &clip, |name| name.trim_start_matches("mixamorig:"));
    /// assert_eq!(binding.channels_without_node, [1]); // Head
    /// assert_eq!(scene.nodes[binding.joints_without_channel[0].index()].name, "Tail");
    /// ```
    pub fn onto<'a, S: Into<Cow<'a, str>>>(
        scene: &Scene,
        animation: &'a Animation,
        node_name_of: impl Fn(&'a str) -> S,
    ) -> Self {
        let mut binding = Self::find(scene, animation, |_| None, |name| node_name_of(name).into());
        for link in &mut binding.links {
            if !link.moving.position && !is_root(scene, link.node) {
                link.still.translation = scene.nodes[link.node.index()].transform.w_axis.truncate();
            }
        }
        binding
    }

    /// Finds the node of every channel: the node from `known`, or else the next node of its name without a channel.
    fn find<'a>(
        scene: &Scene,
        animation: &'a Animation,
        known: impl Fn(&Channel) -> Option<NodeId>,
        node_name_of: impl Fn(&'a str) -> Cow<'a, str>,
    ) -> Self {
        let mut is_driven = vec![false; scene.nodes.len()];
        for id in animation.channels.iter().filter_map(&known) {
            is_driven[id.index()] = true;
        }
        let mut nodes_by_name: HashMap<&str, Vec<NodeId>> = HashMap::new();
        // The nodes are added in reverse order. So the last node in the list of a name is the next node to use.
        for (index, node) in scene.nodes.iter().enumerate().rev() {
            if node.kind != NodeKind::EndSite && !is_driven[index] {
                nodes_by_name.entry(&node.name).or_default().push(NodeId::new(index));
            }
        }

        let mut links = Vec::with_capacity(animation.channels.len());
        let mut channels_without_node = Vec::new();
        for (index, channel) in animation.channels.iter().enumerate() {
            let by_name = || {
                let name = node_name_of(&channel.node_name);
                nodes_by_name.get_mut(name.as_ref()).and_then(Vec::pop)
            };
            let Some(id) = known(channel).or_else(by_name) else {
                channels_without_node.push(index);
                continue;
            };
            is_driven[id.index()] = true;
            if !channel.is_empty() {
                let rest = Trs::from_matrix(scene.nodes[id.index()].transform);
                links.push(Link {
                    channel: index,
                    node: id,
                    still: channel.sample(0.0, rest),
                    moving: Moving::of(channel),
                });
            }
        }

        let joints_without_channel = std::iter::zip(&scene.nodes, is_driven)
            .enumerate()
            .filter(|(_, (node, is_driven))| node.kind == NodeKind::Joint && !is_driven)
            .map(|(index, _)| NodeId::new(index))
            .collect();
        Self {
            channels_without_node,
            joints_without_channel,
            out_of_range: OutOfRange::default(),
            links,
        }
    }

    /// The driven nodes, each with the index of its channel in [`Animation::channels`].
    pub fn driven(&self) -> impl Iterator<Item = (NodeId, usize)> {
        self.links.iter().map(|link| (link.node, link.channel))
    }

    /// Sets the meaning of ticks outside of the animation's range. Default: [`OutOfRange::Clamp`].
    #[must_use]
    pub fn out_of_range(mut self, out_of_range: OutOfRange) -> Self {
        self.out_of_range = out_of_range;
        self
    }

    /// Calls `drive` with every driven node and its transform relative to its parent at `tick`.
    ///
    /// Between two keys, positions and scales are interpolated linearly and rotations by slerp on the shorter arc. A
    /// component without keys keeps its value from the time of binding. A node whose channel has no keys is skipped.
    #[inline]
    pub fn sample(&self, animation: &Animation, tick: f64, mut drive: impl FnMut(NodeId, Trs)) {
        let moment = Moment::new(self.out_of_range.resolve(tick, animation.duration));
        for link in &self.links {
            if let Some(channel) = animation.channels.get(link.channel) {
                drive(link.node, channel.sample_moving(moment, link.moving, link.still));
            }
        }
    }
}

/// Whether the translation of `node` is a world position, not the offset of a link.
fn is_root(scene: &Scene, node: NodeId) -> bool {
    let parent = scene.nodes[node.index()]
        .parent
        .and_then(|parent| scene.nodes.get(parent.index()));
    parent.is_none_or(|parent| parent.kind == NodeKind::Group)
}

impl Scene {
    /// The joints whose position relative to their parent joint changes.
    #[doc(hidden)]
    pub fn position_curves(&self, animation: &Animation) -> Vec<NodeId> {
        let binding = Binding::new(self, animation);
        let is_curve = |(node, channel): &(NodeId, usize)| {
            let joint = &self.nodes[node.index()];
            let parent = |node: &Node| node.parent.map(|parent| &self.nodes[parent.index()]);
            let mut above = std::iter::successors(parent(joint), |node| parent(node));
            joint.kind == NodeKind::Joint
                && joint.face.is_none()
                && above.any(|node| node.kind == NodeKind::Joint)
                && animation.channels[*channel].goes()
        };
        binding.driven().filter(is_curve).map(|(node, _)| node).collect()
    }
}
