//! Determines the meaning of position channels: positions that replace the OFFSET, displacements that are added to it,
//! or world positions.
//!
//! The format does not state the meaning. The reader decides after all frames are read, from a sample of them.

use glam::Vec3;
use mocap_scene::math::median::median;
use mocap_scene::scene::report::RootOffsetUsed;
use mocap_scene::scene::{Assumption, Confidence, RootOffset, Topic};

use super::hierarchy::Hierarchy;

/// The number of sampled frames of a long take, evenly spaced.
const SAMPLES: usize = 512;

/// The positions of one joint in all frames.
pub(super) struct Positions<'a> {
    pub(super) offset: Vec3,
    /// The axes with a channel.
    pub(super) axes: [bool; 3],
    pub(super) keys: &'a [Vec3],
}

impl Positions<'_> {
    /// Sets the components of a vector to 0 on the axes without a channel.
    fn masked(&self, vector: Vec3) -> Vec3 {
        vector * Vec3::from(self.axes.map(f32::from))
    }

    /// The length of the OFFSET over the axes with a channel.
    fn offset_length(&self) -> f32 {
        self.masked(self.offset).length()
    }

    /// Evenly spaced frames of the motion.
    fn samples(&self) -> impl Iterator<Item = Vec3> + '_ {
        let step = self.keys.len().div_ceil(SAMPLES).max(1);
        self.keys.iter().step_by(step).map(|key| self.masked(*key))
    }

    fn median(&self, measure: impl Fn(Vec3) -> f32) -> f32 {
        let mut values: Vec<f32> = self.samples().map(measure).collect();
        median(&mut values).unwrap_or(0.0)
    }
}

/// How far the lowest joint is below a root in the rest pose. The direction of the root's OFFSET counts as up.
pub(super) fn lowest_at_rest(hierarchy: &Hierarchy, root: usize) -> f32 {
    let upwards = hierarchy.joints[root].offset.normalize_or_zero();
    let mut heights = vec![None; hierarchy.joints.len()];
    heights[root] = Some(0.0_f32);
    for (index, joint) in hierarchy.joints.iter().enumerate() {
        if let Some(above) = joint.parent.and_then(|parent| heights[parent]) {
            heights[index] = Some(above + joint.offset.dot(upwards));
        }
    }
    -heights.into_iter().flatten().fold(0.0, f32::min)
}

/// Whether the position channels of a root replace its OFFSET. `feet` is the distance of the lowest joint below the
/// root at rest.
///
/// In nearly every real file the positions are unrelated to the OFFSET, or equal to it in the first frame. Such
/// positions replace the OFFSET. In a few files the positions are relative to the OFFSET. Positions count as relative
/// if they are near zero in the first frame or in the median of all frames. Positions also count as relative if they
/// stay near zero along an OFFSET that puts the feet on the floor.
pub(super) fn root_offset(root: &Positions<'_>, feet: f32) -> RootOffsetUsed {
    /// The fraction of the OFFSET's length that counts as near zero. The real files whose positions must be added are
    /// below 0.0101, all others above 0.3.
    const NEAR_ZERO: f32 = 0.02;
    /// The fraction of the OFFSET's length that counts as near zero for the height in the median frame. It is larger
    /// than `NEAR_ZERO`, because a walking pelvis rises and sinks.
    const NEAR_FLOOR: f32 = 0.05;

    /// A moving pelvis rarely gets this far along the OFFSET, as a fraction of the OFFSET's length.
    const FAR_ALONG: f32 = 0.5;
    let used = |policy, confidence, reason: String| RootOffsetUsed {
        policy,
        reason,
        confidence,
    };
    let length = root.offset_length();
    if length == 0.0 {
        let reason = "the root's OFFSET is zero".to_owned();
        return used(RootOffset::Replace, Confidence::Sure, reason);
    }
    let offset = root.masked(root.offset);
    let is_near = |value: Vec3| value.abs().max_element() <= NEAR_ZERO * length;
    let first = root.samples().next().unwrap_or_default();
    let median = Vec3::from([0, 1, 2].map(|axis| root.median(|sample| sample[axis])));
    let along = root.median(|sample| sample.dot(offset)) / (length * length);
    // The soles are slightly lower than the last joint.
    let stands = (0.8..=1.1).contains(&(feet / length)) && offset.abs().max_element() >= 0.9 * length;
    let frame = if is_near(first) { "first" } else { "median" };
    if (is_near(first) || is_near(median)) && along.abs() <= FAR_ALONG {
        let reason = format!("the root's position in the {frame} frame is near zero while the OFFSET is not");
        let confidence = if stands && along.abs() <= NEAR_FLOOR {
            Confidence::Sure
        } else {
            Confidence::Likely
        };
        return used(RootOffset::Add, confidence, reason);
    }
    if stands && along.abs() <= NEAR_FLOOR {
        let reason = "the OFFSET puts the feet on the floor, and along the OFFSET the root's position stays near \
                zero"
            .to_owned();
        return used(RootOffset::Add, Confidence::Likely, reason);
    }
    let reason = format!("along the OFFSET, the root's position in the median frame is {along:.2} times the OFFSET");
    let repeats = first.distance(offset) <= NEAR_ZERO * length || (along - 1.0).abs() <= 0.3;
    let confidence = if repeats { Confidence::Sure } else { Confidence::Likely };
    used(RootOffset::Replace, confidence, reason)
}

