//! Writes an animation into the node transforms of its own scene.

use crate::pose::{Binding, OutOfRange};
use crate::scene::Scene;

impl Scene {
    /// Writes position x rotation x scale at `tick` into [`Node::transform`](crate::scene::Node::transform) of every
    /// node with a channel in `animation`, an index into [`Scene::animations`]. Ticks out of range are clamped.
    ///
    /// Returns whether the scene has that animation. Every call looks up the names. An [`Updater`] looks them up once,
    /// and can loop.
    pub fn update_node_matrices(&mut self, animation: usize, tick: f64) -> bool {
        let updater = Updater::new(self, animation);
        if let Some(updater) = &updater {
            updater.update(self, tick);
        }
        updater.is_some()
    }
}

/// Like [`Scene::update_node_matrices`], but looks up names only once: an update does not allocate.
///
/// ```
/// use mocap::glam::Vec3;
/// use mocap::Updater;
/// use mocap::scene::{Animation, Channel, Keys, Node, Scene};
///
/// let mut scene = Scene {
///     nodes: vec![Node { name: "hip".into(), ..Node::default() }],
///     animations: vec![Animation {
///         duration: 1.0,
///         channels: vec![Channel {
///             node_name: "hip".into(),
///             position_keys: Keys::every_tick(vec![Vec3::ZERO, Vec3::X]),
///             ..Channel::default()
///         }],
///         ..Animation::default()
///     }],
///     ..Scene::default()
/// };
/// let updater = Updater::new(&scene, 0).expect("there is one animation");
/// updater.update(&mut scene, 1.0);
/// assert_eq!(scene.nodes[0].transform.w_axis.truncate(), Vec3::X);
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Updater {
    /// The node of every channel, and the channels and joints without a partner.
    pub binding: Binding,
    animation: usize,
}

impl Updater {
    /// Prepares updates of `scene` from `animation`, an index into [`Scene::animations`]; `None` if there is no such
    /// animation.
    pub fn new(scene: &Scene, animation: usize) -> Option<Self> {
        let binding = Binding::new(scene, scene.animations.get(animation)?);
        Some(Self { binding, animation })
    }

    /// Sets the meaning of ticks outside of the animation's range. Default: [`OutOfRange::Clamp`].
    #[must_use]
    pub fn out_of_range(mut self, out_of_range: OutOfRange) -> Self {
        self.binding = self.binding.out_of_range(out_of_range);
        self
    }

    /// Writes the transforms at `tick` into the nodes of `scene`, for which the updater was made.
    pub fn update(&self, scene: &mut Scene, tick: f64) {
        let Scene { nodes, animations, .. } = scene;
        if let Some(animation) = animations.get(self.animation) {
            self.binding.sample(animation, tick, |id, trs| {
                if let Some(node) = nodes.get_mut(id.index()) {
                    node.transform = trs.matrix();
                }
            });
        }
    }
}
