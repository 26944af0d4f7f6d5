//! The rest transforms of nodes, which take the constant tracks.

use std::collections::HashMap;

use glam::{Quat, Vec3};
use gltf_json::{Node, scene::UnitQuaternion};
use mocap_scene::math::quaternion::unit;
use mocap_scene::pose::Binding;
use mocap_scene::scene::{self, Keys, NodeId, Scene};

use super::values::{Value, is_constant};

/// The rest transform of a node.
#[derive(Clone, Copy)]
pub(super) struct Rest {
    pub(super) translation: Vec3,
    pub(super) rotation: Quat,
    pub(super) scale: Vec3,
}

impl Rest {
    pub(super) fn is_finite(&self) -> bool {
        self.translation.is_finite() && self.rotation.is_finite() && self.scale.is_finite()
    }

    /// Writes the values that differ from glTF's defaults into `node`.
    pub(super) fn apply(&self, node: &mut Node) {
        node.translation = Some(self.translation).filter(|t| *t != Vec3::ZERO).map(Into::into);
        node.rotation = Some(self.rotation)
            .filter(|r| *r != Quat::IDENTITY)
            .map(|rotation| UnitQuaternion(rotation.into()));
        node.scale = Some(self.scale).filter(|scale| *scale != Vec3::ONE).map(Into::into);
    }
}

/// Moves a constant track to `rest` if all animations have the same constant value and the node can take this value. A
/// node can take any value if a skin keeps the rest pose. Without such a skin, a node can take only the value of its
/// rest pose. Other constant tracks are written as one key, because a node has only one rest transform.
pub(super) fn of_all(scene: &Scene, rest: &mut [Rest], has_bind_pose: bool) {
    let Some((first, others)) = scene.animations.split_first() else {
        return;
    };
    let still = |animation: &scene::Animation| -> HashMap<usize, ConstantValues> {
        let driven = Binding::new(scene, animation);
        let still = |(node, channel): (NodeId, usize)| (node.index(), ConstantValues::of(&animation.channels[channel]));
        driven.driven().map(still).collect()
    };
    let others: Vec<_> = others.iter().map(still).collect();
    for (node, still) in still(first) {
        let of = |other: &HashMap<usize, ConstantValues>| other.get(&node).copied().unwrap_or_default();
        let shared = others.iter().map(of).fold(still, ConstantValues::and);
        let transform = &mut rest[node];
        if let Some(translation) = shared
            .translation
            .filter(|value| value.is_finite() && (has_bind_pose || value.is_of_rest(transform.translation)))
        {
            transform.translation = translation + Vec3::ZERO;
        }
        let rotation = shared.rotation.and_then(unit);
        if let Some(rotation) = rotation.filter(|value| has_bind_pose || value.is_of_rest(transform.rotation)) {
            transform.rotation = rotation;
        }
        if let Some(scale) = shared.scale.filter(|scale| scale.is_finite()) {
            transform.scale = scale + Vec3::ZERO;
        }
    }
}

/// The constant values of a channel.
#[derive(Clone, Copy, Default)]
struct ConstantValues {
    translation: Option<Vec3>,
    rotation: Option<Quat>,
    scale: Option<Vec3>,
}

impl ConstantValues {
    fn of(channel: &scene::Channel) -> Self {
        fn value<T: Value<N>, const N: usize>(keys: &Keys<T>) -> Option<T> {
            keys.values.first().copied().filter(|_| is_constant(keys))
        }
        Self {
            translation: value(&channel.position_keys),
            rotation: value(&channel.rotation_keys),
            scale: value(&channel.scaling_keys),
        }
    }

    /// The values that both channels share.
    fn and(self, other: Self) -> Self {
        fn same<T: Value<N>, const N: usize>(a: Option<T>, b: Option<T>) -> Option<T> {
            a.filter(|a| b.is_some_and(|b| a.is_same(b)))
        }
        Self {
            translation: same(self.translation, other.translation),
            rotation: same(self.rotation, other.rotation),
            scale: same(self.scale, other.scale),
        }
    }
}
