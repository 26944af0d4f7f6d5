//! The joints that carry a figure over the ground.
//!
//! Usually the root carries the figure. Some programs put a root above the hips that never moves. In such a file the
//! carriers are the hips and the joints that travel next to them, such as goals of inverse kinematics.

use std::collections::HashMap;

use glam::{DMat4, DQuat, DVec3, Quat, Vec3, Vec4};

use super::super::collapse_keys::collapse;
use crate::pose::Binding;
use crate::scene::{Animation, Channel, Keys, NodeId, Scene};

/// The length in ticks from which a motion gets no key at every tick: a motion with few keys may last for years.
const MOST_TICKS: f64 = 1_048_576.0;

/// The sum of squares below which the twist about the up axis is undefined, because the figure is upside down.
const NO_HEADING: f64 = 1e-9;

/// A joint that carries the figure, with its channel.
struct Carrier {
    channel: usize,
    /// The rest transform to the parent.
    rest: DMat4,
    /// The transform from its parent to the parent of the root. No joint between them moves.
    to_space: DMat4,
}

/// The carriers below one root. The carrier with the most descendants is the first.
pub(super) struct Carriers {
    carriers: Vec<Carrier>,
    /// The transform from the parent of the root to the world, at rest.
    to_world: DMat4,
}

impl Carriers {
    pub(super) fn new(scene: &Scene, animation: &Animation, root: NodeId) -> Self {
        let channels: HashMap<NodeId, usize> = Binding::new(scene, animation).driven().collect();
        let found = travelling(scene, animation, &channels, root);
        let local = |node: NodeId| {
            let rest = scene.nodes[node.index()].transform.as_dmat4();
            channels.get(&node).map_or(rest, |channel| {
                let (scale, rotation, translation) = rest.to_scale_rotation_translation();
                let channel = &animation.channels[*channel];
                let first = |keys: &Keys<Vec3>| keys.values.first().map(|value| value.as_dvec3());
                DMat4::from_scale_rotation_translation(
                    first(&channel.scaling_keys).unwrap_or(scale),
                    (channel.rotation_keys.values.first()).map_or(rotation, |value| value.as_dquat()),
                    first(&channel.position_keys).unwrap_or(translation),
                )
            })
        };
        let parent = |node: NodeId| scene.nodes[node.index()].parent;
        let to_space = |node: NodeId| {
            let up_to_root = std::iter::successors(Some(node), |node| parent(*node).filter(|_| *node != root));
            up_to_root
                .skip(1)
                .fold(DMat4::IDENTITY, |below, node| local(node) * below)
        };
        let carriers = found.into_iter().filter_map(|node| {
            let carrier = Carrier {
                channel: *channels.get(&node)?,
                rest: scene.nodes[node.index()].transform.as_dmat4(),
                to_space: to_space(node),
            };
            carrier.to_space.inverse().is_finite().then_some(carrier)
        });
        Self {
            carriers: carriers.collect(),
            to_world: std::iter::successors(parent(root), |node| parent(*node)).fold(DMat4::IDENTITY, |below, node| {
                scene.nodes[node.index()].transform.as_dmat4() * below
            }),
        }
    }

    /// Keeps the first carrier above the ground point where it starts. The other carriers keep their positions relative
    /// to the first.
    pub(super) fn put_in_place(&self, animation: &mut Animation) {
        let Some(main) = self.carriers.first() else { return };
        let to_world = |carrier: &Carrier| self.to_world * carrier.to_space;
        let path = animation.channels[main.channel].position_keys.clone();
        let of_main = to_world(main);
        let at = |tick: f64| {
            path.sample(tick)
                .map(|value| of_main.transform_point3(value.as_dvec3()))
        };
        let Some(start) = path
            .values
            .first()
            .map(|value| of_main.transform_point3(value.as_dvec3()))
        else {
            return;
        };
        for (index, carrier) in self.carriers.iter().enumerate() {
            let to_world = to_world(carrier);
            let from_world = to_world.inverse();
            if !from_world.is_finite() {
                continue;
            }
            let keys = &mut animation.channels[carrier.channel].position_keys;
            let ticks: Vec<f64> = (0..keys.len()).map(|key| keys.tick(key)).collect();
            for (value, tick) in keys.values.iter_mut().zip(ticks) {
                let here = to_world.transform_point3(value.as_dvec3());
                let moved = at(tick).unwrap_or(start) - start;
                let kept = match index {
                    0 => start.with_y(here.y),
                    _ => here - moved.with_y(0.0),
                };
                *value = from_world.transform_point3(kept).as_vec3();
            }
        }
    }

