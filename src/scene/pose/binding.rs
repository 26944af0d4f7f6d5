//! Finds the node of every channel, once.

use std::borrow::Cow;
use std::collections::HashMap;

use crate::pose::sample::{Moment, Moving, Trs};
use crate::scene::{Animation, Channel, NodeId, NodeKind, Scene};

/// The meaning of a tick outside of an animation.
///
/// [`Binding`](crate::Binding) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum OutOfRange {
    /// The nearest end: the first frame before the start, the last frame after the end.
    #[default]
    Clamp,
    /// The animation repeats in both directions. Its period is its duration, so the last frame and the first are the
    /// same moment of two cycles; neither tick is out of range, and each has its own frame.
    Loop,
}

impl OutOfRange {
    /// The tick from 0 to `duration` for `tick`. It is 0 for NaN, and for every tick if the duration is not above 0.
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
/// Names are looked up when the binding is made; sampling needs neither look-up nor allocation. A binding holds no
/// reference, so one animation can drive any number of skeletons, each with its own binding and
/// [`Pose`](crate::pose::Pose), from any thread. It is valid for the animation and the nodes that it was made from, and
/// has already read the constant tracks: make a new one when either changes.
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
    /// The joints without a channel. They do not change.
    pub joints_without_channel: Vec<NodeId>,
    out_of_range: OutOfRange,
    links: Vec<Link>,
}

#[derive(Clone, Debug)]
struct Link {
    channel: usize,
    node: NodeId,
    /// The constant components: the key of a track with one key, the node's own value for a track without keys.
    still: Trs,
    /// The tracks with more than one key, which are sampled.
    moving: Moving,
}

impl Binding {
    /// Binds `animation` to the skeleton that it was made for.
    ///
    /// A channel drives its [`node`](crate::scene::Channel::node) if that node has the channel's name. Of the others,
    /// the first channel of a name drives the first node of that name that is not an end site, the second channel the
    /// second, and so on. Translations, rotations and scales all come from the animation.
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

    /// Binds `animation` to the skeleton of another file, joint by joint. `node_name_of` is the map of names: from
    /// a channel's [`node_name`](crate::scene::Channel::node_name) to the name of a node of `scene`.
    ///
    /// The skeleton keeps its own proportions: a position track with a single key is only the OFFSET of its skeleton,
    /// and is applied only to a root. Rotations are applied unchanged, so the links of both rest poses should have the
    /// same directions, as in T-poses.
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

    /// Finds the node of every channel: the one from `known`, or else the next of its name without a channel.
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
        // From the back, so that the next node of a name is the last of its list.
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

    /// The nodes that are driven, each with the index of its channel in [`Animation::channels`].
    pub fn driven(&self) -> impl Iterator<Item = (NodeId, usize)> {
        self.links.iter().map(|link| (link.node, link.channel))
    }

    /// Sets the meaning of ticks outside of the animation. Default: [`OutOfRange::Clamp`].
    #[must_use]
    pub fn out_of_range(mut self, out_of_range: OutOfRange) -> Self {
        self.out_of_range = out_of_range;
        self
    }

