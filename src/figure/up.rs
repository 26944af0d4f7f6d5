//! The axis that points up, from the rest pose and from a few poses of the motion.

use glam::Vec3;
use mocap_scene::math::median::median;
use mocap_scene::scene::{HumanoidBone as Bone, NodeId};

use super::Confidence;
use super::axis::Axis;
use super::measure::Measures;
use mocap_scene::scene::report::Guess;

/// Heights of the lowest joint of a body that lies on a floor at height 0, as fractions of the figure: joints are in
/// the middle of a lying limb.
const LYING: std::ops::RangeInclusive<f32> = -0.03..=0.06;

/// Heights of its hips, as fractions of the figure, which are above it. A body that stands above the origin has its
/// hips at 0, and joints behind it.
const LYING_HIPS: std::ops::RangeInclusive<f32> = 0.02..=0.2;

impl Measures<'_> {
    /// The axis that points up.
    pub(super) fn up(&self) -> Option<Guess<Axis>> {
        let guess = |value, confidence, reason: String| {
            Some(Guess {
                value,
                confidence,
                reason,
            })
        };
        let rest = self.rest_up().map(Axis::nearest).filter(|(_, cosine)| *cosine > 0.8);
        let Some(motion) = self.motion_up() else {
            return match rest {
                Some((axis, _)) => guess(axis, Confidence::Likely, "the rest pose stands along it".to_owned()),
                None => None,
            };
        };
        let direction = motion.mean;
        let words = format!(
            "from the feet to the head it is {:.2} {:.2} {:.2} of the distance",
            direction.x, direction.y, direction.z
        );
        let (axis, cosine) = Axis::nearest(direction);
        let is_vertical = !matches!(axis, Axis::X | Axis::NegX);
        let is_clear = direction.length() > 0.85 && cosine > 0.9 && is_vertical && motion.extended > 0.75;
        match rest {
            Some((rest, _)) if rest == axis && cosine > 0.7 => guess(
                axis,
                Confidence::Sure,
                format!("{words}, and the rest pose stands along it"),
            ),
            Some((rest, _)) if is_clear && motion.frames > 1 => {
                // Standing feet come back to one height along the up axis; a lying body lies near 0 along the other.
                let (of_motion, of_rest) = (motion.floor(axis), motion.floor(rest));
                if of_rest.abs() < 0.06 && of_motion.abs() > 0.1 {
                    let reason = format!("the rest pose stands along it, and the body lies on the floor ({words})");
                    guess(rest, Confidence::Likely, reason)
                } else {
                    let reason = format!("{words}, although the rest pose stands along {}", rest.as_str());
                    guess(axis, Confidence::Likely, reason)
                }
            }
            Some((rest, _)) => guess(
                rest,
                Confidence::Likely,
                format!("the rest pose stands along it; in motion {words}"),
            ),
            // The hands of a handstand are on the floor.
            None if matches!(axis, Axis::NegY | Axis::NegZ)
                && motion.floor(axis.opposite()).abs() < 0.06
                && motion.floor(axis).abs() > 0.1 =>
            {
                let reason = format!("the body stands on its head on the floor ({words})");
                guess(axis.opposite(), Confidence::Likely, reason)
            }
            // A figure that stands has its feet on the floor; one that lies has all of it there.
            None if is_clear && motion.floor(axis).abs() < 0.15 => {
                let reason = format!("{words}, and the feet are on a floor below");
                guess(axis, Confidence::Sure, reason)
            }
            None if is_clear => {
                let other = if matches!(axis, Axis::Z | Axis::NegZ) {
                    Axis::Y
                } else {
                    Axis::Z
                };
                let lies = LYING.contains(&motion.floor(other)) && LYING_HIPS.contains(&motion.hips(other));
                // One who stands may be there by chance, and is not all the time.
                if lies && motion.wander(other) < motion.wander(axis) {
                    guess(
                        other,
                        Confidence::Likely,
                        format!("the body lies on the floor ({words})"),
                    )
                } else {
                    guess(axis, Confidence::Likely, words)
                }
            }
            None if is_vertical && cosine > 0.7 => guess(axis, Confidence::Likely, words),
            None => {
                // What is left of a path along X is noise.
                let is_z = direction.z.abs() > direction.y.abs() && direction.z.abs() > 0.3 * direction.length();
                let axis = if is_z { Axis::Z } else { Axis::Y };
                guess(axis, Confidence::Unsure, words)
            }
        }
    }

    fn motion_up(&self) -> Option<Motion> {
        self.scene.animations.first()?;
        let feet = self.feet()?;
        let head = self.joint(Bone::Head).or(self.joint(Bone::Neck))?;
        let length = self.bone_length()? as f32;
        let poses = self.poses();
        let mut motion = Motion {
            mean: Vec3::ZERO,
            extended: 0.0,
            lowest: Vec::new(),
            highest: Vec::new(),
            hips: Vec::new(),
            length,
            frames: self.scene.animations[0].frame_count(),
        };
        let weight = 1.0 / poses.len() as f32;
        for pose in poses {
            let at = |node: usize| pose.position(NodeId::new(node));
            let direction = at(head) - 0.5 * (at(feet[0]) + at(feet[1]));
            motion.mean += weight * direction.normalize_or_zero();
            motion.extended += weight * direction.length() / length;
            let positions = || self.humanoid.bones.values().map(|joint| pose.position(joint.joint));
            motion.lowest.extend(positions().reduce(Vec3::min));
            motion.highest.extend(positions().reduce(Vec3::max));
            motion.hips.extend(self.joint(Bone::Hips).map(at));
        }
        motion.mean.is_finite().then_some(motion)
    }
}

