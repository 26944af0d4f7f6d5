//! Infers the up axis from the rest pose, a few poses of the motion, and the frequency of each up axis in files.

use glam::Vec3;
use mocap_scene::math::median::median;
use mocap_scene::scene::{HumanoidBone as Bone, NodeId, Side};

use super::Confidence;
use super::axis::Axis;
use super::measure::Measures;
use mocap_scene::scene::report::Guess;

/// The axes that may point up.
const AXES: [Axis; 4] = [Axis::Y, Axis::Z, Axis::NegY, Axis::NegZ];

/// The scores of an axis, as natural logarithms of likelihoods. The weights are near those of a logistic regression
/// over 261 clips of 25 makers and 150 made motions: crawls, lies, handstands, sit-ups, walks. Each clip is rotated to
/// all axes, and weighted by the frequency of the up axis in files.
///
/// Y and -Y: more than nine of ten BVH files are Y up.
const IS_Y: f32 = 2.1;

/// Y and Z, against -Y and -Z: a difference of scores.
const IS_POSITIVE: f32 = 3.5;

/// The cosine of the angle to the mean direction from the feet to the head.
const TO_HEAD: f32 = 3.0;

/// The same cosine if it is negative: nobody stands on the head all the time.
const UPSIDE_DOWN: f32 = 2.5;

/// The vertical movement of the lowest joint, in lengths of the figure: a body on the ground stays on it.
const WANDER: f32 = -6.9;

/// The most of that which counts, as fractions of the figure: of a body that lies along the ground, and of one that
/// stands. Who jumps goes up and down too, and nobody climbs while lying.
const MOST_WANDER: [f32; 2] = [1.5, 0.6];

/// The cosines of the angle to the mean direction from the feet to the head up to which a body lies, and from which on
/// it stands.
const LIES_OR_STANDS: [f32; 2] = [0.3, 0.6];

/// A body that lies on a floor at height 0.
const LIES: f32 = 5.3;

/// The cosine of the angle to the trunk of a rest pose that stands.
const REST: f32 = 7.7;

/// The fraction of joints at the height of the lowest joint: joints on the ground lie in one plane.
const CONTACT: f32 = 4.5;

/// The height of the hips above the lowest joint, as a fraction of the figure.
const HIPS: f32 = 6.4;

/// The score of a ground far below 0, where the origin would be in the air.
const BELOW: f32 = -2.5;

/// The largest height above the lowest joint of a joint in contact, as a fraction of the figure.
const TOUCHES: f32 = 0.06;

/// The height below which a ground is far below 0, as a fraction of the figure.
const FAR_BELOW: f32 = -0.2;

/// Heights of the lowest joint of a body that lies on a floor at height 0, as fractions of the figure: joints are in
/// the middle of a lying limb.
const LYING: std::ops::RangeInclusive<f32> = -0.03..=0.07;

/// Heights of its hips, as fractions of the figure, which are above it. A body that stands above the origin has its
/// hips at 0, and joints behind it.
const LYING_HIPS: std::ops::RangeInclusive<f32> = 0.02..=0.2;

/// The probability of an axis, a fraction, above which it is sure: one of a hundred may be wrong.
const SURE: f32 = 0.99;
/// Likewise likely: no motion at all leaves Y a fraction of 0.87.
const LIKELY: f32 = 0.9;

/// The cosine of the largest angle between up and the mean direction from the feet to the head of a body that stands.
const UPRIGHT: f32 = 0.9;

/// The joints whose heights are examined, on the left: no fingers, and no joints inside the body.
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
                reason: "the rest pose stands along it".to_owned(),
            });
        };
        let scores = AXES.map(|axis| motion.score(axis, rest));
        let best = scores.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let axis = AXES.into_iter().zip(scores).find(|(_, score)| *score == best)?.0;
        let probability = scores.iter().map(|score| (score - best).exp()).sum::<f32>().recip();
        let mean = motion.mean;
        let words = format!(
            "from the feet to the head it is {:.2} {:.2} {:.2} of the distance",
            mean.x, mean.y, mean.z
        );
        let reason = match (stands(axis), Axis::nearest(mean).0 == axis) {
            (true, true) => format!("{words}, and the rest pose stands along it"),
            (true, false) => format!("the rest pose stands along it; in motion {words}"),
            (false, true) => words,
            (false, false) => format!("the body is on the ground ({words})"),
        };
        // Only a standing body is certain.
        let is_upright = stands(axis) || mean.dot(axis.direction().unwrap_or_default()) > UPRIGHT;
        let confidence = match probability {
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

/// A few poses.
struct Motion {
    /// The mean of the directions from the feet to the head.
    mean: Vec3,
    /// The hips and all parts, as fractions of the figure.
    frames: Vec<(Vec3, Vec<Vec3>)>,
}

impl Motion {
    /// The log-likelihood of an axis, up to a constant for all axes. `rest` is the up direction of a standing rest
    /// pose.
    fn score(&self, axis: Axis, rest: Option<Vec3>) -> f32 {
        let up = axis.direction().unwrap_or_default();
        let lowest = |parts: &[Vec3]| parts.iter().map(|part| part.dot(up)).fold(f32::INFINITY, f32::min);
        let mut low: Vec<f32> = self.frames.iter().map(|(_, parts)| lowest(parts)).collect();
        low.sort_by(f32::total_cmp);
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
