//! Lists the words in joint names, and the body parts that each word can mean.
//!
//! The words come from the names that programs and capture systems write:
//!
//! - modelling programs: MotionBuilder, Mixamo, 3ds Max Biped, Maya, Blender Rigify, Unreal, VRM, MikuMikuDance, Poser,
//!   Daz, MakeHuman, Second Life
//! - capture systems: Biovision, CMU, Acclaim, Xsens, Rokoko, Perception Neuron, mocopi, Kinect, SlimeVR
//! - data sets: SMPL, LAFAN1, SOMA
//!
//! A word can mean several parts: `LeftShoulder` is a collar bone or an upper arm, `LeftLeg` a shin or a thigh. So each
//! part has a weight.

use std::collections::BTreeMap;
use std::sync::LazyLock;

/// A part of the body. A joint with such a name is at the start of the part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    Hips,
    Spine,
    Neck,
    Head,
    Jaw,
    Eye,
    Shoulder,
    UpperArm,
    LowerArm,
    Hand,
    UpperLeg,
    LowerLeg,
    Foot,
    Toes,
    Finger,
}

/// The parts that a word can mean, each with a weight of 0 to 1.
pub type Meaning = &'static [(Part, f32)];

use Part::{
    Eye, Finger, Foot, Hand, Head, Hips, Jaw, LowerArm, LowerLeg, Neck, Shoulder, Spine, Toes, UpperArm, UpperLeg,
};

