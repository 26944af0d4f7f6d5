//! A clip to draw: its joint positions at a tick, its size, and its up axis.

use std::cell::OnceCell;

use glam::{Quat, Vec3};
use mocap_figure::ground::Ground;
use mocap_figure::names::Name;
use mocap_figure::{Figure, Humanoid, HumanoidBone};
use mocap_scene::math::up_axis::turn_to_y_up;
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{Animation, Mesh, NodeId, NodeKind, Primitive, Scene};
use serde::Serialize;

use super::texture::Images;

/// A scene and its name in a picture.
///
/// [`Drawing::sheet`](crate::Drawing::sheet) has an example.
#[derive(Clone, Copy, Debug)]
pub struct Clip<'a> {
    /// A short name, such as the file's.
    pub name: &'a str,
    /// The scene. Its first animation is drawn.
    pub scene: &'a Scene,
}

impl<'a> Clip<'a> {
    /// A scene with a name.
    pub fn new(name: &'a str, scene: &'a Scene) -> Self {
        Self { name, scene }
    }

    /// The drawn animation. Without one, a picture shows the rest pose.
    pub fn animation(&self) -> Option<&'a Animation> {
        self.scene.animations.first()
    }

    /// The length in seconds; 0 without an animation.
    pub fn seconds(&self) -> f64 {
        self.animation()
            .map_or(0.0, |animation| animation.duration / animation.ticks_per_second)
    }

    /// The number of frames; 0 without an animation.
    pub fn frames(&self) -> u64 {
        self.animation()
            .map_or(0, |animation| (animation.duration as u64).saturating_add(1))
    }

    /// A summary in one line, such as `2.9 s, 344 frames at 120 fps, 31 joints`.
    pub fn facts(&self) -> String {
        let joints = self
            .scene
            .nodes
            .iter()
            .filter(|node| node.kind == NodeKind::Joint)
            .count();
        let plural = |count: u64, one: &str| format!("{count} {one}{}", if count == 1 { "" } else { "s" });
        let joints = plural(joints as u64, "joint");
        match self.animation() {
            None => format!("no motion, {joints}"),
            Some(animation) => format!(
                "{} s, {} at {} fps, {joints}",
                short(self.seconds()),
                plural(self.frames(), "frame"),
                short(animation.ticks_per_second)
            ),
        }
    }
}

/// A number with at most two decimals, without trailing zeros.
pub fn short(number: f64) -> String {
    let text = format!("{number:.2}");
    match text.trim_end_matches('0').trim_end_matches('.') {
        "-0" => "0".to_owned(),
        short => short.to_owned(),
    }
}

/// The side of the body that a joint belongs to, from its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[doc(hidden)]
pub enum Side {
    Left,
    Right,
    Middle,
}

impl From<mocap_figure::Side> for Side {
    fn from(side: mocap_figure::Side) -> Self {
        match side {
            mocap_figure::Side::Left => Self::Left,
            mocap_figure::Side::Right => Self::Right,
        }
    }
}

impl Side {
    /// The side in the name of a joint, such as `LeftArm`, `lThigh`, `hand_L`, `L_Foot`, `mixamorig:RightHand` or
    /// `rtibia`.
    pub fn of(name: &str) -> Self {
        Name::read(name).side.map_or(Self::Middle, Self::from)
    }
}

/// A bone to draw: a node and one of its children.
pub struct Link {
    pub(super) from: usize,
    pub(super) to: usize,
    pub(super) side: Side,
}

/// A clip that is prepared for drawing: bound to its animation, measured, and rotated to +Y up.
pub struct DrawnClip<'a> {
    pub(super) clip: Clip<'a>,
    pub(super) links: Vec<Link>,
    /// Joints without links, such as markers.
    pub(super) lone: Vec<usize>,
    is_shown: Vec<bool>,
    /// The largest distance of a joint from the root: about half of a person's height.
    pub(super) reach: f32,
    /// The height of the ground. For a scene without a humanoid, the lowest joint height of the whole clip.
    pub(super) floor: f32,
    /// Metres per unit of the scene.
    pub(super) metres: f32,
    /// The joint that the camera follows: the hips, or the topmost drawn joint with a moving position.
    pub root: usize,
    /// The left and the right thigh.
    thighs: Option<(NodeId, NodeId)>,
    /// The first tick of the motion, after a rest pose.
    pub(super) first_tick: f64,
    to_stage: Quat,
    binding: Option<Binding>,
    pose: Pose,
    images: OnceCell<Images>,
}

impl<'a> DrawnClip<'a> {
    /// Finds the humanoid in a clip and prepares to draw it.
    pub fn new(clip: Clip<'a>) -> Self {
        Self::of_figure(clip, &Figure::new(clip.scene))
    }

