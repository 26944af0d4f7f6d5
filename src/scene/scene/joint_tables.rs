//! The joints of SMPL, SMPL-H, SMPL-X, SOMA and MHR: names, order, parents and bones. These tables are facts of the
//! formats. The tables contain no body model. A motion file does not state bone lengths; without a body, lengths come
//! from `array_files/proportions.rs` in `mocap-formats`.

mod mhr;

pub use self::mhr::{mhr, mhr70};
use super::{HumanoidBone as Bone, Side};

/// A joint of an array layout.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    pub name: String,
    pub parent: Option<usize>,
    pub bone: Option<Bone>,
}

/// The 22 joints that SMPL, SMPL-H and SMPL-X share.
const BODY: [(&str, usize, Bone); 22] = [
    ("pelvis", 0, Bone::Hips),
    ("left_hip", 0, Bone::LeftUpperLeg),
    ("right_hip", 0, Bone::RightUpperLeg),
    ("spine1", 0, Bone::Spine),
    ("left_knee", 1, Bone::LeftLowerLeg),
    ("right_knee", 2, Bone::RightLowerLeg),
    ("spine2", 3, Bone::Chest),
    ("left_ankle", 4, Bone::LeftFoot),
    ("right_ankle", 5, Bone::RightFoot),
    ("spine3", 6, Bone::UpperChest),
    ("left_foot", 7, Bone::LeftToes),
    ("right_foot", 8, Bone::RightToes),
    ("neck", 9, Bone::Neck),
    ("left_collar", 9, Bone::LeftShoulder),
    ("right_collar", 9, Bone::RightShoulder),
    ("head", 12, Bone::Head),
    ("left_shoulder", 13, Bone::LeftUpperArm),
    ("right_shoulder", 14, Bone::RightUpperArm),
    ("left_elbow", 16, Bone::LeftLowerArm),
    ("right_elbow", 17, Bone::RightLowerArm),
    ("left_wrist", 18, Bone::LeftHand),
    ("right_wrist", 19, Bone::RightHand),
];

/// The joints of a left hand in MANO's order: three of each finger.
const FINGERS: [(&str, [Bone; 3]); 5] = [
    (
        "index",
        [
            Bone::LeftIndexProximal,
            Bone::LeftIndexIntermediate,
            Bone::LeftIndexDistal,
        ],
    ),
    (
        "middle",
        [
            Bone::LeftMiddleProximal,
            Bone::LeftMiddleIntermediate,
            Bone::LeftMiddleDistal,
        ],
    ),
    (
        "pinky",
        [
            Bone::LeftLittleProximal,
            Bone::LeftLittleIntermediate,
            Bone::LeftLittleDistal,
        ],
    ),
    (
        "ring",
        [Bone::LeftRingProximal, Bone::LeftRingIntermediate, Bone::LeftRingDistal],
    ),
    (
        "thumb",
        [
            Bone::LeftThumbMetacarpal,
            Bone::LeftThumbProximal,
            Bone::LeftThumbDistal,
        ],
    ),
];

/// The wrist on each side, the parent of the finger joints.
const WRISTS: [usize; 2] = [20, 21];

/// The head joint, the parent of jaw and eyes.
const HEAD: usize = 15;

fn body() -> Vec<Joint> {
    let joint = |(index, (name, parent, bone)): (usize, &(&str, usize, Bone))| Joint {
        name: (*name).to_owned(),
        parent: (index > 0).then_some(*parent),
        bone: Some(*bone),
    };
    BODY.iter().enumerate().map(joint).collect()
}

fn side_name(side: Side) -> &'static str {
    match side {
        Side::Left => "left",
        Side::Right => "right",
    }
}

fn add_hands(joints: &mut Vec<Joint>) {
    for (side, wrist) in std::iter::zip(Side::ALL, WRISTS) {
        for (finger, bones) in FINGERS {
            for (number, bone) in (1..).zip(bones) {
                let parent = if number == 1 { wrist } else { joints.len() - 1 };
                joints.push(Joint {
                    name: format!("{}_{finger}{number}", side_name(side)),
                    parent: Some(parent),
                    bone: Some(bone.on(side)),
                });
            }
        }
    }
}

