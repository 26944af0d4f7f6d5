//! The body of a take: a joint set, and a model from the joint centres of some frames.

use glam::{DQuat, DVec3, Vec3};
use mocap_scene::math::median::median_vector;
use mocap_scene::scene::{HumanoidBone as Bone, Side};

use super::calibrate::Frame;
use super::centres::Centres;
use super::landmarks::MarkerSite;
use super::model::{Freedom, Hinge, Joint, Marker, Model, Pose};
use super::take::Take;
use super::weights::MarkerWeights;
use crate::points::Points;
use crate::rest::{Rest, bend_axis, limb_direction};
use crate::set::{JointSet, Lengths, Mark, SetJoint};

/// The joints to which the hands point.
const KNUCKLES: [&str; 2] = ["leftKnuckles", "rightKnuckles"];

/// The expected rotation of a shoulder girdle about the line from neck to shoulder, in radians. Marker positions do not
/// show this rotation. If this rotation were as free as the other ones, arms would not show where their shoulders are.
/// A scapula tips by 30 degrees while an arm rises from the hip to the head (McClure et al., J. Shoulder Elbow Surg.
/// 10, 2001).
const SHOULDER_ROLL: f64 = 0.1;

/// The joints that the landmarks determine, parents first.
pub(super) fn joint_set(name: String, centres: &Centres, take: &Take) -> JointSet {
    let mut set = JointSet {
        name,
        points: Vec::new(),
        joints: Vec::new(),
        marks: Vec::new(),
        lengths: Lengths::Median,
    };
    let mut add = |name: &str, bone: Option<Bone>, parent: Option<usize>| {
        set.joints.push(SetJoint {
            name: name.to_owned(),
            parent,
            bone,
            of: Vec::new(),
        });
        set.joints.len() - 1
    };
    let mut chain = |bones: &[Bone], parent: Option<usize>| {
        let mut parent = parent;
        for bone in bones.iter().filter(|bone| centres.has(**bone)) {
            parent = Some(add(bone.as_str(), Some(*bone), parent));
        }
        parent
    };
    let hips = chain(&[Bone::Hips], None);
    let chest = chain(&[Bone::Spine, Bone::Chest], hips);
    chain(&[Bone::Neck, Bone::Head], chest);
    let mut hands = Vec::new();
    for side in [Side::Left, Side::Right] {
        let arm = [
            Bone::LeftShoulder,
            Bone::LeftUpperArm,
            Bone::LeftLowerArm,
            Bone::LeftHand,
        ]
        .map(|bone| bone.on(side));
        let end = chain(&arm, chest);
        let [left, right] = KNUCKLES;
        let knuckles = if side == Side::Left { left } else { right };
        hands.extend(end.filter(|_| centres.has(arm[3])).map(|hand| (hand, knuckles)));
        let leg = [Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot, Bone::LeftToes];
        chain(&leg.map(|bone| bone.on(side)), hips);
    }
    for (hand, name) in hands {
        let finger = if name == KNUCKLES[0] { "LFIN" } else { "RFIN" };
        if take.has(finger) {
            set.joints.push(SetJoint {
                name: name.to_owned(),
                parent: Some(hand),
                bone: None,
                of: Vec::new(),
            });
        }
    }
    marks(&mut set, take);
    set
}

/// Adds the lines between markers that determine the roll of head, hands and feet.
fn marks(set: &mut JointSet, take: &Take) {
    // A foot's line points to the left: from the left big toe to the left small toe.
    let lines = [
        (Bone::Head, "RFHD", "LFHD"),
        (Bone::LeftHand, "LWRB", "LWRA"),
        (Bone::RightHand, "RWRB", "RWRA"),
        (Bone::LeftFoot, "LTOE", "LMT5"),
        (Bone::RightFoot, "RMT5", "RTOE"),
        (Bone::LeftFoot, "LMT1", "LMT5"),
        (Bone::RightFoot, "RMT5", "RMT1"),
    ];
    for (bone, from, to) in lines {
        if let Some(joint) = set.joint(bone)
            && take.has(from)
            && take.has(to)
            && set.marks.iter().all(|mark| mark.joint != joint)
        {
            set.points.extend([from.to_owned(), to.to_owned()]);
            let count = set.points.len();
            set.marks.push(Mark {
                joint,
                from: count - 2,
                to: count - 1,
            });
        }
    }
}

/// The centres of a set's joints as points. `take` has the frames of `centres`.
pub(super) fn points(set: &JointSet, centres: &[Centres], take: &Take) -> Points {
    let track = |joint: &SetJoint| -> Vec<Vec3> {
        let bone = |frame: usize| {
            let own = centres[frame].joints.iter().find(|(bone, _)| Some(*bone) == joint.bone);
            own.map(|(_, at)| *at)
        };
        let finger = |frame: usize| take.at(if joint.name == KNUCKLES[0] { "LFIN" } else { "RFIN" }, frame);
        let mut before = DVec3::ZERO;
        (0..centres.len())
            .map(|frame| {
                before = joint
                    .bone
                    .map_or_else(|| finger(frame), |_| bone(frame))
                    .unwrap_or(before);
                before.as_vec3()
            })
            .collect()
    };
    let point = |name: &String| -> Vec<Vec3> {
        (0..centres.len())
            .map(|frame| take.at(name, frame).unwrap_or_default().as_vec3())
            .collect()
    };
    Points {
        frames: centres.len(),
        tracks: set.joints.iter().map(track).collect(),
        all: set.points.iter().map(point).collect(),
        pelvis_up: centres.iter().map(|centres| centres.pelvis_up.as_vec3()).collect(),
        warnings: Vec::new(),
    }
}