    /// Prepares a clip with a known figure.
    pub(super) fn of_figure(clip: Clip<'a>, known: &Figure) -> Self {
        let scene = clip.scene;
        let links = links(scene, &known.humanoid);
        let is_shown = shown(scene, &known.humanoid, &links);
        let mut is_lone = is_shown.clone();
        for link in &links {
            (is_lone[link.from], is_lone[link.to]) = (false, false);
        }
        // A joint above the hips may stand still, so the camera follows the hips.
        let hips = known.humanoid.joint(HumanoidBone::Hips);
        let moves = |node: &usize| {
            let channels = clip.animation().map_or(&[][..], |animation| &animation.channels);
            let channel = channels
                .iter()
                .find(|channel| channel.node_name == scene.nodes[*node].name);
            channel.is_some_and(|channel| channel.position_keys.values.len() > 1)
        };
        let first = || {
            let is_joint = |node: &usize| scene.nodes[*node].kind == NodeKind::Joint && is_shown[*node];
            let mut joints = (0..scene.nodes.len()).filter(is_joint);
            let topmost = joints.clone().next();
            joints.find(moves).or(topmost).unwrap_or(0)
        };
        let thigh = |bone| known.humanoid.joint(bone);
        let mut figure = Self {
            clip,
            root: hips.map_or_else(first, NodeId::index),
            thighs: thigh(HumanoidBone::LeftUpperLeg).zip(thigh(HumanoidBone::RightUpperLeg)),
            lone: (0..scene.nodes.len()).filter(|&node| is_lone[node]).collect(),
            links,
            is_shown,
            reach: 0.0,
            floor: f32::INFINITY,
            metres: known.metres(),
            first_tick: f64::from(u8::from(known.survey.first_frame_is_rest_pose)),
            to_stage: turn_to_y_up(known.survey.up.value).as_quat(),
            binding: clip.animation().map(|animation| Binding::new(scene, animation)),
            pose: Pose::rest(scene),
            images: OnceCell::new(),
        };
        figure.measure();
        // A figure with the up axis X is drawn as if the up axis were Y.
        let ground = known.up.value.up().and_then(|_| known.ground_of(scene));
        figure.floor = ground.map_or(figure.floor, Ground::height);
        figure
    }

    /// The textures of the skin, decoded at first use.
    pub(super) fn images(&self) -> &Images {
        self.images.get_or_init(|| Images::of(self.clip.scene))
    }

    /// The positions of the drawn nodes.
    pub(super) fn shown(&self, positions: &[Vec3]) -> impl Iterator<Item = Vec3> {
        let all = positions.iter().zip(&self.is_shown);
        all.filter(|(_, is_shown)| **is_shown).map(|(position, _)| *position)
    }

    /// Measures a few dozen poses, which are enough for the size of a clip.
    fn measure(&mut self) {
        for tick in self.ticks(48) {
            let positions = self.positions(tick);
            let root = positions.get(self.root).copied().unwrap_or_default();
            let shown: Vec<Vec3> = self.shown(&positions).collect();
            for position in shown {
                self.floor = self.floor.min(position.y);
                self.reach = self.reach.max(position.distance(root));
            }
        }
        if !(self.reach > 0.0 && self.floor.is_finite()) {
            (self.reach, self.floor) = (1.0, 0.0);
        }
    }

    /// `count` ticks of the motion from the first to the last, evenly spaced. Fewer if the motion has fewer frames.
    pub(super) fn ticks(&self, count: usize) -> Vec<f64> {
        let end = self.clip.animation().map_or(0.0, |animation| animation.duration);
        let duration = (end - self.first_tick).max(0.0);
        let count = count.min(duration as usize + 1);
        let last = count.saturating_sub(1).max(1) as f64;
        (0..count)
            .map(|index| self.first_tick + (duration * index as f64 / last).round())
            .collect()
    }

    /// The positions of all nodes at `tick`, with +Y up, in the file's unit.
    pub(super) fn positions(&mut self, tick: f64) -> Vec<Vec3> {
        if let (Some(binding), Some(animation)) = (&self.binding, self.clip.animation()) {
            self.pose.sample(binding, animation, tick);
        }
        (0..self.clip.scene.nodes.len())
            .map(|node| self.to_stage * self.pose.position(NodeId::new(node)))
            .collect()
    }

    /// Rotates a point of the file to +Y up.
    pub(super) fn on_stage(&self, point: Vec3) -> Vec3 {
        self.to_stage * point
    }

    /// The skin meshes with their vertices in the last pose, with +Y up.
    pub(super) fn skins(&self) -> impl Iterator<Item = (&Mesh, Vec<Vec3>)> {
        skin_meshes(self.clip.scene).map(|mesh| {
            let vertices = self.pose.skin(mesh).into_iter();
            (mesh, vertices.map(|vertex| self.on_stage(vertex)).collect())
        })
    }

