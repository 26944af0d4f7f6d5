//! Defines when a foot or a hand is in contact with the ground, for all commands.

use mocap_scene::scene::{HumanoidBone as Bone, NodeId, Scene, Side};

use super::humanoid::Humanoid;

/// The thresholds of a contact. A contact starts when a point's height is at most `height` and its speed at most
/// `speed`. It ends when the height or the speed is above `release` times this threshold. Heights are relative to the
/// point's own resting level, because an ankle rests higher above the floor than a toe.
#[derive(Clone, Copy, Debug)]
pub struct ContactRule {
    /// The largest height of a point at the start of a contact, in metres.
    pub height: f64,
    /// The largest speed of a point at the start of a contact, in metres per second.
    pub speed: f64,
    /// A contact ends when the height or the speed is above this factor times its threshold.
    pub release: f64,
    /// The shortest contact, in seconds. Shorter contacts are dropped.
    pub shortest: f64,
    /// The shortest gap between two contacts, in seconds. Shorter gaps are closed.
    pub gap: f64,
}

/// A contact ends when the height or the speed is above this factor times its threshold. The factor applies to contacts
/// in reports and to contacts that lock the feet.
const RELEASE: f64 = 1.6;

impl Default for ContactRule {
    fn default() -> Self {
        Self {
            height: 0.05,
            speed: 0.25,
            release: RELEASE,
            shortest: 0.08,
            gap: 0.05,
        }
    }
}

impl ContactRule {
    /// For each frame, whether a point is in contact. `samples` has the height of the point above its resting level in
    /// metres, and its speed in metres per second.
    pub fn at_rest(&self, samples: impl Iterator<Item = (f64, f64)>, frame_rate: f64) -> Vec<bool> {
        let mut at_rest = self.low_and_slow(samples);
        let frames = |seconds: f64| frames_in(seconds, frame_rate, at_rest.len());
        let (gap, shortest) = (frames(self.gap), frames(self.shortest));
        without_short_ones(&mut at_rest, gap, shortest);
        at_rest
    }

    fn low_and_slow(&self, samples: impl Iterator<Item = (f64, f64)>) -> Vec<bool> {
        let mut rests = false;
        let state = |(height, speed): (f64, f64)| {
            let factor = if rests { self.release } else { 1.0 };
            rests = height <= factor * self.height && speed <= factor * self.speed;
            rests
        };
        samples.map(state).collect()
    }
}

/// The whole number of frames nearest to a time, at least 1 and at most `frames`.
pub fn frames_in(seconds: f64, frame_rate: f64, frames: usize) -> usize {
    ((seconds * frame_rate).round().max(1.0) as usize).min(frames.max(1))
}

/// The examined points of the feet: the ankles of both sides, which share one resting height, and the balls of both
/// feet.
pub fn points_of_feet(scene: &Scene, humanoid: &Humanoid) -> [Vec<(Bone, NodeId)>; 2] {
    [Bone::LeftFoot, Bone::LeftToes].map(|bone| {
        let node = |side: Side| match bone {
            Bone::LeftToes => ball(scene, humanoid, side),
            _ => humanoid.joint(bone.on(side)),
        };
        let sides = Side::ALL.into_iter();
        sides.filter_map(|side| Some((bone.on(side), node(side)?))).collect()
    })
}

/// The node at the ball of the foot: the joint of the toes, or else the first node below the ankle.
pub fn ball(scene: &Scene, humanoid: &Humanoid, side: Side) -> Option<NodeId> {
    let ankle = humanoid.joint(Bone::LeftFoot.on(side))?;
    let below = || {
        (0..scene.nodes.len())
            .map(NodeId::new)
            .find(|node| scene.nodes[node.index()].parent == Some(ankle))
    };
    humanoid.joint(Bone::LeftToes.on(side)).or_else(below)
}

/// Closes gaps shorter than `gap` frames in `contacts`, then drops contacts shorter than `contact` frames.
pub fn without_short_ones(contacts: &mut [bool], gap: usize, contact: usize) {
    for (value, shortest) in [(false, gap), (true, contact)] {
        let mut start = 0;
        for end in 1..=contacts.len() {
            if end < contacts.len() && contacts[end] == contacts[start] {
                continue;
            }
            // A contact at the start or end of the motion may be longer, so it is kept. A gap must have contacts on
            // both sides.
            let is_inside = start > 0 && end < contacts.len();
            if contacts[start] == value && end - start < shortest && is_inside {
                contacts[start..end].fill(!value);
            }
            start = end;
        }
    }
}
