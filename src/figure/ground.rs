//! Finds the ground of a motion, for contacts, cleaning, pictures, retargeting, robots and surveys.
//!
//! Ankles, balls of the feet and toe tips each have a resting level in the motion. In each frame, the height of the
//! lower of the left and the right point counts. The level is the fifth percentile of these heights, without feet that
//! have sunk into the ground. A frame's weight is the distance that the feet move around it, so a long stance counts
//! about as much as a step. Frames that repeat the frame before have no weight. A rest pose from which the motion jumps
//! away also has no weight. The soles are at the lowest of these levels, or at the height that the skin shows. Most
//! files have a floor at height 0. So if the soles are near 0, the ground is at 0.

mod drift;
mod levels;

use glam::Vec3;
use mocap_scene::math::median::median;
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{NodeId, Scene, Side};

pub use self::drift::height_drift;
pub use self::levels::levels;
use self::levels::{Rests, stride};
use super::body::Body;
use super::contacts::points_of_feet;
use super::hierarchy::Hierarchy;
use crate::report::Guess;
use crate::{Confidence, Humanoid, HumanoidBone as Bone};

/// In a rest pose that stands on the ground, the largest distance of the lowest joint from the ground, as a fraction of
/// the leg.
const STANDS: f32 = 0.1;

/// The largest height of a motion's ankles above the ankles of a standing body, as a fraction of the leg. If the ankles
/// are higher, the body does not stand in this motion.
const HIGHEST: f32 = 0.2;

/// The largest height of the ankles in stance above the ankles of flat feet, as a fraction of the leg. In 153 clips the
/// height is up to 0.03. Runners on their toes have up to 0.09.
const FLAT: f32 = 0.05;

/// The height of the hips above the soles, as a fraction of the leg, below which a body lies, crawls or sits on the
/// ground. The hips of a crouching body are higher.
const UPRIGHT: f32 = 0.65;

/// The number of frames of an animation whose hips are examined.
const LOOKS: usize = 100;

/// Distances of the soles from height 0, as fractions of the leg. Up to the first distance, the soles stand on a floor
/// at 0. Beyond the second distance, the soles do not stand on a floor at 0. In clips of fifteen makers with a floor at
/// 0, the lowest joints of the feet rest at -0.065 to 0.065 of the leg. These joints are centres of joints, or markers
/// on shoes.
const ON_ZERO: [f32; 2] = [0.07, 0.17];

/// The height of an ankle over the sole as a fraction of the leg (Winter, "Biomechanics and motor control", 2009).
const ANKLE: f32 = 0.08;

/// The largest distance from the ankle to the end of a foot, as a fraction of the leg.
const FOOT: f32 = 0.6;

/// The evidence for the height of the soles.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Sole {
    Skin,
    Ends,
    Joints,
    Proportions,
}

/// The ground of a motion, along the up axis, in units of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// The resting level of the ankles. If the body has no feet, the resting level of the ends of the shins.
    pub ankles: Option<f32>,
    /// The resting level of the balls of the feet.
    pub balls: Option<f32>,
    /// The level of the soles, and its evidence.
    soles: (f32, Sole),
    /// The length of thigh plus shin; 0 if unknown.
    leg: f32,
}

impl Ground {
    /// The ground of all animations of a scene; `None` without a motion or without feet.
    pub(super) fn new(scene: &Scene, humanoid: &Humanoid, up: Vec3, metres: f32) -> Option<Self> {
        let points = FootPoints::new(scene, humanoid, up);
        let mut rests = Rests::default();
        let mut pose = Pose::rest(scene);
        for animation in &scene.animations {
            let binding = Binding::new(scene, animation);
            let mut tracks = points.nodes.each_ref().map(|nodes| vec![Vec::new(); nodes.len()]);
            let (frames, stride) = (animation.frame_count(), stride(animation.frame_count()));
            for frame in (0..frames).step_by(stride) {
                pose.sample(&binding, animation, frame as f64);
                for (nodes, tracks) in points.nodes.iter().zip(&mut tracks) {
                    for (node, track) in nodes.iter().zip(tracks) {
                        track.push(pose.position(*node));
                    }
                }
            }
            rests.add(&tracks, up, metres, animation.ticks_per_second / stride as f64);
        }
        points.ground(&rests.levels(metres))
    }

