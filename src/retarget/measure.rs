//! How well a motion sits on another skeleton, measured on the poses of both.

use glam::{Quat, Vec3};
use serde::Serialize;

use super::body::{Body, limb_end};
use super::plan::Unmapped;
use crate::pose::{Binding, Pose};
use crate::scene::{Animation, NodeId, Scene};
use crate::skeleton::HumanoidBone as Bone;

/// The fastest a foot may be that stands on the ground, in metres a second.
const CONTACT_SPEED: f32 = 0.15;

/// The highest a joint of a foot may be above its height in a standing body, in metres, where it stands on the ground.
const CONTACT_HEIGHT: f32 = 0.03;

/// The depth below the floor that counts, in metres.
const BELOW: f32 = 0.01;

/// How much faster the feet of the target may slide than those of the source, in metres a second.
const MORE_SKATE: f64 = 0.005;

/// The share of frames in which they may be below the floor.
const MOST_BELOW: f64 = 0.01;

/// The difference of feet that do the same, in metres or metres a second.
const SAME_FEET: f64 = 1e-4;

/// How far the directions of a limb are apart on two skeletons.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LimbError {
    /// The bone.
    pub bone: Bone,
    /// The mean of all frames, in degrees.
    pub mean_degrees: f64,
    /// The largest angle of a frame, in degrees.
    pub max_degrees: f64,
    /// The tick of the largest angle.
    pub tick: f64,
}

/// The feet of one skeleton in a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FootMotion {
    /// The mean speed over the ground of feet that stand, in metres a second.
    pub skate: f64,
    /// The share of frames in which a foot is more than 1 cm below the floor.
    pub share_below_floor: f64,
    /// How far below the floor a joint of a foot is at most, in metres.
    pub deepest: f64,
}

/// The feet before and after.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FeetReport {
    /// Frames of both feet in which the source stands on a foot.
    pub contact_frames: usize,
    /// The feet of the source.
    pub source: FootMotion,
    /// The feet of the target, at the same frames.
    pub target: FootMotion,
}

/// Whether the motion can be used as it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The limbs are within 1 degree in the mean.
    Good,
    /// The limbs are within 3 degrees in the mean.
    Fair,
    /// The limbs are farther off, or nothing could be compared.
    Poor,
}

impl Verdict {
    /// Its name in JSON.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Fair => "fair",
            Self::Poor => "poor",
        }
    }
}

/// How well a motion sits on another skeleton.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RetargetReport {
    /// The name of the motion.
    pub clip: String,
    /// Frames compared.
    pub frames: usize,
    /// How many times as long the steps of the target are, both in metres.
    pub scale: f64,
    /// Arms and legs.
    pub limbs: Vec<LimbError>,
    /// The mean of all limbs and frames, in degrees.
    pub mean_degrees: f64,
    /// The largest angle of a limb in a frame, in degrees.
    pub max_degrees: f64,
    /// What is not moved, and why.
    pub unmapped: Vec<Unmapped>,
    /// The feet; absent where one skeleton has none.
    pub feet: Option<FeetReport>,
    /// Whether the motion can be used as it is.
    pub verdict: Verdict,
}

impl RetargetReport {
    /// Whether a motion with locked feet is better than `free`, the same without: its feet slide less or are above the floor
    /// more often, neither much worse, and its limbs still point where they should.
    pub fn is_better_locked_than(&self, free: &Self) -> bool {
        let Some((locked, free_feet)) = self.feet.zip(free.feet) else {
            return false;
        };
        let (locked, before) = (locked.target, free_feet.target);
        let less_skate = before.skate - locked.skate;
        let less_below = before.share_below_floor - locked.share_below_floor;
        let limbs_stay = self.verdict == free.verdict;
        limbs_stay && less_skate > -MORE_SKATE && less_below > -MOST_BELOW && (less_skate > 0.0 || less_below > 0.0)
    }

    /// Whether feet that stand slide more on the target than on the source, or are often below its floor. Feet that do what
    /// those of the source do, on a body of the same size, are left as they are.
    pub fn slides(&self) -> bool {
        self.feet.is_some_and(|FeetReport { source, target, .. }| {
            let is_same = |a: f64, b: f64| (a - b).abs() < SAME_FEET;
            let moves_alike = is_same(source.skate, target.skate) && is_same(source.deepest, target.deepest);
            let is_below = target.share_below_floor > MOST_BELOW;
            !moves_alike && (is_below || target.skate > source.skate + MORE_SKATE)
        })
    }
}

/// A skeleton with a motion, frame by frame.
pub(super) struct Moving<'a> {
    pub(super) body: &'a Body,
    pub(super) scene: &'a Scene,
    pub(super) animation: &'a Animation,
    /// The height of the ankles when it stands.
    pub(super) ankle: f32,
}

