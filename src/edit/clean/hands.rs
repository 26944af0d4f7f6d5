//! Keeps the contacts of hands with each other and with the body while noise is removed.
//!
//! Smoothing changes each joint independently, so it would move two touching hands apart. Therefore the position of a
//! hand relative to its partner is recorded and smoothed as a separate track. The partner is the other hand, or a bone.
//! After the smoothing of the joints, the arms move the hands to the smoothed relative positions.

use glam::{DVec3, Vec3};
use mocap_scene::ik::Goal;
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::{HumanoidBone as Bone, NodeId, Side};

use super::measures::jitter_and_peak;
use super::noise::without_noise;
use super::pace::Bank;
use super::smoother::Positions;
use crate::frames::Frames;
use crate::quantity::counted;
use crate::work::Work;

/// The leg length in metres of a body of 1.7 m. The lengths in [`BODY`] are those of this body.
const LEG: f32 = 0.84;

/// The distance in metres between the centre of a hand and the axis of a bone that it touches: about half of the
/// thickness of that part of the body.
const BODY: [(Bone, f32); 8] = [
    (Bone::Head, 0.17),
    (Bone::Chest, 0.19),
    (Bone::Spine, 0.19),
    (Bone::Hips, 0.19),
    (Bone::LeftUpperLeg, 0.14),
    (Bone::LeftLowerLeg, 0.11),
    (Bone::LeftUpperArm, 0.1),
    (Bone::LeftLowerArm, 0.09),
];

/// The largest increase of the distances between hands and partners that the step accepts, in metres. It is only as
/// large as rounding errors.
const WORSE: f64 = 1e-3;

/// The largest ratio of the body's jitter after the arms were moved to the jitter before. An increase of 15 % is not
/// visible.
const TREMBLES: f64 = 1.15;

/// A hand and its partner: the other hand, or a bone of the body.
#[derive(Clone, Debug)]
struct HandContact {
    hand: Palm,
    with: With,
    /// The frames in which the contact has a weight, in order.
    frames: Vec<HandFrame>,
}

/// A frame in which a hand is in contact.
#[derive(Clone, Copy, Debug)]
struct HandFrame {
    frame: usize,
    /// The smoothed position of the hand relative to its partner, in metres.
    apart: DVec3,
    /// The weight of the contact, from 0 to 1.
    weight: f64,
}

#[derive(Clone, Copy, Debug)]
enum With {
    /// The other hand. Both hands move.
    Hand(Palm),
    /// A joint of the body, and the end of its bone in units of the scene. The position of the hand is relative to the
    /// joint's coordinate frame.
    Body(NodeId, Vec3),
}

/// The joints of an arm. The centre of the hand is half way from the wrist to the node below.
#[derive(Clone, Copy, Debug)]
struct Palm {
    arm: [NodeId; 3],
    below: Option<NodeId>,
}

impl Palm {
    fn new(work: &Work<'_>, side: Side) -> Option<Self> {
        let joint = |bone: Bone| work.figure.humanoid.joint(bone.on(side));
        let hand = joint(Bone::LeftHand)?;
        let below = || {
            work.scene
                .nodes
                .iter()
                .position(|node| node.parent == Some(hand))
                .map(NodeId::new)
        };
        Some(Self {
            arm: [joint(Bone::LeftUpperArm)?, joint(Bone::LeftLowerArm)?, hand],
            below: joint(Bone::LeftMiddleProximal).or_else(below),
        })
    }

    fn position(self, pose: &Pose) -> Vec3 {
        let wrist = pose.position(self.arm[2]);
        self.below.map_or(wrist, |below| wrist.midpoint(pose.position(below)))
    }
}

impl With {
    /// The position of a hand relative to this partner.
    fn apart(self, hand: Palm, pose: &Pose) -> Vec3 {
        match self {
            Self::Hand(other) => hand.position(pose) - other.position(pose),
            Self::Body(joint, _) => pose.node_to_world[joint.index()]
                .inverse()
                .transform_point3(hand.position(pose)),
        }
    }

    /// The distance between this partner and a hand at the relative position `apart`, in metres.
    fn distance(self, apart: DVec3, metres: f32) -> f64 {
        match self {
            Self::Hand(_) => apart.length(),
            Self::Body(_, end) => {
                let end = end.as_dvec3() * f64::from(metres);
                let along = (apart.dot(end) / end.length_squared().max(1e-9)).clamp(0.0, 1.0);
                apart.distance(end * along)
            }
        }
    }
}

/// The hand contacts of a motion, measured before smoothing.
#[derive(Clone, Debug, Default)]
pub(super) struct Meetings(Vec<HandContact>);

