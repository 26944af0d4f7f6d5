//! Infers the up axis. The evidence is the rest pose, a few poses of the motion, and how frequent each up axis is in
//! files.

use glam::Vec3;
use mocap_scene::math::median::median;
use mocap_scene::scene::{HumanoidBone as Bone, NodeId, Side};

use super::Confidence;
use super::axis::Axis;
use super::measure::Measures;
use mocap_scene::scene::report::Guess;

/// The axes that may point up.
const AXES: [Axis; 4] = [Axis::Y, Axis::Z, Axis::NegY, Axis::NegZ];

/// The scores of an axis, as natural logarithms of likelihoods. The weights are near the weights of a logistic
/// regression over 261 clips of 25 makers and 150 generated motions: crawls, lies, handstands, sit-ups, walks. Each
/// clip is rotated to all axes, and weighted by the frequency of the up axis in files.
///
/// The score of Y and -Y: more than nine of ten BVH files are Y up.
const IS_Y: f32 = 2.1;

/// An additional score for Y and Z, as a logarithm of a likelihood. -Y and -Z do not get it.
const IS_POSITIVE: f32 = 3.5;

/// The weight of the cosine of the angle between the axis and the mean direction from the feet to the head.
const TO_HEAD: f32 = 3.0;

/// The additional weight of this cosine if it is negative: nobody stands on the head all the time.
const UPSIDE_DOWN: f32 = 2.5;

/// The weight of the range of heights of the lowest joint in the motion, as a fraction of the figure's size. The lowest
/// joint of a body on the ground stays near one height.
const WANDER: f32 = -6.9;

/// The largest vertical range that counts, as fractions of the figure's size. The first value is for a body that lies
/// along the ground, the second for a standing body. A standing body may jump, but a lying body does not climb.
const MOST_WANDER: [f32; 2] = [1.5, 0.6];

/// Limits of the cosine of the angle between the axis and the mean direction from the feet to the head. A body lies up
/// to the first limit, and stands from the second.
const LIES_OR_STANDS: [f32; 2] = [0.3, 0.6];

/// The score of a body that lies on a floor at height 0.
const LIES: f32 = 5.3;

/// The weight of the cosine of the angle between the axis and the trunk of a standing rest pose.
const REST: f32 = 7.7;

/// The weight of the fraction of joints at the height of the lowest joint. Joints on the ground lie in one plane.
const CONTACT: f32 = 4.5;

/// The weight of the height of the hips above the lowest joint, as a fraction of the figure's size.
const HIPS: f32 = 6.4;

/// The score of a ground far below 0, where the origin would be in the air.
const BELOW: f32 = -2.5;

/// The largest height of a joint in contact above the ground, as a fraction of the figure's size.
const TOUCHES: f32 = 0.06;

/// A ground below this height counts as far below 0. The height is a fraction of the figure's size.
const FAR_BELOW: f32 = -0.2;

/// Heights of the lowest joint of a body that lies on a floor at height 0, as fractions of the figure's size. The
/// joints of a lying limb are inside the limb, and not on the floor.
const LYING: std::ops::RangeInclusive<f32> = -0.03..=0.07;

/// Heights of the hips of a body that lies on a floor at height 0, as fractions of the figure's size. The hips of a
/// body that stands above the origin are at 0 along a horizontal axis, with joints behind them.
const LYING_HIPS: std::ops::RangeInclusive<f32> = 0.02..=0.2;

/// The probability of an axis, as a fraction, above which the axis is sure: one of a hundred may be wrong.
const SURE: f32 = 0.99;
/// The probability of an axis, as a fraction, above which the axis is likely. Without evidence of the motion, Y has
/// 0.87.
const LIKELY: f32 = 0.9;

/// The smallest cosine of the angle between the up axis and the mean direction from the feet to the head of a standing
/// body.
const UPRIGHT: f32 = 0.9;

/// The joints whose heights are examined. Of the joints on both sides, the left joint is listed. Fingers and the joints
/// of the spine are not examined.
const PARTS: [Bone; 10] = [
    Bone::Hips,
    Bone::Neck,
    Bone::Head,
    Bone::LeftUpperArm,
    Bone::LeftLowerArm,
    Bone::LeftHand,
    Bone::LeftUpperLeg,
    Bone::LeftLowerLeg,
    Bone::LeftFoot,
    Bone::LeftToes,
];