    /// Moves the translation over the ground and the heading to a channel of a new node `name` above the root.
    pub(super) fn extract(&self, animation: &mut Animation, name: &str) {
        let Some((main, others)) = self.carriers.split_first() else {
            return;
        };
        let (_, to_world, _) = self.to_world.to_scale_rotation_translation();
        let to_world = if to_world.is_finite() {
            to_world
        } else {
            DQuat::IDENTITY
        };
        let from_world = to_world.inverse();
        let (ticks, poses) = main.poses(animation);
        let (_, rest, _) = (main.to_space * main.rest).to_scale_rotation_translation();
        let mut heading = DQuat::IDENTITY;
        let path = Vec::from_iter(poses.iter().map(|(position, rotation)| {
            let turned = to_world * *rotation * rest.inverse() * from_world;
            // The twist about Y of the swing-twist decomposition.
            if turned.y * turned.y + turned.w * turned.w > NO_HEADING {
                heading = DQuat::from_xyzw(0.0, turned.y, 0.0, turned.w).normalize();
            }
            let on_ground = from_world * (to_world * *position).with_y(0.0);
            (on_ground, from_world * heading * to_world)
        }));
        let root = Channel {
            node_name: name.to_owned(),
            node: None,
            position_keys: keys(path.iter().map(|(position, _)| position.as_vec3()).collect(), &ticks),
            rotation_keys: keys(path.iter().map(|(_, heading)| heading.as_quat()).collect(), &ticks),
            scaling_keys: Keys::constant(Vec3::ONE),
        };
        // The first carrier keeps its height, which a heading does not change.
        let left = std::iter::zip(&poses, &path).map(|((position, rotation), (on_ground, heading))| {
            (*position - *on_ground, heading.inverse() * *rotation)
        });
        main.set(animation, left.collect(), &ticks);
        for carrier in others {
            let (ticks, poses) = carrier.poses(animation);
            let left = std::iter::zip(&poses, &ticks).map(|((position, rotation), tick)| {
                let on_ground = root.position_keys.sample(*tick).unwrap_or_default().as_dvec3();
                let heading = root
                    .rotation_keys
                    .sample(*tick)
                    .unwrap_or_default()
                    .as_dquat()
                    .inverse();
                (heading * (*position - on_ground), heading * *rotation)
            });
            carrier.set(animation, left.collect(), &ticks);
        }
        animation.channels.insert(main.channel, root);
    }
}

impl Carrier {
    /// The poses of the carrier at each key, in the space of the root's parent, and the ticks of the keys.
    fn poses(&self, animation: &Animation) -> (Vec<f64>, Vec<(DVec3, DQuat)>) {
        let channel = &animation.channels[self.channel];
        let (positions, rotations) = (&channel.position_keys, &channel.rotation_keys);
        let mut ticks: Vec<f64> = (0..positions.len()).map(|key| positions.tick(key)).collect();
        ticks.extend((0..rotations.len()).map(|key| rotations.tick(key)));
        // Between two keys, the heading and the remaining rotation are interpolated on separate arcs. Their product is
        // not the original arc, so every tick gets a key.
        if rotations.ticks.is_some() && animation.duration < MOST_TICKS {
            ticks.extend((0..=animation.duration as u32).map(f64::from));
        }
        ticks.sort_unstable_by(f64::total_cmp);
        ticks.dedup();
        let (_, rotation, _) = self.to_space.to_scale_rotation_translation();
        let rest = self.rest.w_axis.truncate().as_vec3();
        let pose = |tick: &f64| {
            let position = positions.sample(*tick).unwrap_or(rest).as_dvec3();
            let turned = rotations.sample(*tick).unwrap_or(Quat::IDENTITY).as_dquat();
            (self.to_space.transform_point3(position), rotation * turned)
        };
        let poses = ticks.iter().map(pose).collect();
        (ticks, poses)
    }
    /// Sets the keys of the channel to these poses, given in the space of the root's parent.
    fn set(&self, animation: &mut Animation, poses: Vec<(DVec3, DQuat)>, ticks: &[f64]) {
        let from_space = self.to_space.inverse();
        let (_, rotation, _) = from_space.to_scale_rotation_translation();
        let (positions, rotations): (Vec<Vec3>, Vec<Quat>) = (poses.into_iter())
            .map(|(position, turned)| {
                let position = from_space.transform_point3(position);
                (position.as_vec3(), (rotation * turned).as_quat())
            })
            .unzip();
        let channel = &mut animation.channels[self.channel];
        channel.position_keys = keys(positions, ticks);
        channel.rotation_keys = keys(rotations, ticks);
    }
}

