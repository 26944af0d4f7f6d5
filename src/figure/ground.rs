//! Where the ground is: the one definition, for contacts, pictures, retargeting and robots.
//!
//! The ankles have a level on which they rest in the motion, and so have the balls of the feet: the fifth percentile of
//! the height of the lower one. The ground is the lower of both levels. A body without a motion stands on the lowest
//! joint of its feet, or at height 0 where that is near.

use glam::Vec3;
use mocap_scene::math::median::percentile;
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{NodeId, Scene};

use super::body::Body;
use super::contacts::points_of_feet;
use super::hierarchy::Hierarchy;
use crate::{Humanoid, HumanoidBone as Bone};

/// Frames of an animation that are examined at most, evenly spaced.
const FRAMES: usize = 600;

/// The fraction of frames in which the lower foot is below its level of rest: a twentieth. The minimum would be that of
/// a rest pose in the first frame, in which CMU's files have the hips at the origin and the feet far below.
const BELOW: f64 = 0.05;

/// How far from the ground the lowest joint of a rest pose may be that stands on it, as a fraction of the leg.
const STANDS: f32 = 0.1;

/// How much higher than those of a standing body the ankles of a motion may be, as a fraction of the leg. If they are
/// still higher, the body does not stand in this motion.
const HIGHEST: f32 = 0.2;

/// The ground of a motion: the levels on which the feet rest, along the up axis, in units of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// The level of the ankles; of the ends of the shins where there are no feet.
    ankles: Option<f32>,
    /// The level of the balls of the feet.
    balls: Option<f32>,
}

impl Ground {
    /// The ground of all animations of a scene; `None` without a motion or without feet.
    pub(super) fn new(scene: &Scene, humanoid: &Humanoid, up: Vec3) -> Option<Self> {
        let [ankles, balls] = points_of_feet(scene, humanoid);
        let nodes = |points: &[(Bone, NodeId)]| points.iter().map(|(_, node)| *node).collect::<Vec<_>>();
        let mut feet = [nodes(&ankles), nodes(&balls)];
        if feet[0].is_empty() {
            feet[0] = ends_of_shins(scene, humanoid);
        }
        let mut heights = [Vec::new(), Vec::new()];
        let mut pose = Pose::rest(scene);
        for animation in &scene.animations {
            let binding = Binding::new(scene, animation);
            for frame in examined(animation.frame_count()) {
                pose.sample(&binding, animation, frame as f64);
                for (nodes, heights) in feet.iter().zip(&mut heights) {
                    heights.extend(nodes.iter().map(|node| pose.position(*node).dot(up)).reduce(f32::min));
                }
            }
        }
        let [ankles, balls] =
            heights.map(|heights| percentile(heights, BELOW, f64::floor).filter(|level| level.is_finite()));
        (ankles.is_some() || balls.is_some()).then_some(Self { ankles, balls })
    }

    /// The height of the ground.
    pub fn height(&self) -> f32 {
        let levels = [self.ankles, self.balls].into_iter().flatten();
        levels.reduce(f32::min).unwrap_or(0.0)
    }
}

/// The ends of the shins of a body without feet.
fn ends_of_shins(scene: &Scene, humanoid: &Humanoid) -> Vec<NodeId> {
    let hierarchy = Hierarchy::new(scene);
    let shins = [Bone::LeftLowerLeg, Bone::RightLowerLeg].into_iter();
    shins
        .filter_map(|bone| hierarchy.only_child(humanoid.joint(bone)?))
        .collect()
}

/// The level on which the lowest of several points rests. `heights` has those of all points, frame by frame.
pub fn level(heights: &[f32], points: usize) -> f32 {
    let rows: Vec<&[f32]> = heights.chunks(points.max(1)).collect();
    let lowest = |frame: usize| rows[frame].iter().copied().fold(f32::INFINITY, f32::min);
    percentile(examined(rows.len()).map(lowest), BELOW, f64::floor).unwrap_or(0.0)
}

/// The frames that are examined of so many.
fn examined(frames: usize) -> impl Iterator<Item = usize> {
    (0..frames).step_by(frames.div_ceil(FRAMES).max(1))
}

/// The height of the ankles over the origin when the body stands: in its animations, else in its rest pose.
pub fn of_motion(body: &Body, scene: &Scene) -> f32 {
    let usual = of_skeleton(body);
    let level = body.figure.ground_of(scene).and_then(|ground| ground.ankles);
    let moving = level.filter(|height| *height < usual + HIGHEST * body.leg);
    moving.unwrap_or_else(|| of_rest(body).unwrap_or(usual))
}

/// The height of the ankles over the origin when the body stands: in its rest pose if that stands on the ground, else
/// in its animations.
pub fn of_character(body: &Body, scene: &Scene) -> f32 {
    of_rest(body).unwrap_or_else(|| of_motion(body, scene))
}

/// Both ankles; the ends of the shins where there are no feet.
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

/// From the lowest joint of the foot to the ankle.
pub(crate) fn of_skeleton(body: &Body) -> f32 {
    match (lowest_ankle(body), lowest(body)) {
        (Some(ankle), Some(lowest)) => ankle - lowest,
        _ => 0.0,
    }
}

/// The height of the floor in the reference pose: the ground on which it stands, else its lowest joint.
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

/// The height of the ankles over the origin in the rest pose, if that stands on the ground.
fn of_rest(body: &Body) -> Option<f32> {
    let stands = lowest(body)?.abs() < STANDS * body.leg;
    lowest_ankle(body).filter(|_| stands)
}