/// The body with its markers, and the poses of the frames, from a T-pose and world rotations.
pub(super) fn model(
    set: &JointSet,
    rest: &Rest,
    world: &[Vec<glam::Quat>],
    points: &Points,
    take: &Take,
    weights: MarkerWeights,
) -> (Model, Vec<Frame>) {
    let joints: Vec<Joint> = (set.joints.iter().enumerate())
        .map(|(index, joint)| {
            let (freedom, bend) = joint.bone.map_or((Freedom::Fixed, None), |bone| kind(bone, &weights));
            Joint {
                parent: joint.parent,
                offset: rest.offsets[index].as_dvec3(),
                freedom,
                bend,
                usual: DQuat::IDENTITY,
                // The usual roll of a shoulder girdle is not shown either.
                is_shown: !matches!(joint.bone, Some(Bone::LeftShoulder | Bone::RightShoulder)),
                hinge: joint.bone.and_then(hinge),
            }
        })
        .collect();
    let frames = points.frames;
    let turned = |joint: usize, frame: usize| world[joint][frame].as_dquat();
    let mut markers = Vec::new();
    for (landmark, track) in std::iter::zip(&take.landmarks, &take.tracks) {
        let joint = attached(set, landmark.bone);
        let offsets = (0..frames).filter_map(|frame| {
            let own = points.tracks[joint][frame].as_dvec3();
            Some(turned(joint, frame).inverse() * (track[frame]? - own))
        });
        let mut offset = median_vector(offsets);
        if stands_on_axis(&landmark.name, take) {
            // The axes of knees, ankles and elbows are at right angles to +Z of the T-pose. In the T-pose, the centres
            // of the limbs have Z = 0.
            offset.z = 0.0;
        }
        markers.push(Marker {
            joint,
            offset,
            spread: match landmark.on == MarkerSite::Bone {
                true => weights.on_bone,
                false => weights.on_muscle,
            },
        });
    }
    let poses = (0..frames).map(|frame| Frame {
        pose: Pose {
            root: points.tracks[0][frame].as_dvec3(),
            local: (0..joints.len())
                .map(|joint| {
                    let parent = joints[joint]
                        .parent
                        .map_or(DQuat::IDENTITY, |parent| turned(parent, frame));
                    (parent.inverse() * turned(joint, frame)).normalize()
                })
                .collect(),
        },
        seen: take.tracks.iter().map(|track| track[frame]).collect(),
    });
    let poses = poses.collect();
    (Model::new(joints, markers, weights), poses)
}

/// Whether a marker is beside a joint, on its bending axis, and no marker is on the other side. The first centre of
/// such a joint is in front of this axis or behind it, because it lies along the normal of a nearly straight limb.
fn stands_on_axis(landmark: &str, take: &Take) -> bool {
    let Some((side, name)) = landmark.split_at_checked(1) else {
        return false;
    };
    let inner = match name {
        "KNE" => "KNM",
        "ANK" => "ANM",
        "ELB" => "ELM",
        _ => return false,
    };
    !take.has(&format!("{side}{inner}"))
}

/// The joint that moves a landmark of a bone: the joint of the bone, or its nearest ancestor in the set.
fn attached(set: &JointSet, bone: Bone) -> usize {
    let above = std::iter::successors(Some(bone), |bone| bone.parent());
    above.into_iter().find_map(|bone| set.joint(bone)).unwrap_or(0)
}

/// What calibration may change about a joint. Also the expected bend about each axis of the T-pose, in radians, if no
/// marker shows the bend.
fn kind(bone: Bone, weights: &MarkerWeights) -> (Freedom, Option<DVec3>) {
    let (freedom, bend) = match bone.on(Side::Left) {
        Bone::Hips => (Freedom::Fixed, Some(1.0)),
        Bone::LeftUpperLeg => (Freedom::Position(weights.hip), Some(2.0)),
        Bone::LeftLowerLeg => (Freedom::Length, Some(2.0)),
        Bone::LeftFoot => (Freedom::Length, Some(0.8)),
        Bone::LeftToes => (Freedom::Fixed, None),
        Bone::LeftUpperArm => (Freedom::Position(weights.trunk), Some(2.0)),
        Bone::LeftLowerArm => (Freedom::Length, Some(2.0)),
        Bone::LeftHand => (Freedom::Length, Some(0.6)),
        Bone::Neck | Bone::Head => (Freedom::Position(weights.trunk), Some(0.5)),
        _ => (Freedom::Position(weights.trunk), Some(0.3)),
    };
    let mut bend = bend.map(DVec3::splat);
    if let (Bone::LeftShoulder, Some(bend)) = (bone.on(Side::Left), &mut bend) {
        bend.x = SHOULDER_ROLL;
    }
    (freedom, bend)
}

/// The hinge of a knee or elbow, the joint at which a shin or forearm begins.
fn hinge(bone: Bone) -> Option<Hinge> {
    let is_pure = match bone.on(Side::Left) {
        Bone::LeftLowerLeg => true,
        Bone::LeftLowerArm => false,
        _ => return None,
    };
    Some(Hinge {
        axis: bend_axis(bone)?.as_dvec3(),
        along: limb_direction(bone)?.as_dvec3(),
        is_pure,
    })
}
