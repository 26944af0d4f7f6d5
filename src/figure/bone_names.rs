//! Lists the names of a humanoid's joints in different programs.
//!
//! - VRM 1.0's humanoid, Mixamo's characters, the skeletons of MHR and SOMA
//! - Unreal's mannequin (`SK_Mannequin`), Godot's `SkeletonProfileHumanoid`, Unity's `HumanBodyBones` (Mecanim)
//! - the BVH files that Bruce Hahne made of the motions of Carnegie Mellon University

use mocap_scene::scene::joint_tables::{Joint, mhr, soma};
use mocap_scene::scene::{HumanoidBone as Bone, Side};
use serde::{Deserialize, Serialize};

use super::humanoid::HumanoidMap;

/// The naming scheme of a program or dataset for the joints of a humanoid.
///
/// ```
/// use mocap::figure::{BoneNames, HumanoidBone};
///
/// let thigh = HumanoidBone::LeftUpperLeg;
/// assert_eq!(BoneNames::Mixamo.name_of(thigh).unwrap(), "mixamorig:LeftUpLeg");
/// assert_eq!(BoneNames::Unreal.name_of(thigh).unwrap(), "thigh_l");
/// assert_eq!(BoneNames::Unreal.name_of(HumanoidBone::Jaw), None); // the mannequin has no jaw
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum BoneNames {
    /// The bones of the VRM 1.0 humanoid, such as `leftUpperLeg`.
    Vrm,
    /// The skeletons of Mixamo, such as `mixamorig:LeftUpLeg`.
    Mixamo,
    /// The mannequin of Unreal Engine, such as `thigh_l`.
    Unreal,
    /// BVH files of the CMU database, such as `LeftUpLeg`, with `LowerBack` as the spine.
    Cmu,
    /// Godot's humanoid profile, such as `LeftUpperLeg`.
    Godot,
    /// Unity's humanoid avatars, such as `LeftUpperLeg`.
    Unity,
    /// The Momentum Human Rig, such as `l_upleg`.
    Mhr,
    /// SOMA, such as `LeftLeg`.
    Soma,
}

/// The prefix of every name of Mixamo.
const MIXAMO_PREFIX: &str = "mixamorig:";

/// Bones in the middle and on the left, and their names in Mixamo, Unreal and CMU. `*` stands for the side, `^` for its
/// first letter. The name is empty for a bone that the skeleton lacks.
const NAMES: [(Bone, [&str; 3]); 31] = [
    (Bone::Hips, ["Hips", "pelvis", "Hips"]),
    (Bone::Spine, ["Spine", "spine_01", "LowerBack"]),
    (Bone::Chest, ["Spine1", "spine_02", "Spine"]),
    (Bone::UpperChest, ["Spine2", "spine_03", "Spine1"]),
    (Bone::Neck, ["Neck", "neck_01", "Neck"]),
    (Bone::Head, ["Head", "head", "Head"]),
    (Bone::LeftEye, ["*Eye", "", ""]),
    (Bone::Jaw, ["", "", ""]),
    (Bone::LeftUpperLeg, ["*UpLeg", "thigh_*", "*UpLeg"]),
    (Bone::LeftLowerLeg, ["*Leg", "calf_*", "*Leg"]),
    (Bone::LeftFoot, ["*Foot", "foot_*", "*Foot"]),
    (Bone::LeftToes, ["*ToeBase", "ball_*", "*ToeBase"]),
    (Bone::LeftShoulder, ["*Shoulder", "clavicle_*", "*Shoulder"]),
    (Bone::LeftUpperArm, ["*Arm", "upperarm_*", "*Arm"]),
    (Bone::LeftLowerArm, ["*ForeArm", "lowerarm_*", "*ForeArm"]),
    (Bone::LeftHand, ["*Hand", "hand_*", "*Hand"]),
    (Bone::LeftThumbMetacarpal, ["*HandThumb1", "thumb_01_*", "^Thumb"]),
    (Bone::LeftThumbProximal, ["*HandThumb2", "thumb_02_*", ""]),
    (Bone::LeftThumbDistal, ["*HandThumb3", "thumb_03_*", ""]),
    (Bone::LeftIndexProximal, ["*HandIndex1", "index_01_*", "*HandIndex1"]),
    (Bone::LeftIndexIntermediate, ["*HandIndex2", "index_02_*", ""]),
    (Bone::LeftIndexDistal, ["*HandIndex3", "index_03_*", ""]),
    (Bone::LeftMiddleProximal, ["*HandMiddle1", "middle_01_*", ""]),
    (Bone::LeftMiddleIntermediate, ["*HandMiddle2", "middle_02_*", ""]),
    (Bone::LeftMiddleDistal, ["*HandMiddle3", "middle_03_*", ""]),
    (Bone::LeftRingProximal, ["*HandRing1", "ring_01_*", ""]),
    (Bone::LeftRingIntermediate, ["*HandRing2", "ring_02_*", ""]),
    (Bone::LeftRingDistal, ["*HandRing3", "ring_03_*", ""]),
    (Bone::LeftLittleProximal, ["*HandPinky1", "pinky_01_*", ""]),
    (Bone::LeftLittleIntermediate, ["*HandPinky2", "pinky_02_*", ""]),
    (Bone::LeftLittleDistal, ["*HandPinky3", "pinky_03_*", ""]),
];

