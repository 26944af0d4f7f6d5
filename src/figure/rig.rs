//! Handles rigs in which a joint of the skin follows another joint than its parent.
//!
//! In a modelling program, constraints move such joints, but files do not store constraints. Examples: an IK control of
//! a foot as a child of the root, an eye or a hat outside the skeleton, and a deforming spine separate from the
//! animated spine. A motion of the skeleton would leave these joints behind, and stretch the skin. This module makes
//! such a joint a child of the joint that it follows, by the first rule that applies:
//!
//! 1. It coincides with a joint without its own skin that carries other joints of the skin.
//! 2. It shares vertices or faces with a joint far down another limb, and almost none with the top of that limb.
//! 3. No ancestor has a skin, it shares no vertices, and its vertices are nearest to the vertices of a joint far down a
//! limb.
//! 4. It has no skin, and it is at the end of a limb.

mod shared_skin;

use std::collections::BTreeMap;

use glam::{DMat4, Quat, Vec3};
use mocap_scene::pose::{Binding, Pose, Trs};
use mocap_scene::scene::{Animation, Channel, NodeId, NodeKind, Scene};

use self::shared_skin::SharedSkin;
use crate::ticks::{Ticks, ticks};

/// The largest distance between two joints that count as being at the same position, as a fraction of the height of the
/// skeleton.
const SAME_PLACE: f32 = 2e-4;

/// A joint without a fitting parent follows a joint far down a limb with which it shares vertices. At most this
/// fraction of the shared vertices may belong to joints near the top of that limb.
const NEAR_PARENT: f32 = 0.05;

/// A distance from a joint to its parent, as a fraction of the height of the skeleton. Below this distance, the nearest
/// vertices do not show which joint the joint follows. Hips without a skin of their own are near to thighs and spine.
const FAR_FROM_PARENT: f32 = 0.2;

/// The largest distance between the skins of a joint and the joint that it follows, as a fraction of the height of the
/// skeleton.
const NEAR_SKIN: f32 = 0.05;

/// A scene in which each joint of the skin is a child of the joint that it follows, in the rest pose of the file.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Rig {
    /// The nodes and meshes, without animations. Node ids differ from the ids in the file.
    pub scene: Scene,
    /// The node of the file for each node of `scene`.
    to_file: Vec<NodeId>,
    /// The node of `scene` for each node of the file.
    of_file: Vec<NodeId>,
    /// The nodes of `scene` with a new parent, each with its parent in the file.
    moved: Vec<(NodeId, Option<NodeId>)>,
}

impl Rig {
    /// `None` if each joint follows its parent, as in most files. `stated` has joints and the joints that they follow,
    /// as nodes of the file.
    pub fn new(file: &Scene, stated: &BTreeMap<NodeId, NodeId>) -> Option<Self> {
        let parents = Parents::new(file, stated);
        parents.has_changed.then(|| Self::with_parents(file, &parents.of))
    }

    fn with_parents(file: &Scene, parents: &[Option<usize>]) -> Self {
        let count = file.nodes.len();
        let mut children = vec![Vec::new(); count];
        let mut open = Vec::new();
        for node in (0..count).rev() {
            match parents[node] {
                Some(parent) => children[parent].push(node),
                None => open.push(node),
            }
        }
        let mut to_file = Vec::with_capacity(count);
        while let Some(node) = open.pop() {
            to_file.push(NodeId::new(node));
            open.append(&mut children[node]);
        }
        let mut of_file = vec![NodeId::default(); count];
        for (index, node) in to_file.iter().enumerate() {
            of_file[node.index()] = NodeId::new(index);
        }
        let world = worlds(file);
        let nodes = to_file.iter().map(|id| {
            let mut node = file.nodes[id.index()].clone();
            let parent = parents[id.index()];
            if parent != node.parent.map(NodeId::index) {
                let above = parent.map_or(DMat4::IDENTITY, |parent| world[parent]);
                node.transform = (above.inverse() * world[id.index()]).as_mat4();
            }
            node.parent = parent.map(|parent| of_file[parent]);
            node
        });
        let mut meshes = file.meshes.clone();
        for bone in meshes.iter_mut().flat_map(|mesh| &mut mesh.bones) {
            bone.node = of_file[bone.node.index()];
        }
        let scene = Scene {
            nodes: nodes.collect(),
            meshes,
            materials: file.materials.clone(),
            metadata: file.metadata.clone(),
            ..Scene::default()
        };
        let in_file = |node: usize| {
            file.nodes[to_file[node].index()]
                .parent
                .map(|parent| of_file[parent.index()])
        };
        let moved = (0..count).filter(|node| in_file(*node) != scene.nodes[*node].parent);
        let moved = moved.map(|node| (NodeId::new(node), in_file(node))).collect();
        Self {
            scene,
            to_file,
            of_file,
            moved,
        }
    }