    /// The facing of a figure with two legs in these poses, as an angle about +Y from +Z. The angle is 0 if the figure
    /// has no main facing.
    pub(super) fn heading<'p>(&self, poses: impl Iterator<Item = &'p [Vec3]>) -> f32 {
        /// If the mean of unit vectors is longer than this, the vectors have a main direction.
        const TOGETHER: f32 = 0.5;
        let Some((left, right)) = self.thighs else { return 0.0 };
        let (mut sum, mut count) = (Vec3::ZERO, 0.0);
        for positions in poses {
            let across = (positions[left.index()] - positions[right.index()]).with_y(0.0);
            sum += across.cross(Vec3::Y).normalize_or_zero();
            count += 1.0;
        }
        if sum.length() > TOGETHER * count {
            sum.x.atan2(sum.z)
        } else {
            0.0
        }
    }

    /// The position of the root joint.
    pub(super) fn root(&self, positions: &[Vec3]) -> Vec3 {
        positions.get(self.root).copied().unwrap_or_default()
    }

    /// The projection of a point on the floor.
    pub(super) fn ground_below(&self, point: Vec3) -> Vec3 {
        Vec3::new(point.x, self.floor, point.z)
    }
}

/// Whether each node belongs to the figure: the humanoid bones and their descendants, or else every drawn node.
pub(super) fn body(scene: &Scene, humanoid: &Humanoid) -> Vec<bool> {
    if humanoid.bones.is_empty() {
        return scene.nodes.iter().map(|node| node.kind != NodeKind::Group).collect();
    }
    let mut in_body = vec![false; scene.nodes.len()];
    for joint in humanoid.bones.values() {
        in_body[joint.joint.index()] = true;
    }
    for (index, node) in scene.nodes.iter().enumerate() {
        in_body[index] |= node.parent.is_some_and(|parent| in_body[parent.index()]);
    }
    in_body
}

/// The links from nodes to their parents. Group nodes have no link. A static node has no link to a figure that moves
/// away from it.
pub fn links(scene: &Scene, humanoid: &Humanoid) -> Vec<Link> {
    let leaves = leaves_a_still_node(scene, humanoid);
    let nodes = scene.nodes.iter().enumerate();
    let links = nodes.filter_map(|(to, node)| {
        let from = node.parent?.index();
        let parent = &scene.nodes[from];
        (parent.kind != NodeKind::Group && Some(to) != leaves).then(|| Link {
            from,
            to,
            side: Side::of(if node.kind == NodeKind::EndSite {
                &parent.name
            } else {
                &node.name
            }),
        })
    });
    links.collect()
}

/// The skin meshes of a scene, without meshes that draw a skeleton.
pub(super) fn skin_meshes(scene: &Scene) -> impl Iterator<Item = &Mesh> {
    let is_skin = |mesh: &&Mesh| mesh.primitive == Primitive::Triangles && !mesh.bones.is_empty();
    scene.own_meshes().filter(is_skin)
}

/// Whether each node is drawn: not group nodes, and not static ancestors that the figure moves away from.
pub fn shown(scene: &Scene, humanoid: &Humanoid, links: &[Link]) -> Vec<bool> {
    let mut is_shown: Vec<bool> = scene.nodes.iter().map(|node| node.kind != NodeKind::Group).collect();
    let mut above = leaves_a_still_node(scene, humanoid).and_then(|node| scene.nodes[node].parent);
    while let Some(node) = above {
        let index = node.index();
        // The lowest static ancestor has no link, unless it has another child.
        is_shown[index] &= links.iter().any(|link| link.from == index);
        above = scene.nodes[index].parent;
    }
    is_shown
}

/// The hips, or an ancestor of the hips, that moves although all its ancestors are static.
fn leaves_a_still_node(scene: &Scene, humanoid: &Humanoid) -> Option<usize> {
    let animation = scene.animations.first()?;
    let (mut moves, mut is_still) = (vec![false; scene.nodes.len()], vec![true; scene.nodes.len()]);
    for (node, channel) in Binding::new(scene, animation).driven() {
        let channel = &animation.channels[channel];
        moves[node.index()] = channel.position_keys.len() > 1;
        is_still[node.index()] =
            !moves[node.index()] && channel.rotation_keys.len() <= 1 && channel.scaling_keys.len() <= 1;
    }
    // The nodes from the root to the first moving node.
    let mut chain = vec![humanoid.joint(HumanoidBone::Hips)?];
    while let Some(parent) = scene.nodes[chain[chain.len() - 1].index()].parent {
        chain.push(parent);
    }
    let first = chain.iter().rev().find(|node| !is_still[node.index()])?.index();
    moves[first].then_some(first)
}