/// The words of joint names, each with its meaning. They are in lower case. Blanks, numbers, and words for left and
/// right are removed.
const WORDS: &[(Meaning, &[&str])] = &[
    (
        &[(Hips, 1.0)],
        &[
            "hips",
            "pelvis",
            "hipcenter",
            "centerhip",
            "midhip",
            "hipscenter",
            "spinebase",
            "lowerbody",
            "quadril",
            "cadera",
            "caderas",
            "becken",
            "bassin",
            "hanche",
            "下半身",
        ],
    ),
    // Without a side, the word means the hips. With a side, it means the thigh: see `part_of`.
    (&[(Hips, 0.9)], &["hip", "腰"]),
    (
        &[(Hips, 0.4)],
        &["root", "cog", "center", "centre", "センター", "centerofmass"],
    ),
    (&[(Spine, 0.6), (Hips, 0.2)], &["waist"]),
    (
        &[(Spine, 1.0)],
        &[
            "spine",
            "chest",
            "torso",
            "abdomen",
            "back",
            "lowerback",
            "upperback",
            "thorax",
            "upperchest",
            "lowerchest",
            "stomach",
            "belly",
            "trunk",
            "tospine",
            "lumbar",
            "abdomenlower",
            "abdomenupper",
            "chestlower",
            "chestupper",
            "lowerabdomen",
            "upperabdomen",
            "spinelower",
            "spineupper",
            "spinemid",
            "spinechest",
            "spinenavel",
            "lowerspine",
            "midspine",
            "upperspine",
            "spinelow",
            "spinehigh",
            "ribcage",
            "ribs",
            "vertebra",
            "sternum",
            "lowertorso",
            "uppertorso",
            "uppertrunk",
            "lowertrunk",
            "upperbody",
            "midback",
            "backbone",
            "peito",
            "pecho",
            "brust",
            "columna",
            "coluna",
            "torse",
            "buste",
            "上半身",
            "胸",
            "l5",
            "l3",
            "t12",
            "t8",
            "t10",
            "t4",
            "l1",
        ],
    ),
    (
        &[(Spine, 0.7), (Neck, 0.3)],
        &["spineshoulder", "shouldercenter", "centershoulder", "midshoulder"],
    ),
    (
        &[(Neck, 1.0)],
        &[
            "neck",
            "lowerneck",
            "upperneck",
            "necklower",
            "neckupper",
            "neckbase",
            "cervical",
            "pescoço",
            "pescoco",
            "cuello",
            "hals",
            "cou",
            "首",
        ],
    ),
    (
        &[(Head, 1.0)],
        &[
            "head", "skull", "cabeça", "cabeca", "cabeza", "kopf", "tête", "tete", "頭",
        ],
    ),
    (&[(Head, 0.6)], &["face"]),
    (&[(Head, 0.2)], &["hmd", "headset"]),
    (&[(Jaw, 1.0)], &["jaw", "lowerjaw", "jawbone", "あご", "顎"]),
    (&[(Eye, 1.0)], &["eye", "eyeball", "目"]),
    (
        &[(Shoulder, 1.0)],
        &[
            "collar",
            "collarbone",
            "clavicle",
            "clavicula",
            "clav",
            "innershoulder",
            "shoulderinner",
            "肩",
        ],
    ),
    (&[(Shoulder, 0.6)], &["scapula", "shoulderblade", "scap"]),
    (
        &[(Shoulder, 0.9), (UpperArm, 0.9)],
        &["shoulder", "ombro", "hombro", "schulter", "épaule", "epaule"],
    ),
    (
        &[(UpperArm, 1.0)],
        &[
            "upperarm",
            "uparm",
            "humerus",
            "shldr",
            "shldrbend",
            "upperarmbend",
            "armupper",
            "uarm",
            "bicep",
            "arm",
            "oberarm",
            "brazo",
            "braço",
            "braco",
            "bras",
            "腕",
        ],
    ),
    (
        &[(LowerArm, 1.0)],
        &[
            "forearm",
            "lowerarm",
            "lowarm",
            "loarm",
            "elbow",
            "radius",
            "ulna",
            "forearmbend",
            "lowerarmbend",
            "armlower",
            "unterarm",
            "antebrazo",
            "antebraço",
            "antebraco",
            "avantbras",
            "ellbogen",
            "codo",
            "cotovelo",
            "coude",
            "ひじ",
            "肘",
        ],
    ),
    (
        &[(Hand, 1.0)],
        &[
            "hand",
            "wrist",
            "手首",
            "pulso",
            "muñeca",
            "handgelenk",
            "poignet",
            "mão",
            "mao",
            "mano",
        ],
    ),
    (&[(Hand, 0.5)], &["palm", "手", "carpus"]),
    (
        &[(UpperLeg, 1.0)],
        &[
            "upperleg",
            "upleg",
            "thigh",
            "femur",
            "thighbend",
            "legupper",
            "uleg",
            "oberschenkel",
            "muslo",
            "coxa",
            "cuisse",
            "足",
        ],
    ),
    (&[(UpperLeg, 0.2)], &["hipjoint", "pelvisjoint", "buttock"]),
    (&[(LowerLeg, 0.9), (UpperLeg, 0.7)], &["leg"]),
    (
        &[(LowerLeg, 1.0)],
        &[
            "lowerleg",
            "lowleg",
            "loleg",
            "shin",
            "shank",
            "calf",
            "knee",
            "tibia",
            "fibula",
            "foreleg",
            "leglower",
            "shinbend",
            "unterschenkel",
            "knie",
            "rodilla",
            "joelho",
            "genou",
            "ひざ",
            "膝",
        ],
    ),
    (
        &[(Foot, 1.0)],
        &["ankle", "足首", "tornozelo", "tobillo", "cheville", "knöchel", "talus"],
    ),
    (
        &[(Foot, 0.95), (Toes, 0.35)],
        &["foot", "feet", "fuss", "fuß", "pie", "pied", "pé"],
    ),
    (
        &[(Toes, 1.0)],
        &[
            "toe",
            "toes",
            "toebase",
            "ball",
            "football",
            "forefoot",
            "metatarsal",
            "metatarsals",
            "foottoe",
            "toebones",
            "zehe",
            "footthumb",
            "bigtoe",
            "つま先",
        ],
    ),
    (
        &[(Finger, 1.0)],
        &["finger", "fingers", "fingerbase", "handfinger", "指"],
    ),
];

/// Words that mean no part of the body, such as words of rigs, names of programs, and kinds of joints.
pub(crate) const NOISE: &[&str] = &[
    "jnt",
    "joint",
    "jt",
    "bone",
    "bn",
    "b",
    "j",
    "c",
    "m",
    "d",
    "p",
    "sk",
    "skel",
    "skeleton",
    "bip",
    "biped",
    "character",
    "mixamorig",
    "fk",
    "def",
    "org",
    "drv",
    "driver",
    "rig",
    "cc",
    "base",
    "main",
    "human",
    "avatar",
    "bind",
    "valve",
    "hik",
    "f",
    "x",
    "actor",
    "subject",
    "mot",
    "deform",
    "body",
];

