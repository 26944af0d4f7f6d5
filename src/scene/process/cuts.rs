//! Finds discontinuities in a motion: a rest pose as the first frame, or two takes in one file.

use std::collections::HashMap;

use glam::Vec3;

use crate::pose::{Binding, Pose, Trs};
use crate::scene::{Animation, NodeId, NodeKind, Scene};

/// The smallest movement of a node in a cut, from one frame to the next, as a fraction of the skeleton's size.
const SHARE_OF_SIZE: f32 = 0.05;

/// The smallest movement of a node in a cut, as a multiple of its usual movement per frame around that time.
const TIMES_THE_USUAL: f32 = 5.0;

/// The number of frames on each side that define the usual movement. One frame is not enough: a marker that slips for
/// one frame jumps away and back, and both jumps would count as usual.
const NEIGHBOURS: usize = 4;

/// The rotation in radians below which a joint is in its rest pose: 2 degrees. Compression within a millimetre rotates
/// a finger by that much.
const RESTING: f32 = 0.035;

/// The smallest fraction of joints at rest in a rest pose. CMU's rest pose has the legs a little apart.
const RESTING_SHARE: f32 = 0.75;

impl Scene {
    /// The frames after which `animation` (an index into [`Scene::animations`]) has a cut, in order.
    ///
    /// In a cut, a node moves far within one frame, compared with the skeleton's size and with the frames around it.
    /// Fast motion does not count, because the frames before and after it are fast too.
    pub fn cuts(&self, animation: usize) -> Vec<usize> {
        let frames = self.animations.get(animation).map_or(0, Animation::frame_count);
        let (steps, size) = steps(self, animation, frames);
        (0..steps.len()).filter(|&frame| is_cut(&steps, frame, size)).collect()
    }
}

/// Whether the first frame of an animation is a rest pose with a cut after it. The BVH conversions of the CMU database,
/// for example, have "a T-pose added as its new first frame".
#[doc(hidden)]
pub fn first_frame_is_rest_pose(scene: &Scene, index: usize) -> bool {
    let Some(animation) = scene.animations.get(index) else {
        return false;
    };
    let (steps, size) = steps(scene, index, animation.frame_count().min(NEIGHBOURS + 2));
    let driven: HashMap<NodeId, usize> = Binding::new(scene, animation).driven().collect();
    let (mut joints, mut resting) = (0, 0);
    for (index, node) in scene.nodes.iter().enumerate() {
        let channel = driven.get(&NodeId::new(index));
        if node.kind != NodeKind::Joint && channel.is_none() {
            continue;
        }
        // A joint without a channel is always at rest.
        let first = channel.and_then(|channel| animation.channels[*channel].rotation_keys.values.first());
        let rest = Trs::from_matrix(node.transform).rotation;
        joints += 1;
        resting += usize::from(first.is_none_or(|first| first.angle_between(rest) < RESTING));
    }
    !steps.is_empty() && is_cut(&steps, 0, size) && resting as f32 >= RESTING_SHARE * joints as f32
}

/// The largest distance that any node moves from each of the first `frames` frames to the next, and the largest extent
/// of the skeleton.
fn steps(scene: &Scene, animation: usize, frames: usize) -> (Vec<f32>, f32) {
    let Some(animation) = scene.animations.get(animation) else {
        return (Vec::new(), 0.0);
    };
    let binding = Binding::new(scene, animation);
    let (mut before, mut now) = (Pose::rest(scene), Pose::rest(scene));
    now.sample(&binding, animation, 0.0);
    let mut size = extent(scene, &now);
    let mut steps = Vec::with_capacity(frames);
    for frame in 1..frames {
        std::mem::swap(&mut before, &mut now);
        now.sample(&binding, animation, frame as f64);
        let nodes = (0..scene.nodes.len()).map(NodeId::new);
        steps.push(
            nodes
                .map(|node| before.position(node).distance(now.position(node)))
                .fold(0.0, f32::max),
        );
        size = size.max(extent(scene, &now));
    }
    (steps, size)
}

fn is_cut(steps: &[f32], frame: usize, size: f32) -> bool {
    let around = frame.saturating_sub(NEIGHBOURS)..steps.len().min(frame + NEIGHBOURS + 1);
    let usual = around
        .filter(|&other| other != frame)
        .map(|other| steps[other])
        .reduce(f32::max);
    // A motion of two frames has no usual movement.
    let Some(usual) = usual else { return false };
    steps[frame] > SHARE_OF_SIZE * size && steps[frame] > TIMES_THE_USUAL * usual
}

/// The largest extent of a pose along an axis.
fn extent(scene: &Scene, pose: &Pose) -> f32 {
    let positions = || (0..scene.nodes.len()).map(|index| pose.position(NodeId::new(index)));
    match (positions().reduce(Vec3::min), positions().reduce(Vec3::max)) {
        (Some(min), Some(max)) => (max - min).max_element(),
        _ => 0.0,
    }
}