    /// Converts a node of the file to a node of [`Self::scene`].
    pub fn node(&self, of_file: NodeId) -> NodeId {
        self.of_file[of_file.index()]
    }

    /// Converts a node of [`Self::scene`] to a node of the file.
    pub fn node_of_file(&self, node: NodeId) -> NodeId {
        self.to_file[node.index()]
    }

    /// The joints that follow another joint than their parent, each with the joint that it follows, as nodes of the
    /// file.
    pub fn followers(&self) -> impl Iterator<Item = (NodeId, NodeId)> {
        self.moved.iter().filter_map(|(node, _)| {
            let parent = self.scene.nodes[node.index()].parent?;
            Some((self.node_of_file(*node), self.node_of_file(parent)))
        })
    }

    /// Converts an animation of the file to [`Self::scene`]. The world transforms of all nodes do not change.
    pub fn in_rig(&self, file: &Scene, animation: &Animation) -> Animation {
        let moved = self.moved.iter().map(|(node, _)| {
            let parent = self.scene.nodes[node.index()].parent;
            (self.node_of_file(*node), parent.map(|parent| self.node_of_file(parent)))
        });
        carry(file, &moved.collect::<Vec<_>>(), &self.of_file, animation)
    }

    /// Converts an animation of [`Self::scene`] to the file. The world transforms of all nodes do not change.
    pub fn in_file(&self, animation: &Animation) -> Animation {
        carry(&self.scene, &self.moved, &self.to_file, animation)
    }

    /// Sets `pose` to the pose `file` of the file, except for nodes with a new parent.
    pub fn take_pose(&self, file: &Pose, pose: &mut Pose) {
        for (index, id) in self.to_file.iter().enumerate() {
            if !self.moved.iter().any(|(node, _)| node.index() == index) {
                pose.node_to_parent[index] = file.node_to_parent[id.index()];
            }
        }
    }

    /// Sets a pose of the file to a pose of [`Self::scene`].
    pub fn give_pose(&self, pose: &Pose, file: &mut Pose) {
        for (index, id) in self.to_file.iter().enumerate() {
            file.node_to_parent[id.index()] = pose.node_to_parent[index];
        }
        for (node, above) in &self.moved {
            let above = above.map_or(DMat4::IDENTITY, |above| pose.node_to_world[above.index()].as_dmat4());
            let world = pose.node_to_world[node.index()].as_dmat4();
            file.node_to_parent[self.node_of_file(*node).index()] = (above.inverse() * world).as_mat4();
        }
        file.update_world();
    }
}

/// Converts an animation of a scene to the same nodes with other parents. `moved` has the nodes with a new parent, each
/// with this parent. `ids` has the new ids of all nodes.
fn carry(scene: &Scene, moved: &[(NodeId, Option<NodeId>)], ids: &[NodeId], animation: &Animation) -> Animation {
    let binding = Binding::new(scene, animation);
    let stays = |node: &NodeId| !moved.iter().any(|(moved, _)| moved == node);
    let channels = binding.driven().filter(|(node, _)| stays(node));
    let channels = channels.map(|(node, channel)| Channel {
        node: Some(ids[node.index()]),
        ..animation.channels[channel].clone()
    });
    let mut channels: Vec<Channel> = channels.collect();
    let ticks = ticks(animation);
    let mut local: Vec<Vec<Trs>> = vec![Vec::with_capacity(ticks.len()); moved.len()];
    let mut pose = Pose::rest(scene);
    for tick in &ticks {
        pose.sample(&binding, animation, *tick);
        for (keys, (node, above)) in local.iter_mut().zip(moved) {
            let world = |node: NodeId| pose.node_to_world[node.index()].as_dmat4();
            let above = above.map_or(DMat4::IDENTITY, world);
            keys.push(Trs::from_matrix((above.inverse() * world(*node)).as_mat4()));
        }
    }
    let at = Ticks::new(&ticks);
    for (keys, (node, _)) in local.into_iter().zip(moved) {
        let mut before = Quat::IDENTITY;
        let rotations = keys.iter().map(|key| {
            let is_far = key.rotation.dot(before) < 0.0;
            before = if is_far { -key.rotation } else { key.rotation };
            before
        });
        channels.push(Channel {
            node_name: scene.nodes[node.index()].name.clone(),
            node: Some(ids[node.index()]),
            rotation_keys: at.rotation_keys(rotations.collect()),
            position_keys: at.keys(keys.iter().map(|key| key.translation).collect()),
            scaling_keys: at.keys(keys.iter().map(|key| key.scale).collect()),
        });
    }
    let mut animation = Animation {
        name: animation.name.clone(),
        ticks_per_second: animation.ticks_per_second,
        duration: animation.duration,
        channels,
    };
    animation.sort_channels();
    animation
}