/// The joints that travel. If the root moves, this is the root. Otherwise these are the uppermost moving joints below
/// the root, if all of them change their position. If one of them only rotates, such as a leg below resting hips, the
/// root is returned.
fn travelling(scene: &Scene, animation: &Animation, channels: &HashMap<NodeId, usize>, root: NodeId) -> Vec<NodeId> {
    let channel = |node: &NodeId| channels.get(node).map(|channel| &animation.channels[*channel]);
    let of_vector = |value: Vec3| value.extend(0.0);
    let travels = |node: &NodeId| channel(node).is_some_and(|channel| varies(&channel.position_keys, of_vector));
    let moves = |node: &NodeId| {
        let turns = |channel: &Channel| varies(&channel.rotation_keys, Vec4::from);
        let scales = |channel: &Channel| varies(&channel.scaling_keys, of_vector);
        travels(node) || channel(node).is_some_and(|channel| turns(channel) || scales(channel))
    };
    if moves(&root) {
        return vec![root];
    }
    // For each node below the root, its uppermost moving ancestor, or the node itself. Parents come first.
    let mut first: Vec<Option<NodeId>> = vec![None; scene.nodes.len()];
    let (mut is_below, mut sizes) = (vec![false; scene.nodes.len()], vec![0_usize; scene.nodes.len()]);
    is_below[root.index()] = true;
    for (index, node) in scene.nodes.iter().enumerate() {
        let Some(parent) = node.parent.filter(|parent| is_below[parent.index()]) else {
            continue;
        };
        is_below[index] = true;
        first[index] = first[parent.index()].or_else(|| Some(NodeId::new(index)).filter(moves));
        first[index].into_iter().for_each(|first| sizes[first.index()] += 1);
    }
    let is_own = |node: &NodeId| first[node.index()] == Some(*node);
    let mut found: Vec<NodeId> = (0..first.len()).map(NodeId::new).filter(is_own).collect();
    if found.is_empty() || !found.iter().all(travels) {
        return vec![root];
    }
    found.sort_by_key(|node| std::cmp::Reverse(sizes[node.index()]));
    found
}

/// Whether a component changes by more than the rounding of other programs.
fn varies<T: Copy>(keys: &Keys<T>, components: impl Fn(T) -> Vec4) -> bool {
    /// The largest change that counts as rounding, in units of length or as a fraction of the value.
    const ROUNDING: f32 = 1e-5;
    let Some(first) = keys.values.first().map(|value| components(*value)) else {
        return false;
    };
    let most = ROUNDING * (1.0 + first.length());
    keys.values
        .iter()
        .any(|value| !components(*value).abs_diff_eq(first, most))
}

/// The keys of these values; a single key if all values are equal.
fn keys<T: Copy + PartialEq>(values: Vec<T>, ticks: &[f64]) -> Keys<T> {
    let mut keys = Keys::at_ticks(values, ticks.to_vec());
    collapse(&mut keys, |a, b| a == b);
    keys
}
