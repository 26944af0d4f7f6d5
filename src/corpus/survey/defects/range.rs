//! Joints that bend beyond the human range.
//!
//! The angles are computed from the positions of the joints, because the local axes of joints differ between skeletons.

use glam::Vec3;
use mocap_scene::scene::{HumanoidBone as Bone, Side};

use super::{Findings, confidence};
use crate::survey::motion::{Body, Motion};
use crate::survey::spans;
use crate::survey::thresholds::DefectKind::BeyondRange;

/// The largest flexion of a knee, in degrees. The average is 140 (Norkin and White, "Measurement of joint motion",
/// 2016); this limit includes the most flexible people.
const KNEE: f32 = 158.0;

/// The largest flexion of an elbow, in degrees. The average is 150 (Norkin and White).
const ELBOW: f32 = 160.0;

/// The largest angle between head and trunk, in degrees. The neck bends by 45 to 60 degrees, and the upper trunk adds
/// some.
const NECK: f32 = 100.0;

/// The sine of the least angle between shin and foot at which the foot shows the forward direction: 14 degrees.
const FOOT_TELLS: f32 = 0.25;
/// The least mean sine of the knee angle at which the hinge axis of the knee is known.
const BENDS: f32 = 0.05;
/// The shortest time beyond the range that counts as a defect, in seconds.
const SHORTEST: f64 = 0.05;

pub(super) fn find(motion: &Motion, body: &Body, findings: &mut Findings<'_>) {
    findings.look_for(&[BeyondRange]);
    for side in Side::ALL {
        let on = |bone: Bone| bone.on(side);
        let leg = [Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot].map(on);
        let points = body.contacts.points.iter();
        let toes = points
            .filter(|point| point.bone == on(Bone::LeftToes))
            .map(|point| point.node.index())
            .next();
        let forwards = |frame: usize| {
            let [thigh, shin] = limb(motion, body, frame, leg)?;
            let toes = motion.at(frame, toes?) - motion.bone(body, frame, leg[2])?;
            // The shin bends away from the direction of the toes. If the foot is in line with the shin, the direction
            // of the toes is unknown.
            let forward = toes.try_normalize()?.reject_from_normalized(shin);
            let forward = (forward.length() > FOOT_TELLS).then(|| forward.normalize())?;
            let along = shin.reject_from_normalized(thigh).dot(forward);
            Some(along.clamp(-1.0, 1.0).asin().to_degrees())
        };
        let angles: Vec<f32> = (0..motion.frames).map(|frame| forwards(frame).unwrap_or(0.0)).collect();
        let hinge = Hinge::new(motion, body, leg, &angles);
        let knee = |frame: usize| {
            let [thigh, shin] = limb(motion, body, frame, leg)?;
            let folded = degrees(thigh, shin) - KNEE;
            Some(folded.max(hinge.backwards(motion, frame, thigh, shin).min(angles[frame])))
        };
        add(motion, body, leg[1], findings, knee);
        let arm = [Bone::LeftUpperArm, Bone::LeftLowerArm, Bone::LeftHand].map(on);
        let elbow = |frame: usize| {
            let [upper, lower] = limb(motion, body, frame, arm)?;
            Some(degrees(upper, lower) - ELBOW)
        };
        add(motion, body, arm[1], findings, elbow);
    }
    let neck = |frame: usize| {
        let head = motion.bone(body, frame, Bone::Head)? - motion.bone(body, frame, Bone::Neck)?;
        Some(degrees(body.trunk(motion, frame), head.try_normalize()?) - NECK)
    };
    add(motion, body, Bone::Neck, findings, neck);
}

/// The hinge axis of a knee relative to the thigh, from the frames in which the knee bends backwards. Pointed toes can
/// make a normal knee look as if it bends forwards. The axis distinguishes the two cases.
struct Hinge {
    thigh: Option<usize>,
    axis: Option<Vec3>,
}

impl Hinge {
    /// `forwards` has the angle by which the knee seems to bend forwards in each frame, in degrees.
    fn new(motion: &Motion, body: &Body, leg: [Bone; 3], forwards: &[f32]) -> Self {
        let thigh = body.bones.get(&leg[0]).copied();
        let mut sum = Vec3::ZERO;
        for frame in (motion.starts..motion.frames).filter(|frame| forwards[*frame] < 0.0) {
            if let (Some(node), Some([upper, lower])) = (thigh, limb(motion, body, frame, leg)) {
                sum += motion.to_world(frame, node).inverse() * upper.cross(lower);
            }
        }
        // If the knee hardly bends in the clip, the axis is unknown.
        let bends = sum.length() > BENDS * motion.frames as f32;
        Self {
            thigh,
            axis: bends.then(|| sum.normalize()),
        }
    }

    /// The angle by which the knee bends forwards around its axis, in degrees. If the axis is unknown, the angle is
    /// infinite.
    fn backwards(&self, motion: &Motion, frame: usize, upper: Vec3, lower: Vec3) -> f32 {
        let Some((node, axis)) = self.thigh.zip(self.axis) else {
            return f32::INFINITY;
        };
        let bend = motion.to_world(frame, node).inverse() * upper.cross(lower);
        (-bend.dot(axis)).clamp(-1.0, 1.0).asin().to_degrees()
    }
}

/// The directions of the upper and the lower part of a limb.
fn limb(motion: &Motion, body: &Body, frame: usize, bones: [Bone; 3]) -> Option<[Vec3; 2]> {
    let [a, b, c] = bones.map(|bone| motion.bone(body, frame, bone));
    let (a, b, c) = (a?, b?, c?);
    Some([(b - a).try_normalize()?, (c - b).try_normalize()?])
}

fn degrees(a: Vec3, b: Vec3) -> f32 {
    a.angle_between(b).to_degrees()
}

/// Adds the spans in which a joint exceeds its range. `beyond` returns the excess in degrees.
fn add(motion: &Motion, body: &Body, bone: Bone, findings: &mut Findings<'_>, beyond: impl Fn(usize) -> Option<f32>) {
    let Some(node) = body.bones.get(&bone) else { return };
    let angles: Vec<f32> = (0..motion.frames).map(|frame| beyond(frame).unwrap_or(0.0)).collect();
    for [from, to] in spans(motion.frames, |frame| frame >= motion.starts && angles[frame] > 5.0) {
        if to + 1 - from >= motion.frames_in(SHORTEST) {
            let most = angles[from..=to].iter().copied().fold(0.0, f32::max);
            findings.add(
                BeyondRange,
                [from, to],
                Some(&motion.names[*node]),
                most,
                confidence(most, 20.0),
            );
        }
    }
}