/// The rest pose in the world.
fn worlds(scene: &Scene) -> Vec<DMat4> {
    let mut world: Vec<DMat4> = Vec::with_capacity(scene.nodes.len());
    for node in &scene.nodes {
        let above = node.parent.map_or(DMat4::IDENTITY, |parent| world[parent.index()]);
        world.push(above * node.transform.as_dmat4());
    }
    world
}

/// The parents of the nodes of a file, while some joints get a new parent.
struct Parents<'a> {
    file: &'a Scene,
    of: Vec<Option<usize>>,
    has_changed: bool,
    /// The position of each node at rest.
    at: Vec<Vec3>,
    /// The height of the skeleton, or its largest extent.
    size: f32,
    skin: SharedSkin,
}

impl<'a> Parents<'a> {
    fn new(file: &'a Scene, stated: &BTreeMap<NodeId, NodeId>) -> Self {
        let world = worlds(file);
        let at: Vec<Vec3> = world.iter().map(|world| world.w_axis.truncate().as_vec3()).collect();
        let joints = || {
            file.nodes
                .iter()
                .zip(&at)
                .filter(|(node, at)| node.kind == NodeKind::Joint && at.is_finite())
        };
        let (least, most) = joints().fold((Vec3::MAX, Vec3::MIN), |(least, most), (_, at)| {
            (least.min(*at), most.max(*at))
        });
        let mut parents = Self {
            file,
            of: file.nodes.iter().map(|node| node.parent.map(NodeId::index)).collect(),
            has_changed: false,
            at,
            size: (most - least).max_element(),
            skin: SharedSkin::new(file),
        };
        let is_node = |node: &NodeId| node.index() < file.nodes.len();
        let in_file = stated.iter().filter(|(node, parent)| is_node(node) && is_node(parent));
        for (node, parent) in in_file {
            parents.set(node.index(), parent.index());
        }
        if parents.size.is_finite() && parents.size > 0.0 {
            let stated: Vec<usize> = stated.keys().map(|node| node.index()).collect();
            parents.find(&stated);
        }
        parents
    }

    /// Gives a node a new parent, unless the new parent is a descendant.
    fn set(&mut self, node: usize, parent: usize) {
        if self.of[node] != Some(parent) && node != parent && !self.above(parent).any(|above| above == node) {
            self.of[node] = Some(parent);
            self.has_changed = true;
        }
    }

    fn above(&self, node: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(self.of[node], |above| self.of[*above])
    }

    fn is_within(&self, node: usize, above: usize) -> bool {
        node == above || self.above(node).any(|other| other == above)
    }

    fn find(&mut self, stated: &[usize]) {
        let weighted: Vec<usize> = self.skin.weighted().collect();
        if weighted.is_empty() {
            self.find_ends();
            return;
        }
        // A joint may follow another joint whose own parent is found later.
        for _ in 0..weighted.len() {
            let mut found = false;
            for &joint in weighted.iter().filter(|joint| !stated.contains(joint)) {
                let carrier = self.above(joint).find(|above| self.skin.has(*above));
                let top = carrier.is_none_or(|carrier| !self.above(carrier).any(|above| self.skin.has(above)));
                if !top || carrier.is_some_and(|carrier| self.skin.shared(joint, carrier) > 0.0) {
                    continue;
                }
                let limb: Vec<usize> = weighted
                    .iter()
                    .copied()
                    .filter(|node| self.is_within(*node, joint))
                    .collect();
                // A part with at least half of the joints is not a limb.
                let is_limb = 2 * limb.len() < weighted.len();
                if carrier.is_none() && self.follow_copies(&limb, &weighted) {
                    found = true;
                } else if let Some(parent) = self.neighbour(&limb, joint, carrier.is_none()).filter(|_| is_limb) {
                    self.set(joint, parent);
                    found = true;
                }
            }
            if !found {
                break;
            }
        }
    }