impl Measures<'_> {
    /// The up axis.
    pub(super) fn up(&self) -> Option<Guess<Axis>> {
        let rest = self.rest_up();
        let stands = |axis: Axis| rest.is_some_and(|rest| rest.dot(axis.direction().unwrap_or_default()) > 0.8);
        let Some(motion) = self.motion_up() else {
            let axis = rest.map(|rest| Axis::nearest(rest).0).filter(|axis| stands(*axis))?;
            return Some(Guess {
                value: axis,
                confidence: Confidence::Likely,
                reason: "the rest pose stands along this axis".to_owned(),
            });
        };
        let scores = AXES.map(|axis| motion.score(axis, rest));
        let best = scores.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let axis = AXES.into_iter().zip(scores).find(|(_, score)| *score == best)?.0;
        let probability = scores.iter().map(|score| (score - best).exp()).sum::<f32>().recip();
        let mean = motion.mean;
        let words = format!(
            "the feet-to-head direction is ({:.2}, {:.2}, {:.2})",
            mean.x, mean.y, mean.z
        );
        let reason = match (stands(axis), Axis::nearest(mean).0 == axis) {
            (true, true) => format!("{words}, and the rest pose stands along this axis"),
            (true, false) => format!("the rest pose stands along this axis; in the motion, {words}"),
            (false, true) => words,
            (false, false) => format!("the contacts with the ground show this axis; {words}"),
        };
        // A body shows its up axis for certain only if it stands.
        let is_upright = stands(axis) || mean.dot(axis.direction().unwrap_or_default()) > UPRIGHT;
        // A figure that crawls does not stand along the up axis of its rest pose. If that axis is unusual, the rest
        // pose and the motion probably have different up axes.
        let is_usual = matches!(axis, Axis::Y | Axis::Z);
        let is_contradicted = !is_usual && stands(axis) && Axis::nearest(mean).0 != axis;
        let confidence = match probability {
            _ if is_contradicted => Confidence::Unsure,
            probability if probability > SURE && is_upright => Confidence::Sure,
            probability if probability > LIKELY => Confidence::Likely,
            _ => Confidence::Unsure,
        };
        Some(Guess {
            value: axis,
            confidence,
            reason,
        })
    }

    fn motion_up(&self) -> Option<Motion> {
        self.scene.animations.first()?;
        let feet = self.feet()?;
        let head = self.joint(Bone::Head).or(self.joint(Bone::Neck))?;
        let hips = self.joint(Bone::Hips)?;
        let scale = (self.bone_length()? as f32).recip();
        let sides = [Side::Left, Side::Right].into_iter();
        let mut parts: Vec<usize> = sides
            .flat_map(|side| PARTS.into_iter().filter_map(move |part| self.joint(part.on(side))))
            .collect();
        parts.sort_unstable();
        parts.dedup();
        let mut mean = Vec3::ZERO;
        let mut frames = Vec::new();
        for pose in self.poses() {
            let at = |node: usize| scale * pose.position(NodeId::new(node));
            mean += (at(head) - 0.5 * (at(feet[0]) + at(feet[1]))).normalize_or_zero();
            frames.push((at(hips), parts.iter().map(|part| at(*part)).collect()));
        }
        let mean = mean / frames.len() as f32;
        mean.is_finite().then_some(Motion { mean, frames })
    }
}

/// A few poses of a motion.
struct Motion {
    /// The mean of the directions from the feet to the head.
    mean: Vec3,
    /// The positions of the hips and of all parts, in each pose, as fractions of the figure's size.
    frames: Vec<(Vec3, Vec<Vec3>)>,
}

impl Motion {
    /// The log-likelihood of an axis, up to a constant for all axes. `rest` is the up direction of a standing rest
    /// pose.
    fn score(&self, axis: Axis, rest: Option<Vec3>) -> f32 {
        let up = axis.direction().unwrap_or_default();
        let lowest = |parts: &[Vec3]| parts.iter().map(|part| part.dot(up)).fold(f32::INFINITY, f32::min);
        let mut low: Vec<f32> = self.frames.iter().map(|(_, parts)| lowest(parts)).collect();
        low.sort_unstable_by(f32::total_cmp);
        let at = |fraction: f32| low[((low.len() - 1) as f32 * fraction) as usize];
        let (wander, ground) = (at(0.9) - at(0.1), at(0.5));
        let joints = self.frames.iter().flat_map(|(_, parts)| parts);
        let touches = joints.clone().filter(|part| part.dot(up) - ground < TOUCHES).count();
        let heights = self.frames.iter().map(|(hips, _)| hips.dot(up));
        let above = std::iter::zip(heights.clone(), &self.frames).map(|(hips, (_, parts))| hips - lowest(parts));
        let above = above.sum::<f32>() / self.frames.len() as f32;
        let hips = median(&mut heights.collect::<Vec<_>>()).unwrap_or_default();
        let to_head = self.mean.dot(up);
        let [lies, stands] = LIES_OR_STANDS;
        let standing = ((to_head.abs() - lies) / (stands - lies)).clamp(0.0, 1.0);
        let most_wander = MOST_WANDER[0] + standing * (MOST_WANDER[1] - MOST_WANDER[0]);
        let when = |holds: bool, score: f32| if holds { score } else { 0.0 };
        when(up.y != 0.0, IS_Y)
            + when(up.y + up.z > 0.0, IS_POSITIVE)
            + TO_HEAD * to_head
            + UPSIDE_DOWN * to_head.min(0.0)
            + WANDER * wander.min(most_wander)
            + when(LYING.contains(&ground) && LYING_HIPS.contains(&hips), LIES)
            + REST * rest.map_or(0.0, |rest| rest.dot(up))
            + CONTACT * touches as f32 / joints.count().max(1) as f32
            + HIPS * above
            + when(ground < FAR_BELOW, BELOW)
    }
}