    /// The resting level of the lowest joints of the feet.
    pub fn joints(&self) -> f32 {
        let levels = [self.ankles, self.balls].into_iter().flatten();
        levels.reduce(f32::min).unwrap_or(self.soles.0)
    }

    /// The height of the floor, never above the joints that rest on it.
    pub fn height(&self) -> f32 {
        let [near, far] = ON_ZERO.map(|fraction| fraction * self.leg);
        let distance_of_zero = self.distance_of_zero();
        let part = match distance_of_zero < far {
            true => far / (far - near) * (1.0 - near / distance_of_zero).max(0.0),
            false => 1.0,
        };
        // Adding 0 turns -0 into 0.
        (part * self.soles.0).min(self.joints()) + 0.0
    }

    /// The distance of height 0 from the soles. When a foot pushes off, its toe tip is below the sole. So the sole is
    /// between the level of the toe tips and the level of the joints.
    fn distance_of_zero(&self) -> f32 {
        match self.soles {
            (soles, Sole::Ends) if soles < 0.0 => (-self.joints()).max(0.0),
            (soles, _) => soles.abs(),
        }
    }

    /// The height of the floor, with the reason.
    pub(super) fn guess(&self) -> Guess<f64> {
        let (soles, shown) = self.soles;
        let shown = match shown {
            Sole::Skin => "the skin of the soles",
            Sole::Ends => "the ends of the toes",
            Sole::Joints => "the lowest joints of the feet",
            Sole::Proportions => "the soles, at a person's distance below the ankles,",
        };
        let of_leg = soles / self.leg;
        let (confidence, words) = match self.distance_of_zero() <= ON_ZERO[0] * self.leg {
            true => (Confidence::Likely, "so the feet are on a floor at height 0"),
            false => (Confidence::Unsure, "so the feet are not on a floor at height 0"),
        };
        Guess {
            value: f64::from(self.height()),
            confidence,
            reason: format!("{shown} rest {of_leg:.2} of the leg length above height 0, {words}"),
        }
    }
}

/// The nodes that show the height of the ground.
pub struct FootPoints {
    /// Three lists of nodes: the ankles, the balls and the tips of the feet, each with the left and the right node.
    pub nodes: [Vec<NodeId>; 3],
    /// The distance from the ankles down to the skin of the soles, in the rest pose. `None` without a skin.
    skin: Option<f32>,
    /// The length of thigh plus shin.
    leg: f32,
}

impl FootPoints {
    /// The points of a figure with this up direction.
    pub fn new(scene: &Scene, humanoid: &Humanoid, up: Vec3) -> Self {
        let rest = Pose::rest(scene);
        let [ankles, balls] = points_of_feet(scene, humanoid)
            .map(|points| -> Vec<NodeId> { points.into_iter().map(|(_, node)| node).collect() });
        let leg = leg(&rest, humanoid);
        let hierarchy = Hierarchy::new(scene);
        let foot_of = |node: NodeId| {
            let above = |node: &NodeId| scene.nodes[node.index()].parent;
            std::iter::successors(Some(node), above).find(|node| ankles.contains(node))
        };
        let is_end = |node: &NodeId| {
            let ankle = foot_of(*node).filter(|ankle| ankle != node && !balls.contains(node));
            let is_near = |ankle| rest.position(*node).distance(rest.position(ankle)) < FOOT * leg;
            ankle.is_some_and(is_near) && hierarchy.first_child(*node).is_none()
        };
        let ends = (0..scene.nodes.len()).map(NodeId::new).filter(is_end).collect();
        let skin = skin(scene, &rest, &ankles, up, &foot_of).filter(|below| (0.0..FOOT * leg).contains(below));
        let shins = || ends_of_shins(&hierarchy, humanoid);
        Self {
            nodes: [if ankles.is_empty() { shins() } else { ankles }, balls, ends],
            skin,
            leg,
        }
    }