/// The number of joints of SOMA's full set.
const SOMA_JOINTS: usize = 77;

fn capitalized(name: &str) -> String {
    let mut name = name.to_owned();
    if let Some(first) = name.get_mut(..1) {
        first.make_ascii_uppercase();
    }
    name
}

/// The name of a bone's joint.
fn name_in(joints: Vec<Joint>, bone: Bone) -> Option<String> {
    let mut joints = joints.into_iter();
    joints.find(|joint| joint.bone == Some(bone)).map(|joint| joint.name)
}

impl BoneNames {
    /// All naming schemes.
    pub const ALL: [Self; 8] = [
        Self::Vrm,
        Self::Mixamo,
        Self::Unreal,
        Self::Cmu,
        Self::Godot,
        Self::Unity,
        Self::Mhr,
        Self::Soma,
    ];

    /// The name of the scheme, as a user types it.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Vrm => "vrm",
            Self::Mixamo => "mixamo",
            Self::Unreal => "unreal",
            Self::Cmu => "cmu",
            Self::Godot => "godot",
            Self::Unity => "unity",
            Self::Mhr => "mhr",
            Self::Soma => "soma",
        }
    }

    /// The naming scheme with this name; `None` if there is none.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|names| names.as_str() == name)
    }

    /// The name of a bone in this scheme; `None` if its skeletons lack the bone.
    pub fn name_of(self, bone: Bone) -> Option<String> {
        let column = match self {
            Self::Vrm => return Some(bone.as_str().to_owned()),
            Self::Godot => return Some(capitalized(bone.as_str())),
            // Unity numbers the joints of a thumb like the joints of a finger.
            Self::Unity => {
                let name = capitalized(bone.as_str());
                let name = name.replace("ThumbProximal", "ThumbIntermediate");
                return Some(name.replace("ThumbMetacarpal", "ThumbProximal"));
            }
            Self::Mhr => return name_in(mhr(), bone),
            Self::Soma => return name_in(soma(SOMA_JOINTS).unwrap_or_default(), bone),
            Self::Mixamo => 0,
            Self::Unreal => 1,
            Self::Cmu => 2,
        };
        let (_, names) = NAMES.iter().find(|(named, _)| *named == bone.on(Side::Left))?;
        let (word, letter) = match (bone.side(), self) {
            (Some(Side::Left), Self::Unreal) => ("l", "l"),
            (Some(Side::Right), Self::Unreal) => ("r", "r"),
            (Some(Side::Left), _) => ("Left", "L"),
            (Some(Side::Right), _) => ("Right", "R"),
            (None, _) => ("", ""),
        };
        let prefix = if self == Self::Mixamo { MIXAMO_PREFIX } else { "" };
        let name = names[column].replace('*', word).replace('^', letter);
        (!name.is_empty()).then(|| format!("{prefix}{name}"))
    }

    /// The name of every bone in this scheme.
    pub fn names(self) -> HumanoidMap {
        let named = Bone::ALL.iter().map(|bone| (*bone, self.name_of(*bone)));
        named.filter(|(_, name)| name.is_some()).collect()
    }
}