/// Whether the positions of the joints other than the root are displacements from their OFFSETs, as in MakeHuman's
/// files: near zero in all frames while the OFFSETs are not. As positions, such values would put all joints at one
/// point.
pub(super) fn are_moves(joints: &[Positions<'_>]) -> Option<Assumption> {
    /// The fraction of the OFFSET's length within which a position is a displacement: solver noise.
    const NEAR_ZERO: f32 = 0.05;
    let is_whole = |joint: &&Positions<'_>| joint.axes == [true; 3] && joint.offset_length() > 0.0;
    let with_offset = || joints.iter().filter(is_whole);
    let stays_near = |joint: &&Positions<'_>| {
        let most = NEAR_ZERO * joint.offset_length();
        joint.keys.iter().all(|key| joint.masked(*key).length() <= most)
    };
    let (all, near) = (with_offset().count(), with_offset().filter(stays_near).count());
    (near > 0 && near * 10 >= all * 9).then(|| Assumption {
        topic: Topic::JointPositions,
        choice: "added-to-offset".to_owned(),
        reason: format!(
            "the positions of {near} of {all} joints other than the root are near zero in all frames, but their \
                OFFSETs are not"
        ),
        confidence: Some(Confidence::Likely),
    })
}

/// The joints other than the root whose positions are far beyond the length of their OFFSET in most frames. The result
/// is empty unless at least half of the joints with positions are that far.
pub(super) fn far_from_offset<'a>(
    hierarchy: &Hierarchy,
    positions_of: impl Fn(usize) -> Option<Positions<'a>>,
) -> Option<Vec<usize>> {
    /// The distance of a joint from its parent, as a multiple of the OFFSET's length, above which positions are world
    /// positions.
    const FAR: f32 = 3.0;

    /// The smallest number of joints with world positions. Fewer may be a coincidence.
    const LEAST: usize = 4;
    let is_below_root = |joint: &usize| hierarchy.joints[*joint].parent.is_some();
    let (mut all, mut far) = (0, Vec::new());
    for joint in (0..hierarchy.joints.len()).filter(is_below_root) {
        let Some(positions) = positions_of(joint).filter(|positions| positions.axes == [true; 3]) else {
            continue;
        };
        let length = positions.offset_length();
        if length > 0.0 {
            all += 1;
            if positions.median(Vec3::length) > FAR * length {
                far.push(joint);
            }
        }
    }
    (far.len() >= LEAST && far.len() * 2 >= all).then_some(far)
}

/// Whether the bones to these joints have constant lengths if the positions are world positions.
pub(super) fn are_in_world<'a>(
    hierarchy: &Hierarchy,
    joints: &[usize],
    positions_of: impl Fn(usize) -> Option<Positions<'a>>,
) -> bool {
    /// The largest variation of a constant length over time, as a fraction: the rounding of world positions.
    const SPREAD: f32 = 0.02;

    /// The largest difference between the length of a bone and the length of the OFFSET, as a fraction.
    const OFF: f32 = 0.1;
    let (mut all, mut constant) = (0, 0);
    for &joint in joints {
        let parent = hierarchy.joints[joint].parent.and_then(&positions_of);
        let Some((here, parent)) = positions_of(joint).zip(parent) else {
            continue;
        };
        let is_constant = |lengths: &[f32]| {
            let most = lengths.iter().copied().fold(0.0, f32::max);
            let least = lengths.iter().copied().fold(f32::INFINITY, f32::min);
            most - least <= SPREAD * most
        };
        let bones: Vec<f32> = std::iter::zip(here.samples(), parent.samples())
            .map(|(here, parent)| here.distance(parent))
            .collect();
        let norms: Vec<f32> = here.samples().map(Vec3::length).collect();
        let offset = here.offset_length();
        let is_as_offset = bones.iter().all(|length| (length - offset).abs() <= OFF * offset);
        all += 1;
        constant += usize::from(is_constant(&bones) && (is_as_offset || !is_constant(&norms)));
    }
    constant > 0 && constant * 10 >= all * 9
}