    /// The ground for points with these [`levels`].
    pub fn ground(&self, levels: &[Option<f32>]) -> Option<Ground> {
        let level = |kind: usize| levels.get(kind).copied().flatten();
        let (ankles, balls, ends) = (level(0), level(1), level(2));
        let joints = [ankles, balls].into_iter().flatten().reduce(f32::min)?;
        let soles = match (self.skin.zip(ankles), ends, balls) {
            (Some((below, ankles)), ..) => (ankles - below, Sole::Skin),
            (_, Some(ends), _) => (ends.min(joints), Sole::Ends),
            (_, _, Some(_)) => (joints, Sole::Joints),
            _ => (joints - ANKLE * self.leg, Sole::Proportions),
        };
        let leg = self.leg;
        Some(Ground {
            ankles,
            balls,
            soles,
            leg,
        })
    }
}

/// The length of thigh plus shin in the rest pose.
fn leg(rest: &Pose, humanoid: &Humanoid) -> f32 {
    let length = |side: Side| {
        let at = |bone: Bone| Some(rest.position(humanoid.joint(bone.on(side))?));
        let knee = at(Bone::LeftLowerLeg)?;
        Some(knee.distance(at(Bone::LeftUpperLeg)?) + knee.distance(at(Bone::LeftFoot)?))
    };
    Side::ALL
        .into_iter()
        .find_map(length)
        .filter(|leg| leg.is_finite())
        .unwrap_or(0.0)
}

/// The distance from the ankle down to the lowest vertex of the foot, in the rest pose.
fn skin(
    scene: &Scene,
    rest: &Pose,
    ankles: &[NodeId],
    up: Vec3,
    foot_of: &impl Fn(NodeId) -> Option<NodeId>,
) -> Option<f32> {
    let mut lowest: Option<f32> = None;
    let height = |node: NodeId| rest.position(node).dot(up);
    let ankle = ankles.iter().map(|ankle| height(*ankle)).reduce(f32::min)?;
    for mesh in scene.own_meshes() {
        for bone in mesh.bones.iter().filter(|bone| foot_of(bone.node).is_some()) {
            let to_world = rest.node_to_world[bone.node.index()] * bone.offset_matrix;
            let of_bone = bone.weights.iter().filter(|weight| weight.weight > 0.5);
            let vertices = of_bone.filter_map(|weight| mesh.vertices.get(weight.vertex_id as usize));
            let heights = vertices.map(|vertex| to_world.transform_point3(*vertex).dot(up));
            lowest = heights.chain(lowest).reduce(f32::min);
        }
    }
    lowest.map(|lowest| ankle - lowest)
}

/// The ends of the shins of a body without feet.
fn ends_of_shins(hierarchy: &Hierarchy, humanoid: &Humanoid) -> Vec<NodeId> {
    let shins = [Bone::LeftLowerLeg, Bone::RightLowerLeg].into_iter();
    shins
        .filter_map(|bone| hierarchy.only_child(humanoid.joint(bone)?))
        .collect()
}

/// The height of the ankles above the origin when the body stands. It comes from the animations, or otherwise from the
/// rest pose.
pub fn of_motion(body: &Body, scene: &Scene) -> f32 {
    shown_by_motion(body, scene)
        .or_else(|| of_rest(body))
        .unwrap_or_else(|| of_skeleton(body))
}

/// The height of the ankles in a scene's animations, if the body stands in them. A body that lies or crawls may rest on
/// its toes, with the ankles far above the ground. The soles are then at the height of the toes.
fn shown_by_motion(body: &Body, scene: &Scene) -> Option<f32> {
    let ground = body.figure.ground_of(scene)?;
    let usual = of_skeleton(body);
    let soles = ground.height().max(ground.soles.0);
    let level = ground.ankles?;
    let is_on_toes = level - soles > usual.max(ANKLE * body.leg) + FLAT * body.leg;
    let level = match is_on_toes && hips(body, scene).is_some_and(|hips| hips - soles < UPRIGHT * body.leg) {
        true => soles + usual,
        false => level,
    };
    Some(level).filter(|height| *height < usual + HIGHEST * body.leg)
}

