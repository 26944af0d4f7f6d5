//! Joints that bend farther than those of a body.
//!
//! It is judged by where the joints are, which does not depend on how a skeleton names its axes.

use glam::Vec3;
use mocap_scene::scene::{HumanoidBone as Bone, Side};

use super::{Findings, confidence};
use crate::survey::motion::{Body, Motion};
use crate::survey::spans;
use crate::survey::thresholds::DefectKind::BeyondRange;

/// How far a knee bends at most, in degrees from straight: 140 on the average (Norkin and White, "Measurement of joint
/// motion", 2016), and the most limber.
const KNEE: f32 = 158.0;

/// How far an elbow bends at most, in degrees from straight: 150 on the average, from the same source.
const ELBOW: f32 = 160.0;

/// How far a head bends from the trunk at most, in degrees: the neck has 45 to 60, and the upper trunk some.
const NECK: f32 = 100.0;

/// The sine of the least angle between shin and foot by which the foot tells a direction: 14 degrees.
const FOOT_TELLS: f32 = 0.25;
/// The mean sine of the angle of a knee from which its axis is known.
const BENDS: f32 = 0.05;
/// The shortest time, in seconds.
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
            // A knee bends the shin away from where the toes point, which a foot in line with the shin does not tell.
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

/// About which axis of the thigh a knee bends in the frames in which it bends as knees do. Toes that are pointed seem
/// to be at the other side of the foot, which the axis tells from a knee that bends forwards.
struct Hinge {
    thigh: Option<usize>,
    axis: Option<Vec3>,
}

impl Hinge {
    /// `forwards` is by how many degrees the knee seems to bend forwards in each frame.
    fn new(motion: &Motion, body: &Body, leg: [Bone; 3], forwards: &[f32]) -> Self {
        let thigh = body.bones.get(&leg[0]).copied();
        let mut sum = Vec3::ZERO;
        for frame in (motion.starts..motion.frames).filter(|frame| forwards[*frame] < 0.0) {
            if let (Some(node), Some([upper, lower])) = (thigh, limb(motion, body, frame, leg)) {
                sum += motion.to_world(frame, node).inverse() * upper.cross(lower);
            }
        }
        // A clip in which the knee hardly bends does not tell the axis.
        let bends = sum.length() > BENDS * motion.frames as f32;
        Self {
            thigh,
            axis: bends.then(|| sum.normalize()),
        }
    }

    /// By how many degrees the knee bends the other way; without an axis any amount may be.
    fn backwards(&self, motion: &Motion, frame: usize, upper: Vec3, lower: Vec3) -> f32 {
        let Some((node, axis)) = self.thigh.zip(self.axis) else {
            return f32::INFINITY;
        };
        let bend = motion.to_world(frame, node).inverse() * upper.cross(lower);
        (-bend.dot(axis)).clamp(-1.0, 1.0).asin().to_degrees()
    }
}

/// Where the upper and the lower part of a limb point.
fn limb(motion: &Motion, body: &Body, frame: usize, bones: [Bone; 3]) -> Option<[Vec3; 2]> {
    let [a, b, c] = bones.map(|bone| motion.bone(body, frame, bone));
    let (a, b, c) = (a?, b?, c?);
    Some([(b - a).try_normalize()?, (c - b).try_normalize()?])
}

fn degrees(a: Vec3, b: Vec3) -> f32 {
    a.angle_between(b).to_degrees()
}

/// Adds the spans in which a joint is beyond its range by an angle.
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
