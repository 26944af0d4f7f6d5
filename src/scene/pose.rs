//! Computes the matrices of every node at a tick.
//!
//! An animation's channels give the transform of each node relative to its parent at a tick. [`Binding`] finds the node
//! of each channel. Forward kinematics multiplies these matrices, starting at the root, T = J0 L1 J1 L2 ...: the motion
//! of a joint, then the offset of the next joint. The matrix of a node has both: its offset as translation, and its
//! motion as rotation. So the chain is one product per node. Because parents precede children, one loop computes all
//! products.
//!
//! The results are matrices, not translation, rotation and scale, because products may have shear.
//!
//! [`Updater`] writes into the scene itself, as users of Assimp do. A [`Pose`] is separate from the scene, so any
//! number of poses can use one scene.

mod bind;
mod binding;
mod chain;
mod face;
mod flat;
mod forward_kinematics;
mod same_joints;
mod sample;
mod skin;
mod updater;

use glam::{Mat3, Mat4, Quat, Vec3};

use crate::scene::{Animation, NodeId, NodeKind, Scene};

#[doc(hidden)]
pub use self::bind::complete_bind_pose;
pub use self::binding::{Binding, OutOfRange};
pub use self::chain::ChainMatrix;
#[doc(hidden)]
pub use self::face::FaceTrack;
#[doc(hidden)]
pub use self::flat::of_flat;
#[doc(hidden)]
pub use self::forward_kinematics::forward_kinematics;
#[doc(hidden)]
pub use self::same_joints::have_the_same_joints;
pub use self::sample::Trs;
pub use self::updater::Updater;

/// The matrices of all nodes of one skeleton, relative to the parent and to the world. [`NodeId`] indexes both lists.
///
/// ```
/// use mocap::glam::{Mat4, Vec3};
/// use mocap::Pose;
/// use mocap::scene::{Node, NodeId, Scene};
///
/// let upper = Node { transform: Mat4::from_translation(Vec3::Y), ..Node::default() };
/// let lower = Node { parent: Some(NodeId(0)), ..upper.clone() };
/// let scene = Scene { nodes: vec![upper, lower], ..Scene::default() };
///
/// let mut pose = Pose::rest(&scene);
/// assert_eq!(pose.position(NodeId(1)), Vec3::new(0.0, 2.0, 0.0));
///
/// pose.node_to_parent[0] *= Mat4::from_rotation_z(std::f32::consts::FRAC_PI_2);
/// pose.update_world();
/// assert!(pose.position(NodeId(1)).abs_diff_eq(Vec3::new(-1.0, 1.0, 0.0), 1e-6));
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Pose {
    /// For each node, the matrix from its space to the space of its parent.
    pub node_to_parent: Vec<Mat4>,
    /// For each node, the matrix from its space to the world, which is the space of the root's parent.
    /// [`Pose::update_world`] computes these matrices from `node_to_parent`.
    pub node_to_world: Vec<Mat4>,
    parents: Vec<Option<NodeId>>,
}

impl Pose {
    /// The pose of the node transforms in `scene`. It is the rest pose unless the transforms were updated.
    pub fn rest(scene: &Scene) -> Self {
        let mut pose = Self {
            node_to_parent: scene.nodes.iter().map(|node| node.transform).collect(),
            node_to_world: vec![Mat4::IDENTITY; scene.nodes.len()],
            parents: scene.nodes.iter().map(|node| node.parent).collect(),
        };
        pose.update_world();
        pose
    }

    /// The pose at `tick` of `animation`, an index into [`Scene::animations`]; `None` if there is no such animation.
    /// For more than one tick, keep a [`Binding`] and call [`Pose::sample`].
    pub fn at_tick(scene: &Scene, animation: usize, tick: f64) -> Option<Self> {
        let animation = scene.animations.get(animation)?;
        let mut pose = Self::rest(scene);
        pose.sample(&Binding::new(scene, animation), animation, tick);
        Some(pose)
    }

    /// Copies the current node transforms of `scene`, for example after [`Updater::update`]. The pose must have been
    /// made from this scene.
    pub fn copy_from(&mut self, scene: &Scene) {
        for (matrix, node) in self.node_to_parent.iter_mut().zip(&scene.nodes) {
            *matrix = node.transform;
        }
        self.update_world();
    }

