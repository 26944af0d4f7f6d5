//! Joint centres and axes of the legs as Plug-in Gait defines them, if the file states the measures of the person.
//!
//! Plug-in Gait computes the hip centre from the leg length (Davis et al., Hum. Mov. Sci. 10, 1991). Knee and ankle are
//! half a joint width beside their markers, in the plane of the upper joint, the marker and the wand of the segment. So
//! the wands, not the motion, determine the axes. `mocap angles` compares the angles with the outputs in such a file.

use glam::{DMat3, DQuat, DVec3};
use mocap_scene::scene::{Assumption, Confidence, HumanoidBone as Bone, Scene, Side, Topic};

use super::centres::{self, sided, sign};
use super::model::Model;
use super::take::Take;
use super::track::TrackingOutcome;
use crate::set::JointSet;

/// The marker diameter in metres, if the file states none: the markers that Vicon delivers with Plug-in Gait.
const DIAMETER: f64 = 0.014;

/// The distance C in the hip centre by Davis et al.: a factor of the leg length, plus a length in metres.
const HIP: (f64, f64) = (0.115, -0.0153);

/// The angles in radians of C in the frontal and in the sagittal plane (Davis et al.).
const HIP_ANGLES: (f64, f64) = (0.5, 0.314);

/// The distance from front spine to trochanter if the file states none: a factor of the leg length, plus a length in
/// metres (Davis et al.).
const TROCHANTER: (f64, f64) = (0.1288, -0.04856);

/// The largest offset angle of a wand, in radians, that counts as none. The signs of offset angles are not documented,
/// so files with larger angles keep the axes from the motion.
const NO_OFFSET: f64 = 1e-4;

/// The measures of a leg in metres.
struct Measures {
    to_trochanter: f64,
    /// The distance from the marker beside the knee to the knee's centre; `ankle` is the same for the ankle.
    knee: f64,
    ankle: f64,
    /// The angle from the line between toe marker and ankle up to the sole, in radians.
    sole: f64,
}

/// The measures of a person in metres.
pub(super) struct Calibration {
    leg: f64,
    spines: f64,
    radius: f64,
    sides: [Measures; 2],
}

/// The joint centres and the rotations of a leg in a frame.
struct Leg {
    hip: DVec3,
    knee: DVec3,
    ankle: DVec3,
    thigh: DQuat,
    shank: DQuat,
    foot: DQuat,
    toe: DVec3,
}

impl Calibration {
    /// `None` if the file does not state all measures, or the take lacks markers of Plug-in Gait.
    pub(super) fn of(scene: &Scene, take: &Take) -> Option<Self> {
        let measures = &scene.metadata.recorded.as_deref()?.measures;
        let stated = |name: &str| measures.iter().find(|(own, _)| own == name).map(|(_, value)| *value);
        let length = |name: &str| {
            stated(name)
                .map(|value| value * take.metres)
                .filter(|length| *length > 0.0)
        };
        let legs = [Side::Left, Side::Right].map(|side| length(&sided(side, "LegLength")));
        let leg = 0.5 * (legs[0]? + legs[1]?);
        let radius = 0.5 * length("MarkerDiameter").unwrap_or(DIAMETER);
        let of_side = |side: Side| {
            let own = |name: &str| sided(side, name);
            let has_all = ["THI", "KNE", "TIB", "ANK", "TOE"]
                .iter()
                .all(|name| take.has(&own(name)));
            let offsets = ["ThighRotation", "ShankRotation", "TibialTorsion"];
            let has_offset = |name: &&str| stated(&own(name)).is_some_and(|angle| angle.abs() > NO_OFFSET);
            if !has_all || offsets.iter().any(has_offset) {
                return None;
            }
            let from_leg = TROCHANTER.0 * leg + TROCHANTER.1;
            Some(Measures {
                to_trochanter: length(&own("AsisTrocanterDistance")).unwrap_or(from_leg),
                knee: 0.5 * length(&own("KneeWidth"))? + radius,
                ankle: 0.5 * length(&own("AnkleWidth"))? + radius,
                sole: stated(&own("StaticPlantFlex"))?,
            })
        };
        Some(Self {
            leg,
            spines: length("InterAsisDistance")?,
            radius,
            sides: [of_side(Side::Left)?, of_side(Side::Right)?],
        })
    }

    /// The hip centre relative to the midpoint of the front spines, in the axes of the pelvis: left, up and forward.
    fn hip(&self, side: Side) -> DVec3 {
        let ((sin, cos), (sin_side, cos_side)) = (HIP_ANGLES.0.sin_cos(), HIP_ANGLES.1.sin_cos());
        let distance = HIP.0 * self.leg + HIP.1;
        let depth = self.sides[usize::from(side == Side::Right)].to_trochanter + self.radius;
        DVec3::new(
            sign(side) * (0.5 * self.spines - distance * sin),
            -distance * cos * cos_side - depth * sin_side,
            distance * cos * sin_side - depth * cos_side,
        )
    }

    /// The pelvis and the legs from the markers of a frame.
    fn legs(&self, at: &impl Fn(&str) -> Option<DVec3>) -> Option<(DQuat, [Leg; 2])> {
        let pelvis = centres::pelvis_axes(at)?;
        let front = at("LASI")?.midpoint(at("RASI")?);
        let leg = |side: Side| {
            let own = |name: &str| at(&sided(side, name));
            let measures = &self.sides[usize::from(side == Side::Right)];
            let hip = front + pelvis * self.hip(side);
            let knee = chord(hip, own("KNE")?, own("THI")?, measures.knee)?;
            let ankle = chord(knee, own("ANK")?, own("TIB")?, measures.ankle)?;
            let shank = axes(knee, ankle, own("ANK")?, side)?;
            let toe = own("TOE")?;
            Some(Leg {
                thigh: axes(hip, knee, own("KNE")?, side)?,
                foot: foot(toe - ankle, shank * DVec3::X)? * DQuat::from_rotation_x(-measures.sole),
                toe,
                shank,
                hip,
                knee,
                ankle,
            })
        };
        Some((pelvis, [leg(Side::Left)?, leg(Side::Right)?]))
    }