impl Moving<'_> {
    /// Calls `see` with each of the ticks and the pose there.
    fn poses(&self, ticks: &[f64], mut see: impl FnMut(usize, &Pose)) {
        let binding = Binding::new(self.scene, self.animation);
        let mut pose = Pose::rest(self.scene);
        for (frame, &tick) in ticks.iter().enumerate() {
            pose.sample(&binding, self.animation, tick);
            see(frame, &pose);
        }
    }

    /// The direction of a limb at each tick, in the axes of the figure.
    fn directions(&self, bone: Bone, ticks: &[f64]) -> Option<Vec<Vec3>> {
        let ends = self
            .body
            .joint(bone)
            .zip(limb_end(bone).and_then(|end| self.body.joint(end)));
        let (from, to) = ends?;
        let world_to_frame: Quat = self.body.axes.inverse();
        let mut directions = Vec::with_capacity(ticks.len());
        self.poses(ticks, |_, pose| {
            let way = pose.position(to) - pose.position(from);
            directions.push((world_to_frame * way).normalize_or_zero());
        });
        Some(directions)
    }

    /// The joints of a foot, each with its height when the body stands on it.
    fn foot(&self, foot: Bone, toes: Bone) -> Option<Vec<(NodeId, f32)>> {
        let ankle = self.body.joint(foot)?;
        let height = |node: NodeId| self.body.position(node).dot(self.body.up());
        let joints = [Some(ankle), self.body.joint(toes)].into_iter().flatten();
        Some(
            joints
                .map(|joint| (joint, self.ankle + height(joint) - height(ankle)))
                .collect(),
        )
    }

    /// The joints of both feet at each tick in metres, relative to the height at which they stand; +Y is up.
    fn feet(&self, ticks: &[f64]) -> Option<[Vec<Vec<Vec3>>; 2]> {
        let left = self.foot(Bone::LeftFoot, Bone::LeftToes)?;
        let right = self.foot(Bone::RightFoot, Bone::RightToes)?;
        let world_to_frame = self.body.axes.inverse();
        let metres = self.body.metres_per_unit as f32;
        let mut feet = [Vec::new(), Vec::new()];
        self.poses(ticks, |_, pose| {
            for (places, joints) in feet.iter_mut().zip([&left, &right]) {
                let place = |&(joint, height): &(NodeId, f32)| {
                    metres * (world_to_frame * pose.position(joint) - Vec3::new(0.0, height, 0.0))
                };
                places.push(joints.iter().map(place).collect());
            }
        });
        Some(feet)
    }
}

/// Compares two motions at the same ticks.
pub(super) fn measure(
    source: &Moving<'_>,
    target: &Moving<'_>,
    ticks: &[f64],
    scale: f64,
    unmapped: &[Unmapped],
) -> RetargetReport {
    let mut limbs = Vec::new();
    let (mut sum, mut count) = (0.0, 0);
    for &bone in Bone::ALL {
        let both = source.directions(bone, ticks).zip(target.directions(bone, ticks));
        let Some((was, is)) = both else { continue };
        let mut limb = LimbError {
            bone,
            mean_degrees: 0.0,
            max_degrees: 0.0,
            tick: 0.0,
        };
        for ((was, is), &tick) in was.iter().zip(&is).zip(ticks) {
            let angle = f64::from(was.cross(*is).length().atan2(was.dot(*is)).to_degrees());
            limb.mean_degrees += angle;
            if angle > limb.max_degrees {
                (limb.max_degrees, limb.tick) = (angle, tick);
            }
        }
        sum += limb.mean_degrees;
        count += ticks.len();
        limb.mean_degrees /= ticks.len().max(1) as f64;
        limbs.push(limb);
    }
    let mean_degrees = sum / count.max(1) as f64;
    RetargetReport {
        clip: target.animation.name.clone(),
        frames: ticks.len(),
        scale,
        max_degrees: limbs.iter().map(|limb| limb.max_degrees).fold(0.0, f64::max),
        verdict: match mean_degrees {
            _ if limbs.is_empty() => Verdict::Poor,
            mean if mean <= 1.0 => Verdict::Good,
            mean if mean <= 3.0 => Verdict::Fair,
            _ => Verdict::Poor,
        },
        limbs,
        mean_degrees,
        unmapped: unmapped.to_vec(),
        feet: feet(source, target, ticks),
    }
}

fn feet(source: &Moving<'_>, target: &Moving<'_>, ticks: &[f64]) -> Option<FeetReport> {
    let (was, is) = source.feet(ticks).zip(target.feet(ticks))?;
    let per_second = source.animation.ticks_per_second as f32;
    let flat = |step: Vec3| Vec3::new(step.x, 0.0, step.z).length();
    // The joint of a foot that stands is its slowest: it may roll over heel or toes.
    let speed = |places: &[Vec<Vec3>], frame: usize, joint: usize| {
        let step = ticks[frame + 1] - ticks[frame];
        flat(places[frame + 1][joint] - places[frame][joint]) * per_second / step as f32
    };
    let (mut contact_frames, mut before, mut after) = (0, 0.0, 0.0);
    for (was, is) in was.iter().zip(&is) {
        for frame in 0..ticks.len().saturating_sub(1) {
            let joints = was[frame].len().min(is[frame].len());
            let low = (0..joints).filter(|joint| was[frame][*joint].y < CONTACT_HEIGHT);
            let slowest = low.min_by(|a, b| speed(was, frame, *a).total_cmp(&speed(was, frame, *b)));
            let Some(joint) = slowest.filter(|joint| speed(was, frame, *joint) < CONTACT_SPEED) else {
                continue;
            };
            contact_frames += 1;
            before += f64::from(speed(was, frame, joint));
            after += f64::from(speed(is, frame, joint));
        }
    }
    let motion = |feet: &[Vec<Vec<Vec3>>; 2], speeds: f64| {
        let lowest = |frame: usize| {
            let joints = feet.iter().flat_map(|places| &places[frame]);
            joints.map(|place| place.y).fold(f32::INFINITY, f32::min)
        };
        let below = (0..ticks.len()).filter(|frame| lowest(*frame) < -BELOW).count();
        let deepest = (0..ticks.len()).map(lowest).fold(0.0, f32::min);
        FootMotion {
            skate: speeds / contact_frames.max(1) as f64,
            share_below_floor: below as f64 / ticks.len().max(1) as f64,
            deepest: f64::from(-deepest),
        }
    };
    Some(FeetReport {
        contact_frames,
        source: motion(&was, before),
        target: motion(&is, after),
    })
}