/// The median height of the hips in the animations of a scene.
fn hips(body: &Body, scene: &Scene) -> Option<f32> {
    let mut pose = Pose::rest(scene);
    let mut heights = Vec::new();
    for animation in &scene.animations {
        let binding = Binding::new(scene, animation);
        let frames = animation.frame_count();
        for frame in (0..frames).step_by(frames.div_ceil(LOOKS).max(1)) {
            pose.sample(&binding, animation, frame as f64);
            heights.push(pose.position(body.hips).dot(body.up()));
        }
    }
    median(&mut heights)
}

/// The height of the ankles above the origin when the body stands. It comes from a rest pose that stands on the ground,
/// or otherwise from the animations. If nothing shows the soles, the distance from the lowest joints of the feet to the
/// soles comes from the body `other` in its motion. This distance is multiplied by `scale`, the ratio of the sizes of
/// both bodies.
pub fn of_character((body, scene): (&Body, &Scene), (other, motion): (&Body, &Scene), scale: f32) -> f32 {
    let soles = || {
        let floor = other.figure.ground_of(motion).map_or(0.0, Ground::height);
        scale * (of_motion(other, motion) - floor - of_skeleton(other)).max(0.0)
    };
    of_rest(body)
        .or_else(|| shown_by_motion(body, scene))
        .unwrap_or_else(|| of_skeleton(body) + soles())
}

/// Both ankles. If the body has no feet, the ends of the shins.
fn ankles(body: &Body) -> Vec<NodeId> {
    let feet = [Bone::LeftFoot, Bone::RightFoot]
        .into_iter()
        .filter_map(|bone| body.joint(bone));
    let mut feet: Vec<_> = feet.collect();
    if feet.is_empty() {
        let shins = [Bone::LeftLowerLeg, Bone::RightLowerLeg].into_iter();
        feet.extend(shins.filter_map(|bone| body.next(bone, body.joint(bone)?)));
    }
    feet
}

fn height(body: &Body, node: NodeId) -> f32 {
    body.position(node).dot(body.up())
}

fn lowest_ankle(body: &Body) -> Option<f32> {
    ankles(body)
        .into_iter()
        .map(|ankle| height(body, ankle))
        .reduce(f32::min)
}

/// The lowest joint of the feet in the reference pose.
fn lowest(body: &Body) -> Option<f32> {
    let ankles = ankles(body);
    let is_of_foot = |node: &NodeId| {
        ankles
            .iter()
            .any(|ankle| node == ankle || body.depends_on(*node, *ankle))
    };
    let nodes = (0..body.hierarchy.parents.len()).map(NodeId::new).filter(is_of_foot);
    nodes.map(|node| height(body, node)).reduce(f32::min)
}

/// The height of the ankle above the lowest joint of the foot.
pub(crate) fn of_skeleton(body: &Body) -> f32 {
    match (lowest_ankle(body), lowest(body)) {
        (Some(ankle), Some(lowest)) => ankle - lowest,
        _ => 0.0,
    }
}

/// The height of the floor in the reference pose. If the pose stands on the ground, this is the height of the ground,
/// and otherwise of the lowest joint.
pub fn floor(body: &Body) -> f32 {
    match of_rest(body) {
        Some(_) => 0.0,
        None => lowest(body).unwrap_or(0.0),
    }
}

/// The height of the lower ankle above the floor of the reference pose.
pub fn ankle(body: &Body) -> f32 {
    lowest_ankle(body).map_or(0.0, |ankle| ankle - floor(body))
}

/// The height of the ankles above the origin in the rest pose, if the rest pose stands on the ground.
fn of_rest(body: &Body) -> Option<f32> {
    let stands = lowest(body)?.abs() < STANDS * body.leg;
    lowest_ankle(body).filter(|_| stands)
}
