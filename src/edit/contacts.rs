//! Finds the frames in which a foot or a hand is at rest.

use glam::Vec3;
use mocap_figure::contacts::{ContactRule, points_of_feet};
use mocap_figure::ground::{FootPoints, levels};
use mocap_figure::{Figure, Humanoid, HumanoidBone, Side};
use mocap_scene::error::{Code, Result};
use mocap_scene::limits::not_negative;
use mocap_scene::math::velocity::velocities;
use mocap_scene::options::setters;
use mocap_scene::pose::Pose;
use mocap_scene::scene::{Animation, NodeId, Scene};
use serde::{Deserialize, Serialize};

use super::body::figure_of;
use super::frames::{Frames, tracks};

/// Thresholds that decide when a foot or a hand is at rest.
///
/// A point comes to rest when its height is at most `height` and its speed at most `speed`. It stays at rest until its
/// height is above `release` times `height`, or its speed is above `release` times `speed`. Heights are relative to the
/// point's own resting level, because an ankle rests higher above the floor than a toe.
///
/// [`ContactOptions::detect`](crate::ContactOptions::detect) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct ContactOptions {
    /// The largest height of a point above its resting level, in metres. Default: 0.05.
    pub height: f64,
    /// The largest speed of a point, in metres per second. Default: 0.25.
    pub speed: f64,
    /// A contact ends when the height or the speed of the point is above this factor times `height` or `speed`.
    /// Default: 1.6.
    pub release: f64,
    /// The shortest contact, in seconds. Shorter contacts are ignored. Default: 0.08.
    pub shortest: f64,
    /// The shortest gap between two contacts, in seconds. If a gap is shorter, both contacts become one. Default: 0.05.
    pub gap: f64,
    /// Whether hands are also examined. Default: `false`.
    pub hands: bool,
}

setters! {
    ContactOptions {
        height: f64,
        speed: f64,
        release: f64,
        shortest: f64,
        gap: f64,
        hands: bool,
    }
}

impl Default for ContactOptions {
    fn default() -> Self {
        let ContactRule {
            height,
            speed,
            release,
            shortest,
            gap,
        } = ContactRule::default();
        Self {
            height,
            speed,
            release,
            shortest,
            gap,
            hands: false,
        }
    }
}

impl ContactOptions {
    fn rule(&self) -> ContactRule {
        ContactRule {
            height: self.height,
            speed: self.speed,
            release: self.release.max(1.0),
            shortest: self.shortest,
            gap: self.gap,
        }
    }

    /// Refuses thresholds that are negative or not finite.
    pub(super) fn check(&self) -> Result<()> {
        for (name, value) in [
            ("height", self.height),
            ("speed", self.speed),
            ("release", self.release),
            ("shortest", self.shortest),
            ("gap", self.gap),
        ] {
            not_negative(Code::InvalidValue, name, value)?;
        }
        Ok(())
    }
}

/// A point of a foot or a hand, and the frames in which the point is at rest.
///
/// [`ContactOptions::detect`](crate::ContactOptions::detect) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ContactPoint {
    /// The bone of the point: a foot (its point is the ankle), the toes (their point is the ball of the foot), or a
    /// hand.
    pub bone: HumanoidBone,
    /// The node whose position is the point. If the toes have no joint, the node is the first node below the ankle.
    pub node: NodeId,
    /// The name of the node.
    pub name: String,
    /// The resting level: the height of the point above the floor when it rests, in metres.
    pub height: f32,
    /// For each frame, whether the point is at rest.
    pub at_rest: Vec<bool>,
    /// For each frame, the height of the point above its resting level, in metres.
    #[serde(skip)]
    pub above_rest: Vec<f32>,
    /// For each frame, the position of the point in the world, in units of the scene.
    #[serde(skip)]
    pub positions: Vec<Vec3>,
}

impl ContactPoint {
    /// The contacts, each as its first and its last frame.
    pub fn intervals(&self) -> Vec<[usize; 2]> {
        let mut intervals: Vec<[usize; 2]> = Vec::new();
        for (frame, _) in self.at_rest.iter().enumerate().filter(|(_, at_rest)| **at_rest) {
            match intervals.last_mut() {
                Some(last) if last[1] + 1 == frame => last[1] = frame,
                _ => intervals.push([frame, frame]),
            }
        }
        intervals
    }
}

