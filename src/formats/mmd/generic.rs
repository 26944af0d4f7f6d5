//! The bones that nearly all models have, for a motion without its model: the bones of MMD's first models with the
//! usual additions, and generic body proportions.

use glam::{DQuat, DVec3};
use mocap_scene::scene::{HumanoidBone as B, Side};

use super::METRES_PER_UNIT;
use super::model::{Bone, Ik, Inherits, Link, Model};
use super::names::{LEFT, RIGHT};
use crate::proportions;

/// The angle of the arms below the horizontal, in degrees: 35 to 40 in most models.
pub const ARMS: f64 = 37.0;

/// The number of loops of the leg IK, as in MMD's first models.
const LEG_LOOPS: usize = 40;

/// The largest step of the leg IK in radians, as in MMD's first models.
const LEG_STEP: f64 = 2.0;

/// The number of loops of the toe IK, as in MMD's first models.
const TOE_LOOPS: usize = 3;

/// The largest step of the toe IK in radians, as in MMD's first models.
const TOE_STEP: f64 = 4.0;

/// The limits of knees in degrees, as in MMD.
const KNEE: [f64; 2] = [0.5, 180.0];

/// The model name in a motion for no specific model.
pub(super) const NAME: &str = "標準";

/// The position of a bone.
#[derive(Clone, Copy)]
enum BonePlace {
    /// The position of a humanoid bone.
    Bone(B),
    /// The point at a fraction of the way from the first bone to the second bone.
    Between(B, B, f64),
}

use BonePlace::{Between, Bone as Of};

/// Names, parents and positions of the bones in the middle.
#[rustfmt::skip]
const MIDDLE: &[(&str, &str, BonePlace)] = &[
    ("センター", "全ての親", Between(B::LeftFoot, B::Hips, 0.65)),
    ("グルーブ", "センター", Between(B::LeftFoot, B::Hips, 0.67)),
    ("腰", "グルーブ", Of(B::Hips)),
    ("下半身", "腰", Of(B::Spine)),
    ("上半身", "腰", Of(B::Spine)),
    ("上半身2", "上半身", Of(B::UpperChest)),
    ("首", "上半身2", Of(B::Neck)),
    ("頭", "首", Of(B::Head)),
    ("両目", "頭", Between(B::LeftEye, B::LeftEye, 0.0)),
];

/// The bones of a side, without the side's letter. A parent in the middle is stated by its full name.
#[rustfmt::skip]
const SIDE: &[(&str, &str, BonePlace)] = &[
    ("目", "頭", Of(B::LeftEye)),
    ("肩P", "上半身2", Of(B::LeftShoulder)),
    ("肩", "肩P", Of(B::LeftShoulder)),
    ("肩C", "肩", Of(B::LeftUpperArm)),
    ("腕", "肩C", Of(B::LeftUpperArm)),
    ("腕捩", "腕", Between(B::LeftUpperArm, B::LeftLowerArm, 0.6)),
    ("ひじ", "腕捩", Of(B::LeftLowerArm)),
    ("手捩", "ひじ", Between(B::LeftLowerArm, B::LeftHand, 0.6)),
    ("手首", "手捩", Of(B::LeftHand)),
    ("親指０", "手首", Of(B::LeftThumbMetacarpal)),
    ("親指１", "親指０", Of(B::LeftThumbProximal)),
    ("親指２", "親指１", Of(B::LeftThumbDistal)),
    ("人指１", "手首", Of(B::LeftIndexProximal)),
    ("人指２", "人指１", Of(B::LeftIndexIntermediate)),
    ("人指３", "人指２", Of(B::LeftIndexDistal)),
    ("中指１", "手首", Of(B::LeftMiddleProximal)),
    ("中指２", "中指１", Of(B::LeftMiddleIntermediate)),
    ("中指３", "中指２", Of(B::LeftMiddleDistal)),
    ("薬指１", "手首", Of(B::LeftRingProximal)),
    ("薬指２", "薬指１", Of(B::LeftRingIntermediate)),
    ("薬指３", "薬指２", Of(B::LeftRingDistal)),
    ("小指１", "手首", Of(B::LeftLittleProximal)),
    ("小指２", "小指１", Of(B::LeftLittleIntermediate)),
    ("小指３", "小指２", Of(B::LeftLittleDistal)),
    ("足", "下半身", Of(B::LeftUpperLeg)),
    ("ひざ", "足", Of(B::LeftLowerLeg)),
    ("足首", "ひざ", Of(B::LeftFoot)),
    ("つま先", "足首", Of(B::LeftToes)),
    ("足IK親", "全ての親", Between(B::LeftFoot, B::LeftFoot, 0.0)),
    ("足ＩＫ", "足IK親", Of(B::LeftFoot)),
    ("つま先ＩＫ", "足ＩＫ", Of(B::LeftToes)),
];

