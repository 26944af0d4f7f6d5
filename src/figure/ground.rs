//! How high the ankles of a standing body are.

use super::body::Body;
use crate::figure::HumanoidBone as Bone;
use crate::pose::{Binding, Pose};
use crate::scene::{NodeId, Scene};

/// Frames of an animation that are examined at most.
const FRAMES: usize = 600;

/// How far from the ground the lowest joint of a rest pose may be that stands on it, as a share of the leg.
const STANDS: f32 = 0.1;

/// How much higher than those of a standing body the ankles of a motion may be, as a share of the leg. If they are
/// still higher, the body does not stand in this motion.
const HIGHEST: f32 = 0.2;

/// The height of the ankles over the origin when the body stands: in its animations, else in its rest pose.
pub(crate) fn of_motion(body: &Body, scene: &Scene) -> f32 {
    let usual = of_skeleton(body);
    let moving = animated(body, scene).filter(|height| *height < usual + HIGHEST * body.leg);
    moving.unwrap_or_else(|| of_rest(body).unwrap_or(usual))
}

/// The height of the ankles over the origin when the body stands: in its rest pose if that stands on the ground, else
/// in its animations.
pub(crate) fn of_character(body: &Body, scene: &Scene) -> f32 {
    of_rest(body).unwrap_or_else(|| of_motion(body, scene))
}

/// Both ankles; the ends of the shins where there are no feet.
pub(crate) fn ankles(body: &Body) -> Vec<NodeId> {
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
pub(crate) fn floor(body: &Body) -> f32 {
    match of_rest(body) {
        Some(_) => 0.0,
        None => lowest(body).unwrap_or(0.0),
    }
}

/// The height of the lower ankle above the floor of the reference pose.
pub(crate) fn ankle(body: &Body) -> f32 {
    lowest_ankle(body).map_or(0.0, |ankle| ankle - floor(body))
}

/// The height of the ankles over the origin in the rest pose, if that stands on the ground.
pub(crate) fn of_rest(body: &Body) -> Option<f32> {
    let stands = lowest(body)?.abs() < STANDS * body.leg;
    lowest_ankle(body).filter(|_| stands)
}

/// The fifth percentile of the lower ankle: the minimum would be that of a rest pose in the first frame, which hangs
/// below the ground in some files.
fn animated(body: &Body, scene: &Scene) -> Option<f32> {
    let ankles = ankles(body);
    let mut heights = Vec::new();
    let mut pose = Pose::rest(scene);
    for animation in &scene.animations {
        let binding = Binding::new(scene, animation);
        let frames = animation.frame_count();
        let step = frames.div_ceil(FRAMES).max(1);
        for frame in (0..frames).step_by(step) {
            pose.sample(&binding, animation, frame as f64);
            let places = ankles.iter().map(|ankle| pose.position(*ankle).dot(body.up()));
            heights.extend(places.reduce(f32::min));
        }
    }
    heights.sort_by(f32::total_cmp);
    heights
        .get(heights.len().saturating_sub(1) / 20)
        .copied()
        .filter(|height| height.is_finite())
}
