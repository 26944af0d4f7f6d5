//! Computes the matrices of every node at a tick.
//!
//! An animation's channels say how each node stands to its parent at a tick ([`Binding`] finds out which node). Forward
//! kinematics chains these matrices from the root on, T = J0 L1 J1 L2 ...: the motion of a joint, then the offset of
//! the next. In a node both are one matrix, translation x rotation, so the chain is one product a node, and since
//! parents stand before children it is one loop.
//!
//! The results are matrices, not translation, rotation and scale, because products of those may have shear.
//!
//! [`Updater`] writes into the scene itself, as users of Assimp do; a [`Pose`] is separate from the scene, so any
//! number of poses can use one scene.

mod binding;
mod face;
mod flat;
mod forward_kinematics;
mod same_joints;
mod sample;
mod skin;
mod updater;

use glam::{Mat3, Mat4, Quat, Vec3};

use crate::scene::{Animation, NodeId, NodeKind, Scene};

pub use self::binding::{Binding, OutOfRange};
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

/// The matrices of all nodes of one skeleton, to the parent and to the world. [`NodeId`] indexes both lists.
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
    /// Node to parent.
    pub node_to_parent: Vec<Mat4>,
    /// Node to world, which is the space of the root's parent. [`Pose::update_world`] computes it from
    /// `node_to_parent`.
    pub node_to_world: Vec<Mat4>,
    parents: Vec<Option<NodeId>>,
}

impl Pose {
    /// The pose of the node transforms of `scene`: the rest pose, unless they were updated.
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

    /// Copies the current node transforms of `scene`, for example after [`Updater::update`]. `scene` must be the one
    /// that the pose was made from.
    pub fn copy_from(&mut self, scene: &Scene) {
        for (matrix, node) in self.node_to_parent.iter_mut().zip(&scene.nodes) {
            *matrix = node.transform;
        }
        self.update_world();
    }

    /// Moves to `tick` of `animation`. Nodes without a channel do not change.
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

    /// [`node_to_parent`](Self::node_to_parent) as arrays, column by column, without a copy: for graphics interfaces,
    /// and for programs with another version of glam.
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

    /// [`node_to_world`](Self::node_to_world) likewise.
    pub fn node_to_world_arrays(&self) -> &[[f32; 16]] {
        bytemuck::cast_slice(&self.node_to_world)
    }

    /// Forward kinematics: `node_to_world` from `node_to_parent`.
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

    /// Forward kinematics of `node` and of those below it, after a change of `node_to_parent` there alone.
    pub fn update_below(&mut self, node: NodeId) {
        let nodes = self.parents.iter().zip(&self.node_to_parent).enumerate();
        for (index, (parent, node_to_parent)) in nodes.skip(node.index()) {
            // Depth-first order: those below a node come right after it.
            if index > node.index() && parent.is_none_or(|parent| parent < node) {
                break;
            }
            self.node_to_world[index] = match parent {
                Some(parent) => self.node_to_world[parent.index()] * *node_to_parent,
                None => *node_to_parent,
            };
        }
    }

    /// Rotates `node` about its own position by `rotation`, along the axes of the world, with all nodes below it. Its
    /// position does not change. A rotation that would give values that are not finite is not applied.
    ///
    /// # Panics
    /// If the pose has no such node.
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

    /// The position of `node` in the world.
    ///
    /// # Panics
    /// If the pose has no such node.
    pub fn position(&self, node: NodeId) -> Vec3 {
        self.node_to_world[node.index()].w_axis.truncate()
    }

    /// The position in the world of a point in the space of `node`.
    ///
    /// # Panics
    /// If the pose has no such node.
    pub fn point_to_world(&self, node: NodeId, point: Vec3) -> Vec3 {
        self.node_to_world[node.index()].transform_point3(point)
    }
}

impl Scene {
    /// The end effectors: end sites, and joints without children. [`Pose::position`] gives their positions.
    pub fn end_effectors(&self) -> impl Iterator<Item = NodeId> {
        // Depth-first order: the first child of a node, if there is one, comes right after it.
        let is_leaf = |index: usize| {
            let next = self.nodes.get(index + 1);
            next.is_none_or(|next| next.parent != Some(NodeId::new(index)))
        };
        (0..self.nodes.len())
            .filter(move |&index| self.nodes[index].kind != NodeKind::Group && is_leaf(index))
            .map(NodeId::new)
    }
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::scene::{Channel, Keys, Node};