/// The generic model, with all bones of this module.
pub fn model() -> Model {
    let mut model = Model {
        name: NAME.to_owned(),
        bones: vec![Bone {
            name: "全ての親".to_owned(),
            ..Bone::default()
        }],
        ..Model::default()
    };
    for (name, parent, at) in MIDDLE {
        let position = at.position(Side::Left) * DVec3::new(0.0, 1.0, 1.0);
        let parent = model.find(parent);
        model.bones.push(Bone {
            name: (*name).to_owned(),
            position,
            parent,
            ..Bone::default()
        });
    }
    for (side, letter) in [(Side::Left, LEFT), (Side::Right, RIGHT)] {
        add_side(&mut model, side, letter);
    }
    model
}

fn add_side(model: &mut Model, side: Side, letter: char) {
    let named = |name: &str| format!("{letter}{name}");
    for (name, parent, at) in SIDE {
        let parent = model.find(&named(parent)).or_else(|| model.find(parent));
        model.bones.push(Bone {
            name: named(name),
            position: at.position(side),
            parent,
            ..Bone::default()
        });
    }
    let index = |model: &Model, name: &str| model.find(&named(name)).unwrap_or(0);
    let inherits = |source: usize, ratio: f64| Inherits {
        source,
        ratio,
        rotation: true,
        position: false,
    };
    let (eye, eyes) = (index(model, "目"), model.find("両目").unwrap_or(0));
    model.bones[eye].inherits = Some(inherits(eyes, 1.0));
    // The arm keeps its direction while the whole shoulder rotates.
    let (cancel, whole) = (index(model, "肩C"), index(model, "肩P"));
    model.bones[cancel].inherits = Some(inherits(whole, -1.0));
    let free = |bone: usize| Link { bone, limits: None };
    let knee = KNEE.map(|degrees| degrees.to_radians() * DVec3::X);
    let ik = index(model, "足ＩＫ");
    model.bones[ik].ik = Some(Ik {
        target: index(model, "足首"),
        loops: LEG_LOOPS,
        step: LEG_STEP,
        links: vec![
            Link {
                bone: index(model, "ひざ"),
                limits: Some(knee),
            },
            free(index(model, "足")),
        ],
    });
    let ik = index(model, "つま先ＩＫ");
    model.bones[ik].ik = Some(Ik {
        target: index(model, "つま先"),
        loops: TOE_LOOPS,
        step: TOE_STEP,
        links: vec![free(index(model, "足首"))],
    });
}

impl BonePlace {
    /// The rest position, in units.
    fn position(self, side: Side) -> DVec3 {
        let of = |bone: B| rest(bone.on(side));
        match self {
            Self::Bone(bone) => of(bone),
            Self::Between(from, to, fraction) => of(from).lerp(of(to), fraction),
        }
    }
}

/// The rest position of a humanoid bone with lowered arms, in units.
fn rest(bone: B) -> DVec3 {
    let at = |bone: B| proportions::position(bone).as_dvec3() / METRES_PER_UNIT;
    let Some(side) = bone.side().filter(|_| is_of_arm(bone)) else {
        return at(bone);
    };
    let shoulder = at(B::LeftUpperArm.on(side));
    shoulder + hanging(side) * (at(bone) - shoulder)
}

/// The length of a leg, in units.
pub(super) fn leg() -> f64 {
    let [hip, knee, foot] = [B::LeftUpperLeg, B::LeftLowerLeg, B::LeftFoot].map(rest);
    hip.distance(knee) + knee.distance(foot)
}

/// Whether a bone is the upper arm or a descendant of it.
pub(super) fn is_of_arm(bone: B) -> bool {
    std::iter::successors(Some(bone), |bone| bone.parent()).any(|above| above.on(Side::Left) == B::LeftUpperArm)
}

/// The rotation from the T-pose to lowered arms.
pub(super) fn hanging(side: Side) -> DQuat {
    let sense = if side == Side::Left { -1.0 } else { 1.0 };
    DQuat::from_rotation_z(sense * ARMS.to_radians())
}