/// The joints of the SMPL family. `count` is 22 for the body, 24 for SMPL, 52 for SMPL-H or 55 for SMPL-X.
pub fn smpl(count: usize) -> Option<Vec<Joint>> {
    let mut joints = body();
    match count {
        22 => {}
        24 => joints.extend(std::iter::zip(Side::ALL, WRISTS).map(|(side, wrist)| Joint {
            name: format!("{}_hand", side_name(side)),
            parent: Some(wrist),
            bone: None,
        })),
        52 => add_hands(&mut joints),
        55 => {
            let face = [
                ("jaw", Bone::Jaw),
                ("left_eye_smplhf", Bone::LeftEye),
                ("right_eye_smplhf", Bone::RightEye),
            ];
            joints.extend(face.map(|(name, bone)| Joint {
                name: name.to_owned(),
                parent: Some(HEAD),
                bone: Some(bone),
            }));
            add_hands(&mut joints);
        }
        _ => return None,
    }
    Some(joints)
}

/// A row of SOMA's joints. It has the name of the joint (with `*` for the side), the name of the parent, and the bone
/// of the joint on the left side. The flag states whether the set of 30 joints has the joint.
type Row = (&'static str, &'static str, Option<Bone>, bool);

const SOMA_TRUNK: [Row; 11] = [
    ("Hips", "", Some(Bone::Hips), true),
    ("Spine1", "Hips", Some(Bone::Spine), true),
    ("Spine2", "Spine1", Some(Bone::Chest), true),
    ("Chest", "Spine2", Some(Bone::UpperChest), true),
    ("Neck1", "Chest", Some(Bone::Neck), true),
    ("Neck2", "Neck1", None, true),
    ("Head", "Neck2", Some(Bone::Head), true),
    ("HeadEnd", "Head", None, false),
    ("Jaw", "Head", Some(Bone::Jaw), true),
    ("LeftEye", "Head", Some(Bone::LeftEye), true),
    ("RightEye", "Head", Some(Bone::RightEye), true),
];

const SOMA_ARM: [Row; 28] = [
    ("*Shoulder", "Chest", Some(Bone::LeftShoulder), true),
    ("*Arm", "*Shoulder", Some(Bone::LeftUpperArm), true),
    ("*ForeArm", "*Arm", Some(Bone::LeftLowerArm), true),
    ("*Hand", "*ForeArm", Some(Bone::LeftHand), true),
    ("*HandThumb1", "*Hand", Some(Bone::LeftThumbMetacarpal), false),
    ("*HandThumb2", "*HandThumb1", Some(Bone::LeftThumbProximal), false),
    ("*HandThumb3", "*HandThumb2", Some(Bone::LeftThumbDistal), false),
    ("*HandThumbEnd", "*HandThumb3", None, true),
    ("*HandIndex1", "*Hand", None, false),
    ("*HandIndex2", "*HandIndex1", Some(Bone::LeftIndexProximal), false),
    ("*HandIndex3", "*HandIndex2", Some(Bone::LeftIndexIntermediate), false),
    ("*HandIndex4", "*HandIndex3", Some(Bone::LeftIndexDistal), false),
    ("*HandIndexEnd", "*HandIndex4", None, false),
    ("*HandMiddle1", "*Hand", None, false),
    ("*HandMiddle2", "*HandMiddle1", Some(Bone::LeftMiddleProximal), false),
    (
        "*HandMiddle3",
        "*HandMiddle2",
        Some(Bone::LeftMiddleIntermediate),
        false,
    ),
    ("*HandMiddle4", "*HandMiddle3", Some(Bone::LeftMiddleDistal), false),
    ("*HandMiddleEnd", "*HandMiddle4", None, true),
    ("*HandRing1", "*Hand", None, false),
    ("*HandRing2", "*HandRing1", Some(Bone::LeftRingProximal), false),
    ("*HandRing3", "*HandRing2", Some(Bone::LeftRingIntermediate), false),
    ("*HandRing4", "*HandRing3", Some(Bone::LeftRingDistal), false),
    ("*HandRingEnd", "*HandRing4", None, false),
    ("*HandPinky1", "*Hand", None, false),
    ("*HandPinky2", "*HandPinky1", Some(Bone::LeftLittleProximal), false),
    ("*HandPinky3", "*HandPinky2", Some(Bone::LeftLittleIntermediate), false),
    ("*HandPinky4", "*HandPinky3", Some(Bone::LeftLittleDistal), false),
    ("*HandPinkyEnd", "*HandPinky4", None, false),
];