impl Meetings {
    /// Measures the hand contacts of a humanoid. The result is empty for any other body.
    pub(super) fn new(work: &Work<'_>, bank: &Bank) -> Self {
        let hands: Vec<Palm> = Side::ALL.into_iter().filter_map(|side| Palm::new(work, side)).collect();
        let size = work.leg().map_or(1.0, |leg| leg / LEG);
        let mut pairs: Vec<(Palm, With, f32)> = Vec::new();
        if let [left, right] = hands[..] {
            pairs.push((left, With::Hand(right), work.weights.hand_distance as f32 * size));
        }
        for hand in &hands {
            for (bone, thick) in BODY {
                let sides = if bone.side().is_some() {
                    &Side::ALL[..]
                } else {
                    &Side::ALL[..1]
                };
                let joints = sides
                    .iter()
                    .filter_map(|side| work.figure.humanoid.joint(bone.on(*side)));
                // A hand is always near its own arm, so this is no contact.
                let joints = joints.filter(|joint| !hand.arm.contains(joint));
                pairs.extend(joints.map(|joint| (*hand, With::Body(joint, end(work, joint)), thick * size)));
            }
        }
        let apart = |(hand, with, _): &(Palm, With, f32), pose: &Pose| with.apart(*hand, pose) * work.metres;
        let mut pose = Pose::rest(work.scene);
        let mut is_met = vec![false; pairs.len()];
        for frame in 0..work.frames.len() {
            work.frames.pose(frame, &mut pose);
            for (is_met, pair) in is_met.iter_mut().zip(&pairs) {
                let near = f64::from(pair.2) + work.weights.hand_noise;
                *is_met = *is_met || pair.1.distance(apart(pair, &pose).as_dvec3(), work.metres) < near;
            }
        }
        let mut is_met = is_met.into_iter();
        pairs.retain(|_| is_met.next().unwrap_or_default());
        let mut tracks: Vec<Vec<Vec3>> = pairs.iter().map(|_| Vec::with_capacity(work.frames.len())).collect();
        for frame in 0..work.frames.len() {
            work.frames.pose(frame, &mut pose);
            for (track, pair) in tracks.iter_mut().zip(&pairs) {
                track.push(apart(pair, &pose));
            }
        }
        let contact = |(pair, track): (&(Palm, With, f32), Vec<Vec3>)| HandContact::new(*pair, track, work, bank);
        Self(pairs.iter().zip(tracks).filter_map(contact).collect())
    }

    /// The mean distance in metres between hands and their partners, in the frames in which a contact has its full
    /// weight. `None` if there is no contact.
    pub(super) fn apart(&self, work: &Work<'_>) -> Option<f64> {
        let mut pose = Pose::rest(work.scene);
        let (mut sum, mut count) = (0.0, 0);
        for frame in 0..work.frames.len() {
            let mut is_posed = false;
            for meeting in self.0.iter().filter(|meeting| meeting.weight(frame) == 1.0) {
                if !is_posed {
                    work.frames.pose(frame, &mut pose);
                    is_posed = true;
                }
                let apart = meeting.with.apart(meeting.hand, &pose) * work.metres;
                sum += meeting.with.distance(apart.as_dvec3(), work.metres);
                count += 1;
            }
        }
        (count > 0).then(|| sum / f64::from(count))
    }

    /// Restores the contacts that the smoothing changed. Returns a message about the changes, which is empty if nothing
    /// changed.
    pub(super) fn restore(&self, work: &mut Work<'_>, before: Option<f64>) -> String {
        let (Some(before), Some(smoothed)) = (before, self.apart(work)) else {
            return String::new();
        };
        let old = work.frames.clone();
        let frames = self.keep(work);
        let after = self.apart(work).unwrap_or(smoothed);
        let jitter = |frames: &Frames| jitter_and_peak(work, frames)[0];
        if jitter(&work.frames) > TREMBLES * jitter(&old) || (after - before).abs() > (smoothed - before).abs() + WORSE
        {
            work.frames = old;
            return String::new();
        }
        format!("hand contacts restored in {}", counted(frames, "frame"))
    }

    /// Moves the arms of a smoothed motion so that their hands are in contact. Returns the number of changed frames.
    fn keep(&self, work: &mut Work<'_>) -> usize {
        let mut changed = 0;
        let mut pose = Pose::rest(work.scene);
        for frame in 0..work.frames.len() {
            if self.0.iter().all(|meeting| meeting.weight(frame) == 0.0) {
                continue;
            }
            work.frames.pose(frame, &mut pose);
            let mut arms: Vec<(Palm, Vec3, f32)> = Vec::new();
            for meeting in &self.0 {
                let weight = meeting.weight(frame) as f32;
                for (palm, by) in meeting.shifts(frame, &pose, work.metres) {
                    match arms.iter_mut().find(|arm| arm.0.arm == palm.arm) {
                        Some(arm) => (arm.1, arm.2) = (arm.1 + by * weight, arm.2 + weight),
                        None => arms.push((palm, by * weight, weight)),
                    }
                }
            }
            for (palm, sum, weight) in arms {
                // An arm with several contacts moves by the weighted mean of their displacements. An arm with one
                // contact moves by the displacement times its weight.
                let by = (sum / weight.max(1.0)).clamp_length_max(work.weights.hand_noise as f32 / work.metres);
                bring(&mut pose, &mut work.frames, frame, palm.arm, by);
            }
            changed += 1;
        }
        changed
    }
}