/// Measurements of a few poses.
struct Motion {
    /// The mean of the directions from the feet to the head.
    mean: Vec3,
    /// The distance from the feet to the head, as a fraction of the length of bone.
    extended: f32,
    lowest: Vec<Vec3>,
    highest: Vec<Vec3>,
    hips: Vec<Vec3>,
    length: f32,
    frames: usize,
}

impl Motion {
    /// The height of the lowest joint along an axis, in the median, as a fraction of the figure.
    fn floor(&self, axis: Axis) -> f32 {
        self.median(std::iter::zip(&self.lowest, &self.highest), axis)
    }

    /// How far the lowest joint goes up and down an axis, as a fraction of the figure: what stands or lies on a floor
    /// does so along the other axes.
    fn wander(&self, axis: Axis) -> f32 {
        let mut heights = Self::heights(std::iter::zip(&self.lowest, &self.highest), axis);
        heights.sort_by(f32::total_cmp);
        let at = |fraction: f32| heights.get(((heights.len() as f32 - 1.0) * fraction) as usize);
        at(0.9)
            .zip(at(0.1))
            .map_or(0.0, |(high, low)| (high - low) / self.length)
    }

    /// Likewise of the hips.
    fn hips(&self, axis: Axis) -> f32 {
        self.median(self.hips.iter().map(|hips| (hips, hips)), axis)
    }

    /// The median along an axis of points; each is given by its least and its largest coordinates.
    fn median<'a>(&self, points: impl Iterator<Item = (&'a Vec3, &'a Vec3)>, axis: Axis) -> f32 {
        median(&mut Self::heights(points, axis)).map_or(0.0, |height| height / self.length)
    }

    fn heights<'a>(points: impl Iterator<Item = (&'a Vec3, &'a Vec3)>, axis: Axis) -> Vec<f32> {
        points
            .map(|(low, high)| match axis {
                Axis::X => low.x,
                Axis::Y => low.y,
                Axis::Z | Axis::Unknown => low.z,
                Axis::NegX => -high.x,
                Axis::NegY => -high.y,
                Axis::NegZ => -high.z,
            })
            .collect()
    }
}