    /// Sets the pose to `tick` of `animation`. Nodes without a channel do not change.
    ///
    /// ```
    /// use mocap::{Binding, Pose};
    /// use mocap::scene::{Animation, Scene};
    ///
    /// fn print_ends(scene: &Scene, animation: &Animation) {
    ///     let binding = Binding::new(scene, animation);
    ///     let mut pose = Pose::rest(scene);
    ///     for tick in 0..=animation.duration as u32 {
    ///         pose.sample(&binding, animation, f64::from(tick));
    ///         for end in scene.end_effectors() {
    ///             println!("{tick} {} {}", scene.nodes[end.index()].name, pose.position(end));
    ///         }
    ///     }
    /// }
    /// ```
    pub fn sample(&mut self, binding: &Binding, animation: &Animation, tick: f64) {
        binding.sample(animation, tick, |node, trs| {
            if let Some(matrix) = self.node_to_parent.get_mut(node.index()) {
                *matrix = trs.matrix();
            }
        });
        self.update_world();
    }

    /// [`node_to_parent`](Self::node_to_parent) as arrays, column by column, without a copy: for graphics APIs, and for
    /// programs with another version of glam.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Pose;
    ///
    /// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let pose = Pose::rest(&scene);
    /// let elbow: [f32; 16] = pose.node_to_parent_arrays()[1];
    /// assert_eq!(elbow[12..], [2.0, 0.0, 0.0, 1.0]);
    /// assert_eq!(pose.node_to_world_arrays()[2][12..], [3.5, 0.0, 0.0, 1.0]);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn node_to_parent_arrays(&self) -> &[[f32; 16]] {
        bytemuck::cast_slice(&self.node_to_parent)
    }

    /// [`node_to_world`](Self::node_to_world) as arrays, column by column, without a copy.
    pub fn node_to_world_arrays(&self) -> &[[f32; 16]] {
        bytemuck::cast_slice(&self.node_to_world)
    }

    /// Forward kinematics: computes `node_to_world` from `node_to_parent`.
    pub fn update_world(&mut self) {
        let parents = &self.parents;
        let node_to_parent = &self.node_to_parent;
        forward_kinematics(
            &mut self.node_to_world,
            |index| parents.get(index)?.map(NodeId::index),
            |index, parent_to_world, node_to_world| {
                if let Some(node_to_parent) = node_to_parent.get(index) {
                    *node_to_world = parent_to_world.map_or(*node_to_parent, |parent| *parent * *node_to_parent);
                }
            },
        );
    }

    /// Forward kinematics of `node` and its descendants, after `node_to_parent` changed only for these nodes.
    pub fn update_below(&mut self, node: NodeId) {
        let nodes = self.parents.iter().zip(&self.node_to_parent).enumerate();
        for (index, (parent, node_to_parent)) in nodes.skip(node.index()) {
            // In depth-first order, the descendants of a node follow it immediately.
            if index > node.index() && parent.is_none_or(|parent| parent < node) {
                break;
            }
            self.node_to_world[index] = match parent {
                Some(parent) => self.node_to_world[parent.index()] * *node_to_parent,
                None => *node_to_parent,
            };
        }
    }

    /// Rotates `node` about its own position by `rotation`, in world axes, together with its descendants. Its position
    /// does not change. A rotation is ignored if it would make a value non-finite.
    ///
    /// # Panics
    /// If the pose lacks the node.
    pub fn rotate(&mut self, node: NodeId, rotation: Quat) {
        let parent = self.parents[node.index()];
        let parent = parent.map_or(Mat3::IDENTITY, |parent| {
            Mat3::from_mat4(self.node_to_world[parent.index()])
        });
        let matrix = &mut self.node_to_parent[node.index()];
        let turned = parent.inverse() * (Mat3::from_quat(rotation) * (parent * Mat3::from_mat4(*matrix)));
        if turned.is_finite() {
            let translation = matrix.w_axis;
            *matrix = Mat4::from_mat3(turned);
            matrix.w_axis = translation;
            self.update_below(node);
        }
    }

    /// The world position of `node`.
    ///
    /// # Panics
    /// If the pose lacks the node.
    pub fn position(&self, node: NodeId) -> Vec3 {
        self.node_to_world[node.index()].w_axis.truncate()
    }

    /// The world position of a point in the space of `node`.
    ///
    /// # Panics
    /// If the pose lacks the node.
    pub fn point_to_world(&self, node: NodeId, point: Vec3) -> Vec3 {
        self.node_to_world[node.index()].transform_point3(point)
    }
}

impl Scene {
    /// The end effectors: end sites, and joints without children. [`Pose::position`] gives their positions.
    pub fn end_effectors(&self) -> impl Iterator<Item = NodeId> {
        // In depth-first order, the first child of a node follows it immediately.
        let is_leaf = |index: usize| {
            let next = self.nodes.get(index + 1);
            next.is_none_or(|next| next.parent != Some(NodeId::new(index)))
        };
        (0..self.nodes.len())
            .filter(move |&index| self.nodes[index].kind != NodeKind::Group && is_leaf(index))
            .map(NodeId::new)
    }
}