    /// The skeleton and the motion of the lecture's example: shoulder, elbow, wrist and its end site, on the x axis.
    ///
    /// ```text
    /// Shoulder --2-- Elbow --1.5-- Wrist --0.5-- EndSite_Wrist
    /// ```
    ///
    /// In frame n (from 0) the shoulder is at (0.1 (n + 1), 0.02 n, 0), and the joints are rotated about z by 5, 10 and
    /// 8 degrees times n + 1.
    fn lecture() -> Scene {
        let offsets = [0.0, 2.0, 1.5, 0.5].map(|x| Vec3::new(x, 0.0, 0.0));
        let names = ["Shoulder", "Elbow", "Wrist", "EndSite_Wrist"];
        let node = |index: usize| Node {
            name: names[index].into(),
            kind: if index == 3 { NodeKind::EndSite } else { NodeKind::Joint },
            parent: index.checked_sub(1).map(NodeId::new),
            transform: Mat4::from_translation(offsets[index]),
            ..Node::default()
        };
        let channel = |(index, degrees): (usize, f32)| Channel {
            node_name: names[index].into(),
            node: None,
            position_keys: Keys::constant(offsets[index]),
            rotation_keys: Keys::every_tick(
                (1u8..=10)
                    .map(|frame| Quat::from_rotation_z((degrees * f32::from(frame)).to_radians()))
                    .collect(),
            ),
            scaling_keys: Keys::constant(Vec3::ONE),
        };
        let mut channels: Vec<_> = [5.0, 10.0, 8.0].into_iter().enumerate().map(channel).collect();
        channels[0].position_keys = Keys::every_tick(
            (0u8..10)
                .map(f32::from)
                .map(|frame| Vec3::new(0.1 * (frame + 1.0), 0.02 * frame, 0.0))
                .collect(),
        );
        Scene {
            nodes: (0..4).map(node).collect(),
            animations: vec![Animation {
                ticks_per_second: 10.0,
                duration: 9.0,
                channels,
                ..Animation::default()
            }],
            ..Scene::default()
        }
    }

    /// A step of `length` in the direction of `degrees`, in the plane of the lecture's arm.
    fn step(length: f64, degrees: f64) -> Vec3 {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Vec3::new((length * cos) as f32, (length * sin) as f32, 0.0)
    }

    /// Where the arm's nodes are if the shoulder is at `shoulder` and each joint is rotated by its angle.
    fn arm(shoulder: Vec3, [first, second, third]: [f64; 3]) -> [Vec3; 4] {
        let elbow = shoulder + step(2.0, first);
        let wrist = elbow + step(1.5, first + second);
        let tip = wrist + step(0.5, first + second + third);
        [shoulder, elbow, wrist, tip]
    }

    fn assert_positions(pose: &Pose, expected: [Vec3; 4]) {
        for (index, expected) in expected.into_iter().enumerate() {
            let found = pose.position(NodeId::new(index));
            assert!(
                found.abs_diff_eq(expected, 1e-6),
                "node {index}: {found}, not {expected}"
            );
        }
    }

    #[test]
    fn at_rest_the_offsets_add_up() {
        let pose = Pose::rest(&lecture());
        assert_positions(&pose, [0.0, 2.0, 3.5, 4.0].map(|x| Vec3::new(x, 0.0, 0.0)));
    }

    #[test]
    fn at_tick_9_the_arm_stands_where_the_lecture_puts_it() {
        let pose = Pose::at_tick(&lecture(), 0, 9.0).unwrap();
        assert_positions(&pose, arm(Vec3::new(1.0, 0.18, 0.0), [50.0, 100.0, 80.0]));
    }

    #[test]
    fn every_tick_and_what_lies_between_follows_the_chain() {
        let scene = lecture();
        let animation = &scene.animations[0];
        let binding = Binding::new(&scene, animation);
        let mut pose = Pose::rest(&scene);
        for quarter in 0..=36 {
            // All angles and both coordinates of the shoulder grow by equal amounts from frame to frame.
            let tick = f64::from(quarter) / 4.0;
            pose.sample(&binding, animation, tick);
            let shoulder = Vec3::new((0.1 * (tick + 1.0)) as f32, (0.02 * tick) as f32, 0.0);
            assert_positions(
                &pose,
                arm(shoulder, [5.0, 10.0, 8.0].map(|degrees| degrees * (tick + 1.0))),
            );
        }
    }