impl With {
    /// The weight of the contact in each frame: 1 where the hand is near. It decreases with distance and, on the body,
    /// with speed.
    fn weights(self, apart: &[DVec3], near: f64, work: &Work<'_>) -> Vec<f64> {
        let end = apart.len().saturating_sub(1);
        let speed = |frame: usize| {
            let (from, to) = (frame.saturating_sub(1), (frame + 1).min(end));
            apart[to].distance(apart[from]) * work.frames.rate / (to - from).max(1) as f64
        };
        let fade = work.weights.hand_fade;
        let least = |ratio: f64| {
            let part = ((ratio - 1.0) / (fade - 1.0)).clamp(0.0, 1.0);
            1.0 - part * part * (3.0 - 2.0 * part)
        };
        let weight = |frame: usize| {
            let is_near = least(self.distance(apart[frame], work.metres) / near);
            match self {
                Self::Hand(_) => is_near,
                Self::Body(..) => is_near.min(least(speed(frame) / work.weights.hand_speed)),
            }
        };
        let weights: Vec<f64> = (0..apart.len()).map(weight).collect();
        eased(&weights, work.frames.frames_in(work.weights.hand_blend))
    }
}

impl HandContact {
    /// Smooths the position of a hand relative to its partner. Returns `None` if they never touch.
    fn new((hand, with, near): (Palm, With, f32), track: Vec<Vec3>, work: &Work<'_>, bank: &Bank) -> Option<Self> {
        let mut apart: Vec<DVec3> = track.iter().map(|apart| apart.as_dvec3()).collect();
        drop(track);
        let is_noise = |noise: f64| noise >= work.weights.least_distance;
        let smooth = without_noise::<Positions>(&apart, &work.missing, work.frames.rate, bank, true, is_noise);
        if let Some((smooth, _)) = smooth {
            apart = smooth;
        }
        let weights = with.weights(&apart, f64::from(near), work);
        let frames = weights.iter().enumerate().filter(|(_, weight)| **weight != 0.0);
        let frames = frames.map(|(frame, weight)| HandFrame {
            frame,
            apart: apart[frame],
            weight: *weight,
        });
        weights.contains(&1.0).then(|| Self {
            hand,
            with,
            frames: frames.collect(),
        })
    }

    fn at(&self, frame: usize) -> Option<&HandFrame> {
        let found = self.frames.binary_search_by_key(&frame, |held| held.frame);
        found.ok().map(|index| &self.frames[index])
    }

    /// The weight of the contact in a frame.
    fn weight(&self, frame: usize) -> f64 {
        self.at(frame).map_or(0.0, |held| held.weight)
    }

    /// The displacement of each hand that restores the contact, in units of the scene.
    fn shifts(&self, frame: usize, pose: &Pose, metres: f32) -> Vec<(Palm, Vec3)> {
        let Some(held) = self.at(frame) else {
            return Vec::new();
        };
        let goal = (held.apart / f64::from(metres)).as_vec3();
        let off = goal - self.with.apart(self.hand, pose);
        match self.with {
            With::Hand(other) => vec![(self.hand, 0.5 * off), (other, -0.5 * off)],
            With::Body(joint, _) => vec![(self.hand, pose.node_to_world[joint.index()].transform_vector3(off))],
        }
    }
}

/// Moves the end of an arm and keeps its rotation in the world.
fn bring(pose: &mut Pose, frames: &mut Frames, frame: usize, arm: [NodeId; 3], by: Vec3) {
    let hand = Trs::from_matrix(pose.node_to_world[arm[2].index()]);
    pose.bend_limb(arm, &Goal::at(hand.translation + by).with_rotation(hand.rotation), None);
    for node in arm {
        frames.set_rotation_of(frame, node, pose);
    }
}

/// The end of a joint's bone in the coordinate frame of the joint: the position of its farthest child.
fn end(work: &Work<'_>, joint: NodeId) -> Vec3 {
    let children = work.scene.nodes.iter().filter(|node| node.parent == Some(joint));
    let offsets = children.map(|child| child.transform.w_axis.truncate());
    offsets
        .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
        .unwrap_or_default()
}

/// Spreads weights over `frames` frames on either side, with a cosine fall-off, so that they rise and fall smoothly.
fn eased(weights: &[f64], frames: usize) -> Vec<f64> {
    let at = |frame: usize| {
        let around = frame.saturating_sub(frames)..(frame + frames + 1).min(weights.len());
        let less = |other: usize| {
            let part = other.abs_diff(frame) as f64 / (frames + 1) as f64;
            weights[other] * (0.5 + 0.5 * (std::f64::consts::PI * part).cos())
        };
        around.map(less).fold(0.0, f64::max)
    };
    (0..weights.len()).map(at).collect()
}