    /// Calls `drive` with every driven node and its transform to the parent at `tick`.
    ///
    /// Between two keys, positions and scales are interpolated linearly and rotations by slerp on the shorter arc. A
    /// component whose track has no key keeps its value from when the binding was made; a node whose channel has no key
    /// at all is left out.
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

/// Whether the translation of `node` is a position in the world, not the offset of a link.
fn is_root(scene: &Scene, node: NodeId) -> bool {
    let parent = scene.nodes[node.index()]
        .parent
        .and_then(|parent| scene.nodes.get(parent.index()));
    parent.is_none_or(|parent| parent.kind == NodeKind::Group)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glam::{Mat4, Quat, Vec3};

    use super::*;
    use crate::pose::Pose;
    use crate::scene::{Keys, Node};

    fn node(name: &str, kind: NodeKind, parent: Option<u32>, offset: Vec3) -> Node {
        Node {
            name: name.into(),
            kind,
            parent: parent.map(NodeId),
            transform: Mat4::from_translation(offset),
            ..Node::default()
        }
    }

    /// A channel as a BVH joint with rotation channels has it: one position key, its OFFSET.
    fn channel(node_name: &str, offset: Vec3) -> Channel {
        Channel {
            node_name: node_name.into(),
            position_keys: Keys::constant(offset),
            rotation_keys: Keys::every_tick(vec![Quat::IDENTITY, Quat::from_rotation_z(1.0)]),
            scaling_keys: Keys::constant(Vec3::ONE),
            ..Channel::default()
        }
    }

    fn clip(channels: Vec<Channel>) -> Animation {
        Animation {
            duration: 1.0,
            channels,
            ..Animation::default()
        }
    }

    /// hip - spine - spine - (end site "spine"), and a tail on the hip.
    fn scene() -> Scene {
        Scene {
            nodes: vec![
                node("hip", NodeKind::Joint, None, Vec3::Y),
                node("spine", NodeKind::Joint, Some(0), Vec3::Y),
                node("spine", NodeKind::Joint, Some(1), Vec3::Y * 2.0),
                node("spine", NodeKind::EndSite, Some(2), Vec3::Y * 3.0),
                node("tail", NodeKind::Joint, Some(0), Vec3::X),
            ],
            ..Scene::default()
        }
    }

    fn driven(binding: &Binding, animation: &Animation) -> Vec<(u32, Vec3)> {
        let mut driven = Vec::new();
        binding.sample(animation, 0.0, |node, trs| driven.push((node.0, trs.translation)));
        driven
    }

    #[test]
    fn channels_of_one_name_drive_the_joints_of_that_name_in_turn() {
        let [a, b, c] = [1.0, 2.0, 3.0].map(Vec3::splat);
        let animation = clip(vec![channel("spine", a), channel("hip", b), channel("spine", c)]);
        let binding = Binding::new(&scene(), &animation);
        assert_eq!(driven(&binding, &animation), [(1, a), (0, b), (2, c)]);
        assert_eq!(binding.channels_without_node, [0usize; 0]);
        assert_eq!(binding.joints_without_channel, [NodeId(4)]);
    }

    #[test]
    fn a_channel_too_many_is_reported_and_end_sites_are_left_alone() {
        let mut animation = clip(vec![channel("spine", Vec3::ONE); 3]);
        animation.channels.insert(0, channel("wing", Vec3::ONE));
        let binding = Binding::new(&scene(), &animation);
        assert_eq!(driven(&binding, &animation), [(1, Vec3::ONE), (2, Vec3::ONE)]);
        assert_eq!(binding.channels_without_node, [0, 3]);
        assert_eq!(binding.joints_without_channel, [NodeId(0), NodeId(4)]);
    }

    #[test]
    fn a_channel_that_knows_its_node_leaves_the_others_of_its_name_to_those_that_do_not() {
        let [a, b, c] = [1.0, 2.0, 3.0].map(Vec3::splat);
        let mut animation = clip(vec![channel("spine", a), channel("spine", b), channel("spine", c)]);
        animation.channels[0].node = Some(NodeId(2));
        // An end site, which no name reaches.
        animation.channels[1].node = Some(NodeId(3));
        let binding = Binding::new(&scene(), &animation);
        assert_eq!(driven(&binding, &animation), [(2, a), (3, b), (1, c)]);
        // The ids of another scene are not taken for ids of this one.
        for stale in [NodeId(0), NodeId(9)] {
            animation.channels[0].node = Some(stale);
            let binding = Binding::new(&scene(), &animation);
            assert_eq!(driven(&binding, &animation), [(1, a), (3, b), (2, c)], "{stale:?}");
        }
        // Another skeleton has other ids.
        let binding = Binding::onto(&scene(), &animation, |name| name);
        assert_eq!(driven(&binding, &animation)[0].0, 1);
    }

    #[test]
    fn another_skeleton_keeps_its_proportions_and_takes_the_root_motion() {
        let mut animation = clip(vec![
            channel("Hips", Vec3::splat(9.0)),
            channel("Spine", Vec3::splat(9.0)),
            channel("Tail", Vec3::splat(9.0)),
            channel("Head", Vec3::splat(9.0)),
        ]);
        // The tail really moves: that is motion, not proportion.
        animation.channels[2].position_keys = Keys::every_tick(vec![Vec3::Z, Vec3::X]);
        let names = HashMap::from([("Hips", "hip"), ("Spine", "spine"), ("Tail", "tail")]);
        let binding = Binding::onto(&scene(), &animation, |name| names.get(name).copied().unwrap_or(name));
        assert_eq!(
            driven(&binding, &animation),
            [(0, Vec3::splat(9.0)), (1, Vec3::Y), (4, Vec3::Z)]
        );
        assert_eq!(binding.channels_without_node, [3]);
        assert_eq!(binding.joints_without_channel, [NodeId(2)]);

        // A map may also make names up.
        let binding = Binding::onto(&scene(), &animation, str::to_lowercase);
        assert_eq!(driven(&binding, &animation), [(1, Vec3::Y), (4, Vec3::Z)]);
    }

    #[test]
    fn a_joint_under_a_group_is_a_root() {
        let scene = Scene {
            nodes: vec![
                node("file", NodeKind::Group, None, Vec3::ZERO),
                node("hip", NodeKind::Joint, Some(0), Vec3::Y),
            ],
            ..Scene::default()
        };
        let animation = clip(vec![channel("hip", Vec3::X)]);
        let binding = Binding::onto(&scene, &animation, |name| name);
        assert_eq!(driven(&binding, &animation), [(1, Vec3::X)]);
        assert_eq!(binding.joints_without_channel, []);
    }

    #[test]
    fn tracks_without_keys_leave_the_rest_transform_alone() {
        // Sheared, as no translation, rotation and scale can be.
        let sheared = Mat4::from_cols_array(&[
            1.0, 0.0, 0.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0,
        ]);
        let mut scene = scene();
        scene.nodes[4].transform = sheared;
        let mut animation = clip(vec![channel("hip", Vec3::X), channel("tail", Vec3::X)]);
        animation.channels[0].position_keys = Keys::default();
        animation.channels[1] = Channel {
            node_name: "tail".into(),
            ..Channel::default()
        };
        let binding = Binding::new(&scene, &animation);
        assert_eq!(binding.joints_without_channel, [NodeId(1), NodeId(2)]);
        let mut pose = Pose::rest(&scene);
        pose.sample(&binding, &animation, 1.0);
        let turned = Mat4::from_translation(Vec3::Y) * Mat4::from_rotation_z(1.0);
        assert!(pose.node_to_parent[0].abs_diff_eq(turned, 1e-6));
        assert_eq!(pose.node_to_parent[4], sheared);
    }

    #[test]
    fn a_binding_of_something_else_does_no_harm() {
        let animation = clip(vec![channel("hip", Vec3::X), channel("tail", Vec3::X)]);
        let binding = Binding::new(&scene(), &animation);
        let mut shorter = animation.clone();
        shorter.channels.truncate(1);
        let mut pose = Pose::rest(&Scene {
            nodes: scene().nodes[..1].to_vec(),
            ..Scene::default()
        });
        pose.sample(&binding, &shorter, 0.0);
        pose.sample(&binding, &animation, 0.0);
        assert_eq!(pose.node_to_parent, [Mat4::from_translation(Vec3::X)]);
    }

    #[test]
    fn ticks_out_of_range_clamp_or_loop() {
        let animation = Animation {
            duration: 2.0,
            channels: vec![Channel {
                position_keys: Keys::every_tick(vec![Vec3::ZERO, Vec3::X, Vec3::X * 2.0]),
                ..channel("hip", Vec3::ZERO)
            }],
            ..Animation::default()
        };
        let clamping = Binding::new(&scene(), &animation);
        let looping = clamping.clone().out_of_range(OutOfRange::Loop);
        let x = |binding: &Binding, tick| {
            let mut x = f32::NAN;
            binding.sample(&animation, tick, |_, trs| x = trs.translation.x);
            x
        };
        for (tick, clamped, looped) in [
            (0.0, 0.0, 0.0),
            (2.0, 2.0, 2.0),
            (2.5, 2.0, 0.5),
            (5.25, 2.0, 1.25),
            (-0.5, 0.0, 1.5),
            (f64::NAN, 0.0, 0.0),
            (f64::INFINITY, 2.0, 0.0),
            (f64::NEG_INFINITY, 0.0, 0.0),
        ] {
            assert_eq!((x(&clamping, tick), x(&looping, tick)), (clamped, looped), "{tick}");
        }
    }

    #[test]
    fn an_animation_without_length_stands_at_tick_0() {
        for out_of_range in [OutOfRange::Clamp, OutOfRange::Loop] {
            for duration in [0.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
                assert_eq!(out_of_range.resolve(PI, duration), 0.0);
            }
        }
    }
}