/// The contacts of an animation.
///
/// [`ContactOptions::detect`](crate::ContactOptions::detect) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct DetectedContacts {
    /// Frames per second.
    pub frame_rate: f64,
    /// The number of frames.
    pub frames: usize,
    /// The height of the floor along the up axis, in metres.
    pub floor: f32,
    /// The points: of the ankles, the balls of the feet and the hands. The left point is before the right point.
    pub points: Vec<ContactPoint>,
}

impl DetectedContacts {
    /// The point of a bone.
    pub fn point(&self, bone: HumanoidBone) -> Option<&ContactPoint> {
        self.points.iter().find(|point| point.bone == bone)
    }
}

impl ContactOptions {
    /// Finds the frames in which the feet are at rest. If [`hands`](Self::hands) is `true`, also finds the frames in
    /// which the hands are at rest. Pass the bones as `humanoid` if you know them; otherwise mocap finds them.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::ContactOptions;
    /// use mocap::figure::HumanoidBone;
    ///
    /// let scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let found = ContactOptions::default().detect(&scene, 0, None)?;
    /// let steps = found.point(HumanoidBone::LeftToes).unwrap().intervals();
    /// assert!(steps.len() >= 2, "{steps:?}");
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::NotHumanoid`](mocap_scene::Code::NotHumanoid); [`Code::NoMotion`](mocap_scene::Code::NoMotion) without
    /// this animation; [`Code::InvalidValue`](mocap_scene::Code::InvalidValue) for a threshold that is negative or not
    /// finite.
    pub fn detect(&self, scene: &Scene, animation: usize, humanoid: Option<&Humanoid>) -> Result<DetectedContacts> {
        self.check()?;
        let figure = figure_of(scene, humanoid)?;
        let frames = Frames::reading(scene, animation, &[])?;
        Ok(detect(scene, &frames, &figure, self))
    }
}

/// The contacts of an animation of `scene` whose figure is known, with the default thresholds.
#[doc(hidden)]
pub fn contacts_of(scene: &Scene, animation: &Animation, figure: &Figure) -> Result<DetectedContacts> {
    let frames = Frames::of(scene, animation, &[])?;
    Ok(detect(scene, &frames, figure, &ContactOptions::default()))
}

/// Finds the contacts in `frames`.
pub(super) fn detect(scene: &Scene, frames: &Frames, figure: &Figure, options: &ContactOptions) -> DetectedContacts {
    let mut pairs: Vec<_> = points_of_feet(scene, &figure.humanoid).into();
    if options.hands {
        let hand = |side: Side| {
            let bone = HumanoidBone::LeftHand.on(side);
            Some((bone, figure.humanoid.joint(bone)?))
        };
        pairs.push(Side::ALL.into_iter().filter_map(hand).collect());
    }
    let (up, metres) = (figure.up_direction(), figure.metres());
    let feet = FootPoints::new(scene, &figure.humanoid, up);
    let mut nodes: Vec<NodeId> = pairs.iter().flatten().map(|(_, node)| *node).collect();
    nodes.extend(feet.nodes.iter().flatten());
    nodes.sort_unstable();
    nodes.dedup();
    let tracks = tracks(frames, scene, &nodes);
    let track = |node: &NodeId| nodes.binary_search(node).map_or(&[][..], |index| &tracks[index]);
    let kinds = feet.nodes.each_ref().map(|nodes| nodes.iter().map(track).collect());
    let levels = levels(&kinds, up, metres, frames.rate);
    let ground = feet.ground(&levels);
    let floor = ground.map_or(0.0, |ground| ground.height());
    let lowest = ground.map_or(0.0, |ground| ground.joints());
    let mut points = Vec::new();
    for (index, pair) in pairs.into_iter().enumerate() {
        // Both feet rest on one floor, so the left and the right point of a kind (ankles, balls) have one resting
        // level. A hand rests at the level of the lowest joints of the feet.
        let rest = match index {
            2.. => lowest,
            kind => levels[kind].unwrap_or(lowest),
        };
        for (bone, node) in pair {
            let track = track(&node);
            let above_rest: Vec<f32> = track.iter().map(|point| (point.dot(up) - rest) * metres).collect();
            points.push(ContactPoint {
                bone,
                node,
                name: scene.nodes[node.index()].name.clone(),
                height: (rest - floor) * metres,
                at_rest: rests(track, &above_rest, frames.rate, figure, options),
                above_rest,
                positions: track.to_vec(),
            });
        }
    }
    DetectedContacts {
        frame_rate: frames.rate,
        frames: frames.len(),
        floor: floor * metres,
        points,
    }
}

/// For each frame, whether a point is at rest, by its position and its height above its resting level.
fn rests(track: &[Vec3], above_rest: &[f32], rate: f64, figure: &Figure, options: &ContactOptions) -> Vec<bool> {
    let flat: Vec<f32> = track.iter().flat_map(Vec3::to_array).collect();
    let speeds = velocities(&flat, 3, rate);
    let speeds = speeds
        .chunks_exact(3)
        .map(|speed| Vec3::from_slice(speed).length() * figure.metres());
    let samples = above_rest.iter().zip(speeds);
    let samples = samples.map(|(height, speed)| (f64::from(*height), f64::from(speed)));
    options.rule().at_rest(samples, rate)
}

/// The contacts of feet in the latest frames of a live motion.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct LiveContacts {
    figure: Figure,
    rate: f64,
    /// The number of past frames that are kept.
    most: usize,
    /// The points, one list for each kind (ankles, balls), because both points of a kind rest at one height. Each point
    /// has its side, its node, and its past positions.
    pairs: Vec<Vec<(Side, NodeId, Vec<Vec3>)>>,
}

impl LiveContacts {
    /// Creates the state for a figure with `rate` poses per second. The height of the floor comes from the last
    /// `seconds` seconds.
    #[doc(hidden)]
    pub fn new(scene: &Scene, figure: Figure, rate: f64, seconds: f64) -> Self {
        let pairs = points_of_feet(scene, &figure.humanoid).into_iter().map(|pair| {
            let points = pair.into_iter();
            let points = points.filter_map(|(bone, node)| Some((bone.side()?, node, Vec::new())));
            points.collect()
        });
        Self {
            pairs: pairs.collect(),
            figure,
            rate,
            most: (seconds * rate).ceil().max(2.0) as usize,
        }
    }

    /// Adds a frame.
    #[doc(hidden)]
    pub fn push(&mut self, pose: &Pose) {
        for (_, node, track) in self.pairs.iter_mut().flatten() {
            if track.len() == self.most {
                track.remove(0);
            }
            track.push(pose.position(*node));
        }
    }

    /// Which feet are at rest, `before` frames before the last frame.
    #[doc(hidden)]
    pub fn at(&self, before: usize) -> [bool; 2] {
        let mut found = [false; 2];
        let height = |point: &Vec3| point.dot(self.figure.up_direction()) * self.figure.metres();
        let tracks = |pair: &Vec<(Side, NodeId, Vec<Vec3>)>| pair.iter().map(|(_, _, track)| track.clone()).collect();
        let kinds: Vec<Vec<Vec<Vec3>>> = self.pairs.iter().map(tracks).collect();
        let (up, metres) = (self.figure.up_direction(), self.figure.metres());
        let levels = levels(&kinds, up, metres, self.rate);
        for (pair, rest) in self.pairs.iter().zip(levels) {
            let rest = rest.unwrap_or_default() * metres;
            let frames = pair.first().map_or(0, |(_, _, track)| track.len());
            for (side, _, track) in pair {
                let above: Vec<f32> = track.iter().map(|point| height(point) - rest).collect();
                let at_rest = rests(track, &above, self.rate, &self.figure, &ContactOptions::default());
                let frame = frames.checked_sub(before + 1);
                found[*side as usize] |= frame.is_some_and(|frame| at_rest[frame]);
            }
        }
        found
    }
}