const SOMA_LEG: [Row; 5] = [
    ("*Leg", "Hips", Some(Bone::LeftUpperLeg), true),
    ("*Shin", "*Leg", Some(Bone::LeftLowerLeg), true),
    ("*Foot", "*Shin", Some(Bone::LeftFoot), true),
    ("*ToeBase", "*Foot", Some(Bone::LeftToes), true),
    ("*ToeEnd", "*ToeBase", None, false),
];

/// The joints of SOMA. `count` is 77 or 30.
pub fn soma(count: usize) -> Option<Vec<Joint>> {
    let has_all = match count {
        77 => true,
        30 => false,
        _ => return None,
    };
    let mut joints: Vec<Joint> = Vec::with_capacity(count);
    let mut add = |rows: &[Row], side: Option<Side>| {
        for (name, parent, bone, is_in_30) in rows.iter().filter(|row| has_all || row.3) {
            let _ = is_in_30;
            let word = match side {
                Some(Side::Right) => "Right",
                _ => "Left",
            };
            let mut parent = parent.replace('*', word);
            // The set of 30 has only the end of each finger, as a child of the hand.
            let index = loop {
                match joints.iter().position(|joint| joint.name == parent) {
                    None if parent.contains("Hand") => parent = format!("{word}Hand"),
                    index => break index,
                }
            };
            joints.push(Joint {
                name: name.replace('*', word),
                parent: index,
                bone: bone.map(|bone| side.map_or(bone, |side| bone.on(side))),
            });
        }
    };
    add(&SOMA_TRUNK, None);
    Side::ALL.into_iter().for_each(|side| add(&SOMA_ARM, Some(side)));
    Side::ALL.into_iter().for_each(|side| add(&SOMA_LEG, Some(side)));
    Some(joints)
}

/// The joints of Unitree's G1 in Kimodo: its motors, two toes and two hands.
pub fn g1() -> Vec<Joint> {
    const LEG: [&str; 7] = [
        "hip_pitch",
        "hip_roll",
        "hip_yaw",
        "knee",
        "ankle_pitch",
        "ankle_roll",
        "toe_base",
    ];
    const WAIST: [&str; 3] = ["waist_yaw", "waist_roll", "waist_pitch"];
    const ARM: [&str; 8] = [
        "shoulder_pitch",
        "shoulder_roll",
        "shoulder_yaw",
        "elbow",
        "wrist_roll",
        "wrist_pitch",
        "wrist_yaw",
        "hand_roll",
    ];
    let mut joints = vec![Joint {
        name: "pelvis_skel".to_owned(),
        parent: None,
        bone: Some(Bone::Hips),
    }];
    let mut chain = |prefix: &str, names: &[&str], mut above: usize, bone: &dyn Fn(&str) -> Option<Bone>| {
        for name in names {
            let ending = if *name == "toe_base" { "" } else { "_skel" };
            joints.push(Joint {
                name: format!("{prefix}{name}{ending}"),
                parent: Some(above),
                bone: bone(name),
            });
            above = joints.len() - 1;
        }
        above
    };
    let leg = |side: Side| {
        move |name: &str| {
            let bone = match name {
                "hip_pitch" => Bone::LeftUpperLeg,
                "knee" => Bone::LeftLowerLeg,
                "ankle_roll" => Bone::LeftFoot,
                "toe_base" => Bone::LeftToes,
                _ => return None,
            };
            Some(bone.on(side))
        }
    };
    let arm = |side: Side| {
        move |name: &str| {
            let bone = match name {
                "shoulder_pitch" => Bone::LeftUpperArm,
                "elbow" => Bone::LeftLowerArm,
                "wrist_yaw" => Bone::LeftHand,
                _ => return None,
            };
            Some(bone.on(side))
        }
    };
    chain("left_", &LEG, 0, &leg(Side::Left));
    chain("right_", &LEG, 0, &leg(Side::Right));
    let chest = chain("", &WAIST, 0, &|name| (name == "waist_yaw").then_some(Bone::Spine));
    chain("left_", &ARM, chest, &arm(Side::Left));
    chain("right_", &ARM, chest, &arm(Side::Right));
    joints
}