/// Words of helper and attached joints, which are not the start of a bone.
pub(crate) const HELPERS: &[&str] = &[
    "twist",
    "roll",
    "split",
    "ik",
    "pole",
    "target",
    "helper",
    "end",
    "nub",
    "tip",
    "top",
    "effector",
    "site",
    "box",
    "dummy",
    "ctrl",
    "control",
    "metacarpal",
    "jiggle",
    "breast",
    "sleeve",
    "pectoral",
    "hair",
    "skirt",
    "tail",
    "ear",
    "tongue",
    "teeth",
    "tooth",
    "lip",
    "lips",
    "cheek",
    "brow",
    "eyebrow",
    "lid",
    "eyelid",
    "lash",
    "nose",
    "nostril",
    "weapon",
    "prop",
    "camera",
    "light",
    "mesh",
    "volume",
    "corrective",
    "muscle",
    "adjust",
    "marker",
    "footsteps",
    "null",
    "locator",
    "aim",
    "lookat",
    "heel",
    "cloth",
    "wing",
    "捩",
    "捻",
    "ik親",
    "髪",
    "スカート",
    "先",
    "wrinkle",
    "attach",
    "socket",
    "slot",
    "handle",
    "holster",
    "bag",
    "cape",
    "belt",
    "hat",
    "virtual",
    "constraint",
    "space",
    "offset",
    "carrying",
];

/// The meaning of a word; empty for a word without a meaning.
pub(crate) fn meaning(word: &str) -> Meaning {
    // Memory checkers report a `HashMap` that lives to the end as a leak.
    static MEANINGS: LazyLock<BTreeMap<&str, Meaning>> = LazyLock::new(|| {
        let rows = WORDS.iter();
        rows.flat_map(|(meaning, words)| words.iter().map(|word| (*word, *meaning)))
            .collect()
    });
    MEANINGS.get(word).copied().unwrap_or_default()
}

/// A part that animals have, and people do not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AnimalPart {
    Tail,
    Wing,
    Beak,
    /// A paw, a hoof, or another word for a limb with paws or hooves. 3ds Max calls the third bone of a hind leg horse
    /// link.
    Paw,
}

impl AnimalPart {
    /// The part that a word names.
    pub(crate) fn of(word: &str) -> Option<Self> {
        match word {
            "tail" | "tailbone" | "しっぽ" | "尻尾" => Some(Self::Tail),
            "wing" | "wings" | "feather" | "feathers" => Some(Self::Wing),
            "beak" => Some(Self::Beak),
            "paw" | "paws" | "hoof" | "hooves" | "fetlock" | "pastern" | "hock" | "horselink" | "hindleg"
            | "hindlegs" | "hindfoot" | "rearleg" | "backleg" | "frontleg" => Some(Self::Paw),
            _ => None,
        }
    }
}

/// A finger, starting with the thumb.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FingerKind {
    Thumb,
    Index,
    Middle,
    Ring,
    Little,
}

/// The words for each finger, at any position in a name.
pub(crate) const FINGERS_WITHIN: &[(FingerKind, &[&str])] = &[
    (FingerKind::Little, &["pinky", "pinkie", "little", "小指"]),
    (
        FingerKind::Thumb,
        &["thumb", "親指", "daumen", "pulgar", "polegar", "pouce"],
    ),
    (
        FingerKind::Index,
        &[
            "index",
            "pointer",
            "人指",
            "人差指",
            "人差し指",
            "forefinger",
            "zeigefinger",
        ],
    ),
    (
        FingerKind::Middle,
        &["middlefinger", "handmiddle", "fmiddle", "中指", "mittelfinger"],
    ),
    (FingerKind::Ring, &["ringfinger", "handring", "fring", "薬指"]),
];

/// The words for each finger that count only as separate words.
pub(crate) const FINGER_WORDS: &[(FingerKind, &[&str])] = &[
    (FingerKind::Middle, &["middle", "mid"]),
    (FingerKind::Ring, &["ring"]),
    (FingerKind::Little, &["small"]),
];