    #[test]
    fn a_point_on_a_node_moves_with_it() {
        let pose = Pose::at_tick(&lecture(), 0, 9.0).unwrap();
        let [_, _, wrist, _] = arm(Vec3::new(1.0, 0.18, 0.0), [50.0, 100.0, 80.0]);
        // The wrist's x axis points at 230 degrees, its y axis at 320.
        let expected = wrist + step(3.0, 230.0) + step(4.0, 320.0) + Vec3::Z;
        let found = pose.point_to_world(NodeId(2), Vec3::new(3.0, 4.0, 1.0));
        assert!(found.abs_diff_eq(expected, 2e-6), "{found}, not {expected}");
    }

    #[test]
    fn the_scene_is_driven_to_the_same_pose() {
        let mut scene = lecture();
        let expected = Pose::at_tick(&scene, 0, 3.5).unwrap();
        let mut pose = Pose::rest(&scene);
        assert!(scene.update_node_matrices(0, 3.5));
        pose.copy_from(&scene);
        assert_eq!(pose, expected);
        assert_eq!(Pose::rest(&scene), expected);
    }

    #[test]
    fn an_animation_that_is_not_there_changes_nothing() {
        let mut scene = lecture();
        assert!(!scene.update_node_matrices(1, 3.0));
        assert_eq!(scene, lecture());
        assert!(Updater::new(&scene, 1).is_none());
        assert!(Pose::at_tick(&scene, 1, 3.0).is_none());
    }

    #[test]
    fn an_updater_clamps_or_loops() {
        let mut scene = lecture();
        let updater = Updater::new(&scene, 0).unwrap();
        let shoulder = |scene: &Scene| scene.nodes[0].transform.w_axis.x;
        updater.update(&mut scene, 12.0);
        assert_eq!(shoulder(&scene), 1.0);
        updater.out_of_range(OutOfRange::Loop).update(&mut scene, 12.0);
        assert_eq!(shoulder(&scene), 0.1 * 4.0);
    }

    #[test]
    fn a_chain_of_scales_and_rotations_shears() {
        // The root doubles x; its child is rotated by 45 degrees about z. A square on the child becomes a rhombus.
        let scene = Scene {
            nodes: vec![
                Node {
                    transform: Mat4::from_scale(Vec3::new(2.0, 1.0, 1.0)),
                    ..Node::default()
                },
                Node {
                    parent: Some(NodeId(0)),
                    transform: Mat4::from_rotation_z(std::f32::consts::FRAC_PI_4),
                    ..Node::default()
                },
            ],
            ..Scene::default()
        };
        let pose = Pose::rest(&scene);
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let (x, y) = (
            pose.point_to_world(NodeId(1), Vec3::X),
            pose.point_to_world(NodeId(1), Vec3::Y),
        );
        assert!(x.abs_diff_eq(Vec3::new(2.0 * half, half, 0.0), 1e-6), "{x}");
        assert!(y.abs_diff_eq(Vec3::new(-2.0 * half, half, 0.0), 1e-6), "{y}");
        // 1.5 apart from a right angle: no translation, rotation and scale is this matrix.
        assert!((x.dot(y) + 1.5).abs() < 1e-6);
        let without_shear = Trs::from_matrix(pose.node_to_world[1]).matrix();
        assert!(!without_shear.abs_diff_eq(pose.node_to_world[1], 0.1));
    }

    #[test]
    fn a_tree_has_an_end_for_each_branch() {
        // 0 group ─ 1 hip ┬ 2 spine ─ 3 end site
        //                 ├ 4 leg   ─ 5 foot (nothing below)
        //                 └ 6 tail (nothing below)
        let parents = [None, Some(0), Some(1), Some(2), Some(1), Some(4), Some(1)];
        let mut nodes: Vec<_> = parents
            .map(|parent| Node {
                parent: parent.map(NodeId),
                ..Node::default()
            })
            .into();
        nodes[0].kind = NodeKind::Group;
        nodes[3].kind = NodeKind::EndSite;
        let scene = Scene {
            nodes,
            ..Scene::default()
        };
        assert_eq!(scene.end_effectors().collect::<Vec<_>>(), [3, 5, 6].map(NodeId));
        assert_eq!(Scene::default().end_effectors().count(), 0);
    }
}