    /// Puts joints of the skin below coinciding joints without a skin that carry other joints of the skin.
    fn follow_copies(&mut self, limb: &[usize], weighted: &[usize]) -> bool {
        let mut found = false;
        for &joint in limb {
            let carries = |node: usize| {
                weighted
                    .iter()
                    .any(|other| !limb.contains(other) && self.is_within(*other, node))
            };
            let stands = |node: &usize| self.at[*node].distance(self.at[joint]) < SAME_PLACE * self.size;
            let mut copies = (0..self.of.len())
                .rev()
                .filter(|node| !self.skin.has(*node))
                .filter(stands);
            let copy = copies.find(|node| !self.is_within(joint, *node) && carries(*node));
            if let Some(copy) = copy {
                self.set(joint, copy);
                found = true;
            }
        }
        found
    }

    /// The joint that the top joint of a limb follows according to the skin. The whole limb then follows it.
    fn neighbour(&self, limb: &[usize], top: usize, may_be_apart: bool) -> Option<usize> {
        if !self.skin.shared_by(limb).is_empty() {
            let shared = self.skin.shared_by(&[top]);
            let others = shared.keys().copied().filter(|joint| !limb.contains(joint));
            let (far, near): (Vec<usize>, Vec<usize>) = others.partition(|joint| self.is_far(*joint, top));
            // A near joint counts only if it is an ancestor of a far joint. Any other near joint may itself be a joint
            // without a fitting parent.
            let near = near
                .iter()
                .filter(|near| far.iter().any(|far| self.is_within(*far, **near)));
            let of_near: f32 = near.map(|joint| shared[joint]).sum();
            let of_far: f32 = far.iter().map(|joint| shared[joint]).sum();
            let far = far.into_iter().map(|joint| (joint, shared[&joint]));
            return (of_near <= NEAR_PARENT * (of_near + of_far))
                .then(|| most(far))
                .flatten();
        }
        let parent = self.of[top].filter(|_| may_be_apart)?;
        if self.at[top].distance(self.at[parent]) < FAR_FROM_PARENT * self.size {
            return None;
        }
        let nearest = self.skin.nearest(self.file, limb, NEAR_SKIN * self.size);
        nearest.filter(|joint| self.is_far(*joint, top))
    }

    /// Whether a joint of the skin is far down another limb. This is so if another joint of the skin is between it and
    /// the common ancestor of both joints.
    fn is_far(&self, joint: usize, top: usize) -> bool {
        let above: Vec<usize> = self.above(top).collect();
        let mut path = self.above(joint).take_while(|node| !above.contains(node));
        !above.contains(&joint) && path.any(|node| self.skin.has(node))
    }

    /// Puts joints below the end of a limb at the same place.
    fn find_ends(&mut self) {
        let nodes = &self.file.nodes;
        let is_end = |node: &usize| {
            let name = nodes[*node].name.to_ascii_lowercase();
            let is_leaf = !nodes.iter().any(|other| other.parent == Some(NodeId::new(*node)));
            is_leaf && (nodes[*node].kind == NodeKind::EndSite || name.ends_with("_end"))
        };
        let ends: Vec<usize> = (0..nodes.len()).filter(is_end).collect();
        for joint in (0..nodes.len()).filter(|joint| nodes[*joint].kind == NodeKind::Joint && !is_end(joint)) {
            let is_here = |end: &&usize| {
                let is_near = self.at[**end].distance(self.at[joint]) < SAME_PLACE * self.size;
                is_near
                    && !self.is_within(**end, joint)
                    && self.of[**end].is_some_and(|limb| self.hangs_above(joint, limb))
            };
            if let Some(limb) = ends.iter().find(is_here).and_then(|end| self.of[*end]) {
                self.set(joint, limb);
            }
        }
    }

    /// Whether a joint is a child of the skeleton's root, far above a joint of another limb.
    fn hangs_above(&self, joint: usize, limb: usize) -> bool {
        let Some(parent) = self.of[joint] else { return false };
        let between = self.above(limb).position(|above| above == parent);
        let below = (0..self.of.len()).filter(|node| self.is_within(*node, parent)).count();
        2 * below > self.of.len() && between.is_some_and(|between| between > 1)
    }
}

/// The joint with the largest value.
fn most(joints: impl IntoIterator<Item = (usize, f32)>) -> Option<usize> {
    let best = joints
        .into_iter()
        .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
    best.map(|(joint, _)| joint)
}
