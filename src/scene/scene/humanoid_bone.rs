//! The bones of the VRM 1.0 humanoid.

use serde::{Deserialize, Serialize};

/// Left or right, from the character's view.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "each says itself")]
pub enum Side {
    Left,
    Right,
}

impl Side {
    /// Both sides.
    pub const ALL: [Self; 2] = [Self::Left, Self::Right];

    /// The other side.
    pub const fn opposite(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
        }
    }
}

macro_rules! humanoid_bones {
    ($($variant:ident $name:literal $parent:literal),* $(,)?) => {
        /// A bone of the VRM 1.0 humanoid. Each bone precedes its descendants.
        ///
        /// The [module](crate::scene) has an example.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[serde(rename_all = "camelCase")]
        #[allow(missing_docs, reason = "each says itself")]
        pub enum HumanoidBone {
            $($variant,)*
        }

        impl HumanoidBone {
            /// All bones; parents precede their children.
            pub const ALL: &[Self] = &[$(Self::$variant,)*];

            /// The name in VRM files, such as `leftUpperArm`.
            pub const fn as_str(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }

            const fn parent_name(self) -> &'static str {
                match self {
                    $(Self::$variant => $parent,)*
                }
            }
        }
    };
}

humanoid_bones! {
    Hips "hips" "",
    Spine "spine" "hips",
    Chest "chest" "spine",
    UpperChest "upperChest" "chest",
    Neck "neck" "upperChest",
    Head "head" "neck",
    LeftEye "leftEye" "head",
    RightEye "rightEye" "head",
    Jaw "jaw" "head",
    LeftUpperLeg "leftUpperLeg" "hips",
    LeftLowerLeg "leftLowerLeg" "leftUpperLeg",
    LeftFoot "leftFoot" "leftLowerLeg",
    LeftToes "leftToes" "leftFoot",
    RightUpperLeg "rightUpperLeg" "hips",
    RightLowerLeg "rightLowerLeg" "rightUpperLeg",
    RightFoot "rightFoot" "rightLowerLeg",
    RightToes "rightToes" "rightFoot",
    LeftShoulder "leftShoulder" "upperChest",
    LeftUpperArm "leftUpperArm" "leftShoulder",
    LeftLowerArm "leftLowerArm" "leftUpperArm",
    LeftHand "leftHand" "leftLowerArm",
    RightShoulder "rightShoulder" "upperChest",
    RightUpperArm "rightUpperArm" "rightShoulder",
    RightLowerArm "rightLowerArm" "rightUpperArm",
    RightHand "rightHand" "rightLowerArm",
    LeftThumbMetacarpal "leftThumbMetacarpal" "leftHand",
    LeftThumbProximal "leftThumbProximal" "leftThumbMetacarpal",
    LeftThumbDistal "leftThumbDistal" "leftThumbProximal",
    LeftIndexProximal "leftIndexProximal" "leftHand",
    LeftIndexIntermediate "leftIndexIntermediate" "leftIndexProximal",
    LeftIndexDistal "leftIndexDistal" "leftIndexIntermediate",
    LeftMiddleProximal "leftMiddleProximal" "leftHand",
    LeftMiddleIntermediate "leftMiddleIntermediate" "leftMiddleProximal",
    LeftMiddleDistal "leftMiddleDistal" "leftMiddleIntermediate",
    LeftRingProximal "leftRingProximal" "leftHand",
    LeftRingIntermediate "leftRingIntermediate" "leftRingProximal",
    LeftRingDistal "leftRingDistal" "leftRingIntermediate",
    LeftLittleProximal "leftLittleProximal" "leftHand",
    LeftLittleIntermediate "leftLittleIntermediate" "leftLittleProximal",
    LeftLittleDistal "leftLittleDistal" "leftLittleIntermediate",
    RightThumbMetacarpal "rightThumbMetacarpal" "rightHand",
    RightThumbProximal "rightThumbProximal" "rightThumbMetacarpal",
    RightThumbDistal "rightThumbDistal" "rightThumbProximal",
    RightIndexProximal "rightIndexProximal" "rightHand",
    RightIndexIntermediate "rightIndexIntermediate" "rightIndexProximal",
    RightIndexDistal "rightIndexDistal" "rightIndexIntermediate",
    RightMiddleProximal "rightMiddleProximal" "rightHand",
    RightMiddleIntermediate "rightMiddleIntermediate" "rightMiddleProximal",
    RightMiddleDistal "rightMiddleDistal" "rightMiddleIntermediate",
    RightRingProximal "rightRingProximal" "rightHand",
    RightRingIntermediate "rightRingIntermediate" "rightRingProximal",
    RightRingDistal "rightRingDistal" "rightRingIntermediate",
    RightLittleProximal "rightLittleProximal" "rightHand",
    RightLittleIntermediate "rightLittleIntermediate" "rightLittleProximal",
    RightLittleDistal "rightLittleDistal" "rightLittleIntermediate",
}

impl HumanoidBone {
    /// The bones that VRM requires of a humanoid.
    pub const REQUIRED: [Self; 15] = [
        Self::Hips,
        Self::Spine,
        Self::Head,
        Self::LeftUpperLeg,
        Self::LeftLowerLeg,
        Self::LeftFoot,
        Self::RightUpperLeg,
        Self::RightLowerLeg,
        Self::RightFoot,
        Self::LeftUpperArm,
        Self::LeftLowerArm,
        Self::LeftHand,
        Self::RightUpperArm,
        Self::RightLowerArm,
        Self::RightHand,
    ];

    /// The bone with this name, in VRM's spelling.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|bone| bone.as_str() == name)
    }

    /// The parent if all bones exist; `None` for the hips.
    pub fn parent(self) -> Option<Self> {
        Self::from_name(self.parent_name())
    }

    /// The side of the bone; `None` for the bones in the middle.
    pub fn side(self) -> Option<Side> {
        if self.as_str().starts_with("left") {
            Some(Side::Left)
        } else if self.as_str().starts_with("right") {
            Some(Side::Right)
        } else {
            None
        }
    }

    /// The same bone on the other side. A bone in the middle is its own mirror image.
    pub fn mirrored(self) -> Self {
        let other = match self.side() {
            Some(Side::Left) => format!("right{}", &self.as_str()["left".len()..]),
            Some(Side::Right) => format!("left{}", &self.as_str()["right".len()..]),
            None => return self,
        };
        Self::from_name(&other).unwrap_or(self)
    }

    /// Whether the bone is a thigh, a shin or a foot.
    #[doc(hidden)]
    pub fn is_of_leg(self) -> bool {
        matches!(
            self.on(Side::Left),
            Self::LeftUpperLeg | Self::LeftLowerLeg | Self::LeftFoot
        )
    }

    /// The same bone on the given side: `LeftHand` and `Side::Right` give `RightHand`.
    #[doc(hidden)]
    pub fn on(self, side: Side) -> Self {
        if self.side() == Some(side.opposite()) {
            self.mirrored()
        } else {
            self
        }
    }

    /// Whether the bone belongs to a finger or a thumb.
    pub fn is_finger(self) -> bool {
        self >= Self::LeftThumbMetacarpal
    }
}
