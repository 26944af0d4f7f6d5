//! When feet and hands are at rest on the ground: the one rule for all commands.

use mocap_scene::scene::{HumanoidBone as Bone, NodeId, Scene, Side};

use super::humanoid::Humanoid;

/// When a point is at rest: it comes to rest when it is low and slow, and leaves when it is `release` times too high or
/// too fast. Heights are those above the level on which the point rests itself: an ankle is higher above the floor than
/// a toe.
#[derive(Clone, Copy, Debug)]
pub struct ContactRule {
    /// The largest height in contact, in metres.
    pub height: f64,
    /// The largest speed in contact, in metres per second.
    pub speed: f64,
    /// How many times as high or fast a point in contact must be to leave it.
    pub release: f64,
    /// The shortest contact, in seconds; shorter ones are dropped.
    pub shortest: f64,
    /// The shortest gap between two contacts, in seconds; shorter ones are closed.
    pub gap: f64,
}

/// How many times as high or fast a point in contact must be to leave it: for contacts that are reported, and for those
/// by which feet are held.
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
    /// The contacts of one point: whether it is at rest in each frame. `samples` are its height above the level of rest
    /// and its speed, in metres and seconds.
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

/// The points of the feet that are examined, those of both sides together, which rest at one height: the ankles, and
/// the balls of the feet.
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

/// Ends every gap in `contacts` that is shorter than `gap` frames, and then drops every contact shorter than `contact`.
pub fn without_short_ones(contacts: &mut [bool], gap: usize, contact: usize) {
    for (value, shortest) in [(false, gap), (true, contact)] {
        let mut start = 0;
        for end in 1..=contacts.len() {
            if end < contacts.len() && contacts[end] == contacts[start] {
                continue;
            }
            // A contact that is cut off by the end of the motion may be longer; a gap must have contacts on both sides.
            let is_inside = start > 0 && end < contacts.len();
            if contacts[start] == value && end - start < shortest && is_inside {
                contacts[start..end].fill(!value);
            }
            start = end;
        }
    }
}