    /// Replaces the joint centres and the axes of pelvis and legs of a tracked take.
    pub(super) fn redefine(
        &self,
        scene: &mut Scene,
        take: &Take,
        set: &JointSet,
        model: &mut Model,
        tracked: &mut TrackingOutcome,
    ) {
        let joints_of = |side: Side| {
            let joint = |bone: Bone| set.joint(bone.on(side));
            Some([
                joint(Bone::LeftUpperLeg)?,
                joint(Bone::LeftLowerLeg)?,
                joint(Bone::LeftFoot)?,
                joint(Bone::LeftToes)?,
            ])
        };
        let (Some(left), Some(right)) = (joints_of(Side::Left), joints_of(Side::Right)) else {
            return;
        };
        // Sums of the offsets from the hips, and of the lengths of thighs and shanks.
        let mut offsets = vec![DVec3::ZERO; model.joints.len()];
        let mut lengths = [[0.0; 2]; 2];
        let mut frames = 0.0;
        let mut positions = vec![DVec3::ZERO; model.joints.len()];
        for frame in 0..take.frames {
            for (joint, own) in model.joints.iter().enumerate() {
                positions[joint] = own.parent.map_or(tracked.roots[frame], |parent| {
                    positions[parent] + tracked.rotations[parent][frame] * own.offset
                });
            }
            let at = |name: &str| {
                let marker = take.index(name)?;
                let own = &model.markers[marker];
                let expected = positions[own.joint] + tracked.rotations[own.joint][frame] * own.offset;
                let seen = take.tracks[marker][frame];
                Some(
                    seen.filter(|seen| seen.distance(expected) < model.weights.outlier)
                        .unwrap_or(expected),
                )
            };
            let Some((pelvis, legs)) = self.legs(&at) else { continue };
            let root = legs[0].hip.midpoint(legs[1].hip);
            positions[left[0]] = legs[0].hip;
            positions[right[0]] = legs[1].hip;
            for (joint, _) in model.joints.iter().enumerate().filter(|(_, own)| own.parent == Some(0)) {
                offsets[joint] += pelvis.inverse() * (positions[joint] - root);
            }
            tracked.roots[frame] = root;
            tracked.rotations[0][frame] = pelvis;
            for ((joints, leg), lengths) in [left, right].iter().zip(&legs).zip(&mut lengths) {
                tracked.rotations[joints[0]][frame] = leg.thigh;
                tracked.rotations[joints[1]][frame] = leg.shank;
                tracked.rotations[joints[2]][frame] = leg.foot;
                offsets[joints[3]] += leg.foot.inverse() * (leg.toe - leg.ankle);
                lengths[0] += leg.hip.distance(leg.knee);
                lengths[1] += leg.knee.distance(leg.ankle);
            }
            frames += 1.0;
        }
        if frames == 0.0 {
            return;
        }
        for (own, sum) in std::iter::zip(&mut model.joints, &offsets).filter(|(own, _)| own.parent == Some(0)) {
            own.offset = *sum / frames;
        }
        for (joints, lengths) in [left, right].iter().zip(lengths) {
            model.joints[joints[3]].offset = offsets[joints[3]] / frames;
            for (joint, length) in joints[1..3].iter().zip(lengths) {
                let own = &mut model.joints[*joint];
                own.offset = own.offset.normalize_or_zero() * (length / frames);
            }
        }
        scene.metadata.assumptions.push(Assumption {
            topic: Topic::Markers,
            choice: "Plug-in Gait defines the joint centres and axes of the legs".to_owned(),
            reason: "the file states leg lengths and joint widths".to_owned(),
            confidence: Some(Confidence::Sure),
        });
    }
}

/// The joint centre by the chord function of Plug-in Gait: at a distance from the marker `beside` it, on the side away
/// from `wand`. It is in the plane of `above`, the marker and the wand, and has a right angle between the first two.
fn chord(above: DVec3, beside: DVec3, wand: DVec3, distance: f64) -> Option<DVec3> {
    let up = above - beside;
    let length = up.length();
    let along = up.try_normalize()?;
    let outward = (wand - beside).reject_from(along).try_normalize()?;
    let part = distance * distance / length;
    let across = (distance * distance - part * part).max(0.0).sqrt();
    (length > distance).then(|| beside + along * part - outward * across)
}

/// The rotation of a foot to the world: forward along the foot, and left as near as possible to the left of the shank.
fn foot(along: DVec3, left: DVec3) -> Option<DQuat> {
    let forward = along.try_normalize()?;
    let left = left.reject_from(forward).try_normalize()?;
    Some(DQuat::from_mat3(&DMat3::from_cols(left, forward.cross(left), forward)).normalize())
}

/// The rotation of a segment to the world: up along the bone, and left toward the marker of the left side.
fn axes(above: DVec3, below: DVec3, beside: DVec3, side: Side) -> Option<DQuat> {
    let up = (above - below).try_normalize()?;
    let left = ((beside - below) * sign(side)).reject_from(up).try_normalize()?;
    Some(DQuat::from_mat3(&DMat3::from_cols(left, up, left.cross(up))).normalize())
}
